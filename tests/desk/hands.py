# SPDX-License-Identifier: BSD-3-Clause
"""Uses the desk as hands would, in a real browser: hands.py BROWSER ADDRESS DIRECTORY. Prints, for each picture that was kept,
its file, its frame and its size. With DESK_SHOTS=DIR it keeps pictures of the page."""
import json
import os
import sys
import time

from browser import Browser

SHOTS = os.environ.get("DESK_SHOTS")
program, address, directory = sys.argv[1:4]
FINAL = "document.querySelector('#picture')?.dataset.kind === 'final' && Number(document.querySelector('#picture').dataset.revision)"
# What the server says of itself, asked for by the page.
ASK = "fetch(location.pathname + %s, {method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(%s)})"


def ask(page, verb, body):
    return page.run("(" + ASK % (json.dumps(verb), json.dumps(body)) + ").then((a) => a.json())")


def state(page):
    return ask(page, "state", {})


def rest(page):
    """Wait until the picture is refined, and nothing changes any more."""
    for _ in range(600):
        before = page.until(FINAL)
        now = state(page)
        if now["revision"] == before and now["fits"]:
            return now
        time.sleep(0.1)
    raise AssertionError("the picture does not come to rest: %s" % page.run("document.querySelector('#status').textContent"))


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def keep(page, name):
    """Keep the picture that is seen now, and what its pixels are on the screen."""
    now = rest(page)
    size = page.run("[document.querySelector('#picture').width, document.querySelector('#picture').height]")
    script = ("(async () => { const a = await " + ASK % ('"picture"', json.dumps({"size": size})) + ";"
              " const bytes = new Uint8Array(await a.arrayBuffer()); let s = ''; for (const b of bytes) s += String.fromCharCode(b);"
              " const shown = document.querySelector('#picture');"
              " const levels = (picture) => { const c = new OffscreenCanvas(picture.width, picture.height).getContext('2d', {willReadFrequently: true});"
              " c.drawImage(picture, 0, 0); return c.getImageData(0, 0, picture.width, picture.height).data; };"
              " const one = levels(await createImageBitmap(new Blob([bytes]))), two = levels(shown);"
              " return [btoa(s), one.length === two.length && one.every((v, i) => v === two[i])]; })()")
    import base64
    data, same = page.run(script)
    expect(same, name + ": what is on the screen is not the picture that the server sends")
    with open(os.path.join(directory, name), "wb") as file:
        file.write(base64.b64decode(data))
    print(name, now["frame"], "%dx%d" % tuple(size), flush=True)


def shoot(page, name):
    if SHOTS:
        page.shoot(os.path.join(SHOTS, name + ".png"))


def use(page):
    page.window(1440, 900)
    page.open(address)
    first = rest(page)
    expect(first["undo"] == 0 and not first["unsaved"], "something was changed before a hand did anything")
    x, y = page.middle("#picture")

    # The keyboard reaches everything, and everything has a name that can be read aloud.
    silent = page.run("[...document.querySelectorAll('button, input, select, summary, [tabindex]')].filter((e) => !(e.getAttribute('aria-label')"
                      " || e.textContent.trim() || e.labels?.length || e.title)).map((e) => e.outerHTML.slice(0, 80))")
    expect(not silent, "these have no name: %s" % silent)
    reached = set()
    for _ in range(200):
        page.key("Tab")
        reached.add(page.run("document.activeElement.id || document.activeElement.getAttribute('aria-label') || document.activeElement.textContent.trim()"))
    wanted = {"picture", "save", "render", "search", "playhead", "tab-Tissues", "transverse slice", "length"}
    expect(wanted <= reached, "the keyboard does not reach %s, only %s" % (wanted - reached, reached))
    page.run("document.querySelector('#picture').focus()")
    page.key("ArrowLeft")
    keyed = rest(page)
    expect(keyed["orbit"]["angle"] == 5 and keyed["undo"] == 1, "an arrow key does not turn by five degrees: %s" % keyed["orbit"])
    page.key("z", modifiers=2)
    page.until("document.querySelector('#undo:disabled')")
    rest(page)

    # Turn, zoom, undo, redo.
    page.drag((x - 60, y), (x + 60, y - 20))
    turned = rest(page)
    expect(abs(turned["orbit"]["angle"]) > 5 and turned["orbit"]["elevation"] < 10, "a drag does not turn: %s" % turned["orbit"])
    expect(turned["undo"] == 1, "a drag is %d steps" % turned["undo"])
    page.wheel(x + 40, y, -300)
    zoomed = rest(page)
    expect(zoomed["orbit"]["zoom"] > 1.2 and zoomed["orbit"]["hasTarget"], "the wheel does not zoom to the pointer: %s" % zoomed["orbit"])
    page.press("#undo")
    page.until("document.querySelector('#redo:not(:disabled)')")
    expect(rest(page)["orbit"]["zoom"] == 1, "undo does not undo the zoom")
    page.key("y", modifiers=2)
    page.until("document.querySelector('#redo:disabled')")
    expect(rest(page)["orbit"]["zoom"] > 1.2, "redo does not zoom again")

    # Select in the list and in the picture; hide; colour.
    page.press("#search")
    for letter in "aorta":
        page.key(letter)
    page.until("document.querySelectorAll('#tissues li').length < 4")
    page.press("#tissues li .name")
    page.until("document.querySelector('#detail h2')?.textContent.toLowerCase().includes('aorta')")
    expect(" ml" in page.run("document.querySelector('#detail').textContent"), "the volume of the tissue is not told")
    page.run("(() => { const s = document.querySelector('#search'); s.value = ''; s.dispatchEvent(new Event('input')); })()")
    page.click(x, y)
    picked = page.until("document.querySelector('#place') && document.querySelector('#tissues li.selected')?.dataset.id")
    page.press("#tissues li.selected input[type=checkbox]")
    hidden = rest(page)
    expect(not [t for t in hidden["tissues"] if t["id"] == int(picked)][0]["visible"], "the tissue is still shown")
    shoot(page, "hidden")

    # Show one alone, and all again: nothing of it stays in the job.
    page.press("#tissues li.selected button.small")
    page.until("!document.querySelector('.banner').hidden")
    alone = state(page)
    expect([t["id"] for t in alone["tissues"] if t["visible"]] == [int(picked)], "solo shows others, too")
    page.press("#tissues li.selected button.small")
    page.until("document.querySelector('.banner').hidden")
    expect(state(page)["job"]["tissues"] == hidden["job"]["tissues"], "what solo has changed stays in the job")
    rest(page)

    # Cut by the handle.
    page.press("#tab-Cut")
    page.press("button[aria-label='Add a sagittal plane']")
    page.until("document.querySelector('.grip')")
    before = rest(page)["job"]["animation"]["clip"][0]
    grip = page.middle(".grip")
    page.drag(grip, (grip[0] + 25, grip[1]))
    moved = rest(page)["job"]["animation"]["clip"][0]
    expect(moved["at"] != before["at"] and moved["at"].endswith("mm"), "the handle does not move the plane: %s" % moved)
    tip = page.middle(".tip")
    page.drag(tip, (tip[0], tip[1] - 30))
    tilted = rest(page)["job"]["animation"]["clip"][0]
    expect(isinstance(tilted["normal"], list), "the arrow does not turn the plane: %s" % tilted)
    shoot(page, "cut")
    keep(page, "first.png")

    # Two keys, play.
    page.run("(() => { const s = document.querySelector('#playhead'); s.value = 0; s.dispatchEvent(new Event('input')); })()")
    rest(page)
    page.run("(() => { const s = [...document.querySelectorAll('#timeline select')][0]; s.value = 'zoom'; })()")
    page.press("button[aria-label^='Set a key']")
    rest(page)
    page.run("(() => { const s = document.querySelector('#playhead'); s.value = 11; s.dispatchEvent(new Event('input')); })()")
    rest(page)
    page.press("#picture")
    for _ in range(3):
        page.key("+")
    page.press("button[aria-label^='Set a key']")
    keyed = rest(page)
    keys = keyed["job"]["animation"]["camera"]["zoom"]
    expect(len(keys) == 2 and keys["100%"] > 1.2 * keys["0%"], "there are no two keys: %s" % keys)
    expect(page.run("document.querySelectorAll('.key').length") == 2, "the timeline does not show two keys")
    page.press("button[aria-label='Play or stop']")
    page.until("document.querySelector('#clock').textContent.includes('5 of') || document.querySelector('#clock').textContent.includes('11 of')")
    page.until("document.querySelector('button[aria-label=\"Play or stop\"]').textContent === '▶'")
    shoot(page, "film")
    keep(page, "last.png")

    # A verb is dragged in time, and so are its ends; the keyboard does it, too. The sheet shows all of the film.
    page.run("(() => { const s = [...document.querySelectorAll('#timeline select')].find((one) => one.value === ''); s.value = 'rock'; s.dispatchEvent(new Event('change')); })()")
    page.until("document.querySelector('.bar')")
    place = lambda: [float(time.rstrip("%")) for time in rest(page)["job"]["animation"]["verbs"][0]["during"]]
    label = "document.querySelector('.bar').getAttribute('aria-label')"
    way = page.run("document.querySelector('.bar').parentElement.clientWidth")
    for selector, by, wanted in ((".bar", 20, (20, 20)), ("[aria-label='end of rock']", -10, (0, -10)), ("[aria-label='begin of rock']", 10, (10, 0))):
        before, told, at = place(), page.run(label), page.middle(selector)
        page.drag(at, (at[0] + way * by / 100, at[1]))
        page.until("%s !== %s" % (label, json.dumps(told)))
        after = place()
        expect(all(abs(b + w - a) < 1.5 for a, b, w in zip(after, before, wanted)), "%s was dragged from %s to %s" % (selector, before, after))
    page.run("document.querySelector('.bar').focus()")
    before = place()
    page.key("ArrowLeft")
    page.until("document.querySelector('.bar').style.left.startsWith('%d')" % round(before[0] - 1))
    expect(page.run("document.activeElement.className") == "bar", "the keyboard loses what it moves")
    shoot(page, "verb")
    page.press("button[aria-label='Remove rock']")
    page.until("!document.querySelector('.bar')")
    page.press("button[aria-label='Small pictures of all of the film']")
    page.until("[...document.querySelectorAll('#sheet img')].every((one) => one.naturalWidth > 100)")
    expect(page.run("document.querySelectorAll('#sheet img').length") == 12, "the sheet does not show 12 frames")
    different = page.run("new Set([...document.querySelectorAll('#sheet img')].map((one) => { const c = document.createElement('canvas');"
                         " c.getContext('2d').drawImage(one, 0, 0); return c.toDataURL(); })).size")
    expect(different == 12, "the sheet shows %d different frames" % different)
    shoot(page, "sheet")
    page.press("#sheet button:nth-child(12)")
    expect(rest(page)["frame"] == 11, "the sheet does not lead to its frames")

    # Exempt a tissue from one plane of two.
    page.press("#tab-Cut")
    page.press("button[aria-label='Add a coronal plane']")
    page.until("document.querySelectorAll('#planes > li').length === 2")
    page.press("#tab-Tissues")
    page.press("#tissues li:nth-child(2) .name")
    page.press("[data-name='exempt Plane 2']")
    spared = rest(page)["job"]["animation"]["clip"]
    expect("except" not in spared[0] and len(spared[1]["except"]) == 1, "one plane was to spare the tissue: %s" % spared)
    expect(page.run("document.querySelector(\"[data-name^='exempt stays']\").indeterminate"), "that some planes spare it is not shown")
    shoot(page, "exempt")
    page.press("[data-name^='exempt stays']")
    expect(all(len(plane["except"]) == 1 for plane in rest(page)["job"]["animation"]["clip"]), "all planes were to spare the tissue")
    # Of a pattern that names it, the others stay.
    page.run("document.querySelector('#tissues li.selected .name').focus()")
    ask(page, "edit", {"edits": [["animation.clip[1].except", ["*valve", "aorta"]]]})
    rest(page)
    page.press("[data-name='exempt Plane 2']")
    left = rest(page)["job"]["animation"]["clip"][1]["except"]
    expect(sorted(left) == ["aorta", "aortic valve", "mitral valve", "tricuspid valve"], "the pattern becomes %s" % left)
    for _ in range(5):
        page.press("#undo")
        rest(page)

    # A mistake is told, and changes nothing.
    length = page.middle("#length")
    page.click(*length, count=3)
    for letter in "12 apples":
        page.key(letter)
    page.key("Enter")
    page.until("document.querySelector('#status.error')?.textContent.includes('apples')")
    expect(rest(page)["frames"] == 12, "a mistake has changed the film")

    # A look has values for keys that the job does not name. Until its light is gathered the picture is in plain light.
    more = page.run("(async () => { await %s; const a = await %s; await a.blob(); return JSON.parse(a.headers.get('X-View')).more; })()" % (
        ASK % ('"edit"', json.dumps({"edits": [["look", "studio"]]})), ASK % ('"picture"', json.dumps({"size": [320, 180], "after": -1}))))
    expect(more, "no picture in plain light comes before one whose light is gathered")
    rest(page)
    expect(page.run("document.querySelector('select[aria-label=Light]').value") == "global", "the page does not show the light of the look")
    page.press("#undo")
    rest(page)

    # Another window shows the same.
    other = page.browser.page()
    other.window(1024, 768, dark=True)
    other.open(address)
    expect(rest(other)["revision"] == state(page)["revision"], "two windows show two jobs")
    expect(other.run("document.documentElement.scrollWidth") <= 1024, "the page is wider than the window")
    shoot(other, "medium-dark")
    other.window(390, 844)
    rest(other)
    expect(other.run("document.documentElement.scrollWidth") <= 390, "the page is wider than a telephone")
    shoot(other, "narrow")

    # Save: the difference is shown, then written.
    page.press("#save")
    page.until("document.querySelector('#difference')?.textContent.includes('epicardial fat') || document.querySelector('#difference')")
    shoot(page, "save")
    page.press("#confirm")
    page.until("document.querySelector('#status')?.textContent.startsWith('Saved')")
    expect(not state(page)["unsaved"], "the job was not saved")

    # Render it here.
    page.press("#render")
    page.until("document.querySelector('#here')")
    page.press("#here")
    page.until("document.querySelector('#status')?.textContent.startsWith('Rendered')")
    expect(os.path.exists(os.path.join(directory, "out", "frames", "000011.png")), "there are no frames")
    for one in (page, other):
        expect(not one.errors, "the console complains: %s" % one.errors)


def main():
    browser = Browser(program, os.path.join(directory, "profile"))
    try:
        use(browser.page())
    finally:
        browser.close()


main()
