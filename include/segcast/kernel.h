/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 4: the ray march, as a table of kernels. A kernel allocates nothing, reads no files and
 *  knows neither threads nor MPI. The plain C kernels here are the specification; a variant for a
 *  processor must give the same bits. */
#ifndef SEGCAST_KERNEL_H
#define SEGCAST_KERNEL_H

#include "segcast/scene.h"

typedef enum sc_surface {
    SC_SURFACE_VOXEL, /**< the paper's: samples along the ray take the nearest voxel's label */
    SC_SURFACE_SMOOTH /**< interfaces where the largest of the labels' trilinear votes changes */
} sc_surface;

typedef enum sc_skip {
    SC_SKIP_NONE, /**< every sample or cell is classified from the labels alone (paper: plain) */
    SC_SKIP_INTERIOR, /**< only those marked by preprocessing are (paper: accelerated) */
    SC_SKIP_LEAP      /**< the same, in leaps over empty bricks, many rays side by side */
} sc_skip;

/** A label as the kernel sees it. */
typedef struct sc_march_tissue {
    float rgb[3];         /**< linear light */
    float boundary_alpha; /**< of one crossing (smooth) or one sample (voxel) */
    float interior_alpha; /**< of one sample; voxel only */
    float diffuse, specular;
    int shininess; /**< exponent of the highlight */
    uint8_t show;  /**< SC_SHOW_* */
    uint8_t clip_group;
    bool by_thickness; /**< alpha comes from the local thickness: sc_march.thickness_alpha */
} sc_march_tissue;

/** Light of a frame; directions are unit, RAS, towards the light. */
typedef struct sc_march_light {
    bool flat; /**< no light at all: plain colours */
    float key_direction[3], fill_direction[3];
    float ambient, key, fill, head;
    float edges;     /**< 0 to 1: how much opacity grows where a surface is seen from the side */
    float occlusion; /**< 0 to 1: how dark what is enclosed by tissue gets */
    float shadow;    /**< 0 or 1 */
    float cue;       /**< 0 to 1: how much of the background mixes in at cue_far_mm */
    float cue_near_mm, cue_far_mm, cue_rgb[3];
} sc_march_light;

/** What all rays of a frame share; everything is borrowed. */
typedef struct sc_march {
    const sc_prepared *volume;
    const uint64_t *visible;        /**< sc_visible_masks or, smooth, sc_visible_cells; not read by
                                         SC_SKIP_NONE */
    int visible_row, visible_layer; /**< masks from one brick to the next along y and z */
    const uint8_t *distances;       /**< sc_brick_distances of the masks; SC_SKIP_LEAP only */
    const uint32_t *cell_start;     /**< sc_cells of the masks; smooth and SC_SKIP_LEAP only */
    const uint64_t *cells;
    float box_low[3], box_high[3];  /**< in places: rays are marched within this box alone, which
                                         holds all that can be seen and reaches no more than 3 places
                                         beyond those of the volume */
    const sc_march_tissue *tissues; /**< by dense id */
    float step_mm;                  /**< voxel only */
    sc_march_light light;
    const sc_occlusion *occlusion; /**< NULL: none */
    float thickness_alpha[256];    /**< by code of sc_prepared.thickness */
    float place_per_mm[3][3];      /**< RAS vector -> places */
    bool caps;                     /**< cut faces are solid */
    bool only_caps;                /**< nothing but cut faces: a slice */
    float cap_outline;             /**< half width of the lines between tissues on cut faces, in
                                        voxels; 0: none; smooth only */
    bool cut_away;                 /**< planes remove only what all of them remove */
    int plane_count;
    float plane_normals[SC_PLANES_MAX][3]; /**< RAS, towards what is kept */
    float plane_places[SC_PLANES_MAX][4];  /**< distance in mm as a function of the place */
} sc_march;

/** A part of a ray that is kept: from where to where, in mm from the origin, and which samples;
 *  sample k of the voxel surface lies at (k + 1/2) step_mm, and those with first <= k < last are
 *  kept. */
typedef struct sc_ray_part {
    float begin_mm, end_mm;
    int32_t first, last; /**< voxel only */
    int8_t cap_plane;    /**< the clip plane it begins at; -1: none */
} sc_ray_part;

/** One ray. */
typedef struct sc_ray {
    float origin[3];     /**< voxel surface: in places plus 1/2, so that truncation is rounding;
                              smooth: in places (voxel + 1) */
    float direction[3];  /**< voxels per mm */
    float toward_eye[3]; /**< unit, RAS */
    float base_mm;       /**< distance of the origin from the eye */
    uint8_t groups;      /**< clip groups */
    uint8_t part_count[SC_CLIP_SETS_MAX];
    sc_ray_part parts[SC_CLIP_SETS_MAX][2]; /**< by clip group, in order along the ray */
} sc_ray;

/** Light that comes along a ray (premultiplied, linear), the share of what is behind, and what
 *  was met, by which neighbouring rays are compared. */
typedef struct sc_radiance {
    float rgb[3], transmittance;
    float depth_mm;     /**< of the first surface, from the eye; HUGE_VALF: none */
    float normal[3];    /**< of the first surface, unit, RAS, towards the eye */
    uint32_t label;     /**< dense id of the tissue seen first; 0: none */
    uint32_t signature; /**< of all tissues that matter, in their order */
} sc_radiance;

/** Counts that depend on the work alone, not on threads or time. */
typedef struct sc_march_counters {
    uint64_t rays;          /**< that met the volume */
    uint64_t samples;       /**< samples or cells looked at */
    uint64_t leaps;         /**< over empty bricks; SC_SKIP_LEAP only */
    uint64_t contributions; /**< samples, crossings and caps that added colour */
} sc_march_counters;

static inline void sc_add_counters(sc_march_counters *to, const sc_march_counters *from)
{
    to->rays += from->rays;
    to->samples += from->samples;
    to->leaps += from->leaps;
    to->contributions += from->contributions;
}

/** March @p count rays. @param out [count]. Adds to @p counters. Threads: any. */
typedef void sc_march_fn(const sc_march *march, const sc_ray *rays, size_t count, sc_radiance *out,
                         sc_march_counters *counters);

typedef struct sc_kernel {
    const char *name;
    sc_surface surface;
    sc_skip skip;
    int label_bytes;
    const char *cpu; /**< instruction set: one of sc_cpu_names */
    sc_march_fn *march;
} sc_kernel;

/** Names of instruction sets: "auto", the best that this processor has, then all there are
 *  kernels for on some processor, the best first and plain C, "c", last. NULL ends the list. */
extern const char *const sc_cpu_names[];
/** Can this processor run them? */
bool sc_cpu_has(const char *name);
/** The kernel for a job. SC_SKIP_NONE and SC_SKIP_INTERIOR are there in plain C alone.
 *  @param cpu one of sc_cpu_names; NULL is "auto".
 *  @return NULL if this processor cannot run it, or the volume is too large for it: kernels of
 *  SC_SKIP_LEAP count in 31 bits. */
const sc_kernel *sc_kernel_find(sc_surface surface, sc_skip skip, const sc_prepared *volume,
                                const char *cpu);
/** The label that owns a point, by the largest vote: the rule of the smooth surface.
 *  @param place point in places (voxel + 1). @return dense id; background outside. */
uint32_t sc_kernel_owner(const sc_prepared *volume, const float place[3]);
/** All kernels, for tests and listings. */
const sc_kernel *sc_kernel_all(size_t *count);

#endif
