# SPDX-License-Identifier: BSD-3-Clause
# Pages in a real browser, at 390, 1440 and 2560 pixels, light and dark: they show what their data say, nothing sticks
# out, nothing is fetched, nothing is complained of, letters can be read, all charts have words, and they print.
# SC_BROWSER: a Chromium; otherwise chromium, chromium-browser or google-chrome is looked for.
browser=
for name in "${SC_BROWSER:-}" chromium chromium-browser google-chrome; do
    [ -z "$browser" ] && [ -n "$name" ] && command -v "$name" >/dev/null && browser=$name
done
[ -n "$browser" ] || skip "no browser is installed: chromium, chromium-browser, google-chrome, or SC_BROWSER"
command -v jq >/dev/null || skip "jq is not installed"

hostile='</title></script><script>document.title = 1</script><img src=x onerror=alert(1)>'
small_job job.yaml
sed -i 's/video: none/fps: 4/' job.yaml
"$SEGCAST" render job.yaml -o out -q --threads 2 --set "output.title=A film with aratherlongwordinitthatcannotbebrokenanywhere $hostile" >/dev/null
"$SEGCAST" render job.yaml -o 'another/directory with/a/rather/long/name' -q --set output.video=none --set output.frames=png >/dev/null
"$SEGCAST" report out 'another/directory with/a/rather/long/name' -o compared.html >/dev/null
cat >study.yaml <<YAML
title: "A study with aratherlongwordinitthatcannotbebrokenanywhere $hostile"
set: {volume: "phantom:32x24x32", output: {size: 64x64}, animation: {frames: 4}}
sweep: {render.skip: [none, interior, leap], output.size: [32x32, 64x64], threads: [1, 2, 4000]}
least: 6
most: 6
budget: 20 min
YAML
"$SEGCAST" study study.yaml -o scaling -q >/dev/null 2>&1
sed -i 's/, threads: .*}/}/' study.yaml
"$SEGCAST" study study.yaml -o methods -q >/dev/null
"$SEGCAST" report methods scaling -o studies.html >/dev/null

# A script at the end of a copy of the page measures it, and sends what it finds to the page around it.
cat >measure.js <<'JS'
window.addEventListener("load", () => {
  const rgb = (key) => getComputedStyle(document.body).getPropertyValue(key);
  const light = (color) => {
    document.body.style.color = color;
    const c = getComputedStyle(document.body).color.match(/[0-9.]+/g).slice(0, 3)
      .map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  };
  const contrast = (a, b) => {
    const x = light(rgb(a)), y = light(rgb(b));
    return (Math.max(x, y) + 0.05) / (Math.min(x, y) + 0.05);
  };
  const all = (selector) => [...document.querySelectorAll(selector)];
  parent.postMessage({
    width: innerWidth, scroll: document.documentElement.scrollWidth, title: document.title, text: document.querySelector("main").innerText,
    out: all("main *").filter((e) => {
      const box = e.getBoundingClientRect();
      return box.width > 0 && (box.right > innerWidth + 1 || box.left < -1);
    }).map((e) => e.tagName + ":" + e.textContent.slice(0, 30)),
    dark: matchMedia("(prefers-color-scheme: dark)").matches, page: light(rgb("--page")),
    contrasts: ["--ink", "--soft", "--link"].flatMap((k) => [contrast(k, "--page"), contrast(k, "--card")]),
    fetched: performance.getEntriesByType("resource").map((e) => e.name),
    focusable: all("a[href], summary, video[controls]").length, pictures: all("img").length, heats: all("canvas").length,
    scripts: all("script").length, plots: all("svg.plot").length, rows: all("svg.strip").length, heads: all("h2").map((e) => e.innerText),
    dots: all("circle.dot").length, bold: all("td b").length,
    silent: all("svg.plot, svg.strip, canvas, img").filter((e) => !(e.getAttribute("aria-label") ?? e.alt)).length,
    numbers: all("svg *").filter((e) => /NaN|undefined|Infinity/.test(e.outerHTML)).length,
  }, "*");
});
JS
# The page at all widths: the window of a browser is not narrower than some 500 pixels.
cat >frame.html <<'HTML'
<!DOCTYPE html><html><body style="margin: 0">
<script>const found = []; addEventListener("message", (e) => { found.push(e.data); document.documentElement.dataset.found = JSON.stringify(found); });</script>
<iframe src="measured.html" style="width: 390px; height: 900px"></iframe><iframe src="measured.html" style="width: 1440px; height: 900px"></iframe>
<iframe src="measured.html" style="width: 2560px; height: 900px"></iframe></body></html>
HTML
sed -i 's/height: 900px/&; border: 0/g' frame.html
open_page() { # open_page FILE OPTION...: run the browser on a file, with what it says in browser.txt
    local file=$1
    shift
    timeout 120 "$browser" --headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --user-data-dir="$PWD/profile" \
        --no-first-run --disable-background-networking --disable-component-update --disable-extensions --virtual-time-budget=5000 \
        --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr --hide-scrollbars "$@" "file://$file" 2>browser.txt
}
echo '<!DOCTYPE html><p>here</p>' >empty.html
open_page "$PWD/empty.html" --dump-dom | grep -q here || skip "the browser does not run here: $(tail -n 1 browser.txt)"

# shows PAGE CONDITION: the page shows what it should, at all widths, light and dark, and prints.
shows() {
    local page=$1 condition=$2 folder
    folder=$PWD/$(dirname "$page")
    sed '/^<\/body>$/,$d' "$page" >"$folder/measured.html"
    echo "<script>$(cat measure.js)</script></body></html>" >>"$folder/measured.html"
    [ "$folder/frame.html" -ef frame.html ] || cp frame.html "$folder/frame.html"
    for scheme in 0 1; do # dark, light
        open_page "$folder/frame.html" --blink-settings=preferredColorScheme=$scheme --window-size=2600,900 --dump-dom >dom.html ||
            { cat browser.txt >&2; fail "$page: the browser fails"; }
        sed -n 's/.*data-found="\([^"]*\)".*/\1/p' dom.html | sed 's/&quot;/"/g; s/&nbsp;/ /g; s/&lt;/</g; s/&gt;/>/g; s/&amp;/\&/g' >found.json
        jq -e --argjson dark "$([ $scheme = 0 ] && echo true || echo false)" '
            (map(.width) | sort) == [390, 1440, 2560] and all(.[]; .scroll <= .width and .out == [] and .dark == $dark and
            (if $dark then .page < 0.05 else .page > 0.8 end) and ([.contrasts[] >= 4.5] | all) and
            ([.fetched[] | startswith("file:") or startswith("data:")] | all) and .silent == 0 and .numbers == 0 and .scripts == 3 and
            '"$condition"')' found.json >/dev/null || fail "$page, scheme $scheme: $(jq -c 'map(del(.text))' found.json) $(jq -r '.[0].text' found.json)"
        ! grep -q CONSOLE browser.txt || fail "$page: $(grep CONSOLE browser.txt)"
    done
    rm "$folder/measured.html"
    open_page "$PWD/$page" --no-pdf-header-footer --print-to-pdf="$PWD/page.pdf" >/dev/null || fail "$page does not print"
    [ "$(head -c 5 page.pdf)" = %PDF- ] || fail "$page: what was printed is no PDF"
    grep -q '<noscript><p>A script draws this page' "$page" || fail "$page says nothing without scripts"
}
named='(.title | endswith("onerror=alert(1)>")) and (.text | contains("onerror=alert(1)>"))'
shows out/report.html "$named"' and .pictures == 7 and .heats == 2 and .plots == 2 and .focusable == 8 and (.text | test("7 frames in .*Limited by")) and
    .heads == ["The film", "The run", "Where the time went", "Ranks over time", "Cost along the film", "Work of each pixel", "Runs on this job", "Settings and files"]'
shows scaling/report.html "$named"' and .plots == 2 and .focusable == 5 and (.text | test("4: needs 4000 threads|6: needs 4000 threads")) and
    (.heads | index("Scaling") != null and index("Not measured") != null) and (.text | contains("All pixels agree"))'
shows methods/report.html "$named"' and .rows == 12 and .dots == 36 and .bold >= 2 and (.text | contains("the paper, its heart and computer")) and
    (.text | test("render.skip: [a-z]+ (is fastest|has the lowest median)")) and (.heads | index("Values of render.skip") != null and index("What limited the cells") != null)'
shows studies.html '(.text | contains("scaling and methods have no measured cell") or contains("no measured cell of the same name")) and .focusable == 0'
shows compared.html '.rows == 8 and .focusable == 0 and (.text | contains("another/directory with/a/rather/long/name")) and (.text | contains("All have drawn the same pictures"))'
