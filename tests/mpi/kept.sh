# SPDX-License-Identifier: BSD-3-Clause
# What several ranks have prepared together is kept once, by rank 0, and the file is that of one rank; all ranks read it.
export SEGCAST_CACHE=$PWD/kept
small_job job.yaml
film() { # film RANKS FOUND: so many ranks draw the frames of one that keeps nothing, and find what was kept, or not
    local found
    rm -rf out
    mpi "$1" "$SEGCAST" render job.yaml -o out 2>film.txt >/dev/null || { cat film.txt >&2; fail "$1 ranks: no film"; }
    [ "$(hashes out)" = "$(hashes new)" ] || fail "$1 ranks: other frames"
    found=$(grep -c 'the volume was prepared before, and kept' film.txt) || true
    [ "$found" = "$2" ] || { cat film.txt >&2; fail "$1 ranks: found $found, expected $2"; }
    [ "$(find kept -type f | wc -l)" = 1 ] || fail "$1 ranks: kept $(ls -A kept)"
}
SEGCAST_CACHE=off "$SEGCAST" render job.yaml -o new -q >/dev/null
film 1 0
sum=$(cksum kept/*.segc)
rm kept/*.segc
film 3 0
[ "$(cksum kept/*.segc)" = "$sum" ] || fail "three ranks keep another file than one: $(cksum kept/*.segc), expected $sum"
film 2 1
truncate -s 5000 kept/*.segc
film 2 0
film 1 1
# Thick slices, which become layers, are prepared and found by the voxels as they were read.
rm -r kept new
sed -i 's/phantom:59x41x61/phantom:118x82x16/' job.yaml
SEGCAST_CACHE=off "$SEGCAST" render job.yaml -o new -q >/dev/null
film 2 0
film 1 1
film 3 1
# So is the light that was gathered: two ranks find that of one, and draw the same frames; what is damaged they gather together.
rm -r kept new
sed -i 's/phantom:.*/phantom:144x116x152/; s/frames: 7/frames: 2/; /clip:/,$d' job.yaml
echo 'look: atlas' >>job.yaml
SEGCAST_CACHE=off "$SEGCAST" render job.yaml -o new -q >/dev/null
lit() { # lit RANKS: so many ranks draw the frames
    rm -rf out
    mpi "$1" "$SEGCAST" render job.yaml -o out -q >/dev/null || fail "$1 ranks: no lit film"
    [ "$(hashes out)" = "$(hashes new)" ] || fail "$1 ranks: other lit frames"
}
lit 1
file=$(ls kept/*.light)
touch -d '2001-02-03 UTC' "$file"
lit 2
[ "$(stat -c '%Y' "$file")" = 981158400 ] && [ "$(stat -c '%X' "$file")" != 981158400 ] || fail "two ranks gather light that is kept"
truncate -s 3000 "$file"
lit 2
