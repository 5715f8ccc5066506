# SPDX-License-Identifier: BSD-3-Clause
# segcast tables writes label tables in the formats of other programs, from any of them and from volumes.
cat >heart.tsv <<'TSV'
index	name	color
1	left atrium	#e15f78
2	aorta	#c80000
TSV

# By the ending of the file, and to standard output; a file is replaced only if that is asked for.
[ "$("$SEGCAST" tables heart.tsv -o heart.ctbl -q)" = heart.ctbl ] || fail "the path of the table was not printed"
grep -qx '1 left_atrium 225 95 120 255' heart.ctbl || { cat heart.ctbl; fail "the table of 3D Slicer is not as expected"; }
"$SEGCAST" tables heart.ctbl -o - --to bids -q | diff heart.tsv - >&2 || fail "the table did not come back as it was"
expect 73 'heart.ctbl' "$SEGCAST" tables heart.tsv -o heart.ctbl; one_error
"$SEGCAST" tables heart.tsv -o heart.ctbl --overwrite -q >/dev/null
expect 73 'heart.tsv' "$SEGCAST" tables heart.tsv -o heart.tsv --overwrite; one_error

# Every format is read again, whether it is guessed or named.
for pair in slicer freesurfer itksnap xml csv:csv bids:csv json neuroglancer:json ome-zarr:json; do
    "$SEGCAST" tables heart.tsv -o "${pair%:*}.txt" --to "${pair%:*}" -q >/dev/null 2>&1
    if ! "$SEGCAST" tables "${pair%:*}.txt" -o - --to bids -q --labels-format "${pair#*:}" >back.tsv 2>said.txt; then
        grep -q 'built without Expat' said.txt && continue
        cat said.txt; fail "${pair%:*} was not read again"
    fi
    [ "$(cut -f 1 back.tsv | tr '\n' ' ')" = 'index 1 2 ' ] || { cat back.tsv; fail "${pair%:*} lost labels"; }
    [ "${pair%:*}" = neuroglancer ] || grep -q '#e15f78' back.tsv || fail "${pair%:*} lost colours"
done

# Names and colours of a volume's header, and the same volume drawn with either table.
"$SEGCAST" phantom --size 40x36x44 -o phantom.nrrd -q >/dev/null
"$SEGCAST" tables phantom.nrrd -o phantom.json -q >/dev/null
[ "$(jq length phantom.json)" = 20 ] || fail "the table of the phantom has $(jq length phantom.json) labels"
"$SEGCAST" tables phantom.json -o phantom.csv -q >/dev/null
"$SEGCAST" info phantom.nrrd --labels phantom.csv --json -q 2>/dev/null | jq '.labels[1:] | map({name, color})' >one.json
"$SEGCAST" info phantom.nrrd --json -q 2>/dev/null | jq '.labels[1:] | map({name, color})' | diff - one.json >&2 ||
    fail "names or colours changed on their way through JSON and CSV"

# Mistakes, and what a format cannot hold.
expect 64 'no file to write' "$SEGCAST" tables heart.tsv; one_error
expect 64 'its ending does not tell the format' "$SEGCAST" tables heart.tsv -o heart.txt; one_error
expect 64 'did you mean "freesurfer"' "$SEGCAST" tables heart.tsv -o new.txt --to freesurfr; one_error
expect 66 'nothing.tsv' "$SEGCAST" tables nothing.tsv -o new.json; one_error
echo '# nothing' >empty.txt
expect 65 'expected one a line' "$SEGCAST" tables empty.txt -o new.json; one_error
expect 0 'cannot hold, and does not have: the colours of 2 labels' "$SEGCAST" tables heart.tsv -o new.txt --to neuroglancer
