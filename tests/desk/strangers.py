# SPDX-License-Identifier: BSD-3-Clause
"""Asks the desk what it must refuse: strangers.py ADDRESS DIRECTORY. STRANGERS: how many requests (default 10000)."""
import json
import os
import random
import socket
import sys
import time

address, directory = sys.argv[1:3]
host, secret = address.split("//")[1].split("/")[:2]
port = int(host.split(":")[1])
count = int(os.environ.get("STRANGERS", "10000"))
seed = int(os.environ.get("STRANGERS_SEED", str(random.randrange(1 << 30))))
dice = random.Random(seed)


def send(raw, wait=5):
    """The answer to raw bytes."""
    answer = b""
    with socket.create_connection(("127.0.0.1", port), timeout=wait) as line:
        try:
            line.sendall(raw)
            more = line.recv(65536)
            while more:
                answer += more
                more = line.recv(65536)
        except (ConnectionError, socket.timeout):
            pass  # what was answered until then counts
    return answer


def throw(raw):
    """Send raw bytes, and go."""
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=5) as line:
            line.sendall(raw)
            line.setblocking(False)
            if dice.randrange(4) == 0:
                line.recv(100)
    except OSError:
        pass


def request(method="POST", path="/" + secret + "/state", headers=None, body=b"{}", **more):
    own = {"Host": host, "Origin": "http://" + host, "Content-Length": str(len(body)), "Connection": "close"}
    own.update(headers or {})
    head = "%s %s HTTP/1.1\r\n" % (method, path) + "".join("%s: %s\r\n" % pair for pair in own.items() if pair[1] is not None)
    return send(head.encode("latin-1") + b"\r\n" + body, **more)


def code(answer):
    return int(answer.split(b" ")[1]) if answer.startswith(b"HTTP/") else 0


def expect(condition, what):
    if not condition:
        raise SystemExit("%s (STRANGERS_SEED=%d)" % (what, seed))


def good(seconds=60):
    """Is a page of the desk answered? With a sanitizer that may take its time."""
    end = time.time() + seconds
    while time.time() < end:
        try:
            answer = request(wait=min(20, seconds))
        except OSError:
            answer = b""
        if code(answer) == 200 and b'"revision"' in answer:
            return True
        time.sleep(0.2)
    return False


def foreign():
    """Requests that are refused with one code, each with it."""
    wrong = secret[:-1] + ("0" if secret[-1] != "0" else "1")
    return [
        (403, dict(path="/" + wrong + "/state")), (403, dict(path="/state")), (403, dict(path="/")), (403, dict(path="/" + secret)),
        (403, dict(path="/" + secret[:-1] + "/state")), (403, dict(path="//" + secret + "/state")), (403, dict(method="GET", path="/" + wrong + "/")),
        (403, dict(headers={"Origin": "http://evil.example"})), (403, dict(headers={"Origin": "null"})), (403, dict(headers={"Origin": None})),
        (403, dict(headers={"Origin": "http://127.0.0.1:1"})), (403, dict(headers={"Origin": "https://" + host})),
        (403, dict(headers={"Host": "evil.example:%d" % port, "Origin": "http://evil.example:%d" % port})),
        (403, dict(headers={"Host": "127.0.0.1.evil.example", "Origin": "http://127.0.0.1.evil.example"})),
        (404, dict(method="GET", path="/" + secret + "/etc/passwd")), (404, dict(method="GET", path="/" + secret + "/../../etc/passwd")),
        (404, dict(path="/" + secret + "/nothing")), (404, dict(path="/" + secret + "/state/../save")), (404, dict(path="/" + secret + "/" + "a" * 300)),
        (405, dict(method="DELETE")), (405, dict(method="PUT")), (413, dict(headers={"Content-Length": "999999999"}, body=b"")),
        (413, dict(headers={"Content-Length": "9" * 40}, body=b"")), (400, dict(body=b"[1")), (400, dict(body=b"[]")), (400, dict(body=b"\xff\xfe")),
        (400, dict(body=b"{" * 5000)), (400, dict(body=b'{"a": ' * 3000)),
    ]


def refused(body, verb="edit"):
    answer = request(path="/%s/%s" % (secret, verb), body=json.dumps(body).encode())
    return code(answer) == 200 and b'"refused":true' in answer


def noise():
    """A request that may be anything."""
    kind = dice.randrange(6)
    body = json.dumps({"edits": [["animation.camera.zoom", 1]], "size": [64, 48]}).encode()
    raw = ("POST /%s/move HTTP/1.1\r\nHost: %s\r\nOrigin: http://%s\r\nContent-Length: %d\r\n\r\n" % (secret, host, host, len(body))).encode() + body
    if kind == 0:
        return bytes(dice.randrange(256) for _ in range(dice.randrange(400)))
    if kind == 1:
        return raw[:dice.randrange(len(raw))]  # half a request
    if kind == 2:
        at = dice.randrange(len(raw))
        return raw[:at] + bytes([dice.randrange(256)]) + raw[at + 1:]
    if kind == 3:
        return b"POST /" + b"%2e%2e/" * dice.randrange(40) + b" HTTP/1.1\r\n\r\n"
    if kind == 4:
        return b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * dice.randrange(2000) + b"\r\n"
    return raw.replace(b"\r\n\r\n", b"\r\nTransfer-Encoding: chunked\r\n\r\n" + b"ffffffffffffffffffff\r\n", 1)


def main():
    expect(good(), "the desk does not answer")
    for wanted, how in foreign():
        found = code(request(**how))
        expect(found == wanted, "%s: answered with %d, expected %d" % (how, found, wanted))
    before = sorted(os.listdir(directory))
    for name in ("../out.yaml", "/tmp/out.yaml", "a/b.yaml", ".hidden.yaml", "job", "job.txt", "-o.yaml", "\u0001.yaml", "x" * 300 + ".yaml"):
        expect(refused({"name": name}, "save"), "a job was saved as " + name)
    expect(sorted(os.listdir(directory)) == before, "files were written")
    for edits in ([["animation.camera.zoom", -5]], [["nothing", 1]], [["", 1]], [["animation", "*x"]], [[1, 2]], ["x"], [["a" * 9000, "b"]],
                  [["animation.clip[99999999999999999999].at", "1 mm"]], [["tissues.\"", "1"]], [["output.size", [1, 1]]], [["volume", "/etc/passwd"]]):
        expect(refused({"edits": edits}), "a mistake was taken: %s" % edits)
        expect(refused({"edits": edits, "size": [64, 48], "group": "g" * 500}, "move"), "a mistake was taken by a hand: %s" % edits)
    for key in ("volume", "labels", "light.environment", "shots[0].light.environment", "output.directory"):
        answer = request(path="/%s/edit" % secret, body=json.dumps({"edits": [[key, "x"]]}).encode())
        expect(b"pages do not change this key" in answer, "a page has named a file by %s" % key)
    for size in ([0, 0], [99999, 99999], [64], "64x48", None):
        expect(refused({"size": size}, "move"), "a size was taken: %s" % size)
        expect(refused({"size": size, "x": 1, "y": 1}, "pick"), "a size was taken: %s" % size)
        expect(refused({"size": size, "which": 0}, "slice"), "a size was taken: %s" % size)
    expect(refused({"size": [64, 48], "which": 7}, "slice"), "a slice was taken that is none")
    # More lines than the desk accepts send a byte and never show the secret: they starve nobody, the oldest have to go.
    slow = [socket.create_connection(("127.0.0.1", port)) for _ in range(700)]
    for line in slow:
        try:
            line.sendall(b"POST /")
        except ConnectionError:
            pass
    expect(good(15), "lines that never show the secret keep others out")
    # Who goes in the middle of a request leaves nothing behind: not even until lines are closed that send nothing for 30 s.
    half = ("POST /%s/state HTTP/1.1\r\nHost: %s\r\nOrigin: http://%s\r\nContent-Length: 9\r\n\r\n{" % (secret, host, host)).encode()
    for _ in range(600):
        with socket.create_connection(("127.0.0.1", port), timeout=5) as line:
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_CORK, 1)  # the end comes with the data
            line.sendall(half)
    expect(good(15), "half requests keep others out")
    for i in range(count):
        throw(noise())
        if i % 1000 == 0:
            expect(good(), "after %d malformed requests the desk does not answer" % i)
    expect(good(), "in the end the desk does not answer")
    for line in slow[:400]:
        line.settimeout(5)
        try:
            while line.recv(1000):
                pass
        except ConnectionError:
            pass
        except socket.timeout:
            expect(False, "a line that never shows the secret stays open")


main()
