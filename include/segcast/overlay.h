/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Lines and text drawn over a picture. This module is the only user of cairo. Coordinates are in
 *  pixels from the upper left corner of the picture, x to the right, y down; pixel centres lie at
 *  halves. Colours are 8-bit sRGB. */
#ifndef SEGCAST_OVERLAY_H
#define SEGCAST_OVERLAY_H

#include "segcast/image.h"

typedef struct sc_overlay sc_overlay;

/** Begin to draw over @p image, which stays borrowed and unchanged until sc_overlay_finish.
 *  @return SC_ERR_MEMORY. Threads: any, on distinct images. */
SC_MUST_USE sc_status sc_overlay_begin(const sc_ctx *ctx, sc_image *image, sc_overlay **out);
void sc_overlay_line(sc_overlay *overlay, double x0, double y0, double x1, double y1,
                     double width_px, const uint8_t rgb[3], double alpha);
void sc_overlay_frame(sc_overlay *overlay, double x, double y, double width, double height,
                      double width_px, const uint8_t rgb[3]);
/** How letters look. */
typedef struct sc_letters {
    double size_px;
    uint8_t rgb[3];
    uint8_t halo[3]; /**< drawn around them, so that they can be read on anything */
} sc_letters;
/** @p anchor_x: -1 text begins at x, 0 is centred on it, 1 ends there; @p anchor_y alike, for top,
 *  middle and base line. */
void sc_overlay_text(sc_overlay *overlay, double x, double y, int anchor_x, int anchor_y,
                     const sc_letters *letters, const char *text);
/** Blend everything into the picture and free. */
void sc_overlay_finish(sc_overlay *overlay);

#endif
