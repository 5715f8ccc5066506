# SPDX-License-Identifier: BSD-3-Clause
# Options: every command has help and version; mistakes are named, with exit code 64.
"$SEGCAST" --version | grep -q '^segcast 1' || fail "no version"
for word in commit compiler MPI libav videos; do "$SEGCAST" --version | grep -q "^$word" || fail "$word"; done
"$SEGCAST" --help | grep -q 'Exit codes' || fail "no help"
"$SEGCAST" --help | head -1 | grep -q '^Usage: ' || fail "the help does not begin with Usage"
[ "$("$SEGCAST" --help | wc -l)" -le 40 ] || fail "the help does not fit a screen"
"$SEGCAST" --help | awk 'length($0) > 100 {exit 1}' || fail "a line of the help is longer than 100 characters"
for command in $("$SEGCAST" --help | sed -nE 's/^([a-z]+)? {2,}([a-z]+) +[][A-Z].*/\2/p' | sort -u); do
    for way in "$command --help" "$command -h" "help $command"; do
        # shellcheck disable=SC2086
        "$SEGCAST" $way | sed -n 1p | grep -q "^Usage: segcast $command" || fail "$way"
    done
    "$SEGCAST" "$command" --version | grep -q '^segcast 1' || fail "$command --version"
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
expect 64 'expected KEY.PATH=VALUE' "$SEGCAST" render a.yaml --set render.quality; one_error
: >a.nrrd
expect 64 '--zoom x: zoom is "x"' "$SEGCAST" orbit a.nrrd --zoom x; one_error
expect 64 '--size 3x4: size is "3x4"' "$SEGCAST" orbit a.nrrd --size 3x4; one_error
expect 64 '--axis superoir: unknown axis.*did you mean "superior"' "$SEGCAST" orbit a.nrrd --axis superoir
one_error
expect 64 '1 to 4096' "$SEGCAST" render a.yaml --threads 0; one_error
expect 64 'for example phantom:128x96x128' "$SEGCAST" convert phantom:12 -o p.nrrd; one_error
expect 66 'missing.yaml: No such file' "$SEGCAST" render missing.yaml; one_error
expect 66 'is a directory' "$SEGCAST" info /; one_error

# Without a job file a phantom is written, inspected, drawn and turned.
"$SEGCAST" convert phantom:40x30x42 -o p.nrrd -q >/dev/null
"$SEGCAST" info p.nrrd --json | jq -e '.size == [40,30,42] and .axes == "RAS" and
    (.labels | length) == 21 and ([.labels[1:][].voxels] | min) >= 0 and
    (.labels[10] | .name == "left ventricular myocardium" and .thickness_mm > 3 and
     .surface_mm2 > 1000 and .boundary_voxels > 0)' >/dev/null || fail "info --json"
# How a volume was drawn: a ball in slices that jump by SHIFT voxels to and fro.
drawn_ball() { # drawn_ball SHIFT
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 60 60 60\n'
    printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: ascii\n\n'
    awk -v shift="$1" 'BEGIN {
        for (z = 0; z < 60; z++) for (y = 0; y < 60; y++) {
            for (x = 0; x < 60; x++) {
                r = sqrt((x - 30 - shift * (z % 2)) ^ 2 + (y - 30) ^ 2 + (z - 30) ^ 2) - 22
                printf "%d ", r < 0
            }
            print ""
        }
    }'
}
drawn_ball 0 >still.nrrd
drawn_ball 3 >jumping.nrrd
for name in still jumping; do
    case $name in
    still) wanted='.drawn_mm == [1,1,1] and .moved_slices == [0,0,0]' ;;
    jumping) wanted='.moved_slices[0:2] == [0,0] and .moved_slices[2] > 40' ;;
    esac
    "$SEGCAST" info $name.nrrd --json -q | jq -e "$wanted" >/dev/null || fail "info --json of $name.nrrd"
done
"$SEGCAST" info p.nrrd | grep -q 'superior vena cava' || fail "info"
mkdir sub
(cd sub && "$SEGCAST" orbit ../p.nrrd -o turn.mp4 --frames 5 --size 64x48 -q >/dev/null)
"$VIDEO_PROBE" sub/turn.mp4 | grep -q '5 frames of 64 x 48' || fail "orbit"
[ "$(ls sub)" = turn.mp4 ] || fail "orbit leaves other files: $(ls sub)"
# What a run that was killed has left beside the video goes with --overwrite; what is of a living process, or only named
# alike, stays.
gone=$(sh -c 'echo $$')
touch "sub/.turn.mp4.tmp.$(uname -n).$gone.0123456789abcdef" "sub/.turn.mp4.tmp.$(uname -n).$$.0123456789abcdef" sub/.turn.mp4.tmp.mine
"$SEGCAST" orbit p.nrrd -o sub/turn.mp4 --frames 5 --size 64x48 -q --overwrite >/dev/null
[ "$(ls -A sub | tr '\n' ' ')" = ".turn.mp4.tmp.mine .turn.mp4.tmp.$(uname -n).$$.0123456789abcdef turn.mp4 " ] ||
    fail "--overwrite leaves other files than it should: $(ls -A sub)"
expect 66 'nowhere.nrrd: No such file' "$SEGCAST" orbit nowhere.nrrd; one_error
expect 64 'expected a name ending in' "$SEGCAST" orbit p.nrrd -o turn.avi

# A small limit of the stack is raised; where it cannot be, that is said. The sanitizers need more.
small_job stack.yaml
case $BUILD in *san*) ;; *)
    (ulimit -S -s 256 && "$SEGCAST" still stack.yaml -o stack.png -q >/dev/null) || fail "a stack of 256 KiB is too small"
    (ulimit -s 1400 && expect 71 'the stack is limited to 1400 KiB' "$SEGCAST" still stack.yaml -o stack.png) || exit 1
    ;;
esac
