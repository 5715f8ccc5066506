# SPDX-License-Identifier: BSD-3-Clause
# Frames that all ranks draw and some encode, GOP by GOP, give the same pictures and the same video to the byte as one
# rank does; also after a stop, which keeps every frame that was drawn, and after a run that was killed.
small_job job.yaml
sed -i 's/video: none/fps: 5, frames: png, video: film.mp4/; s/frames: 7/frames: 47/' job.yaml
"$SEGCAST" render job.yaml -o one -q >/dev/null

# compare DIR WHAT: the outputs in DIR are those of one rank.
compare() {
    [ "$(hashes "$1")" = "$(hashes one)" ] || fail "$2: the frames differ"
    cmp "$1/film.mp4" one/film.mp4 || fail "$2: the video differs"
    diff -r "$1/frames" one/frames || fail "$2: the PNG files differ"
    "$SEGCAST" verify "$1" >/dev/null || fail "$2: verify"
    [ ! -e "$1/segments" ] || fail "$2: segments are left"
}

for way in '2 auto' '4 auto' '4 frames' '4 tiles'; do
    read -r ranks partition <<<"$way"
    mpi "$ranks" "$SEGCAST" render job.yaml -o "all$ranks$partition" -q --set farm.encode=gather --set "farm.partition=$partition" >/dev/null
    compare "all$ranks$partition" "$ranks ranks, $partition"
done
# What encoders hold is limited by --max-memory.
expect 71 'farm.encode is gather: each rank that encodes holds frames of 1280 x 720 for 158 MiB .*--max-memory 1G' \
    mpi 2 "$SEGCAST" render job.yaml -o little --set 'output.size=[1280, 720]' --set farm.encode=gather --max-memory 130M
one_error
# Of the nine GOPs of five frames rank 0 encodes the first, and the last two frames; ranks 1 to 3 have encoded the others.
jq -e '[.traceEvents[] | select(.ph == "X" and (.name | startswith("encode")) and .pid > 1)] | length == 40' all4auto/trace.json >/dev/null ||
    fail "the trace does not hold 40 frames that ranks other than 0 have encoded"
jq -e '.frames | length == 47 and all(.render_cpu_s > 0 and .samples > 0)' all4auto/stats.json >/dev/null ||
    fail "stats.json does not hold what each frame took"

# interrupt DIR SIGNAL FRAMES: start a run with 3 ranks, and send the signal to one of them after so many frames.
name=sc_gather_$$ # to find the ranks by
ln -s "$SEGCAST" "$name"
trap 'kill -KILL $(pgrep -x "$name") 2>/dev/null || true' EXIT
interrupt() {
    local launcher pid code=0
    mpirun -n 3 "./$name" render job.yaml -o "$1" --set farm.encode=gather --set output.size=192x144 >/dev/null 2>stderr.txt &
    launcher=$!
    wait_until "[ \"\$(frames $1)\" -ge $3 ] || ! kill -0 $launcher 2>/dev/null"
    pid=$(pgrep -r R,S,D -x "$name" | tail -1) || fail "the run ended before it was interrupted"
    kill "-$2" "$pid"
    wait $launcher 2>/dev/null || code=$?
    echo $code
}
rm -rf one
"$SEGCAST" render job.yaml -o one -q --set output.size=192x144 >/dev/null

code=$(interrupt stopped USR1 10)
[ "$code" = 75 ] || { cat stderr.txt >&2; fail "exit $code after USR1, expected 75"; }
done=$(jq .done stopped/status.json)
[ "$(hashes stopped | wc -l)" = "$done" ] || fail "manifest and status.json disagree"
[ "$done" -lt 47 ] || fail "the run was not stopped"
mpi 2 "$SEGCAST" render job.yaml -o stopped -q --resume --set farm.encode=gather --set output.size=192x144 >/dev/null
compare stopped "stopped and resumed"

code=$(interrupt killed KILL 6)
[ "$code" != 0 ] || fail "the run was not killed"
for _ in $(seq 200); do pgrep -r R,S,D -x "$name" >/dev/null || break; sleep 0.05; done
mpi 4 "$SEGCAST" render job.yaml -o killed -q --resume --set farm.encode=gather --set output.size=192x144 >/dev/null
compare killed "killed and resumed"
