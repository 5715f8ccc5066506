# SPDX-License-Identifier: BSD-3-Clause
# Every C source is formatted as clang-format 14 does it (.clang-format); tools/format does it.
command -v clang-format-14 >/dev/null || skip "clang-format-14 is not installed"
cd "$SOURCE"
git ls-files '*.c' '*.h' '*.cpp' >"$OLDPWD/files.txt" 2>/dev/null || skip "this is not a git checkout"
xargs clang-format-14 --dry-run -Werror <"$OLDPWD/files.txt" || fail "sources are not formatted; run tools/format"
