/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of kernels, and the search in it. */
#include "variants.h"

#include <string.h>

#define KERNEL(surface_name, SURFACE, skip_name, SKIP, cpu_name)                                   \
    {                                                                                              \
#surface_name "/" #skip_name, SC_SURFACE_##SURFACE, SC_SKIP_##SKIP, #cpu_name,             \
            sc_march_##surface_name##_##skip_name##_##cpu_name                                     \
    }
#define KERNELS(skip, SKIP, cpu)                                                                   \
    KERNEL(voxel, VOXEL, skip, SKIP, cpu), KERNEL(smooth, SMOOTH, skip, SKIP, cpu),
#define LEAP_KERNELS(cpu, supported) KERNELS(leap, LEAP, cpu)
#define RIVAL_KERNELS(cpu)                                                                         \
    KERNELS(octree, OCTREE, cpu)                                                                   \
    KERNELS(proximity, PROXIMITY, cpu)                                                             \
    KERNELS(chessboard, CHESSBOARD, cpu)

/* Of two kernels that do the same, the faster one stands first. */
static const sc_kernel kernels[] = {
    /* clang-format off */
    KERNELS(none, NONE, c)
    KERNELS(interior, INTERIOR, c)
    SC_EACH_BUILT_CPU(LEAP_KERNELS)
    SC_EACH_RIVAL_CPU(RIVAL_KERNELS)
    /* clang-format on */
};

#define NAME(cpu) #cpu,
const char *const sc_cpu_names[] = {"auto", SC_EACH_CPU(NAME) NULL};

bool sc_cpu_has(const char *name)
{
#define ANSWER(cpu, supported)                                                                     \
    if (strcmp(name, #cpu) == 0)                                                                   \
        return supported;

    SC_EACH_BUILT_CPU(ANSWER)
    return strcmp(name, "auto") == 0;
}

static bool is_built(const char *name)
{
#define COMPARE(cpu, supported)                                                                    \
    if (strcmp(name, #cpu) == 0)                                                                   \
        return true;

    SC_EACH_BUILT_CPU(COMPARE)
    return false;
}

sc_status sc_cpu_check(const sc_ctx *ctx, const char *name)
{
    if (sc_cpu_has(name))
        return SC_OK;
    if (is_built(name))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "this processor cannot run the kernels for %s; set render.cpu to auto",
                       name);
    return sc_fail(ctx, SC_ERR_USAGE,
                   "this segcast was built without kernels for %s; set render.cpu to auto, or "
                   "build it with that name in SC_VARIANTS",
                   name);
}

const sc_kernel *sc_kernel_all(size_t *count)
{
    *count = SC_COUNT_OF(kernels);
    return kernels;
}

/* Can offsets of 31 bits, which the wide kernels use, reach all masks of the volume, all distances
 * of cells if the skip method has these, and all labels and vertex records if the surface needs
 * them? */
static bool within_reach(sc_surface surface, const sc_prepared *v, sc_skip skip)
{
    const uint64_t voxels = (uint64_t)v->size[0] * (uint64_t)v->size[1] * (uint64_t)v->size[2];
    const uint64_t limit = INT32_MAX - 8;
    int framed[3];
    uint64_t bricks;

    sc_framed_size(v->bricks, framed);
    bricks = sc_brick_count(framed);
    /* With the upper levels of the pyramid there are less than 1 / 32 more. */
    if ((bricks + bricks / 32) * SC_BRICK_MASK_BYTES >= limit ||
        (sc_skip_has_cell_distances(skip) && bricks * SC_BRICK_VERTICES >= limit))
        return false;
    return surface == SC_SURFACE_SMOOTH ||
           (voxels * (uint64_t)v->label_bytes < limit && v->boundary.count < limit &&
            v->outer.count * SC_RECORD_BYTES < limit && v->inner.count * SC_RECORD_BYTES < limit);
}

/* @return where a name stands in sc_cpu_names. */
static int cpu_rank(const char *name)
{
    int rank = 0;

    while (strcmp(sc_cpu_names[rank], name) != 0)
        rank++;
    return rank;
}

const sc_kernel *sc_kernel_find(sc_surface surface, sc_skip skip, const sc_prepared *volume,
                                const char *cpu)
{
    const bool wide = sc_skip_is_wide(skip);

    if (!wide || !cpu)
        cpu = "auto";
    if (!sc_cpu_has(cpu) || (wide && volume && !within_reach(surface, volume, skip)))
        return NULL;
    for (size_t i = 0; i < SC_COUNT_OF(kernels); i++) {
        const sc_kernel *k = &kernels[i];

        if (k->surface == surface && k->skip == skip && sc_cpu_has(k->cpu) &&
            cpu_rank(k->cpu) >= cpu_rank(cpu))
            return k;
    }
    return NULL;
}

sc_gather_fn *sc_gather_find(const char *cpu)
{
    const bool any = !cpu || strcmp(cpu, "auto") == 0;

#define CHOOSE(name, supported)                                                                    \
    if ((any || strcmp(cpu, #name) == 0) && (supported))                                           \
        return sc_gather_wide_##name;

    SC_EACH_BUILT_CPU(CHOOSE)
    return sc_gather_wide_c;
}
