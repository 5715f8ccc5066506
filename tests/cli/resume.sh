# SPDX-License-Identifier: BSD-3-Clause
# --resume verifies what is there and draws the rest and what is damaged; the outputs then have the same
# bytes as those of an undisturbed run, ref/. A directory of another job is refused.
small_job job.yaml
sed -i 's/size: \[96, 72\], video: none/size: [96, 72], fps: 4, frames: png, video: film.mp4/; s/frames: 7/frames: 18/' job.yaml
"$SEGCAST" render job.yaml -o ref -q >/dev/null
same_as_ref() { # same_as_ref WHAT [DIFF_OPTION...]: out holds the same bytes as ref
    [ "$(hashes out)" = "$(hashes ref)" ] || fail "$1: the hashes of the frames differ"
    cmp out/film.mp4 ref/film.mp4 || fail "$1: the video differs"
    diff -r "${@:2}" out/frames ref/frames || fail "$1: the PNG files differ"
    "$SEGCAST" verify out >/dev/null || fail "$1: segcast verify found an error"
    [ ! -e out/segments ] || fail "$1: out/segments was not removed"
}

# With --resume, a run begins in an empty directory, and does nothing if the job is finished.
"$SEGCAST" render job.yaml -o out --resume -q >/dev/null
same_as_ref "an empty directory"
before=$(stat -c '%n %i %Y' out/* out/frames/*)
expect 0 'nothing to do' "$SEGCAST" render job.yaml -o out --resume
[ "$(cat stdout.txt)" = out/film.mp4 ] || fail "standard output is not the path of the video"
[ "$before" = "$(stat -c '%n %i %Y' out/* out/frames/*)" ] || fail "the files of a finished job were changed"

# Without --resume a directory that holds a run is refused before the volume is read; --overwrite removes
# the run and begins anew.
echo broken >broken.nrrd
expect 73 'already holds a run; use --resume' "$SEGCAST" render job.yaml -o out --set volume=broken.nrrd; one_error
echo mine >out/frames/notes.txt
"$SEGCAST" render job.yaml -o out --overwrite --set animation.frames=5 -q >/dev/null
[ "$(ls out/frames | tr '\n' ' ')" = "000000.png 000001.png 000002.png 000003.png 000004.png notes.txt " ] ||
    fail "--overwrite left other files than expected: $(ls out/frames)"
expect 64 'cannot be used with --resume' "$SEGCAST" render job.yaml --resume --overwrite; one_error

# A directory of another job, volume, size or number of frames is refused, with the reason.
rm -rf out
"$SEGCAST" render job.yaml -o out -q --time-limit 0.001 >/dev/null && fail "a run with a limit of 0.001 s drew all frames" || [ $? = 75 ]
expect 73 'an animation of 18 frames instead of 9' "$SEGCAST" render job.yaml -o out --resume --set animation.frames=9; one_error
expect 73 'frames of .* pixels instead of' "$SEGCAST" render job.yaml -o out --resume --set output.size=[96,96]; one_error
expect 73 'another volume' "$SEGCAST" render job.yaml -o out --resume --set volume=phantom:61x41x59; one_error
expect 73 'another job' "$SEGCAST" render job.yaml -o out --resume --set render.quality=draft; one_error
grep -q 'the first difference is "render: quality: draft", which was "quality: film"' stderr.txt || fail "the key: $(cat stderr.txt)"
expect 73 'another job' "$SEGCAST" render job.yaml -o out --resume --set output.crf=30; one_error
sed -i '1s/"version":"/"version":"0.0-/' out/manifest.jsonl
expect 73 'first line is damaged' "$SEGCAST" render job.yaml -o out --resume; one_error
sed -i '1s/segcast-manifest-[0-9]*/segcast-manifest-2/' out/manifest.jsonl
expect 73 'another version' "$SEGCAST" render job.yaml -o out --resume; one_error
expect 73 'another version' "$SEGCAST" render job.yaml -o out --overwrite; one_error

# stop_in_the_middle DIR SIGNAL [FRAMES]: begin the job anew in DIR and send the signal when some frames are there.
stop_in_the_middle() {
    rm -rf "$1"
    "$SEGCAST" render job.yaml -o "$1" -q --set animation.frames=18 >/dev/null &
    local pid=$!
    for _ in $(seq 2000); do
        [ "$(cat "$1/manifest.jsonl" 2>/dev/null | grep -c '"frame"')" -ge "${3:-7}" ] && break
        sleep 0.005
    done
    kill -"$2" $pid 2>/dev/null || true
    wait $pid 2>/dev/null || true
}
for signal in USR1 TERM KILL; do
    stop_in_the_middle out $signal
    "$SEGCAST" render job.yaml -o out --resume -q >/dev/null
    same_as_ref "after $signal"
done

# The statistics of a resumed job cover all its runs that ended in order.
stopped_run() { # a run that ended in order, by a signal, when some frames were there
    for _ in $(seq 20); do
        stop_in_the_middle out TERM
        jq -e '.state == "incomplete" and .done > 0' out/status.json >/dev/null 2>&1 && return
    done
    fail "no run stopped in the middle"
}
stopped_run
first=$(jq '.runs[0].frames' out/stats.json)
kept=$(jq -c '[.frames[] | {frame, hash, render_cpu_s, rays}]' out/stats.json)
"$SEGCAST" render job.yaml -o out --resume -q >/dev/null
same_as_ref "after a stop"
jq -e --argjson first "$first" --argjson kept "$kept" '(.runs | length) == 2 and .runs[0].frames == $first and
    (.runs[1] | .frames == 18 - $first and .ranks == 1 and .wall_s > 0 and .cpu_s > 0 and (.begin | endswith("Z"))) and
    [.frames[].frame] == [range(18)] and ([.frames[] | select(.run == 0)] | length) == $first and
    [.frames[] | select(.run == 0) | {frame, hash, render_cpu_s, rays}] == $kept' out/stats.json >/dev/null ||
    fail "statistics of two runs: $(cat out/stats.json)"
[ "$(wc -l <out/frames.csv)" = 19 ] || fail "frames.csv of two runs"
for how in cut another_job; do
    stopped_run
    [ $how = cut ] && truncate -s 300 out/stats.json || sed -i 's/"job_hash": "./"job_hash": "x/' out/stats.json
    first=$(jq .done out/status.json)
    expect 0 'out/stats.json: .*earlier runs is left out' "$SEGCAST" render job.yaml -o out --resume
    same_as_ref "after stats.json was $how"
    jq -e --argjson first "$first" '(.runs | length) == 1 and ([.frames[].frame] == [range(18)]) and
        ([.frames[] | select(.run == null and .rays == null and .hash)] | length) == $first' out/stats.json >/dev/null ||
        fail "statistics after stats.json was $how"
    [ "$(grep -c ',,,,[^,]*,,$' out/frames.csv)" = "$first" ] || fail "frames.csv after stats.json was $how: $(cat out/frames.csv)"
done

# So do those of a job whose run was killed, and could write nothing at its end: the run is listed, and what the
# manifest says of its frames. Every frame names the run and the host that drew it.
for _ in $(seq 20); do
    stop_in_the_middle out KILL
    first=$(($(grep -c '^{"frame"' out/manifest.jsonl || true)))
    [ "$first" = 0 ] || break
done
[ "$first" != 0 ] || fail "no run was killed in the middle"
"$SEGCAST" render job.yaml -o out --resume -q >/dev/null
same_as_ref "after a run was killed"
jq -e '[.runs[].ended] == [false, true] and .runs[0].id != .runs[1].id and [.frames[].frame] == [range(18)] and
    .runs[1].farm_wall_s > 0 and .runs[1].farm_wall_s < .runs[1].wall_s and
    all(.runs[]; .hosts == [.host] and .rank_hosts == [0] and .kernel and .mpi and .begin and has("processor") and
        has("commit") and has("batch_job")) and
    ([.frames[] | select(.run == 0)] | length) == 18 - .runs[1].frames and
    all(.frames[]; if .run == 0 then .rays == null else .rays > 0 end) and
    .settings.animation.frames == 18 and .settings.output.video == "film.mp4"' out/stats.json >/dev/null ||
    fail "statistics of a killed run: $(cat out/stats.json)"
[ "$(grep -c ",[01],$(hostname)\$" out/frames.csv)" = 18 ] || fail "frames.csv of a killed run: $(cat out/frames.csv)"
"$SEGCAST" verify out >/dev/null || fail "verify after a killed run"

# Damage is noticed, and what is damaged is made again: each kind of file, truncated, changed, emptied,
# removed, or replaced by a file of other frames.
damage() { # damage HOW FILE...
    local how=$1 file
    shift
    for file in "$@"; do
        [ -e "$file" ] || continue
        case $how in
        cut) truncate -s $(($(stat -c %s "$file") / 2)) "$file" ;;
        change) printf '\x55' | dd of="$file" bs=1 seek=$(($(stat -c %s "$file") / 2)) conv=notrunc status=none ;;
        empty) : >"$file" ;;
        gone) rm "$file" ;;
        another) case $file in # an undamaged file that belongs to other frames
            *.png) cp out/frames/000003.png "$file" ;;
            *.seg) cp out/segments/000001.seg "$file" ;;
            esac ;;
        esac
    done
}
all_damage=(cut change empty gone another)
case $BUILD in */asan) all_damage=(cut) ;; esac # every run takes ten times as long there
for attempt in $(seq 20); do # until a run stops within a GOP of 4 frames, so that there is a partial one
    stop_in_the_middle out TERM $((8 + attempt % 5))
    [ -e out/segments/000000.seg ] && ls out/segments/*.part >/dev/null 2>&1 && break
done
mv out stopped
for how in "${all_damage[@]}"; do
    for what in 'segments/000000.seg' 'segments/*.part' 'frames/000002.png' manifest.jsonl; do
        rm -rf out
        cp -r stopped out
        # shellcheck disable=SC2086
        [ -n "$(ls out/$what 2>/dev/null)" ] || fail "no run stopped with $what"
        # shellcheck disable=SC2086
        damage $how out/$what
        case $how-$what in empty-manifest.jsonl | gone-manifest.jsonl)
            # Without a manifest nobody can know what in the directory was made by segcast.
            before=$(find out -type f -exec sha256sum {} + | sort)
            expect 73 'out/(manifest.jsonl: its first line|.*: is a file that was not made by segcast)' \
                "$SEGCAST" render job.yaml -o out --resume; one_error
            [ "$before" = "$(find out -type f -exec sha256sum {} + | sort)" ] || fail "$how $what: files were changed"
            continue ;;
        esac
        "$SEGCAST" render job.yaml -o out --resume -q >/dev/null 2>stderr.txt || { cat stderr.txt >&2; fail "$how $what: exit code $?"; }
        same_as_ref "$how $what"
    done
done

# Segments of another job that bear the names of this one's are not used.
for _ in $(seq 20); do
    rm -rf out
    "$SEGCAST" render job.yaml -o out -q --set output.crf=40 >/dev/null &
    pid=$!
    for _ in $(seq 2000); do [ -e out/segments/000001.seg ] && break; sleep 0.005; done
    kill -KILL $pid 2>/dev/null || true
    wait $pid 2>/dev/null || true
    [ -e out/segments/000001.seg ] && break # otherwise the run was finished before the signal
done
mv out another
stopped_run
mkdir -p out/segments
cp another/segments/000001.seg out/segments/
"$SEGCAST" render job.yaml -o out --resume -q >/dev/null 2>stderr.txt
grep -q 'belongs to another job; its frames are drawn again' stderr.txt || fail "no warning about segments of another job"
same_as_ref "segments of another job"

# A run that was thought dead (its host lost the network) comes back when another one has completed the job: it
# gives way, and changes nothing.
for _ in $(seq 20); do # again, if the run was finished before the signal
    rm -rf out
    "$SEGCAST" render job.yaml -o out -q >/dev/null 2>late.txt &
    pid=$!
    for _ in $(seq 400); do [ -e out/segments/000000.seg ] && break; sleep 0.005; done
    kill -STOP $pid
    [ -e out/segments/000000.seg ] && break
    kill -CONT $pid
    wait $pid || true
done
"$SEGCAST" render job.yaml -o out --resume -q >/dev/null
# The file that it was just writing, under a temporary name, is still its own.
same_as_ref "completed beside a run that stands still" -x '.*.tmp.*'
kill -CONT $pid
code=0
wait $pid || code=$?
[ $code = 75 ] || fail "a run whose job another one has completed ends with $code: $(cat late.txt)"
[ "$(grep -c 'out: another run has begun in this directory meanwhile, and has it now' late.txt)" = 1 ] ||
    fail "a run whose job another one has completed: $(cat late.txt)"
expect 0 '' "$SEGCAST" verify out
same_as_ref "after a run that came back"

# cli.flips damages the files of a finished job.
rm -rf out
expect 75 '' "$SEGCAST" render job.yaml -o out --time-limit 0.001
expect 75 'has no end line' "$SEGCAST" verify out; one_error
expect 64 'takes the directory that a job has made' "$SEGCAST" verify job.yaml; one_error
sed -i '/"frame":3,/d' ref/manifest.jsonl
expect 65 'line 5 is damaged' "$SEGCAST" verify ref; one_error
