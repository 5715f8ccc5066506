# SPDX-License-Identifier: BSD-3-Clause
# A beating heart: a series of volumes is filmed, each frame with the phase that its number says; several ranks, prepared
# files of the phases, and a run that was continued make the same film. property.films draws frames alone and the resolved job.
"$SEGCAST" convert phantom:59x41x61 --beating 5 -o beat.nrrd -q >/dev/null
cat >job.yaml <<'YAML'
volume: beat-*.nrrd
cine: {bpm: 120}
output: {directory: out, size: [96, 72], video: film.mp4, fps: 10}
tissues: {"*": {opacity: 0.4}, "epicardial fat": {visible: false}}
animation:
  frames: 12
  camera: {orbit: {elevation: 10, target_mm: [0, 0, 0], distance_mm: 400, turns: 0.5}}
  clip: [{normal: posterior, at: 0 mm}]
YAML
"$SEGCAST" render job.yaml -o one -q --set output.frames=png >/dev/null
[ "$(hashes one | cut -d' ' -f2 | sort -u | wc -l)" = 12 ] || fail "frames repeat"

# Each frame is that of its phase: the picture that the file of the phase gives by itself
for k in 1 4 10; do
    grep -v '^cine' job.yaml | sed "s/beat-\*/beat-0$((k % 5))/" >single.yaml
    "$SEGCAST" still single.yaml --frame $k -o still.png --overwrite -q >/dev/null
    "$IMAGE_DIFFERENCE" still.png "one/frames/$(printf %06d $k).png" || fail "frame $k does not show phase $((k % 5))"
done

# Phases are files in the temporary directory, of which nothing is left; or where there can be none, in shared memory
mkdir temporary
TMPDIR=$PWD/temporary mpi 3 "$SEGCAST" render job.yaml -o files --set farm.partition=tiles --cpu c 2>stderr.txt >/dev/null
grep -q "the 5 phases take .*, in files without names in $PWD/temporary" stderr.txt || { cat stderr.txt; fail "phases are held in memory"; }
[ "$(hashes one)" = "$(hashes files)" ] && cmp one/film.mp4 files/film.mp4 || fail "the film differs where phases are files"
TMPDIR=$PWD/nowhere mpi 3 "$SEGCAST" render job.yaml -o memory 2>stderr.txt >/dev/null
[ "$(hashes one)" = "$(hashes memory)" ] || fail "the pictures differ where phases are in memory"
[ -z "$(ls -A temporary)" ] || fail "files are left behind: $(ls -A temporary)"

# Prepared files of all phases are the same film
"$SEGCAST" convert job.yaml -o beat.segc -q >said.txt
printf 'beat-%02d.segc\n' {0..4} | diff - said.txt || fail "the prepared files that are named"
sed 's/nrrd/segc/' job.yaml >prepared.yaml
mpi 2 "$SEGCAST" render prepared.yaml -o prepared -q >/dev/null
[ "$(hashes one)" = "$(hashes prepared)" ] && cmp one/film.mp4 prepared/film.mp4 || fail "prepared phases are another film"

# A run that was killed goes on as the same film; with other phases, or another order of them, it does not
(
    ulimit -c 0
    mpi 2 "$SEGCAST" render job.yaml -o parts -q --frames 3-6 >/dev/null
    "$SEGCAST" render job.yaml -o parts -q --resume --set render.quality=still >/dev/null 2>&1
) || true
mpi 3 "$SEGCAST" render job.yaml -o parts -q --resume >/dev/null
[ "$(hashes parts | uniq)" = "$(hashes one)" ] && cmp one/film.mp4 parts/film.mp4 || fail "a film that was continued differs"
"$SEGCAST" verify parts >/dev/null || fail "the film is not verified"
expect 73 'volume' "$SEGCAST" render job.yaml -o one --resume -q --set 'volume=[beat-00.nrrd, beat-02.nrrd, beat-01.nrrd, beat-03.nrrd, beat-04.nrrd]'
expect 73 'job' "$SEGCAST" render job.yaml -o one --resume -q --set cine.bpm=60

# In a film of shots the beat goes on from shot to shot, also under a cross-fade
cat >>job.yaml <<'YAML'
shots:
  - card: Beat
    animation: {frames: 3}
  - {}
  - transition: cross_fade 400 ms
    tissues: {"*": {opacity: 1}}
YAML
"$SEGCAST" render job.yaml -o shots -q --set output.frames=png >/dev/null
[ "$(hashes shots | wc -l)" = 23 ] || fail "the film of shots has not 3 + 12 + 12 - 4 frames"
mpi 3 "$SEGCAST" render job.yaml -o shots3 -q --set farm.partition=tiles >/dev/null
[ "$(hashes shots)" = "$(hashes shots3)" ] || fail "the film of shots differs with 3 ranks"
grep -v '^cine' job.yaml | sed "s/beat-\*/beat-03/" >single.yaml
"$SEGCAST" still single.yaml --frame 8 -o still.png --overwrite -q >/dev/null
"$IMAGE_DIFFERENCE" still.png shots/frames/000008.png || fail "the phase of a shot does not follow from the time of the film"
