# SPDX-License-Identifier: BSD-3-Clause
# A job merges, keeps and crops: the picture is that of a volume which another program has changed in the same way.
python=
for candidate in /usr/bin/python3 python3; do
    "$candidate" -c 'import gzip' 2>/dev/null && python=$candidate && break
done
[ -n "$python" ] || skip "no Python to change a volume with"

"$SEGCAST" convert phantom:47x33x49 -o heart.nrrd -q >/dev/null
# change.py IN OUT LOW HIGH FROM=TO...: crop to voxels LOW to HIGH (x,y,z, inclusive) and replace labels, the others by 0
cat >change.py <<'PY'
import gzip, re, sys
low, high = ([int(v) for v in a.split(",")] for a in sys.argv[3:5])
to = dict((int(a), int(b)) for a, b in (pair.split("=") for pair in sys.argv[5:]))
head, data = open(sys.argv[1], "rb").read().split(b"\n\n", 1)
voxels, head = gzip.decompress(data), head.decode()
size = [int(v) for v in re.search(r"sizes: (.*)", head).group(1).split()]
table = bytes(to.get(v, 0) for v in range(256))
rows = [voxels[(z * size[1] + y) * size[0] + low[0]:(z * size[1] + y) * size[0] + high[0] + 1]
        for z in range(low[2], high[2] + 1) for y in range(low[1], high[1] + 1)]
axes = re.findall(r"\(([^)]*)\)", re.search(r"space directions: (.*)", head).group(1))
axes = [[float(v) for v in a.split(",")] for a in axes]
origin = [float(v) for v in re.search(r"space origin: \((.*)\)", head).group(1).split(",")]
origin = [origin[r] + sum(axes[a][r] * low[a] for a in range(3)) for r in range(3)]
head = re.sub(r"sizes: .*", "sizes: " + " ".join(str(h - l + 1) for l, h in zip(low, high)), head)
head = re.sub(r"space origin: .*", "space origin: (" + ",".join(repr(o) for o in origin) + ")", head)
open(sys.argv[2], "wb").write(head.encode() + b"\n\n" + gzip.compress(b"".join(rows).translate(table)))
PY

# hash_of VALUE [LINE]: the hash of the picture of a job whose volume is VALUE, and which may have one more LINE
hash_of() {
    cat >job.yaml <<JOB
volume: $1
output: {size: [160, 120], frames: png, video: none}
animation: {frames: 1, camera: {fixed: {position_mm: [-180, 190, 60], target_mm: [-10, 5, 0], up: superior}}}
tissues: {"*": {opacity: 0.6}, "aorta": {color: [200, 30, 30]}, "blood": {color: [90, 90, 200]}}
JOB
    [[ $1 == *blood* ]] || sed -i 's/, "blood".*/}/' job.yaml
    [[ $1 != *"keep: [blood]"* ]] || sed -i 's/"aorta": {[^}]*}, //' job.yaml
    echo "${2:-}" >>job.yaml
    rm -rf out
    "$SEGCAST" render job.yaml -o out -q >/dev/null
    hashes out
}

# Labels: 6 the aorta, 8 the left, 11 the right ventricle, 16 and 18 the atria.
whole=(0,0,0 46,32,48)
"$python" change.py heart.nrrd kept.nrrd "${whole[@]}" 6=6 8=8 16=16
[ "$(hash_of '{path: heart.nrrd, keep: [aorta, left ventricle, 16]}')" = "$(hash_of kept.nrrd)" ] ||
    fail "keep: the picture is not that of the volume with these tissues"
"$python" change.py heart.nrrd part.nrrd 10,4,12 40,30,44 $(for i in {1..20}; do echo "$i=$i"; done)
read -ra box < <("$SEGCAST" info part.nrrd --json | jq -r '.to_ras_mm | "\(.[0][3]) \(.[1][3]) \(.[2][3]) " +
    "\(.[0][3] + 30 * .[0][0]) \(.[1][3] + 26 * .[1][1]) \(.[2][3] + 32 * .[2][2])"')
corners="[[${box[0]}, ${box[4]}, ${box[2]}], [${box[3]}, ${box[1]}, ${box[5]}]]"
[ "$(hash_of "{path: heart.nrrd, box: $corners}")" = "$(hash_of part.nrrd)" ] || fail "box in mm: another picture"

# Merged tissues have the least number of theirs, and there are no borders between them.
"$python" change.py heart.nrrd blood.nrrd "${whole[@]}" $(for i in {1..20}; do echo "$i=$i"; done) 11=8 16=8 18=8
"$python" - <<'PY'
data = open("blood.nrrd", "rb").read()
open("blood.nrrd", "wb").write(data.replace(b"_Name:=left ventricle\n", b"_Name:=blood\n").replace(
    b"_ID:=left ventricle\n", b"_ID:=blood\n"))
PY
merge='merge: {blood: [right ventricle, left ventricle, "*atrium"]}'
"$SEGCAST" info blood.nrrd >said.txt
grep -q ' blood$' said.txt || fail "no blood: $(cat said.txt)"
[ "$(hash_of "{path: heart.nrrd, $merge}")" = "$(hash_of blood.nrrd)" ] || fail "merge: another picture"

# Merged, kept under the new name and cropped to what is shown: the same picture as without the crop, but for the dark
# of cavities, whose blocks of voxels it moves. Without a margin, too, it has no flat faces at the border of what is left.
hash_of "{path: heart.nrrd, $merge, keep: [blood]}" "light: {occlusion: 0}" >/dev/null
cp out/frames/000000.png kept.png
hash_of "{path: heart.nrrd, $merge, keep: [blood], box: visible}" "light: {occlusion: 0}" >/dev/null
"$IMAGE_DIFFERENCE" kept.png out/frames/000000.png 8 0.05 || fail "what is visible without a margin: another picture"
hash_of "{path: heart.nrrd, $merge, keep: [blood], box: visible + 6 mm}" "light: {occlusion: 0}" >kept.txt
"$IMAGE_DIFFERENCE" kept.png out/frames/000000.png 8 0.05 || fail "what is visible: another picture"
"$SEGCAST" check job.yaml 2>said.txt >/dev/null
grep -q '"blood" is made of 4 tissues' said.txt && grep -q '1 of 17 tissues are kept' said.txt || fail "$(cat said.txt)"
cropped=$(sed -n 's/.*volume.box: \(.*\) of 47 x 33 x 49 voxels.*/\1/p' said.txt)
[ -n "$cropped" ] && [ "$cropped" != "47 x 33 x 49" ] || fail "nothing was cropped: $(cat said.txt)"
# The job that is kept is the same job.
rm -rf again
"$SEGCAST" render out/job.yaml -o again -q >/dev/null
[ "$(hashes again)" = "$(cat kept.txt)" ] || fail "the resolved job gives another picture"

# A prepared file holds what was kept; a job that wants to change it is refused.
hash_of "{path: heart.nrrd, $merge, keep: [blood, aorta], box: visible + 6 mm}" >/dev/null
"$SEGCAST" convert job.yaml -o part.segc -q >/dev/null
[ "$(hash_of part.segc)" != "" ] || fail "the prepared file cannot be drawn"
sed 's/^volume.*/volume: {path: part.segc, keep: aorta}/; s/, "blood".*/}/' job.yaml >prepared.yaml
expect 65 'is prepared, and level, box, merge, keep and resample' "$SEGCAST" check prepared.yaml
# A setting of the path keeps what the job does with the volume; with the prepared file it has been done.
hash_of "{path: heart.nrrd, $merge, keep: [blood, aorta]}" >kept.txt
"$SEGCAST" convert phantom:40x30x42 -o small.nrrd -q >/dev/null
"$SEGCAST" check job.yaml --set volume=small.nrrd 2>said.txt >/dev/null
grep -q '2 of 17 tissues are kept' said.txt || fail "what the job keeps is lost with another path: $(cat said.txt)"
"$SEGCAST" convert job.yaml -o kept.segc -q >/dev/null
"$SEGCAST" render job.yaml --set volume=kept.segc -o mapped 2>said.txt >/dev/null
grep -q 'kept.segc: is prepared; what the job reads, merges, keeps and crops' said.txt || fail "$(cat said.txt)"
[ "$(hashes mapped)" = "$(cat kept.txt)" ] || fail "the prepared file with the job that made it: another picture"
# A box is what reading a smaller file is.
"$python" change.py heart.nrrd part.nrrd 10,4,12 40,30,44 $(for i in {1..20}; do echo "$i=$i"; done)
[ "$(hash_of '{path: heart.nrrd, box: [[10, 41], [4, 31], [12, 45]]}')" = "$(hash_of part.nrrd)" ] || fail "box: another picture"
# A box and what is visible in it; the corners of a box of the phantom, which is no file.
hash_of '{path: heart.nrrd, box: [[10, 41], [4, 31], [12, 45], visible], keep: [aorta]}' >/dev/null
grep -q "box.*visible" out/job.yaml || fail "box with visible: $(cat out/job.yaml)"
"$SEGCAST" check job.yaml 2>said.txt >/dev/null
grep -q 'volume.box: .* of 31 x 27 x 33 voxels' said.txt || fail "a box and what is visible in it: $(cat said.txt)"
hash_of "{path: phantom:47x33x49, box: $corners}" >/dev/null
"$SEGCAST" check job.yaml 2>said.txt >/dev/null
grep -q 'volume.box: 31 x 27 x 33 of 47 x 33 x 49 voxels' said.txt || fail "a box of the phantom: $(cat said.txt)"

# Another size of voxels is told, and so are tissues of which nothing is left; the hash is that of any number of threads.
hash_of '{path: heart.nrrd, resample: 6 mm}' >resampled.txt
"$SEGCAST" check job.yaml 2>said.txt >/dev/null
grep -Eq 'volume.resample: from 47 x 33 x 49 voxels of [0-9.]+ x [0-9.]+ x [0-9.]+ mm to [0-9]+ x [0-9]+ x [0-9]+ of 6 x 6 x 6 mm' said.txt ||
    fail "the resampling is not told: $(cat said.txt)"
rm -rf out
"$SEGCAST" render job.yaml -o out -q --threads 3 >/dev/null
[ "$(hashes out)" = "$(cat resampled.txt)" ] || fail "the resampled picture depends on the threads"
hash_of '{path: heart.nrrd, resample: [30, 30, 40 mm]}' >/dev/null
rm -rf out
"$SEGCAST" render job.yaml -o out 2>said.txt >/dev/null
grep -Eq 'volume.resample: no voxel is left of [0-9]+ tissues?: ' said.txt || fail "lost tissues are not told: $(cat said.txt)"

# What a box or coarser voxels leave nothing of is named, by check, too; a job may name it.
"$python" - <<'PY'
head = "NRRD0004\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 8 8 8\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n"
voxels = bytearray(512)
for z in range(8):
    for y in range(8):
        voxels[(z * 8 + y) * 8:(z * 8 + y) * 8 + 3] = bytes([1, 1, 1])
voxels[511] = 7
open("corner.nrrd", "wb").write(head.encode() + bytes(voxels))
PY
printf '1 wall 255 0 0 255\n7 nail 0 255 0 255\n9 ghost 0 255 0 255\n' >corner.ctbl
lost() { # lost KEY PATTERN: check and render of the volume with KEY warn of a lost tissue as PATTERN says
    printf 'volume: {path: corner.nrrd, %s}\nlabels: corner.ctbl\noutput: {size: [64, 48], frames: none, video: none}\n' "$1" >lost.yaml
    printf 'tissues: {nail: {opacity: 1}, "7": {color: [1, 2, 3]}}\nanimation: {frames: 1}\n' >>lost.yaml
    expect 0 "warning: .*$2" "$SEGCAST" check lost.yaml
    expect 0 "warning: .*${3:-$2}" "$SEGCAST" still lost.yaml --frame 0 -o lost.png --overwrite
}
lost 'box: [[0, 0, 0], [5, 5, 5]]' 'corner.nrrd: the box leaves nothing of 1 tissue: "nail"'
! grep -q wall stderr.txt || fail "a tissue that is left is said to be lost: $(cat stderr.txt)"
lost 'box: [[0, 5], [0, 8], [0, 8]]' 'corner.nrrd: the box leaves nothing of 1 tissue: "nail"'
grep -q 'corner.nrrd: has no voxels of 1 tissue that the job names: "nail"' stderr.txt || fail "that the job names it is not said: $(cat stderr.txt)"
lost 'box: [[0, 8], [0, 7], [0, 8]]' 'corner.nrrd: the box leaves nothing of 1 tissue: "nail"'
lost 'resample: 4 mm' 'volume.resample: no voxel may be left of 1 tissue, .*: "nail"' 'volume.resample: no voxel is left of 1 tissue: "nail"'
! grep -q wall stderr.txt || fail "a tissue that is left is said to be lost: $(cat stderr.txt)"
# So is a sheet that is large, but thinner than half a new voxel.
"$python" - <<'PY'
header, voxels = open("corner.nrrd", "rb").read().split(b"\n\n", 1)
sheet = bytearray(voxels)
for i in range(512):
    if i // 8 % 8 == 6 and sheet[i] == 0:
        sheet[i] = 7
open("corner.nrrd", "wb").write(header + b"\n\n" + bytes(sheet[:511]) + b"\0")
PY
lost 'resample: [1, 3 mm, 1]' 'volume.resample: no voxel may be left of 1 tissue, .* thinner than half of one: "nail"' \
    'volume.resample: no voxel is left of 1 tissue: "nail"'
expect 0 '' "$SEGCAST" check lost.yaml --set 'volume.resample=1 mm'
! grep -q 'may be left' stderr.txt || fail "a sheet that stays is said to be lost: $(cat stderr.txt)"
printf 'volume: {path: corner.nrrd, box: [[0, 0, 0], [7, 7, 7]]}\n' >whole.yaml
"$SEGCAST" check whole.yaml >/dev/null 2>said.txt
! grep -q 'leaves nothing of' said.txt || fail "a box that loses nothing: $(cat said.txt)"
