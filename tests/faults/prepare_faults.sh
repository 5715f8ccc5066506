# SPDX-License-Identifier: BSD-3-Clause
# As matrix.sh, for calls of two ranks while they prepare the volume together: if that fails, rank 0 does it alone.
FAULT_FUNCTION=sc_prepare
FAULT_KINDS=alloc
FAULT_RANKS=2
FAULT_STEP=${FAULT_STEP:-3}
. "$SOURCE/tests/faults/matrix.sh"
