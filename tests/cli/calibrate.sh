# SPDX-License-Identifier: BSD-3-Clause
# segcast plan --calibrate keeps what it has measured in the user's cache directory, and what is damaged, foreign or of
# another machine is told and not used.
export XDG_CACHE_HOME=$PWD/cache
unset HOME
"$SEGCAST" plan --calibrate -q >printed.txt
file=$(tail -1 printed.txt)
[[ $file = "$PWD"/cache/segcast/calibration-*.json ]] || fail "plan --calibrate prints $(cat printed.txt)"
[ "$(stat -c %a cache/segcast)" = 700 ] && [ "$(stat -c %a "$file")" = 600 ] || fail "others can read it: $(ls -la cache/segcast)"
[ "$(ls -A cache/segcast | wc -l)" = 1 ] || fail "left behind: $(ls -la cache/segcast)"
[ "$(grep -c '(assumed)$' printed.txt)" = 3 ] || fail "one rank has measured messages: $(cat printed.txt)"
"$SEGCAST" plan --calibrate -q --json >costs.json
jq -e '.schema == "segcast-calibration-1" and ([.copy_bytes_per_s, .file_bytes_per_s, .notice_s, .message_s, .latency_s,
    .link_bytes_per_s | . > 0] | all) and .messages_measured == false and .network_measured == false' costs.json >/dev/null ||
    fail "plan --calibrate --json: $(cat costs.json)"

# segcast plan reads it.
small_job job.yaml
"$SEGCAST" plan job.yaml -q --json >plan.json 2>stderr.txt
jq -e '.scaling.costs_measured' plan.json >/dev/null && [ ! -s stderr.txt ] || fail "plan does not use it: $(cat stderr.txt plan.json)"

# What is wrong with a file is told, by plan, which goes on with what it assumes, and by calibrate, which measures anew.
refused() { # refused REASON: so is the file
    expect 0 "warning: $file is not used: $1" "$SEGCAST" plan job.yaml -q --json
    jq -e '.scaling.costs_measured == false' stdout.txt >/dev/null || fail "$1: plan uses it"
    expect 0 "warning: $file is not used: $1" "$SEGCAST" plan --calibrate -q
    expect 0 '' "$SEGCAST" plan job.yaml -q --json
    jq -e '.scaling.costs_measured' stdout.txt >/dev/null && [ ! -s stderr.txt ] || fail "$1: it was not measured anew: $(cat stderr.txt)"
}
change() { jq "$1" "$file" >changed.json && cat changed.json >"$file"; }
head -c 100 "$file" >cut.json && cat cut.json >"$file" && refused 'it is damaged'
change '.version = "0.0.0"' && refused 'it is of another version'
change '.processor = "Z80"' && refused 'it is of another processor'
change '.message_s = 0' && refused 'a number is missing or impossible'
change 'del(.notice_s)' && refused 'a number is missing or impossible'
change '.copy_bytes_per_s += 1' && refused 'its hash does not fit'
change '.network_measured = true' && refused 'its hash does not fit'
# What segcast has not written is in the way: it is neither used nor followed nor replaced.
foreign() { # foreign REASON: so is what is there
    expect 0 "warning: $file is not used: $1; move it away" "$SEGCAST" plan job.yaml -q --json
    jq -e '.scaling.costs_measured == false' stdout.txt >/dev/null || fail "$1: plan uses it"
    expect 73 "$file: is in the way of what is measured, and not replaced: $1; move it away" "$SEGCAST" plan --calibrate -q
    one_error
}
mv "$file" elsewhere.json
ln -s "$PWD/elsewhere.json" "$file"
before=$(sha256sum elsewhere.json)
foreign 'it is no regular file'
[ -L "$file" ] && [ "$(sha256sum elsewhere.json)" = "$before" ] || fail "the link was followed or replaced"
rm "$file"
for text in 'my own notes' '[]' '' '{"schema": "somebody-else-1"}'; do
    echo "$text" >"$file"
    foreign 'it is no calibration of segcast'
    [ "$(cat "$file")" = "$text" ] || fail "a file with \"$text\" was replaced"
done
rm "$file" && mkdir "$file"
foreign 'it is no regular file'
rmdir "$file"

# Where there is no place for it.
expect 73 'neither XDG_CACHE_HOME nor HOME is an absolute path' env XDG_CACHE_HOME=relative "$SEGCAST" plan --calibrate
one_error
echo >file
expect 73 'file' env XDG_CACHE_HOME="$PWD/file" "$SEGCAST" plan --calibrate
one_error
expect 0 '' env XDG_CACHE_HOME=relative HOME="$PWD/home" "$SEGCAST" plan --calibrate
[ -n "$(ls home/.cache/segcast)" ] || fail "nothing is in the home directory"
expect 0 '' env XDG_CACHE_HOME="$PWD/none" "$SEGCAST" plan job.yaml -q
[ ! -e none ] || fail "segcast plan has written files"

# With two ranks messages are measured, and stay so when one rank measures again.
if mpi 2 "$SEGCAST" plan --calibrate -q --json >two.json 2>stderr.txt; then
    if jq -e '.messages_measured' two.json >/dev/null; then
        "$SEGCAST" plan --calibrate -q --json >again.json
        jq -e '.messages_measured and .message_s == $two[0].message_s' --slurpfile two two.json again.json >/dev/null ||
            fail "what two ranks had measured is lost: $(cat two.json again.json)"
    fi
elif ! grep -q 'without MPI' stderr.txt; then
    fail "two ranks: $(cat stderr.txt)"
fi
