# SPDX-License-Identifier: BSD-3-Clause
# Each run logs a table of ranks, and one warning with the options that help if threads share cores.
small_job job.yaml
sed -i 's/video: none/video: none, frames: png/' job.yaml # without files there is a warning of that
cores=$(env -u OMP_NUM_THREADS nproc)
many=$((cores * 2))
logs() { # logs WARNINGS PATTERN COMMAND...
    local warnings=$1 pattern=$2
    shift 2
    "$@" >/dev/null 2>stderr.txt || { cat stderr.txt >&2; fail "exit $?: $*"; }
    [ "$(grep -c 'segcast: warning' stderr.txt || true)" = "$warnings" ] || { cat stderr.txt >&2; fail "expected $warnings warnings: $*"; }
    grep -qE -- "$pattern" stderr.txt || { cat stderr.txt >&2; fail "no line matches \"$pattern\""; }
}
logs 0 "^segcast: +0 +$(hostname) +1 " "$SEGCAST" render job.yaml --overwrite --threads 1
logs 1 "$many threads of rank 0 share .*--map-by slot:PE=$many .*--cpus-per-task=$many" \
    "$SEGCAST" render job.yaml --overwrite --threads "$many"
logs 1 "2 ranks with $many threads in all share" mpi 2 "$SEGCAST" render job.yaml --overwrite --threads "$cores"
[ "$(grep -cE "^segcast: +[01] +$(hostname) +$cores " stderr.txt)" = 2 ] || fail "no table of two ranks"
logs 1 'was --cpus-per-task forgotten.*--cpus-per-task=64' \
    env SLURM_CPUS_ON_NODE=64 "$SEGCAST" render job.yaml --overwrite --threads 1
logs 0 '' env SLURM_CPUS_ON_NODE=1 "$SEGCAST" render job.yaml --overwrite --threads 1
