# SPDX-License-Identifier: BSD-3-Clause
# The simulation draws what real ranks that sleep instead of drawing draw, and more ranks are predicted and measured to
# be faster. How near the times are is not asked here, because that depends on what else the machine does.
compare() { # compare RANKS: the line that tells both
    mpi "$1" "$BUILD/tests/farm_load" compare 48 0.02 2e-5 3e-4 | tail -1
}
for ranks in 1 4; do
    compare "$ranks" >"$ranks.txt" || fail "$ranks ranks: $(cat "$ranks.txt")"
    grep -qE 'measured [0-9.]+ s, predicted [0-9.]+ s, .*; units drawn 48, predicted 48$' "$ranks.txt" ||
        fail "$ranks ranks: $(cat "$ranks.txt")"
done
time_of() { sed -n "s/.*$1 \([0-9.]*\) s.*/\1/p" "$2.txt"; }
for what in measured predicted; do
    awk "BEGIN {exit !($(time_of "$what" 4) < $(time_of "$what" 1))}" || fail "$what: four ranks are not faster: $(cat 1.txt 4.txt)"
done
