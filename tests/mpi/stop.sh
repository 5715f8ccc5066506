# USR1 to any rank: no new frames, what is in flight is finished, exit 75, a playable part.
small_job job.yaml
sed -i 's/frames: 7/frames: 4000/' job.yaml
name=sc_stop_$$ # to find the ranks by, under any launcher
ln -s "$SEGCAST" "$name"
mpirun -n 2 "./$name" render job.yaml -o out --set output.video=film.mp4 --set output.fps=5 >stdout.txt 2>stderr.txt &
launcher=$!
trap 'kill -KILL $launcher $(pgrep -x "$name") 2>/dev/null || true' EXIT
for _ in $(seq 300); do
    [ "$( (grep -c frame\" out/manifest.jsonl 2>/dev/null) || true)" -gt 5 ] 2>/dev/null && break
    sleep 0.1
done
# one rank of the two, most often not rank 0
pids=$(pgrep -x "$name")
[ "$(wc -w <<<"$pids")" = 2 ] || fail "expected two ranks, found: $pids"
kill -USR1 "$(tail -1 <<<"$pids")"
code=0
wait $launcher || code=$?
[ $code = 75 ] || { cat stderr.txt >&2; fail "exit $code, expected 75"; }
grep -q 'stopped on request' stderr.txt || fail "no message"
done=$(jq .done out/status.json)
jq -e '.state == "incomplete" and .done < 4000' out/status.json >/dev/null || fail "status"
[ "$(hashes out | wc -l)" = "$done" ] || fail "manifest and status disagree"
[ ! -e out/film.mp4 ] || fail "a part bears the final name"
# what can be looked at meanwhile: whole groups of pictures
"$VIDEO_PROBE" out/film.partial.mp4 | grep -q "^$((done / 5 * 5)) frames" || fail "the part cannot be played"
