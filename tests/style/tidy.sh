# SPDX-License-Identifier: BSD-3-Clause
# clang-tidy 14 finds nothing: static analysis, frequent mistakes, sizes of functions (.clang-tidy).
#
# TIDY_NODES  how many states of a function the static analysis looks at (default: 4000, which takes a twentieth of the
#             time of 225000, clang-tidy's own default)
command -v clang-tidy-14 >/dev/null || skip "clang-tidy-14 is not installed"
[ -e "$BUILD/compile_commands.json" ] || skip "there is no compile_commands.json in $BUILD"
case $BUILD in */release) ;; *) skip "clang-tidy checks the release build only" ;; esac
find "$SOURCE/src" \( -name '*.c' -o -name '*.cpp' \) ! -name '*_tmpl.c' -print0 |
    xargs -0 -n 4 -P "$(nproc)" clang-tidy-14 -p "$BUILD" --quiet --warnings-as-errors='*' --extra-arg=-Xclang \
        --extra-arg=-analyzer-config --extra-arg=-Xclang --extra-arg=max-nodes="${TIDY_NODES:-4000}" >tidy.txt 2>/dev/null || {
    grep -E 'error|warning' tidy.txt | head -40
    fail "clang-tidy found the problems above"
}
