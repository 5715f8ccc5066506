# SPDX-License-Identifier: BSD-3-Clause
# A prepared file gives the same pictures as the volume. Where the job hides other tissues or needs other
# settings, it is prepared again or refused with the reason. A damaged file is refused.
"$SEGCAST" convert phantom:79x55x81 -o heart.nrrd -q >/dev/null
"$SEGCAST" convert heart.nrrd -o heart.segc -q >/dev/null
job() { # job VOLUME [TISSUES]: print a job
    printf 'volume: %s\noutput: {size: [160, 120]}\nanimation: {frames: 4}\n' "$1"
    [ $# -lt 2 ] || printf 'tissues: %s\n' "$2"
}
same() { # same A B WHAT: two pictures are equal
    "$IMAGE_DIFFERENCE" "$1" "$2" 0 0 || fail "$3: the pictures differ"
}
hidden='{"epicardial fat": {visible: false}, "*myocardium*": {opacity: 0.4}}'

job heart.nrrd >plain.yaml
job heart.segc >mapped.yaml
job heart.nrrd "$hidden" >plain-hidden.yaml
job heart.segc "$hidden" >mapped-hidden.yaml
for kind in "" -hidden; do
    "$SEGCAST" still "plain$kind.yaml" --frame 1 -o "plain$kind.png" -q >/dev/null
    "$SEGCAST" still "mapped$kind.yaml" --frame 1 -o "mapped$kind.png" >/dev/null 2>log.txt ||
        fail "mapped$kind.yaml: $(cat log.txt)"
    same "plain$kind.png" "mapped$kind.png" "mapped$kind"
done
grep -q "heart.segc: was prepared with tissues that the job hides" log.txt || fail "no message that the job hides tissues of the prepared file: $(cat log.txt)"

# What a file stores for drawing was made for other opacities, surfaces or skip methods.
job heart.nrrd '{"*myocardium*": {opacity: 0.4}, "*ventricle*": {opacity: 0.1}}' >plain-other.yaml
job heart.segc '{"*myocardium*": {opacity: 0.4}, "*ventricle*": {opacity: 0.1}}' >mapped-other.yaml
for setting in light.occlusion=1 render.surface=voxel render.skip=octree render.skip=interior light.shadows=true; do
    sampled || continue
    "$SEGCAST" still plain-other.yaml --set "$setting" -o a.png --overwrite -q >/dev/null
    "$SEGCAST" still mapped-other.yaml --set "$setting" -o b.png --overwrite -q >/dev/null 2>&1
    same a.png b.png "other opacities, $setting"
done

# Colours that the job wants instead of those with which the file was prepared.
for appearance in anatomy distinct; do
    "$SEGCAST" still plain.yaml --frame 1 --set appearance=$appearance -o a.png --overwrite -q >/dev/null
    "$SEGCAST" still mapped.yaml --frame 1 --set appearance=$appearance -o b.png --overwrite -q >/dev/null
    same a.png b.png "appearance: $appearance"
    ! cmp -s a.png plain.png || fail "appearance: $appearance: the colours are those of the table"
done

# A file of an earlier version is refused, with what to do.
cp "$SOURCE/tests/data/version-9.segc" old.segc
job old.segc >old.yaml
! "$SEGCAST" still old.yaml -o old.png >/dev/null 2>log.txt || fail "a file of version 9 was read"
grep -q "version 9, this segcast reads version 11; prepare it again" log.txt || fail "a file of version 9: $(cat log.txt)"

# A file that was prepared for a job needs no warning.
"$SEGCAST" convert plain-hidden.yaml -o hidden.segc -q >/dev/null
job hidden.segc "$hidden" >fits.yaml
"$SEGCAST" still fits.yaml --frame 1 -o fits.png >/dev/null 2>log.txt
same plain-hidden.png fits.png fits
! grep -q warning log.txt || fail "an unexpected warning: $(cat log.txt)"
# A tissue that was hidden when the file was prepared cannot be shown.
job hidden.segc >lacks.yaml
refused() { # refused CODE PATTERN ARGUMENT...: segcast exits with CODE and a message like PATTERN
    local code=$1 pattern=$2 got=0
    shift 2
    "$SEGCAST" "$@" >/dev/null 2>log.txt || got=$?
    [ "$got" = "$code" ] || fail "$*: exit code $got, expected $code: $(cat log.txt)"
    grep -q "$pattern" log.txt || fail "$*: expected a message like \"$pattern\", found: $(cat log.txt)"
}
refused 65 'was prepared without "epicardial fat"' check lacks.yaml
refused 64 'is a prepared file already' convert mapped.yaml -o again.segc
refused 64 'has no option --frame; these commands have: still' convert heart.nrrd --frame 3

# With other settings than the file was prepared with, it is prepared again.
for setting in render.smooth=0.5 'render.smooth=[1, 1, 2]' 'tissues."*myocardium*".smooth=0.5' render.auto_opacity=local \
    render.surface=voxel volume.resample=40x60x41 volume.resample=79x55x81; do
    sampled || continue
    "$SEGCAST" still plain.yaml --set "$setting" -o a.png --overwrite -q >/dev/null
    "$SEGCAST" still mapped.yaml --set "$setting" -o b.png --overwrite -q >/dev/null 2>&1
    same a.png b.png "$setting"
done
# A file holds the strength of each tissue, and fits a job that has the same.
mixed='{"*myocardium*": {smooth: 0.5}, aorta: {smooth: [1, 1, 2]}}'
job heart.nrrd "$mixed" >plain-mixed.yaml
"$SEGCAST" convert plain-mixed.yaml -o mixed.segc -q >/dev/null
"$SEGCAST" still plain-mixed.yaml --frame 1 -o plain-mixed.png -q >/dev/null
job mixed.segc "$mixed" >fits.yaml
"$SEGCAST" still fits.yaml --frame 1 -o fits.png --overwrite >/dev/null 2>log.txt
same plain-mixed.png fits.png 'strengths of tissues'
! grep -q warning log.txt || fail "an unexpected warning: $(cat log.txt)"
"$IMAGE_DIFFERENCE" plain.png fits.png 0 0 2>/dev/null >&2 && fail 'strengths of tissues do not change the picture'
job mixed.segc >lacks.yaml
"$SEGCAST" check lacks.yaml >/dev/null 2>log.txt
grep -q 'was prepared with another strength of smoothing' log.txt || fail "strengths that differ are not told: $(cat log.txt)"
"$SEGCAST" info heart.nrrd --json | grep -v '"file"' | jq '.label_table = null' >a.json # a prepared file keeps no table
"$SEGCAST" info heart.segc --json | grep -v '"file"' | jq . >b.json
cmp a.json b.json || fail "info of the prepared file differs: $(diff a.json b.json)"

# A file notes that its grid is the one on which the volume was drawn, so that it is not measured again; but not
# where memory was too little to bring thick slices to that grid.
sed '/^space directions/s/.*/space directions: (1,0,0) (0,1,0) (0,0,4)/' heart.nrrd >thick.nrrd
"$SEGCAST" convert thick.nrrd -o thick.segc --max-memory 4M >/dev/null 2>log.txt
grep -q 'leaves no room for layers' log.txt || fail "4 MB are enough for layers: $(cat log.txt)"
job thick.segc >thick.yaml
"$SEGCAST" check thick.yaml >/dev/null 2>log.txt
grep -q 'was prepared with another grid of voxels' log.txt || fail "thick slices are taken for the drawn grid: $(cat log.txt)"
# What a file with other layers holds is told as it is, without preparing it anew.
"$SEGCAST" convert thick.nrrd -o layers.segc -q >/dev/null
"$SEGCAST" info layers.segc --json >layers.json 2>log.txt
! grep -q 'prepared with' log.txt || fail "info prepares a prepared file anew: $(cat log.txt)"
[ "$(jq '.size[2]' layers.json)" -gt "$("$SEGCAST" info thick.nrrd --json 2>/dev/null | jq '.size[2]')" ] ||
    fail "layers.segc has no layers: $(jq -c .size layers.json)"

# Any damage is found by the hashes in the file.
size=$(wc -c <heart.segc)
for at in 9 13 30 60 100 "$((size / 2))" "$((size - 2000))"; do
    cp heart.segc bad.segc
    printf '\377\376' | dd of=bad.segc bs=1 seek="$at" conv=notrunc 2>/dev/null
    job bad.segc >bad.yaml
    got=0
    "$SEGCAST" check bad.yaml >/dev/null 2>log.txt || got=$?
    # the bytes behind the last section are not used, so that a change there is no damage
    if cmp -s heart.segc bad.segc; then continue; fi
    [ "$got" = 65 ] && grep -q "bad.segc: " log.txt || fail "byte $at was changed: exit code $got, expected 65: $(cat log.txt)"
done
for bytes in 8 100 300 "$((size / 3))" "$((size - 1))"; do
    head -c "$bytes" heart.segc >bad.segc
    refused 65 'bad.segc: ' check bad.yaml
done
cp heart.segc bad.segc
printf '\001\002\003\004' | dd of=bad.segc bs=1 seek=12 conv=notrunc 2>/dev/null
refused 65 'another order of bytes' check bad.yaml
