# SPDX-License-Identifier: BSD-3-Clause
# The time limit ends during the run: it stops in order, the job requeues itself, and the next run
# completes it.
. "$SOURCE/tests/support/cluster.sh"
cat >late.sbatch <<S
#!/bin/bash
trap : USR1   # Slurm may send it up to a minute early
[ -n "\${SLURM_RESTART_COUNT:-}" ] || sleep 48 & wait; wait   # so that little of the first minute is left for segcast
export PATH=$PATH
exec bash $SOURCE/jobs/slurm/requeue.sbatch job.yaml -o out
S
# The job has to be longer than the first run, which has ten seconds. How long a job takes cannot be told
# well on a machine that others use, too: where the first run completed the job, a longer one is tried.
# Slurm may send USR1 up to a minute early: then the run stops on request, before its time is nearly up.
stopped='stopped (because the time is nearly up|on request) after [1-9]'
for seconds in 25 60 150; do
    rm -rf trial ref out requeue.log
    make_job $seconds
    submit "${SMALL[@]}" --requeue --open-mode=append --time=1 --signal=B:USR1@5 -o requeue.log late.sbatch
    wait_for 300 "the end of the job" has_ended
    [ "$(state)" = COMPLETED ] || { cat requeue.log >&2; fail "state $(state)"; }
    ! grep -qE "$stopped" requeue.log || break
done
grep -qE "$stopped" requeue.log || fail "the time limit did not end during the run"
grep -q 'are there, and verified' requeue.log || fail "the run after the requeue kept no frame"
[ "$(on_head scontrol show job "$id" | sed -n 's/.*Restarts=\([0-9]*\).*/\1/p')" -ge 1 ] || fail "no requeue"
same_as_ref
