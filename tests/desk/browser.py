# SPDX-License-Identifier: BSD-3-Clause
"""A headless Chromium, driven over a pipe by the DevTools protocol: real pointers, keys and pictures."""
import base64
import json
import os
import subprocess
import time

OPTIONS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
           "--disable-background-networking", "--disable-component-update", "--disable-extensions", "--hide-scrollbars",
           "--remote-debugging-pipe", "--force-color-profile=srgb"]
KEYS = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Tab": 9, "Enter": 13, " ": 32, "Escape": 27}


class Page:
    """One tab. Errors of its console are kept in self.errors."""

    def __init__(self, browser, target):
        self.browser = browser
        self.session = browser.call("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
        self.errors = browser.errors.setdefault(self.session, [])
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")

    def call(self, method, parameters=None):
        return self.browser.call(method, parameters or {}, self.session)

    def open(self, address):
        self.call("Page.navigate", {"url": address})

    def run(self, script):
        """The value of an expression, which may be a promise."""
        found = self.call("Runtime.evaluate", {"expression": script, "awaitPromise": True, "returnByValue": True})
        if "exceptionDetails" in found:
            raise AssertionError(script + ": " + json.dumps(found["exceptionDetails"])[:600])
        return found["result"].get("value")

    def until(self, script, seconds=60):
        """Wait until an expression is true, and return its value."""
        end = time.time() + seconds
        while time.time() < end:
            value = self.run(script)
            if value or value == {}:  # an element
                return value
            time.sleep(0.05)
        self.shoot("failed.png")
        raise AssertionError("in %d s this did not become true (failed.png): %s; %s" % (seconds, script, self.errors))

    def window(self, width, height, dark=False, touch=False):
        self.call("Emulation.setDeviceMetricsOverride",
                  {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": touch})
        self.call("Emulation.setEmulatedMedia",
                  {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, **more})

    def click(self, x, y, count=1):
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", buttons=1, clickCount=count)

    def drag(self, start, end, steps=8, modifiers=0, pause=0.02):
        self.mouse("mousePressed", *start, button="left", buttons=1, clickCount=1, modifiers=modifiers)
        for i in range(1, steps + 1):
            at = [a + (b - a) * i / steps for a, b in zip(start, end)]
            self.mouse("mouseMoved", *at, button="left", buttons=1, modifiers=modifiers)
            time.sleep(pause)
        self.mouse("mouseReleased", *end, button="left", clickCount=1, modifiers=modifiers)

    def wheel(self, x, y, by):
        self.mouse("mouseWheel", x, y, deltaX=0, deltaY=by)

    def key(self, name, modifiers=0):
        code = KEYS.get(name, ord(name.upper()) if len(name) == 1 else 0)
        text = {"text": name} if len(name) == 1 and not modifiers else {"text": "\r"} if name == "Enter" else {}
        self.call("Input.dispatchKeyEvent", {"type": "keyDown", "key": name, "windowsVirtualKeyCode": code,
                                             "modifiers": modifiers, **text})
        self.call("Input.dispatchKeyEvent", {"type": "keyUp", "key": name, "windowsVirtualKeyCode": code,
                                             "modifiers": modifiers})

    def middle(self, selector):
        """The middle of an element, which is scrolled into view."""
        return self.run("(() => { const e = document.querySelector(%s); e.scrollIntoView({block: 'nearest'});"
                        " const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()"
                        % json.dumps(selector))

    def press(self, selector, count=1):
        self.click(*self.middle(selector), count=count)

    def shoot(self, path):
        self.call("Page.bringToFront")  # a page that is behind another draws nothing, and would be waited for
        shot = self.call("Page.captureScreenshot", {"format": "png"})
        with open(path, "wb") as file:
            file.write(base64.b64decode(shot["data"]))


class Browser:
    def __init__(self, program, profile):
        down, self.out = os.pipe()
        self.into, up = os.pipe()

        def place():  # the browser reads from 3 and writes to 4
            spare = [os.dup(down), os.dup(up)]
            os.dup2(spare[0], 3)
            os.dup2(spare[1], 4)

        self.process = subprocess.Popen([program, "--user-data-dir=" + profile, *OPTIONS, "about:blank"],
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=place,
                                        close_fds=False)
        os.close(down)
        os.close(up)
        self.buffer = b""
        self.number = 0
        self.errors = {}

    def read(self):
        while b"\0" not in self.buffer:
            more = os.read(self.into, 1 << 20)
            if not more:
                raise AssertionError("the browser has ended")
            self.buffer += more
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def note(self, message):
        """Keep what the console of a page complains of."""
        what, told = message.get("method"), message.get("params", {})
        if what == "Runtime.exceptionThrown" or (what == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning")) \
                or (what == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning")):
            self.errors.setdefault(message.get("sessionId"), []).append(json.dumps(told)[-900:])

    def call(self, method, parameters, session=None):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read()
            if answer.get("id") != self.number:
                self.note(answer)
                continue
            if "error" in answer:
                raise AssertionError(method + ": " + json.dumps(answer["error"]))
            return answer["result"]

    def page(self):
        return Page(self, self.call("Target.createTarget", {"url": "about:blank"})["targetId"])

    def close(self):
        self.process.terminate()
        self.process.wait()
