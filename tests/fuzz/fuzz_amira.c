/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of AmiraMesh. */
#include "volume.h"

FUZZ_VOLUME_TARGET("input.am", "in.raw")
