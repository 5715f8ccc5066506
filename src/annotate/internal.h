/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to annotate: how overlays share out the picture, and each of them. All sizes follow from
 * the job and the pixels of its text, so that nothing moves from frame to frame. */
#ifndef SC_ANNOTATE_INTERNAL_H
#define SC_ANNOTATE_INTERNAL_H

#include "segcast/annotate.h"

/* Kinds of words in the lettering, and what their number is. */
enum {
    SC_WORD_GLYPH,  /* one character, of which changing text is composed: its code */
    SC_WORD_CAPTION /* a line of a caption: SC_CAPTION_LINES_MAX times its index, plus the line */
};

/* ---- layout.c ---- */

/* A drawing over one frame. */
typedef struct sc_drawing {
    const sc_annotations *a;
    sc_image *image;
    const sc_rows *rows;
    sc_letters letters;          /* their colours */
    int margin_px;               /* from the edges of the picture, and between overlays */
    int used_px[SC_PLACE_COUNT]; /* height of what stands at each place already */
} sc_drawing;

/* @return the font size of all but captions. */
double sc_text_px(const sc_annotations *a);
/* @return the drawing over @p image, with nothing placed yet. */
sc_drawing sc_drawing_begin(const sc_annotations *a, sc_image *image, const sc_rows *rows);
/* Take room at a place, behind what stands there already. @return the rectangle, of that size. */
sc_viewport sc_take_room(sc_drawing *d, int place, int width_px, int height_px);
/* @return the width of a text that is composed of glyphs. All digits are equally wide. */
int sc_glyphs_width(const sc_lettering *lettering, const char *text);
/* Draw a text composed of glyphs, from @p x on, on the base line @p y. */
void sc_draw_glyphs(const sc_drawing *d, const char *text, int x, int y);
/* @return height of capital letters of that text. */
int sc_glyphs_capitals(const sc_lettering *lettering);

/* ---- one file each ---- */

/* The characters of time codes and scale bars. */
#define SC_GLYPHS "0123456789:. umn"

/* Draw the scale bar of a frame, if there is one. */
void sc_draw_scale_bar(sc_drawing *d, const sc_scene *scene);
/* A list of lines that are to become pixels. */
typedef struct sc_line_list {
    sc_text_line *lines; /* [count], owned */
    size_t count, room;
} sc_line_list;
/* Append a line. @return SC_ERR_MEMORY. */
sc_status sc_add_line(const sc_ctx *ctx, sc_line_list *list, const sc_text_line *line);
/* Append the lines of all captions, broken so that they fit. @return SC_ERR_DATA if one does not.
 */
sc_status sc_add_captions(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                          sc_line_list *list);
/* Draw the captions of frame @p k. */
void sc_draw_captions(sc_drawing *d, int k);

#endif
