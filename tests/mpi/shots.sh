# SPDX-License-Identifier: BSD-3-Clause
# A film of shots on several ranks, and one that was continued, are the same frames and, byte for byte, the same video, which
# has a chapter for each shot that has a name. property.films draws frames alone, stills and the resolved job of such films.
cat >job.yaml <<'YAML'
volume: phantom:59x41x61
output: {directory: out, size: [96, 72], video: film.mp4, fps: 10, title: The film}
tissues: {"*": {opacity: 0.6}}
overlays: {time: top-left}
animation:
  frames: 0.7 s
  camera: {orbit: {elevation: 10}}
shots:
  - card: ["Cœur", a card]
    animation: {frames: 5}
  - name: Turn
    transition: fade 0.6 s
    overlays: {names: [aorta], legend: bottom-right}
  - name: Open
    transition: cut
    animation: {clip: [{normal: posterior, at: {0%: 0%, 100%: 60%}}], verbs: [{fade: aorta, to: 0}]}
    render: {background: "#203040"}
    light: {shadows: true}
  - transition: cross_fade 400 ms
    animation: {slices: through}
    tissues: {epicardial fat: {visible: false}}
  - card: End
    name: The end
    transition: cross_fade 300 ms
    fade_out: 100 ms
    render: {background: black}
    animation: {frames: 4}
YAML
"$SEGCAST" render job.yaml -o one -q --set output.frames=png >/dev/null
frames=$(hashes one | wc -l)
[ "$frames" = 23 ] || fail "the film has $frames frames, expected 5 + 7 + 7 + 7 - 4 + 4 - 3 = 23"
[ "$(hashes one | cut -d' ' -f2 | sort -u | wc -l)" = 23 ] || fail "frames repeat"

OMP_NUM_THREADS=2 mpi 3 "$SEGCAST" render job.yaml -o three -q --set farm.partition=tiles --set farm.tile=48 --cpu c >/dev/null
[ "$(hashes one)" = "$(hashes three)" ] && cmp one/film.mp4 three/film.mp4 || fail "three ranks make another film"
"$SEGCAST" render job.yaml -o parts -q --frames 10-15 >/dev/null
mpi 2 "$SEGCAST" render job.yaml -o parts -q --resume >/dev/null
[ "$(hashes parts | uniq)" = "$(hashes one)" ] && cmp one/film.mp4 parts/film.mp4 || fail "a film that was continued differs"
"$SEGCAST" verify parts >/dev/null || fail "the film is not verified"

# Chapters, in every format; the first begins with the film
for video in film.mp4 film.mkv film.webm film.mov; do
    [ $video = film.mp4 ] || "$SEGCAST" render job.yaml -o "$video.out" -q --set output.video=$video >/dev/null
    [ $video != film.mp4 ] || cp -r one "$video.out"
    "$VIDEO_PROBE" "$video.out/$video" chapters >chapters.txt
    printf '%s\n' '0.000 0.500 The film' '0.500 1.200 Turn' '1.200 1.900 Open' '1.900 2.300 The end' >expected.txt
    diff expected.txt chapters.txt || fail "the chapters of $video differ from the shots"
    "$VIDEO_PROBE" "$video.out/$video" | grep -q '^23 frames of 96 x 72' || fail "$video does not hold 23 frames"
done

# What is told of a film before it is drawn
"$SEGCAST" check job.yaml | grep -q 'ok: 23 frames' || fail "check"
"$SEGCAST" plan job.yaml --json | jq -e '.frames == 23 and .memory.derived_bytes > 0' >/dev/null || fail "plan"
"$SEGCAST" still job.yaml -o sheet.png -q --sheet 5 >/dev/null || fail "a sheet"
# Other shots are another job
expect 73 '' "$SEGCAST" render job.yaml -o one --resume -q --set shots.1.light.shadows=true
# A tissue that the volume has not is told with its line
expect 65 'tissue "aortaa" matches no label' "$SEGCAST" check job.yaml --set 'shots.1.tissues={aortaa: {opacity: 1}}'
one_error
