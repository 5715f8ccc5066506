# SPDX-License-Identifier: BSD-3-Clause
# segcast convert writes label tables in the formats of other programs, from any of them and from volumes.
cat >heart.tsv <<'TSV'
index	name	color
1	left atrium	#e15f78
2	aorta	#c80000
TSV

# By the ending of the file, and to standard output; a file is replaced only if that is asked for.
[ "$("$SEGCAST" convert heart.tsv -o heart.ctbl -q)" = heart.ctbl ] || fail "the path of the table was not printed"
grep -qx '1 left_atrium 225 95 120 255' heart.ctbl || { cat heart.ctbl; fail "the table of 3D Slicer is not as expected"; }
"$SEGCAST" convert heart.ctbl -o - --to bids -q | diff heart.tsv - >&2 || fail "the table did not come back as it was"
expect 73 'heart.ctbl' "$SEGCAST" convert heart.tsv -o heart.ctbl; one_error
"$SEGCAST" convert heart.tsv -o heart.ctbl --overwrite -q >/dev/null
expect 73 'heart.tsv' "$SEGCAST" convert heart.tsv -o heart.tsv --overwrite; one_error

# Every format is read again, whether it is guessed or named.
for pair in slicer freesurfer itksnap xml csv:csv bids:csv json neuroglancer:json ome-zarr:json gifti:xml workbench names nnunet:json; do
    "$SEGCAST" convert heart.tsv -o "${pair%:*}.txt" --to "${pair%:*}" -q >/dev/null 2>&1
    if ! "$SEGCAST" convert "${pair%:*}.txt" -o - --to bids -q --labels-format "${pair#*:}" >back.tsv 2>said.txt; then
        grep -q 'built without Expat' said.txt && continue
        cat said.txt; fail "${pair%:*} was not read again"
    fi
    [ "$(cut -f 1 back.tsv | tr '\n' ' ')" = 'index 1 2 ' ] || { cat back.tsv; fail "${pair%:*} lost labels"; }
    [[ $pair =~ ^(neuroglancer|names|nnunet) ]] || grep -q '#e15f78' back.tsv || fail "${pair%:*} lost colours"
done

[ "$(jq -c .labels nnunet.txt)" = '{"background":0,"left atrium":1,"aorta":2}' ] || fail "nnU-Net: $(cat nnunet.txt)"
"$SEGCAST" convert heart.tsv -o heart.label.gii -q >/dev/null
grep -q '<GIFTI' heart.label.gii || fail "the ending .label.gii does not tell GIFTI"
printf 'LabelValue,Name,Color_R,Color_G,Color_B,Type_CodeValue,Type_CodeMeaning\n1,left atrium,1,2,3,T-32300,Atrium\n1,atrium,1,2,3,T,A\n' >codes.csv
expect 0 'codes.csv: columns that are not used: "Type_CodeValue"' "$SEGCAST" convert codes.csv -o - --to names
expect 0 'warning: standard output: 1 row of the table says something else of a number than a row before; the first' "$SEGCAST" convert codes.csv -o - --to names

# Names and colours of a volume's header, and the same volume drawn with either table.
"$SEGCAST" convert phantom:40x36x44 -o phantom.nrrd -q >/dev/null
"$SEGCAST" convert phantom.nrrd -o phantom.json -q >/dev/null
[ "$(jq length phantom.json)" = 20 ] || fail "the table of the phantom has $(jq length phantom.json) labels"
"$SEGCAST" convert phantom.json -o phantom.csv -q >/dev/null
"$SEGCAST" info phantom.nrrd --labels phantom.csv --json -q 2>/dev/null | jq '.labels[1:] | map({name, color})' >one.json
"$SEGCAST" info phantom.nrrd --json -q 2>/dev/null | jq '.labels[1:] | map({name, color})' | diff - one.json >&2 ||
    fail "names or colours changed on their way through JSON and CSV"

# Mistakes, and what a format cannot hold.
expect 64 'no file to write' "$SEGCAST" convert heart.tsv; one_error
expect 64 'its ending does not tell what to write' "$SEGCAST" convert heart.tsv -o heart.txt; one_error
expect 64 'did you mean "freesurfer"' "$SEGCAST" convert heart.tsv -o new.txt --to freesurfr; one_error
expect 66 'nothing.tsv' "$SEGCAST" convert nothing.tsv -o new.json; one_error
echo '# nothing' >empty.txt
expect 65 'expected one a line' "$SEGCAST" convert empty.txt -o new.json; one_error
expect 0 'cannot hold, and does not have: the colours of 2 labels' "$SEGCAST" convert heart.tsv -o new.txt --to neuroglancer

# Tables where other programs look for them: those of BIDS, also inherited, and the look-up table of FreeSurfer.
command -v python3 >/dev/null || exit 0
mkdir -p bids/sub-01/anat elsewhere/anat
to_nifti() { # to_nifti OUT: a NIfTI file of 2 x 2 x 2 voxels, four of label 1 and four of label 2
    python3 - "$1" <<'PY'
import struct, sys
header = bytearray(352)
struct.pack_into("<i", header, 0, 348)
struct.pack_into("<8h", header, 40, 3, 2, 2, 2, 1, 1, 1, 1)
struct.pack_into("<hh", header, 70, 2, 8)
struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
struct.pack_into("<fff", header, 108, 352, 1, 0)
struct.pack_into("<hh", header, 252, 0, 2)
struct.pack_into("<12f", header, 280, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
header[344:348] = b"n+1\0"
open(sys.argv[1], "wb").write(bytes(header) + bytes([1, 2] * 4))
PY
}
name_of() { # name_of VOLUME: the name of its label 1, or what was wrong
    "$SEGCAST" info "$1" --json -q 2>said.txt | jq -r '.labels[1].name' || cat said.txt
}
volume=bids/sub-01/anat/sub-01_desc-aseg_dseg.nii
to_nifti $volume
[ "$(name_of $volume)" = "" ] || fail "a volume without a table has a name: $(name_of $volume)"
echo '{}' >bids/dataset_description.json
sed 's/left atrium/root/' heart.tsv >bids/dseg.tsv
sed 's/left atrium/wrong/' heart.tsv >bids/desc-other_dseg.tsv
[ "$(name_of $volume)" = root ] || fail "the inherited table is not found: \"$(name_of $volume)\""
sed 's/left atrium/aseg/' heart.tsv >bids/desc-aseg_dseg.tsv
[ "$(name_of $volume)" = aseg ] || fail "the table that fits best is not taken: \"$(name_of $volume)\""
sed 's/left atrium/beside/' heart.tsv >bids/sub-01/anat/sub-01_desc-aseg_dseg.tsv
[ "$(name_of $volume)" = beside ] || fail "the table beside the volume is not found: \"$(name_of $volume)\""
[ "$(cd bids/sub-01/anat && name_of sub-01_desc-aseg_dseg.nii)" = beside ] || fail "it is not found from its own directory"
expect 0 'names and colours come from .*sub-01_desc-aseg_dseg.tsv' "$SEGCAST" info $volume
"$SEGCAST" info $volume --labels heart.tsv --json -q | jq -e '.labels[1].name == "left atrium"' >/dev/null || fail "--labels does not win"
cp $volume elsewhere/anat/sub-01_dseg.nii
cp heart.tsv elsewhere/dseg.tsv
[ "$(name_of elsewhere/anat/sub-01_dseg.nii)" = "" ] || fail "a table above a volume of no data set was taken"

# Of FreeSurfer: beside the volume, or where the program is installed.
python3 - <<'PY'
import struct
header = bytearray(284)
struct.pack_into(">7i", header, 0, 1, 2, 2, 2, 1, 0, 0)
struct.pack_into(">h", header, 28, 1)
struct.pack_into(">15f", header, 30, 1, 1, 1, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0)
open("aseg.mgh", "wb").write(bytes(header) + bytes([17, 53] * 4))
PY
mkdir installed beside
printf '17  Left-Hippocampus  220 216 20  0\n53  Right-Hippocampus  220 216 20  0\n' >installed/FreeSurferColorLUT.txt
export FREESURFER_HOME=$PWD/installed
[ "$(name_of aseg.mgh)" = Left-Hippocampus ] || fail "the table of FreeSurfer is not found: $(name_of aseg.mgh)"
cp aseg.mgh beside
sed 's/Left/Own/' installed/FreeSurferColorLUT.txt >beside/FreeSurferColorLUT.txt
[ "$(name_of beside/aseg.mgh)" = Own-Hippocampus ] || fail "the table beside the volume does not win"

# Without one, the numbers of FreeSurfer tell where names are to be had; those of others do not.
numbers() { # numbers FILE NUMBER...: write a volume with these labels
    local file=$1
    shift
    printf 'NRRD0004\ntype: int\ndimension: 3\nspace: RAS\nsizes: %d 1 1\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n\n%s\n' $# "$*" >"$file"
}
numbers aseg.nrrd 0 2 3 4 5 7 8 10 11 12 14 15 16 24 41 42 43 44 46 47 49 50 51
numbers aparc.nrrd 0 2 41 $(seq 1001 1035) $(seq 2001 2035)
numbers other.nrrd 0 $(seq 1 117)
for file in aseg aparc; do
    expect 0 "$file.nrrd: has the numbers of FreeSurfer, and no names; names and colours are in $FREESURFER_HOME/FreeSurferColorLUT.txt," "$SEGCAST" info $file.nrrd
    FREESURFER_HOME='' expect 0 "names and colours are in FreeSurferColorLUT.txt, which FreeSurfer installs: .labels: FILE" "$SEGCAST" info $file.nrrd
done
for arguments in other.nrrd "aseg.nrrd --labels heart.tsv" phantom.nrrd; do
    "$SEGCAST" info $arguments 2>said.txt >/dev/null
    ! grep -q 'numbers of FreeSurfer' said.txt || fail "$arguments: taken for a volume of FreeSurfer"
done

# info and check tell how a table and the voxels agree: values of several rows, rows of no voxel, voxels of no row.
cat >some.csv <<'CSV'
value,name
99,ghost
2,second
2,again
1,first
CSV
"$SEGCAST" info phantom.nrrd --labels some.csv >info.txt 2>/dev/null
cat >expected.txt <<'TXT'
label table some.csv: 4 rows
  several rows          2 second
  rows without voxels   99 ghost
TXT
sed -n "s|$PWD/||; /^label table/,\$p" info.txt | head -3 | diff expected.txt - >&2 || fail "info: the report on the table"
grep -q '^  voxels without a row  3 mitral valve, 4 tricuspid valve, .* and 6 more$' info.txt || { cat info.txt; fail "info: voxels without a row"; }
grep -qx '  numbers left out      3 to 98' info.txt || { cat info.txt; fail "info: numbers left out"; }
"$SEGCAST" info phantom.nrrd --labels some.csv --json -q | jq -e '.label_table | .rows == 4 and .several_rows == [2] and
    .rows_without_voxels == [99] and .voxels_without_row == [range(3; 21)] and .numbers_left_out == [[3, 98]]' >/dev/null || fail "info --json: the report on the table"
printf 'ObjectType = Image\nNDims = 3\nDimSize = 2 2 1\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n\1\1\2\2' >bare.mha
"$SEGCAST" info bare.mha --json -q | jq -e 'has("label_table") and .label_table == null' >/dev/null || fail "info --json without a table"
# The same of the table in the header of a volume; of a job that merges tissues, nothing about voxels.
LC_ALL=C sed 's/^Segment0_LabelValue:=1$/Segment0_LabelValue:=99/; s/^Segment3_LabelValue:=4$/Segment3_LabelValue:=3/' phantom.nrrd >own.nrrd
cat >expected_own.txt <<'TXT'
label table own.nrrd: 20 rows
  several rows          3 mitral valve
  rows without voxels   99 aortic valve
  voxels without a row  1, 4
  numbers left out      4, 21 to 98
TXT
"$SEGCAST" info own.nrrd 2>/dev/null | sed -n '/^label table/,$p' | sed "s|$PWD/||" | diff expected_own.txt - >&2 || fail "info: the report on the table of the file"
for said in '1,5' '1,2p;5'; do
    printf 'volume: own.nrrd\n' >own.yaml
    [ "$said" = '1,5' ] || printf 'volume: {path: own.nrrd, merge: {valves: [1, 2]}}\n' >own.yaml
    "$SEGCAST" check own.yaml 2>/dev/null | sed "1d; s|$PWD/||" | diff <(sed -n "${said}p" expected_own.txt) - >&2 || fail "check: the report on the table of the file, $said"
done
printf 'volume: phantom.nrrd\nlabels: some.csv\n' >job.yaml
"$SEGCAST" check job.yaml >check.txt 2>/dev/null
sed '1d' check.txt | diff - <(sed -n '/^label table/,$p' info.txt) >&2 || fail "check: the report on the table"
"$SEGCAST" check job.yaml --fast >check.txt 2>/dev/null
sed "1d; s|$PWD/||" check.txt | diff - <(head -n 2 expected.txt && grep '^  numbers left out' info.txt) >&2 || fail "check --fast: the report on the table"
