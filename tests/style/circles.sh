# SPDX-License-Identifier: BSD-3-Clause
# Within a module, files use each other's functions in one direction: no file calls back, directly or by
# way of others, into one that uses it.
count=0
for archive in "$BUILD"/src/*/libsc_*.a; do
    module=$(basename "$archive" .a)
    # "file symbol" of what each object defines and of what it uses
    nm -A --defined-only "$archive" 2>/dev/null | sed -n 's/^[^:]*:\([^:]*\):.* [A-TV-Z] \(sc_.*\)$/\2 \1/p' | sort >defined.txt
    nm -A --undefined-only "$archive" 2>/dev/null | sed -n 's/^[^:]*:\([^:]*\):.* U \(sc_.*\)$/\2 \1/p' | sort >used.txt
    [ -s defined.txt ] || fail "$module defines nothing"
    # pairs "user provider"
    join used.txt defined.txt | awk '$2 != $3 {print $2, $3}' | sort -u >pairs.txt
    tsort pairs.txt >/dev/null 2>circles.txt || true
    [ ! -s circles.txt ] || { cat circles.txt >&2; fail "$module: files call each other in a circle"; }
    count=$((count + $(wc -l <pairs.txt)))
done
[ "$count" -gt 50 ] || fail "only $count uses of one file by another were found"
