# SPDX-License-Identifier: BSD-3-Clause
# Every job of jobs/ and jobs/verbs/ runs, at a small size: it makes the frames and the video it promises, shows something,
# moves, and where the camera turns once and nothing else happens, the last frame leads back to the first. docs/verbs.md
# shows a film of each verb, made from its present job.
"$SEGCAST" convert phantom:59x41x61 --beating 4 -o beat.nrrd -q >/dev/null
for job in "$SOURCE"/jobs/*.yaml "$SOURCE"/jobs/verbs/*.yaml; do
    name=$(basename "$job" .yaml)
    settings=(-q --set output.size=[160,90] --set volume=phantom:59x41x61)
    ! grep -q '^cine:' "$job" || settings+=(--set 'volume=beat-*.nrrd')
    frames=$("$SEGCAST" check --fast "$job" "${settings[@]:1}" 2>check.txt | sed -n 's/.*: ok: \([0-9]*\) frames .*/\1/p')
    ! grep "crops what is shown" check.txt || fail "$name: a job that is shown to others leaves nothing out by its zoom"
    short=5 rate=30
    ! grep -q '^shots:' "$job" || short=$frames # each shot has frames of its own
    if [ "$short" -gt 200 ]; then               # a long film, with all its times in seconds
        rate=2
        short=$((frames * rate / 30))
    fi
    "$SEGCAST" render "$job" -o "$name" "${settings[@]}" --set output.fps=$rate --set animation.frames=$short >/dev/null
    jq -e '[.frames[].samples] | add > 0' "$name"/stats.*json >/dev/null || fail "$name: nothing is seen"
    "$VIDEO_PROBE" "$name/$name.mp4" | grep -q "$short frames of 160 x 90" || fail "$name: the video does not hold $short frames of 160 x 90"
    [ "$(hashes "$name" | cut -d' ' -f2 | sort -u | wc -l)" -gt 2 ] || fail "$name: nothing moves"
    if grep -q 'turns: 1[,}]' "$job" && ! grep -qE '^( *clip|shots|compare|color_by):|slices' "$job"; then
        "$SEGCAST" render "$job" -o "$name-turn" "${settings[@]}" --frames "0,$((frames / 2)),$((frames - 1))" --set output.frames=png >/dev/null
        rms=()
        for other in $((frames - 1)) $((frames / 2)); do
            rms+=("$("$IMAGE_DIFFERENCE" "$name-turn"/frames/000000.png "$name-turn/frames/$(printf %06d "$other").png" 255 | sed -n 's/.*rms \([0-9]*\)\..*/\1/p')")
        done
        [ "${rms[1]}" -gt $((2 * rms[0])) ] || fail "$name: the last frame differs from the first by ${rms[0]} levels, the middle one by ${rms[1]}"
    fi
done
for job in "$SOURCE"/jobs/verbs/*.yaml; do
    name=$(basename "$job" .yaml)
    [ -s "$SOURCE/docs/verbs/$name.webp" ] && grep -q "verbs/$name.webp.*jobs/verbs/$name.yaml" "$SOURCE/docs/verbs.md" ||
        fail "$name: docs/verbs.md does not show its film: add a line, and run tools/verb-films $name"
done
# With which jobs the films were made, tools/verb-films has written down.
cd "$SOURCE/jobs/verbs"
outdated=$(sha256sum ./*.yaml | sed 's|\./||' | LC_ALL=C sort -k 2 | diff - "$SOURCE/docs/verbs/jobs.sha256" | sed -n 's/^< .* \([a-z-]*\).yaml/\1/p' | xargs)
[ -z "$outdated" ] || fail "the films of docs/verbs are older than their jobs: run tools/verb-films $outdated"
