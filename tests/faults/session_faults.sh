# SPDX-License-Identifier: BSD-3-Clause
# As matrix.sh, for memory that one of two ranks lacks while they share tissues, colours and the volume: a rank that
# leaves without the other would let it wait for ever.
FAULT_KINDS=alloc
FAULT_RANKS=2
FAULT_STEP=${FAULT_STEP:-1}
FAULT_FUNCTION=sc_session_tissues
. "$SOURCE/tests/faults/matrix.sh"
