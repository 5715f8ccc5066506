# SPDX-License-Identifier: BSD-3-Clause
# More threads than the machine can use, or than the limits allow, are not started: a run goes on with fewer
# and says so, or ends with 71 and a message.
small_job job.yaml
export OMP_NUM_THREADS=100000
expect 0 'warning: [0-9]+ threads instead of 100000 on [0-9]+ cores?: more would only wait' "$SEGCAST" render job.yaml -o many
export OMP_NUM_THREADS=1
"$SEGCAST" render job.yaml -o ref -q >/dev/null
[ "$(hashes many)" = "$(hashes ref)" ] || fail "the frames depend on the number of threads"
expect 0 '' "$SEGCAST" help keys

[ "$(id -u)" = 0 ] || skip "only root can try the limit of processes as another user"
command -v setpriv >/dev/null || skip "no setpriv"
user=54321 # who has no other processes
chmod 777 .
chmod a+x .. # the way to it
as_user() { (ulimit -u "$1"; shift; exec setpriv --reuid $user --regid $user --clear-groups env HOME="$PWD" TMPDIR="$PWD" "$@"); }
as_user 100 "$SEGCAST" --version >/dev/null || skip "another user cannot run segcast where it was built"
video=(--set output.video=film.mp4 --set output.fps=5)
expect 0 'warning: [0-9]+ threads instead of 16 on .*: the system allows no more \(ulimit -u' \
    as_user 30 "$SEGCAST" render job.yaml -o limited --threads 16 "${video[@]}"
[ "$(hashes limited)" = "$(hashes ref)" ] || fail "the frames of a limited run differ"
expect 71 'only [0-9]+ threads can be started beside the first' \
    as_user 8 "$SEGCAST" render job.yaml -o none --threads 16 "${video[@]}"
one_error
expect 71 'only [0-9]+ threads' as_user 2 "$SEGCAST" convert phantom:20x20x20 -o p.nrrd
one_error

# The ranks of a host share the limit: what each can start is tried by all at the same time.
expect 0 'warning: .*threads instead of 16' as_user 90 mpirun -n 2 "$SEGCAST" render job.yaml -o both --threads 16 "${video[@]}"
[ "$(hashes both)" = "$(hashes ref)" ] || fail "the frames of two limited ranks differ"
