# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash
# Shared by all test scripts.
export OMP_NUM_THREADS=1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none
export OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_btl_vader_single_copy_mechanism=none
command -v ssh >/dev/null || export OMPI_MCA_plm_rsh_agent=false
export XDG_CACHE_HOME=$PWD/.cache # nothing that the user has calibrated counts, and nothing is left there
export HWLOC_COMPONENTS=-gl # mpirun would look for displays, which takes seconds without /etc/hosts

fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }
skip() { printf 'skipped: %s\n' "$*"; exit 77; }

# find_python MODULES PACKAGE: set $python to an interpreter that has the modules; else skip, and name Debian's package.
find_python() {
    for python in /usr/bin/python3 python3; do
        "$python" -c "import $1" 2>/dev/null && return
    done
    skip "Python cannot import $1 (Debian: $2)"
}

# sampled: is this case one to try? All are; but where AddressSanitizer watches, which makes each command take several
# times as long, every third from a random one on, unless SC_TEST_ALL is set.
sample=$((RANDOM % 3))
sampled() {
    case $BUILD in
    */asan)
        sample=$((sample + 1))
        [ -n "${SC_TEST_ALL:-}" ] || [ $((sample % 3)) = 0 ]
        ;;
    esac
}

# expect CODE PATTERN COMMAND...: the command exits with CODE, and a line of its standard error matches
# the extended regular expression PATTERN, unless that is empty.
expect() {
    local want=$1 pattern=$2 code=0
    shift 2
    "$@" >stdout.txt 2>stderr.txt || code=$?
    [ "$code" = "$want" ] || { cat stderr.txt >&2; fail "exit code $code, expected $want: $*"; }
    [ -z "$pattern" ] || grep -qE -- "$pattern" stderr.txt || {
        cat stderr.txt >&2
        fail "no line of standard error matches \"$pattern\": $*"
    }
}

# one_error: the command of the last expect printed exactly one error.
one_error() {
    [ "$(grep -c 'segcast: error' stderr.txt)" = 1 ] || { cat stderr.txt >&2; fail "$(grep -c 'segcast: error' stderr.txt) errors were printed, expected 1"; }
}

# change STORE NEW SCRIPT: copy a volume of several files. In its directory $changes and SCRIPT are run by one Python, with
# those of all others, when refused begins.
change() {
    cp -r "$1" "$2"
    printf "os.chdir('%s')\n%s\n%s\nos.chdir('$PWD')\n" "$2" "$changes" "$3" >>changes.py
}
# refused: of each line of standard input, CODE VOLUME PATTERN, the volume is refused by one message.
refused() {
    local code volume pattern
    "$python" -c 'import glob, json, os, struct; exec(open("changes.py").read())' || fail "the volumes cannot be changed"
    while read -r code volume pattern; do
        expect "$code" "$pattern" "$SEGCAST" info "$volume"
        one_error
        ! grep -q $'\x1b' stderr.txt || fail "$volume: an escape code is printed"
    done
}

# wait_until COMMAND: look again and again whether it succeeds, for a minute at most.
wait_until() {
    for _ in $(seq 1200); do ! eval "$1" || break; sleep 0.05; done
}
# frames DIRECTORY: how many frames its manifest names.
frames() { grep -cs '"frame"' "$1/manifest.jsonl" || [ -e "$1/manifest.jsonl" ] || echo 0; }
# wait_for_desk FILE: until the desk that was started last has written its address there.
wait_for_desk() {
    desk=$!
    trap 'kill $desk 2>/dev/null || true' EXIT
    wait_until "[ -s $1 ] || ! kill -0 $desk 2>/dev/null"
    kill -0 $desk 2>/dev/null || { cat desk.txt >&2; fail "the desk has ended"; }
}
end_desk() { # end_desk SIGNAL: by which it ends in order
    local code=0
    kill "-$1" $desk
    wait $desk || code=$?
    trap - EXIT
    [ $code = 0 ] || { cat desk.txt >&2; fail "the desk has ended with exit code $code"; }
}

mpi() { # mpi RANKS COMMAND...
    local ranks=$1
    shift
    mpirun -n "$ranks" "$@"
}

# hashes DIR: print number and hash of each frame that the manifests name, in order of frames.
hashes() { jq -r 'select(.frame != null) | "\(.frame) \(.hash)"' "$1"/manifest*.jsonl | sort -n; }
# job_hash DIR: print the hash of the job that the manifest names.
job_hash() { head -q -n 1 "$1"/manifest*.jsonl | jq -r .job_hash; }

small_job() { # small_job FILE [LINES]: write a quick job on a small phantom, with more LINES at its end
    cat >"$1" <<YAML
volume: phantom:59x41x61
output: {directory: out, size: [96, 72], video: none}
tissues:
  "*": {opacity: 0.6}
animation:
  frames: 7
  camera: {orbit: {axis: superior, elevation: 10}}
  clip:
    - {normal: posterior, at: {0%: 0%, 100%: 60%},
       except: [coronary arteries]}
${2:-}
YAML
}

# page_data PAGE: print the data of a page, which names no address of the network and is smaller than 300 KB.
page_data() {
    [ "$(stat -c %s "$1")" -lt 300000 ] || fail "$1 has $(stat -c %s "$1") bytes"
    ! sed 's|http://www.w3.org/2000/svg||' "$1" | grep -oE '.{20}https?:.{20}' || fail "$1 names an address (above)"
    [ "$(grep -c '<script' "$1")" = 2 ] || fail "$1 has other scripts than its own"
    sed -n 's|^<script type="application/json" id="data">\(.*\)</script>$|\1|p' "$1"
}
# page_has PAGE CONDITION [VALUE]: the condition, in the language of jq, holds for the data of a page; $value in it is VALUE.
page_has() { page_data "$1" | jq -e --arg value "${3:-}" "$2" >/dev/null || fail "$1: $2 does not hold"; }
