# SPDX-License-Identifier: BSD-3-Clause
# Each frame has the same hash for any number of ranks and threads, any partition, tile size and skip
# method, and with the plain C kernels or the fastest ones; for both surface models, with the three views,
# without a background, and while tissues fade and verbs move the camera.
small_job job.yaml
kinds=(smooth voxel views clear fading)
settings=(render.surface=smooth render.surface=voxel animation.slices=through render.background=none
    'animation.verbs=[{fade: "*", to: 70%, during: [0%, 0%]}, {fade: "*", to: 0, during: [10%, 90%]},
        {frame: aorta, during: [20%, 60%], ease: [0.6, 0, 0.2, 1]}, {rock: 30, elevation: 100}, {hold: orbit, during: [30%, 50%]}]')
for i in 0 1 2 3 4; do
    OMP_NUM_THREADS=1 "$SEGCAST" render job.yaml -o "${kinds[i]}" -q --set "${settings[i]}" >/dev/null
    [ "$(hashes "${kinds[i]}" | wc -l)" = 7 ] || fail "${kinds[i]}: the manifest does not name 7 frames"
    [ "$(hashes "${kinds[i]}" | cut -d' ' -f2 | sort -u | wc -l)" = 7 ] || fail "${kinds[i]}: frames repeat"
done
[ "$(cat smooth/manifest.jsonl voxel/manifest.jsonl views/manifest.jsonl clear/manifest.jsonl fading/manifest.jsonl |
    jq -r 'select(.frame != null).hash' | sort -u | wc -l)" = 35 ] || fail "different pictures have the same hash"
partitions=(auto frames tiles)
n=0
# Of the numbers of threads, each combination is drawn with one; HASHES_THREADS=3 draws it with all three.
for ranks in 1 2 4; do
    for turn in $(seq "${HASHES_THREADS:-1}"); do
        for skip in none interior octree proximity chessboard leap; do
            n=$((n + 1)) threads=$(((n + turn + n / 6) % 3 + 1))
            kind=${kinds[(n + n / 5) % 5]} setting=${settings[(n + n / 5) % 5]}
            cache=$SEGCAST_CACHE
            [ "$ranks" = 2 ] && kind=smooth setting=render.surface=smooth cache=off # both prepare
            SEGCAST_CACHE=$cache OMP_NUM_THREADS=$threads mpi "$ranks" "$SEGCAST" render job.yaml -o "run$n" -q \
                --set render.skip=$skip --cpu "$([ $(((n + n / 6) % 2)) = 0 ] && echo c || echo auto)" --set farm.tile=$((8 + 13 * n % 120)) \
                --set farm.share=$([ $((n / 2 % 2)) = 0 ] && echo true || echo false) \
                --set "farm.partition=${partitions[(n + n / 9) % 3]}" --set "$setting" >/dev/null
            [ "$(hashes "$kind")" = "$(hashes "run$n")" ] ||
                fail "the pictures differ with $ranks ranks, $threads threads, $skip, $kind"
            jq -e ".ranks == $ranks and .threads == $threads and .nodes == 1 and
                (.memory.peak_rss_bytes | length) == $ranks" "run$n/stats.json" >/dev/null ||
                fail "stats.json of run$n"
        done
    done
done

# There may be more ranks than frames. A video made by several ranks, whoever encodes it, is the same
# byte for byte as that of one rank; so are the PNG files.
mpi 5 "$SEGCAST" render job.yaml -o few --frames 2-3 -q >/dev/null
[ "$(hashes few)" = "$(hashes smooth | sed -n '3,4p')" ] || fail "the pictures differ with more ranks than frames"
video=(--set output.video=v.mp4 --set output.fps=2 --set output.frames=png)
"$SEGCAST" render job.yaml -o v1 -q "${video[@]}" >/dev/null
for run in 1segments 3rank0 3segments 3gather 3auto; do
    mpi ${run:0:1} "$SEGCAST" render job.yaml -o v$run -q "${video[@]}" --set farm.encode=${run:1} >/dev/null
    cmp v1/v.mp4 v$run/v.mp4 || fail "the video depends on ranks or on who encodes"
    diff -r v1/frames v$run/frames || fail "PNG files depend on who writes them"
done
clear=(--set output.video=v.mov --set output.fps=2 --set render.background=none)
for encode in rank0 segments gather; do
    mpi 3 "$SEGCAST" render job.yaml -o c$encode -q "${clear[@]}" --set farm.encode=$encode >/dev/null
    cmp crank0/v.mov c$encode/v.mov || fail "the transparent video depends on who encodes"
done

# Values by key frames are the same on all ranks, with all kernels.
keyframes=("$SOURCE/jobs/keyframes.yaml" -q --set volume=phantom:59x41x61 --set 'output.size=[96, 54]' --set output.video=none
    --set animation.frames=7)
"$SEGCAST" render "${keyframes[@]}" -o keyed >/dev/null
for cpu in c auto; do
    mpi 2 "$SEGCAST" render "${keyframes[@]}" -o keyed-$cpu --cpu $cpu --set farm.partition=tiles --set render.skip=none >/dev/null
    [ "$(hashes keyed)" = "$(hashes keyed-$cpu)" ] || fail "key frames: the pictures differ with two ranks, $cpu"
done

# A grey volume behind the tissues, with a background and without.
behind=("$SOURCE/jobs/heart-backdrop.yaml" -q --set volume=phantom:59x41x61 --set image.path=phantom:60x40x50 --set 'output.size=[96, 54]'
    --set output.video=none --set animation.frames=7 --set light.depth_cue=0.3)
for background in black none; do
    OMP_NUM_THREADS=1 "$SEGCAST" render "${behind[@]}" -o behind-$background --set render.background=$background >/dev/null
done
n=0
for skip in none interior octree proximity chessboard leap; do
    n=$((n + 1)) background=$([ $((n % 2)) = 0 ] && echo black || echo none)
    OMP_NUM_THREADS=$((1 + n % 3)) mpi $((1 + n % 4)) "$SEGCAST" render "${behind[@]}" -o by-$skip --set render.background=$background \
        --cpu "$([ $((n / 2 % 2)) = 0 ] && echo c || echo auto)" --set farm.tile=$((8 + 13 * n)) \
        --set "farm.partition=${partitions[n % 3]}" --set render.skip=$skip >/dev/null
    [ "$(hashes behind-$background)" = "$(hashes by-$skip)" ] || fail "backdrop: the pictures differ by $skip, $background"
done
