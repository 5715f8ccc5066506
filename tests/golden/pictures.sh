# SPDX-License-Identifier: BSD-3-Clause
# Pictures of what is hard to draw are those kept in tests/golden. README.md there is the list: each with its job, its frame
# and what to look at. To replace them, after looking at the new ones: GOLDEN_UPDATE=1 ctest -R golden
golden=$SOURCE/tests/golden
most=24
seen=$BUILD/golden-differing # the pictures of the last failure
rm -rf "$seen"

for kind in torso slices hand seams; do
    "$HARD_VOLUME" "$kind" "$kind.nrrd"
    "$SEGCAST" convert "$kind.nrrd" -o "$kind.segc" -q >/dev/null
done
"$SEGCAST" convert phantom:117x81x122 -o phantom.segc -q >/dev/null

sed -nE 's/^\| !\[([a-z-]+)\]\(\1\.png\) \| ([^|]*[^ |]) \| ([0-9]+) \| ([^|]{20,}) \|$/\1;\2;\3;\4/p' "$golden/README.md" >list.txt
[ "$(grep -c '\.png' "$golden/README.md")" = "$(wc -l <list.txt)" ] || fail "a row of $golden/README.md names a picture without a job, a frame and what to look at"
[ "$(wc -l <list.txt)" -le $most ] || fail "there are $(wc -l <list.txt) pictures, at most $most are kept: which one does a new one replace?"
[ -n "${GOLDEN_UPDATE:-}" ] || diff <(cut -d';' -f1 list.txt | LC_ALL=C sort) <(basename -s .png -a "$golden"/*.png | LC_ALL=C sort) ||
    fail "README.md lists other pictures (<) than are kept (>)"
diff <(cut -d';' -f2 list.txt | sed -n 's|^tests/golden/||p' | LC_ALL=C sort -u) <(basename -a "$golden"/*.yaml | LC_ALL=C sort) ||
    fail "README.md lists other jobs (<) than are in tests/golden (>)"

differing=()
while IFS=';' read -r name job frame sentence; do
    volume=$(sed -n 's/^volume: //p' "$SOURCE/$job")
    size=() # of the jobs that are shown to others
    [ "${job%/*}" = tests/golden ] || size=(--size 640x360)
    "$SEGCAST" still "$SOURCE/$job" --frame "$frame" -o "$name.png" -q --set volume="${volume%.nrrd}.segc" "${size[@]}" >/dev/null 2>stderr.txt || { cat stderr.txt >&2; fail "$name: not drawn"; }
    if [ -n "${GOLDEN_UPDATE:-}" ]; then
        cp "$name.png" "$golden"
    # Pixels are compared with a tolerance: another compiler may change the last bit of some.
    elif ! how=$("$IMAGE_DIFFERENCE" "$name.png" "$golden/$name.png" 255 0.3); then
        differing+=("$name")
        mkdir -p "$seen"
        cp "$name.png" "$seen"
        printf '%s differs (%s). Look at: %s\n' "$name" "$how" "$sentence" >&2
    fi
done <list.txt
[ ${#differing[@]} = 0 ] || fail "${#differing[@]} pictures differ from those in tests/golden (the new ones: $seen): ${differing[*]}"
