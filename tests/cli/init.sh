# SPDX-License-Identifier: BSD-3-Clause
# segcast init writes a job that names every tissue, that check accepts and that draws what it should.
export HOME=/home/someone
"$SEGCAST" convert phantom:59x41x61 -o heart.nrrd -q >/dev/null

# Every label has a line, by name, with number, volume and thickness as `info` measures them.
[ "$("$SEGCAST" init heart.nrrd -q)" = heart.yaml ] || fail "the path of the job was not printed"
"$SEGCAST" info heart.nrrd --json -q >info.json 2>/dev/null
jq -r '.labels[1:][] | "\(.name)\t\(.value)\t\(.volume_mm3)\t\(.thickness_mm)"' info.json >labels.txt
[ "$(wc -l <labels.txt)" = 20 ] || fail "the phantom has $(wc -l <labels.txt) labels"
while IFS=$'\t' read -r name value mm3 thickness; do
    line=$(grep "^  \"$name\": " heart.yaml) || fail "no line for $name"
    want=$(awk -v v="$mm3" -v t="$thickness" 'BEGIN {printf "%.3g ml, %.3g mm thick", v / 1000, t}')
    [[ $line == *"}  # color: \"#"??????"\", label $value, $want" ]] || fail "$name: \"$line\", expected label $value, $want"
done <labels.txt
"$SEGCAST" check heart.yaml >/dev/null 2>check.txt || { cat check.txt; fail "check refuses what init has written"; }
[ ! -s check.txt ] || { cat check.txt; fail "check warns of what init has written"; }
"$SEGCAST" still heart.yaml --set output.size=64x48 -o heart.png -q >/dev/null

# A file is never replaced, also not with the option that replaces files elsewhere.
sum=$(cksum heart.yaml)
expect 73 'heart.yaml' "$SEGCAST" init heart.nrrd; one_error
expect 64 'has no option --overwrite' "$SEGCAST" init heart.nrrd --overwrite; one_error
[ "$sum" = "$(cksum heart.yaml)" ] || fail "an existing job was changed"

# A job in another folder finds its volume and table; - is standard output.
mkdir sub
printf '1 heart_muscle 200 80 70 255\n2 heart_muscle 1 2 3 255\n3 7 1 2 3 255\n4 left_[*] 1 2 3 255\n5 "quoted"\\name 1 2 3 128\n' >table.ctbl
"$SEGCAST" init heart.nrrd --labels table.ctbl -o sub/job.yaml -q >/dev/null 2>&1
grep -q "^volume: \"$PWD/heart.nrrd\"" sub/job.yaml || fail "the volume of sub/job.yaml"
for line in '  1: .*# color: "#c85046", "heart muscle", label 1,' '  3: .*, "7", label 3,' '  4: .*, "left \[\*\]", label 4,' \
    '  "\\"quoted\\"\\\\name": *{opacity: 0.502}  # color: "#010203", label 5'; do
    grep -q "^$line" sub/job.yaml || { cat sub/job.yaml >&2; fail "no line $line"; }
done
expect 0 '' "$SEGCAST" check sub/job.yaml
"$SEGCAST" init heart.nrrd -o - -q | diff <(sed '/^#   /d' heart.yaml) - >&2 || fail "-o - differs from the file"
[ ! -e ./- ] || fail "a file named - was written"

# The colours are comments, so that the appearance wins, also where a table has others; init keeps the word.
"$SEGCAST" init heart.nrrd --labels table.ctbl --appearance distinct -o distinct.yaml -q >/dev/null 2>&1
grep -q '^appearance: distinct$' distinct.yaml || fail "init has not kept --appearance"
for job in sub/job.yaml distinct.yaml; do
    "$SEGCAST" still $job --size 64x48 -o table.png --appearance table --overwrite -q >/dev/null 2>&1
    "$SEGCAST" still $job --size 64x48 -o distinct.png --appearance distinct --overwrite -q >/dev/null 2>&1
    ! cmp -s table.png distinct.png || fail "$job: --appearance changes nothing"
done
"$SEGCAST" still distinct.yaml --size 64x48 -o kept.png --overwrite -q >/dev/null 2>&1
cmp kept.png distinct.png || fail "distinct.yaml has not the colours that init was asked for"
expect 64 'unknown appearance "tabel"; did you mean "table"' "$SEGCAST" still heart.nrrd --appearance tabel -o bad.png; one_error

# A name that YAML or a terminal would misread stands in the job so that they do not.
"$SEGCAST" init heart.nrrd -o $'two\nlines.yaml' -q >/dev/null
expect 0 '' "$SEGCAST" check $'two\nlines.yaml'
cp heart.nrrd $'a "b" \\ #c.nrrd'
"$SEGCAST" init $'a "b" \\ #c.nrrd' -q -o quoted.yaml >/dev/null
expect 0 '' "$SEGCAST" check quoted.yaml

# Names that no directory, video or shell takes are changed to such that do; what no YAML can hold is refused
# before the volume is measured.
long=$(printf 'x%.0s' $(seq 150))
"$SEGCAST" convert phantom:20x14x21 -o small.nrrd -q >/dev/null
while read -r name job; do
    sampled || continue
    name=$(printf '%b' "$name")
    cp small.nrrd "./$name"
    [ "$("$SEGCAST" init "./$name" -q)" = "$job" ] || fail "init of \"$name\" wrote $(ls ./*.yaml), expected $job"
    expect 0 '' "$SEGCAST" check "$job"
    [ ! -s stderr.txt ] || { cat stderr.txt >&2; fail "check warns of what init has written for \"$name\""; }
    rm -f "./$name" "$job"
done <<NAMES
~x.nrrd x.yaml
.hid.nrrd hid.yaml
-dash.nrrd dash.yaml
\$HOME.nrrd _HOME.yaml
.nrrd nrrd.yaml
~.nrrd volume.yaml
a\\tb.nrrd a_b.yaml
a\\0302\\0205b.nrrd a_b.yaml
a\\0342\\0200\\0250b.nrrd a_b.yaml
a\\0342\\0200\\0256b.nrrd a_b.yaml
$long.nrrd ${long:0:135}.yaml
\\0303\\0251$long.nrrd $(printf '\303\251')${long:0:133}.yaml
NAMES
cp heart.nrrd $'a\xffb.nrrd'
expect 64 'byte 2 of this path is not UTF-8, so that no job file can hold it; rename' "$SEGCAST" init $'a\xffb.nrrd'; one_error
[ ! -e $'a\xffb.yaml' ] || fail "a job was written that is not UTF-8"
rm -f $'a\xffb.nrrd'

# Tissues that enclose the others come first: the outermost nearly transparent, the next hidden.
cat >nested.py <<'PY'
import struct, sys
n = 24
def label(x, y, z):
    r = max(abs(x - 11.5), abs(y - 11.5), abs(z - 11.5))
    return 3 if r > 10 else 9 if r > 8 else (1 if z > 11 else 2) if r < 6 else 0
open("nested.nrrd", "wb").write(
    ("NRRD0004\ntype: uint8\ndimension: 3\nsizes: %d %d %d\nspacings: 1 1 1\nencoding: raw\n\n" % (n, n, n)).encode()
    + bytes(label(x, y, z) for z in range(n) for y in range(n) for x in range(n)))
PY
command -v python3 >/dev/null || skip "no Python to make a nested volume with"
python3 nested.py
"$SEGCAST" init nested.nrrd -q >/dev/null 2>&1
sed -n '/^tissues/,/^$/p' nested.yaml | cut -d, -f1 | cut -d} -f1 | tr -d '{' >looks.txt
diff - looks.txt >&2 <<'LOOKS' || fail "covers are not found"
tissues:
  # Around the others
  3:  opacity: 0.12
  9:  visible: false
  # Other tissues
  1:  opacity: 1
  2:  opacity: 1

LOOKS
