# SPDX-License-Identifier: BSD-3-Clause
# Every kind of video: the same bytes from one rank, from several and from runs that were continued; verified;
# its frames are those of the PNG files within what the codec loses; alpha is kept. Small pictures with sharp
# edges: colours are stored at half the resolution by most.
small_job job.yaml
sed -i 's/, video: none/, fps: 3, crf: 10/' job.yaml
# extension, codec, background, largest root mean square of the error of a frame, in levels of 8 bits
kinds='mp4 h264 white 8
mp4 h265 white 8
mp4 av1 white 8
mkv h265 white 8
mkv vp9 white 8
webm vp9 white 8
webm av1 white 8
mov h264 white 8
mov prores white 2
mov prores none 2
webm vp9 none 8
mkv vp9 none 8
webp auto white 8
webp auto none 8'
for background in white none; do
    "$SEGCAST" render job.yaml -o "$background" -q --set render.background=$background --set output.video=none --set output.frames=png >/dev/null
done
missing=
while read -r extension codec background rms; do
    name=$extension-$codec-$background video=v.$extension
    kind=(--set output.video="$video" --set output.codec="$codec" --set render.background="$background")
    if ! "$SEGCAST" check job.yaml "${kind[@]}" >/dev/null 2>check.txt; then
        grep -q 'this libavcodec has no encoder' check.txt || { cat check.txt >&2; fail "$name is refused"; }
        missing="$missing $codec"
        continue
    fi
    "$SEGCAST" render job.yaml -o "$name" -q "${kind[@]}" >/dev/null
    expect 0 '' "$SEGCAST" verify "$name"
    for encode in segments gather; do
        mpi 2 "$SEGCAST" render job.yaml -o "$name-$encode" -q "${kind[@]}" --set farm.encode=$encode </dev/null >/dev/null
        cmp "$name/$video" "$name-$encode/$video" || fail "$name: the video depends on who encodes"
    done
    "$SEGCAST" render job.yaml -o "$name-parts" -q "${kind[@]}" --frames 0-3 >/dev/null
    "$SEGCAST" render job.yaml -o "$name-parts" -q "${kind[@]}" --resume >/dev/null
    cmp "$name/$video" "$name-parts/$video" || fail "$name: a run that was continued makes another video"
    for frame in 0 4 6; do
        "$VIDEO_PROBE" "$name/$video" $frame frame.png | grep -q '^7 frames of 96 x 72, last at 2.0' ||
            fail "$name: $("$VIDEO_PROBE" "$name/$video")"
        "$IMAGE_DIFFERENCE" -p "$background/frames/00000$frame.png" frame.png 255 "$rms" >difference.txt ||
            fail "$name: frame $frame differs: $(cat difference.txt)"
    done
done <<<"$kinds"
[ -z "$missing" ] || skip "this libavcodec has no encoder of$missing"
