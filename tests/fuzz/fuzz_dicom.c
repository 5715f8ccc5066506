/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a DICOM segmentation. */
#include "volume.h"

FUZZ_VOLUME_TARGET("input.dcm", "unused")
