# SPDX-License-Identifier: BSD-3-Clause
# What several ranks have prepared together is kept once, by rank 0, and the file is that of one rank; all ranks read it.
export SEGCAST_CACHE=$PWD/kept
printf 'volume: phantom:224x180x240\noutput: {size: [96, 64]}\n' >job.yaml # takes more than half a second to prepare
still() { # still RANKS FOUND: so many ranks draw the picture of one that keeps nothing, and find what was kept, or not
    local found=0
    mpi "$1" "$SEGCAST" still job.yaml -o still.png --overwrite 2>still.txt >/dev/null || { cat still.txt >&2; fail "$1 ranks: no picture"; }
    cmp still.png new.png || fail "$1 ranks: another picture"
    found=$(grep -c 'the volume was prepared before, and kept' still.txt) || true
    [ "$found" = "$2" ] || { cat still.txt >&2; fail "$1 ranks: found $found, expected $2"; }
    [ "$(find kept -type f | wc -l)" = 1 ] || fail "$1 ranks: kept $(ls -A kept)"
}
SEGCAST_CACHE=off "$SEGCAST" still job.yaml -o new.png -q >/dev/null
still 1 0
sum=$(cksum kept/*.segc)
rm kept/*.segc
still 3 0
[ "$(cksum kept/*.segc)" = "$sum" ] || fail "three ranks keep another file than one: $(cksum kept/*.segc), expected $sum"
still 2 1
truncate -s 5000 kept/*.segc
still 2 0
still 1 1
# Slices that jump are put back, or were; both are one preparation to the next run.
rm kept/*.segc
printf 'volume: {path: "phantom:224x180x30"}\noutput: {size: [96, 64]}\nrender: {samples: 1}\n' >job.yaml
SEGCAST_CACHE=off "$SEGCAST" still job.yaml -o new.png --overwrite -q >/dev/null
still 2 0
still 1 1
still 3 1
