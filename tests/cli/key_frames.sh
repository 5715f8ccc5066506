# SPDX-License-Identifier: BSD-3-Clause
# What has key frames is, in each frame, as if it were constant with the value that it has there: nothing is
# kept from another frame, or made once for all of them.
cat >job.yaml <<'EOF'
volume: phantom:59x41x61
output: {size: [96, 72], video: none}
tissues: {"*": {opacity: 0.6}}
animation:
  frames: 5
  camera: {orbit: {turns: 0, elevation: 10}}
EOF

frame() { # frame DIR FRAME: print the hash of a frame
    hashes "$1" | sed -n "s/^$2 //p"
}
# as_constant NAME KEY KEY_FRAMES {FRAME VALUE}...: with the key frames, the key is as if it were VALUE in FRAME
as_constant() {
    local name=$1 key=$2 n=0
    "$SEGCAST" render job.yaml -o "$name" -q --set "$key=$3" >/dev/null
    shift 3
    [ "$(hashes "$name" | cut -d' ' -f2 | sort -u | wc -l)" -gt 1 ] || fail "$name: $key does not change the picture"
    while [ $# -gt 0 ]; do
        n=$((n + 1))
        "$SEGCAST" render job.yaml -o "$name-$n" -q --frames "$1" --set "$key=$2" >/dev/null
        [ "$(frame "$name" "$1")" = "$(frame "$name-$n" "$1")" ] || fail "$name: frame $1 is not as with $key=$2"
        shift 2
    done
}

# Light: frame 2 is in the middle, where the strength is the mean of both.
for strength in ambient key fill head occlusion edges depth_cue; do
    as_constant $strength light.$strength '[{at: 0%, value: 0}, {at: 4f, value: 0.5}]' 0 0 2 0.25 4 0.5
done
