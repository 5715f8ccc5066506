/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The three regular views (paper, figure 3): transverse, coronal and sagittal slices
 *  beside the picture in space, in the same colours, in radiological convention (the patient's
 *  right on the left of the picture). */
#ifndef SEGCAST_VIEWS_H
#define SEGCAST_VIEWS_H

#include "segcast/overlay.h"
#include "segcast/render.h"

/** What the slices show. Positions are patient coordinates (RAS) in millimetres. */
typedef struct sc_views {
    sc_vec3 low_mm, high_mm; /**< the box that fits into every slice */
    bool oriented; /**< false: it is unknown which side is left, so no letters are drawn */
} sc_views;

/** @return where the panel of the picture in space lies, in a picture of the given size. */
sc_viewport sc_views_space(int width_px, int height_px);
/** @return width divided by height of the panel that holds the picture in space, in a picture of
 * the given size. */
double sc_views_aspect(int width_px, int height_px);
/** @return the scene of a slice alone in a picture of that size. @param which 0: transverse, 1:
 *  coronal, 2: sagittal. @param scene as of sc_views_draw. */
sc_scene sc_views_slice(const sc_views *views, int which, const int size_px[2],
                        const sc_scene *scene);
/** Draw all four panels into @p image, slices with lines and text over them. @param scene of the
 *  picture in space, for a picture of sc_views_aspect; all three slices go through its point.
 * @param rows the rows of @p image that are needed, or NULL for all; other rows are unspecified.
 * @param stats receives the sum over the panels; untouched after an error. Threads: one call at a
 * time per renderer. @return SC_ERR_MEMORY; @p image is unspecified then. */
SC_MUST_USE sc_status sc_views_draw(const sc_ctx *ctx, sc_renderer *renderer, const sc_views *views,
                                    const sc_scene *scene, const sc_rows *rows, sc_image *image,
                                    sc_render_stats *stats);

/** Find where @p count pictures of one size stand side by side in a picture of @p size_px (width,
 *  height), in so many columns and as many rows as it takes; those of a last row that is not full
 *  stand in its middle. @param below_px height that stays free below each of them. @param out
 *  [count]: the pictures, in reading order, as large as can be; at least one pixel wide and high.
 */
void sc_place_panels(const int size_px[2], int count, int columns, int below_px, sc_viewport *out);

#endif
