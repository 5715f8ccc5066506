/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to overlay: the outlines of text in a font. */
#ifndef SC_OVERLAY_FONT_H
#define SC_OVERLAY_FONT_H

#include "segcast/lettering.h"

#include <cairo.h>

/* Append the outlines of a line of text to the path of @p cairo, from its origin on; NULL: nothing
 * is drawn. @return how far the text reaches, in pixels. */
double sc_font_outline(sc_font *font, const char *text, size_t bytes, double size_px,
                       cairo_t *cairo);
/* @return the ascent of the font at this size, in pixels, above the base line. */
double sc_font_ascent(sc_font *font, double size_px);
/* @return whether any of these functions, or sc_font_width_px, found no memory for an outline; what
 * they have returned then is too small. */
bool sc_font_failed(const sc_font *font);
/* @return whether a font has the character. */
bool sc_font_has(const sc_font *font, unsigned code);

#endif
