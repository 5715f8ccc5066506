# clang-tidy 14: analyzer, bugprone, size of functions; see .clang-tidy.
command -v clang-tidy-14 >/dev/null || skip "no clang-tidy-14"
[ -e "$BUILD/compile_commands.json" ] || skip "no compile_commands.json"
case $BUILD in */release) ;; *) skip "done in the release build" ;; esac
find "$SOURCE/src" -name '*.c' ! -name '*_tmpl.c' -print0 |
    xargs -0 -n 4 -P "$(nproc)" clang-tidy-14 -p "$BUILD" --quiet --warnings-as-errors='*' >tidy.txt 2>/dev/null || {
    grep -E 'error|warning' tidy.txt | head -40
    fail "clang-tidy"
}
