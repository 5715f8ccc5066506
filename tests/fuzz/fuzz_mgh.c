/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of the format MGH. */
#include "volume.h"

FUZZ_VOLUME_TARGET("input.mgh", "unused")
