# SPDX-License-Identifier: BSD-3-Clause
# tools/fidelity --against: a volume against itself is as far from it as voxels are from a surface, or
# nothing where both are drawn alike; a known shift is measured as such.
against() { "$FIDELITY" --json "$@" >out.json || fail "$*: the comparison failed"; }
check() { # check FILTER WHAT: the filter must be true of the summary of large tissues
    jq -e ".large | $1" out.json >/dev/null || fail "$2: $(cat out.json)"
}
"$FIDELITY" --write torus.nrrd torus-6 || fail 'the voxels of a torus were not written'
against --truth 1 --against torus.nrrd torus.nrrd
check '.tissues == 1 and .max_mm < 0.01 and .volume_kept > 0.98 and .volume_kept < 1.02
    and .points > 10000' 'against itself, both drawn'
against --surface voxel --against torus.nrrd torus.nrrd
check '.rms_to_truth_mm < 0.001 and .rms_from_truth_mm < 0.2 and .volume_kept == 1' 'against itself, voxels'
against --against torus.nrrd torus.nrrd
check '.rms_mm > 0.1 and .rms_mm < 0.2 and .volume_kept > 0.98 and .volume_kept < 1.02' 'drawn against voxels'

# The same moved by 2 mm along x. Where the normal n of a torus is at random, the mean square of the
# distance is about the shift's, times the mean of n_x squared: here between 1/4 and 1/2 of it.
sed '1,/^$/s/^space origin: ([^,]*,/space origin: (2,/' torus.nrrd >moved.nrrd
head -c 1000 moved.nrrd | grep -aq '^space origin: (2,0,0)' || fail 'the origin was not moved'
against --truth 1 --against torus.nrrd moved.nrrd
check '.max_mm > 1.9 and .max_mm < 2.1 and .rms_mm > 1 and .rms_mm < 1.42 and .volume_kept > 0.98
    and .volume_kept < 1.02' 'moved by 2 mm'

# A label that is not there, and volumes with nothing in common.
"$FIDELITY" --write skin.nrrd skin-ellipsoid || fail 'the voxels of a skin were not written'
against --against skin.nrrd torus.nrrd
jq -e '[.tissues[] | select(.label == 3)] | .[0].rms_mm == null' out.json >/dev/null ||
    fail "a label that is not there was measured: $(cat out.json)"
sed '1,/^$/s/^space origin: ([^,]*,/space origin: (5000,/' torus.nrrd >far.nrrd
"$FIDELITY" --against torus.nrrd far.nrrd >/dev/null 2>far.txt && fail 'volumes apart were compared'
grep -q 'no space in common' far.txt || fail "unexpected message for volumes apart: $(cat far.txt)"
