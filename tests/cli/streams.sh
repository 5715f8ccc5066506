# SPDX-License-Identifier: BSD-3-Clause
# Standard streams that are full, closed or cut off. What cannot be printed is an error, of every command.
"$SEGCAST" convert phantom:24x20x26 -o heart.nrrd -q >/dev/null
small_job job.yaml
sed -i 's/^volume.*/volume: heart.nrrd/' job.yaml
"$SEGCAST" render job.yaml -o done -q >/dev/null
printf 'set: {volume: heart.nrrd, output: {size: 32x32}, threads: 1}\nleast: 1\nmost: 1\n' >study.yaml
arguments() { # arguments COMMAND: what makes the command print something to standard output
    case $1 in
    render) echo job.yaml -o "new$RANDOM$RANDOM" ;;
    check | plan) echo job.yaml ;;
    still) echo job.yaml -o out.png --overwrite ;;
    orbit) echo heart.nrrd --size 64x48 --frames 2 -o out.mp4 --overwrite ;;
    info) echo heart.nrrd ;;
    convert) echo heart.nrrd -o out.segc --overwrite ;;
    join | verify | status | report) echo 'done' ;;
    study) echo study.yaml -o "study$RANDOM$RANDOM" ;;
    init) echo heart.nrrd -o - ;;
    help | -*) ;;
    *) fail "the command $1 is new: say here what makes it print" ;;
    esac
}
commands=$("$SEGCAST" --help | sed -nE 's/^([a-z]+)? {2,}([a-z]+) +[][A-Z].*/\2/p' | sort -u)
[ "$(wc -w <<<"$commands")" -gt 12 ] || fail "the list of commands: $commands"
[ -c /dev/full ] || skip "there is no /dev/full"
full() { "$@" >/dev/full; }
closed() { "$@" >&-; }
all_closed() { "$@" <&- >&- 2>&-; }
# A desk whose address nobody can read ends; else it would go on.
for command in $commands --help --version -h; do
    [ "$command" != desk ] || { expect 74 'standard output: cannot be written' full timeout 20 "$SEGCAST" desk job.yaml; continue; }
    arguments "$command" >arguments.txt # not $(...), in which a failure would end the subshell alone
    read -ra words <arguments.txt || true # of some commands there are none
    code=0
    "$SEGCAST" "$command" "${words[@]}" >printed.txt 2>said.txt || code=$?
    [ $code = 0 ] || fail "$command ${words[*]}: exit code $code: $(cat said.txt)"
    [ -s printed.txt ] || continue
    read -ra words <<<"$(arguments "$command")"
    expect 74 'standard output: cannot be written: No space left' full "$SEGCAST" "$command" "${words[@]}"; one_error
done
for words in 'help --man' 'help --bash' 'help --zsh' 'help --fish' 'help keys --json' 'help keys --man' 'help keys --markdown' \
    'help keys --schema' 'info heart.nrrd --json' 'render --help' 'help keys'; do
    # shellcheck disable=SC2086 # a list of words
    expect 74 'standard output: cannot be written' full "$SEGCAST" $words; one_error
done

# A reader that has seen enough ends the command without a word.
for words in 'help keys' 'help --bash' 'help keys --json'; do
    # shellcheck disable=SC2086 # a list of words
    { "$SEGCAST" $words 2>said.txt || true; } | head -1 >/dev/null
    [ ! -s said.txt ] || fail "$words into head: $(cat said.txt)"
done

# A run whose log nobody reads any more (`| tee` that was ended) goes on. Without -q it says something.
exec 8> >(exit 0)
wait $!
code=0
"$SEGCAST" render job.yaml -o unread >printed.txt 2>&8 || code=$?
[ $code = 0 ] || fail "a render whose log nobody reads: exit code $code"
expect 0 '' "$SEGCAST" verify unread
code=0
"$SEGCAST" render job.yaml -o unprinted 2>said.txt >&8 || code=$?
[ $code = 74 ] || fail "a render whose output nobody reads: exit code $code, expected 74: $(cat said.txt)"
expect 0 '' "$SEGCAST" verify unprinted
# Every other command ends as programs do, and leaves nothing unfinished.
"$SEGCAST" convert phantom:300x300x300 -o large.nrrd -q &
until compgen -G '.large.nrrd.tmp.*' >/dev/null; do
    kill -0 $! 2>/dev/null || fail "phantom ended before it could be interrupted"
    sleep 0.05
done
kill -PIPE $!
code=0
wait $! || code=$?
[ $code = 141 ] || fail "phantom without a reader: exit code $code, expected 141"
[ -z "$(compgen -G '.large.nrrd*')" ] || fail "left behind: $(compgen -G '.large.nrrd*')"
exec 8>&-

# With any of them closed, nothing that is meant for it gets into a file.
expect 0 '' closed "$SEGCAST" still job.yaml -o closed.png
"$SEGCAST" still job.yaml -q -o open.png >/dev/null
cmp open.png closed.png || fail "with standard output closed the picture differs"
no_input() { "$@" <&-; }
no_errors() { "$@" 2>&-; }
for way in closed no_input no_errors all_closed; do
    $way "$SEGCAST" render job.yaml -o "$way" --set output.frames=png --set output.video=f.mp4 >/dev/null ||
        fail "$way: exit code $?"
    expect 0 '' "$SEGCAST" verify "$way"
    for file in "$way"/manifest.jsonl "$way"/status.json "$way"/stats.json; do
        jq -e . "$file" >/dev/null || fail "$file is not JSON: $(cat "$file")"
        ! grep -q 'segcast:' "$file" || fail "the log is in $file: $(cat "$file")"
    done
done
