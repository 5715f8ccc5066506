# Shell scripts of the project hold what shellcheck asks for.
command -v shellcheck >/dev/null || skip "no shellcheck"
cd "$SOURCE"
shellcheck jobs/slurm/*.sbatch jobs/pbs/*.pbs || fail "shellcheck"
shellcheck -e SC1091,SC2154 tools/test tools/demo tools/soak tools/common || fail "shellcheck"
for script in jobs/slurm/*.sbatch jobs/pbs/*.pbs; do
    [ "$(wc -l <"$script")" -le 40 ] || fail "$script is not short"
    grep -q "$(basename "$script")" docs/cluster.md || fail "$script is not in docs/cluster.md"
done
