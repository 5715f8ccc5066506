/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 4: the ray march, as a table of kernels. A kernel allocates nothing, reads no files and
 *  knows neither threads nor MPI. The plain C kernels here are the specification; a variant for a
 *  processor must give the same bits. */
#ifndef SEGCAST_KERNEL_H
#define SEGCAST_KERNEL_H

#include "segcast/scene.h"

typedef enum sc_surface { SC_SURFACE_VOXEL } sc_surface;

typedef enum sc_skip {
    SC_SKIP_NONE,    /**< every sample is classified from the labels alone (paper: plain) */
    SC_SKIP_INTERIOR /**< only voxels marked by preprocessing are (paper: accelerated) */
} sc_skip;

/** A label as the kernel sees it. */
typedef struct sc_march_tissue {
    float rgb[3];         /**< linear light */
    float boundary_alpha; /**< of one sample: 1 - (1 - opacity)^(step / voxel length) */
    float interior_alpha;
    uint8_t show; /**< SC_SHOW_* */
    uint8_t clip_group;
} sc_march_tissue;

/** What all rays of a frame share; everything is borrowed. */
typedef struct sc_march {
    const sc_prepared *volume;
    const uint64_t *visible;        /**< sc_visible_masks; not read by SC_SKIP_NONE */
    int visible_row, visible_layer; /**< masks from one brick to the next along y and z */
    const sc_march_tissue *tissues; /**< by dense id */
    float step_mm;
    float key_light[3]; /**< unit, RAS, towards the light */
    bool caps;          /**< cut faces are solid */
    float plane_normals[SC_PLANES_MAX][3];
} sc_march;

/** One ray. Sample k lies at (k + 1/2) step_mm from the origin. For each clip group, the samples
 *  to be taken are first[g][i] <= k < last[g][i], i < parts[g]; a part that begins at a plane has
 *  cap_plane >= 0 and its cut face at cap_mm. */
typedef struct sc_ray {
    float origin[3];     /**< in voxels, plus 1.5: truncation is then rounding, plus 1 */
    float direction[3];  /**< voxels per mm */
    float toward_eye[3]; /**< unit, RAS */
    uint8_t groups;
    uint8_t parts[SC_GROUPS_MAX];
    int32_t first[SC_GROUPS_MAX][2], last[SC_GROUPS_MAX][2];
    float cap_mm[SC_GROUPS_MAX][2];
    int8_t cap_plane[SC_GROUPS_MAX][2];
} sc_ray;

/** Light that comes along a ray (premultiplied, linear) and the share of what is behind. */
typedef struct sc_radiance {
    float rgb[3], transmittance;
} sc_radiance;

/** Counts that depend on the work alone, not on threads or time. */
typedef struct sc_march_counters {
    uint64_t rays;          /**< that met the volume */
    uint64_t samples;       /**< looked at */
    uint64_t contributions; /**< samples and caps that added colour */
} sc_march_counters;

/** March @p count rays. @param out [count]. Adds to @p counters. Threads: any. */
typedef void sc_march_fn(const sc_march *march, const sc_ray *rays, size_t count, sc_radiance *out,
                         sc_march_counters *counters);

typedef struct sc_kernel {
    const char *name;
    sc_surface surface;
    sc_skip skip;
    int label_bytes;
    const char *cpu; /**< instruction set, "c" for plain C */
    sc_march_fn *march;
} sc_kernel;

/** The kernel for a job; never NULL for valid arguments. */
const sc_kernel *sc_kernel_find(sc_surface surface, sc_skip skip, int label_bytes);
/** All kernels, for tests and listings. */
const sc_kernel *sc_kernel_all(size_t *count);

#endif
