# Deadlines and signals, alone and under mpirun: finish what is in flight, exit 75; a second TERM
# stops at once; whatever came, the job can be gone on with.
small_job job.yaml
sed -i 's/size: \[96, 72\], video: none/size: [320, 240], fps: 5, video: film.mp4/; s/frames: 7/frames: 4000/' job.yaml
name=sc_signal_$$ # to find the ranks by, under any launcher
ln -s "$SEGCAST" "$name"
wait_for_frames() {
    for _ in $(seq 600); do
        [ "$(cat out/manifest.jsonl 2>/dev/null | grep -c '"frame"')" -ge "$1" ] && return
        sleep 0.05
    done
    fail "no frames"
}
stopped() { # stopped CODE WHAT
    [ "$1" = 75 ] || { cat stderr.txt >&2; fail "$2: exit $1, expected 75"; }
    jq -e '.state == "incomplete" and .done > 0 and .done < 4000' out/status.json >/dev/null || fail "$2: status"
    [ "$(hashes out | wc -l)" = "$(jq .done out/status.json)" ] || fail "$2: manifest and status disagree"
}

# the time limit, and Slurm's end of the allocation
for ranks in 1 2; do
    rm -rf out
    code=0
    begin=$(date +%s%N)
    mpi $ranks "$SEGCAST" render job.yaml -o out --time-limit 0:06 >/dev/null 2>stderr.txt || code=$?
    # of a job of minutes; the rest is room for a busy machine
    [ $((($(date +%s%N) - begin) / 1000000000)) -lt 25 ] || fail "the time limit was passed"
    stopped $code "time limit"
    grep -q 'the time is nearly up' stderr.txt || fail "no reason"
done
expect 75 'no frame could be finished' "$SEGCAST" render job.yaml -o none --time-limit 0.001
before=$(jq .done out/status.json)
code=0
SLURM_JOB_END_TIME=$(($(date +%s) + 6)) "$SEGCAST" render job.yaml -o out --resume >/dev/null 2>stderr.txt || code=$?
stopped $code "end of the allocation"
grep -q "$before of 4000 frames are there, and verified" stderr.txt || { cat stderr.txt >&2; fail "the $before frames are not kept"; }
[ "$(jq .done out/status.json)" -gt "$before" ] || fail "nothing was added"

# signals, to one process or to mpirun; also while ranks encode groups of their own
for signal in USR1 TERM; do
    rm -rf out
    "$SEGCAST" render job.yaml -o out >/dev/null 2>stderr.txt &
    pid=$!
    wait_for_frames 7
    kill -$signal $pid
    code=0
    wait $pid || code=$?
    stopped $code "$signal alone"
    rm -rf out
    mpirun -n 2 "./$name" render job.yaml -o out --set farm.encode=segments >/dev/null 2>stderr.txt &
    pid=$!
    wait_for_frames 7
    pkill -USR1 -x "$name" # every rank, as srun does it
    code=0
    wait $pid || code=$?
    stopped $code "USR1 to all ranks"
done

# a second TERM: at once
rm -rf out
"$SEGCAST" render job.yaml -o out --set output.size=[3840,2160] >/dev/null 2>stderr.txt &
pid=$!
for _ in $(seq 200); do [ -e out/manifest.jsonl ] && break; sleep 0.05; done
kill -TERM $pid
sleep 0.02 # two at once are one
kill -TERM $pid
code=0
wait $pid || code=$?
[ $code = 75 ] || fail "second TERM: exit $code"
! grep -q incomplete out/status.json 2>/dev/null || fail "the second TERM did not stop at once"
expect 64 'expected seconds' "$SEGCAST" render job.yaml --time-limit soon; one_error
