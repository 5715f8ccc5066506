# SPDX-License-Identifier: BSD-3-Clause
# Jobs made at random, of every verb, shots, phases of a beat, comparisons, images, values and overlays, are accepted by
# check, and any frame of them alone, in any order, of the resolved job, on any number of ranks and threads, in any
# partition, with any kernel and skip method, after a run that was killed, or as a still, is that of the film, by hash.
# PROPERTY_SEED=N chooses other jobs, PROPERTY_JOBS=N how many, and PROPERTY_FIRST=N the number of the first. A job that
# fails is kept in the build directory, with its inputs.
seed=${PROPERTY_SEED:-1} first=${PROPERTY_FIRST:-0} jobs=${PROPERTY_JOBS:-14}

# The generator knows each key that says what happens in a film, so that a new verb or overlay is tried from then on.
subjects='animation\.(verbs\.N\.|clip\.N\.|camera\.(orbit|fixed)\.|slices$)|overlays\.|'
subjects+='light\.|tissues\.NAME\.|color_by\.|image\.|cine\.|compare\.with\.N\.'
"$SEGCAST" help keys --json | jq -r '.[].key' | grep -E "^($subjects)" | LC_ALL=C sort >keys.txt
"$RANDOM_JOB" --keys | LC_ALL=C sort -u | diff keys.txt - >&2 ||
    fail "tests/property/random_job.c makes jobs of other keys than segcast has: < are keys of segcast alone"

# The inputs of the jobs
"$SEGCAST" convert phantom:24x18x24 --beating 3 -o beat.nrrd -q >/dev/null
"$SEGCAST" convert phantom:22x17x20 -o other.nrrd -q >/dev/null
"$SEGCAST" convert phantom:20x16x20 --ct -o ct.nrrd -q >/dev/null
{
    printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n'
    printf '\200\100\040%b' '\0201' '\0177' '\0203' '\0200' '\0177' '\0176' '\0201' '\0201'
} >sky.hdr
printf '6 aorta 10 200 10 255\n8 left_ventricle 200 10 200 255\n' >other.ctbl
printf 'name,change,weight\naorta,-0.5,12\nleft ventricle,3.5,80\nright atrium,,40\n7,1,\n' >values.csv
printf 'volume: phantom:24x18x24\noutput: {size: [24, 16]}\n' >logo.yaml
"$SEGCAST" still logo.yaml -o logo.png -q --set render.background=none >/dev/null

failed() { # failed WHAT: keep the job
    mkdir -p "$BUILD/failed-films"
    cp -r job.yaml beat-*.nrrd other.* ct.nrrd sky.hdr values.csv logo.png "$BUILD/failed-films"
    cp job.yaml "$BUILD/failed-films/$seed-$n.yaml"
    cat job.yaml stderr.txt >&2
    fail "job $n of seed $seed ($BUILD/failed-films/$seed-$n.yaml; PROPERTY_SEED=$seed PROPERTY_FIRST=$n PROPERTY_JOBS=1): $1"
}
run() { "$@" >/dev/null 2>stderr.txt || failed "exit code $?: $*"; }

skips=(none interior octree proximity chessboard leap)
moving=0
for ((n = first; n < first + jobs; n++)); do
    rm -rf one two some killed alone.png
    RANDOM=$((seed * 100 + n))
    "$RANDOM_JOB" "$seed" "$n" >job.yaml
    unset SEGCAST_RENDER_QUALITY
    ! grep -qE 'aperture_mm|shutter' job.yaml || export SEGCAST_RENDER_QUALITY=draft # 8 rays for a pixel, not 128: unit.optics sends them
    run "$SEGCAST" check job.yaml
    run "$SEGCAST" render job.yaml -o one -q --set output.frames=png
    hashes one >one.txt
    frames=$(wc -l <one.txt)
    [ "$frames" -ge 4 ] || failed "the manifest names $frames frames"
    [ "$(cut -d' ' -f2 one.txt | sort -u | wc -l)" = 1 ] || moving=$((moving + 1))

    # Another number of ranks, partition, size of tiles, kernel and skip method
    skip=${skips[RANDOM % 6]} tile=$((8 + RANDOM % 60)) partition=$([ $((n % 2)) = 0 ] && echo tiles || echo frames)
    SEGCAST_CACHE=off OMP_NUM_THREADS=$((1 + RANDOM % 2)) run mpi 2 "$SEGCAST" render job.yaml -o two -q --cpu c --set render.skip="$skip" \
        --set farm.partition="$partition" --set farm.tile="$tile" --set farm.share="$([ $((RANDOM % 2)) = 0 ] && echo true || echo false)"
    hashes two | diff one.txt - >&2 || failed "2 ranks, $partition, tiles of $tile, skip $skip and plain C make other frames"

    # Some frames alone, in another order, of the job as it was resolved
    cp one/job.yaml resolved.yaml
    last=$((frames - 1)) any=$((RANDOM % (frames - 1)))
    OMP_NUM_THREADS=2 run "$SEGCAST" render resolved.yaml -o some -q --frames "$last,$any" --set render.skip="${skips[RANDOM % 6]}"
    hashes some | diff <(grep -E "^($any|$last) " one.txt) - >&2 || failed "frames $last and $any alone are not those of the film"
    [ "$(job_hash one)" = "$(job_hash some)" ] || failed "the resolved job is another one"
    for k in $last $((RANDOM % frames)); do
        run "$SEGCAST" still job.yaml --frame "$k" -o alone.png --overwrite -q
        "$IMAGE_DIFFERENCE" alone.png "one/frames/$(printf %06d "$k").png" || failed "a still of frame $k is not that of the film"
    done

    # A run that is killed as soon as a frame is done, and goes on with other ranks
    [ $((n % 4)) = 1 ] || continue
    "$SEGCAST" render job.yaml -o killed -q >/dev/null 2>&1 &
    for _ in $(seq 500); do
        if grep -qs '"frame"' killed/manifest.jsonl || ! kill -0 $! 2>/dev/null; then
            break
        fi
        sleep 0.01
    done
    kill -KILL $! 2>/dev/null || true
    wait $! 2>/dev/null || true
    run mpi 2 "$SEGCAST" render job.yaml -o killed -q --resume
    hashes killed | uniq | diff one.txt - >&2 || failed "a run that was killed and resumed makes other frames"
    run "$SEGCAST" verify killed
done
[ "$jobs" -lt 6 ] || [ $((2 * moving)) -ge "$jobs" ] || fail "$moving of $jobs films show something that changes"
