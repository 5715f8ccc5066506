# SPDX-License-Identifier: BSD-3-Clause
# The files of a finished job are those that the documentation promises.
small_job job.yaml
SEGCAST_CACHE=off "$SEGCAST" render job.yaml -o out -q --set output.video=film.mp4 --set output.frames=png >said.txt
[ "$(cat said.txt)" = out/film.mp4 ] || fail "standard output is not the path of the video: $(cat said.txt)"
[ "$(ls out | tr '\n' ' ')" = "film.mp4 frames frames.csv job.yaml manifest.jsonl report.html ro-crate-metadata.json stats.json status.json trace.json " ] ||
    fail "unexpected files in the output directory: $(ls -a out)"
[ -z "$(find out -name '.*.tmp.*')" ] || fail "temporary files are left"
"$VIDEO_PROBE" out/film.mp4 | grep -q '7 frames of 96 x 72, last at 0.2000 s' || fail "the video does not hold 7 frames of 96 x 72"
[ "$(ls out/frames | wc -l)" = 7 ] && [ -e out/frames/000006.png ] || fail "out/frames does not hold 7 PNG files"
jq -e '.state == "complete" and .done == 7 and .total == 7' out/status.json >/dev/null || fail "status.json: $(cat out/status.json)"
head -1 out/manifest.jsonl | jq -e '.frames == 7 and (.job_hash | length) == 16 and
    (.volume_hash | length) == 16 and .size == [96,72] and .version' >/dev/null || fail "first line of the manifest: $(head -1 out/manifest.jsonl)"
[ "$(hashes out | wc -l)" = 7 ] || fail "the manifest does not name 7 frames"
jq -e '.schema and .version and .host and .ranks == 1 and .threads == 1 and .nodes == 1 and
    .wall_s > 0 and .cpu_s > 0 and (.imbalance >= 0) and
    (.phases | keys) == ["encode","gather","idle","prepare","read","render","share","write"] and
    ([.phases[] | .wall_s >= 0 and .cpu_s >= 0] | all) and
    ([.phases | .read, .prepare, .share, .render, .encode, .write | .wall_s > 0] | all) and
    (.frames | length) == 7 and (.frames[3] | .frame == 3 and .rays > 0 and .samples > 0 and
      .render_cpu_s > 0 and (.hash | length) == 16) and
    .memory.volume_bytes == 59*41*61 and .memory.prepared_bytes > .memory.volume_bytes and
    (.memory.peak_rss_bytes | length) == 1 and .speed.frames_per_s > 0' out/stats.json >/dev/null ||
    fail "stats.json lacks values, or they are wrong: $(cat out/stats.json)"
jq -e '[.traceEvents[] | select(.ph == "X")] |
    ([.[] | select(.name | startswith("draw")) | .args.frame] | unique) == [0,1,2,3,4,5,6] and
    ([.[].name | split(" ")[0]] | unique) == ["draw","encode","finish","prepare","read","share"] and
    ([.[] | .dur >= 0 and .ts >= 0 and .pid == 1 and .tid >= 1] | all)' out/trace.json >/dev/null || fail "trace.json lacks events, or they are wrong"
[ "$(wc -l <out/frames.csv)" = 8 ] || fail "frames.csv does not have 8 lines"

# The resolved job gives the same pictures as the job, and so do a slice and a still of it.
"$SEGCAST" render out/job.yaml -o again -q >/dev/null
[ "$(hashes out)" = "$(hashes again)" ] || fail "the resolved job gives other pictures"
[ "$(job_hash out)" = "$(job_hash again)" ] ||
    fail "the resolved job has another hash"
"$SEGCAST" render job.yaml -o slice --frames 1-5:2 -q >/dev/null
[ "$(hashes slice)" = "$(hashes out | sed -n '2p;4p;6p')" ] || fail "a slice gives other pictures"
"$SEGCAST" still job.yaml --frame 4 -o still.png -q >/dev/null
"$IMAGE_DIFFERENCE" still.png out/frames/000004.png || fail "a still differs from the frame of the same number"

# Paths in a job file are relative to the file; those in the resolved job work from any directory.
mkdir -p sub/dir
"$SEGCAST" convert phantom:59x41x61 -o sub/p.nrrd -q >/dev/null
sed 's|^volume.*|volume: ../p.nrrd|' job.yaml >sub/dir/job.yaml
"$SEGCAST" render sub/dir/job.yaml --frames 0 -q >/dev/null
[ -e sub/dir/out/manifest.0.jsonl ] || fail "the output directory is not relative to the job"
"$SEGCAST" render sub/dir/out/job.yaml --frames 0 -o elsewhere -q >/dev/null
[ "$(hashes elsewhere)" = "$(hashes out | head -1)" ] || fail "a volume from a file gives other pictures"

# The directory of a resolved job is the one in which it lies, wherever it is read from and moved to: a run of it goes on
# there, and makes no directory in the directory.
for directory in out again sub/dir/out; do
    [ "$(grep '^  directory: ' "$directory/job.yaml")" = '  directory: "."' ] || fail "directory of $directory/job.yaml"
done
expect 73 '/again: already holds a run' "$SEGCAST" render again/job.yaml -q; one_error
(cd again && expect 73 'already holds a run' "$SEGCAST" render job.yaml -q && one_error) || exit 1
mv again moved
expect 0 'nothing to do' "$SEGCAST" render moved/job.yaml --resume
[ ! -e moved/out ] && [ ! -e moved/again ] && [ ! -e again ] || fail "a resolved job was rendered to another directory"
mv moved again

# The hash of the job depends on what changes the pictures, and not on where they are written.
"$SEGCAST" render job.yaml -o other -q --set render.step=0.7 --frames 0 >/dev/null
[ "$(job_hash other)" != "$(job_hash out)" ] ||
    fail "render.step does not change the hash of the job"

# If standard error is not a terminal, progress is printed as plain lines; a summary ends the run.
expect 0 'drawing [0-9.]+ CPU s/frame' "$SEGCAST" render job.yaml -o log
grep -qE 'segcast: limited by (drawing|reading|the start|shared cores)' stderr.txt || fail "the summary does not say what limited the speed of the run"
grep -q 'slowest frames' stderr.txt || fail "the summary does not name the slowest frames"
grep -q $'\r' stderr.txt && fail "a progress bar was written to a file"
true

# Title and author of a film stand in the metadata of each container, and what it was made from, as the manifest
# has it.
for video in t.mp4 t.mkv t.webm t.mov t.webp t.gif; do
    "$SEGCAST" render job.yaml -o "titled-$video" -q --frames 0-6 --set output.video="$video" \
        --set 'output.title="The heart, opened"' --set output.author='Ada Émile' >/dev/null
    for text in 'The heart, opened' 'Ada Émile' \
        "$(head -n 1 "titled-$video/manifest.jsonl" | jq -r '"job \(.job_hash), volume \(.volume_hash)"')"; do
        grep -aq "$text" "titled-$video/$video" || fail "$video does not hold \"$text\""
    done
done
"$SEGCAST" orbit phantom:59x41x61 -o titled.mp4 --frames 3 --size 64x48 -q \
    --set output.title=Turning >/dev/null
grep -aq Turning titled.mp4 || fail "orbit: no title"
grep -aEq 'segcast [0-9.]+[^,]*, job [0-9a-f]{16}, volume [0-9a-f]{16}' titled.mp4 || fail "orbit: no hashes of job and volume"
# A video of all directions says so to players.
"$SEGCAST" orbit phantom:59x41x61 -o around.mp4 --frames 2 --size 64x32 -q \
    --set animation.camera.projection=equirectangular >/dev/null
grep -aq sv3d around.mp4 || fail "a video of all directions does not say that it is one"
! grep -aq sv3d titled.mp4 || fail "a video says that it shows all directions, which it does not"


# Where and with what the run was made.
jq -e '(.begin | test("^20..-..-..T..:..:..Z$")) and (.hosts | length == 1) and (.kernel | length > 0) and
    (.mpi | length > 0) and (.commit | length > 0) and .farm_wall_s > 0 and .farm_wall_s < .wall_s and
    has("batch_job") and has("processor")' out/stats.json >/dev/null || fail "stats.json: $(cat out/stats.json)"
