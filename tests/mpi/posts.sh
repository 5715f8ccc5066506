# SPDX-License-Identifier: BSD-3-Clause
# Messages can be posted although no memory is left; see test_posts.c.
timeout 60 mpirun -n 2 "$BUILD/tests/test_posts" || fail "exit $?"
