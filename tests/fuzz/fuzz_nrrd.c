/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of the format NRRD. Beside it lie files for one name and for a pattern. */
#include "volume.h"

FUZZ_VOLUME_TARGET("input.nhdr", "in.raw", "in01.raw", "in02.raw")
