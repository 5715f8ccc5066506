# SPDX-License-Identifier: BSD-3-Clause
# Crash consistency: segcast is killed at each of its changes to the output directory (creating, writing,
# flushing, renaming, removing), or in the middle of a write; whatever the prefix of changes that is left,
# --resume ends with the bytes of an undisturbed run, and nothing else is left in the directory.
# SC_TEST_ALL=1 tries all changes (half an hour), otherwise every thirtieth or so.
cat >job.yaml <<'YAML'
volume: phantom:40x32x40
output: {directory: out, size: [32, 32], fps: 2, frames: png, video: v.mp4}
animation: {frames: 3}
YAML
"$SEGCAST" render job.yaml -o ref -q >/dev/null
code=0
"$CRASH_POINTS" 1000000 before "$PWD/whole" "$SEGCAST" render job.yaml -o whole -q --threads 1 >said.txt || code=$?
[ $code = 3 ] || skip "this system does not let a process trace another (ptrace)"
grep -q '^exit code 0 after [1-9][0-9]* changes' said.txt || fail "an undisturbed run: $(cat said.txt)"

files() { (cd "$1" && find . | sort); }
same_as_ref() { # same_as_ref WHAT: out holds what ref does
    [ "$(hashes out)" = "$(hashes ref)" ] || fail "$1: the hashes of the frames differ"
    cmp out/v.mp4 ref/v.mp4 || fail "$1: the video differs"
    diff -r out/frames ref/frames || fail "$1: the PNG files differ"
    "$SEGCAST" verify out >/dev/null || fail "$1: segcast verify found an error"
    "$SEGCAST" status out >/dev/null || fail "$1: segcast status says that the job is not complete"
    diff <(files out) <(files "${2:-ref}") || fail "$1: other files are left"
}
# crash NAME ORIGIN ARGUMENT...: kill `segcast ARGUMENT...` at each change to out, which is a copy of ORIGIN
# ('': it does not exist), then go on with --resume
crash() {
    local name=$1 origin=$2 how tried=0 n code
    shift 2
    for how in before torn; do
        n=1
        [ -n "${SC_TEST_ALL:-}" ] || n=$((RANDOM % 20 + 1))
        while :; do
            rm -rf out
            [ -z "$origin" ] || cp -a "$origin" out
            code=0
            "$CRASH_POINTS" $n $how "$PWD/out" "$SEGCAST" "$@" -q >said.txt 2>stderr.txt || code=$?
            [ $code = 3 ] && break
            [ $code = 0 ] || fail "$name $how $n: crash_points ended with $code"
            "$SEGCAST" status out >status.txt 2>&1 && code=0 || code=$?
            case $code in 0 | 66 | 75) ;; *) fail "$name $how $n: status says $code: $(cat status.txt)" ;; esac
            "$SEGCAST" render job.yaml -o out --resume -q >/dev/null 2>stderr.txt || {
                cat stderr.txt >&2
                fail "$name $how $n: --resume ended with $?: $(find out)"
            }
            same_as_ref "$name $how $n" "${expected:-ref}"
            tried=$((tried + 1))
            [ -n "${SC_TEST_ALL:-}" ] && n=$((n + 1)) || n=$((n + 16 + RANDOM % 30))
        done
    done
    echo "$name: $tried crashes; $(cat said.txt)"
}
crash 'a new run' '' render job.yaml -o out
"$SEGCAST" render job.yaml -o half --time-limit 0.001 -q >/dev/null || [ $? = 75 ]
"$CRASH_POINTS" 45 before "$PWD/half" "$SEGCAST" render job.yaml -o half --resume -q >/dev/null
crash 'a run that goes on' half render job.yaml -o out --resume
crash 'a run that begins anew' ref render job.yaml -o out --overwrite
# The second of two slices completes the job.
"$SEGCAST" render job.yaml -o slice --slice 0/2 -q >/dev/null
cp -a slice both
"$SEGCAST" render job.yaml -o both --slice 1/2 -q >/dev/null
same_slices() { [ "$(hashes out)" = "$(hashes ref)" ] && cmp out/v.mp4 ref/v.mp4 && "$SEGCAST" verify out >/dev/null; }
for how in before torn; do
    n=$((RANDOM % 20 + 1))
    [ -z "${SC_TEST_ALL:-}" ] || n=1
    while :; do
        rm -rf out
        cp -a slice out
        code=0
        "$CRASH_POINTS" $n $how "$PWD/out" "$SEGCAST" render job.yaml -o out --slice 1/2 -q >said.txt 2>stderr.txt || code=$?
        [ $code = 3 ] && break
        "$SEGCAST" render job.yaml -o out --slice 1/2 --resume -q >/dev/null 2>stderr.txt || fail "a slice, $how $n: $(cat stderr.txt)"
        same_slices || fail "a slice, $how $n: other bytes"
        diff <(files out) <(files both) || fail "a slice, $how $n: other files are left"
        [ -n "${SC_TEST_ALL:-}" ] && n=$((n + 1)) || n=$((n + 16 + RANDOM % 30))
    done
done
