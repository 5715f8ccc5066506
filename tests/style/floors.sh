# SPDX-License-Identifier: BSD-3-Clause
# A module includes only headers of modules that stand above it in the list of src/CMakeLists.txt,
# and each foreign library, and each thing that is hard to test, is used in one place only.
cd "$SOURCE"
declare -A floor=() owner=()
modules=$(tr '\n' ' ' <src/CMakeLists.txt | sed -n 's/.*foreach(module \([^)]*\)).*/\1/p')
for module in $modules; do
    floor[$module]=${#floor[@]}
done
[ "${#floor[@]}" -gt 10 ] || fail "src/CMakeLists.txt: no list of modules was found: foreach(module ...)"

# A public header that is not named after a module (phantom.h) belongs to the first module of the list
# whose sources include it.
for header in include/segcast/*.h; do
    name=$(basename "$header" .h)
    owner[$name]=${floor[$name]:+$name}
    for module in $modules; do
        [ -z "${owner[$name]}" ] || break
        ! grep -rqs --include="*.[ch]" "include \"segcast/$name.h\"" "src/$module" || owner[$name]=$module
    done
    [ -n "${owner[$name]}" ] || fail "$header: no module bears its name, and none includes it"
done

check() { # check MODULE FILE: the headers that a file of this module includes
    local name used
    for name in $(sed -n 's/^ *# *include "segcast\/\([a-z0-9_]*\)\.h".*/\1/p' "$2"); do
        used=${owner[$name]:-}
        [ -n "$used" ] || fail "$2 includes segcast/$name.h, which does not exist"
        [ "${floor[$used]}" -le "${floor[$1]}" ] ||
            fail "$2 includes segcast/$name.h, but module $used comes after $1 in src/CMakeLists.txt"
    done
}
for file in src/*/*.[ch] src/*/*/*.[ch]; do
    module=${file#src/}
    module=${module%%/*}
    [ -n "${floor[$module]:-}" ] || fail "src/$module is not in the list of modules in src/CMakeLists.txt"
    check "$module" "$file"
done
for name in "${!owner[@]}"; do
    check "${owner[$name]}" "include/segcast/$name.h"
done

only() { # only PATTERN FILE_PATTERN: no other file holds a match of PATTERN
    local found
    found=$(grep -rlE "$1" src include tests/unit tests/property tests/support | grep -vE "$2" || true)
    [ -z "$found" ] || fail "\"$1\" is allowed only in files that match $2; it is in" "$found"
}
only '#include <mpi.h>' '^src/comm/comm_mpi.c$'
only '#include <omp.h>|# *pragma omp' '^src/base/parallel.c$'
only '#include <png.h>' '^src/image/png.c$'
only '#include <lib(av|sw)' '^src/video/|^tests/support/video_probe.c'
only '#include <jpeglib.h>' '^src/image/jpeg.c$'
only '#include <microhttpd.h>' '^src/desk/http.c$'
only '#include <teem/' '^src/volume/formats/(read_nrrd|nrrd_header)\.c$'
only '#include <nifti' '^src/volume/formats/read_nifti.c$'
only '#include <libavfilter' '^src/video/libav.h$'
only '#include <expat' '^src/volume/(tables/label_xml|formats/tiff_notes)\.c$'
only '#include <tiff' '^src/volume/formats/read_tiff.c$'
only '#include <hdf5' '^src/hdf5/program.h$'
only '#include <dcmtk' '^src/volume/dicom/dicom_file.cpp$'
only '#include <(blosc|lz4|zstd)' '^src/volume/chunked/zarr_codecs.c$'
only '#include <meshoptimizer.h>' '^src/mesh/simplify.c$'
only '#include <yaml.h>' '^src/job/yaml/yaml_words\.h$'
only '#include <cairo(-ft)?.h>' '^src/overlay/(overlay|lettering|font).c$|^src/overlay/font.h$'
only '#include <fontconfig' '^src/overlay/font.[ch]$'
only '#include <xxhash.h>' '^src/base/hash.c$'
only '#include <pthread.h>' '^src/base/parallel.c$|^src/farm/worker_thread.c$|^src/process/display.c$|^src/desk/(http|prepare|ranks).c$|^include/segcast/terminal.h$|^src/video/libav.c$|^tests/support/thread_comm.h$|^tests/unit/test_video.c$'
only '\bgetenv *\(' '^src/(cli|process|input|commands)/|^tests/'
only '\b(exit|abort|_exit) *\(' '^src/(commands|process)/|^tests/'
# No directory has more than 30 files, and no struct more than 20 members.
for directory in $(find src -type d); do
    files=$(find "$directory" -maxdepth 1 -type f | wc -l)
    [ "$files" -le 30 ] || fail "$directory has $files files; at most 30 are allowed: put some into a directory of their own"
done
find src include -name '*.[ch]' -o -name '*.cpp' | xargs awk '
    /^(typedef )?struct.*\{$/ {name = $0; body = ""; inside = 1; next}
    inside && /^\}/ {inside = 0; gsub(/\/\*([^*]|\*+[^*\/])*\*+\//, "", body)
            while (gsub(/\([^()]*\)/, "", body)); members = gsub(/[,;]/, "", body); structs++
            if (members > 20) {print FILENAME ": " name " " members " members"; most = 1}}
    inside {body = body $0 "\n"} END {exit most || structs < 500}' ||
    fail "a struct (above) has more than 20 members: put those of one subject into a struct of their own"
lines=$(wc -l <src/commands/main.c)
[ "$lines" -lt 100 ] || fail "src/commands/main.c has $lines lines; fewer than 100 are allowed"
grep -rnE 'TO''DO|FIX''ME|X''XX|#if ''0' src include && fail "the lines above mark unfinished work"
true
