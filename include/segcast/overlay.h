/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Lines and text drawn over a picture. This module is the only user of cairo. Coordinates are in
 *  pixels from the upper left corner of the picture, x to the right, y down; pixel centres lie at
 *  halves. Colours are 8-bit sRGB. */
#ifndef SEGCAST_OVERLAY_H
#define SEGCAST_OVERLAY_H

#include "segcast/image.h"

typedef struct sc_overlay sc_overlay;

/** Begin to draw over @p image, which is borrowed and does not change until sc_overlay_finish.
 *  Threads: any, on distinct images. @return SC_ERR_MEMORY. Caller owns: sc_overlay_finish. */
SC_MUST_USE sc_status sc_overlay_begin(const sc_ctx *ctx, sc_image *image, sc_overlay **out);
/** Draw a line from (x0, y0) to (x1, y1). @param alpha opacity in [0, 1]. */
void sc_overlay_line(sc_overlay *overlay, double x0, double y0, double x1, double y1,
                     double width_px, const uint8_t rgb[3], double alpha);
/** Draw the outline of a rectangle, whose upper left corner is (x, y). */
void sc_overlay_frame(sc_overlay *overlay, double x, double y, double width, double height,
                      double width_px, const uint8_t rgb[3]);
/** Size and colours of text. */
typedef struct sc_letters {
    double size_px;
    uint8_t rgb[3];
    uint8_t halo[3]; /**< colour around the letters, so that they can be read on any background */
} sc_letters;
/** Draw one line of text.
 *  @param anchor_x -1: the text begins at @p x; 0: it is centred on it; 1: it ends there.
 *  @param anchor_y -1: the top of capitals is at @p y; 0: their middle; 1: their base line. */
void sc_overlay_text(sc_overlay *overlay, double x, double y, int anchor_x, int anchor_y,
                     const sc_letters *letters, const char *text);
/** Blend what was drawn into the picture and free the overlay. */
void sc_overlay_finish(sc_overlay *overlay);

#endif
