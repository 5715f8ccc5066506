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
by=(--set 'color_by={values: values.csv, column: thickness_mm}')

# Rows of tissues that are not there are told once; tissues without a value, too.
"$SEGCAST" check job.yaml "${by[@]}" >said.txt 2>&1 || { cat said.txt; fail "the table was refused"; }
grep -q 'warning: .*values.csv:4: "liver" is no label of the volume; 1 such row is not used' said.txt || { cat said.txt; fail "the row without a label was not told"; }
sed 's/^liver/left atrum/' values.csv >near.csv
"$SEGCAST" check job.yaml --set 'color_by={values: near.csv, column: thickness_mm}' >near.txt 2>&1 || { cat near.txt; fail "the table was refused"; }
grep -q 'near.csv:4: "left atrum" is no label of the volume; did you mean "left atrium"? 1 such row is not used' near.txt || { cat near.txt; fail "the nearest name was not told"; }
grep -q '19 of 20 tissues have no value' said.txt || { cat said.txt; fail "tissues without a value were not told"; }

# Pictures follow the values, on any number of ranks, also of a prepared file; a colour under tissues goes before.
expect 0 '' "$SEGCAST" render job.yaml -o plain -q
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" -q
[ "$(hashes plain)" != "$(hashes out)" ] || fail "the values change nothing"
mpi 2 "$SEGCAST" render job.yaml "${by[@]}" -o two -q >/dev/null 2>&1
[ "$(hashes two)" = "$(hashes out)" ] || fail "the pictures of two ranks differ"
expect 0 '' "$SEGCAST" convert job.yaml -o heart.segc -q
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
    expect 0 '' "$SEGCAST" render job.yaml --set "color_by={values: $measure, map: cividis}" -o $measure -q --frames 0
done
[ "$(cat <(hashes volume) <(hashes thickness) <(hashes surface) | sort -u | wc -l)" = 3 ] || fail "measures have the same pictures"
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" --set overlays.color_bar=bottom-left -o bar -q
expect 0 '' "$SEGCAST" render job.yaml "${by[@]}" -o bare -q
[ -z "$(comm -12 <(hashes bar | sort) <(hashes bare | sort))" ] || fail "the colour bar is not drawn"
mpi 2 "$SEGCAST" render job.yaml "${by[@]}" --set overlays.color_bar=bottom-left --set farm.partition=tiles -o bar2 -q >/dev/null 2>&1
[ "$(hashes bar)" = "$(hashes bar2)" ] || fail "the colour bar of two ranks differs"

# Values that change: a column for each key frame. At a key frame the picture is that of its column with the same range, one
# frame alone is that of the film, on any number of ranks, and the headings and times belong to the identity.
cat >ages.csv <<'CSV'
name,age_20,age_40,age_60
left_ventricle,10,5,0
aorta,n/a,2,8
pulmonary artery,0,4,1
CSV
cat >ages.yaml <<'YAML'
volume: phantom:40x36x44
color_by:
  values: ages.csv
  column: {0%: age_20, 2f: {value: age_40, ease: smooth}, 100%: age_60}
output: {directory: ages, size: [160, 120], video: none, frames: png}
animation: {frames: 5, camera: {orbit: {turns: 0}}}
overlays: {color_bar: bottom-left, legend: top-right}
tissues: {"*": {opacity: 1}, "left ventricle": {color: red}}
YAML
expect 0 '' "$SEGCAST" render ages.yaml -q
[ "$(hashes ages | cut -d ' ' -f 2 | sort -u | wc -l)" = 5 ] || fail "colours do not change in every frame"
expect 0 '' "$SEGCAST" render ages.yaml -o second -q --frames 2 --set color_by.column=age_40 --set 'color_by.range=[0, 10]' \
    --set 'color_by.title=age_20 to age_60'
[ "$(hashes second)" = "$(hashes ages | sed -n 3p)" ] || fail "the picture of a key frame is not that of its column"
mpi 2 "$SEGCAST" render ages.yaml --set farm.partition=tiles -o ages2 -q >/dev/null 2>&1
[ "$(hashes ages2)" = "$(hashes ages)" ] || fail "changing values differ on two ranks"
expect 0 '' "$SEGCAST" render ages.yaml --frames 3 -o alone -q
[ "$(hashes alone)" = "$(hashes ages | sed -n 4p)" ] || fail "a frame alone is not that of the film"
expect 0 '' "$SEGCAST" render ages/job.yaml -o ages3 -q
[ "$(hashes ages3)" = "$(hashes ages)" ] || fail "the job as resolved makes other pictures"
"$SEGCAST" check ages.yaml >said.txt 2>&1 || { cat said.txt; fail "key frames of columns are refused"; }
grep -q 'color_by.column  *0  age_20' said.txt || { cat said.txt; fail "check does not list the key frames"; }
expect 73 'another job' "$SEGCAST" render ages.yaml --resume -q --set 'color_by.column={0%: age_20, 3f: age_40}'
sed -i 's/aorta,n.a,2/aorta,n\/a,3/' ages.csv
expect 73 'another job' "$SEGCAST" render ages.yaml --resume -q
expect 0 '' "$SEGCAST" render ages.yaml --overwrite -q
expect 65 'ages.csv:1: has not exactly one column "age_30"; .*"age_20", "age_40", "age_60"' "$SEGCAST" check ages.yaml \
    --set 'color_by.column={0s: age_20, 100%: age_30}'
one_error
expect 64 'the key frame at 1f does not come after that at 50%' "$SEGCAST" check ages.yaml \
    --set 'color_by.column={50%: age_20, 1f: age_40}'
one_error
expect 64 'column is "age_20", but the values are a measure' "$SEGCAST" check ages.yaml \
    --set 'color_by={values: volume, column: {0s: age_20}}'
one_error
echo 'liver,1,1,1' >>ages.csv
"$SEGCAST" check ages.yaml >said.txt 2>&1 || { cat said.txt; fail "the table was refused"; }
[ "$(grep -c 'ages.csv:5: "liver" is no label' said.txt)" = 1 ] || { cat said.txt; fail "the row without a label is not told once"; }
grep -q '18 of 20 tissues have no value in one of the columns' said.txt || { cat said.txt; fail "tissues without a value are not told"; }

# Mistakes.
expect 65 'values.csv:1: has not exactly one column "thick"; .*"thickness_mm", "change"' "$SEGCAST" check job.yaml --set 'color_by={values: values.csv, column: thick}'
one_error
expect 65 'values.csv:1: has not exactly one column that may hold the values' "$SEGCAST" check job.yaml --set 'color_by={values: values.csv}'
one_error
printf 'aorta,9,9\n' >>values.csv
expect 65 'values.csv:5: is a second row of "aorta" .*, which line 3 has already' "$SEGCAST" check job.yaml "${by[@]}"
one_error
expect 66 'none.csv' "$SEGCAST" check job.yaml --set 'color_by={values: none.csv}'
one_error
