# clang-format 14 leaves the sources as they are; tools/format mends them.
command -v clang-format-14 >/dev/null || skip "no clang-format-14"
cd "$SOURCE"
git ls-files '*.c' '*.h' >"$OLDPWD/files.txt" 2>/dev/null || skip "not a git checkout"
xargs clang-format-14 --dry-run -Werror <"$OLDPWD/files.txt" || fail "run tools/format"
