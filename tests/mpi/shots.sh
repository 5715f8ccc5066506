# SPDX-License-Identifier: BSD-3-Clause
# A film of shots: any frame alone, any rank, band of rows and order of runs gives the frame of the film, by hash; the
# video has a chapter for each shot that has a name, and is the same byte for byte whoever encodes it.
cat >job.yaml <<'YAML'
volume: phantom:59x41x61
output: {directory: out, size: [96, 72], video: film.mp4, fps: 10, title: The film}
tissues: {"*": {opacity: 0.6}}
overlays: {time: top-left}
animation:
  duration: 0.7 s
  camera: {orbit: {elevation: 10}}
shots:
  - card: {title: "Cœur", subtitle: a card}
    animation: {frames: 5}
  - name: Turn
    transition: {fade: 0.6 s}
    overlays: {names: [aorta], legend: bottom-right}
  - name: Open
    transition: cut
    animation: {clip: [{sweep: {normal: posterior, from: 0%, to: 60%}}], verbs: [{fade: {tissues: aorta, to: 0}}]}
    render: {background: "#203040"}
    light: {shadows: true}
  - transition: {cross_fade: 400 ms}
    output: {layout: views}
    tissues: {epicardial fat: {visible: false}}
  - card: {title: End}
    name: The end
    transition: {cross_fade: 300 ms}
    fade_out: 100 ms
    render: {background: black}
    animation: {frames: 4}
YAML
"$SEGCAST" render job.yaml -o one -q --set output.frames=png >/dev/null
frames=$(hashes one | wc -l)
[ "$frames" = 23 ] || fail "the film has $frames frames, expected 5 + 7 + 7 + 7 - 4 + 4 - 3 = 23"
[ "$(hashes one | cut -d' ' -f2 | sort -u | wc -l)" = 23 ] || fail "frames repeat"

# Frames alone, in any order, and stills
for k in 22 17 11 13 4 5 0; do
    "$SEGCAST" still job.yaml --frame $k -o still.png --overwrite -q >/dev/null
    "$IMAGE_DIFFERENCE" still.png "one/frames/$(printf %06d "$k").png" || fail "frame $k alone differs from the film's"
done
"$SEGCAST" render job.yaml -o some --frames 14-18,2-3 -q >/dev/null
[ "$(hashes some)" = "$(hashes one | sed -n '3,4p;15,19p')" ] || fail "some frames alone differ from the film's"

# Any number of ranks and threads, in tiles, with other kernels
for ranks in 1 2 3; do
    for partition in frames tiles; do
        OMP_NUM_THREADS=$((3 - ranks / 2)) mpi $ranks "$SEGCAST" render job.yaml -o "r$ranks$partition" -q --set farm.partition=$partition \
            --set farm.tile=$((16 * ranks)) --set render.skip=octree --cpu c >/dev/null
        [ "$(hashes one)" = "$(hashes "r$ranks$partition")" ] || fail "the pictures differ with $ranks ranks, $partition"
        cmp one/film.mp4 "r$ranks$partition/film.mp4" || fail "the video depends on ranks"
    done
done

# The resolved job is the same film, and a run that was interrupted goes on as one
cp one/job.yaml resolved.yaml
"$SEGCAST" render resolved.yaml -o again -q >/dev/null
[ "$(job_hash one)" = "$(job_hash again)" ] && cmp one/job.yaml again/job.yaml &&
    [ "$(hashes one)" = "$(hashes again)" ] || fail "the resolved job is another film"
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
