# SPDX-License-Identifier: BSD-3-Clause
# Tissues are coloured by the values of a table, or by what is measured; the values belong to the identity of the job.
cat >values.csv <<'CSV'
name,thickness_mm,change
left_ventricle,10,-1
aorta,n/a,2
liver,5,0
CSV
cat >job.yaml <<'YAML'
volume: phantom:40x36x44
output: {directory: out, size: [160, 120], video: none, frames: png}
animation: {frames: 2, camera: {orbit: {turns: 1}}}
tissues: {"*": {opacity: 1}}
YAML
by=(--set 'color_by={table: values.csv, column: thickness_mm}')

# Rows of tissues that are not there are told once; tissues without a value, too.
"$SEGCAST" check job.yaml "${by[@]}" >said.txt 2>&1 || { cat said.txt; fail "the table was refused"; }
grep -q 'warning: .*values.csv:4: "liver" is no label of the volume; 1 such row is not used' said.txt || { cat said.txt; fail "the row without a label was not told"; }
sed 's/^liver/left atrum/' values.csv >near.csv
"$SEGCAST" check job.yaml --set 'color_by={table: near.csv, column: thickness_mm}' >near.txt 2>&1 || { cat near.txt; fail "the table was refused"; }
grep -q 'near.csv:4: "left atrum" is no label of the volume; did you mean "left atrium"? 1 such row is not used' near.txt || { cat near.txt; fail "the nearest name was not told"; }
grep -q '19 of 20 tissues have no value' said.txt || { cat said.txt; fail "tissues without a value were not told"; }

# Pictures follow the values, on any number of ranks, also of a prepared file; a colour under tissues goes before.
expect 0 '' "$SEGCAST" render job.yaml -o plain -q
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" -q
[ "$(hashes plain)" != "$(hashes out)" ] || fail "the values change nothing"
mpi 2 "$SEGCAST" render job.yaml "${by[@]}" -o two -q >/dev/null 2>&1
[ "$(hashes two)" = "$(hashes out)" ] || fail "the pictures of two ranks differ"
expect 0 '' "$SEGCAST" prepare job.yaml -o heart.segc -q
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" --set volume=heart.segc -o prepared -q
[ "$(hashes prepared)" = "$(hashes out)" ] || fail "the pictures of a prepared file differ"
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" --set 'tissues={"*": {opacity: 1, color: red}}' -o red -q
expect 0 '' "$SEGCAST" render job.yaml --set 'tissues={"*": {opacity: 1, color: red}}' -o red2 -q
[ "$(hashes red)" = "$(hashes red2)" ] || fail "values go before a colour of the job"

# The job as resolved makes the same pictures; other values under the same name are another job.
expect 0 '' "$SEGCAST" render out/job.yaml -o again -q
[ "$(hashes again)" = "$(hashes out)" ] || fail "the job as resolved makes other pictures"
expect 0 'nothing to do' "$SEGCAST" render job.yaml "${by[@]}" --resume
sed -i 's/aorta,n/aorta,7/' values.csv
sed -i 's/7\/a/7/' values.csv
expect 73 'other job|another job' "$SEGCAST" render job.yaml "${by[@]}" --resume -q

# What is measured, and the colour bar.
for measure in volume thickness surface; do
    expect 0 '' "$SEGCAST" render job.yaml --set "color_by={measure: $measure, map: cividis}" -o $measure -q --frames 0
done
[ "$(cat <(hashes volume) <(hashes thickness) <(hashes surface) | sort -u | wc -l)" = 3 ] || fail "measures have the same pictures"
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" --set overlays.color_bar=bottom-left -o bar -q
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" -o bare -q
[ -z "$(comm -12 <(hashes bar | sort) <(hashes bare | sort))" ] || fail "the colour bar is not drawn"
mpi 2 "$SEGCAST" render job.yaml "${by[@]}" --set overlays.color_bar=bottom-left --set farm.partition=tiles -o bar2 -q >/dev/null 2>&1
[ "$(hashes bar)" = "$(hashes bar2)" ] || fail "the colour bar of two ranks differs"

# Mistakes.
expect 65 'values.csv:1: has not exactly one column "thick"; .*"thickness_mm", "change"' "$SEGCAST" check job.yaml --set 'color_by={table: values.csv, column: thick}'
one_error
expect 65 'values.csv:1: has not exactly one column that may hold the values' "$SEGCAST" check job.yaml --set 'color_by={table: values.csv}'
one_error
printf 'aorta,9,9\n' >>values.csv
expect 65 'values.csv:5: is a second row of "aorta" .*, which line 3 has already' "$SEGCAST" check job.yaml "${by[@]}"
one_error
expect 66 'none.csv' "$SEGCAST" check job.yaml --set 'color_by={table: none.csv}'
one_error
