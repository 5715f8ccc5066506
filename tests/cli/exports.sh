# SPDX-License-Identifier: BSD-3-Clause
# Every kind of video: the same bytes from one rank, from several and from runs that were continued; verified;
# its frames are those of the PNG files within what the codec loses; alpha is kept. Small pictures with sharp
# edges: colours are stored at half the resolution by most.
small_job job.yaml
"$SEGCAST" convert job.yaml -o heart.segc -q >/dev/null
sed -i 's/, video: none/, fps: 3, crf: 10/; s/^volume: .*/volume: heart.segc/' job.yaml
# extension, codec, background, largest root mean square of the error of a frame in levels of 8 bits, who encodes with 2 ranks;
# every codec is encoded by segments once
kinds='mp4 h264 white 8 segments
mp4 h265 white 8 segments
mkv h265 white 8 gather
webm av1 white 8 segments
webm vp9 white 8 gather
mkv vp9 none 8 segments
mov h264 white 8 gather
mov prores none 2 segments
webp auto white 8 gather
webp auto none 8 segments
gif auto white 8 segments'
# The encoders are libraries, which AddressSanitizer does not look into: there one kind for each way to write a file.
case $BUILD in */asan) kinds=$(grep -E '^(mp4 h264|mkv vp9|mov prores|webp auto none|gif)' <<<"$kinds") ;; esac
for background in white none; do
    "$SEGCAST" render job.yaml -o "$background" -q --set render.background=$background --set output.video=none --set output.frames=png >/dev/null
done
missing=
while read -r extension codec background rms encode; do
    name=$extension-$codec-$background video=v.$extension
    kind=(--set output.video="$video" --set output.codec="$codec" --set render.background="$background")
    if ! "$SEGCAST" check job.yaml "${kind[@]}" >/dev/null 2>check.txt; then
        grep -q 'this libavcodec has no encoder' check.txt || { cat check.txt >&2; fail "$name is refused"; }
        missing="$missing $codec"
        continue
    fi
    "$SEGCAST" render job.yaml -o "$name" -q "${kind[@]}" >/dev/null
    expect 0 '' "$SEGCAST" verify "$name"
    mpi 2 "$SEGCAST" render job.yaml -o "$name-$encode" -q "${kind[@]}" --set farm.encode="$encode" </dev/null >/dev/null
    cmp "$name/$video" "$name-$encode/$video" || fail "$name: the video depends on who encodes"
    if [ "$encode" = segments ]; then
        "$SEGCAST" render job.yaml -o "$name-parts" -q "${kind[@]}" --frames 0-3 >/dev/null
        "$SEGCAST" render job.yaml -o "$name-parts" -q "${kind[@]}" --resume >/dev/null
        cmp "$name/$video" "$name-parts/$video" || fail "$name: a run that was continued makes another video"
    fi
    for frame in 0 4 6; do
        "$VIDEO_PROBE" "$name/$video" $frame frame.png | grep -q '^7 frames of 96 x 72, last at 2.0' ||
            fail "$name: $("$VIDEO_PROBE" "$name/$video")"
        "$IMAGE_DIFFERENCE" -p "$background/frames/00000$frame.png" frame.png 255 "$rms" >difference.txt ||
            fail "$name: frame $frame differs: $(cat difference.txt)"
    done
done <<<"$kinds"

# A film in which nothing moves keeps all its frames, and one of a single frame is a film.
for extension in gif webp; do
    "$SEGCAST" render job.yaml -o still-$extension -q --set output.video=v.$extension --set animation.camera.orbit.turns=0 \
        --set 'animation.clip=[]' >/dev/null 2>check.txt || { grep -q 'no encoder' check.txt && continue; fail "$(cat check.txt)"; }
    expect 0 '' "$SEGCAST" verify still-$extension
    "$SEGCAST" orbit phantom:59x41x61 --frames 1 --size 65x33 -q -o one.$extension >/dev/null
    "$VIDEO_PROBE" one.$extension | grep -q '^1 frames of 66 x 34' || fail "one.$extension: $("$VIDEO_PROBE" one.$extension)"
done
grep -aq 'NETSCAPE2.0' still-gif/v.gif 2>/dev/null || [ ! -e still-gif/v.gif ] || fail 'the GIF does not loop'

# What a format does to a film is told, and pictures are as large as 8K, also upright.
large=(--set output.video=turn.gif --set output.size=8k --set output.fps=30)
expect 0 'turn.gif: 7 frames of 320 x 180 take about 0.0[0-9] MB' "$SEGCAST" check job.yaml --set output.video=turn.gif --set output.size=320x180
expect 0 'turn.gif: 7 frames of 7680 x 4320 take about 23 MB' "$SEGCAST" check job.yaml "${large[@]}"
grep -q 'output.fps is 30: a GIF counts in hundredths .* for 3 or 4 of them' stderr.txt || fail 'nothing is said of the times of a GIF'
expect 0 'more than the 35.7 million pixels for which H.264 has levels' "$SEGCAST" check job.yaml --set output.size=8000x8000 --set output.video=v.mp4
for video in v.mp4 v.webm v.webp v.gif; do
    "$SEGCAST" check job.yaml --set output.size=4320x7680 --set output.video=$video >/dev/null 2>check.txt ||
        grep -q 'no encoder' check.txt || fail "$(cat check.txt)"
    ! grep -q levels check.txt || fail 'a picture of 8K is said to be beyond all levels'
done
expect 0 '' "$SEGCAST" still job.yaml --frame 3 --set output.size=64x7680 --set render.quality=draft -o upright.png -q
od -An -tx1 -j16 -N8 upright.png | grep -q '00 00 00 40 00 00 1e 00' || fail 'the picture is not 64 x 7680'

[ -z "$missing" ] || skip "this libavcodec has no encoder of$missing"
