# SPDX-License-Identifier: BSD-3-Clause
# Options: every command has help and version; mistakes are named, with exit code 64.
"$SEGCAST" --version | grep -q '^segcast 0' || fail "no version"
for word in commit compiler MPI libav; do "$SEGCAST" --version | grep -q "^$word" || fail "$word"; done
"$SEGCAST" --help | grep -q 'Exit codes' || fail "no help"
"$SEGCAST" --help | head -1 | grep -q '^Usage: ' || fail "the help does not begin with Usage"
for command in $("$SEGCAST" --help | awk '/^  segcast [a-z]+ /{print $2}' | grep -v '^--' | sort -u); do
    for way in "$command --help" "$command -h" "help $command"; do
        # shellcheck disable=SC2086
        "$SEGCAST" $way | head -1 | grep -q "^Usage: segcast $command" || fail "$way"
    done
    "$SEGCAST" "$command" --version | grep -q '^segcast 0' || fail "$command --version"
done
# One word for one thing: no message, help or document says folder, but for the glossary.
! LC_ALL=C grep -aoiE '[^"]{0,40} folders?[ ,:.;]' "$SEGCAST" || fail "the program says folder"
! grep -rniwE --include='*.md' 'folders?' "$SOURCE/docs" "$SOURCE/README.md" "$SOURCE/CONTRIBUTING.md" |
    grep -v 'never say folder' || fail "a document says folder"
expect 64 'did you mean "render"' "$SEGCAST" help rendr; one_error
expect 64 'no command' "$SEGCAST"; one_error
expect 64 'did you mean "render"' "$SEGCAST" rendr; one_error
expect 64 'needs JOB.yaml' "$SEGCAST" render; one_error
expect 64 'did you mean --frames' "$SEGCAST" render job.yaml --fraems 1; one_error
expect 64 'needs a value' "$SEGCAST" render job.yaml -o; one_error
expect 64 'unexpected argument' "$SEGCAST" render a.yaml b.yaml; one_error
expect 64 '--overwrite takes no value' "$SEGCAST" render a.yaml --overwrite=false; one_error
expect 64 '--quiet takes no value' "$SEGCAST" info a.nrrd --quiet=; one_error
expect 64 'unknown option -x' "$SEGCAST" render a.yaml -x; one_error
expect 66 '^segcast: error: --frames: No such file' "$SEGCAST" render -- --frames; one_error
expect 64 'expected KEY.PATH=VALUE' "$SEGCAST" render a.yaml --set render.samples; one_error
: >a.nrrd
expect 64 '--zoom x: zoom is "x"' "$SEGCAST" orbit a.nrrd --zoom x; one_error
expect 64 '--size 3x4: size is "3x4"' "$SEGCAST" orbit a.nrrd --size 3x4; one_error
expect 64 '--axis superoir: unknown axis.*did you mean "superior"' "$SEGCAST" orbit a.nrrd --axis superoir
one_error
expect 64 '1 to 4096' "$SEGCAST" render a.yaml --threads 0; one_error
expect 64 'for example 128x96x128' "$SEGCAST" phantom --size 12; one_error
expect 66 'missing.yaml: No such file' "$SEGCAST" render missing.yaml; one_error
expect 66 'is a directory' "$SEGCAST" info /; one_error

# Without a job file a phantom is written, inspected, drawn and turned.
"$SEGCAST" phantom --size 40x30x42 -o p.nrrd -q >/dev/null
"$SEGCAST" info p.nrrd --json | jq -e '.size == [40,30,42] and .axes == "RAS" and
    (.labels | length) == 21 and ([.labels[1:][].voxels] | min) >= 0 and
    (.labels[10] | .name == "left ventricular myocardium" and .thickness_mm > 3 and
     .surface_mm2 > 1000 and .boundary_voxels > 0)' >/dev/null || fail "info --json"
"$SEGCAST" info p.nrrd | grep -q 'superior vena cava' || fail "info"
mkdir sub
(cd sub && "$SEGCAST" orbit ../p.nrrd -o turn.mp4 --frames 5 --size 64x48 -q >/dev/null)
"$VIDEO_PROBE" sub/turn.mp4 | grep -q '5 frames of 64 x 48' || fail "orbit"
[ "$(ls sub)" = turn.mp4 ] || fail "orbit leaves other files: $(ls sub)"
expect 66 'nowhere.nrrd: No such file' "$SEGCAST" orbit nowhere.nrrd; one_error
expect 64 'expected a name ending in' "$SEGCAST" orbit p.nrrd -o turn.avi
