# SPDX-License-Identifier: BSD-3-Clause
# A run on two hosts, by sbatch with jobs/slurm/many-nodes.sbatch; and the network between them, measured.
. "$SOURCE/tests/support/cluster.sh"
make_job 4
submit "${SMALL[@]}" "$SOURCE/jobs/slurm/many-nodes.sbatch" job.yaml -o out
wait_for 90 "the end of the job" has_ended
[ "$(state)" = COMPLETED ] || { cat ./*.log >&2; fail "state $(state)"; }
jq -e '.ranks == 2 and .nodes == 2' out/stats.json >/dev/null || fail "not two nodes"
grep -qE ' 0  n1 .* 1 ' ./*.log && grep -qE ' 1  n2 ' ./*.log || fail "no table of ranks and hosts"
same_as_ref
# The same by mpirun within an allocation.
rm -rf out
on_head salloc -Q "${SMALL[@]}" mpirun segcast render job.yaml -o out -q >/dev/null
same_as_ref
# The network between the hosts is measured, not assumed.
on_head env XDG_CACHE_HOME="$PWD/cache" salloc -Q "${SMALL[@]}" mpirun segcast calibrate --json -q >costs.json
jq -e '.messages_measured and .network_measured and .latency_s > 0 and .link_bytes_per_s > 0' costs.json >/dev/null ||
    fail "the network is not measured: $(cat costs.json)"
