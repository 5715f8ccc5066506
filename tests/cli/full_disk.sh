# SPDX-License-Identifier: BSD-3-Clause
# Writing fails in the middle: segcast exits with 74 and one message, and no incomplete file has its
# final name. A limit of the file size stands for a full disk; segcast ignores its signal, so that write()
# fails instead.
small_job job.yaml
limited() { (ulimit -f 8; exec "$@"); } # 8 blocks of 1 KiB

code=0
limited "$SEGCAST" render job.yaml -o out --set output.size=[320,240] --set output.video=film.mp4 \
    --set output.crf=1 >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || { cat stderr.txt; fail "exit code $code, expected 74"; }
one_error
grep -q 'limit of file sizes is reached (ulimit -f)' stderr.txt || fail "the message does not name the limit: $(cat stderr.txt)"
[ -z "$(ls -A out | grep film)" ] || fail "an incomplete video is left: $(ls -A out)"
jq -e '.state == "failed"' out/status.json >/dev/null || fail "status.json does not say that the run failed"

code=0
limited "$SEGCAST" render job.yaml -o png --set output.size=[320,240] --set output.frames=png \
    >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || fail "exit code $code, expected 74"
one_error
[ -z "$(ls -A png/frames)" ] || fail "incomplete PNG files are left: $(ls -A png/frames)"

# When there is room again, --resume completes the job, and the bytes are those of an undisturbed run.
full=(render job.yaml --set output.size=[320,240] --set output.video=film.mp4 --set output.fps=3)
"$SEGCAST" "${full[@]}" -o ref -q >/dev/null
code=0
(ulimit -f 150; exec "$SEGCAST" "${full[@]}" -o again) >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || fail "exit code $code, expected 74"
expect 0 '' "$SEGCAST" "${full[@]}" -o again --resume
cmp again/film.mp4 ref/film.mp4 || fail "the video after a full disk differs"
[ "$(hashes again)" = "$(hashes ref)" ] || fail "the frames after a full disk differ"

code=0
limited "$SEGCAST" convert phantom:100x100x100 -o p.nrrd >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || fail "exit code $code, expected 74"
one_error
[ -z "$(ls -A | grep nrrd)" ] || fail "an incomplete volume is left: $(ls -A)"

code=0
limited "$SEGCAST" convert phantom:60x50x60 -o full.segc >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || { cat stderr.txt >&2; fail "exit code $code, expected 74"; }
one_error
grep -q 'full.segc: cannot be written after .* bytes: the limit of file sizes is reached' stderr.txt ||
    fail "the message does not name the reason: $(cat stderr.txt)"
[ -z "$(ls -A | grep segc)" ] || fail "an incomplete prepared volume is left: $(ls -A)"
