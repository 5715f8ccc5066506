# SPDX-License-Identifier: BSD-3-Clause
# Smooth surfaces, drawn with the default settings, are compared with the true surfaces of closed shapes: fine, in
# thick slices, copied up from coarse voxels, and with noise. They are the same to the last bit everywhere, so each is
# allowed 3 % more than was measured when the table was made: whoever changes how surfaces are found sees what gets
# worse. Rows that get better are renewed. tools/fidelity prints the whole table.
worse=()
while read -r shape position silhouette most normal volume; do # RMS and most in voxels, degrees, % too much
    "$FIDELITY" --json --smooth auto "$shape" >"$shape.json" || fail "$shape: the measurement failed"
    jq -e --argjson p "$position" --argjson s "$silhouette" --argjson m "$most" --argjson n "$normal" --argjson v "${volume#+}" '.shapes[0]
        | .position_rms_voxels <= 1.03 * $p and .silhouette_voxels <= 1.03 * $s and .position_max_voxels <= 1.1 * $m
        and .normal_rms_deg <= 1.03 * $n and (100 * .volume_kept - 100 | fabs) <= ($v | fabs) + 0.2
        and .owner_errors_per_million < 200 and (.gaps // 0) == 0 and .hits > 600' "$shape.json" >/dev/null ||
        worse+=("$(jq -c '.shapes[0]' "$shape.json")")
done <<'TXT'
ellipsoid        0.0252 0.0211 0.229 0.41 -0.07
torus-6          0.0389 0.0319 0.203 0.80 -0.58
torus-3          0.0455 0.0334 0.435 1.17 +0.19
torus-1.5        0.0955 0.0856 0.478 3.50 +1.65
torus-1          0.1397 0.1136 0.515 5.81 +2.21
ellipsoid-slices 0.1459 0.0636 1.329 0.77 -0.21
torus-18-slices  0.1286 0.0728 0.959 1.82 -0.33
torus-12-slices  0.1626 0.0979 1.547 2.71 -0.48
torus-6-slices   0.2920 0.1995 1.395 4.30 -2.23
torus-12-copied  0.0664 0.0620 0.221 2.31 +0.43
torus-18-noisy   0.1185 0.1105 1.253 3.01 +0.50
torus-12-noisy   0.1851 0.1655 1.003 5.03 +0.47
TXT
[ ${#worse[@]} = 0 ] || fail "worse than in the table: ${worse[*]}"

# Meshes are measured in the same way: an octahedron is far from an ellipsoid.
cat >octahedron.ply <<'E'
ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
element face 8
property list uchar int vertex_indices
end_header
119.3 72.13 71.71
23.3 72.13 71.71
71.3 120.13 71.71
71.3 24.13 71.71
71.3 72.13 119.71
71.3 72.13 23.71
3 0 2 4
3 2 1 4
3 1 3 4
3 3 0 4
3 2 0 5
3 1 2 5
3 3 1 5
3 0 3 5
E
"$FIDELITY" --json --mesh octahedron.ply ellipsoid >octahedron.json || fail "the mesh was refused"
jq -e '.shapes[0] | .volume_kept > 0.24 and .volume_kept < 0.27 and .position_rms_voxels > 10' \
    octahedron.json >/dev/null || fail "the mesh was measured wrongly: $(cat octahedron.json)"
printf 'solid nothing' >broken.stl
"$FIDELITY" --mesh broken.stl ellipsoid >/dev/null 2>broken.txt && fail "a damaged mesh was accepted"
grep -q 'expected a PLY or a binary STL' broken.txt || fail "unexpected message for a damaged mesh: $(cat broken.txt)"
