/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: what the templates are compiled into. */
#ifndef SC_KERNEL_VARIANTS_H
#define SC_KERNEL_VARIANTS_H

#include "segcast/kernel.h"

#define SC_DECLARE_KERNELS(skip, cpu)                                                              \
    sc_march_fn sc_march_voxel_##skip##_u8_##cpu, sc_march_voxel_##skip##_u16_##cpu,               \
        sc_march_smooth_##skip##_u8_##cpu, sc_march_smooth_##skip##_u16_##cpu

SC_DECLARE_KERNELS(none, c);
SC_DECLARE_KERNELS(interior, c);
SC_DECLARE_KERNELS(leap, c);
#ifdef SC_KERNELS_X86
SC_DECLARE_KERNELS(leap, sse4);
SC_DECLARE_KERNELS(leap, avx2);
SC_DECLARE_KERNELS(leap, avx512);
#endif

#endif
