# SPDX-License-Identifier: BSD-3-Clause
# Where /dev/shm is too small for the prepared volume (containers have 64 MB by default), the ranks share it
# in a file, or each has a copy. No run hangs, the user is told, and the frames stay the same.
[ "$(uname -s)" = Linux ] || skip "/dev/shm is a matter of Linux"
unshare --mount true 2>/dev/null || skip "mount namespaces are not permitted here"
disk=$(mktemp -d /tmp/segcast.XXXXXX)
trap 'rm -rf "$disk"' EXIT
cd "$disk" # which no other /dev/shm hides
export SEGCAST_CACHE=off
mkdir tmp full
unshare --mount mount -t tmpfs -o size=64k tmpfs full 2>/dev/null || skip "mounting a tmpfs is not permitted here"

small_job job.yaml
sed -i 's/phantom:59x41x61/phantom:200x160x200/' job.yaml
"$SEGCAST" render job.yaml -o ref -q >/dev/null
kb=$(($(jq .memory.prepared_bytes ref/stats.json) / 1024))
[ $kb -gt 8000 ] || fail "the volume is too small for this test: $kb kB"

# run WHAT SHM_KB TMPDIR COMMAND...: run mpirun in a namespace whose /dev/shm has SHM_KB and whose full/ is full.
run() {
    local what=$1 shm=$2 folder=$3 code=0
    shift 3
    rm -rf out
    # shellcheck disable=SC2016
    timeout -k 5 100 unshare --mount bash -c '
        mount -t tmpfs -o size=$1k tmpfs /dev/shm && mount -t tmpfs -o size=64k tmpfs full || exit 1
        export TMPDIR=$2 # of segcast; the folder of the launcher stays where it was
        export OMPI_MCA_orte_tmpdir_base=/tmp
        shift 2
        "$@"
        code=$?
        ls -A /dev/shm full tmp | grep "^[.]segcast" && echo "segcast: error: a file is left"
        exit $code' bash "$shm" "$folder" "$@" >stdout.txt 2>stderr.txt || code=$?
    [ $code = 0 ] || { cat stdout.txt stderr.txt >&2; fail "$what: exit code $code (124: it hangs)"; }
    ! grep -h 'error\|not enough space' stdout.txt stderr.txt || fail "$what: see above"
    [ "$(hashes out)" = "$(hashes ref)" ] || fail "$what: the frames differ"
}
told() { grep -q "warning: $1" stderr.txt || { cat stderr.txt >&2; fail "nobody is told: $1"; }; }

run "enough room" $((4 * kb)) "$PWD/tmp" mpirun -n 2 "$SEGCAST" render job.yaml
! grep -q 'has no room' stderr.txt || fail "a warning although there is room"
run "a file" $kb "$PWD/tmp" mpirun -n 2 "$SEGCAST" render job.yaml
told '/dev/shm has no room for the prepared volume .*: 2 of 2 ranks map a file'
grep -q '/dev/shm is too small .*: rank 0 prepares it alone' stderr.txt || fail "nobody is told that one rank prepares"
run "copies" $kb "$PWD/full" mpirun -n 3 "$SEGCAST" render job.yaml
told 'neither /dev/shm nor .*/full has room for the prepared volume .*: 3 of 3 ranks hold a copy each'
# Open MPI's own shared memory has no room there either.
OMPI_MCA_btl=tcp,self run "copies of all" 64 "$PWD/full" mpirun -n 2 "$SEGCAST" render job.yaml
told 'neither /dev/shm nor .*/full has room for the prepared volume .*: 2 of 2 ranks hold a copy each'
told 'neither /dev/shm nor .*/full has room for what is derived .*: 2 of 2 ranks hold a copy each'
run "no such folder" $kb /nowhere mpirun -n 2 "$SEGCAST" render job.yaml
told 'neither .* 2 of 2 ranks hold a copy each'

# One rank alone sees another /dev/shm, as in a container of its own: then they cannot share there.
# shellcheck disable=SC2016
alone='mount -t tmpfs -o size=1m tmpfs /dev/shm && exec "$@"'
export OMPI_MCA_btl=tcp,self
run "one rank" $((4 * kb)) "$PWD/tmp" mpirun -n 1 "$SEGCAST" render job.yaml : \
    -n 1 unshare --mount bash -c "$alone" bash "$SEGCAST" render job.yaml
told '/dev/shm has no room .*: 2 of 2 ranks map a file'
