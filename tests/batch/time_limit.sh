# The time limit falls in the middle; the job stops in order, requeues itself, and ends complete.
. "$SOURCE/tests/support/cluster.sh"
a_job 25
cat >late.sbatch <<S
#!/bin/bash
trap : USR1   # it may come a minute early, and does
[ -n "\${SLURM_RESTART_COUNT:-}" ] || sleep 42 & wait; wait   # of the first minute little is left
export PATH=$PATH
exec bash $SOURCE/jobs/slurm/requeue.sbatch job.yaml -o out
S
submit "${SMALL[@]}" --requeue --open-mode=append --time=1 --signal=B:USR1@5 -o requeue.log late.sbatch
wait_for 300 "the job" has_ended
[ "$(state)" = COMPLETED ] || { cat requeue.log >&2; fail "state $(state)"; }
[ "$(grep -c 'stopped because the time is nearly up' requeue.log)" -ge 1 ] || fail "the time limit did not fall in the middle"
grep -q 'are there, and verified' requeue.log || fail "began anew after the requeue"
[ "$(on_head scontrol show job "$id" | sed -n 's/.*Restarts=\([0-9]*\).*/\1/p')" -ge 1 ] || fail "no requeue"
same_as_ref
