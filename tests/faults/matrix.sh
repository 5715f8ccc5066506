# SPDX-License-Identifier: BSD-3-Clause
# Every call of malloc, write, fsync, rename, open, mmap and pthread_create that a small job makes fails once, or
# from there on: segcast must end with 70, 71, 73 or 74 and one message, or absorb it, and must not hang; and
# --resume must then lead to the same bytes. Killed at each write, fsync, rename and open it must resume, too.
#
# FAULT_DISTINCT  N: of calls that come the same way, judged by the return addresses out to the N-th in the program,
#                 only the first (default: 1, once for each place in the program; 99: the whole stack); 0: every call
# FAULT_STEP      only every so manyeth of these of a kind; two numbers: with one rank, with several (default: chosen
#                 so that it lasts less than a minute)
# FAULT_OFFSET    the first of them (default: 0)
# FAULT_RANKS     "1", "2" or "1 2" (default)
# FAULT_KINDS     for example "write sync" (default: all)
# FAULT_FUNCTION  only calls that are made while this function of the program works
# FAULT_PREPARED  1: the volume is a prepared file, which every rank maps
# FAULT_OVERLAYS  1: every overlay is written onto the frames
# FAULT_FILM      1: the job is a film of shots, with verbs, names and colours by values
# FAULT_RESUME    1: the run with faults continues one that was killed half way
# FAULT_ENCODE    farm.encode (default: segments), and
# FAULT_FRAMES    the number of frames, two for each GOP (default: 3)
# FAULT_RESULTS   where the list of outcomes is copied to
# FAULT_JOBS      how many runs there are at a time (default: one per core)
[ -e "${FAULT_SHIM:-}" ] || skip "the library that makes calls fail is built on Linux with glibc only, without sanitizers"
command -v jq >/dev/null || skip "jq is not installed"

export SEGCAST_CACHE=off # every run prepares the volume
distinct=${FAULT_DISTINCT:-1}
read -ra steps <<<"${FAULT_STEP:-30 331}"
offset=${FAULT_OFFSET:-0}
read -ra all_ranks <<<"${FAULT_RANKS:-1 2}"
read -ra all_kinds <<<"${FAULT_KINDS:-alloc write sync rename open map thread}"
command -v mpirun >/dev/null || all_ranks=(1)

if [ -n "${FAULT_FUNCTION:-}" ]; then
    FAULT_WITHIN=$(nm -S "$SEGCAST" | awk -v name="$FAULT_FUNCTION" '$4 == name {print $1, $2}' |
        while read -r begin size; do printf '%x-%x' $((16#$begin)) $((16#$begin + 16#$size)); done)
    [ -n "$FAULT_WITHIN" ] || fail "$SEGCAST has no function $FAULT_FUNCTION"
    export FAULT_WITHIN
fi

# A volume of two tissues, compressed, and a job of a few GOPs.
{
    printf '%s\n' NRRD0004 'type: unsigned char' 'dimension: 3' 'space: left-posterior-superior' 'sizes: 12 10 12' \
        'space directions: (1,0,0) (0,1,0) (0,0,1)' 'encoding: gzip' 'space origin: (0,0,0)' \
        'Segment0_Name:=wall' 'Segment0_LabelValue:=1' 'Segment0_Color:=0.8 0.3 0.2' \
        'Segment1_Name:=blood' 'Segment1_LabelValue:=2' ''
    awk 'BEGIN { for (z = 0; z < 12; z++) for (y = 0; y < 10; y++) for (x = 0; x < 12; x++) {
        d = (x - 5.5) ^ 2 + (y - 4.5) ^ 2 + (z - 5.5) ^ 2
        printf "%d", d < 6 ? 2 : d < 15 } }' | tr 012 '\000\001\002' | gzip -9n
} >volume.nrrd
cat >job.yaml <<YAML
volume: volume.nrrd
output: {directory: out, size: [32, 24], fps: 2, frames: png, video: film.mp4}
tissues:
  wall: {opacity: 0.6}
animation:
  frames: ${FAULT_FRAMES:-3}
  camera: {orbit: {axis: superior, elevation: 10}}
farm: {encode: ${FAULT_ENCODE:-segments}}
YAML
if [ -n "${FAULT_OVERLAYS:-}" ]; then
    "$SEGCAST" still job.yaml -o logo.png -q >/dev/null
    sed -i 's/32, 24/128, 96/' job.yaml # room for words
    cat >>job.yaml <<YAML
overlays:
  caption: {0%: Herz 心臓, 60%: none}
  time: top-right
  scale_bar: bottom-left
  orientation: bottom-right
  legend: top-left
  names: all
  logo: {top: logo.png}
YAML
fi
if [ -n "${FAULT_FILM:-}" ]; then # 7 frames: a frame of each shot is mixed with one of another, or faded
    printf '%s\n' 'name,mm' 'wall,1.5' 'blood,3' >values.csv
    cat >job.yaml <<YAML
volume: volume.nrrd
output: {directory: out, size: [96, 72], fps: 2, frames: png, video: film.mp4}
tissues: {wall: {opacity: 0.6}}
shots:
  - name: Title
    card: Herz
    animation: {frames: 2}
  - name: Apart
    transition: fade 0.5 s
    animation:
      frames: 3
      camera: {orbit: {turns: 0.5, elevation: 10}}
      clip: [{normal: posterior, at: {0%: 0%, 100%: 45%}}]
      verbs:
        - {turn: 40, plane: 1, axis: superior}
        - {explode: "*", by: 60%, during: [0%, 60%]}
        - {fade: wall, to: 20%, during: [40%, 100%]}
    overlays: {caption: Apart, names: all}
  - name: Values
    transition: cross_fade 1 s
    animation:
      frames: 4
      camera: {orbit: {turns: 0}}
      verbs:
        - {rock: 20}
        - {frame: blood, during: [0%, 50%]}
        - {fly: [[-5, -4, 0], [-5, -4, 11]], during: [60%, 100%]}
    color_by: {values: values.csv, column: mm}
    overlays: {color_bar: bottom-right, legend: top-left}
YAML
fi
if [ -n "${FAULT_PREPARED:-}" ]; then
    "$SEGCAST" convert job.yaml -o volume.segc -q
    sed -i 's/volume.nrrd/volume.segc/' job.yaml
fi
mkdir reference
(cd reference && "$SEGCAST" render ../job.yaml -o out -q >/dev/null)
jq -c 'select(.frame != null) | [.frame, .hash]' reference/out/manifest.jsonl | sort >hashes.txt

# stop_half_way: leave in stopped/ what a run holds that was killed after half of its files, or later if it had drawn no
# frame by then: frames are written beside other files.
stop_half_way() {
    local renames eighths
    env LD_PRELOAD="$FAULT_SHIM" FAULT_REPORT="$PWD/report" "$SEGCAST" render job.yaml -o whole -q >/dev/null
    renames=$(awk '$1 == "calls" && $2 == "rename" {print $3}' report)
    for eighths in 4 5 6 7; do
        rm -rf report whole stopped
        (env LD_PRELOAD="$FAULT_SHIM" FAULT_KIND=rename FAULT_AT=$((renames * eighths / 8)) FAULT_ERROR=KILL \
            "$SEGCAST" render job.yaml -o stopped -q >/dev/null) 2>/dev/null || true
        ! grep -q '"frame"' stopped/manifest.jsonl || break
    done
    grep -q '"frame"' stopped/manifest.jsonl || fail "the run was killed before it had drawn a frame"
    export FAULT_RESUME
}
[ -z "${FAULT_RESUME:-}" ] || stop_half_way

# plans KIND: print the errors and modes with which calls of a kind fail.
plans() {
    case $1 in
    alloc) echo "ENOMEM once" "ENOMEM on" ;;
    write) echo "EIO once" "ENOSPC on" "SHORT once" "KILL once" ;;
    sync | rename) echo "EIO once" "KILL once" ;;
    open) echo "EMFILE once" "EIO on" "KILL once" ;;
    map) echo "ENOMEM once" ;;
    thread) echo "EAGAIN once" "EAGAIN on" ;;
    esac
}

# count RANKS: run the job without a fault, and leave its calls in calls.RANKS.RANK, each as "site KIND NUMBER STACK".
count() {
    local launch=() rank
    [ "$1" = 1 ] || launch=(mpirun -n "$1")
    rm -f report*
    [ -z "${FAULT_RESUME:-}" ] || cp -a stopped "counted$1"
    "${launch[@]}" env LD_PRELOAD="$FAULT_SHIM" FAULT_REPORT="$PWD/report" FAULT_SITES=$((distinct ? distinct : 1)) \
        "$SEGCAST" render job.yaml -o "counted$1" -q ${FAULT_RESUME:+--resume} >/dev/null
    if [ "$1" = 1 ]; then mv report calls.1.-; else
        for rank in $(seq 0 $(($1 - 1))); do mv "report.$rank" "calls.$1.$rank"; done
    fi
}

# numbers RANKS RANK KIND: print the numbers of the calls that are to fail; of kinds with few at least one.
numbers() {
    awk -v kind="$3" -v distinct="$distinct" -v step="${steps[$1 == 1 ? 0 : ${#steps[@]} - 1]}" -v offset="$offset" '
        $1 == "site" && $2 == kind && !(distinct && seen[$4]++) { number[count++] = $3 }
        END {
            for (i = offset % step; i < count; i += step) print number[i]
            if (count && offset % step >= count) print number[offset % count]
        }' "calls.$1.$2"
}

# list RANKS RANK: print the arguments of case.sh for all faults on a rank.
list() {
    local kind words some i n
    for kind in "${all_kinds[@]}"; do
        mapfile -t some < <(numbers "$1" "$2" "$kind")
        read -ra words <<<"$(plans "$kind")"
        for ((i = 0; i < ${#words[@]}; i += 2)); do
            [ "${words[i]}" != KILL ] || [ "$1" = 1 ] || continue # the launcher ends the other ranks: mpi.soak has that
            for n in "${some[@]}"; do
                echo "$1 $kind ${words[i]} ${words[i + 1]} $2 $n"
            done
        done
    done
}

for ranks in "${all_ranks[@]}"; do
    count "$ranks"
    if [ "$ranks" = 1 ]; then list 1 -; else
        for rank in $(seq 0 $((ranks - 1))); do list "$ranks" "$rank"; done
    fi
done >cases.txt
total=$(wc -l <cases.txt)
echo "FAULT_DISTINCT=$distinct FAULT_STEP="${steps[*]}" FAULT_OFFSET=$offset: $total faults"
[ "$total" -gt 0 ] || fail "no call was counted: does the loader take $FAULT_SHIM?"
export FAULT_SHIM SEGCAST
xargs -P "${FAULT_JOBS:-$(env -u OMP_NUM_THREADS nproc)}" -L 1 bash "$SOURCE/tests/faults/case.sh" <cases.txt >results.txt &
work=$!
while sleep 5 && kill -0 $work 2>/dev/null; do
    [ -z "${FAULT_PROGRESS:-}" ] ||
        printf '%d of %d faults, %d wrong\n' "$(wc -l <results.txt)" "$total" "$(grep -c ^WRONG results.txt || true)" >&2
done
wait $work
[ -z "${FAULT_RESULTS:-}" ] || cp results.txt "$FAULT_RESULTS"
echo "outcomes (number, exit code):"
awk '{print $2}' results.txt | sort | uniq -c
[ "$(wc -l <results.txt)" = "$total" ] || fail "$(wc -l <results.txt) outcomes of $total faults"
if grep ^WRONG results.txt; then fail "$(grep -c ^WRONG results.txt) of $total faults end as they must not"; fi
