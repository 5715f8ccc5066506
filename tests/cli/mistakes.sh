# SPDX-License-Identifier: BSD-3-Clause
# Every mistake of mistakes.tsv ends with its exit code and its messages, and with no others.
export HOME=/home/someone
# Root may read and write every file, unless it gives up that right; where it cannot, cases with a file that cannot be
# read are left out.
unprivileged=()
[ "$(id -u)" != 0 ] || unprivileged=(setpriv --bounding-set=-dac_override,-dac_read_search)
"${unprivileged[@]}" true 2>/dev/null || unprivileged=()
segcast() { "${unprivileged[@]}" "$SEGCAST" "$@"; }
"$SEGCAST" convert phantom:30x21x31 -o heart.nrrd -q >/dev/null
cp heart.nrrd unnamed-volume
cp heart.nrrd ./-dash.nrrd
LC_ALL=C sed '/^Segment[0-9]*_\(ID\|Name\):=/d' heart.nrrd >nameless.nrrd
"$SEGCAST" info heart.nrrd --json |
    jq -r '.labels[] | "\(.value) \(.name | gsub(" "; "_")) 200 \(.value) 90 255"' >heart.ctbl
printf '1 Left_Atrium 200 1 1 255\n2 left-atrium 1 200 1 255\n' >twins.ctbl
printf '<LabelTable>' >broken.xml
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 4 4 160\n'
    printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n'
    for label in $(seq 40); do
        head -c 64 /dev/zero | tr '\000' "\\$(printf %03o "$label")"
    done
} >many.nrrd
: >there.mp4
printf 'To do: scan the second heart\n' >notes.txt
printf '<MRML version="Slicer5.6">\n</MRML>\n' >scene.mrml
head -c 900 /dev/zero >voxels.img
printf 'NRRD0004\ntype: uint64\ndimension: 3\nsizes: 2 2 1\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nendian: little\nencoding: raw\n\n' >large.nrrd
printf '\5\0\0\0\0\0\0\200%.0s' 1 2 3 4 >>large.nrrd
printf 'solid bone\n' >bone.stl
printf 'ply\nformat ascii 1.0\n' >mesh
printf '%-124s\0\1IM' 'MATLAB 5.0 MAT-file, Platform: GLNXA64' >labels.mat
printf 'WKW\1\0\0\0\0' >x0.wkw
{ head -c 208 /dev/zero; printf 'MAP '; } >map.mrc
printf '# AmiraMesh BINARY-LITTLE-ENDIAN 2.1\ndefine VERTEX 9\n@1\n' >graph.am
printf '\377\330\377\340' >slice.jpg
printf '<!DOCTYPE html>\n' >page.nrrd
head -c 150 heart.nrrd >cut.nrrd
gzip <heart.nrrd | head -c 12 >cut.nii.gz
mkdir n5 wkw crackle empty one
cp notes.txt one
printf '{"n5": "2.5.1"}' >n5/attributes.json
printf '{}' >wkw/datasource-properties.json
printf '{"@type": "neuroglancer_multiscale_volume", "type": "segmentation", "data_type": "uint64", "num_channels": 1, "scales": [{"key": "1",
    "size": [4, 4, 4], "resolution": [8, 8, 8], "chunk_sizes": [[4, 4, 4]], "encoding": "crackle"}]}' >crackle/info
ascii() { # ascii TYPE SIZES: the head of a NRRD whose voxels are numbers in text
    printf 'NRRD0004\ntype: %s\ndimension: 3\nspace: RAS\nsizes: %s\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: ascii\n\n' "$@"
}
{ ascii int16 '20 20 20'; awk 'BEGIN {x = 1; for (i = 0; i < 8000; i++) {x = (x * 1103 + 12345) % 65536; print x % 2004 - 1000}}'; } >ct.nrrd
{ ascii uint32 '100 100 7'; seq 70000; } >cells.nrrd
mkdir sub
mkfifo pipe
cp heart.nrrd locked.nrrd
mkdir locked
chmod 000 locked.nrrd
chmod 555 locked

# check_case CODE COMMAND MESSAGES: run the command, which may have settings of the environment before it. A message that
# begins with "warning:" is one, with "^segcast: " neither a warning nor an error.
check_case() {
    local code=0 pattern rest=$3 errors=0 warnings=0 found
    (eval "$2") >stdout.txt 2>stderr.txt </dev/null || code=$?
    [ "$code" = "$1" ] || { cat stderr.txt >&2; fail "exit code $code, expected $1: $2 (job: $job)"; }
    while [ -n "$rest" ]; do
        pattern=${rest%% ;; *}
        rest=${rest#"$pattern"}
        rest=${rest# ;; }
        grep -qE -- "$pattern" stderr.txt || { cat stderr.txt >&2; fail "no line matches \"$pattern\": $2 (job: $job)"; }
        case $pattern in
        warning:*) warnings=$((warnings + 1)) ;;
        '^segcast: '*) ;;
        *) errors=$((errors + 1)) ;;
        esac
    done
    for found in error:$errors warning:$warnings; do
        [ "$(grep -c "^segcast: ${found%:*}:" stderr.txt)" = "${found#*:}" ] || {
            cat stderr.txt >&2
            fail "expected ${found#*:} messages of kind ${found%:*}: $2 (job: $job)"
        }
    done
}

count=0
while IFS=$'\t' read -r code command job messages; do
    case $code in '' | \#*) continue ;; esac
    count=$((count + 1))
    sampled || continue
    case $command$job in *locked*) [ -n "${unprivileged[*]}" ] || [ "$(id -u)" != 0 ] || continue ;; esac
    rm -rf job.yaml sub/job.yaml segcast-out
    case $job in
    -) ;;
    +*) printf 'volume: phantom:30x21x31\n%b' "${job#+}" | tee job.yaml >sub/job.yaml ;;
    *) printf '%b' "$job" | tee job.yaml >sub/job.yaml ;;
    esac
    check_case "$code" "$command" "$messages"
    [ ! -e segcast-out ] || [ "$code" = 0 ] || fail "a job with mistakes was begun: $command (job: $job)"
done <"$SOURCE/tests/cli/mistakes.tsv"
[ "$count" -gt 60 ] || fail "only $count cases were read from mistakes.tsv"
