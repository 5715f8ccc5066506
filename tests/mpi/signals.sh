# SPDX-License-Identifier: BSD-3-Clause
# After a deadline or a signal, in one process and under mpirun, the frames that were begun are finished
# and the exit code is 75; a second TERM ends the run at once. In both cases the next run continues.
small_job job.yaml
sed -i 's/size: \[96, 72\], video: none/size: [320, 240], fps: 5, video: film.mp4/; s/frames: 7/frames: 4000/' job.yaml
name=sc_signal_$$ # to find the ranks by, under any launcher
ln -s "$SEGCAST" "$name"
wait_for_frames() {
    wait_until "[ \"\$(frames out)\" -ge $1 ]"
    [ "$(frames out)" -ge "$1" ] || fail "the manifest does not name $1 frames in time"
}
stopped() { # stopped CODE WHAT
    [ "$1" = 75 ] || { cat stderr.txt >&2; fail "$2: exit $1, expected 75"; }
    jq -e '.state == "incomplete" and .done > 0 and .done < 4000' out/status.json >/dev/null || fail "$2: status.json: $(cat out/status.json)"
    [ "$(hashes out | wc -l)" = "$(jq .done out/status.json)" ] || fail "$2: manifest and status.json disagree"
}

# Two deadlines: the time limit of the command line, and the end of a Slurm allocation.
for ranks in 1 2; do
    rm -rf out
    code=0
    begin=$(date +%s%N)
    mpi $ranks "$SEGCAST" render job.yaml -o out --time-limit 0:06 >/dev/null 2>stderr.txt || code=$?
    # The limit is 6 s, the whole job would take minutes; the rest allows for a busy machine.
    [ $((($(date +%s%N) - begin) / 1000000000)) -lt 25 ] || fail "the time limit was passed"
    stopped $code "time limit"
    grep -q 'the time is nearly up' stderr.txt || fail "the log does not say why the run stopped"
done
expect 75 'no frame could be finished' "$SEGCAST" render job.yaml -o none --time-limit 0.001
before=$(jq .done out/status.json)
code=0
SLURM_JOB_END_TIME=$(($(date +%s) + 6)) "$SEGCAST" render job.yaml -o out --resume >/dev/null 2>stderr.txt || code=$?
stopped $code "end of the allocation"
grep -q "$before of 4000 frames are there, and verified" stderr.txt || { cat stderr.txt >&2; fail "the $before frames are not kept"; }
[ "$(jq .done out/status.json)" -gt "$before" ] || fail "the second run added no frame"

# Signals to a single process and to all ranks, also while ranks encode GOPs.
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

# A launcher that is killed takes a single process with it, too.
rm -rf out
mpirun -n 1 "./$name" render job.yaml -o out >/dev/null 2>stderr.txt &
pid=$!
wait_for_frames 7
kill -KILL $pid
wait $pid || true
wait_until '! pgrep -r R,S,D -x "$name" >/dev/null'
! pkill -KILL -r R,S,D -x "$name" || fail "a process went on for 20 s without its launcher"
stopped 75 "without its launcher"

# A second TERM ends the run at once.
rm -rf out
"$SEGCAST" render job.yaml -o out --set output.size=[3840,2160] >/dev/null 2>stderr.txt &
pid=$!
wait_until '[ "$(jq -r .phase out/status.json 2>/dev/null)" = drawing ]' # before the first frame is begun, one TERM is enough
kill -TERM $pid
sleep 0.02 # two signals at the same time would be delivered as one
kill -TERM $pid
code=0
wait $pid || code=$?
[ $code = 75 ] || fail "second TERM: exit $code"
! grep -q incomplete out/status.json 2>/dev/null || fail "the second TERM did not stop at once"
expect 64 'expected seconds' "$SEGCAST" render job.yaml --time-limit soon; one_error

# USR1 is remembered from the beginning, before MPI is started: one that was pending when the program
# began, and, where it was not blocked, one that comes when the handler has just been installed.
code=0
env --block-signal=USR1 bash -c 'kill -USR1 $$; exec "$@"' bash "$SEGCAST" render job.yaml -o pending >/dev/null 2>stderr.txt || code=$?
[ $code = 75 ] || { cat stderr.txt >&2; fail "a pending USR1: exit $code, expected 75"; }
grep -q 'stopped on request$' stderr.txt || { cat stderr.txt >&2; fail "the pending USR1 was forgotten"; }
[ ! -e pending ] || fail "a run that USR1 stopped before its first frame has left a directory"
# Before the first frame, and in commands without frames, USR1 ends at once: nothing could be kept.
for command in "render job.yaml -o unprepared --set volume=phantom:469x325x487" "convert phantom:469x325x487 -o p.segc"; do
    code=0
    # shellcheck disable=SC2086
    "$SEGCAST" $command >/dev/null 2>stderr.txt &
    pid=$!
    sleep 1
    kill -USR1 $pid
    wait $pid || code=$?
    [ $code = 75 ] || { cat stderr.txt >&2; fail "USR1 before the first frame: exit $code, expected 75: $command"; }
    grep -q 'stopped on request$' stderr.txt || { cat stderr.txt >&2; fail "USR1 before the first frame: $command"; }
done
[ ! -e unprepared ] && [ ! -e p.segc ] || fail "files of runs that were stopped before the first frame: $(ls)"
for try in 1 2 3; do
    SEGCAST_MPI=yes "$SEGCAST" render job.yaml -o early$try >/dev/null 2>stderr.txt &
    pid=$!
    threads=
    while [ -z "$threads" ]; do # until USR1, which is signal 10, is among those that are caught
        status=$(<"/proc/$pid/status")
        [[ $status =~ Threads:[[:space:]]*([0-9]+) ]] && now=${BASH_REMATCH[1]}
        [[ $status =~ SigCgt:[[:space:]]*([0-9a-f]+) ]] || fail "segcast ended before it caught USR1"
        ((16#${BASH_REMATCH[1]} & 1 << 9)) && threads=$now
    done
    kill -USR1 $pid
    code=0
    wait $pid || code=$?
    [ $code = 75 ] || { cat stderr.txt >&2; fail "early USR1: exit $code, expected 75"; }
    [ "$threads" = 1 ] || fail "USR1 was not caught before MPI had started its threads"
done

# Before the first frame TERM ends a run at once; a run that has used up its CPU time stops in order.
rm stderr.txt # of the run before, which has such a line, too
"$SEGCAST" render job.yaml -o early --set volume=phantom:469x325x487 >/dev/null 2>stderr.txt &
pid=$!
until grep -qs '^segcast: rank ' stderr.txt; do sleep 0.02; done
begin=$(date +%s%N)
kill -TERM $pid
code=0
wait $pid || code=$?
[ $code = 75 ] || { cat stderr.txt >&2; fail "TERM before the first frame: exit $code"; }
ms=$((($(date +%s%N) - begin) / 1000000))
[ $ms -lt 10000 ] || fail "TERM before the first frame took $ms ms" # within a second, but for a busy machine
rm -rf out
code=0
(ulimit -S -t 2; exec "$SEGCAST" render job.yaml -o out) >/dev/null 2>stderr.txt || code=$?
stopped $code "CPU time"
grep -q 'limit of CPU time is reached (ulimit -t)' stderr.txt || fail "the log does not name the limit of CPU time"
code=0
(ulimit -S -t 1; exec "$SEGCAST" convert phantom:1200x1200x1200 -o p.nrrd) >/dev/null 2>stderr.txt || code=$?
[ $code = 71 ] || { cat stderr.txt >&2; fail "CPU time of another command: exit $code, expected 71"; }
one_error
