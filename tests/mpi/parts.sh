# SPDX-License-Identifier: BSD-3-Clause
# Some of the ranks can work together while the others wait; see test_parts.c.
timeout 60 mpirun -n 3 "$BUILD/tests/test_parts" || fail "exit $?"
