# Posting messages needs no memory that could fail to be had in the middle of a run.
timeout 60 mpirun -n 2 "$BUILD/tests/test_posts" || fail "exit $?"
