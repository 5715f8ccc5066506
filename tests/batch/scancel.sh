# SPDX-License-Identifier: BSD-3-Clause
# After scancel, a run outside Slurm continues in the same directory.
. "$SOURCE/tests/support/cluster.sh"
make_job 8
submit "${SMALL[@]}" -o job.log "$SOURCE/jobs/slurm/many-nodes.sbatch" job.yaml -o out
wait_for 240 "12 frames" has_frames 12
on_head scancel "$id"
wait_for 60 "the end of the job" has_ended
[ "$(state)" = CANCELLED ] || fail "state $(state)"
[ ! -e out/film.mp4 ] || fail "the job was over before scancel"
"$SEGCAST" render job.yaml -o out --resume >/dev/null 2>again.txt || { cat again.txt >&2; fail "--resume failed"; }
grep -q 'are there, and verified' again.txt || { cat again.txt >&2; fail "no frame was kept"; }
same_as_ref
