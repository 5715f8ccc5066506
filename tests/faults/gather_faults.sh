# SPDX-License-Identifier: BSD-3-Clause
# As matrix.sh, for calls of two ranks of which one gathers and encodes GOPs.
FAULT_ENCODE=gather
FAULT_FRAMES=7
FAULT_RANKS=2
FAULT_STEP=${FAULT_STEP:-293}
. "$SOURCE/tests/faults/matrix.sh"
