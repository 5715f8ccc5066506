/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Lines and text drawn over a picture. This module is the only user of cairo and fontconfig; see
 *  also lettering.h. Coordinates are in
 *  pixels from the upper left corner of the picture, x to the right, y down; pixel centres lie at
 *  halves. Colours are 8-bit sRGB. */
#ifndef SEGCAST_OVERLAY_H
#define SEGCAST_OVERLAY_H

#include "segcast/render.h"

/** What is drawn over one picture, until it is blended into it. */
typedef struct sc_overlay sc_overlay;

/** Begin to draw over @p image, which is borrowed and does not change until sc_overlay_finish.
 *  What is drawn later covers what was drawn before. Threads: any, on distinct images. @return
 *  SC_ERR_MEMORY, also for an image too large for cairo (32767 pixels). Caller owns *out:
 *  sc_overlay_finish. */
SC_MUST_USE sc_status sc_overlay_begin(const sc_ctx *ctx, sc_image *image, sc_overlay **out);
/** As sc_overlay_begin, but only what lies within the rectangle @p within is drawn, which costs the
 * less the smaller it is; it may lie outside of the picture in part. Coordinates stay those of the
 * picture. @param rows the rows of the picture that may be written to; NULL: all. The pixels of a
 * row do not depend on which others are asked for. */
SC_MUST_USE sc_status sc_overlay_begin_within(const sc_ctx *ctx, sc_image *image,
                                              const sc_viewport *within, const sc_rows *rows,
                                              sc_overlay **out);
/** Fill the rectangle whose upper left corner is (x, y), with sharp edges, over what is in @p image
 * at once. @param alpha opacity in [0, 255]. @param rows as of sc_overlay_begin_within. */
void sc_overlay_fill(sc_image *image, const sc_viewport *rectangle, const uint8_t rgb[3], int alpha,
                     const sc_rows *rows);
/** Draw the picture @p from, which has alpha, over @p image at once. @param x and @p y where its
 * upper left corner lies. @param rows as of sc_overlay_begin_within. */
void sc_overlay_image(sc_image *image, const sc_image *from, int x, int y, const sc_rows *rows);
/** Fill the polygon with the @p count corners @p corners, each x and y, and draw its outline.
 * @param alpha opacity of the inside, in [0, 1]; the outline is opaque. */
void sc_overlay_polygon(sc_overlay *overlay, const double (*corners)[2], int count,
                        const uint8_t rgb[3], double alpha, double outline_px,
                        const uint8_t outline[3]);
/** Draw a line from (x0, y0) to (x1, y1), where it ends without caps. Coordinates beyond the
 *  picture are allowed here and below. @param alpha opacity in [0, 1]. */
void sc_overlay_line(sc_overlay *overlay, double x0, double y0, double x1, double y1,
                     double width_px, const uint8_t rgb[3], double alpha);
/** Draw a leader line: lines that join the @p count points @p points, each x and y, with round
 *  corners, and a dot at the first of them. Where line and dot cover each other they are not more
 *  opaque. @param alpha opacity in [0, 1]. */
void sc_overlay_leader(sc_overlay *overlay, const double (*points)[2], int count, double width_px,
                       double radius_px, const uint8_t rgb[3], double alpha);
/** Draw the outline of a rectangle of @p width x @p height pixels, whose upper left corner is
 *  (x, y), opaque. The line lies on the edge: half of @p width_px outside. */
void sc_overlay_frame(sc_overlay *overlay, double x, double y, double width, double height,
                      double width_px, const uint8_t rgb[3]);
/** Choose the colours of text. @param dark 1: dark, with a light halo, for a light background; 0:
 * the reverse; between: it is changing from one to the other. */
void sc_text_colors(double dark, uint8_t rgb[3], uint8_t halo[3]);
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
/** Blend what was drawn into the picture and free the overlay. There is no other way to free it.
 *  @return SC_ERR_MEMORY if a part of it could not be drawn: the picture is unchanged then. */
SC_MUST_USE sc_status sc_overlay_finish(const sc_ctx *ctx, sc_overlay *overlay);

#endif
