# shellcheck finds nothing in the shell scripts; batch scripts are short and documented.
command -v shellcheck >/dev/null || skip "shellcheck is not installed"
cd "$SOURCE"
shellcheck jobs/slurm/*.sbatch jobs/pbs/*.pbs || fail "shellcheck found the problems above"
shellcheck -e SC1091,SC2154 tools/test tools/demo tools/soak tools/common || fail "shellcheck found the problems above"
for script in jobs/slurm/*.sbatch jobs/pbs/*.pbs; do
    [ "$(wc -l <"$script")" -le 40 ] || fail "$script has more than 40 lines"
    grep -q "$(basename "$script")" docs/cluster.md || fail "$script is not named in docs/cluster.md"
done
