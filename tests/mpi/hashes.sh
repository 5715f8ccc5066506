# The crown: every frame's hash is the same for any number of ranks and threads, any size of tiles,
# any skip method and plain C kernels or the best ones; for each surface, and for slices beside the picture.
small_job job.yaml
kinds=(smooth voxel views)
settings=(render.surface=smooth render.surface=voxel output.layout=views)
for i in 0 1 2; do
    OMP_NUM_THREADS=1 "$SEGCAST" render job.yaml -o "${kinds[i]}" -q --set "${settings[i]}" >/dev/null
    [ "$(hashes "${kinds[i]}" | wc -l)" = 7 ] || fail "7 frames"
    [ "$(hashes "${kinds[i]}" | cut -d' ' -f2 | sort -u | wc -l)" = 7 ] || fail "frames repeat"
done
[ "$(cat smooth/manifest.jsonl voxel/manifest.jsonl views/manifest.jsonl |
    jq -r '.hash // empty' | sort -u | wc -l)" = 21 ] || fail "different pictures have the same hash"
n=0
for ranks in 1 2 3 5; do
    for threads in 1 2 3; do
        for skip in none interior leap; do
            n=$((n + 1))
            kind=${kinds[(n + n / 3) % 3]} setting=${settings[(n + n / 3) % 3]}
            [ "$ranks" = 2 ] && kind=smooth setting=render.surface=smooth
            OMP_NUM_THREADS=$threads mpi "$ranks" "$SEGCAST" render job.yaml -o "run$n" -q \
                --set render.skip=$skip --cpu "$([ $((n % 2)) = 0 ] && echo c || echo auto)" --set farm.tile=$((8 + 13 * n % 120)) \
                --set "$setting" >/dev/null
            [ "$(hashes "$kind")" = "$(hashes "run$n")" ] ||
                fail "other pictures with $ranks ranks, $threads threads, $skip, $kind"
            jq -e ".ranks == $ranks and .threads == $threads and .nodes == 1 and
                (.memory.peak_rss_bytes | length) == $ranks" "run$n/stats.json" >/dev/null ||
                fail "stats of run$n"
        done
    done
done

# More ranks than frames; and a video through several ranks is byte-identical to one rank's.
mpi 5 "$SEGCAST" render job.yaml -o few --frames 2-3 -q >/dev/null
[ "$(hashes few)" = "$(hashes smooth | sed -n '3,4p')" ] || fail "more ranks than frames"
"$SEGCAST" render job.yaml -o v1 -q --set output.video=v.mp4 >/dev/null
mpi 3 "$SEGCAST" render job.yaml -o v3 -q --set output.video=v.mp4 >/dev/null
cmp v1/v.mp4 v3/v.mp4 || fail "the video depends on the number of ranks"
