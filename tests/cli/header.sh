# SPDX-License-Identifier: BSD-3-Clause
# What the user says of a file beside its header, spacing and axes, or of one without a header: type, size, spacing, axes,
# order of bytes, bytes before them.
"$SEGCAST" convert phantom:40x36x44 -o heart.nrrd -q >/dev/null
at=$(grep -abm1 '^$' heart.nrrd | cut -d : -f 1)
tail -c +$((at + 2)) heart.nrrd | gzip -dc >heart.raw
[ "$(stat -c %s heart.raw)" = $((40 * 36 * 44)) ] || fail "the voxels of the phantom have $(stat -c %s heart.raw) bytes"
labels() { jq '[.size, (.labels | map([.value, .voxels]))]'; }
"$SEGCAST" info heart.nrrd --json -q 2>/dev/null | labels >want.json
same() { # same VOLUME LINE: it has the labels and voxels of the phantom, and its size
    "$SEGCAST" info "$1" --header "$2" --json -q >info.json 2>stderr.txt || { cat stderr.txt >&2; fail "$1, $2: not read"; }
    labels <info.json | diff want.json - >&2 || fail "$1, $2: other labels"
}
same heart.raw 'uint8 40x36x44'
gzip -k heart.raw
same heart.raw.gz 'int8 40x36x44'
{ printf 'HEADER'; cat heart.raw; } >skip.raw
same skip.raw 'skip 6, uint8, 40x36x44, 2x2x2 mm'
gzip -k skip.raw
same skip.raw.gz 'uint8 40x36x44 skip 6'
command -v python3 >/dev/null && {
    python3 -c 'import array, sys
voxels = array.array("H", list(open("heart.raw", "rb").read()))
names = ["little.raw", "big.raw"]
for name in names if sys.byteorder == "little" else reversed(names):
    open(name, "wb").write(voxels.tobytes())
    voxels.byteswap()'
    same little.raw 'uint16 40x36x44'
    same big.raw 'uint16 40x36x44 big'
}

# Spacing, its unit, and axes; a job with the key, its copy, and the same picture as of a header.
"$SEGCAST" info heart.raw --header 'uint8 40x36x44 500x250x1000um PSR' --json -q >info.json
jq -e '.oriented and (.to_ras_mm | map(map(. * 1000 | round)) == [[0, 0, 1000, 0], [-500, 0, 0, 0], [0, 250, 0, 0]])' info.json >/dev/null ||
    { cat info.json; fail "spacing or axes"; }
expect 0 'warning: .*header: gives no spacing' "$SEGCAST" info heart.raw --header 'uint8 40x36x44 RAS'
cat >head.nhdr <<'NRRD'
NRRD0004
type: uint8
dimension: 3
sizes: 40 36 44
space: left-posterior-superior
space directions: (2,0,0) (0,2,0) (0,0,2)
encoding: raw
data file: heart.raw
NRRD
printf 'volume: {path: heart.raw, header: uint8 40x36x44 2x2x2 LPS}\noutput: {size: [64, 48]}\n' >job.yaml
"$SEGCAST" check job.yaml -q | grep -q 'volume of 40 x 36 x 44 voxels with 20 labels' || fail "check of a job with raw voxels"
"$SEGCAST" still job.yaml -o raw.png -q >/dev/null 2>&1
sed 's/^volume.*/volume: head.nhdr/' job.yaml >head.yaml
"$SEGCAST" still head.yaml -o head.png -q >/dev/null 2>&1
cmp raw.png head.png || fail "raw voxels give another picture than the same with a header"
"$SEGCAST" still heart.raw --header 'uint8 40x36x44 2x2x2 LPS' --sheet slices --size 64x48 -o raw-views.png -q >/dev/null
"$SEGCAST" still head.nhdr --sheet slices --size 64x48 -o head-views.png -q >/dev/null
cmp raw-views.png head-views.png || fail "raw voxels give other slices than the same with a header"
"$SEGCAST" render job.yaml --frames 0 -o out -q --set output.video=none --set output.frames=png >/dev/null 2>&1
grep -q 'header: "uint8 40x36x44 2x2x2 LPS"' out/job.yaml || { cat out/job.yaml; fail "job.yaml has left out header"; }

"$SEGCAST" init heart.raw --header 'uint8 40x36x44 2x2x2 LPS' -o init.yaml -q >/dev/null
"$SEGCAST" check init.yaml -q | grep -q 'volume of 40 x 36 x 44 voxels with 20 labels' || { cat init.yaml; fail "check of the job of init"; }

# Spacing and axes of a file with a header: instead of its own, each by itself. The file says 2 x 2 x 2 mm, LPS.
map() { # map LINE WANTED...: to_ras_mm of the volume with that header line, in micrometers
    "$SEGCAST" info heart.nrrd --header "$1" --json -q >info.json || fail "--header '$1'"
    jq -e --argjson wanted "$2" '.to_ras_mm | map(.[:3] | map(. * 1000 | round)) == $wanted' info.json >/dev/null ||
        { jq -c .to_ras_mm info.json; fail "--header '$1': expected $2"; }
}
"$SEGCAST" info heart.nrrd --json -q | jq -c '.to_ras_mm | map(.[:3] | map(. * 1000 | round))' >own.txt
map 'LIP' "$(jq -c '(.[0] | map(fabs) | max) as $a | (.[1] | map(fabs) | max) as $b | (.[2] | map(fabs) | max) as $c | [[-$a, 0, 0], [0, 0, -$c], [0, -$b, 0]]' own.txt)"
map '500x500x2000 um RAS' '[[500, 0, 0], [0, 500, 0], [0, 0, 2000]]'
map '0.5x0.25x2' "$(jq -c '[(.[0][0] | . / fabs * 500), (.[1][1] | . / fabs * 250), (.[2][2] | . / fabs * 2000)] | [[.[0], 0, 0], [0, .[1], 0], [0, 0, .[2]]]' own.txt)"
expect 0 'its voxels are said to measure 0.5 x 0.5 x 2 mm \(.* in the file\)' "$SEGCAST" info heart.nrrd --header '0.5x0.5x2 mm RAS'
printf 'volume: {path: heart.nrrd, header: 1x1x3 mm, box: [[-70, -50, -60], [-40, -20, 20]]}\noutput: {size: [64, 48]}\n' >box.yaml
"$SEGCAST" check box.yaml -q >/dev/null || fail "a box in mm of a volume with another spacing"

# Mistakes.
while read -r line; do
    expect 65 "${line#*; }" "$SEGCAST" info heart.nrrd --header "${line%%; *}"
    one_error
done <<'MISTAKES'
asr; header: "asr" is written as BrainGlobe does.*; here LIP says where they lead
0.5x0.5x0 mm; is no spacing above 0
0.5x0.5 mm; header: "0.5x0.5" is not known
1x1x1 2x2x2; is a second spacing
1x1x1 RAS big; header: "big" is not known
1x1x1 RRS; header: "RRS" is not known
MISTAKES
while read -r code line; do
    expect "$code" "${line#*; }" "$SEGCAST" info heart.raw --header "${line%%; *}"
    one_error
done <<'MISTAKES'
65 uint8 40x36x45; heart.raw: has 63360 bytes, but 40 x 36 x 45 voxels of 1 byte are 64800
65 uint16 40x36x44; are 126720; are type and size of
65 uint8 40x36; header: "40x36" is not known
65 uint8 40x36x-4; header: "40x36x-4" is not known
65 uint8 0x36x44; is no size in voxels
65 uint8 40.5x36x44; is no size in voxels
65 uint7 40x36x44; header: "uint7" is not known; did you mean uint8
65 40x36x44; voxels without a header are described by a line: --header
65 uint8; gives no size
65 uint8 40x36x44 1x1x1parsec; has no known unit
65 uint8 40x36x44 1x1x1 RLS; header: "RLS" is not known
65 uint8 40x36x44 skip; header: "skip" is not known
65 uint8 40x36x44 skip 99999999999999999999; is no number of bytes
65 uint8 40x36x44 1x1x0 mm; is no spacing above 0
65 uint8 2147483647x2147483647x2147483647; more than 1 TiB
MISTAKES
expect 66 'nothing.raw' "$SEGCAST" info nothing.raw --header 'uint8 4x4x4'; one_error
expect 66 'is no file' "$SEGCAST" info . --header 'uint8 4x4x4'; one_error
expect 65 'header: "\\x1b\[31m" is not known' "$SEGCAST" info heart.raw --header $'uint8 40x36x44 \x1b[31m'; one_error
! grep -q $'\x1b' stderr.txt || fail "an escape code is printed"
expect 65 'voxels without a header are described by a line: --header' "$SEGCAST" info heart.raw; one_error
head -c 500 /dev/zero | gzip >bomb.raw.gz
expect 65 'bomb.raw.gz' "$SEGCAST" info bomb.raw.gz --header 'uint8 4000x4000x4000'; one_error
gzip -c heart.raw | head -c 3000 >cut.raw.gz
expect 65 'cut.raw.gz: ends after [0-9]+ bytes of voxels, expected 63360' "$SEGCAST" info cut.raw.gz --header 'uint8 40x36x44'; one_error
