/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 5: one frame, from tiles that threads take in turn. The pixels do not depend on the
 *  number of threads, on the size of tiles, or on the skip method. */
#ifndef SEGCAST_RENDER_H
#define SEGCAST_RENDER_H

#include "segcast/image.h"
#include "segcast/kernel.h"

enum { SC_SAMPLES_MAX = 8 };

typedef struct sc_render_settings {
    int width_px, height_px;
    sc_surface surface;
    sc_skip skip;
    const char *cpu; /**< instruction set of the kernels, one of sc_cpu_names; NULL: the best that
                          this processor has */
    int samples;     /**< rays per pixel, 1 to SC_SAMPLES_MAX */
    bool everywhere; /**< take them in every pixel; else one, and those where neighbouring pixels
                          see something else */
    double step_voxels; /**< between samples, in voxel lengths (the smallest spacing) */
    bool caps;
    double cap_outline; /**< width of lines between tissues on cut faces, in voxels; 0: none */
    sc_lighting light;
    bool local_thickness; /**< automatic opacity follows the thickness at each place */
    uint8_t background[3];
    int tile_px;
    int threads;
} sc_render_settings;

typedef struct sc_renderer sc_renderer;

/** What a frame took. */
typedef struct sc_render_stats {
    sc_march_counters counters;
    double wall_s, cpu_s; /**< cpu: of all threads that drew */
} sc_render_stats;

/** @p volume and @p tissues (by dense id) stay borrowed until sc_renderer_free.
 *  @return SC_ERR_MEMORY; SC_ERR_USAGE if the processor has not what settings->cpu names. */
SC_MUST_USE sc_status sc_renderer_new(const sc_ctx *ctx, const sc_render_settings *settings,
                                      const sc_prepared *volume, const sc_tissue *tissues,
                                      sc_renderer **out);
void sc_renderer_free(sc_renderer *renderer);
/** Corners of what is visible, for framing. Borrowed from the renderer. */
const sc_vec3 *sc_renderer_hull(const sc_renderer *renderer, size_t *count);
const sc_kernel *sc_renderer_kernel(const sc_renderer *renderer);

/** A part of a picture. */
typedef struct sc_viewport {
    int x_px, y_px, width_px, height_px;
} sc_viewport;
/** Draw a scene into a part of @p image, which holds it. Threads: as sc_render_frame. */
void sc_render_view(sc_renderer *renderer, const sc_scene *scene, const sc_viewport *viewport,
                    sc_image *image, sc_render_stats *stats);
/** Draw a frame into @p image, which has the size of the settings. Threads: one frame at a time
 *  per renderer. */
void sc_render_frame(sc_renderer *renderer, const sc_scene *scene, sc_image *image,
                     sc_render_stats *stats);

#endif
