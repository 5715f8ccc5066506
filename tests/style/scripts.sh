# SPDX-License-Identifier: BSD-3-Clause
# shellcheck finds nothing in the shell scripts; batch scripts are short and documented, and what is the same
# in all of them is the same.
command -v shellcheck >/dev/null || skip "shellcheck is not installed"
cd "$SOURCE"
shellcheck jobs/slurm/*.sbatch jobs/studies/*.sbatch jobs/pbs/*.pbs || fail "shellcheck found the problems above"
shellcheck -e SC1091,SC2154 tools/test tools/count tools/demo tools/soak tools/faults tools/fuzz tools/common || fail "shellcheck found the problems above"
while IFS= read -r script; do
    sed -n 1,2p "$script" | grep -qx '# SPDX-License-Identifier: BSD-3-Clause' ||
        fail "$script: neither line 1 nor line 2 is the licence: # SPDX-License-Identifier: BSD-3-Clause"
done < <(find cmake jobs src tests tools CMakeLists.txt -type f \( -name '*.sh' -o -name '*.py' -o -name '*.cmake' \
    -o -name CMakeLists.txt -o -name '*.sbatch' -o -name '*.pbs' -o -path 'tools/*' ! -name 'packages*' \))
for script in jobs/slurm/*.sbatch jobs/studies/*.sbatch jobs/pbs/*.pbs; do
    [ "$(wc -l <"$script")" -le 94 ] || fail "$script has more than 94 lines"
    grep -q "$(basename "$script")" docs/cluster.md || fail "$script is not named in docs/cluster.md"
    grep -q '^# ---- Your site' "$script" || fail "$script has no block for the site"
done
# block TITLE SCRIPT: print the block of a script that begins with this title.
block() { awk -v title="# ---- $1" '/^# ----/ {inside = index($0, title)} inside' "$2"; }
for script in jobs/slurm/*.sbatch jobs/studies/*.sbatch; do
    [ "$(block "The same in all scripts: " "$script")" = "$(block "The same in all scripts: " jobs/slurm/requeue.sbatch)" ] ||
        fail "the block \"The same in all scripts\" of $script differs from that of requeue.sbatch"
done
# same_block TITLE SCRIPT...: the block is the same in all of these scripts.
same_block() {
    local title=$1 first=$2 script
    shift
    for script; do
        [ "$(block "$title" "$script")" = "$(block "$title" "$first")" ] ||
            fail "the block \"$title\" of $script differs from that of $first"
    done
}
same_block "The same in all scripts that draw" jobs/slurm/*.sbatch
same_block "The same in all scripts of studies" jobs/studies/*.sbatch
for script in jobs/studies/*.sbatch; do
    grep -qx "study=$(basename "$script" .sbatch)" "$script" || fail "$script measures another study"
    [ -f "${script%.sbatch}.yaml" ] || fail "$script has no study file beside it"
done
