# SPDX-License-Identifier: BSD-3-Clause
# Any number of ranks prepares the same bytes, in memory that they really share; see test_prepare_mpi.c.
for ranks in 1 2 3; do
    timeout 60 mpirun -n $ranks "$BUILD/tests/test_prepare_mpi" >hash$ranks.txt || fail "$ranks ranks: exit $?"
    [ "$(wc -l <hash$ranks.txt)" = 1 ] || fail "$ranks ranks print: $(cat hash$ranks.txt)"
    cmp -s hash1.txt hash$ranks.txt || fail "$ranks ranks prepare $(cat hash$ranks.txt), one prepares $(cat hash1.txt)"
done

# A whole run: the pictures, and that rank 1 has prepared before it prepared the light, too.
export SEGCAST_CACHE=off
small_job job.yaml
sed -i 's/phantom:59x41x61/phantom:200x160x200/' job.yaml
mpi 2 "$SEGCAST" render job.yaml -o together -q >/dev/null
"$SEGCAST" render job.yaml -o alone -q >/dev/null
[ "$(hashes together)" = "$(hashes alone)" ] || fail "the frames differ"
told=$(jq '[.traceEvents[] | select(.pid == 2 and .name == "prepare")] | length' together/trace.json)
[ "$told" = 2 ] || fail "the trace has $told times in which rank 1 prepares, expected 2: the volume, and the light"
