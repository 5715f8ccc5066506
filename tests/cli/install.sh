# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` leaves: program, manual pages, completions, jobs with their schema, documents.
cmake --install "$BUILD" --prefix "$PWD/to" >install.log 2>&1 || { cat install.log >&2; fail "install"; }
for file in bin/segcast share/man/man1/segcast.1 share/man/man5/segcast-job.5 \
    share/bash-completion/completions/segcast share/zsh/site-functions/_segcast \
    share/fish/vendor_completions.d/segcast.fish share/segcast/jobs/job.schema.json \
    share/segcast/jobs/heart-orbit.yaml share/segcast/jobs/slurm/requeue.sbatch \
    share/segcast/jobs/pbs/many-nodes.pbs share/doc/segcast/LICENSE share/doc/segcast/README.md \
    share/doc/segcast/docs/job.md; do
    [ -s "to/$file" ] || fail "$file is not installed: $(find to -type f | sort | tr '\n' ' ')"
done
to/bin/segcast --version | grep -q '^segcast 1' || fail "the installed program does not run"

# The program that reads HDF5, where segcast has it, is found from the place of segcast.
if to/bin/segcast --version | grep -q '^volumes .*HDF5'; then
    [ -x to/libexec/segcast/segcast-hdf5 ] || fail "segcast-hdf5 is not installed: $(find to -name 'segcast-*')"
    expect 65 'hdf5-crash-1.h5: ' to/bin/segcast info "$SOURCE/tests/data/hdf5-crash-1.h5"
    mv to moved
    expect 65 'hdf5-crash-1.h5: ' moved/bin/segcast info "$SOURCE/tests/data/hdf5-crash-1.h5"
    mv moved/libexec moved/other
    expect 71 'the program that reads HDF5, .*libexec/segcast/segcast-hdf5, cannot be started' moved/bin/segcast info "$SOURCE/tests/data/hdf5-crash-1.h5"
    mv moved to
    mv to/other to/libexec
fi

# So is what loads libav, with the first video; nothing else needs it.
printf 'volume: phantom:40x28x41\noutput: {size: [64, 48], video: a.mp4}\nanimation: {frames: 2}\n' >job.yaml
mv to moved
LD_DEBUG=files LD_DEBUG_OUTPUT=$PWD/video expect 0 '' moved/bin/segcast render job.yaml -o installed
[ -s installed/a.mp4 ] || fail "the installed program wrote no video"
! grep -qs 'libavfilter' video.* || fail "a video loads libavfilter, which only GIF needs and which takes 50 ms"
LD_DEBUG=files LD_DEBUG_OUTPUT=$PWD/loaded moved/bin/segcast still phantom:40x28x41 -o b.png -q >/dev/null
if [ -n "$(find . -maxdepth 1 -name 'loaded.*')" ]; then # the loader is that of glibc
    ! grep -q 'segcast-libav' loaded.* || fail "a picture loads libav"
fi
mv moved/libexec moved/other
expect 73 'a.mp4: segcast-libav.so, by which segcast writes and reads videos, cannot be loaded: ' \
    moved/bin/segcast render job.yaml -o missing
[ ! -e missing ] || fail "a directory was made for nothing: $(find missing)"
moved/bin/segcast --version | grep -q '^libav *cannot be loaded' || fail "version without libav"
expect 0 '' moved/bin/segcast still phantom:40x28x41 -o a.png
[ -s a.png ] || fail "no picture without libav"
if command -v ldd >/dev/null && ldd moved/bin/segcast | grep -q libavcodec; then
    fail "segcast is linked with libav, which takes most of the time of a start"
fi
mv moved to
mv to/other to/libexec

# The manual pages: every command, option and key is in them, and groff finds nothing wrong.
for command in render check convert; do grep -q "^.SS segcast $command" to/share/man/man1/segcast.1 || fail "$command"; done
grep -q 'output.size' to/share/man/man5/segcast-job.5 || fail "no keys in segcast-job(5)"
if command -v groff >/dev/null; then
    for page in to/share/man/man?/*; do
        groff -man -Tutf8 -ww -z "$page" 2>warnings.txt
        [ ! -s warnings.txt ] || fail "$page: $(cat warnings.txt)"
    done
fi

# The bill of materials is that of this build, as SPDX demands it; versions stand in one place, and in the citation.
to/bin/segcast --version --json >version.json || fail "--version --json"
jq -e '.schema == "segcast-version-1" and .options.hdf5 == (.volumes | contains("HDF5")) and .options.mpi == (.libraries | has("mpi"))
    and .libraries.zlib != "" and (.libraries.teem | test("^1[.][0-9]+[.][0-9]+$"))
    and (.libraries.hdf5 // "1." | startswith("1.")) and .compiler != "" and (.commit | length > 0)' version.json >/dev/null || fail "$(cat version.json)"
jq -e --slurpfile version version.json '.spdxVersion == "SPDX-2.3" and .dataLicense == "CC0-1.0" and .SPDXID == "SPDXRef-DOCUMENT"
    and (.name | length > 0) and (.documentNamespace | test("^[a-z]+:[^#]+$")) and (.creationInfo.creators | length > 0)
    and (.creationInfo.created | test("^[0-9-]{10}T[0-9:]{8}Z$")) and ([.packages[].SPDXID] | length == (unique | length))
    and all(.packages[]; (.SPDXID | test("^SPDXRef-[A-Za-z0-9.-]+$")) and .name and .downloadLocation and (.filesAnalyzed == false))
    and ([.relationships[].relatedSpdxElement] | sort) == ([.packages[].SPDXID] | sort)
    and ([.packages[] | select(.name != "segcast") | {(.name): (.versionInfo // "")}] | add) == $version[0].libraries
    and .packages[0].versionInfo == $version[0].version' to/share/doc/segcast/segcast.spdx.json >/dev/null ||
    fail "the bill of materials is not right: $(cat to/share/doc/segcast/segcast.spdx.json)"
grep -qx "version: $(jq -r .version version.json)" "$SOURCE/CITATION.cff" || fail "CITATION.cff names another version"
grep -q "^## \[$(jq -r .version version.json)\]" "$SOURCE/CHANGELOG.md" || fail "CHANGELOG.md does not name the version"

# Completions.
bash -n to/share/bash-completion/completions/segcast || fail "bash completion"
complete_words() { # complete_words WORD...: what bash offers for the last word
    bash -c '. to/share/bash-completion/completions/segcast
        COMP_WORDS=(segcast "$@") COMP_CWORD=$#; compopt() { :; }; _segcast; echo "${COMPREPLY[*]}"' - "$@"
}
[ "$(complete_words ren)" = render ] || fail "completion of a command: $(complete_words ren)"
[ "$(complete_words render --over)" = --overwrite ] || fail "completion of an option"
[ "$(complete_words render --set render.qual)" = render.quality= ] || fail "completion of a key"
[ "$(complete_words help ke)" = keys ] || fail "completion of a topic of help"
if command -v zsh >/dev/null; then zsh -n to/share/zsh/site-functions/_segcast || fail "zsh completion"; fi
if command -v fish >/dev/null; then fish -n to/share/fish/vendor_completions.d/segcast.fish || fail "fish completion"; fi

# Sources from an archive know no commit, also if they lie in a repository of something else, or GIT_DIR
# names one: it would be the commit of that.
mkdir -p foreign/segcast
(
    cd foreign
    git init -q .
    git -c user.name=test -c user.email=test@example.org commit -q --allow-empty -m other
) || fail "git"
cp -r "$SOURCE"/CMakeLists.txt "$SOURCE"/cmake "$SOURCE"/src "$SOURCE"/include foreign/segcast/
GIT_DIR=$PWD/foreign/.git cmake -S foreign/segcast -B foreign/build -DBUILD_TESTING=OFF >configure.log 2>&1 ||
    { cat configure.log >&2; fail "sources from an archive cannot be configured"; }
grep -q 'SC_COMMIT "unknown"' foreign/build/src/cli/version.h ||
    fail "the commit of another repository: $(cat foreign/build/src/cli/version.h)"
if [ -e "$SOURCE/.git" ]; then
    to/bin/segcast --version | grep -qE '^commit +[0-9a-f]{12}$' || fail "no commit: $(to/bin/segcast --version)"
fi

# No program, built or installed, has the loader look for libraries in the current folder, as an empty or a relative
# element of a search path would: there may lie a libexpat.so.1 among downloaded data. What is read-only stays so.
for program in "$SEGCAST" "$BUILD"/segcast-* to/bin/segcast to/libexec/segcast/*; do
    [ -f "$program" ] || continue
    readelf -d "$program" >dynamic.txt || fail "$program is no program"
    paths=$(sed -nE 's/.*\((RPATH|RUNPATH)\).*\[(.*)\]$/\2/p' dynamic.txt)
    [ -z "$paths" ] || [[ ":$paths:" =~ ^(:(/|\$ORIGIN)[^:]*)+:$ ]] || fail "$program: libraries are looked for in \"$paths\""
    grep -q BIND_NOW dynamic.txt || grep -q 'FLAGS_1.* NOW' dynamic.txt || fail "$program is not linked with -z now"
done
