# Every symbol our libraries export begins with sc_; nothing but the signal flag is mutable data.
command -v nm >/dev/null || skip "no nm"
for library in "$BUILD"/src/*/libsc_*.a; do
    nm --defined-only -g "$library" 2>/dev/null | awk 'NF == 3 && $3 !~ /^sc_/ && $3 !~ /^(__|_ZN)/ {print}' >found.txt
    [ ! -s found.txt ] || fail "$library exports $(cat found.txt)"
    case $library in *asan*) continue ;; esac # the sanitizer adds data of its own
    objdump -t "$library" 2>/dev/null |
        awk '{for (i = 2; i < NF; i++)
                  if (($i == ".data" || $i == ".bss" || $i == "*COM*") && $NF !~ /^(\.|stop_requested)/) print}' >found.txt
    [ ! -s found.txt ] || fail "$library holds mutable globals: $(cat found.txt)"
done
