# SPDX-License-Identifier: BSD-3-Clause
# Several volumes in one picture: several ranks, and a run that was continued, make the same film; other volumes are another
# job, and none of them is overwritten. property.films draws frames alone, stills and the resolved job of such films.
"$SEGCAST" convert phantom:40x28x41 -o other.nrrd -q >/dev/null
# A volume with a tissue of its own, at another place in space, and with its own label table
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 20 20 20\n'
    printf 'space directions: (4,0,0) (0,4,0) (0,0,4)\nspace origin: (500,-300,70)\nencoding: raw\n\n'
    for z in $(seq 20); do
        head -c 400 /dev/zero | tr '\000' "\\$(printf %03o $((z > 4 && z < 16 ? 1 + z % 2 : 0)))"
    done
} >stripes.nrrd
printf '1 aorta 10 200 10 255\n2 stripe 200 10 200 255\n' >stripes.ctbl
cat >side.yaml <<'YAML'
volume: phantom:59x41x61
output: {directory: out, size: [160, 90], video: film.mp4, fps: 10}
tissues: {"*": {opacity: 0.6}, stripe: {opacity: 1}}
compare:
  with: [other.nrrd, {volume: stripes.nrrd, labels: stripes.ctbl, name: "Stripes\nof labels"}]
overlays: {names: [aorta, stripe], legend: top-right, scale_bar: top-left, caption: Three}
animation:
  frames: 12
  camera: {orbit: {elevation: 10}, projection: orthographic}
  clip: [{normal: posterior, at: {0%: 0%, 100%: 40%}, except: [stripe]}]
  verbs: [{fade: [stripe, aorta], to: 0, during: [50%, 90%]}, {frame: stripe, during: [0%, 40%]}]
YAML
cat >divider.yaml <<'YAML'
volume: phantom:59x41x61
output: {directory: out, size: [90, 120], video: film.mp4, fps: 10}
render: {background: none}
compare: {name: before, with: [{volume: stripes.nrrd, name: after, labels: stripes.ctbl}], divider: {20%: 100%, 80%: 0%, ease: smooth}}
overlays: {names: all}
animation: {frames: 8}
YAML
sed -i 's/film.mp4/film.webm/' divider.yaml

for name in side divider; do
    "$SEGCAST" render $name.yaml -o $name -q --set output.frames=png >/dev/null
    frames=$(hashes $name | wc -l)
    [ "$(hashes $name | cut -d' ' -f2 | sort -u | wc -l)" = "$frames" ] || fail "$name: frames repeat"
    OMP_NUM_THREADS=2 mpi 3 "$SEGCAST" render $name.yaml -o $name.three -q --set farm.partition=tiles --set farm.tile=48 --cpu c >/dev/null
    [ "$(hashes $name)" = "$(hashes $name.three)" ] && cmp $name/film.* $name.three/film.* || fail "$name: three ranks make another film"
    "$SEGCAST" render $name.yaml -o $name.parts -q --frames 3-5 >/dev/null
    mpi 2 "$SEGCAST" render $name.yaml -o $name.parts -q --resume >/dev/null
    [ "$(hashes $name.parts | uniq)" = "$(hashes $name)" ] && cmp $name/film.* $name.parts/film.* ||
        fail "$name: a film that was continued differs"
    "$SEGCAST" verify $name.parts >/dev/null || fail "$name: the film is not verified"
    "$SEGCAST" still $name.yaml -o $name.png -q --sheet 3 >/dev/null || fail "$name: a sheet"
    "$SEGCAST" plan $name.yaml --json >$name.json 2>/dev/null || fail "$name: plan"
done

# From prepared files, the same pictures; the one that is moved to the middle, too
"$SEGCAST" convert stripes.nrrd --labels stripes.ctbl -o stripes.segc -q >/dev/null
sed 's/stripes\.nrrd, name: after, labels: stripes.ctbl/stripes.segc, name: after/' divider.yaml >prepared.yaml
mpi 2 "$SEGCAST" render prepared.yaml -o prepared -q >/dev/null
[ "$(hashes divider)" = "$(hashes prepared)" ] || fail "a prepared file gives other pictures"

# A volume that lies elsewhere, by multiples of 16 voxels, as the cells of borders lie at fixed places, is brought to the
# first one, and stays there with align: none. A tissue looks as in the
# first volume that has it, whatever other label tables say; one that only one volume has, as its own says.
sed 's/(500,-300,70)/(-76,20,134)/' stripes.nrrd >moved.nrrd
sed 's/10 200 10 255/200 200 10 255/' stripes.ctbl >yellow.ctbl
still() { # still FILE COMPARISON: a picture of volumes side by side
    printf 'volume: phantom:59x41x61\noutput: {size: [120, 80]}\ntissues: {"*": {opacity: 1}}\ncompare: {name: a, %s}\n' "$2" >still.yaml
    "$SEGCAST" still still.yaml -o "$1" -q >/dev/null
}
still there.png 'with: [{volume: stripes.nrrd, name: b, labels: stripes.ctbl}]'
still moved.png 'with: [{volume: moved.nrrd, name: b, labels: stripes.ctbl}]'
still apart.png 'with: [{volume: moved.nrrd, name: b, labels: stripes.ctbl}], align: none'
still yellow.png 'with: [{volume: stripes.nrrd, name: b, labels: yellow.ctbl}]'
still own.png 'with: [{volume: stripes.nrrd, name: b}]'
"$IMAGE_DIFFERENCE" there.png moved.png 255 0.5 || fail "a volume that lies elsewhere gives another picture"
! "$IMAGE_DIFFERENCE" there.png apart.png 255 0.5 || fail "align: none moves volumes"
"$IMAGE_DIFFERENCE" there.png yellow.png || fail "a tissue looks differently in two volumes"
! "$IMAGE_DIFFERENCE" there.png own.png 255 0.5 || fail "the names of a label table are not used"

# In a picture that is too small for a name its last lines are left out
"$SEGCAST" still side.yaml -o tiny.png -q --set output.size=[72,48] --set overlays={} --set compare.name="A name of many words for so few pixels" >/dev/null ||
    fail "a name that does not fit"

# Names find no room where other things are written over the whole picture: here over the one on the left
cat >names.yaml <<'YAML'
volume: phantom:59x41x61
output: {size: [320, 120]}
compare: {with: other.nrrd}
overlays: {names: [aorta, pulmonary artery], names_size: 8}
animation: {frames: 12, camera: {orbit: {turns: 0.01}}}
YAML
over='overlays.caption={bottom-left: "1\n2\n3\n4", top: "1\n2\n3\n4", bottom: "1\n2\n3\n4"}'
named() { # named COUNT MESSAGE SETTINGS...: for so many volumes the message is told
    local count=$1 message=$2
    shift 2
    [ "$("$SEGCAST" still names.yaml -o names.png --overwrite "$@" 2>&1 | grep -c "$message")" = "$count" ] || fail "names with $*: $message"
}
named 0 'no room\|no frame shows'
named 1 'there is no room for 2 of 2 names' --set overlays.legend=top-left --set "$over"
# Beside a divider there are none of the volume that is not seen
for divider in 0% 100%; do
    named 1 'hidden or behind the divider: aorta, pulmonary artery' --set compare.divider=$divider
done

# Other subjects, or others in their place, are another job; so is where they stand, and the divider
sed 's/other\.nrrd/phantom:40x28x43/' side.yaml >changed.yaml
expect 73 'volume' "$SEGCAST" render changed.yaml -o side --resume -q
expect 73 '' "$SEGCAST" render side.yaml -o side --resume -q --set compare.align=none
expect 73 '' "$SEGCAST" render divider.yaml -o divider --resume -q --set compare.divider=40%
expect 73 '' "$SEGCAST" render side.yaml -o side --resume -q --set compare.name=first
# The memory of all is counted
grep -v '^compare' divider.yaml >alone.yaml
one=$("$SEGCAST" plan alone.yaml --json 2>/dev/null | jq .memory.prepared_bytes)
[ "$(jq .memory.prepared_bytes divider.json)" -gt "$one" ] || fail "plan does not count all volumes"
# No input is overwritten
cp other.nrrd other.png
sed 's/other\.nrrd/other.png/' side.yaml >png.yaml
expect 73 'is an input of this command' "$SEGCAST" still png.yaml -o other.png --overwrite -q
cmp other.nrrd other.png || fail "an input was overwritten"
# What check tells: the size of each, and which tissues one lacks
"$SEGCAST" check side.yaml >out.txt 2>err.txt || fail "check"
grep -q '^  other: 40 x 28 x 41 voxels' out.txt && grep -q 'Stripes' out.txt || fail "check does not tell the sizes"
grep -q '"phantom:59x41x61" lacks tissues that others have: "stripe"' err.txt || fail "check does not tell what is lacking"
# A tissue that no subject has is the mistake that it always is
expect 65 'tissue "stripes" matches no label of the volume; did you mean "stripe"' "$SEGCAST" check side.yaml --set 'tissues={stripes: {opacity: 1}}'
expect 65 'tissue "stripes" matches no label of the volume; did you mean "stripe"' "$SEGCAST" render side.yaml -o never --set 'tissues={stripes: {opacity: 1}}'
