# SPDX-License-Identifier: BSD-3-Clause
# The table of modules in docs/architecture.md agrees with the build files: its rows stand in the
# order of src/CMakeLists.txt, and name the libraries that each module links.
cd "$SOURCE"
page=docs/architecture.md
for module in $(tr '\n' ' ' <src/CMakeLists.txt | sed -n 's/.*foreach(module \([^)]*\)).*/\1/p'); do
    [ ! -d "src/$module" ] || echo "$module"
done >"$OLDPWD/modules.txt"
[ "$(wc -l <"$OLDPWD/modules.txt")" -gt 10 ] || fail "src/CMakeLists.txt: no line foreach(module ...) was found"

# name_library TARGET: the name under which the table lists what CMake links as TARGET.
name_library() {
    case $1 in
    OpenMP::OpenMP_C) echo OpenMP ;;
    MPI::MPI_C) echo MPI ;;
    PNG::PNG) echo libpng ;;
    JPEG::JPEG) echo libjpeg ;;
    PkgConfig::MICROHTTPD) echo libmicrohttpd ;;
    PkgConfig::XXHASH) echo xxHash ;;
    Teem::teem) echo Teem ;;
    Nifti::nifti2) echo nifticlib ;;
    Expat::expat) echo Expat ;;
    Tiff::tiff) echo libtiff ;;
    Dcmtk::dcmdata) echo DCMTK ;;
    Hdf::hdf5) echo libhdf5 ;;
    Blosc::blosc) echo c-blosc ;;
    Zstd::zstd) echo zstd ;;
    Lz::lz4) echo lz4 ;;
    Meshoptimizer::meshoptimizer) echo meshoptimizer ;;
    ZLIB::ZLIB) echo zlib ;;
    PkgConfig::LIBAV) echo libav ;;
    PkgConfig::LIBAVFILTER) echo libavfilter ;;
    PkgConfig::YAML) echo libyaml ;;
    PkgConfig::JANSSON) echo jansson ;;
    PkgConfig::CAIRO) echo cairo ;;
    PkgConfig::FONTCONFIG) echo fontconfig ;;
    Threads::Threads) echo POSIX threads ;;
    *) echo "$1 (name it in tests/style/architecture.sh)" ;;
    esac
}
# docs/install.md names the oldest versions that CMake asks for.
{
    grep -oE '[A-Za-z0-9.-]+>=[0-9.]+' cmake/SegcastLibraries.cmake | tr -s '>=' ' '
    sed -nE 's/^ *find_package\((PNG|ZLIB|MPI|EXPAT) ([0-9.]+).*/\1 \2/p' cmake/SegcastLibraries.cmake | sed 's/PNG/libpng/; s/ZLIB/zlib/; s/EXPAT/Expat/'
} >"$OLDPWD/versions.txt"
[ "$(wc -l <"$OLDPWD/versions.txt")" -gt 15 ] || fail "no versions were found in cmake/SegcastLibraries.cmake"
while read -r library; do
    grep -q "^|.*\b$library\b" docs/install.md || fail "docs/install.md: the table of libraries lacks \"$library\""
done <"$OLDPWD/versions.txt"

while read -r module; do
    libraries=$({ grep -oE '[A-Za-z]+::[A-Za-z0-9_]+' "src/$module/CMakeLists.txt" || true; } | sort -u |
        while read -r target; do name_library "$target"; done | sort | paste -sd,)
    echo "$module: $libraries"
done <"$OLDPWD/modules.txt" >"$OLDPWD/linked.txt"

awk -F' *\\| *' '/^\| module \|/ {on = 1; next} on && !/^\|/ {exit} on && /`/ {gsub(/`/, ""); print $2 "\t" $4}' "$page" |
    while IFS=$'\t' read -r module libraries; do
        echo "$module: $(tr ',' '\n' <<<"$libraries" | sed 's/^ *//; s/ *$//' | sort | paste -sd,)"
    done >"$OLDPWD/documented.txt"
diff -u --label "$page" --label "src/CMakeLists.txt and src/*/CMakeLists.txt" "$OLDPWD/documented.txt" "$OLDPWD/linked.txt" >&2 ||
    fail "$page: the table of modules differs from the build files (above, as module: libraries)"
