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
    file: location.pathname, width: innerWidth, scroll: document.documentElement.scrollWidth, title: document.title, text: document.querySelector("main").innerText,
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
pages=(out/report scaling/report methods/report studies compared)
# All pages at all widths: the window of a browser is not narrower than some 500 pixels.
{
    cat <<'HTML'
<!DOCTYPE html><html><body style="margin: 0">
<script>const found = []; addEventListener("message", (e) => { found.push(e.data); document.documentElement.dataset.found = JSON.stringify(found); });</script>
HTML
    for page in "${pages[@]}"; do
        { sed '/^<\/body>$/,$d' "$page.html"; echo "<script>$(cat measure.js)</script></body></html>"; } >"$page.measured.html"
        for width in 390 1440 2560; do
            echo "<iframe src=\"$page.measured.html\" style=\"width: ${width}px; height: 900px; border: 0\"></iframe>"
        done
    done
} >frame.html
open_page() { # open_page FILE OPTION...: run the browser on a file, with what it says in browser.txt
    local file=$1
    shift
    timeout 120 "$browser" --headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --user-data-dir="$PWD/profile" \
        --no-first-run --disable-background-networking --disable-component-update --disable-extensions --virtual-time-budget=5000 \
        --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr --hide-scrollbars "$@" "file://$file" 2>browser.txt
}
echo '<!DOCTYPE html><p>here</p>' >empty.html
open_page "$PWD/empty.html" --dump-dom | grep -q here || skip "the browser does not run here: $(tail -n 1 browser.txt)"

for scheme in 0 1; do # dark, light
    open_page "$PWD/frame.html" --blink-settings=preferredColorScheme=$scheme --window-size=2600,900 --dump-dom >dom.html ||
        { cat browser.txt >&2; fail "the browser fails"; }
    sed -n 's/.*data-found="\([^"]*\)".*/\1/p' dom.html | sed 's/&quot;/"/g; s/&nbsp;/ /g; s/&lt;/</g; s/&gt;/>/g; s/&amp;/\&/g' >found$scheme.json
    ! grep -q CONSOLE browser.txt || fail "scheme $scheme: $(grep CONSOLE browser.txt)"
done

# shows PAGE CONDITION: the page shows what it should, at all widths, light and dark, and prints.
shows() {
    local page=$1 condition=$2
    for scheme in 0 1; do
        jq --arg file "/$page.measured.html" 'map(select(.file | endswith($file)))' found$scheme.json >found.json
        jq -e --argjson dark "$([ $scheme = 0 ] && echo true || echo false)" '
            (map(.width) | sort) == [390, 1440, 2560] and all(.[]; .scroll <= .width and .out == [] and .dark == $dark and
            (if $dark then .page < 0.05 else .page > 0.8 end) and ([.contrasts[] >= 4.5] | all) and
            ([.fetched[] | startswith("file:") or startswith("data:")] | all) and .silent == 0 and .numbers == 0 and .scripts == 3 and
            '"$condition"')' found.json >/dev/null || fail "$page, scheme $scheme: $(jq -c 'map(del(.text))' found.json) $(jq -r '.[0].text' found.json)"
    done
    open_page "$PWD/$page.html" --no-pdf-header-footer --print-to-pdf="$PWD/page.pdf" >/dev/null || fail "$page does not print"
    [ "$(head -c 5 page.pdf)" = %PDF- ] || fail "$page: what was printed is no PDF"
    grep -q '<noscript><p>A script draws this page' "$page.html" || fail "$page says nothing without scripts"
}
named='(.title | endswith("onerror=alert(1)>")) and (.text | contains("onerror=alert(1)>"))'
shows out/report "$named"' and .pictures == 7 and .heats == 2 and .plots == 2 and .focusable == 8 and (.text | test("7 frames in .*Limited by")) and
    .heads == ["The film", "The run", "Where the time went", "Ranks over time", "Cost along the film", "Work of each pixel", "Runs on this job", "Settings and files"]'
shows scaling/report "$named"' and .plots == 2 and .focusable == 5 and (.text | test("4: needs 4000 threads|6: needs 4000 threads")) and
    (.heads | index("Scaling") != null and index("Not measured") != null) and (.text | contains("All pixels agree"))'
shows methods/report "$named"' and .rows == 12 and .dots == 36 and .bold >= 2 and (.text | contains("the paper, its heart and computer")) and
    (.text | test("render.skip: [a-z]+ (is fastest|has the lowest median)")) and (.heads | index("Values of render.skip") != null and index("What limited the cells") != null)'
shows studies '(.text | contains("scaling and methods have no measured cell") or contains("no measured cell of the same name")) and .focusable == 0'
shows compared '.rows == 8 and .focusable == 0 and (.text | contains("another/directory with/a/rather/long/name")) and (.text | contains("All have drawn the same pictures"))'
