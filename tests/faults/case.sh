#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# case.sh RANKS KIND ERROR MODE RANK NUMBER: one fault in one run of the job in this folder (see matrix.sh), in a
# folder of its own. Prints "ok CODE ..." or "WRONG CODE ...: REASON", with the arguments; a wrong case keeps its
# folder. RANK "-" means the faults are on all ranks.
set -u
ranks=$1 kind=$2 error=$3 mode=$4 rank=$5 number=$6
name=$ranks-$kind-$error-$mode-$rank-$number
top=$PWD

ended() { # ended ok|WRONG [REASON]
    printf '%s %s %s%s [%s]\n' "$1" "$code" "$name" "${2:+: $2}" "${site:0:160}"
    cd "$top" || exit 1
    [ "$1" = WRONG ] || rm -rf "$name"
    exit 0
}

# same_output: out holds what ref holds, and the records are whole.
same_output() {
    cmp -s out/film.mp4 ../reference/out/film.mp4 || { why="the video differs or is missing"; return 1; }
    diff -rq out/frames ../reference/out/frames >/dev/null || { why="the PNG files differ"; return 1; }
    cmp -s out/job.yaml ../reference/out/job.yaml || { why="job.yaml differs or is missing"; return 1; }
    why=$(jq -nr --slurpfile manifest out/manifest.jsonl --slurpfile status out/status.json \
        --slurpfile stats out/stats.json --slurpfile trace out/trace.json --slurpfile hashes ../hashes.txt '
        if [$manifest[] | select(.frame != null) | [.frame, .hash]] | sort != ($hashes | sort)
        then "the hashes of the frames differ"
        elif $status[0].state != "complete" then "status.json is not that of a complete run"
        elif $stats[0] | .runs and .host and .phases and .memory.peak_rss_bytes[0] and all(.frames[]; .hash) | not
        then "stats.json is not whole"
        elif $trace[0].traceEvents | not then "trace.json is not whole"
        else empty end' 2>&1 | head -n 1)
    [ -z "$why" ] || return 1
    [ -z "$(find out -name '.*' -o -name segments -o -name '*.part')" ] || grep -q 'not needed any more stay there' stderr.txt ||
        { why="files are left, and nobody is told"; return 1; }
    return 0
}

rm -rf "$name"
mkdir "$name"
cd "$name" || exit 1
[ -z "${FAULT_RESUME:-}" ] || cp -a ../stopped out
launch=()
[ "$ranks" = 1 ] || launch=(mpirun -n "$ranks")
faults=(LD_PRELOAD="$FAULT_SHIM" FAULT_KIND="$kind" FAULT_AT="$number" FAULT_ERROR="$error" FAULT_MODE="$mode"
    FAULT_REPORT="$PWD/report")
[ "$rank" = - ] || faults+=(FAULT_RANK="$rank")
code=0
# The launcher itself has no faults; the shim would not count its calls either.
{
    timeout -k 5 "${FAULT_PATIENCE:-60}" "${launch[@]}" env "${faults[@]}" \
        "$SEGCAST" render ../job.yaml -o out -q ${FAULT_RESUME:+--resume} >stdout.txt 2>stderr.txt || code=$?
} 2>/dev/null # where the shell tells of processes that crash
site=
for report in report*; do # of the first rank with a fault
    [ -n "$site" ] || [ ! -e "$report" ] || read -r _ site < <(grep '^fault ' "$report")
done
errors=$(grep -c 'segcast: \(rank [0-9]*: \)\?error' stderr.txt)
# Libraries that end the process without memory, or use what they did not get: nothing can be done about it
# from outside, but that the directory can be resumed.
library=
if [ "$kind" = alloc ]; then
    case "$code $site" in
    134*libcairo:*) grep -q 'longjmp causes uninitialized stack frame' stderr.txt &&
        library="cairo jumps back into a function that has ended" ;;
    134*) grep -q '^Assertion .* at src/libavcodec/options.c' stderr.txt &&
        library="libavcodec ends the process (av_assert0 in avcodec_alloc_context3)" ;;
    127*) grep -q '^cannot allocate memory for thread-local data: ABORT' stderr.txt &&
        library="the C library ends the process (a thread gets room for the data of libraries loaded since it began)" ;;
    # segcast makes sure that there is memory before; one call that fails in between is beyond its reach.
    124*libfontconfig:FcDirCacheLoad*) library="fontconfig waits for a lock that it has kept (FcCacheInsert)" ;;
    139*libx264:x264_encoder_* | 139*libteem:* | 139*libfontconfig:* | 139*libcairo:*) library="the library uses memory that it did not get" ;;
    esac
fi
case $code in
127 | 134 | 139) [ -n "$library" ] || ended WRONG "it crashes: $(grep -v '^$' stderr.txt | head -n 1)" ;;
0)
    same_output || ended WRONG "exit code 0, but $why"
    [ "$errors" = 0 ] || ended WRONG "exit code 0 with an error message"
    ended ok
    ;;
70 | 71 | 73 | 74)
    [ "$errors" = 1 ] || ended WRONG "$errors error messages: $(grep "segcast: .*error" stderr.txt | tr "\n" ";")"
    # x264, Teem and fontconfig print by themselves that they have no memory, and cannot be kept from it.
    noise=$(grep -vE '^segcast: |^x264 \[error\]: |^Fontconfig (error|warning): |^\[?(biff|air|nrrd).* PANIC|^$' stderr.txt | head -n 1)
    [ "$ranks" != 1 ] || [ -z "$noise" ] || ended WRONG "a library prints: $noise"
    ;;
124 | 137)
    if [ -z "$library" ] && { [ "$error" != KILL ] || [ $code != 137 ]; }; then ended WRONG "it hangs, or was killed"; fi
    ;;
*) ended WRONG "exit code $code: $(grep -v '^$' stderr.txt | head -n 1)" ;;
esac
first=$code
[ -e out ] || ended ok # there is nothing to resume
code=0
timeout -k 5 "${FAULT_PATIENCE:-60}" "$SEGCAST" render ../job.yaml -o out -q --resume >resumed.txt 2>&1 || code=$?
[ "$code" = 0 ] || ended WRONG "after $first, --resume exits with $code: $(head -n 1 resumed.txt)"
same_output || ended WRONG "after $first and --resume, $why"
code=$first
ended ok
