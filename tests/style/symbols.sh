# SPDX-License-Identifier: BSD-3-Clause
# Every symbol that a library of segcast exports begins with sc_, so that it cannot clash with a
# program's own; and no library holds mutable global data, except what signal handlers set and read, which
# libraries the process has loaded, and what was registered with them until it ends.
command -v nm >/dev/null || skip "nm is not installed"
for library in "$BUILD"/src/*/libsc_*.a; do
    [ -e "$library" ] || fail "there is no library in $BUILD/src"
    nm --defined-only -g "$library" 2>/dev/null | awk 'NF == 3 && $3 !~ /^sc_/ && $3 !~ /^(__|_Z[NT]|DW[.])/ {print}' >found.txt
    [ ! -s found.txt ] || fail "$library exports symbols that do not begin with sc_: $(cat found.txt)"
    case $library in *asan*) continue ;; esac # the sanitizer adds data of its own
    objdump -t "$library" 2>/dev/null |
        awk '{for (i = 2; i < NF; i++)
                  if (($i == ".data" || $i == ".bss" || $i == "*COM*") && $NF !~ /^(\.|stop_requested|stops_in_order|tells_of_stop|lost_memory_told|may_keep|answers|watched|gives_up|alarms|expendable|runs|is_terminal|unfinished|ending|sc_av|sc_filters|loading|_ZStL8__ioinit|_Z.*rle_decoder$)/) print}' >found.txt
    [ ! -s found.txt ] || fail "$library holds mutable global data: $(cat found.txt)"
done
