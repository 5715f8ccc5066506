# Writing fails in the middle: exit 74, one message, nothing half-done under a final name.
# The limit of file sizes stands for a full disk; its signal is ignored, so that writes fail.
small_job job.yaml
trap '' XFSZ
limited() { (ulimit -f 8; exec "$@"); } # 8 blocks of 1 KiB

code=0
limited "$SEGCAST" render job.yaml -o out --set output.size=[640,480] --set output.video=film.mp4 \
    --set output.crf=1 >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || { cat stderr.txt; fail "exit $code, expected 74"; }
one_error
[ -z "$(ls -A out | grep film)" ] || fail "left: $(ls -A out)"
jq -e '.state == "failed"' out/status.json >/dev/null || fail "status"

code=0
limited "$SEGCAST" render job.yaml -o png --set output.size=[640,480] --set output.frames=png \
    >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || fail "exit $code, expected 74"
one_error
[ -z "$(ls -A png/frames)" ] || fail "left: $(ls -A png/frames)"

# With room again, the job goes on with what is there, to the same bytes.
full=(render job.yaml --set output.size=[320,240] --set output.video=film.mp4 --set output.fps=3)
"$SEGCAST" "${full[@]}" -o ref -q >/dev/null
code=0
(ulimit -f 150; exec "$SEGCAST" "${full[@]}" -o again) >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || fail "exit $code, expected 74"
expect 0 '' "$SEGCAST" "${full[@]}" -o again --resume
cmp again/film.mp4 ref/film.mp4 || fail "another video after a full disk"
[ "$(hashes again)" = "$(hashes ref)" ] || fail "other frames after a full disk"

code=0
limited "$SEGCAST" phantom --size 200x200x200 -o p.nrrd >stdout.txt 2>stderr.txt || code=$?
[ $code = 74 ] || fail "exit $code, expected 74"
one_error
[ -z "$(ls -A | grep nrrd)" ] || fail "left: $(ls -A)"
