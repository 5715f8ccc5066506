# SPDX-License-Identifier: BSD-3-Clause
# Reports in a real browser: at 1440 and 390 pixels, light and dark, nothing sticks out, nothing is fetched, nothing
# is complained of, letters can be read, and they print.
# SC_BROWSER: a Chromium; otherwise chromium, chromium-browser or google-chrome is looked for.
browser=
for name in "${SC_BROWSER:-}" chromium chromium-browser google-chrome; do
    [ -z "$browser" ] && [ -n "$name" ] && command -v "$name" >/dev/null && browser=$name
done
[ -n "$browser" ] || skip "no browser is installed: chromium, chromium-browser, google-chrome, or SC_BROWSER"
command -v jq >/dev/null || skip "jq is not installed"

small_job job.yaml
sed -i 's/video: none/fps: 4/' job.yaml
"$SEGCAST" render job.yaml -o out -q --threads 2 --set "output.title=A film with aratherlongwordinitthatcannotbebrokenanywhere" >/dev/null
"$SEGCAST" render job.yaml -o another/directory/with/a/rather/long/name -q --set output.video=none --set output.frames=png >/dev/null
"$SEGCAST" report out another/directory/with/a/rather/long/name -o compared.html >/dev/null
cat >study.yaml <<YAML
title: "A study with aratherlongwordinitthatcannotbebrokenanywhere"
set: {volume: "phantom:32x24x32", output: {size: 64x64}, animation: {frames: 4}}
sweep: {render.skip: [none, octree, leap], output.size: [32x32, 64x64], ranks: [1, 64]}
least: 6
most: 6
budget: 20 min
YAML
"$SEGCAST" study study.yaml -o scaling -q >/dev/null
sed -i 's/, ranks: .*}/}/' study.yaml
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
  const root = document.documentElement;
  const out = [...document.querySelectorAll("body *")].filter((e) => {
    const box = e.getBoundingClientRect();
    return box.width > 0 && (box.right > innerWidth + 1 || box.left < -1);
  }).map((e) => e.tagName + ":" + e.textContent.slice(0, 30));
  parent.postMessage(JSON.stringify({
    width: innerWidth, scroll: root.scrollWidth, out,
    dark: matchMedia("(prefers-color-scheme: dark)").matches, page: light(rgb("--page")),
    contrasts: ["--ink", "--soft", "--link"].flatMap((k) => [contrast(k, "--page"), contrast(k, "--card")]),
    fetched: performance.getEntriesByType("resource").map((e) => e.name),
    focusable: document.querySelectorAll("a[href], summary, video[controls]").length,
    plots: document.querySelectorAll("svg").length,
  }), "*");
});
JS
# frame WIDTH: the page with the script, as wide as told: the window of a browser is not narrower than some 500 pixels.
frame() {
    cat <<HTML
<!DOCTYPE html><html><body style="margin: 0">
<script>addEventListener("message", (e) => { document.documentElement.dataset.found = e.data; });</script>
<iframe src="measured.html" style="width: ${1}px; height: 900px; border: 0"></iframe></body></html>
HTML
}
open_page() { # open_page FILE OPTION...: run the browser on a file, with what it says in browser.txt
    local file=$1
    shift
    timeout 120 "$browser" --headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --user-data-dir="$PWD/profile" \
        --no-first-run --disable-background-networking --disable-component-update --disable-extensions \
        --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr --hide-scrollbars "$@" "file://$file" 2>browser.txt
}
echo '<!DOCTYPE html><p>here</p>' >empty.html
open_page "$PWD/empty.html" --dump-dom | grep -q here || skip "the browser does not run here: $(tail -n 1 browser.txt)"
for page in methods/report.html scaling/report.html studies.html out/report.html compared.html; do
    folder=$PWD/$(dirname "$page")
    { sed 's|</body>.*||' "$page" | sed '/<\/html>/d'; echo "<script>$(cat measure.js)</script></body></html>"; } |
        sed '1s/.*/<!DOCTYPE html>/' >"$folder/measured.html"
    for width in 1440 390; do
        frame $width >"$folder/frame.html"
        for scheme in 0 1; do # dark, light
            what="$page at $width pixels, $([ $scheme = 0 ] && echo dark || echo light)"
            open_page "$folder/frame.html" --blink-settings=preferredColorScheme=$scheme --window-size=1440,900 --dump-dom >dom.html ||
                { cat browser.txt >&2; fail "$what: the browser fails"; }
            sed -n 's/.*data-found="\([^"]*\)".*/\1/p' dom.html | sed 's/&quot;/"/g; s/&lt;/</g; s/&gt;/>/g; s/&amp;/\&/g' >found.json
            [ -s found.json ] || fail "$what: could not be measured"
            jq -e --argjson width $width --argjson dark "$([ $scheme = 0 ] && echo true || echo false)" '
                .width == $width and .scroll <= .width and .out == [] and .dark == $dark and
                (if $dark then .page < 0.05 else .page > 0.8 end) and ([.contrasts[] >= 4.5] | all) and
                ([.fetched[] | startswith("file:")] | all) and .plots > 4' found.json >/dev/null || fail "$what: $(cat found.json)"
            ! grep -q CONSOLE browser.txt || fail "$what: $(grep CONSOLE browser.txt)"
        done
    done
    rm "$folder/measured.html" "$folder/frame.html"
    open_page "$PWD/$page" --no-pdf-header-footer --print-to-pdf="$PWD/page.pdf" >/dev/null || fail "$page does not print"
    [ "$(head -c 5 page.pdf)" = %PDF- ] || fail "$page: what was printed is no PDF"
done
[ "$(jq .focusable found.json)" = 0 ] || fail "a comparison has links to nowhere"
