# SPDX-License-Identifier: BSD-3-Clause
"""Several ranks draw the pictures of one desk: ranks.py SEGCAST RANKS. Run in an empty directory."""
import http.client
import json
import os
import subprocess
import sys
import threading
import time

program, ranks = sys.argv[1], sys.argv[2]
NAME = "sc_desk_%d" % os.getpid()  # by which its processes are found under any launcher
os.symlink(program, NAME)
JOB = """volume: phantom:64x48x64
output: {directory: out, size: [320, 180], video: none, frames: png}
tissues: {"*": {opacity: 1}, "epicardial fat": {visible: false}}
overlays: {names: [aorta], scale_bar: bottom-left, legend: top-right}
animation: {frames: 12, camera: {orbit: {elevation: 10}}, clip: [{normal: anterior, at: 5 mm}]}
"""
# What is not one picture of one volume: slices beside it, a comparison, and shots, at frame 13.
BEGINNING = "volume: phantom:48x36x48\noutput: {directory: out, size: [320, 180], video: none}\n"
OTHERS = ("""tissues: {"*": {opacity: 0.5}}
render: {background: none}
overlays: {names: all, caption: Slices}
animation: {frames: 16, slices: 50%}
""", """compare: {with: [{volume: "phantom:40x28x41", name: other}], divider: {20%: 100%, 80%: 0%}}
overlays: {names: [aorta]}
animation: {frames: 16}
""", """animation: {frames: 12}
shots:
  - {card: Beat, animation: {frames: 3}}
  - {}
  - {transition: cross_fade 400 ms, light: {method: global}}
""")


def processes():
    """The numbers of the ranks that are there, rank 0 first."""
    found = []
    for number in subprocess.run(["pgrep", "-x", NAME], stdout=subprocess.PIPE, text=True).stdout.split():
        try:
            with open("/proc/%s/environ" % number) as file:
                variables = dict(one.split("=", 1) for one in file.read().split("\0") if "=" in one)
        except OSError:  # it has just ended
            continue
        found.append((int(variables.get("OMPI_COMM_WORLD_RANK", variables.get("PMI_RANK", 0))), int(number)))
    return [number for _, number in sorted(found)]


def spent(numbers):
    """The CPU seconds of processes."""
    ticks = 0
    for number in numbers:
        with open("/proc/%d/stat" % number) as file:
            ticks += sum(int(part) for part in file.read().rsplit(")", 1)[1].split()[11:13])
    return ticks / os.sysconf("SC_CLK_TCK")


def expect(condition, what):
    if not condition:
        raise AssertionError("%s ranks: %s" % (ranks, what))


class Desk:
    def __init__(self, job):
        self.process = subprocess.Popen(["mpirun", "-n", ranks, "./" + NAME, "desk", job, "--threads", "1", "--idle", "5"],
                                        stdout=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        _, _, self.host, self.secret = self.address.rstrip("/").split("/") if self.address else [""] * 4

    def ask(self, verb, **body):
        line = http.client.HTTPConnection(self.host, timeout=120)
        line.request("POST", "/%s/%s" % (self.secret, verb), json.dumps(body), {"Origin": "http://" + self.host})
        answer = line.getresponse()
        data = answer.read()
        kind = answer.headers["Content-Type"]
        expect(answer.status == 200 and b'"refused"' not in data[:20], "%s: %d %s" % (verb, answer.status, data[:300]))
        return json.loads(data) if kind == "application/json" else data

    def end(self, number, signal):
        os.kill(number, signal)
        code = self.process.wait(60)
        for _ in range(100):
            if not processes():
                return code
            time.sleep(0.1)
        raise AssertionError("%s ranks: %s are left behind" % (ranks, processes()))


def still(*options):
    """The picture of segcast still, which also says that the desk has saved what it has shown."""
    subprocess.run([program, "still", "job.yaml", "-o", "still.png", "--overwrite", "-q", *options], check=True, stdout=subprocess.DEVNULL)
    with open("still.png", "rb") as file:
        return file.read()


def use(desk):
    size, shown, job = [400, 225], [], "animation.camera.orbit.angle"
    for angle in (10, 20, 30):
        shown.append(desk.ask("move", size=size, group="turn", edits=[[job, angle], ["animation.clip[0].at", "%d mm" % angle]]))
    expect(len(set(shown)) == 3, "what moves is not seen")
    whole = desk.ask("picture", size=size)
    desk.ask("edit", edits=[["tissues.aorta.visible", False]])
    while not desk.ask("state")["fits"]:
        time.sleep(0.1)
    hidden, small = desk.ask("picture", size=size), desk.ask("sheet", size=[160, 90], frame=7)
    desk.ask("save", confirm=desk.ask("save")["confirm"])
    expect(hidden == still("--size", "400x225"), "the picture is not that of segcast still")
    expect(small == still("--size", "160x90", "--frame", "7"), "a picture of the sheet is not that of segcast still")
    expect(whole == still("--size", "400x225", "--set", "tissues.aorta.visible=true"), "the first picture is not that of segcast still")

    numbers = processes()
    expect(len(numbers) == int(ranks), "%s are there" % numbers)
    before = spent(numbers)
    time.sleep(2)
    expect(spent(numbers) - before < 0.5, "idle ranks take %.2f CPU seconds in 2 s" % (spent(numbers) - before))

    # All ranks give up a picture that takes minutes when another one is asked for.
    desk.ask("edit", edits=[["light.method", "path"], ["render.quality", "still"]])
    threading.Thread(target=desk.ask, args=("picture",), kwargs={"size": [1600, 900]}, daemon=True).start()
    time.sleep(2)
    begin = time.time()
    desk.ask("move", size=[1600, 900], edits=[[job, 40]])
    expect(time.time() - begin < 10, "a move was answered after %.1f s" % (time.time() - begin))
    # A signal that another rank than rank 0 gets is heard when that is not drawing.
    desk.ask("edit", edits=[["light.method", "plain"], ["render.quality", "film"]])
    desk.ask("picture", size=[400, 225])
    return numbers


def main():
    with open("job.yaml", "w") as file:
        file.write(JOB)
    desk = Desk("job.yaml")
    try:
        # The last rank alone gets the signal; then the launcher, which ends with a code of its own.
        expect(desk.end(use(desk)[-1], 2) == 0, "the desk does not end in order")
        for other in OTHERS:
            with open("job.yaml", "w") as file:
                file.write(BEGINNING + other)
            desk = Desk("job.yaml")
            desk.ask("move", size=[400, 225], frame=13, edits=[])
            expect(desk.ask("picture", size=[400, 225]) == still("--size", "400x225", "--frame", "13"), "another picture of " + other)
            desk.end(processes()[0], 2)
        desk = Desk("job.yaml")
        desk.ask("state")
        desk.end(desk.process.pid, 2)
        with open("bad.yaml", "w") as file:
            file.write(JOB + "light: {method: candle}\n")
        desk = Desk("bad.yaml")
        expect(desk.process.wait(60) == 65 and not processes(), "a mistake in the job does not end all ranks")
    finally:
        desk.process.kill()


main()
