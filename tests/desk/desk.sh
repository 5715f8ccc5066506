# SPDX-License-Identifier: BSD-3-Clause
# The desk in a real browser: turn, zoom, cut by the handle, select in the list and in the picture, hide, undo, set keys,
# play, save; then the saved job gives the pictures that were seen, byte for byte.
# SC_BROWSER: a Chromium; otherwise chromium, chromium-browser or google-chrome is looked for. DESK_SHOTS: a directory for
# pictures of the page.
browser=
for name in "${SC_BROWSER:-}" chromium chromium-browser google-chrome; do
    [ -z "$browser" ] && [ -n "$name" ] && command -v "$name" >/dev/null && browser=$(command -v "$name")
done
[ -n "$browser" ] || skip "no browser is installed: chromium, chromium-browser, google-chrome, or SC_BROWSER"
command -v python3 >/dev/null || skip "python3 is not installed"
timeout 60 "$browser" --headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --user-data-dir="$PWD/first" --dump-dom about:blank \
    >first.txt 2>&1 || skip "the browser does not run here: $(tail -n 1 first.txt)"
grep -q '<html>' first.txt || skip "the browser shows nothing here: $(tail -n 1 first.txt)"

cat >job.yaml <<'YAML'
# My heart, which I have coloured by hand.
volume: phantom:64x48x64   # small

output: {directory: out, size: [320, 180], video: none, frames: png}  # for trying
tissues:
  "*": {opacity: 1}  # all of them
  # the fat hides the rest
  "epicardial fat": {visible: false}
animation:
  frames: 12
  camera: {orbit: {axis: superior, elevation: 10}}  # once around
YAML
cp job.yaml before.yaml
"$SEGCAST" desk job.yaml --threads 2 --idle 20 >address.txt 2>desk.txt &
wait_for_desk address.txt
python3 "$SOURCE/tests/desk/hands.py" "$browser" "$(cat address.txt)" "$PWD" >seen.txt || { cat desk.txt seen.txt >&2; fail "the page does not do what a hand asks"; }

# What was saved is a file that a person would have written.
diff before.yaml job.yaml >changes.txt || true
grep -q '# My heart, which I have coloured by hand.' job.yaml || fail "the first comment is gone: $(cat job.yaml)"
grep -q 'phantom:64x48x64   # small' job.yaml || fail "a line that was not changed is another one: $(cat job.yaml)"
grep -q '  # once around' job.yaml || fail "the comment behind a changed line is gone: $(cat job.yaml)"
[ "$(wc -l <job.yaml)" -ge "$(wc -l <before.yaml)" ] || fail "lines are gone: $(cat changes.txt)"
"$SEGCAST" check job.yaml -q >/dev/null 2>check.txt || { cat check.txt job.yaml >&2; fail "the saved job has mistakes"; }

# The pictures that were seen are those of the saved job.
while read -r picture frame size; do
    "$SEGCAST" still job.yaml --frame "$frame" --size "$size" -o still.png --overwrite -q >/dev/null
    cmp "$picture" still.png || fail "$picture is not frame $frame of the saved job at $size"
done <seen.txt
[ "$(wc -l <seen.txt)" -ge 2 ] || fail "the page has shown no pictures"

# What was rendered from the page is right.
"$SEGCAST" verify out -q >/dev/null || fail "what the page has rendered is not right"

# Ctrl-C ends it in order.
end_desk INT
