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
/** Rows [first, end) of a picture, from the top. Its pixels do not depend on what else is drawn. */
typedef struct sc_rows {
    int first, end;
} sc_rows;
/** Draw a scene into a part of @p image, which holds it; of that only @p rows of the image, or all
 *  if NULL. Threads: as sc_render_frame. */
void sc_render_view(sc_renderer *renderer, const sc_scene *scene, const sc_viewport *viewport,
                    const sc_rows *rows, sc_image *image, sc_render_stats *stats);
/** Draw a frame, or rows of it, into @p image, which has the size of the settings. Threads: one
 *  frame at a time per renderer. */
void sc_render_frame(sc_renderer *renderer, const sc_scene *scene, const sc_rows *rows,
                     sc_image *image, sc_render_stats *stats);

/** From when to when a thread drew, by sc_wall_s; both 0 if it did not. */
typedef struct sc_render_span {
    double begin_s, end_s;
} sc_render_span;
/** What the threads did since the last call, to @p out: [threads of the settings]. */
void sc_renderer_spans(sc_renderer *renderer, sc_render_span *out);

#endif
