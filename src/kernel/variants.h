/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: what the templates are compiled into. */
#ifndef SC_KERNEL_VARIANTS_H
#define SC_KERNEL_VARIANTS_H

#include "segcast/kernel.h"

sc_march_fn sc_march_voxel_none_u8_c, sc_march_voxel_none_u16_c;
sc_march_fn sc_march_voxel_interior_u8_c, sc_march_voxel_interior_u16_c;
sc_march_fn sc_march_smooth_none_u8_c, sc_march_smooth_none_u16_c;
sc_march_fn sc_march_smooth_interior_u8_c, sc_march_smooth_interior_u16_c;

#endif
