# SPDX-License-Identifier: BSD-3-Clause
# As resume.sh, for each fsync and rename with which a manifest is replaced: a run that cannot flush the one that it
# has put in place must not take it for that of another run.
FAULT_RESUME=1
FAULT_RANKS=1
FAULT_STEP=${FAULT_STEP:-1}
FAULT_DISTINCT=0
FAULT_KINDS=${FAULT_KINDS:-sync rename}
FAULT_FUNCTION=sc_manifest_create
. "$SOURCE/tests/faults/matrix.sh"
