/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Lines and text drawn over a picture. This module is the only user of cairo. Coordinates are in
 *  pixels from the upper left corner of the picture, x to the right, y down; pixel centres lie at
 *  halves. Colours are 8-bit sRGB. */
#ifndef SEGCAST_OVERLAY_H
#define SEGCAST_OVERLAY_H

#include "segcast/image.h"

/** What is drawn over one picture, until it is blended into it. */
typedef struct sc_overlay sc_overlay;

/** Begin to draw over @p image, which is borrowed and does not change until sc_overlay_finish.
 *  What is drawn later covers what was drawn before. Threads: any, on distinct images. @return
 *  SC_ERR_MEMORY, also for an image too large for cairo (32767 pixels). Caller owns *out:
 *  sc_overlay_finish. */
SC_MUST_USE sc_status sc_overlay_begin(const sc_ctx *ctx, sc_image *image, sc_overlay **out);
/** Draw a line from (x0, y0) to (x1, y1), where it ends without caps. Coordinates beyond the
 *  picture are allowed here and below. @param alpha opacity in [0, 1]. */
void sc_overlay_line(sc_overlay *overlay, double x0, double y0, double x1, double y1,
                     double width_px, const uint8_t rgb[3], double alpha);
/** Draw the outline of a rectangle of @p width x @p height pixels, whose upper left corner is
 *  (x, y), opaque. The line lies on the edge: half of @p width_px outside. */
void sc_overlay_frame(sc_overlay *overlay, double x, double y, double width, double height,
                      double width_px, const uint8_t rgb[3]);
/** Size and colours of text. */
typedef struct sc_letters {
    double size_px; /**< font size */
    uint8_t rgb[3];
    uint8_t halo[3]; /**< colour around the letters, so that they can be read on any background */
} sc_letters;
/** Draw one line of text (UTF-8) in DejaVu Sans, bold, with a halo. @param anchor_x -1: the text
 *  begins at @p x; 0: it is centred on it; 1: it ends there. @param anchor_y -1: the top of
 *  capitals is at @p y; 0: their middle; 1: their base line. */
void sc_overlay_text(sc_overlay *overlay, double x, double y, int anchor_x, int anchor_y,
                     const sc_letters *letters, const char *text);
/** Blend what was drawn into the picture and free the overlay. There is no other way to free it. */
void sc_overlay_finish(sc_overlay *overlay);

#endif
