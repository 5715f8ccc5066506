# SPDX-License-Identifier: BSD-3-Clause
# Processes are killed at random moments, again and again, and each time the next run continues. All files of
# each job that is complete in the end are those of an undisturbed run. SOAK_KILLS is the number of kills (tools/soak: 50).
kills=${SOAK_KILLS:-6}
RANDOM=${SOAK_SEED:-1}
small_job job.yaml
sed -i 's/size: \[96, 72\], video: none/size: [320, 240], fps: 6, frames: png, video: film.mp4/; s/frames: 7/frames: 60/' job.yaml
begin_ms=$(($(date +%s%N) / 1000000))
"$SEGCAST" render job.yaml -o ref -q --threads 2 >/dev/null
whole_ms=$(($(date +%s%N) / 1000000 - begin_ms)) # duration of an undisturbed run
name=sc_soak_$$
ln -s "$SEGCAST" "$name"
trap 'pkill -KILL -x "$name" 2>/dev/null || true' EXIT

# compare: out is complete, and its files are those of the undisturbed run.
compare() {
    [ "$(hashes out)" = "$(hashes ref)" ] || fail "the frames differ from those of an undisturbed run"
    cmp out/film.mp4 ref/film.mp4 || fail "the video differs from that of an undisturbed run"
    diff -r out/frames ref/frames || fail "the PNG files differ from those of an undisturbed run"
    "$SEGCAST" verify out >/dev/null || fail "verify"
    [ -z "$(find out -name "*.part" -o -name segments -o -name ".*")" ] || fail "files are left: $(find out)"
    finished=$((finished + 1))
}
finished=0
encodes=(rank0 segments gather auto)
partitions=(auto tiles frames)
killed=0
runs=0
kept=0
while :; do
    runs=$((runs + 1))
    mpirun -n $((runs % 2 + 1)) "./$name" render job.yaml -o out --resume \
        --set "farm.encode=${encodes[runs / 2 % 4]}" --set "farm.partition=${partitions[runs / 3 % 3]}" \
        >/dev/null 2>stderr.txt &
    launcher=$!
    ( # a run that hangs ends with a code that is not expected
        sleep 300 &
        trap 'kill $!; exit' TERM
        wait
        kill -ABRT $launcher
    ) >/dev/null 2>&1 &
    watchdog=$!
    if [ $killed -lt "$kills" ]; then
        delay_ms=$((RANDOM % (whole_ms / 2 + 500)))
        sleep "$((delay_ms / 1000)).$(printf %03d $((delay_ms % 1000)))"
        # Kill mpirun, or one of the ranks, or all of them.
        mapfile -t pids < <(pgrep -r R,S,D -x "$name" || true; echo $launcher)
        if [ $((RANDOM % 5)) = 0 ]; then
            target=("${pids[@]}")
        else
            target=("${pids[RANDOM % ${#pids[@]}]}")
        fi
        kill -KILL "${target[@]}" 2>/dev/null && killed=$((killed + 1))
    fi
    code=0
    wait $launcher 2>/dev/null || code=$?
    kill $watchdog 2>/dev/null || fail "a run took more than 300 s"
    wait_until '! pgrep -r R,S,D -x "$name" >/dev/null'
    left=$(pgrep -r R,S,D -x "$name" || true)
    if [ -n "$left" ]; then
        echo "run $runs: of ${pids[*]}, of which $launcher is mpirun, ${target[*]} were killed after $delay_ms ms; left:" >&2
        ps -o pid,ppid,stat,etime,time,args -p "$left" >&2
        cat stderr.txt >&2
        fail "a rank is left behind"
    fi
    grep -q 'are there, and verified' stderr.txt && kept=$((kept + 1))
    ! grep -q 'segcast: error' stderr.txt || { cat stderr.txt >&2; fail "a run logged an error"; }
    if [ $code = 0 ] && [ $killed -lt "$kills" ]; then
        compare
        rm -rf out # the job was complete before all kills: begin again
    elif [ $code = 0 ]; then
        break
    fi
    [ $runs -lt $((4 * kills + 20)) ] || fail "no progress in $runs runs"
done
[ $kept -gt 0 ] || fail "no run kept frames of an earlier one"
compare
echo "$killed kills, $runs runs, $kept of them with frames to keep; $finished jobs complete and identical"
