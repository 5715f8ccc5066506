/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of the format NIfTI. Beside it lies the other file of a pair. */
#include "volume.h"

FUZZ_VOLUME_TARGET("input.hdr", "input.img")
