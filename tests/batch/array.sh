# SPDX-License-Identifier: BSD-3-Clause
# A job array of four tasks draws slices of one job into one directory, without locks; the task that ends
# last makes the video.
. "$SOURCE/tests/support/cluster.sh"
make_job 6
submit --nodes=1 --ntasks=1 --cpus-per-task=1 --array=0-3 -o 'slice.%a.log' "$SOURCE/jobs/slurm/array.sbatch" job.yaml -o out
all_ended() { [ "$(on_head squeue -h -j "$id" 2>/dev/null | wc -l)" = 0 ]; }
wait_for 120 "the end of the array" all_ended
[ -e out/film.mp4 ] || { cat slice.*.log >&2; fail "no video"; }
grep -q "of other slices are not there yet" slice.*.log ||
    fail "every slice took itself for the last"
same_as_ref
