# SPDX-License-Identifier: BSD-3-Clause
# Hosts lose their power under a job and come back, SC_HOST_KILLS times (tools/soak hosts: 20): each job ends
# COMPLETED with the bytes of an undisturbed run, or FAILED with a message, but never COMPLETED without all frames.
kills=${SC_HOST_KILLS:-2}
RANDOM=${SOAK_SEED:-1}
. "$SOURCE/tests/support/cluster.sh"
make_job 8
killed=0
jobs=0
completed=0
told=0

# kill_host: at a random moment of the job, a random host is killed and started again.
kill_host() {
    local host=n$((RANDOM % 2 + 1)) frames=$((RANDOM % 12 + 1))
    [ $jobs = 1 ] && host=n2 # the host of the batch script has its turn in the second job
    [ $jobs = 2 ] && host=n1
    frames=$((frames + $(cat out/manifest*.jsonl 2>/dev/null | grep -c '"frame"' || true)))
    drawn_or_ended() { has_frames $frames || has_ended; }
    wait_for 240 "$frames frames" drawn_or_ended
    has_ended && return
    "$SLURM_CLUSTER" kill-node $host >/dev/null
    sleep $((RANDOM % 4)).$((RANDOM % 10))
    "$SLURM_CLUSTER" start-node $host >/dev/null
    killed=$((killed + 1))
    echo "job $jobs: $host killed and restarted after $frames frames"
}

while [ $killed -lt "$kills" ]; do
    jobs=$((jobs + 1))
    rm -rf out
    submit "${SMALL[@]}" -o "job.$jobs.log" "$SOURCE/jobs/slurm/requeue.sbatch" job.yaml -o out
    kill_host
    [ $((RANDOM % 3)) != 0 ] || [ $killed -ge "$kills" ] || kill_host
    wait_for 400 "the end of the job" has_ended
    case $(state) in
    COMPLETED)
        same_as_ref
        completed=$((completed + 1))
        ;;
    FAILED)
        grep -q '^FAILED: ' "job.$jobs.log" || { cat "job.$jobs.log" >&2; fail "job $jobs failed without a message"; }
        told=$((told + 1))
        ;;
    *) fail "state $(state) of job $jobs" ;;
    esac
    echo "job $jobs: $(state)"
    mv "job.$jobs.log" "job.$jobs.txt" # so that only the log of the present job is shown
    [ $jobs -lt $((2 * kills + 5)) ] || fail "the jobs end before a host can be killed"
done
echo "$killed hosts killed and restarted under $jobs jobs: $completed complete and identical, $told failed and told"
