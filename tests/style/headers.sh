# Every public header compiles alone, and twice.
for header in "$SOURCE"/include/segcast/*.h; do
    name=segcast/$(basename "$header")
    printf '#include "%s"\n#include "%s"\n' "$name" "$name" >alone.c
    cc -std=gnu17 -D_XOPEN_SOURCE=700 -Wall -Wextra -Werror -I"$SOURCE/include" -fsyntax-only alone.c || fail "$name"
    grep -q 'SPDX-License-Identifier: BSD-3-Clause' "$header" || fail "$name: licence"
done
