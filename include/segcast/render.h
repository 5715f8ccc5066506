/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Draws frames: a frame is divided into tiles, which threads claim one after the other. The pixels
 * do not depend on the number of threads, on the size of tiles, on the skip method, or on the
 * variant of the kernels. */
#ifndef SEGCAST_RENDER_H
#define SEGCAST_RENDER_H

#include "segcast/image.h"
#include "segcast/kernel.h"

enum { SC_SAMPLES_MAX = 8 };

/** What all frames of a renderer share. */
typedef struct sc_render_settings {
    int width_px, height_px;
    sc_surface surface;
    sc_skip skip;
    const char *cpu; /**< variant of the kernels, one of sc_cpu_names; NULL: the best that this
                          processor can run */
    int samples;     /**< rays in a pixel that gets more than one, 1 to SC_SAMPLES_MAX */
    bool everywhere; /**< true: every pixel gets that many rays; false: only pixels that differ from
                          a neighbour do, all others one */
    double step_voxels; /**< distance between samples, in voxel lengths (the smallest spacing);
                             voxel surface only */
    bool caps;          /**< cut faces are drawn solid */
    double cap_outline; /**< width of lines between tissues on cut faces, in voxels; 0: none */
    sc_lighting light;
    bool
        local_thickness; /**< automatic opacity follows the local thickness, not the label's mean */
    uint8_t background[3]; /**< sRGB */
    int tile_px;           /**< edge of a tile */
    int threads;
} sc_render_settings;

/** Draws frames of one volume with one set of tissues and settings. */
typedef struct sc_renderer sc_renderer;

/** The work and the time that a frame took. */
typedef struct sc_render_stats {
    sc_march_counters counters;
    double wall_s, cpu_s; /**< cpu: of all threads that drew */
} sc_render_stats;

/** @param volume stays borrowed until sc_renderer_free. @param tissues by dense id; copied.
 *  @return SC_ERR_MEMORY; SC_ERR_DATA if the volume's geometry is singular; SC_ERR_USAGE if this
 *  processor cannot run the variant settings->cpu. @p out is written only on success. */
SC_MUST_USE sc_status sc_renderer_new(const sc_ctx *ctx, const sc_render_settings *settings,
                                      const sc_prepared *volume, const sc_tissue *tissues,
                                      sc_renderer **out);
void sc_renderer_free(sc_renderer *renderer);
/** Points in mm among which are all corners of the convex hull of what is visible; for framing.
 * They stay owned by the renderer. */
const sc_vec3 *sc_renderer_hull(const sc_renderer *renderer, size_t *count);
/** The kernel that the renderer uses. */
const sc_kernel *sc_renderer_kernel(const sc_renderer *renderer);
/** Bytes of memory that the renderer holds beside the prepared volume: what every rank has for
 *  itself. */
size_t sc_renderer_bytes(const sc_renderer *renderer);

/** A rectangle of a picture, from its upper left corner. */
typedef struct sc_viewport {
    int x_px, y_px, width_px, height_px;
} sc_viewport;
/** Rows [first, end) of a picture, from the top. */
typedef struct sc_rows {
    int first, end;
} sc_rows;
/** Draw a scene into @p viewport, a rectangle within @p image. @param rows of the image, outside of
 *  which nothing is drawn; NULL: all rows. A pixel does not depend on which others are drawn.
 * Threads: as sc_render_frame. */
void sc_render_view(sc_renderer *renderer, const sc_scene *scene, const sc_viewport *viewport,
                    const sc_rows *rows, sc_image *image, sc_render_stats *stats);
/** Draw a frame, or @p rows of it (NULL: all), into @p image, which has the size of the settings.
 *  Threads: a renderer draws one frame at a time, on the threads of its settings. */
void sc_render_frame(sc_renderer *renderer, const sc_scene *scene, const sc_rows *rows,
                     sc_image *image, sc_render_stats *stats);

/** When a thread began and ended to draw, by sc_wall_s(); both 0 if it did not draw. */
typedef struct sc_render_span {
    double begin_s, end_s;
} sc_render_span;
/** When each thread drew since the last call of this function. @param out [threads of the
 * settings]. */
void sc_renderer_spans(sc_renderer *renderer, sc_render_span *out);

#endif
