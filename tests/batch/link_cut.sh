# SPDX-License-Identifier: BSD-3-Clause
# The network is cut for some seconds: the run continues afterwards, and all files are right.
. "$SOURCE/tests/support/cluster.sh"
make_job 8
submit "${SMALL[@]}" -o job.log "$SOURCE/jobs/slurm/many-nodes.sbatch" job.yaml -o out
wait_for 240 "10 frames" has_frames 10
"$SLURM_CLUSTER" cut n2
sleep 3
"$SLURM_CLUSTER" mend n2
wait_for 180 "the end of the job" has_ended
[ "$(state)" = COMPLETED ] || { cat job.log >&2; fail "state $(state)"; }
same_as_ref
