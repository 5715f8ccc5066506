# SPDX-License-Identifier: BSD-3-Clause
# A build with other compiler flags draws the same pictures, bit by bit, as the release build beside it.
# Compilers may fuse a multiplication with an addition where the processor can (-march=x86-64-v3):
# the build has to keep them from doing so.
release=$SOURCE/build/release/segcast
[ -x "$release" ] || skip "there is no release build in $SOURCE/build/release"
read -ra cpus < <("$release" help keys render.cpu --json | jq -r '.[0].values | gsub(" or|,"; "")')
[ "${cpus[0]}" = auto ] || fail "found no variants in the values of render.cpu"
small_job job.yaml # drawn larger below: a change in the last bit of a float rarely reaches a level of 8 bits
drawn=0
for surface in smooth voxel; do
    for kernel in none-auto octree-auto proximity-auto chessboard-auto "${cpus[@]/#/leap-}"; do
        settings=(--set render.surface=$surface --set "render.skip=${kernel%-*}" --set "render.cpu=${kernel#*-}" --set animation.frames=3 --set output.size=[400,300])
        name=$surface-$kernel
        "$release" render job.yaml -o "$name-release" -q "${settings[@]}" >/dev/null 2>&1 || continue # this processor cannot run the variant
        if ! "$SEGCAST" render job.yaml -o "$name" -q "${settings[@]}" >/dev/null 2>log; then
            grep -q 'was built without kernels for' log && continue
            cat log
            fail "$name: this build cannot draw it"
        fi
        drawn=$((drawn + 1))
        [ "$(hashes "$name" | wc -l)" = 3 ] || fail "$name: expected 3 frames, found $(hashes "$name" | wc -l)"
        [ "$(hashes "$name")" = "$(hashes "$name-release")" ] ||
            fail "$name: the frames differ from those of the release build"
    done
    [ -e "$surface-leap-c/manifest.jsonl" ] || fail "$surface: the release build drew nothing"
done
# Of each surface: four methods of skipping, plain C, and at least one variant of leap.
[ "$drawn" -ge 12 ] || fail "this build drew only $drawn of the videos"
