# SPDX-License-Identifier: BSD-3-Clause
# The rulers of tools/fidelity report what is known: voxels waver more than the smooth surface drawn of
# them, outlines as well as seams; and lines of voxels that share faces are whole, one voxel wide, where
# voxels are drawn as cubes, while others fall apart there.
check() { # check FILE FILTER WHAT: the filter must be true of the file
    jq -e "$2" "$1" >/dev/null || fail "$3: $(cat "$1")"
}
"$FIDELITY" --write ball.nrrd ellipsoid || fail 'the voxels of an ellipsoid were not written'
"$SEGCAST" convert phantom:160x112x166 -q -o heart.nrrd || fail 'the heart was not written'
for volume in ball heart; do
    for surface in voxel smooth; do
        "$FIDELITY" --json --surface "$surface" --wobble "$volume.nrrd" >"$volume-$surface.json" ||
            fail "$volume, $surface: the measurement failed"
    done
    # Steps of one voxel on a slope at random: uniformly distributed within a voxel, RMS 0.29, less the
    # part that is longer than 8 voxels.
    check "$volume-voxel.json" '.outline_voxels > 0.15 and .outline_voxels < 0.29' "$volume as voxels"
    check "$volume-smooth.json" '.outline_voxels < 0.1 and .outline_points > 30000' "$volume, smooth"
done
check ball-smooth.json '.outline_voxels < 0.06 and .seam_points == 0 and .seam_voxels == null' 'a ball'
check heart-smooth.json '.seam_points > 300 and .seam_voxels < 0.093 and .outline_voxels < 0.0355' 'a heart'

"$FIDELITY" --json --surface voxel --lines >lines.json || fail 'lines were not measured'
check lines.json '[.lines[] | select(.voxels_share != 1)] == []' 'voxels that do not own their centre'
check lines.json '[.lines[] | select(.lines | test("26-") | not) | select(.pieces != .true_pieces
    or .width_voxels < 0.95 or .width_voxels > 1.4)] == []' 'lines of cubes that share faces'
check lines.json '.lines[] | select(.lines == "diagonal in space, 26-connected") | .pieces == 45' \
    'cubes that share corners'
# Smoothed they are about as wide, and whole where voxels touch in corners, too, but for a helix that runs in and out of
# other tissue: two of its points come off.
"$FIDELITY" --json --smooth auto --lines >lines.json || fail 'smooth lines were not measured'
check lines.json '[.lines[] | select(.voxels_share != 1 or .width_voxels < 0.95 or .width_voxels > 1.26)] == []' \
    'smooth lines are too thin or too wide'
check lines.json '[.lines[] | select(.pieces != .true_pieces) | "\(.lines) \(.pieces - .true_pieces)"]
    == ["helix half in tissue, 26-connected 2"]' 'smooth lines fall apart'

# Sharp edges of thick tissue waver less than their voxels and go back little; gaps stay open; what is thin stays whole
# down to the thick tissue that it grows out of.
"$FIDELITY" --json --smooth 1 --edges >edges.json || fail 'edges were not measured'
while read -r angle retreat wobble; do
    check edges.json ".edges[] | select(.edge == \"wedge of $angle degrees\")
        | .retreat_voxels < $retreat and .wobble_voxels < $wobble" "an edge of $angle degrees"
done <<'TXT'
40 1.1 0.5
70 1.9 0.15
100 1.6 0.15
TXT
check edges.json '.edges[] | select(.edge | test("^gap")) | .voxels_share > 0.984' 'a gap is filled'
check edges.json '.edges[] | select(.edge | test("^sheet")) | .voxels_share == 1' 'what grows out of thick tissue is torn off'

# At strength 0 surfaces depend on few voxels around: crops show the same bits, unless the halo is too small.
for halo in 24 1; do
    "$FIDELITY" --json --smooth 0 --locality "$halo" heart.nrrd >"halo-$halo.json" ||
        fail "the locality was not measured with a halo of $halo"
done
check halo-24.json '.crops == 12 and .points > 1000 and .rays > 10000 and .points_differing == 0
    and .rays_differing == 0' 'crops with a wide halo'
check halo-1.json '.rays_differing > 0' 'crops with a halo of one voxel'
# Smooth surfaces depend on the voxels up to 56 away, wherever a crop begins.
"$FIDELITY" --json --smooth 1 --locality 56 heart.nrrd >halo-56.json || fail 'the locality of smooth borders was not measured'
check halo-56.json '.points > 1000 and .rays > 10000 and .points_differing == 0 and .rays_differing == 0' \
    'smooth crops with a wide halo'

# What is drawn changes evenly with the noise of the voxels and with the strength of smoothing: no rule sets in at once.
"$FIDELITY" --json --smooth 1 --cliffs >cliffs.json || fail 'cliffs were not measured'
check cliffs.json '[.cliffs[] | select(.changing == "noise") | select(.median_voxels > 0.002 and
    .median_voxels < 0.05 and .largest_over_median < 1.5)] | length == 2' 'noise'
check cliffs.json '[.cliffs[] | select(.changing == "strength") | select(.largest_voxels > 0.001 and
    .largest_voxels < 0.015)] | length == 2' 'strength of smoothing'
