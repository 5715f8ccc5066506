# SPDX-License-Identifier: BSD-3-Clause
# A study under a real Slurm with two virtual hosts: its ranks are killed in the middle, the job is queued again,
# and the next run completes it. Ranks on both hosts are measured; cells that want more are listed.
. "$SOURCE/tests/support/cluster.sh"
mkdir -p jobs/studies
cat >jobs/studies/placement.yaml <<YAML
set: {volume: "phantom:32x24x32", output: {size: 96x72}, animation: {frames: 24}, threads: 1}
sweep:
  ranks: [1, 2, 3]
  placement: [packed, spread]
  farm.partition: [frames, tiles]
least: 8
most: 8
budget: 60 min
YAML
measured() { [ "$(grep -c '^{"measurement"' study/measurements.jsonl 2>/dev/null)" -ge "$1" ]; }
submit "${SMALL[@]}" --time=10 -o job.log "$SOURCE/jobs/studies/placement.sbatch" study
wait_for 240 "6 measurements" measured 6
pkill -KILL -f "segcast study jobs/studies/placement.yaml -o study" || fail "nothing to kill"
wait_for 300 "the end of the job" has_ended
[ "$(state)" = COMPLETED ] || { cat job.log >&2; fail "state $(state)"; }
grep -q 'it is queued again' job.log || { cat job.log >&2; fail "the job was not queued again"; }
"$SEGCAST" status study || fail "the study is not complete"
[ "$(grep -c '^{"run"' study/measurements.jsonl)" = 2 ] || fail "not two runs: $(grep '^{"run"' study/measurements.jsonl)"
[ "$(grep -c '^{"measurement"' study/measurements.jsonl)" = 64 ] || fail "$(grep -c '^{"measurement"' study/measurements.jsonl) measurements, expected 64"
[ "$(grep -c 'needs 3 ranks' study/cells.csv)" = 4 ] || fail "cells that cannot run: $(cat study/cells.csv)"
jq -e 'select(.measurement) | .measurement | select(.ranks == 2 and .nodes != 2)' study/measurements.jsonl >/dev/null && fail "two ranks were not on two hosts"
[ "$(jq -r 'select(.measurement).measurement.pixels_hash' study/measurements.jsonl | sort -u | wc -l)" = 1 ] || fail "pixels differ"
