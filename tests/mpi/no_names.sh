# SPDX-License-Identifier: BSD-3-Clause
# The start of MPI asks no name server, and looks for no display: where /etc/hosts is missing, that would take
# seconds for each run.
small_job job.yaml
command -v strace >/dev/null || skip "strace is not installed"
strace -f -e trace=connect -o trace.txt true 2>/dev/null || skip "strace is not permitted here"
strace -f -e trace=connect -o trace.txt mpirun -n 2 "$SEGCAST" render job.yaml -q >/dev/null
[ -s trace.txt ] || fail "nothing was traced"
! grep -E 'htons\((53|60[0-9][0-9])\)|X11-unix' trace.txt || fail "a name server or a display was asked"
