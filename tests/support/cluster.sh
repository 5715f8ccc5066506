# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash
# Shared by the tests that run under a real Slurm with several virtual hosts on this machine. The script that
# starts such a cluster is not part of the project: cmake -DSC_SLURM_CLUSTER=PATH names it. If the tests
# cannot run they are skipped, and the reason is printed.
[ -x "${SLURM_CLUSTER:-}" ] || skip "no script that starts a Slurm cluster (SC_SLURM_CLUSTER)"
[ "$(id -u)" = 0 ] || skip "starting a Slurm of virtual hosts needs root"
unshare --mount --pid --net --ipc --uts --fork true 2>/dev/null || skip "namespaces are not permitted here"
"$SLURM_CLUSTER" install >install.txt 2>&1 || skip "Slurm cannot be installed here: $(tail -1 install.txt)"
export SLURM_CLUSTER_DIR=$PWD/cluster SLURM_CLUSTER_SUBNET=10.$((RANDOM % 100 + 100)).$((RANDOM % 200))
trap '"$SLURM_CLUSTER" down >/dev/null 2>&1 || true' EXIT
"$SLURM_CLUSTER" up "${HOSTS:-2}" >up.txt 2>&1 || skip "a Slurm of virtual hosts cannot be started here: $(tail -1 up.txt)"

on_head() { "$SLURM_CLUSTER" exec head "$@"; }
# Batch scripts call the program segcast, found by PATH.
mkdir -p bin
ln -sf "$SEGCAST" bin/segcast
export PATH=$PWD/bin:$PATH
SMALL=(--nodes=2 --ntasks-per-node=1 --cpus-per-task=1)

# make_job SECONDS: write job.yaml, a job that takes about so many seconds on all cores of this machine
# together, and ref/, the output of an undisturbed run of it.
make_job() {
    local frames
    small_job job.yaml
    sed -i 's/size: \[96, 72\], video: none/size: [640, 480], fps: 5, frames: png, video: film.mp4/' job.yaml
    "$SEGCAST" render job.yaml -o trial -q --threads 2 >/dev/null
    frames=$(jq "(7 / (.phases.render.wall_s + .phases.encode.wall_s + .phases.write.wall_s) * $1 | floor) + 7" trial/stats.json)
    [ "$frames" -ge 40 ] || frames=40 # the trial may be slow because the machine is busy with other things
    sed -i "s/frames: 7/frames: $frames/" job.yaml
    "$SEGCAST" render job.yaml -o ref -q --threads 2 >/dev/null
}

# submit [SBATCH_ARGUMENT...]: submit a batch script and set $id to the number of the job.
submit() { id=$(on_head sbatch --parsable "$@"); }

# state: print the state of job $id, for example RUNNING.
state() { on_head scontrol show job "$id" | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p' | sort -u; }

# wait_for SECONDS WHAT COMMAND...: wait until the command succeeds; give up after SECONDS, naming WHAT.
wait_for() {
    local limit=$1 what=$2
    shift 2
    for _ in $(seq $((limit * 5))); do
        "$@" && return
        sleep 0.2
    done
    cat ./*.log >&2 || true
    on_head scontrol show job "$id" >&2 || true
    fail "waited $limit s in vain for $what"
}
has_ended() { [[ $(state) =~ ^(COMPLETED|FAILED|TIMEOUT|CANCELLED|NODE_FAIL)$ ]]; }
has_frames() { [ "$(cat out/manifest*.jsonl 2>/dev/null | grep -c '"frame"')" -ge "$1" ]; }

# same_as_ref: out holds the same bytes as ref, the output of an undisturbed run, and can be verified.
same_as_ref() {
    [ "$(hashes out)" = "$(hashes ref)" ] || fail "the hashes of the frames differ from those of an undisturbed run"
    cmp out/film.mp4 ref/film.mp4 || fail "the video differs from that of an undisturbed run"
    diff -r out/frames ref/frames || fail "the PNG files differ from those of an undisturbed run"
    "$SEGCAST" verify out >/dev/null || fail "segcast verify found an error"
    [ ! -e out/segments ] || fail "out/segments was not removed"
}
