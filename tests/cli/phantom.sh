# SPDX-License-Identifier: BSD-3-Clause
# The synthetic heart as files: whole, and as the phases of its beat.

"$SEGCAST" convert phantom:40x30x42 -o still.nrrd -q >/dev/null
"$SEGCAST" convert phantom:40x30x42 --beating 12 -o beat.nrrd -q >said.txt
printf 'beat-%02d.nrrd\n' {0..11} | diff - said.txt || fail "the files that are named"
[ "$(ls beat-*.nrrd | wc -l)" = 12 ] || fail "not one file for each phase: $(ls)"
cmp still.nrrd beat-00.nrrd || fail "the beat does not begin with the heart at rest"
cmp -s beat-00.nrrd beat-05.nrrd && fail "the heart does not beat"
"$SEGCAST" convert phantom:8x8x8 --beating 101 -o many.nrrd -q >said.txt
grep -qx many-000.nrrd said.txt && grep -qx many-100.nrrd said.txt || fail "names of more than 100 phases do not sort"

# Only labels are told to be a volume to film.
"$SEGCAST" convert phantom:24x18x24 --beating 2 -o labels.nrrd >said.txt 2>&1
grep -q 'these are the phases of a beat' said.txt || fail "it is not told how phases are filmed"
"$SEGCAST" convert phantom:24x18x24 --beating 2 --ct -o grey.nrrd >said.txt 2>&1
! grep 'films them' said.txt || fail "an image is told to be a volume to film"

# Nothing is replaced, and nothing is begun where one of the files is in the way.
rm beat-0[0-6].nrrd
before=$(sha256sum beat-*)
expect 73 'beat-07.nrrd' "$SEGCAST" convert phantom:40x30x42 --beating 12 -o beat.nrrd
[ "$(sha256sum beat-*)" = "$before" ] || fail "files were made or changed beside one in the way"
expect 64 'beating' "$SEGCAST" convert phantom:40x30x42 --beating 0 -o no.nrrd
