# SPDX-License-Identifier: BSD-3-Clause
# segcast convert prints centre lines of vessels: as CSV and JSON, from a file or a prepared one, and refuses what has none.
"$SEGCAST" convert phantom:118x82x122 -o heart.nrrd -q >/dev/null
"$SEGCAST" convert heart.nrrd --tissue 'superior vena cava' -q -o - >svc.csv
[ "$(head -1 svc.csv)" = x_mm,y_mm,z_mm,radius_mm ] || fail "the first line is $(head -1 svc.csv)"
awk -F, 'NR > 1 && (NF != 4 || $4 < 5 || $4 > 12 || $1 < 25 || $1 > 42 || $3 < 10 || $3 > 82) {bad = 1}
    NR == 2 {top = $3} END {exit bad || NR < 20 || top < $3}' svc.csv ||
    { cat svc.csv; fail "the line is not that of the superior vena cava, from above"; }

# By the number of the label, from a prepared file, with any number of threads: the same bytes.
"$SEGCAST" convert heart.nrrd -o heart.segc -q >/dev/null
for words in 'heart.nrrd --tissue 13' 'heart.segc --tissue 13' 'heart.nrrd --tissue 13 --threads 3'; do
    # shellcheck disable=SC2086 # a list of words
    "$SEGCAST" convert $words -q -o - | diff svc.csv - >&2 || fail "the line of $words differs"
done
"$SEGCAST" convert heart.nrrd --tissue 13 -q -o line.json >/dev/null
jq -r '.points[] | map(tostring) | join(",")' line.json |
    awk -F, 'NR == FNR {n++; next} {m++} END {exit n != m + 1}' svc.csv - || fail "JSON has not as many points"

# Between points; files are replaced only if that is asked for.
[ "$("$SEGCAST" convert heart.nrrd --tissue aorta --begin 13,7,42 --end=-24,-43,5 -o arch.csv -q)" = arch.csv ] || fail "the path of the file was not printed"
awk -F, 'NR > 1 && $3 < 0 {bad = 1} END {exit bad}' arch.csv || fail "the line of the arch leaves it"
expect 73 'arch.csv' "$SEGCAST" convert heart.nrrd --tissue aorta -o arch.csv; one_error
"$SEGCAST" convert heart.nrrd --tissue aorta -o arch.csv --overwrite -q >/dev/null
"$SEGCAST" convert heart.nrrd --tissue 'superior vena cava,right atrium' -q -o - >both.csv
[ "$(wc -l <both.csv)" -gt "$(wc -l <svc.csv)" ] || fail "the line through two tissues is not longer"

# From middle to middle: the line begins and ends where the tissues are thickest, within 2 mm.
"$SEGCAST" convert heart.nrrd --tissue 'left ventricle,left atrium' --middles -q -o - >middles.csv
"$SEGCAST" convert heart.nrrd --tissue 'left atrium,left ventricle' --middles -q -o - >back.csv
awk -F, 'FNR == 1 {next} NR == FNR {if (!n++) {x = $1; y = $2; z = $3} next} {X = $1; Y = $2; Z = $3}
    END {exit (x - X) ^ 2 + (y - Y) ^ 2 + (z - Z) ^ 2 > 4}' middles.csv back.csv || fail "the way back does not end where the way there begins"

# Mistakes.
expect 64 'no tissue: give one as --tissue NAME' "$SEGCAST" convert heart.nrrd --middles -o -; one_error
expect 64 'expected a point in RAS mm' "$SEGCAST" convert heart.nrrd --tissue aorta --begin 1,2 -o -; one_error
expect 64 'needs --begin' "$SEGCAST" convert heart.nrrd --tissue aorta --end 1,2,3 -o -; one_error
expect 64 '.--middles needs two tissues' "$SEGCAST" convert heart.nrrd --tissue aorta --middles -o -; one_error
expect 64 '.--middles and --begin both say' "$SEGCAST" convert heart.nrrd --tissue aorta,15 --middles --begin 1,2,3 -o -; one_error
expect 65 'did you mean "aorta"' "$SEGCAST" convert heart.nrrd --tissue aorte -o -; one_error
expect 65 'lies outside of "aorta"; the nearest place in it is' "$SEGCAST" convert heart.nrrd --tissue aorta --begin 60,0,0 -o -; one_error
expect 65 'there is no way within "coronary arteries"' "$SEGCAST" convert heart.nrrd --tissue 'coronary arteries' --begin 37.8,20.5,-8.6 --end=-35.1,33.7,-18 -o -; one_error
expect 65 'do not touch one another.* mm before "right ventricle" at' "$SEGCAST" convert heart.nrrd --tissue 'superior vena cava,right atrium,right ventricle' -o -; one_error
expect 66 'nothing.nrrd' "$SEGCAST" convert nothing.nrrd --tissue aorta -o -; one_error
