/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The three regular views (paper, figure 3): transverse, coronal and sagittal slices
 *  beside the picture in space, in the same colours, in radiological convention (the patient's
 *  right on the left of the picture). */
#ifndef SEGCAST_VIEWS_H
#define SEGCAST_VIEWS_H

#include "segcast/overlay.h"
#include "segcast/render.h"

/** Where the slices go through and what they show. */
typedef struct sc_views {
    sc_vec3 point_mm;
    sc_vec3 low_mm, high_mm; /**< box that the slices show, RAS */
    bool oriented;           /**< false: no letters, since nobody knows where left is */
    uint8_t background[3];
} sc_views;

/** Width by height of the panel with the picture in space, of a picture of the given size. */
double sc_views_aspect(int width_px, int height_px);
/** Draw all four panels into @p image; only @p rows of it are right, or all if NULL. @p scene is
 *  that of the picture in space. @return SC_ERR_MEMORY. Threads: one at a time per renderer. */
SC_MUST_USE sc_status sc_views_draw(const sc_ctx *ctx, sc_renderer *renderer, const sc_views *views,
                                    const sc_scene *scene, const sc_rows *rows, sc_image *image,
                                    sc_render_stats *stats);

#endif
