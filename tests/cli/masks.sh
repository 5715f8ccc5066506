# SPDX-License-Identifier: BSD-3-Clause
# Tissues that a volume names without numbers: the masks of a directory, and segments in layers that share numbers.

# mask FILE VOXELS: write a mask of 12 x 1 x 1 voxels, digits, as NRRD
mask() {
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 12 1 1\n' >"$1"
    printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n\n' >>"$1"
    sed 's/./& /g' <<<"$2" >>"$1"
}
# labels_of VOLUME [OPTION...]: number, name, voxels and colour of all labels, and what the report on the table says
labels_of() {
    "$SEGCAST" info "$@" --json 2>said.txt |
        jq -c '[.labels[1:][] | [.value, .name, .voxels]], (.label_table // {} | [.rows_without_voxels, .voxels_without_row])' || cat said.txt
}
mkdir masks
mask masks/liver.nrrd 111111000000
mask masks/kidney_left.nrrd 000000011000
mask masks/spleen.nrrd 000000000111

# A table finds the masks by their names, however these are written, and gives them its numbers; so does a class list.
printf '1 spleen 255 0 0 255\n7 Kidney-Left 0 255 0 255\n9 colon 1 2 3 255\n' >table.ctbl
labels_of masks --labels table.ctbl >got.txt
diff - got.txt >&2 <<'TXT' || fail "the table is not matched by names"
[[1,"spleen",3],[2,"liver",6],[7,"Kidney-Left",2]]
[[9],[2]]
TXT
grep -q 'table.ctbl: 2 of its 3 rows have the names of tissues of .*masks, whose labels get their numbers; it has no row for "liver"$' said.txt ||
    fail "what was matched is not told: $(cat said.txt)"
"$SEGCAST" info masks --labels table.ctbl --json -q | jq -e '.labels[1].color == [255, 0, 0]' >/dev/null || fail "the spleen has another colour"
printf 'class_map = {1: "spleen", 3: "kidney_left", 5: "liver"}\n' | sed 's/class_map = //' >classes.py
labels_of masks --labels classes.py >got.txt
[ "$(head -1 got.txt)" = '[[1,"spleen",3],[3,"kidney_left",2],[5,"liver",6]]' ] || fail "class list: $(cat got.txt)"
printf 'volume: masks\nlabels: classes.py\noutput: {size: [64, 48], frames: png, video: none}\nanimation: {frames: 1}\n' >job.yaml
printf 'tissues: {"5": {color: [1, 2, 3]}, spleen: {visible: false}}\n' >>job.yaml
"$SEGCAST" check job.yaml --fast >/dev/null 2>said.txt || fail "check --fast: $(cat said.txt)"
"$SEGCAST" render job.yaml -o out -q >/dev/null || fail "no picture of the masks with a class list"

# Of two rows of one name, and of one number, the first counts; the other label gets a free number.
printf '4 spleen 1 1 1 255\n5 Spleen 2 2 2 255\n6 liver 3 3 3 255\n6 kidney_left 4 4 4 255\n' >twice.ctbl
labels_of masks --labels twice.ctbl >got.txt
diff - got.txt >&2 <<'TXT' || fail "rows of one name or number"
[[1,"kidney_left",2],[4,"spleen",3],[6,"liver",6]]
[[5],[1]]
TXT

# Numbers count only if no name fits, and that is said.
printf '1 left 255 0 0 255\n2 middle 0 255 0 255\n' >other.ctbl
labels_of masks --labels other.ctbl >got.txt
[ "$(head -1 got.txt)" = '[[1,"left",2],[2,"middle",6],[3,"spleen",3]]' ] || fail "a table by number: $(cat got.txt)"
grep -q 'warning: .*other.ctbl: names none of the tissues of .*masks, which have no numbers but those that segcast has given' said.txt ||
    fail "that numbers count is not said: $(cat said.txt)"

# A prepared file keeps the numbers that it has, and still goes by names.
"$SEGCAST" convert masks -o masks.segc -q >/dev/null
labels_of masks.segc --labels table.ctbl >got.txt
[ "$(head -1 got.txt)" = '[[1,"Kidney-Left",2],[2,"liver",6],[3,"spleen",3]]' ] || fail "a prepared file: $(cat got.txt)"
"$SEGCAST" convert masks --labels table.ctbl -o named.segc -q >/dev/null
labels_of named.segc --labels other.ctbl >got.txt
[ "$(head -1 got.txt)" = '[[1,"left",3],[2,"middle",6],[7,"Kidney-Left",2]]' ] || fail "a prepared file with the numbers of a table: $(cat got.txt)"

# Layers that use a number twice are the same.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 4\nspace: RAS\nsizes: 2 6 1 1\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n'
    printf 'kinds: list domain domain domain\nspace origin: (0,0,0)\nencoding: ascii\n'
    printf 'Segment%d_ID:=s\nSegment%d_LabelValue:=1\nSegment%d_Layer:=%d\nSegment%d_Name:=%s\n' 0 0 0 0 0 liver 1 1 1 1 1 spleen
    printf '\n1 0 1 0 1 0 0 1 0 1 0 0\n'
} >two.seg.nrrd
labels_of two.seg.nrrd --labels table.ctbl >got.txt
[ "$(head -1 got.txt)" = '[[1,"spleen",2],[2,"liver",3]]' ] || fail "layers: $(cat got.txt; cat said.txt)"

# A tissue whose mask is empty is known, and so is one that only a table names; a job that names it is told so, and drawn.
mask masks/gallbladder.nrrd 000000000000
printf '4 gallbladder 9 9 9 255\n8 colon 1 2 3 255\n5 Liver 1 2 3 255\n' >more.ctbl
cat >job.yaml <<'YAML'
volume: masks
labels: more.ctbl
output: {size: [64, 48], frames: png, video: none}
tissues: {"gall*": {opacity: 0.5}, colon: {color: [1, 2, 3]}, liver: {opacity: 1}}
animation: {frames: 1, clip: [{normal: anterior, at: {0%: 0%, 100%: 10%}, except: [Gallbladder]}]}
YAML
expect 0 'warning: .*masks: has no voxels of 2 tissues that the job names: "gallbladder", "colon"' "$SEGCAST" check job.yaml
expect 0 'masks: has no voxels of 2 tissues' "$SEGCAST" render job.yaml -o empty
"$SEGCAST" check job.yaml --fast >/dev/null 2>said.txt || fail "check --fast: $(cat said.txt)"
labels_of masks --labels more.ctbl >got.txt
diff - got.txt >&2 <<'TXT' || fail "a mask without voxels"
[[1,"kidney_left",2],[2,"spleen",3],[4,"gallbladder",0],[5,"Liver",6]]
[[4,8],[1,2]]
TXT
sed 's/^volume.*/volume: {path: masks, merge: {belly: [gallbladder, liver]}, keep: [belly, gallbladder]}/; /^tissues/d; s/, clip.*/}/' job.yaml >merged.yaml
expect 65 'tissue "gallbladder" matches no label of the volume' "$SEGCAST" check merged.yaml
sed -i 's/, gallbladder\]}$/]}/' merged.yaml
expect 0 '"belly" is made of 2 tissues' "$SEGCAST" check merged.yaml
printf 'volume: masks/liver.nrrd\nlabels: more.ctbl\ntissues: {gallbladder: {visible: false}, "8": {opacity: 1}}\n' >one.yaml
expect 0 'liver.nrrd: has no voxels of 2 tissues that the job names: "gallbladder", "colon"' "$SEGCAST" check one.yaml
expect 65 'tissue "colom" matches no label of the volume' "$SEGCAST" check one.yaml --set tissues.colom.opacity=1; one_error

# What is kept is resolved among what is kept: a tumour that is left out leaves no hole in the liver, whose mask has it.
mkdir holes
mask holes/liver.nrrd 111111110000
mask holes/tumour.nrrd 000111000000
mask holes/vein.nrrd 010000010000
kept_of() { # kept_of VOLUME KEY: labels, and their voxels, of a volume with a key that changes it
    printf 'volume: {path: %s, %s}\n' "$1" "$2" >kept.yaml
    "$SEGCAST" check kept.yaml >/dev/null 2>said.txt || cat said.txt
    "$SEGCAST" info "$1" --json -q --set "volume={$2}" | jq -c '[.labels[1:][] | [.name, .voxels]]'
}
[ "$(kept_of holes 'keep: [liver]')" = '[["liver",8]]' ] || fail "the kept liver: $(kept_of holes 'keep: [liver]')"
grep -q 'volume.keep: 1 of 3 tissues are kept' said.txt || fail "what is kept is not told: $(cat said.txt)"
! grep -q 'belong to several' said.txt || fail "overlaps with tissues that are left out are told: $(cat said.txt)"
[ "$(kept_of holes 'keep: [liver, v*]')" = '[["liver",6],["vein",2]]' ] || fail "liver and veins: $(kept_of holes 'keep: [liver, v*]')"
[ "$(kept_of holes 'merge: {all: [liver, vein]}, keep: [all]')" = '[["all",8]]' ] || fail "merged: $(kept_of holes 'merge: {all: [liver, vein]}, keep: [all]')"
[ "$(kept_of holes 'merge: {all: [tumour, vein]}, keep: [liver]')" = '[["liver",8]]' ] || fail "without a merged tissue"
! grep -q 'has no voxels' said.txt || fail "tissues that are left out are taken for missing: $(cat said.txt)"
expect 65 'tissue "lever" matches no label of the volume; did you mean "liver"' "$SEGCAST" check kept.yaml --set 'volume.keep=[lever]'; one_error
printf '1 Tumor 1 1 1 255\n4 Tumour 1 1 1 255\n5 LIVER 1 1 1 255\n' >renamed.ctbl
sed -i 's/^volume.*/volume: {path: holes, keep: [5]}\nlabels: renamed.ctbl/' kept.yaml
expect 0 '1 of 3 tissues are kept' "$SEGCAST" check kept.yaml
! grep -q 'belong to several' stderr.txt || fail "tissues are not kept by the numbers of a table: $(cat stderr.txt)"
{
    sed '/^Segment1_Name/,$d; s/sizes: .*/sizes: 2 6 1 1/' two.seg.nrrd
    printf 'Segment1_Name:=tumour\n\n1 0 1 1 1 1 1 0 0 0 0 0\n'
} >holes.seg.nrrd
[ "$(kept_of holes.seg.nrrd 'keep: [liver]')" = '[["liver",4]]' ] || fail "layers: $(kept_of holes.seg.nrrd 'keep: [liver]')"

# Of all tissues that overlap, info gives the voxels of each two; a tissue of which nothing is left is told by its name.
mask holes/cyst.nrrd 000010000000
mask holes/node.nrrd 000010000000
expect 0 'warning: .*holes: nothing is shown of 1 tissue, all of whose voxels belong to others, too: "cyst"; `overlap: \[NAME' "$SEGCAST" info holes
sed -n '/tissues that overlap/,$p' stdout.txt | sed 's/  */ /g' >got.txt
diff - got.txt >&2 <<'TXT' || fail "the overlaps are not as expected"
 voxels tissues that overlap
 2 shown as tumour, and not as liver
 2 shown as vein, and not as liver
 1 shown as cyst, and not as liver
 1 shown as node, and not as cyst
 1 shown as node, and not as tumour
TXT
"$SEGCAST" info holes --json -q >info.json
jq -e '.overlaps | map(select(.covered == "liver")) == [{shown: "tumour", covered: "liver", voxels: 2}, {shown: "vein", covered: "liver", voxels: 2},
    {shown: "cyst", covered: "liver", voxels: 1}]' info.json >/dev/null || fail "overlaps: $(jq -c .overlaps info.json)"
"$SEGCAST" info masks/liver.nrrd --json -q | jq -e '.overlaps == []' >/dev/null || fail "a volume without overlaps"
