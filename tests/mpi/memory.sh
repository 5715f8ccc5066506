# SPDX-License-Identifier: BSD-3-Clause
# What is derived from the volume for drawing stands in memory once per node: every rank maps all of it, and has
# next to nothing for itself. The bytes are those that the system counts of the files that ranks map.
[ -r /proc/self/maps ] || skip "no /proc/PID/maps"
export SEGCAST_CACHE=off # what is kept is mapped by all anyhow
small_job job.yaml
sed -i 's/phantom:59x41x61/phantom:200x160x200/; s/frames: 7/frames: 4000/' job.yaml
name=sc_memory_$$ # to find the ranks by, under any launcher
ln -s "$SEGCAST" "$name"

# mapped: print, for each rank, its PID and the bytes of the files of segcast that it maps. A process that maps nothing at all is
# a rank of an earlier run that has ended, but of which nobody has taken notice yet.
mapped() {
    local pid maps low high
    for pid in $(pgrep -x "$name"); do
        maps=$(cat "/proc/$pid/maps" 2>/dev/null || true)
        [ -n "$maps" ] || continue
        while IFS=' -' read -r low high _; do
            echo $((0x$high - 0x$low))
        done < <(grep -F .segcast.tmp. <<<"$maps" || true) | awk -v pid="$pid" '{sum += $1} END {print pid, sum + 0}'
    done
}
for ranks in 2 3; do
    mpi $ranks "./$name" render job.yaml -o out$ranks >stdout.txt 2>stderr.txt &
    launcher=$!
    trap 'kill -KILL $launcher $(pgrep -x "$name") 2>/dev/null || true' EXIT
    wait_until '[ "$(frames out$ranks)" -gt 5 ]'
    mapped >mapped.txt
    kill -USR1 "$(awk 'END {print $1}' mapped.txt)" # not the last of pgrep, which may have ended already
    code=0
    wait $launcher || code=$?
    [ $code = 75 ] || { cat stderr.txt >&2; fail "exit $code, expected 75"; }
    [ "$(wc -l <mapped.txt)" = $ranks ] || fail "expected $ranks ranks, found: $(cat mapped.txt)"
    shared=$(jq '.memory.prepared_bytes + .memory.derived_bytes' out$ranks/stats.json)
    jq -e '.memory.derived_bytes > 10 * .memory.renderer_bytes' out$ranks/stats.json >/dev/null ||
        fail "stats.json: $(jq -c .memory out$ranks/stats.json)"
    while read -r _ bytes; do
        [ "$bytes" -ge "$shared" ] || fail "a rank maps $bytes bytes that it shares, expected at least $shared"
    done <mapped.txt
done
[ "$(jq .memory.derived_bytes out2/stats.json)" = "$(jq .memory.derived_bytes out3/stats.json)" ] ||
    fail "what is derived depends on the number of ranks"
