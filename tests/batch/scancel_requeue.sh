# SPDX-License-Identifier: BSD-3-Clause
# A job that requeues itself is not queued again by scancel: it ends as CANCELLED, and a run outside Slurm
# continues in the same directory.
. "$SOURCE/tests/support/cluster.sh"
make_job 8
submit "${SMALL[@]}" -o job.log "$SOURCE/jobs/slurm/requeue.sbatch" job.yaml -o out
wait_for 240 "12 frames" has_frames 12
on_head scancel "$id"
wait_for 60 "the end of the job" has_ended
[ "$(state)" = CANCELLED ] || { cat job.log >&2; fail "state $(state)"; }
sleep 8 # longer than Slurm waits before it starts a job that was queued again
[ "$(state)" = CANCELLED ] || { cat job.log >&2; fail "the job was queued again after scancel: $(state)"; }
"$SEGCAST" render job.yaml -o out --resume >/dev/null 2>again.txt || { cat again.txt >&2; fail "--resume failed"; }
same_as_ref
