# SPDX-License-Identifier: BSD-3-Clause
# A host loses its power during the run: Slurm requeues the job, which continues on another host. (It cannot
# continue on the same one, where PMIx fails because of a socket that the killed step has left.)
HOSTS=3
. "$SOURCE/tests/support/cluster.sh"
make_job 8
submit "${SMALL[@]}" -o job.log "$SOURCE/jobs/slurm/many-nodes.sbatch" job.yaml -o out
wait_for 240 "12 frames" has_frames 12
"$SLURM_CLUSTER" kill-node n2
on_head scontrol update nodename=n2 state=down reason=killed
wait_for 180 "the end of the job" has_ended
[ "$(state)" = COMPLETED ] || { cat job.log >&2; fail "state $(state)"; }
grep -q 'are there, and verified' job.log || fail "no frame was kept"
same_as_ref
