# SPDX-License-Identifier: BSD-3-Clause
# tools/fidelity measures what real segmentations are like: shapes in thick slices, copied up from coarse
# voxels and with noise at their border, and skins one voxel thick. docs/quality.md has the figures.
measure() { "$FIDELITY" --json "$@" >out.json || fail "$*: the measurement failed"; }
check() { # check FILTER WHAT: the filter must be true of the only shape in out.json
    jq -e ".shapes[0] | $1" out.json >/dev/null || fail "$2: $(cat out.json)"
}
# The grid of the drawing is as coarse as the voxels here: terraces and noise are measured for what they are.
while read -r shape position normal; do
    measure --rays 100000 "$shape"
    check ".position_rms_voxels > 0.9 * $position and .position_rms_voxels < 1.1 * $position and .normal_rms_deg > 0.9 * $normal
        and .normal_rms_deg < 1.1 * $normal and .volume_kept > 0.98 and .volume_kept < 1.02 and .gaps == 0 and .hits > 600" "$shape"
done <<'TXT'
torus-6-slices 0.87 21.4
torus-12-noisy 0.36 26.6
TXT

# Normals are those of the body where voxels are higher than wide (6.3 degrees if gradients per reference voxel were
# taken for gradients per voxel).
measure --smooth 1 --rays 100000 ellipsoid-tall
check '.position_rms_voxels < 0.13 and .normal_rms_deg < 1.3 and .volume_kept > 0.99 and .volume_kept < 1.01' \
    'voxels higher than wide'

# Strong smoothing makes large bodies smoother, and leaves thin ones as they are.
measure --smooth 2.5 --rays 100000 ellipsoid
check '.position_rms_voxels < 0.045 and .normal_rms_deg < 0.7 and .volume_kept > 0.995 and .volume_kept < 1.005' \
    'an ellipsoid, smoothed strongly'
for shape in torus-3 torus-1.5; do
    measure --smooth 2.5 --rays 100000 $shape
    check '.position_rms_voxels < 0.12 and .normal_rms_deg < 4 and .volume_kept > 0.98 and .volume_kept < 1.06
        and .gaps == 0' "$shape, smoothed strongly"
done

# Errors are given in voxels within a slice, or in voxels before they were copied up: an error of about
# 0.28 voxels is that of the voxels themselves.
measure --surface voxel --rays 100000 torus-12-copied
check '.position_rms_voxels > 0.25 and .position_rms_voxels < 0.31' 'copied up: not in coarse voxels'

# Whatever the strength of the smoothing, no ray gets through a skin one voxel thick, and nearly all that meet the
# body have to pass it. FIDELITY_STRENGTHS="0 0.5 1 1.25 2.5 auto" tries more of them on every skin.
skin() { # skin NAME STRENGTH...
    local name=$1 strength
    shift
    for strength in ${FIDELITY_STRENGTHS:-$@}; do
        measure --smooth "$strength" --rays 20000 "$name"
        check '.leaks_per_million == 0 and .rays_through > 3000 and .rays_through > 0.8 * .hits
            and .rays_through <= .hits' "$name at smooth $strength"
    done
}
for name in skin-ellipsoid skin-balls skin-planes; do
    skin $name auto
    skin $name-slices auto
done
skin skin-rough 0 1 2.5 auto
skin skin-rough-slices 0 auto
# The skin of a file, and a tissue named as the skin: rays that meet voxels of something else before are left out.
"$FIDELITY" --write skin.nrrd skin-ellipsoid || fail 'the voxels of a skin were not written'
measure --smooth 0 --rays 20000 --skin 3 skin.nrrd
check '.leaks_per_million == 0 and .rays_through > 2000 and .rays_without_skin == 0' 'the skin of a file'
measure --smooth 0 --rays 20000 --skin 1 skin.nrrd
check '.rays_through == 0 and .hits == 0 and .rays_without_skin > 2000' 'a tissue that is no skin'
"$FIDELITY" --skin 9 skin.nrrd >/dev/null 2>none.txt && fail 'a label that is not there was accepted'
grep -q 'no label 9' none.txt || fail "unexpected message for a label that is not there: $(cat none.txt)"
