# The crown: every frame's hash is the same for any number of ranks and threads, any size of tiles,
# both skip methods.
small_job job.yaml
OMP_NUM_THREADS=1 "$SEGCAST" render job.yaml -o first -q >/dev/null
[ "$(hashes first | wc -l)" = 7 ] || fail "7 frames"
[ "$(hashes first | cut -d' ' -f2 | sort -u | wc -l)" = 7 ] || fail "frames repeat"
n=0
for ranks in 1 2 3 5; do
    for threads in 1 2 3; do
        for skip in none interior; do
            n=$((n + 1))
            OMP_NUM_THREADS=$threads mpi "$ranks" "$SEGCAST" render job.yaml -o "run$n" -q \
                --set render.skip=$skip --set farm.tile=$((8 + 13 * n % 120)) >/dev/null
            [ "$(hashes first)" = "$(hashes "run$n")" ] ||
                fail "other pictures with $ranks ranks, $threads threads, $skip"
            jq -e ".ranks == $ranks and .threads == $threads and .nodes == 1 and
                (.memory.peak_rss_bytes | length) == $ranks" "run$n/stats.json" >/dev/null ||
                fail "stats of run$n"
        done
    done
done

# More ranks than frames; and a video through several ranks is byte-identical to one rank's.
mpi 5 "$SEGCAST" render job.yaml -o few --frames 2-3 -q >/dev/null
[ "$(hashes few)" = "$(hashes first | sed -n '3,4p')" ] || fail "more ranks than frames"
"$SEGCAST" render job.yaml -o v1 -q --set output.video=v.mp4 >/dev/null
mpi 3 "$SEGCAST" render job.yaml -o v3 -q --set output.video=v.mp4 >/dev/null
cmp v1/v.mp4 v3/v.mp4 || fail "the video depends on the number of ranks"
