# SPDX-License-Identifier: BSD-3-Clause
# The documents that are made from the table of keys are what the program prints, and the JSON schema
# agrees with the program on which job files are right.
for pair in docs/job.md:--markdown jobs/job.schema.json:--schema jobs/studies/study.schema.json:--study-schema; do
    file=${pair%%:*} option=${pair##*:}
    "$SEGCAST" help keys "$option" | diff "$SOURCE/$file" - >&2 ||
        fail "$file differs from the table of keys: segcast help keys $option >$file"
done
"$SEGCAST" help keys render.q | grep -q '^render.quality$' || fail "keys PREFIX"
"$SEGCAST" help keys render.s | grep -q '^light' && fail "keys PREFIX lists other keys"
lines=$("$SEGCAST" help keys | tee all.txt | wc -l)
[ "$lines" -le 200 ] || fail "help keys prints $lines lines, more than four screens of 50"
[ "$(wc -L <all.txt)" -le 120 ] || fail "help keys has lines of more than 120 characters"
"$SEGCAST" help keys --json | jq -e '[.[] | select(.key == "output.size")][0] |
    .default == "[1280, 720]" and .option == "size" and .environment == "SEGCAST_OUTPUT_SIZE"' \
    >/dev/null || fail "keys --json"
expect 64 'no key is "rendr"' "$SEGCAST" help keys rendr; one_error
for job in "$SOURCE"/jobs/*.yaml; do
    head -1 "$job" | grep -qx '# yaml-language-server: $schema=job.schema.json' ||
        fail "$job does not name its schema"
done
for study in "$SOURCE"/jobs/studies/*.yaml; do
    head -1 "$study" | grep -qx '# yaml-language-server: $schema=study.schema.json' ||
        fail "$study does not name its schema"
done

# Every key that is in the default job, set to its own default, changes nothing.
small_job plain.yaml
"$SEGCAST" still plain.yaml -o plain.png -q >/dev/null
keys=0
while read -r key value; do
    case $key in *.N.* | *.NAME.* | color_by.* | compare.* | cine.* | image.* | volume | volume.*) continue ;; esac # they are in no default job
    settings+=(--set "$key=$value")
    keys=$((keys + 1))
done < <("$SEGCAST" help keys --json | jq -r '.[] | select(.default) | "\(.key) \(.default)"' |
    grep -vE '^(output\.(directory|size|video)|animation\.(frames|camera\.(fixed|orbit)|slices))')
[ "$keys" -gt 30 ] || fail "only $keys keys have a default"
"$SEGCAST" still plain.yaml -o set.png -q "${settings[@]}" >/dev/null
"$IMAGE_DIFFERENCE" plain.png set.png || fail "defaults that are given change the picture"

find_python 'jsonschema, yaml' 'python3-jsonschema python3-yaml'

# validate FILE...: by a JSON schema validator of another project; prints the files that the schema refuses
"$SEGCAST" help keys --schema >schema.json
cat >validate.py <<'PY'
import json, sys, jsonschema, yaml
schema = json.load(open(sys.argv[1]))
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
for name in sys.argv[2:]:
    errors = list(validator.iter_errors(yaml.safe_load(open(name))))
    if errors:
        print(name, "refused:", errors[0].message[:100])
PY
validate() { "$python" validate.py schema.json "$@"; }
refused=$(validate "$SOURCE"/jobs/*.yaml)
[ -z "$refused" ] || fail "$refused"
"$SEGCAST" help keys --study-schema >study.schema.json
refused=$("$python" validate.py study.schema.json "$SOURCE"/jobs/studies/*.yaml)
[ -z "$refused" ] || fail "$refused"
# jobs NAME TEXT: write each line of standard input, behind TEXT, to a file NAME-N.yaml.
jobs() {
    local n=10 line
    while IFS= read -r line; do n=$((n + 1)) && printf '%b\n%b\n' "$2" "$line" >"$1-$n.yaml"; done
}
jobs study 'title: wrong' <<'WRONG'
swep: {ranks: [1, 2]}
least: many
measure: frame
precision: 2 mm
budget: []
sweep: 3
WRONG
"$python" validate.py study.schema.json study-*.yaml >refused.txt
for study in study-*.yaml; do
    grep -q "^$study " refused.txt || fail "the schema of studies accepts: $(cat $study)"
    expect 65 "$study:2" "$SEGCAST" study $study -o wrong
done

# What the schema has to refuse, the program refuses, too.
jobs wrong 'volume: phantom:59x41x61' <<'WRONG'
outptu: {fps: 25}
output: {fps: "fast"}
output: {fps: 1000}
output: {size: [640]}
output: {frames: jpg}
render: {quality: 5}
render: {background: rde}
output: {size: 1080q}
animation: {frames: 3 hours}
animation: {clip: [{normal: left, at: 12}]}
render: {surface: smoth}
light: {shadows: maybe}
tissues: {aorta: {colour: [1, 2, 3]}}
tissues: {aorta: {opacity: atuo}}
animation: {clip: [{at: 0%}]}
animation: {clip: [{except: [aorta]}]}
animation: {clip: [{normal: left, at_point: [1, 2, 3]}]}
animation: {camera: {fixed: {up: superior}}}
animation: {camera: {orbit: {}, fixed: {position_mm: [0, 0, 0], target_mm: [1, 0, 0]}}}
animation: {camera: {orbit: {strat: 1}}}
animation: {slices: 200}
farm: {tile: [8]}
WRONG
validate wrong-*.yaml >refused.txt
for job in wrong-*.yaml; do
    grep -q "^$job " refused.txt || fail "the schema accepts: $(cat $job)"
    expect 65 "$job:" "$SEGCAST" check $job
done

# What the program accepts in odd but right jobs, the schema accepts.
jobs right 'volume: phantom:59x41x61' <<'RIGHT'
output: {size: 640x480}
render: {background: "#102030"}
render: {background: red}
output: {size: 1080p}
animation: {frames: 2 s}
animation: {camera: {zoom: 2}}
animation: {camera: {zoom: {10%: 1, 20%: 2, ease: smooth}}}
animation: {camera: {orbit: {axis: [0, 1, 1], target_mm: [1, 2, 3]}}}
animation: {clip: [{normal: left, at: 12 mm}, {box: [[0%, 5%, 1 mm], [100%, 100%, 90%]], except: [aorta]}]}
tissues: {"*": {opacity: auto, visible: true}, aorta: {color: [1, 2, 3], roughness: 0.5}}
RIGHT
refused=$(validate right-*.yaml)
[ -z "$refused" ] || fail "the schema refuses: $refused"
for job in right-*.yaml; do expect 0 '' "$SEGCAST" check $job; done
