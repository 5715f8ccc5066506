# What the README shows is true: its job runs, its commands exist, its links lead somewhere, and
# every key of a job is described.
readme=$SOURCE/README.md
awk '/^```yaml/ {on = 1; next} /^```/ {on = 0} on' "$readme" >heart.yaml
grep -q '^volume: phantom' heart.yaml || fail "no job in the README"
sed -i 's/^volume: phantom.*/volume: phantom:59x41x61/' heart.yaml
"$SEGCAST" check heart.yaml >/dev/null || fail "the job of the README does not pass"
"$SEGCAST" plan heart.yaml >/dev/null
"$SEGCAST" still heart.yaml --frame 90 -o look.png -q >/dev/null
"$SEGCAST" render heart.yaml --set animation.frames=3 -q >/dev/null
[ -e heart-out/heart.mp4 ] || fail "no video"
for command in $(grep -oE 'segcast (check|plan|still|render|orbit|info|phantom|views|prepare|join|study|report|verify)\b' "$readme" | cut -d' ' -f2 | sort -u); do
    "$SEGCAST" "$command" --help >/dev/null || fail "segcast $command"
done
grep -oE '\]\(([^)]+)\)' "$readme" | tr -d '()]' | while read -r link; do
    [ -e "$SOURCE/$link" ] || fail "link to $link"
done
"$SEGCAST" render heart.yaml --frames 0 -q -o keys >/dev/null
sed -nE 's/^ *"?([a-z_]+)"?:.*/\1/p' keys/job.yaml | sort -u | while read -r key; do
    grep -qE "\`?\.?\b$key\b" "$readme" || fail "key $key is not described"
done
