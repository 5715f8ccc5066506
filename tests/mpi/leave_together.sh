# SPDX-License-Identifier: BSD-3-Clause
# After any error all ranks end together, soon, with one message and the same exit code.
small_job good.yaml
refuse() { # refuse CODE PATTERN ARGUMENT...
    local want=$1 pattern=$2 code=0
    shift 2
    timeout 60 mpirun -n 3 "$SEGCAST" "$@" >stdout.txt 2>stderr.txt || code=$?
    [ "$code" = "$want" ] || { cat stderr.txt >&2; fail "exit $code, expected $want: $*"; }
    grep -qE -- "$pattern" stderr.txt || { cat stderr.txt >&2; fail "no line matches \"$pattern\": $*"; }
    [ "$(grep -c 'segcast: .*error' stderr.txt)" = 1 ] || { cat stderr.txt >&2; fail "expected one error: $*"; }
}
sed 's/^render:/rendr:/; s/tissues/tissuse/' good.yaml >bad.yaml
refuse 65 'did you mean "tissues"' render bad.yaml
refuse 66 'No such file' render nowhere.yaml
sed 's/^volume.*/volume: none.nrrd/' good.yaml >bad.yaml
refuse 66 'none.nrrd: No such file' render bad.yaml
printf 'NRRD0004\ntype: uchar\n' >cut.nrrd
sed 's/^volume.*/volume: cut.nrrd/' good.yaml >bad.yaml
refuse 65 'cut.nrrd: not a readable NRRD' render bad.yaml
sed 's/"\*"/nothing/' good.yaml >bad.yaml
refuse 65 'matches no label' render bad.yaml
refuse 64 'not within the animation' render good.yaml --frames 99
refuse 64 'unknown option' render good.yaml --nonsense
: >file
refuse 73 'file' render good.yaml -o file/out
# A folder that is not segcast's has the name of a frame's file. (Writing that fails during the run, on one rank of
# several, is the subject of tests/faults.)
mkdir -p full/frames/000003.png/taken
refuse 73 '000003.png: is a directory that was not made by segcast' render good.yaml -o full --set output.frames=png
[ "$(find full | wc -l)" = 4 ] || fail "something was written beside what is in the way: $(find full)"
timeout 60 mpirun -n 2 "$SEGCAST" check good.yaml >/dev/null 2>&1 || fail "check under mpirun"
