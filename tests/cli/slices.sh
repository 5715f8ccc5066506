# SPDX-License-Identifier: BSD-3-Clause
# Slices of a job, drawn by processes that do not communicate, give the same video as one process.
small_job job.yaml
sed -i 's/size: \[96, 72\], video: none/size: [96, 72], fps: 4, frames: png, video: film.mp4/; s/frames: 7/frames: 18/' job.yaml
"$SEGCAST" render job.yaml -o ref -q >/dev/null
same_as_ref() { # same_as_ref WHAT: out holds the same bytes as ref, the output of one process
    [ "$(hashes out)" = "$(hashes ref)" ] || fail "$1: the hashes of the frames differ"
    cmp out/film.mp4 ref/film.mp4 || fail "$1: the video differs"
    "$SEGCAST" verify out >/dev/null || fail "$1: segcast verify found an error"
    [ "$(ls out/manifest* | wc -l)" = 1 ] || fail "$1: manifests of slices were not removed: $(ls out)"
}

# A GOP whose frames belong to two slices is put together from both.
for frames in 0-6 13-17 7-12:2; do
    "$SEGCAST" render job.yaml -o out --frames $frames >said.txt 2>stderr.txt
    [ "$(cat said.txt)" = out ] && grep -q 'not there yet' stderr.txt || fail "slice $frames: expected out/ and a message that other frames are missing"
    [ ! -e out/film.mp4 ] || fail "there is a video although frames are missing"
done
expect 75 '3 of 18 frames are not there' "$SEGCAST" join out; one_error
[ ! -e out/manifest.join.jsonl ] || fail "join left a manifest of its own"
"$SEGCAST" render job.yaml -o out --frames 8-12:2 -q >said.txt
[ "$(cat said.txt)" = out/film.mp4 ] || fail "the last slice did not make the video"
same_as_ref "slices"
expect 0 '' "$SEGCAST" join out
[ "$(cat stdout.txt)" = out/film.mp4 ] || fail "join of a finished job does not print the path of the video"

# Slices run at the same time: the last one to end makes the video, and no other prints a message.
for _ in 1 2 3; do
    rm -rf out
    for i in 0 1 2 3; do
        "$SEGCAST" render job.yaml -o out --slice $i/4 --threads 1 -q >said.$i 2>err.$i &
    done
    for job in $(jobs -p); do wait "$job" || fail "exit code $?: $(cat err.*)"; done
    [ -z "$(cat err.*)" ] || fail "slices printed messages: $(cat err.*)"
    same_as_ref "slices at the same time"
done

# To draw a slice again needs --resume; a slice of another job is refused; join completes a job whose
# slices all ended without making the video.
rm -rf out
"$SEGCAST" render job.yaml -o out --slice 0/2 -q >/dev/null
expect 73 'already holds a run' "$SEGCAST" render job.yaml -o out --slice 0/2; one_error
"$SEGCAST" render job.yaml -o out --slice 0/2 --resume -q >/dev/null
jq -e '(.runs | length) == 2 and .runs[1].frames == 0 and .runs[0].frames > 0 and
    (.frames | length) == .runs[0].frames' out/stats.0of2.json >/dev/null || fail "statistics of a slice"
# A run without --slice that draws the rest reads the statistics of the slice.
cp -r out whole
"$SEGCAST" render job.yaml -o whole --resume -q >/dev/null
jq -e '(.runs | length) == 3 and [.frames[].frame] == [range(18)] and ([.runs[].frames] | add) == 18 and
    ([.frames[].run] | unique) == [0, 2]' whole/stats.json >/dev/null || fail "statistics of all slices"
expect 73 'another job' "$SEGCAST" render job.yaml -o out --slice 1/2 --set render.quality=draft; one_error
expect 64 'expected I/N' "$SEGCAST" render job.yaml -o out --slice 2/2; one_error
expect 64 'exclude each other' "$SEGCAST" render job.yaml -o out --slice 0/2 --frames 3; one_error
expect 64 'slices share' "$SEGCAST" render job.yaml -o out --slice 0/2 --overwrite; one_error
"$SEGCAST" render job.yaml -o other --slice 1/2 -q >/dev/null
cp other/segments/* out/segments/
cp other/frames/* out/frames/
cp other/manifest.1of2.jsonl out/
expect 0 '' "$SEGCAST" join out
same_as_ref "join"
