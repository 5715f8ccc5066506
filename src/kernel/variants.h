/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the functions that the templates are compiled into. */
#ifndef SC_KERNEL_VARIANTS_H
#define SC_KERNEL_VARIANTS_H

#include "segcast/kernel.h"

#include "cpus.h"

#define SC_DECLARE_KERNELS(skip, cpu)                                                              \
    sc_march_fn sc_march_voxel_##skip##_##cpu, sc_march_smooth_##skip##_##cpu;
#define SC_DECLARE_LEAP_KERNELS(cpu, supported) SC_DECLARE_KERNELS(leap, cpu)
#define SC_DECLARE_RIVAL_KERNELS(cpu)                                                              \
    SC_DECLARE_KERNELS(octree, cpu)                                                                \
    SC_DECLARE_KERNELS(proximity, cpu)                                                             \
    SC_DECLARE_KERNELS(chessboard, cpu)

#define SC_DECLARE_BACKDROP(cpu, supported) sc_backdrop_fn sc_backdrop_wide_##cpu;
#define SC_DECLARE_GATHER(cpu, supported) sc_gather_fn sc_gather_wide_##cpu;

SC_DECLARE_KERNELS(none, c)
SC_DECLARE_KERNELS(interior, c)
SC_EACH_BUILT_CPU(SC_DECLARE_LEAP_KERNELS)
SC_EACH_RIVAL_CPU(SC_DECLARE_RIVAL_KERNELS)
SC_EACH_BUILT_CPU(SC_DECLARE_BACKDROP)
SC_EACH_BUILT_CPU(SC_DECLARE_GATHER)

#endif
