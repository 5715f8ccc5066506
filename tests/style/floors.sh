# A module includes only from lower floors; each foreign library lives in one module.
# The order of src/CMakeLists.txt is the order of the floors; scene stands on prepare, because
# opacity follows measured thickness.
declare -A floor=([base]=0 [geom]=1 [image]=1 [comm]=1 [volume]=2 [video]=2 [store]=3 [prepare]=3 [scene]=4
    [timeline]=5 [kernel]=5 [render]=6 [overlay]=6 [views]=7
    [farm]=7 [study]=8 [job]=9 [app]=10)
# phantom.h is volume's second public header
check() { # check MODULE FILE...
    local module=$1 file used
    shift
    for file in "$@"; do
        while read -r used; do
            [ "$used" = phantom ] && used=volume
            [ "$used" = "$module" ] && continue
            [ -n "${floor[$used]:-}" ] || fail "$file includes unknown segcast/$used.h"
            [ "${floor[$used]}" -lt "${floor[$module]}" ] || fail "$file (floor of $module) includes segcast/$used.h"
        done < <(sed -n 's/^ *# *include "segcast\/\([a-z]*\).*/\1/p' "$file")
    done
}
cd "$SOURCE"
for directory in src/*/; do
    module=$(basename "$directory")
    [ -n "${floor[$module]:-}" ] || fail "src/$module has no floor"
    check "$module" "$directory"*.[ch]
done
for header in include/segcast/*.h; do
    module=$(basename "$header" .h)
    [ "$module" = phantom ] && module=volume
    check "$module" "$header"
done

only() { # only PATTERN FILE_PATTERN: the include or pragma stands nowhere else
    local found
    found=$(grep -rlE "$1" src include tests/unit tests/property tests/support | grep -vE "$2" || true)
    [ -z "$found" ] || fail "$1 stands in $found"
}
only '#include <mpi.h>' '^src/comm/comm_mpi.c$'
only '#include <omp.h>|# *pragma omp' '^src/base/parallel.c$'
only '#include <png.h>' '^src/image/png.c$'
only '#include <lib(av|sw)' '^src/video/'
only '#include <teem/' '^src/volume/read_nrrd.c$'
only '#include <nifti' '^src/volume/read_nifti.c$'
only '#include <yaml.h>' '^src/job/yaml_tree.c$'
only '#include <cairo.h>' '^src/overlay/overlay.c$'
only '#include <xxhash.h>' '^src/image/image.c$'
only '#include <pthread.h>' '^src/farm/lane.c$'
only '\bgetenv *\(' '^src/app/|^tests/'
only '\b(exit|abort|_exit) *\(' '^src/app/|^tests/'
[ "$(wc -l <src/app/main.c)" -lt 100 ] || fail "main.c has grown"
grep -rnE 'TO''DO|FIX''ME|X''XX|#if ''0' src include && fail "unfinished work is marked"
true
