# SPDX-License-Identifier: BSD-3-Clause
# A series of volumes as the phases of a beat: what is told of it, and what is refused.
"$SEGCAST" convert phantom:40x30x42 --beating 4 -o beat.nrrd -q >/dev/null
cat >job.yaml <<'YAML'
volume: beat-*.nrrd
cine: {bpm: 90}
output: {directory: out, size: [64, 48], video: none, frames: png, fps: 10}
animation: {frames: 20, camera: {orbit: {turns: 0, elevation: 10}}}
YAML
"$SEGCAST" check job.yaml >said.txt 2>stderr.txt
grep -q 'ok: 20 frames .* 40 x 30 x 42 voxels' said.txt || fail "check does not say what the volume is: $(cat said.txt)"
grep -qx 'phases: 4 volumes of this size, 90 beats a minute: the film shows 3 beats' said.txt || fail "check: $(cat said.txt)"
grep -q '4 phases, from beat-00.nrrd to beat-03.nrrd; 90 beats a minute' stderr.txt || fail "the order is not told"
"$SEGCAST" check job.yaml --fast -q >/dev/null || fail "check --fast"
"$SEGCAST" check job.yaml -q --set cine.loop=2 >said.txt
grep -q 'shows 2 beats, and then the last phase' said.txt || fail "check of a film with an end: $(cat said.txt)"

# The camera stands still, so that the beats are the same; the framing is that of all phases
"$SEGCAST" render job.yaml -q --set output.fps=6 >/dev/null # 4 frames for a beat
[ "$(hashes out | cut -d' ' -f2 | sort -u | wc -l)" = 4 ] || fail "a beat has not 4 pictures"
[ "$(hashes out | cut -d' ' -f2 | head -4)" = "$(hashes out | cut -d' ' -f2 | tail -4)" ] || fail "beats differ"
"$SEGCAST" render job.yaml -q --set output.fps=6 --set cine.loop=false --overwrite >/dev/null
[ "$(hashes out | cut -d' ' -f2 | tail -17 | sort -u | wc -l)" = 1 ] || fail "the last phase does not stay"
opaque=(--set 'tissues={"*": {visible: false}, left ventric*: {visible: true, opacity: 1}}' -q --overwrite) # what moves most
"$SEGCAST" still job.yaml -o first.png --frame 0 --set 'volume=[beat-00.nrrd, beat-02.nrrd]' "${opaque[@]}" >/dev/null
"$SEGCAST" still job.yaml -o second.png --frame 4 --set 'volume=[beat-02.nrrd, beat-00.nrrd]' "${opaque[@]}" >/dev/null
"$IMAGE_DIFFERENCE" first.png second.png || fail "the camera depends on which phase is the first"
"$SEGCAST" still job.yaml -o other.png --frame 0 --set 'volume=[beat-02.nrrd, beat-00.nrrd]' "${opaque[@]}" >/dev/null
! "$IMAGE_DIFFERENCE" first.png other.png || fail "two phases look the same"
"$SEGCAST" plan job.yaml --json >plan.json || fail "plan"
"$SEGCAST" plan job.yaml --json --set cine.phases=0-1 >part.json || fail "plan of two phases"
jq -es '.[0].memory.prepared_bytes > 1.8 * .[1].memory.prepared_bytes' plan.json part.json >/dev/null || fail "plan counts one phase"
"$SEGCAST" still job.yaml -o sheet.png -q --sheet 4 >/dev/null || fail "a sheet"

# Phases are held in files; where there can be none, in memory, which is told once, unless they are larger than that
cache=$SEGCAST_CACHE
export SEGCAST_CACHE=off # from which phases would be drawn
still=(still job.yaml --frame 4 --overwrite)
"$SEGCAST" "${still[@]}" -o files.png >/dev/null 2>said.txt
grep -q 'the 4 phases take about [0-9.]* [KM]iB, in files .* in /.*; a rank has 2 of them in memory' said.txt || fail "files are not told: $(cat said.txt)"
TMPDIR=$PWD/away "$SEGCAST" "${still[@]}" -o memory.png >/dev/null 2>said.txt
grep -q 'warning: the 4 phases take about .* held in memory, .* in .*/away: No such file or directory; .*TMPDIR=' said.txt || fail "a lost directory: $(cat said.txt)"
[ "$(grep -c 'phases take' said.txt)" = 1 ] || fail "told more than once: $(cat said.txt)"
"$IMAGE_DIFFERENCE" files.png memory.png || fail "pictures depend on where phases are held"
mpi 2 env TMPDIR="$PWD/job.yaml" "$SEGCAST" render job.yaml --frames 0-1 -o ranks >/dev/null 2>said.txt
[ "$(grep -c 'warning: the 4 phases take .*job.yaml: Not a directory' said.txt)" = 1 ] || fail "ranks: $(cat said.txt)"
(ulimit -f 8; exec "$SEGCAST" "${still[@]}" -o full.png) >/dev/null 2>said.txt || true
grep -q 'warning: the 4 phases take .*: File too large' said.txt || fail "a limit of file sizes: $(cat said.txt)"
expect 71 'the 4 phases take about .*, more than the memory of [0-9]+ KiB, and no files .*/away: No such file' env TMPDIR="$PWD/away" "$SEGCAST" "${still[@]}" -o none.png --max-memory 500K
one_error
expect 71 'the 4 phases take about .*, more than the memory of [0-9]+ KiB' mpi 2 env TMPDIR="$PWD/away" "$SEGCAST" render job.yaml -o none --max-memory 500K

# A rank with 12 phases needs about the memory of one with 3
peak() { jq '.memory.peak_rss_bytes | max' "$1/stats.json"; }
"$SEGCAST" convert phantom:88x62x91 --beating 12 -o many.nrrd -q >/dev/null
sed 's/beat-/many-/' job.yaml >many.yaml
"$SEGCAST" render many.yaml -o many -q --set output.fps=18 --set animation.frames=12 >/dev/null
"$SEGCAST" render many.yaml -o few -q --set output.fps=18 --set animation.frames=12 --set cine.phases=0-11:4 >/dev/null
case $BUILD in
*/asan) ;; # AddressSanitizer keeps memory that was given back
*) [ "$(peak many)" -lt "$(($(peak few) * 5 / 4))" ] || fail "12 phases take $(peak many) bytes, 3 take $(peak few)" ;;
esac
"$SEGCAST" plan many.yaml --json | jq -e '.memory | .loaded_bytes * 5 < .prepared_bytes + .derived_bytes' >/dev/null || fail "plan counts all phases"
export SEGCAST_CACHE=$cache

# Bad phases: one message, with file and line
"$SEGCAST" convert phantom:40x30x44 -o other.nrrd -q >/dev/null
sed 's/beat-\*.nrrd/[beat-00.nrrd, other.nrrd, beat-01.nrrd]/' job.yaml >size.yaml
sed 's/beat-\*.nrrd/{path: [beat-00.nrrd, part.segc]}/' job.yaml >labels.yaml
printf 'volume: {path: beat-01.nrrd, keep: [aorta, "*ventric*"]}\n' >part.yaml
"$SEGCAST" convert part.yaml -o part.segc -q >/dev/null
head -c 4000 beat-02.nrrd >damaged.nrrd
sed 's/beat-\*.nrrd/[beat-00.nrrd, damaged.nrrd]/' job.yaml >damaged.yaml
for command in 'check' 'render -o bad' 'plan' 'still -o bad.png'; do
    # shellcheck disable=SC2086
    set -- $command
    expect 65 'size.yaml:1: .*other.nrrd has 40 x 30 x 44 voxels, but .*beat-00.nrrd, the first phase, 40 x 30 x 42' "$SEGCAST" "$1" size.yaml "${@:2}"
    one_error
    expect 65 'labels.yaml:1: .*part.segc has no label [0-9]+ .*, which .*beat-00.nrrd has' "$SEGCAST" "$1" labels.yaml "${@:2}"
    one_error
    expect 65 'damaged.nrrd' "$SEGCAST" "$1" damaged.yaml "${@:2}"
    one_error
done
rm -rf bad
mv beat-02.nrrd away.nrrd
expect 65 'job.yaml:1: volume: there is no file between beat-01.nrrd and beat-03.nrrd' "$SEGCAST" check job.yaml
one_error
mv away.nrrd beat-02.nrrd

# Nothing replaces a phase, and prepared files are all checked before the first is made
cp beat-03.nrrd kept.nrrd
cp beat-03.nrrd beat-03.png
expect 73 'is an input of this command' "$SEGCAST" still job.yaml -o beat-03.png --overwrite --set 'volume=[beat-00.nrrd, beat-03.png]'
cp beat-01.nrrd taken-01.segc
expect 73 'taken-01.segc' "$SEGCAST" convert job.yaml -o taken.segc
[ ! -e taken-00.segc ] || fail "files were made beside one that is in the way"
cmp beat-03.png kept.nrrd || fail "a phase was changed"
# Without a job file, a pattern is a beat; a job to begin with has it; other commands for one volume say so
mkdir there
"$SEGCAST" init 'beat-*.nrrd' -q >/dev/null
sed -i 's/1080p/64x48/' beat.yaml
grep -qx 'volume: "beat-\*.nrrd"' beat.yaml && "$SEGCAST" check beat.yaml -q | grep -q 'phases: 4 volumes' || fail "init of a series: $(head -20 beat.yaml)"
"$SEGCAST" init 'beat-*.nrrd' -q -o there/job.yaml >/dev/null
"$SEGCAST" check there/job.yaml -q | grep -q 'phases: 4 volumes' || fail "init of a series in another directory"
"$SEGCAST" orbit 'beat-*.nrrd' -o turn.mp4 -q --size 64x48 --frames 12 --fps 4 >/dev/null && "$VIDEO_PROBE" turn.mp4 | grep -q '^12 frames' || fail "orbit of a series"
expect 64 'series of 4 files' "$SEGCAST" info 'beat-*.nrrd'

# A file with all phases (4-D) is the same film as the series of files, and each of its phases the same picture
"$SEGCAST" convert phantom:40x30x42 --beating 4 -o all.seq.nrrd -q | grep -qx all.seq.nrrd || fail "the name of the file of all phases"
sed 's/beat-\*.nrrd/all.seq.nrrd/; s/bpm: 90//' job.yaml >all.yaml
"$SEGCAST" render job.yaml -o files --set cine.bpm=60 -q >/dev/null
"$SEGCAST" render all.yaml -o one >/dev/null 2>said.txt
[ "$(hashes files)" = "$(hashes one)" ] || fail "phases of one file are another film than files"
grep -q 'phases are 0.25 s apart: 60 beats a minute' said.txt || fail "the time of the file is not told: $(cat said.txt)"
"$SEGCAST" render one/job.yaml -o again -q >/dev/null
[ "$(job_hash one)" = "$(job_hash again)" ] && [ "$(hashes one)" = "$(hashes again)" ] || fail "the resolved job is another film"
"$SEGCAST" render all.yaml -o some -q --set cine.phases=2,0 --set cine.bpm=60 >/dev/null
"$SEGCAST" render some/job.yaml -o again2 -q >/dev/null
"$SEGCAST" render job.yaml -o two -q --set cine.phases=2,0 --set cine.bpm=60 >/dev/null
[ "$(hashes some)" = "$(hashes two)" ] && [ "$(hashes some)" = "$(hashes again2)" ] || fail "chosen phases of a file"
TMPDIR=$PWD/nowhere "$SEGCAST" render all.yaml -o away >/dev/null 2>said.txt
[ "$(hashes files)" = "$(hashes away)" ] && grep -q 'warning: .*all.seq.nrrd: its 4 phases cannot be unpacked to .*/nowhere' said.txt || fail "no room: $(cat said.txt)"
grep -v '^cine' job.yaml | sed 's/beat-\*/beat-02/' >first.yaml
grep -v '^cine' job.yaml | sed 's/beat-\*.nrrd/{path: all.seq.nrrd, phase: 2}/' >second.yaml
"$SEGCAST" still first.yaml -o first.png -q --overwrite >/dev/null
"$SEGCAST" still second.yaml -o second.png -q --overwrite >/dev/null
"$IMAGE_DIFFERENCE" first.png second.png || fail "a phase of a file is another picture"
"$SEGCAST" info all.seq.nrrd -q --set volume.phase=3 | grep -q '^phases    4, 0.25 s apart: 60 beats a minute; this is phase 3' || fail "info of a file of phases"
"$SEGCAST" info all.seq.nrrd -q --json | jq -e '.phases == 4 and .phase == 0 and .phase_step_s == 0.25' >/dev/null || fail "info --json"
"$SEGCAST" convert all.seq.nrrd -o all.segc -q >said.txt
printf 'all-%02d.segc\n' {0..3} | diff - said.txt || fail "the prepared files of a file of phases"
"$SEGCAST" orbit all.seq.nrrd -o turn4.mp4 -q --size 64x48 --frames 8 --fps 4 >/dev/null || fail "orbit of a file of phases"
"$SEGCAST" init all.seq.nrrd -q -o all4.yaml >/dev/null && "$SEGCAST" check all4.yaml -q | grep -q 'phases: 4 volumes' || fail "init of a file of phases"
head -c 6000 all.seq.nrrd >cut.seq.nrrd
sed 's/all.seq/cut.seq/' all.yaml >cut.yaml
expect 65 'cut.seq.nrrd: ends after [0-9]+ bytes of voxels, in phase [0-3] of 4' "$SEGCAST" check cut.yaml
one_error
expect 65 'all.seq.nrrd: holds 4 volumes, one for each time' "$SEGCAST" check first.yaml --set volume=all.seq.nrrd
one_error
expect 65 'all.seq.nrrd: holds 4 images, one for each time .* file of its own' "$SEGCAST" check first.yaml --set image.path=all.seq.nrrd
one_error
sed 's/phase: 2/phase: 4/' second.yaml >third.yaml
expect 65 'third.yaml:1: phase: 4, but .*all.seq.nrrd holds 4, expected 0 to 3' "$SEGCAST" check third.yaml
expect 64 'phases is "0-4", expected numbers from 0 to 3' "$SEGCAST" check all.yaml --set cine.phases=0-4
sed 's/^volume: .*/volume: {path: all.seq.nrrd, phase: 1}/' all.yaml >both.yaml
expect 65 'both.yaml:1: volume: phase chooses one of the 4 phases of the file, and cine shows all' "$SEGCAST" check both.yaml

# Phases between those of the file: these stay what they are, each other picture is one of its own, and the end of beats is
# a phase of the file
"$SEGCAST" render job.yaml -o still4 -q --set cine.bpm=60 --set output.fps=4 --frames 0-3 >/dev/null
"$SEGCAST" render job.yaml -o moving --set cine.bpm=60 --set output.fps=12 --set cine.between=2 >/dev/null 2>said.txt
grep -q 'borders move between phases: 2 are interpolated behind each of 4' said.txt || fail "phases between are not told: $(cat said.txt)"
for k in 0 1 2 3; do
    "$IMAGE_DIFFERENCE" "still4/frames/$(printf %06d $k).png" "moving/frames/$(printf %06d $((3 * k))).png" || fail "phase $k is another picture"
done
[ "$(hashes moving | cut -d' ' -f2 | head -12 | sort -u | wc -l)" = 12 ] || fail "not every phase between is a picture of its own"
[ "$(hashes moving | cut -d' ' -f2 | head -8)" = "$(hashes moving | cut -d' ' -f2 | tail -8)" ] || fail "moving beats differ"
mpi 2 env TMPDIR="$PWD/away" "$SEGCAST" render moving/job.yaml -o moving2 -q --cpu c >/dev/null 2>&1
[ "$(hashes moving)" = "$(hashes moving2)" ] || fail "phases between depend on ranks, or on where they are held"
"$SEGCAST" render all.yaml -o moving3 -q --set output.fps=12 --set cine.between=2 --threads 1 >/dev/null
[ "$(hashes moving)" = "$(hashes moving3)" ] || fail "phases between those of one file, or with one thread, are others"
"$SEGCAST" convert all.yaml -o kept.segc -q >/dev/null
sed 's/all.seq.nrrd/kept-*.segc/' all.yaml >kept.yaml
"$SEGCAST" render kept.yaml -o moving4 -q --set output.fps=12 --set cine.between=2 --set cine.bpm=60 >/dev/null
[ "$(hashes moving)" = "$(hashes moving4)" ] || fail "phases between prepared ones are others"
expect 71 'between: [0-9]+ voxels change .* takes about [0-9.]+ [KM]iB of memory, more than the limit of [0-9.]+ KiB' \
    "$SEGCAST" render moving/job.yaml -o none --max-memory 500K
one_error
# prepare writes those between, too, which are a series by themselves: the same film
"$SEGCAST" convert all.yaml -o each.segc -q --set cine.between=2 >said.txt
printf 'each-%02d.segc\n' {0..11} | sort | diff - <(sort said.txt) || fail "the prepared files of phases between"
sed 's/all.seq.nrrd/each-*.segc/' all.yaml >each.yaml
"$SEGCAST" render each.yaml -o moving5 -q --set output.fps=12 --set cine.bpm=60 >/dev/null
[ "$(hashes moving)" = "$(hashes moving5)" ] || fail "prepared phases between are others"
expect 65 'size.yaml:1: .*other.nrrd has 40 x 30 x 44 voxels, but .*beat-00.nrrd, the first phase' "$SEGCAST" convert size.yaml -o bad.segc --set cine.between=1
one_error
"$SEGCAST" check job.yaml -q --set cine.between=2 | grep -q 'phases: 4 volumes of this size, and 2 between each two' || fail "check of phases between"
expect 64 'cine: 4 phases, and 100 between each two|between' "$SEGCAST" check job.yaml --set cine.between=400
