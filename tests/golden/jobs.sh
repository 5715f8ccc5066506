# SPDX-License-Identifier: BSD-3-Clause
# Every job of jobs/ and jobs/verbs/ runs, at a small size, and five of its frames are equal to the pictures kept here.
# To replace these, after looking at the new ones: GOLDEN_UPDATE=1 ctest -L golden
golden=$SOURCE/tests/golden
outdated=()
"$SEGCAST" phantom --size 117x81x122 --beating 10 -o beat.nrrd -q >/dev/null
for job in "$SOURCE"/jobs/*.yaml "$SOURCE"/jobs/verbs/*.yaml; do
    name=$(basename "$job" .yaml)
    volume=phantom:117x81x122
    ! grep -q '^cine:' "$job" || volume='beat-*.nrrd'
    frames=$("$SEGCAST" check --fast "$job" --set volume="$volume" 2>check.txt | sed -n 's/.*: ok: \([0-9]*\) frames .*/\1/p')
    ! grep "crops what is shown" check.txt || fail "$name: a job that is shown to others leaves nothing out by its zoom"
    short=5
    rate=30
    grep -q '^shots:' "$job" && short=$frames # each shot has frames of its own
    if [ "$short" -gt 200 ]; then             # a long film, with all its times in seconds
        rate=2
        short=$((frames * rate / 30))
    fi
    chosen=0,$((frames / 4)),$((frames / 2)),$((frames * 3 / 4)),$((frames - 1))
    "$SEGCAST" render "$job" -o "$name" -q --frames "$chosen" --set volume="$volume" \
        --set output.size=[160,90] --set output.frames=png >/dev/null
    "$SEGCAST" render "$job" -o "$name-short" -q --set volume="$volume" \
        --set output.size=[160,90] --set output.fps=$rate --set animation.frames=$short >/dev/null
    "$VIDEO_PROBE" "$name-short/$name.mp4" | grep -q "$short frames of 160 x 90" || fail "$name: the video does not hold $short frames of 160 x 90"
    for picture in "$name"/frames/*.png; do
        keep=$golden/$name-$(basename "$picture")
        [ -z "${GOLDEN_UPDATE:-}" ] || cp "$picture" "$keep"
        [ -e "$keep" ] || fail "there is no picture $keep to compare with"
        # Pixels are compared with a tolerance: another compiler may change the last bit of some.
        "$IMAGE_DIFFERENCE" "$picture" "$keep" 255 0.5 || fail "$name: $(basename "$picture") differs from $keep"
    done
    case $job in
    */verbs/*)
        [ -s "$SOURCE/docs/verbs/$name.webp" ] && grep -q "verbs/$name.webp.*jobs/verbs/$name.yaml" "$SOURCE/docs/verbs.md" ||
            fail "$name: docs/verbs.md does not show its film: add a line, and run tools/verb-films $name"
        # With which of these pictures a film was made, tools/verb-films has written down.
        sum=$(cat "$golden/$name"-[0-9]*.png | sha256sum | cut -c 1-16)
        grep -qx "$name $sum" "$SOURCE/docs/verbs/pictures.txt" ||
            outdated+=("$name")
        ;;
    esac
    [ "$(ls "$golden" | grep -c "^$name-[0-9]*.png")" = 5 ] || fail "$name: expected 5 pictures in $golden"
done
[ ${#outdated[@]} = 0 ] ||
    fail "the films of docs/verbs are older than the pictures of their jobs: run tools/verb-films ${outdated[*]}"
