# SPDX-License-Identifier: BSD-3-Clause
# Progress from the first second, never wider than the terminal; status.json with the phase; a signal ends
# every phase within a second or so, with exit code 75, and leaves nothing behind.
export SEGCAST_CACHE=off
slow=phantom:512x512x512 # takes some seconds to make and to prepare
cat >slow.yaml <<YAML
volume: $slow
output: {directory: out, size: [320, 240], video: film.mp4}
animation: {frames: 20, camera: {orbit: {axis: superior}}}
YAML

# status.json names the phase before the volume is read; a directory that was only begun is no run.
"$SEGCAST" render slow.yaml >/dev/null 2>log.txt &
pid=$!
trap 'kill -KILL $pid 2>/dev/null || true' EXIT
for _ in $(seq 100); do [ -e out/status.json ] && break; sleep 0.05; done
jq -e '.state == "running" and .done == 0 and .total == 20 and (.phase | length > 0)' out/status.json >/dev/null ||
    fail "status.json has no phase: $(cat out/status.json)"
expect 75 '' "$SEGCAST" status out
kill -KILL $pid
wait $pid || true
"$SEGCAST" render slow.yaml -q --set volume=phantom:20x20x20 >/dev/null || fail "what was only begun cannot be begun again"
"$SEGCAST" verify out >/dev/null || fail "the run after that is not whole"
jq -e 'has("phase") | not' out/status.json >/dev/null || fail "a complete run has a phase"
rm -rf out
expect 65 '' "$SEGCAST" render slow.yaml --set volume=slow.yaml
[ ! -e out ] || fail "a volume that cannot be read has left $(ls -A out)"

# stop AFTER SIGNAL COMMAND...: the command ends within a second of the signal, and leaves nothing.
stop() {
    local after=$1 signal=$2 begin ms code=0
    shift 2
    ls -A >before.txt
    "$SEGCAST" "$@" >/dev/null 2>stderr.txt &
    pid=$!
    sleep "$after"
    kill "-$signal" $pid 2>/dev/null || fail "$*: ended before the signal: $(cat stderr.txt)"
    begin=$(date +%s%N)
    wait $pid || code=$?
    ms=$((($(date +%s%N) - begin) / 1000000))
    [ $code = 75 ] || { cat stderr.txt >&2; fail "$*: $signal: exit code $code, expected 75"; }
    [ $ms -lt 10000 ] || fail "$*: $signal took $ms ms" # within a second, but for a busy machine
    grep -q 'stopp' stderr.txt || fail "$*: the signal is not answered"
    ls -A >after.txt
    diff before.txt after.txt || fail "$*: $signal leaves files behind"
}
touch before.txt after.txt stderr.txt
"$SEGCAST" convert $slow -o slow.nrrd -q >/dev/null # packed
"$SEGCAST" convert phantom:64x64x64 -o small.nrrd -q >/dev/null
stop 1 INT convert phantom:800x800x800 -o new.nrrd
stop 1 TERM info slow.nrrd
stop 1 HUP render slow.yaml
stop 1.5 TERM convert slow.yaml -o new.segc
stop 1.5 INT still slow.yaml -o new.png --set volume=small.nrrd --set 'output.size=[8192, 8192]' --set render.quality=still
stop 2 INT orbit small.nrrd -o new.mp4 --set 'output.size=[8192, 8192]' --set render.quality=still

# One huge frame of a run is given up.
"$SEGCAST" render slow.yaml --set volume=small.nrrd --set 'output.size=[8192, 8192]' --set render.quality=still --set output.video=none --set output.frames=png >/dev/null 2>stderr.txt &
pid=$!
for _ in $(seq 200); do jq -e '.phase == "drawing"' out/status.json >/dev/null 2>&1 && break; sleep 0.05; done
begin=$(date +%s%N)
kill -INT $pid
code=0
wait $pid || code=$?
[ $code = 75 ] || { cat stderr.txt >&2; fail "a huge frame: exit code $code"; }
ms=$((($(date +%s%N) - begin) / 1000000))
[ $ms -lt 10000 ] || fail "a huge frame was given up only after $ms ms"
jq -e '.state == "incomplete"' out/status.json >/dev/null || fail "status.json: $(cat out/status.json)"

# One that is being compressed cannot be given up: then the process ends. Here it would take for ever.
if [ -e "${ENDLESS_DEFLATE:-}" ]; then
    png=(render slow.yaml -o png --set volume=small.nrrd --set output.frames=png --set animation.frames=2)
    env LD_PRELOAD="$ENDLESS_DEFLATE" DEFLATE_BEGINS="$PWD/begins" "$SEGCAST" "${png[@]}" >/dev/null 2>stderr.txt &
    pid=$!
    for _ in $(seq 600); do [ -e begins ] && break; sleep 0.05; done
    [ -e begins ] || { cat stderr.txt >&2; fail "no frame was compressed"; }
    kill -INT $pid
    code=0
    wait $pid || code=$?
    [ $code = 75 ] || { cat stderr.txt >&2; fail "a frame being compressed: exit code $code"; }
    grep -q 'stopped on request' stderr.txt || { cat stderr.txt >&2; fail "a frame being compressed: the signal is not answered"; }
    [ -z "$(find png -name '.*.tmp.*' -o -name '*.png')" ] || fail "a frame being compressed has left $(find png)"
    expect 0 '' "$SEGCAST" "${png[@]}" --resume
    "$SEGCAST" verify png >/dev/null || fail "the run after that is not whole"
    rm -rf png
fi

# In a log a line appears after five seconds, and none with -q. They pass while both stand still.
"$SEGCAST" info slow.nrrd >/dev/null 2>log.txt &
pid=$!
"$SEGCAST" info slow.nrrd -q >/dev/null 2>quiet.txt &
quiet=$!
trap 'kill -KILL $pid $quiet 2>/dev/null || true' EXIT
sleep 0.5
kill -STOP $pid $quiet
sleep 5
kill -CONT $pid $quiet
for _ in $(seq 200); do [ ! -s log.txt ] || break; sleep 0.05; done
sleep 0.2
kill -KILL $pid $quiet
wait $pid $quiet || true
grep -qE '^segcast: (reading|preparing): [0-9]+ %  [0-9:]+( left)?$' log.txt || fail "log: $(cat log.txt)"
[ ! -s quiet.txt ] || fail "-q: $(cat quiet.txt)"

# On a terminal no line is wider than the terminal, whatever it is called.
command -v script >/dev/null || skip "the rest needs script(1)"
name="ein sehr langer Name mit äöü und 心臓 für eine Datei, die kein Terminal fasst.nrrd"
cp slow.nrrd "$name"
for columns in 20 50 132; do
    TERM=xterm script -qc "stty cols $columns; timeout --foreground -s INT 2.5 '$SEGCAST' info '$name'" typescript.txt >/dev/null </dev/null || true
    tr '\r' '\n' <typescript.txt | sed 's/\x1b\[[0-9]*[A-Za-z]//g' | grep -E '^(reading|preparing)' >bars.txt ||
        fail "no progress in $columns columns"
    widest=$(LC_ALL=C.UTF-8 wc -L <bars.txt)
    [ "$widest" -lt "$columns" ] || fail "a line of $widest characters in $columns columns"
    grep -q '%' bars.txt || [ "$columns" = 20 ] || fail "no percentage in $columns columns"
done
grep -q '\[#*\.*\]' bars.txt || fail "no bar"
