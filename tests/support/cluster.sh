# shellcheck shell=bash
# For tests under a real Slurm of several virtual hosts on this machine; the script that starts it
# is not part of the project: -DSC_SLURM_CLUSTER=... Reasons to skip are told.
[ -x "${SLURM_CLUSTER:-}" ] || skip "no script that starts a Slurm cluster (SC_SLURM_CLUSTER)"
[ "$(id -u)" = 0 ] || skip "a Slurm of virtual hosts needs root"
unshare --mount --pid --net --ipc --uts --fork true 2>/dev/null || skip "namespaces are not permitted here"
"$SLURM_CLUSTER" install >install.txt 2>&1 || skip "Slurm cannot be installed here: $(tail -1 install.txt)"
export SLURM_CLUSTER_DIR=$PWD/cluster SLURM_CLUSTER_SUBNET=10.$((RANDOM % 100 + 100)).$((RANDOM % 200))
trap '"$SLURM_CLUSTER" down >/dev/null 2>&1 || true' EXIT
"$SLURM_CLUSTER" up "${HOSTS:-2}" >up.txt 2>&1 || skip "no Slurm of virtual hosts here: $(tail -1 up.txt)"

on_head() { "$SLURM_CLUSTER" exec head "$@"; }
# The binary under the name that the batch scripts use.
mkdir -p bin
ln -sf "$SEGCAST" bin/segcast
export PATH=$PWD/bin:$PATH
SMALL=(--nodes=2 --ntasks-per-node=1 --cpus-per-task=1)

# a_job SECONDS: job.yaml, which takes about so long on this machine's cores together, and ref/, what
# it makes without any accident.
a_job() {
    local frames
    small_job job.yaml
    sed -i 's/size: \[96, 72\], video: none/size: [640, 480], fps: 5, frames: png, video: film.mp4/' job.yaml
    "$SEGCAST" render job.yaml -o trial -q --threads 2 >/dev/null
    frames=$(jq "(7 / (.phases.render.wall_s + .phases.encode.wall_s + .phases.write.wall_s) * $1 | floor) + 7" trial/stats.json)
    sed -i "s/frames: 7/frames: $frames/" job.yaml
    "$SEGCAST" render job.yaml -o ref -q --threads 2 >/dev/null
}

# submit [OPTION...]: sets $id.
submit() { id=$(on_head sbatch --parsable "$@"); }

# state: of the job, e.g. RUNNING.
state() { on_head scontrol show job "$id" | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p' | sort -u; }

# wait_for SECONDS WHAT COMMAND...: until the command succeeds.
wait_for() {
    local limit=$1 what=$2
    shift 2
    for _ in $(seq $((limit * 5))); do
        "$@" && return
        sleep 0.2
    done
    cat ./*.log >&2 || true
    on_head scontrol show job "$id" >&2 || true
    fail "$what: not within $limit s"
}
has_ended() { [[ $(state) =~ ^(COMPLETED|FAILED|TIMEOUT|CANCELLED|NODE_FAIL)$ ]]; }
has_frames() { [ "$(cat out/manifest*.jsonl 2>/dev/null | grep -c '"frame"')" -ge "$1" ]; }

# same_as_ref: out holds, byte for byte, what an undisturbed run makes, and proves it.
same_as_ref() {
    [ "$(hashes out)" = "$(hashes ref)" ] || fail "other frames than undisturbed"
    cmp out/film.mp4 ref/film.mp4 || fail "another video than undisturbed"
    diff -r out/frames ref/frames || fail "other PNG files than undisturbed"
    "$SEGCAST" verify out >/dev/null || fail "verify"
    [ ! -e out/segments ] || fail "segments are left"
}
