# SPDX-License-Identifier: BSD-3-Clause
# As matrix.sh, for calls of a run with --resume that continues one that was killed half way.
FAULT_RESUME=1
FAULT_RANKS=1
FAULT_STEP=${FAULT_STEP:-35}
. "$SOURCE/tests/faults/matrix.sh"
