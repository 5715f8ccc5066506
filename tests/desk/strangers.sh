# SPDX-License-Identifier: BSD-3-Clause
# What is malformed, foreign or without the secret is refused, thousands of times, and the desk goes on serving.
command -v python3 >/dev/null || skip "python3 is not installed"
printf 'volume: phantom:24x20x24\noutput: {size: [64, 48], video: none}\nanimation: {frames: 3}\n' >job.yaml
# The browser is opened by a file that only its owner can read, and that is gone in the end; not through SSH.
mkdir run
printf '#!/bin/sh\nstat -c %%a "$1" >seen.txt\ncat "$1" >>seen.txt\n' >xdg-open
chmod +x xdg-open
DISPLAY=:9 XDG_RUNTIME_DIR=$PWD/run PATH=$PWD:$PATH env -u SSH_CONNECTION "$SEGCAST" desk job.yaml --threads 1 >address.txt 2>desk.txt &
wait_for_desk address.txt
python3 "$SOURCE/tests/desk/strangers.py" "$(cat address.txt)" "$PWD" || { cat desk.txt >&2; fail "strangers are not refused as they should"; }
kill -0 $desk || { cat desk.txt >&2; fail "the desk has ended"; }
! ps -o stat= --ppid $desk | grep -q Z || fail "what opens the browser stays behind as a zombie"
[ "$(find . -name '*.yaml')" = ./job.yaml ] || fail "files were written: $(find . -name '*.yaml')"
# A second desk at the same port says so.
port=$(sed 's|.*:\([0-9]*\)/.*|\1|' address.txt)
expect 73 "port $port .* is used by another program" "$SEGCAST" desk job.yaml --port "$port"
expect 64 "address of this machine" "$SEGCAST" desk job.yaml --listen nowhere
expect 64 "expected a path of 1 to" "$SEGCAST" desk job.yaml --listen unix:
expect 73 "job.yaml is there already" "$SEGCAST" desk job.yaml --listen unix:job.yaml
expect 66 "none.yaml" "$SEGCAST" desk none.yaml
printf 'volume: phantom:24x20x24\noutputs: {}\n' >wrong.yaml
expect 65 "wrong.yaml:2: " "$SEGCAST" desk wrong.yaml
end_desk TERM
grep -q "url=$(cat address.txt)\"" seen.txt && [ "$(head -n 1 seen.txt)" = 600 ] && [ -z "$(ls run)" ] || fail "the browser is not opened as it should: $(cat seen.txt; ls run)"

# A Unix socket is for its owner alone; one that a killed desk has left is replaced, one that is used is not.
python3 -c 'import socket; socket.socket(socket.AF_UNIX).bind("here")'
"$SEGCAST" desk job.yaml --threads 1 --listen unix:here --port 4711 >unix.txt 2>desk.txt &
wait_for_desk unix.txt
grep -q "ssh -L 4711:$(pwd -P)/here " desk.txt || fail "how to reach the socket is not told: $(cat desk.txt)"
[ "$(stat -c %a here)" = 600 ] || fail "others may use the socket: $(stat -c %a here)"
expect 73 "here is there already" "$SEGCAST" desk job.yaml --listen unix:here
python3 - "$(cat unix.txt)" <<'PYTHON' || fail "the desk is not there behind its socket"
import socket
import sys

host, secret = sys.argv[1].split("/")[2:4]
for address, code in ((secret, b"200"), ("0" * len(secret), b"403")):
    line = socket.socket(socket.AF_UNIX)
    line.connect("here")
    line.sendall(("GET /%s/ HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n\r\n" % (address, host)).encode())
    assert line.recv(100).split(b" ")[1] == code, code
PYTHON
end_desk TERM
[ ! -e here ] || fail "the socket stays behind"
