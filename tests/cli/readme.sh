# SPDX-License-Identifier: BSD-3-Clause
# What README.md, CONTRIBUTING.md and docs/*.md say is true:
# - every block ```sh runs and ends with exit code 0, in one directory per document, with the job
#   files that the document shows. A comment <!-- not run: REASON --> on the line before a block
#   leaves it out, <!-- needs: PROGRAM... --> leaves it out where a program is missing;
# - every `segcast COMMAND --option` in text, tables and blocks that are left out exists;
# - docs/usage.md lists the commands that `segcast --help` lists;
# - links lead to files and headings that exist, and so do paths of the repository in `backquotes`
#   (words in capitals, such as read_FORMAT.c, stand for a name that the reader chooses).
documents=("$SOURCE/README.md" "$SOURCE/CONTRIBUTING.md" "$SOURCE/CHANGELOG.md" "$SOURCE"/docs/*.md)

# Small pictures of a small volume, set in the environment; in bin/segcast what a command sets itself.
export SEGCAST_VOLUME=phantom:59x41x61 SEGCAST_OUTPUT_SIZE='[96, 72]' SEGCAST_ANIMATION_FRAMES=96
export SEGCAST_OUTPUT_FPS=24
mkdir bin
cat >bin/segcast <<'SH'
#!/usr/bin/env bash
[ "${2-}" != phantom ] || set -- "$1" phantom:59x41x61 "${@:3}"
words=("$@")
for ((i = 1; i < $#; i++)); do
    [ "${words[i - 1]}" != --size ] || words[i]=192x108
done
exec "$SEGCAST" "${words[@]}"
SH
cat >bin/have <<'SH'
#!/usr/bin/env bash
# have PROGRAM: succeeds if the program is installed; for mpirun, if segcast is built with MPI, too.
[ "$1" != mpirun ] || ! "$SEGCAST" --version | grep -qx 'MPI  *none' || exit 1
command -v "$1" >/dev/null
SH
chmod +x bin/segcast bin/have
export PATH=$PWD/bin:$PATH

# split DOCUMENT DIR: the blocks of a document as DIR/NN.run, .left (out) or job files by their name.
split() {
    awk -v dir="$2" -v name="$(basename "$1")" '
        /^```/ && on {on = ""; close(file); mark = ""; next}
        on {print >file; if (on == "yaml" && !named) {
                named = 1
                if ($0 ~ /^# [a-z0-9-]+\.yaml/) {
                    close(file); old = file; file = $2; sub(/[^a-z]+$/, "", file); file = dir "/" file
                    print >file; system("rm -f " old) } }
            next}
        /^```sh/ {
            file = sprintf("%s/%02d.run", dir, ++count); on = "sh"
            if (mark ~ /^<!-- not run: ..../) file = sprintf("%s/%02d.left", dir, count)
            else if (mark ~ /^<!-- needs: /) {
                needs = mark; gsub(/^<!-- needs: | -->$/, "", needs)
                if (system("for program in " needs "; do have $program || exit 1; done"))
                    file = sprintf("%s/%02d.left", dir, count) }
            else if (mark != "") {print name ": unknown mark " mark >"/dev/stderr"; exit 1}
            printf "" >file; next}
        /^```yaml/ {on = "yaml"; named = 0; file = sprintf("%s/%02d.yaml.part", dir, ++count); next}
        /^```/ {on = "text"; file = "/dev/null"; next}
        /^<!-- (not run|needs):/ {mark = $0; next}
        {if ($0 != "") mark = ""}
        END {if (on) {print name ": a block is not closed" >"/dev/stderr"; exit 1}}' "$1"
}

[ "$(wc -l <"$SOURCE/README.md")" -le 120 ] || fail "README.md has more than 120 lines: it is for a first look"

# ---- blocks ----
ran=0
for document in "${documents[@]}"; do
    work=$PWD/$(basename "$document" .md)
    mkdir "$work"
    split "$document" "$work" || fail "$document: its blocks cannot be read"
    ln -s "$SOURCE/jobs" "$work/jobs"
    for block in "$work"/*.run; do
        [ -e "$block" ] || continue
        (cd "$work" && bash -euo pipefail "$block") >"$block.out" 2>&1 || {
            cat "$block.out" >&2
            fail "$(basename "$document"): this block ends with an error: $(cat "$block")"
        }
        ran=$((ran + 1))
    done
    for job in "$work"/*.yaml; do
        [ ! -e "$job" ] || "$SEGCAST" check "$job" >/dev/null || fail "$(basename "$document"): $(basename "$job") is refused"
    done
done
[ "$ran" -ge 4 ] || fail "only $ran blocks were run"
[ -e README/heart-out/heart.mp4 ] || fail "the job of the README made no video"

# ---- commands and options, wherever they are named ----
"$SEGCAST" --help | sed -nE 's/^([a-z]+)? {2,}([a-z]+) +[][A-Z].*/\2/p' | sort -u >commands.txt
[ "$(wc -l <commands.txt)" -ge 10 ] || fail "segcast --help lists only $(wc -l <commands.txt) commands"
while read -r command; do
    "$SEGCAST" "$command" --help >"help-$command.txt" || fail "segcast $command --help fails"
done <commands.txt
{ grep -ohE '`segcast [a-z][^`]*`' "${documents[@]}" | tr -d '`'
    cat ./*/*.left ./*/*.run 2>/dev/null; } | grep -oE 'segcast [a-z]+[^|&;#]*' >named.txt
while read -r _ command rest; do
    [ "$command" != help ] || continue
    [ -e "help-$command.txt" ] || fail "a document names segcast $command, which does not exist"
    for option in $(grep -oE -- '--[a-z][a-z-]*' <<<"$rest"); do
        [ "$option" = --help ] || grep -qE -- "$option\b" "help-$command.txt" ||
            fail "a document names segcast $command $option, which does not exist"
    done
done <named.txt
sed -nE '/<!-- commands -->/,/^$/s/^\| `segcast ([a-z]+).*/\1/p' "$SOURCE/docs/usage.md" | sort >listed.txt
diff commands.txt listed.txt >&2 || fail "docs/usage.md and segcast --help list different commands (above)"

# ---- links ----
# headings FILE: the anchors of its headings, as GitHub makes them.
headings() {
    awk '/^```/ {on = !on} !on && /^#+ / {sub(/^#+ /, ""); print tolower($0)}' "$1" |
        sed 's/[^a-z0-9 _-]//g; s/ /-/g'
}
for document in "${documents[@]}"; do
    { grep -oE '\]\([^) ]+\)' "$document" || true; } | sed 's/^](//; s/)$//' | while read -r link; do
        case $link in http://* | https://*) continue ;; esac
        path=${link%%#*} target=$document
        [ -z "$path" ] || target=$(dirname "$document")/$path
        [ -e "$target" ] || fail "$(basename "$document"): the link to $link leads nowhere"
        [ "$path" = "$link" ] || headings "$target" | grep -qxF -- "${link#*#}" ||
            fail "$(basename "$document"): the link to $link names a heading that does not exist"
    done
done
for document in "${documents[@]}"; do
    { grep -oE '`(cmake|docs|include|jobs|src|tests|tools)/[^` ]*`' "$document" || true; } | tr -d '`' | while read -r path; do
        [[ $path =~ [A-Z]{3} ]] || compgen -G "$SOURCE/$path" >/dev/null ||
            fail "$(basename "$document"): $path is named, but does not exist"
    done
done
