# SPDX-License-Identifier: BSD-3-Clause
# As matrix.sh, for a film of shots with verbs, names and colours by values.
FAULT_FILM=1
FAULT_STEP=${FAULT_STEP:-331 2999}
. "$SOURCE/tests/faults/matrix.sh"
