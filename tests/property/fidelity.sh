# SPDX-License-Identifier: BSD-3-Clause
# Smooth surfaces, drawn with the default settings, are compared with the true surfaces of closed shapes
# and stay within bounds for position, normals and volume. tools/fidelity prints the whole table.
bound() { # bound SHAPE POSITION_VOXELS NORMAL_DEG LEAST_VOLUME MOST_VOLUME
    "$FIDELITY" --json "$1" >"$1.json" || fail "$1: the measurement failed"
    jq -e --argjson p "$2" --argjson n "$3" --argjson low "$4" --argjson high "$5" '.shapes[0]
        | .position_rms_voxels <= $p and .normal_rms_deg <= $n and .volume_kept >= $low
        and .volume_kept <= $high and .owner_errors_per_million < 100 and (.gaps // 0) == 0
        and .hits > 1000' "$1.json" >/dev/null || fail "$1: beyond the bounds: $(cat "$1.json")"
}
bound ellipsoid 0.04 0.7 0.99 1.01
bound torus-6 0.06 0.8 0.98 1.02
bound torus-3 0.07 1.7 0.98 1.02
bound torus-1.5 0.13 4.2 0.95 1.05
bound torus-1 0.18 7.5 0.92 1.08

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
