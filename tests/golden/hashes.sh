# SPDX-License-Identifier: BSD-3-Clause
# Seven frames have these very bits on every processor: x86-64 in each instruction set, and arm64 (tools/arm64-check).
# After a change of pictures that is meant, GOLDEN_UPDATE=1 writes the new hashes into this file.
declare -A expected=(
    [smooth]=c192feba5ae1950e
    [voxel]=815cad2d1ef1ae10
    [parallel]=8119e21cb4d320db
    [clear]=cd585e19642d5d1a
    [shadows]=918aafb929094cc2
    [global]=370e7119d9b98e39
    [path]=6386f5a775822e9d
)
declare -A settings=(
    [smooth]=render.quality=film
    [voxel]=render.surface=voxel
    [parallel]=animation.camera.projection=orthographic
    [clear]=render.background=none
    [shadows]=light.shadows=true
    [global]=light.method=global
    [path]=light.method=path
)
read -ra cpus <<<"${HASHES_CPUS:-auto}"
small_job job.yaml
[ -n "${GOLDEN_UPDATE:-}" ] || [ "$(printf '%s\n' "${expected[@]}" | sort -u | wc -l)" = 7 ] || fail "two frames have the same hash"
for kind in smooth voxel parallel clear shadows global path; do
    for cpu in "${cpus[@]}"; do
        "$SEGCAST" render job.yaml -o "$kind-$cpu" -q --frames 3 --cpu "$cpu" --set "${settings[$kind]}" >/dev/null 2>&1
        hash=$(hashes "$kind-$cpu" | cut -d' ' -f2)
        if [ -n "${GOLDEN_UPDATE:-}" ]; then
            sed -i "s/^    \[$kind\]=[0-9a-f]*$/    [$kind]=$hash/" "$SOURCE/tests/golden/hashes.sh"
        elif [ "$hash" != "${expected[$kind]}" ]; then
            fail "the frame $kind has the hash $hash by --cpu $cpu, expected ${expected[$kind]}"
        fi
    done
done
