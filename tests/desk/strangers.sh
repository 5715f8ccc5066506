# SPDX-License-Identifier: BSD-3-Clause
# What is malformed, foreign or without the secret is refused, thousands of times, and the desk goes on serving.
command -v python3 >/dev/null || skip "python3 is not installed"
printf 'volume: phantom:24x20x24\noutput: {size: [64, 48], video: none}\nanimation: {frames: 3}\n' >job.yaml
"$SEGCAST" desk job.yaml --threads 1 >address.txt 2>desk.txt &
desk=$!
trap 'kill $desk 2>/dev/null || true' EXIT
for _ in $(seq 600); do
    [ ! -s address.txt ] || break
    kill -0 $desk 2>/dev/null || { cat desk.txt >&2; fail "the desk has ended"; }
    sleep 0.1
done
python3 "$SOURCE/tests/desk/strangers.py" "$(cat address.txt)" "$PWD" || { cat desk.txt >&2; fail "strangers are not refused as they should"; }
kill -0 $desk || { cat desk.txt >&2; fail "the desk has ended"; }
[ "$(find . -name '*.yaml')" = ./job.yaml ] || fail "files were written: $(find . -name '*.yaml')"
# A second desk at the same port says so.
port=$(sed 's|.*:\([0-9]*\)/.*|\1|' address.txt)
expect 73 "port $port .* is used by another program" "$SEGCAST" desk job.yaml --port "$port"
expect 64 "address of this machine" "$SEGCAST" desk job.yaml --listen nowhere
expect 66 "none.yaml" "$SEGCAST" desk none.yaml
printf 'volume: phantom:24x20x24\noutputs: {}\n' >wrong.yaml
expect 65 "wrong.yaml:2: " "$SEGCAST" desk wrong.yaml
kill -TERM $desk
code=0
wait $desk || code=$?
trap - EXIT
[ $code = 0 ] || { cat desk.txt >&2; fail "the desk has ended with exit code $code"; }
