# SPDX-License-Identifier: BSD-3-Clause
# The batch scripts end with 0 only if the job is complete, whatever the launcher says, and decide what is queued
# again; with stand-ins for the commands of Slurm and PBS, which write down how they were called.
small_job job.yaml
sed -i 's/video: none/video: film.mp4, fps: 4/' job.yaml
mkdir bin
ln -s "$SEGCAST" bin/segcast
export PATH=$PWD/bin:$PATH
stub() { printf '#!/bin/bash\necho "%s $* threads=$OMP_NUM_THREADS,$SRUN_CPUS_PER_TASK" >>%s/calls\n%s\n' "$1" "$PWD" "$2" >bin/"$1"; chmod +x bin/"$1"; }
stub scontrol ''
stub qsub ''
stub sleep ''
stub squeue 'date -d "+1 hour" +%Y-%m-%dT%H:%M:%S'
# srun and mpirun: run the command after their options, or do not (LAUNCH=no); then end with CODE, if it is given.
launch='while [ $# -gt 0 ] && [[ $1 != env && $1 != segcast && $1 != true ]]; do shift; done
[ -z "$SIGNAL" ] || { trap "" USR1; kill -$SIGNAL $PPID; /bin/sleep 0.5; }
[ "$LAUNCH" = no ] || "$@" ${FRAMES:+--frames $FRAMES}
[ -z "$OTHER" ] || echo "{\"run\": \"$OTHER\"}" >out/status.json
exit ${CODE:-$?}'
stub srun '[ "$1" = --mpi=list ] && { printf "MPI plugin types are...\n\tnone\n\t%s\n" $OFFERED; exit; }
'"$launch"
stub mpirun 'while [ $# -gt 0 ] && [[ $1 == -* || $1 == slot* ]]; do shift; done
'"$launch"

export SLURM_JOB_ID=17 SLURM_JOB_CPUS_PER_NODE='1(x2)' SLURM_NNODES=2 OFFERED=pmix PBS_O_WORKDIR=$PWD JOB=job.yaml
# batch CODE QUEUED SCRIPT ARGUMENT...: the script ends with CODE, and is queued again or not.
batch() {
    local want=$1 queued=$2 code=0 found=no
    shift 2
    rm -f calls
    bash "$@" >stdout.txt 2>stderr.txt || code=$?
    [ $code = "$want" ] || { cat stderr.txt >&2; fail "exit code $code, expected $want: $*"; }
    ! grep -qE 'scontrol requeue 17|qsub' calls || found=yes
    [ $found = "$queued" ] || { cat stderr.txt >&2; fail "queued again: $found, expected $queued: $*"; }
    if [ "$want" = 75 ] && [ "$queued" = no ]; then
        grep -q '^FAILED: ' stderr.txt || { cat stderr.txt >&2; fail "failed without a message: $*"; }
    fi
}
for name in one-node many-nodes requeue; do
    script=$SOURCE/jobs/slurm/$name.sbatch
    rm -rf out
    # The launcher ends with 0 and has started nothing; the last time too often without a new frame.
    LAUNCH=no CODE=0 batch 75 yes "$script" job.yaml -o out
    SLURM_RESTART_COUNT=4 LAUNCH=no CODE=0 batch 75 yes "$script" job.yaml -o out
    [ "$(grep -c 'srun --mpi=none true' calls)" = 4 ] || fail "$name does not use one step for each restart"
    SLURM_RESTART_COUNT=5 LAUNCH=no CODE=0 batch 75 no "$script" job.yaml -o out
    # Ranks were killed, but frames were added; an error that another run would meet again.
    SLURM_RESTART_COUNT=9 FRAMES=0-2 CODE=137 batch 75 yes "$script" job.yaml -o out
    LAUNCH=no CODE=65 batch 65 no "$script" job.yaml -o out
    LAUNCH=no CODE=75 batch 75 yes "$script" job.yaml -o out
    # Slurm asks to stop in time: again. Slurm ends the job, because it is cancelled or queued again by others: not.
    SIGNAL=USR1 LAUNCH=no CODE=75 batch 75 yes "$script" job.yaml -o out
    SIGNAL=TERM LAUNCH=no CODE=75 batch 75 no "$script" job.yaml -o out
    # Complete, and still so if the launcher then ends with an error of its own.
    batch 0 no "$script" job.yaml -o out
    CODE=137 batch 0 no "$script" job.yaml -o out
    # Another run has begun in the directory meanwhile: two that queue themselves would take it from each other for ever.
    rm -rf out
    FRAMES=0-2 CODE=75 batch 75 yes "$script" job.yaml -o out
    LAUNCH=no OTHER=19 CODE=75 batch 75 no "$script" job.yaml -o out
    grep -q '^FAILED: another run (19) has begun' stderr.txt || { cat stderr.txt >&2; fail "not told of the other run"; }
    LAUNCH=no OTHER=19 CODE=75 batch 75 yes "$script" job.yaml -o out    # it ended before this one
    LAUNCH=no OTHER=17 CODE=75 batch 75 yes "$script" job.yaml -o out
    rm -rf out
    batch 0 no "$script" job.yaml -o out
    grep -q '"run": "17"' out/status.json || fail "no run in status.json: $(cat out/status.json)"
    # The directory holds another job, which is complete.
    LAUNCH=no CODE=0 batch 75 yes "$script" job.yaml -o out --set render.quality=draft
done
rm -rf out
export SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_COUNT=2
script=$SOURCE/jobs/slurm/array.sbatch
SLURM_ARRAY_TASK_ID=1 batch 0 no "$script" job.yaml -o out
SLURM_ARRAY_TASK_ID=2 LAUNCH=no CODE=0 batch 75 yes "$script" job.yaml -o out
SLURM_ARRAY_TASK_ID=2 batch 0 no "$script" job.yaml -o out
expect 0 '' "$SEGCAST" status out

# The plug-in is the one that Slurm offers for this MPI; a single process needs none.
script=$SOURCE/jobs/slurm/many-nodes.sbatch
if "$SEGCAST" --version | grep -q 'Open MPI'; then
    OFFERED=pmix batch 0 no "$script" job.yaml -o out
    grep -q 'srun --kill-on-bad-exit=1 --ntasks=2 --ntasks-per-node=1 --mpi=pmix env' calls || fail "not --mpi=pmix: $(cat calls)"
    OFFERED=pmi2 batch 0 no "$script" job.yaml -o out
    grep -q 'srun --kill-on-bad-exit=1 --ntasks=2 --ntasks-per-node=1 --mpi=pmi2 env' calls || fail "not --mpi=pmi2: $(cat calls)"
    OFFERED=openmpi batch 0 no "$script" job.yaml -o out
    grep -q 'srun --kill-on-bad-exit=1 --ntasks=2 --ntasks-per-node=1 env' calls || fail "an --mpi that is not offered: $(cat calls)"
fi
SLURM_NNODES=1 batch 0 no "$script" job.yaml -o out
grep -q 'srun --kill-on-bad-exit=1 --ntasks=1 --ntasks-per-node=1 --mpi=none env' calls || fail "a single process with MPI: $(cat calls)"
# Ranks and threads fill the CPUs that Slurm gave on the smallest node; what sbatch was told goes before.
while read -r cpus told want; do
    rm -f calls
    # shellcheck disable=SC2086  # several words
    SLURM_JOB_CPUS_PER_NODE=$cpus LAUNCH=no CODE=65 env ${told//;/ } bash "$script" job.yaml -o out >/dev/null 2>&1 || true
    grep -qe "$want" calls || fail "$cpus, $told: $(cat calls)"
done <<'SIZES'
2(x2) A=1 --ntasks=2 --ntasks-per-node=1 .* threads=2,2
32(x2),8 A=1 --ntasks=2 --ntasks-per-node=1 .* threads=8,8
36(x2) A=1 --ntasks=10 --ntasks-per-node=5 .* threads=7,7
16(x2) SLURM_NTASKS_PER_NODE=4;SLURM_CPUS_PER_TASK=3 --ntasks=8 --ntasks-per-node=4 .* threads=3,3
SIZES
# What a site fills in.
sed 's/^container=()/container=(env IN_CONTAINER=1)/; s/^mpi=auto/mpi=pmix_v4/; s/^launcher=(srun/& --exact/; s/^modules=()/modules=(gcc segcast)/' "$script" >site.sbatch
module() { echo "module $*" >>calls; }
export -f module
batch 0 no site.sbatch job.yaml -o out
grep -q 'srun --exact --kill-on-bad-exit=1 --ntasks=2 --ntasks-per-node=1 --mpi=pmix_v4 env --block-signal=USR1 env IN_CONTAINER=1 segcast' calls || fail "the block for the site: $(cat calls)"
grep -q 'module load gcc segcast' calls || fail "no modules are loaded: $(cat calls)"

# Studies: complete when the file of measurements says so.
mkdir -p jobs/studies
printf 'set: {volume: "phantom:16x16x16", output: {size: 32x32}, threads: 1}\nleast: 1\nmost: 1\n' >jobs/studies/table-1.yaml
script=$SOURCE/jobs/studies/table-1.sbatch
LAUNCH=no CODE=0 batch 75 yes "$script" study
SLURM_RESTART_COUNT=5 LAUNCH=no CODE=0 batch 75 no "$script" study
LAUNCH=no CODE=65 batch 65 no "$script" study
CODE=137 batch 0 no "$script" study
batch 0 no "$script" study --threads 1
SIGNAL=USR1 LAUNCH=no CODE=75 batch 75 yes "$script" other

# PBS: the script submits itself.
script=$SOURCE/jobs/pbs/many-nodes.pbs
rm -rf out
LAUNCH=no CODE=0 batch 75 yes "$script"
grep -q "qsub -v JOB=job.yaml,IDLE=1 " calls || fail "the first run without a frame: $(cat calls)"
IDLE=4 LAUNCH=no CODE=0 batch 75 yes "$script"
IDLE=5 LAUNCH=no CODE=0 batch 75 no "$script"
LAUNCH=no CODE=66 batch 66 no "$script"
batch 0 no "$script"
CODE=1 batch 0 no "$script"
