# SPDX-License-Identifier: BSD-3-Clause
# Doxygen builds the reference of the public headers without a warning.
command -v doxygen >/dev/null || skip "doxygen is not installed"
output=$PWD
cd "$SOURCE"
{ cat docs/Doxyfile && echo "OUTPUT_DIRECTORY = $output"; } | doxygen - >"$output/warnings.txt" 2>&1 || {
    cat "$output/warnings.txt" >&2
    fail "doxygen warns of the public headers (above)"
}
[ -e "$output/doxygen/index.html" ] || fail "doxygen wrote no index.html"
for header in include/segcast/*.h; do
    grep -q '@file' "$header" || fail "$header: has no @file comment, so doxygen leaves its functions out"
done
