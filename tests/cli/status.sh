# SPDX-License-Identifier: BSD-3-Clause
# `segcast status DIR` ends with 0 only if the job is complete: scripts of batch systems ask it.
small_job job.yaml
sed -i 's/video: none/video: film.mp4, fps: 4, frames: png/' job.yaml
expect 66 'nowhere: No such file or directory; expected the output directory' "$SEGCAST" status nowhere; one_error
mkdir empty
expect 66 'holds no run' "$SEGCAST" status empty; one_error
"$SEGCAST" render job.yaml -o out --frames 0-4 -q >/dev/null
expect 75 '' "$SEGCAST" status out
[ "$(cat stdout.txt)" = "out: incomplete, 5 of 7 frames are done; run again with --resume for the rest" ] ||
    fail "status of an incomplete job: $(cat stdout.txt)"
expect 75 '' "$SEGCAST" status out --json
jq -e '.condition == "incomplete" and .done == 5 and .frames == 7 and .directory == "out"' stdout.txt >/dev/null ||
    fail "status --json of an incomplete job: $(cat stdout.txt)"
"$SEGCAST" render job.yaml -o out --resume -q >/dev/null
expect 0 '' "$SEGCAST" status out
[ "$(cat stdout.txt)" = "out: complete, 7 frames, film.mp4" ] || fail "status of a complete job: $(cat stdout.txt)"
expect 0 '' "$SEGCAST" status out --json
jq -e '.condition == "complete" and .done == 7 and .frames == 7 and .video == "film.mp4"' stdout.txt >/dev/null ||
    fail "status --json of a complete job: $(cat stdout.txt)"

# A video that is missing or cut, and a damaged first line, are told.
cp -r out cut
truncate -s -1 cut/film.mp4
expect 65 '' "$SEGCAST" status cut
grep -q 'cut: damaged: film.mp4 has' stdout.txt || fail "a cut video: $(cat stdout.txt)"
rm cut/film.mp4
expect 65 '' "$SEGCAST" status cut --json
jq -e '.condition == "damaged" and (.reason | test("missing"))' stdout.txt >/dev/null || fail "a missing video: $(cat stdout.txt)"
cp -r out torn
sed -i '1s/frames/fr\x01mes/' torn/manifest.jsonl
expect 65 '' "$SEGCAST" status torn
grep -q 'no run can continue there' stdout.txt || fail "a damaged first line: $(cat stdout.txt)"

# With the arguments of `segcast render` it answers for the directory, and the slice, that they name.
"$SEGCAST" render job.yaml -o slices --slice 0/2 -q >/dev/null
expect 0 '' "$SEGCAST" status job.yaml -o slices --slice 0/2 --resume --threads 1
[ "$(cat stdout.txt)" = "slices: complete, 4 frames" ] || fail "status of a slice: $(cat stdout.txt)"
expect 75 '' "$SEGCAST" status job.yaml -o slices --slice 1/2 --cpu c
grep -q 'slices: incomplete, 0 of 3 frames' stdout.txt || fail "status of a missing slice: $(cat stdout.txt)"
expect 75 '' "$SEGCAST" status job.yaml --set output.directory=slices
expect 0 '' "$SEGCAST" status job.yaml -o slices --frames 1-3 --json
jq -e '.condition == "complete" and .done == 3 and .frames == 3' stdout.txt >/dev/null || fail "status of frames: $(cat stdout.txt)"
"$SEGCAST" render job.yaml -o slices --slice 1/2 -q >/dev/null
expect 0 '' "$SEGCAST" status job.yaml -o slices --slice 1/2
expect 0 '' "$SEGCAST" status job.yaml -o nowhere --slice 0/3 # there are only two GOPs
# If all frames are there, but not the end of the manifest, no slice is complete: one has to join the video.
sed '/"complete"/,$d' slices/manifest.jsonl >all.jsonl
cp -r slices unjoined
mv all.jsonl unjoined/manifest.jsonl
grep -q '"complete"' slices/manifest.jsonl || fail "the manifest has no line \"end\""
expect 75 '' "$SEGCAST" status job.yaml -o unjoined --slice 1/2
expect 75 '' "$SEGCAST" status job.yaml -o unjoined

# A job that differs in what decides on the pictures is another job; one that differs otherwise is not.
expect 73 'holds another job' "$SEGCAST" status job.yaml -o out --set render.quality=draft; one_error
expect 73 'holds another job' "$SEGCAST" status job.yaml -o out --set appearance=distinct; one_error
expect 0 '' "$SEGCAST" status job.yaml -o out --set farm.tile=16
expect 66 'nowhere: No such file' "$SEGCAST" status job.yaml -o nowhere; one_error
expect 64 'unknown option' "$SEGCAST" status job.yaml --nonsense; one_error

# Escape codes in the names of a directory and of a foreign manifest are shown to a terminal, which would obey them.
if command -v script >/dev/null; then
    mkdir terminal
    cp -r out $'terminal/\e[31mred'
    export SEGCAST
    # shellcheck disable=SC2016 # the inner shell is to replace them
    for command in status verify; do
        for name in '' 'manifest.\e[31mslice.jsonl'; do
            [ -z "$name" ] || head -n 2 out/manifest.jsonl >"$(printf 'terminal/\e[31mred/'"$name")"
            COMMAND=$command script -qc '"$SEGCAST" $COMMAND terminal/*' typescript.txt >/dev/null </dev/null
            grep -q '\\x1b\[31mred' typescript.txt || fail "$command $name does not show the name: $(cat -v typescript.txt)"
            ! grep -q $'\e\[31m' typescript.txt || fail "$command $name passes escape codes on: $(cat -v typescript.txt)"
        done
        rm -f terminal/*/manifest.*slice.jsonl
    done
fi
