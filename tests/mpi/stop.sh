# SPDX-License-Identifier: BSD-3-Clause
# After USR1 to any rank no frame is begun, those that were begun are finished, the exit code is 75, and
# what is finished can be played.
small_job job.yaml
sed -i 's/frames: 7/frames: 4000/' job.yaml
name=sc_stop_$$ # to find the ranks by, under any launcher
ln -s "$SEGCAST" "$name"
mpirun -n 2 "./$name" render job.yaml -o out --set output.video=film.mp4 --set output.fps=5 >stdout.txt 2>stderr.txt &
launcher=$!
trap 'kill -KILL $launcher $(pgrep -x "$name") 2>/dev/null || true' EXIT
wait_until '[ "$(frames out)" -gt 5 ]'
# Signal one rank of the two, most often not rank 0.
pids=$(pgrep -x "$name")
[ "$(wc -w <<<"$pids")" = 2 ] || fail "expected two ranks, found: $pids"
kill -USR1 "$(tail -1 <<<"$pids")"
code=0
wait $launcher || code=$?
[ $code = 75 ] || { cat stderr.txt >&2; fail "exit $code, expected 75"; }
grep -q 'stopped on request' stderr.txt || fail "the log does not say why the run stopped"
done=$(jq .done out/status.json)
jq -e '.state == "incomplete" and .done < 4000' out/status.json >/dev/null || fail "status.json: $(cat out/status.json)"
[ "$(hashes out | wc -l)" = "$done" ] || fail "manifest and status.json disagree"
[ ! -e out/film.mp4 ] || fail "an incomplete video has the final name"
# The partial video holds the GOPs that are whole.
"$VIDEO_PROBE" out/film.partial.mp4 | grep -q "^$((done / 5 * 5)) frames" || fail "the partial video cannot be played, or has another length"
