# SPDX-License-Identifier: BSD-3-Clause
# USR1 to the batch script, as --signal=B:USR1@N sends it: srun passes it on, all ranks stop in order, the
# job requeues itself, and the next run completes it.
. "$SOURCE/tests/support/cluster.sh"
make_job 8
submit "${SMALL[@]}" --time=10 -o job.log "$SOURCE/jobs/slurm/requeue.sbatch" job.yaml -o out
wait_for 240 "10 frames" has_frames 10
on_head scancel -b -s USR1 "$id"
wait_for 180 "the end of the job" has_ended
[ "$(state)" = COMPLETED ] || { cat job.log >&2; fail "state $(state)"; }
grep -q 'stopped on request' job.log || { cat job.log >&2; fail "did not stop in order"; }
grep -q 'are there, and verified' job.log || fail "the next run kept no frame"
same_as_ref
