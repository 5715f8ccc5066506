/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of the format TIFF. */
#include "volume.h"

FUZZ_VOLUME_TARGET("input.tif", "unused")
