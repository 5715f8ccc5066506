# SPDX-License-Identifier: BSD-3-Clause
# Several ranks draw the one picture of the desk: pictures are those of segcast still, byte for byte; idle ranks sleep; a
# picture is given up by all; whatever ends one rank ends all.
command -v python3 >/dev/null || skip "python3 is not installed"
for ranks in 2 3; do
    mkdir $ranks
    (cd $ranks && python3 "$SOURCE/tests/desk/ranks.py" "$SEGCAST" $ranks 2>said.txt) || { cat $ranks/said.txt >&2; fail "$ranks ranks"; }
done
