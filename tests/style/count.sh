# SPDX-License-Identifier: BSD-3-Clause
# No module has more lines than its budget, and there are not more keys and commands (tools/budgets).
"$SOURCE/tools/count" | tee counts.txt || fail "a budget is exceeded, or out of date (above): take something out, or say why tools/budgets changes"
! grep -qE ' +0 of ' counts.txt || fail "something was not counted: $(grep -E ' +0 of ' counts.txt)"
