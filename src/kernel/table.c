/* SPDX-License-Identifier: BSD-3-Clause */
#include "variants.h"

static const sc_kernel kernels[] = {
    {"voxel/none/u8", SC_SURFACE_VOXEL, SC_SKIP_NONE, 1, "c", sc_march_voxel_none_u8_c},
    {"voxel/none/u16", SC_SURFACE_VOXEL, SC_SKIP_NONE, 2, "c", sc_march_voxel_none_u16_c},
    {"voxel/interior/u8", SC_SURFACE_VOXEL, SC_SKIP_INTERIOR, 1, "c", sc_march_voxel_interior_u8_c},
    {"voxel/interior/u16", SC_SURFACE_VOXEL, SC_SKIP_INTERIOR, 2, "c",
     sc_march_voxel_interior_u16_c},
    {"smooth/none/u8", SC_SURFACE_SMOOTH, SC_SKIP_NONE, 1, "c", sc_march_smooth_none_u8_c},
    {"smooth/none/u16", SC_SURFACE_SMOOTH, SC_SKIP_NONE, 2, "c", sc_march_smooth_none_u16_c},
    {"smooth/interior/u8", SC_SURFACE_SMOOTH, SC_SKIP_INTERIOR, 1, "c",
     sc_march_smooth_interior_u8_c},
    {"smooth/interior/u16", SC_SURFACE_SMOOTH, SC_SKIP_INTERIOR, 2, "c",
     sc_march_smooth_interior_u16_c},
};

const sc_kernel *sc_kernel_all(size_t *count)
{
    *count = SC_COUNT_OF(kernels);
    return kernels;
}

const sc_kernel *sc_kernel_find(sc_surface surface, sc_skip skip, int label_bytes)
{
    for (size_t i = 0; i < SC_COUNT_OF(kernels); i++) {
        if (kernels[i].surface == surface && kernels[i].skip == skip &&
            kernels[i].label_bytes == label_bytes)
            return &kernels[i];
    }
    return NULL;
}
