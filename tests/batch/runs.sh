# SPDX-License-Identifier: BSD-3-Clause
# Runs on two hosts, by the batch scripts of jobs/slurm: undisturbed, stopped by a signal, cancelled, with the network cut,
# and as a job array. Each ends with the bytes of an undisturbed run on this machine, some after a second run.
. "$SOURCE/tests/support/cluster.sh"
make_job 6

# start SCRIPT [SBATCH_ARGUMENT...]: submit a script of jobs/slurm in an empty directory
start() {
    rm -rf out ./*.log
    submit "${@:2}" "$SOURCE/jobs/slurm/$1.sbatch" job.yaml -o out
}
ends_as() { # ends_as STATE SECONDS
    wait_for "$2" "the end of the job" has_ended
    [ "$(state)" = "$1" ] || { cat ./*.log >&2; fail "state $(state), expected $1"; }
}
continue_here() { # a run outside Slurm continues in the same directory
    [ ! -e out/film.mp4 ] || fail "the job was over before scancel"
    "$SEGCAST" render job.yaml -o out --resume >/dev/null 2>again.txt || { cat again.txt >&2; fail "--resume failed"; }
    grep -q 'are there, and verified' again.txt || { cat again.txt >&2; fail "no frame was kept"; }
    same_as_ref
}
on_two_hosts=("${SMALL[@]}" -o job.log)

start many-nodes "${on_two_hosts[@]}"
ends_as COMPLETED 90
jq -e '.ranks == 2 and .nodes == 2' out/stats.json >/dev/null || fail "not two nodes"
grep -qE ' 0  n1 .* 1 ' job.log && grep -qE ' 1  n2 ' job.log || fail "no table of ranks and hosts"
same_as_ref
# The same by mpirun within an allocation.
rm -rf out
on_head salloc -Q "${SMALL[@]}" mpirun segcast render job.yaml -o out -q >/dev/null
same_as_ref
# The network between the hosts is measured, not assumed.
on_head env XDG_CACHE_HOME="$PWD/cache" salloc -Q "${SMALL[@]}" mpirun segcast plan --calibrate --json -q >costs.json
jq -e '.messages_measured and .network_measured and .latency_s > 0 and .link_bytes_per_s > 0' costs.json >/dev/null ||
    fail "the network is not measured: $(cat costs.json)"

# The network is cut for some seconds: the run continues afterwards, and all files are right.
start many-nodes "${on_two_hosts[@]}"
wait_for 240 "10 frames" has_frames 10
"$SLURM_CLUSTER" cut n2
sleep 3
"$SLURM_CLUSTER" mend n2
ends_as COMPLETED 180
same_as_ref

# USR1 to the batch script, as --signal=B:USR1@N sends it: srun passes it on, all ranks stop in order, the
# job requeues itself, and the next run completes it.
start requeue "${on_two_hosts[@]}" --time=10
wait_for 240 "10 frames" has_frames 10
on_head scancel -b -s USR1 "$id"
ends_as COMPLETED 180
grep -q 'stopped on request' job.log || { cat job.log >&2; fail "did not stop in order"; }
grep -q 'are there, and verified' job.log || fail "the next run kept no frame"
same_as_ref

# After scancel a run outside Slurm continues; a job that requeues itself is not queued again by it.
start many-nodes "${on_two_hosts[@]}"
wait_for 240 "10 frames" has_frames 10
on_head scancel "$id"
ends_as CANCELLED 60
continue_here
start requeue "${on_two_hosts[@]}"
wait_for 240 "10 frames" has_frames 10
on_head scancel "$id"
ends_as CANCELLED 60
sleep 8 # longer than Slurm waits before it starts a job that was queued again
[ "$(state)" = CANCELLED ] || { cat job.log >&2; fail "the job was queued again after scancel: $(state)"; }
continue_here

# A job array of four tasks draws slices of one job into one directory, without locks; the task that ends
# last makes the video.
start array --nodes=1 --ntasks=1 --cpus-per-task=1 --array=0-3 -o 'slice.%a.log'
all_ended() { [ "$(on_head squeue -h -j "$id" 2>/dev/null | wc -l)" = 0 ]; }
wait_for 120 "the end of the array" all_ended
[ -e out/film.mp4 ] || { cat slice.*.log >&2; fail "no video"; }
grep -q "of other slices are not there yet" slice.*.log ||
    fail "every slice took itself for the last"
same_as_ref
