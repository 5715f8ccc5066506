/* SPDX-License-Identifier: BSD-3-Clause */
#include "variants.h"

#include <string.h>

#define KERNEL(surface_name, SURFACE, skip_name, SKIP, bits, cpu_name)                             \
    {                                                                                              \
#surface_name "/" #skip_name "/u" #bits, SC_SURFACE_##SURFACE, SC_SKIP_##SKIP, (bits) / 8, \
            #cpu_name, sc_march_##surface_name##_##skip_name##_u##bits##_##cpu_name                \
    }
#define KERNELS(skip, SKIP, cpu)                                                                   \
    KERNEL(voxel, VOXEL, skip, SKIP, 8, cpu), KERNEL(voxel, VOXEL, skip, SKIP, 16, cpu),           \
        KERNEL(smooth, SMOOTH, skip, SKIP, 8, cpu), KERNEL(smooth, SMOOTH, skip, SKIP, 16, cpu)

/* Of two that do the same, the better stands first. */
static const sc_kernel kernels[] = {
    KERNELS(none, NONE, c),      KERNELS(interior, INTERIOR, c),
#ifdef SC_KERNELS_X86
    KERNELS(leap, LEAP, avx512), KERNELS(leap, LEAP, avx2),      KERNELS(leap, LEAP, sse4),
#endif
    KERNELS(leap, LEAP, c),
};

const char *const sc_cpu_names[] = {"auto", "avx512", "avx2", "sse4", "c", NULL};

bool sc_cpu_has(const char *name)
{
#ifdef SC_KERNELS_X86
    __builtin_cpu_init();
    if (strcmp(name, "avx512") == 0)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    if (strcmp(name, "avx2") == 0)
        return __builtin_cpu_supports("avx2");
    if (strcmp(name, "sse4") == 0)
        return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
#endif
    return strcmp(name, "c") == 0 || strcmp(name, "auto") == 0;
}

const sc_kernel *sc_kernel_all(size_t *count)
{
    *count = SC_COUNT_OF(kernels);
    return kernels;
}

/* Wide kernels reach for bytes by 32-bit offsets. */
static bool fits(const sc_prepared *v)
{
    const uint64_t voxels = (uint64_t)v->size[0] * (uint64_t)v->size[1] * (uint64_t)v->size[2];

    return voxels * (uint64_t)v->label_bytes < INT32_MAX - 8 &&
           v->near_count * SC_RECORD_BYTES < INT32_MAX - 8;
}

const sc_kernel *sc_kernel_find(sc_surface surface, sc_skip skip, const sc_prepared *volume,
                                const char *cpu)
{
    const bool any = skip != SC_SKIP_LEAP || !cpu || strcmp(cpu, "auto") == 0;

    if (skip == SC_SKIP_LEAP && !fits(volume))
        return NULL;
    for (size_t i = 0; i < SC_COUNT_OF(kernels); i++) {
        const sc_kernel *k = &kernels[i];

        if (k->surface == surface && k->skip == skip && k->label_bytes == volume->label_bytes &&
            (any || strcmp(k->cpu, cpu) == 0) && sc_cpu_has(k->cpu))
            return k;
    }
    return NULL;
}
