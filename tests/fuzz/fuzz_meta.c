/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of the format MetaImage. Beside it lies in.raw. */
#include "volume.h"

FUZZ_VOLUME_TARGET("input.mhd", "in.raw")
