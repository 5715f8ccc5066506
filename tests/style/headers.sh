# SPDX-License-Identifier: BSD-3-Clause
# Every public header compiles by itself, may be included twice, and begins with the licence and
# with an @file comment that says what the module is for.
for header in "$SOURCE"/include/segcast/*.h; do
    name=segcast/$(basename "$header")
    printf '#include "%s"\n#include "%s"\n' "$name" "$name" >alone.c
    cc -std=gnu17 -D_XOPEN_SOURCE=700 -Wall -Wextra -Werror -I"$SOURCE/include" -fsyntax-only alone.c ||
        fail "$name does not compile by itself, included twice"
    [ "$(sed -n 1p "$header")" = '/* SPDX-License-Identifier: BSD-3-Clause */' ] ||
        fail "$name: line 1 is not the licence: /* SPDX-License-Identifier: BSD-3-Clause */"
    sed -n 2p "$header" | grep -q '^/\*\* @file' || fail "$name: line 2 does not begin with /** @file"
done
