/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to annotate: how overlays share out the picture, and each of them. All sizes follow from
 * the job and the pixels of its text, so that nothing moves from frame to frame. */
#ifndef SC_ANNOTATE_INTERNAL_H
#define SC_ANNOTATE_INTERNAL_H

#include "segcast/annotate.h"

/* Kinds of words in the lettering, and what their number is. */
enum {
    SC_WORD_GLYPH,   /* one character, of which changing text is composed: its code */
    SC_WORD_CAPTION, /* a line of a caption: SC_CAPTION_LINES_MAX times its index, plus the line */
    SC_WORD_LEGEND,  /* a row of the legend: dense id; its data is the colour */
    SC_WORD_MORE,    /* the last row of a legend that has no room for all tissues: 0 */
    SC_WORD_COLOR_BAR,  /* a text of the colour bar: SC_BAR_* */
    SC_WORD_ORIENTATION /* a letter of the orientation cube: its code */
};
/* The most rows of a legend. */
enum { SC_LEGEND_ROWS_MAX = 60 };

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
    char **texts; /* [text_count], owned: those that were made for the list */
    size_t text_count;
} sc_line_list;
/* Append a line. @return SC_ERR_MEMORY. */
sc_status sc_add_line(const sc_ctx *ctx, sc_line_list *list, const sc_text_line *line);
/* Append the beginning of a line, with dots if it is wider than @p widest pixels. @param room where
 * the dots are put behind the text. @return SC_ERR_MEMORY. */
sc_status sc_add_cut_line(const sc_ctx *ctx, sc_font *font, double widest, sc_text *room,
                          sc_text_line *line, sc_line_list *list);
/* Copy a text that a line is to borrow. @param out the copy; the list owns it. */
sc_status sc_keep_text(const sc_ctx *ctx, sc_line_list *list, const char *text, const char **out);
/* Free what a list owns. */
void sc_lines_clear(sc_line_list *list);
/* Append the lines of all captions, broken so that they fit. @return SC_ERR_DATA if one does not.
 */
sc_status sc_add_captions(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                          sc_line_list *list);
/* @return whether a tissue can be seen in the film at all. */
bool sc_is_in_film(const sc_annotations *a, int id);
/* @return how much of a tissue is shown in a frame, 0 to 255, by its verbs and the clip planes. */
int sc_shown_alpha(const sc_annotations *a, const sc_scene *scene, int id);
/* Find the tissues that are seen in the film, all or the @p room largest ones, by rising id.
 * @return how many there are. */
int sc_choose_tissues(const sc_annotations *a, int room, int *ids);
/* Find the name of a tissue, its words separated by blanks, or "label 5". @return SC_ERR_DATA if it
 * cannot be written. */
sc_status sc_name_of(const sc_ctx *ctx, const sc_annotations *a, int id, sc_line_list *list,
                     const char **out);
/* Append the rows of the legend. @return as sc_name_of. */
sc_status sc_add_legend(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                        sc_line_list *list);
/* Draw the legend of a frame, if there is one. */
void sc_draw_legend(sc_drawing *d, const sc_scene *scene);
/* Texts of the colour bar: its title, the values of its ends and of its middle, and what stands
 * beside the colour of missing values. */
enum { SC_BAR_TITLE, SC_BAR_LOW, SC_BAR_MIDDLE, SC_BAR_HIGH, SC_BAR_MISSING, SC_BAR_TEXTS };
/* Append the texts of the colour bar. @return SC_ERR_DATA if its title cannot be written. */
sc_status sc_add_color_bar(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                           sc_line_list *list);
/* Draw the colour bar, if there is one. */
void sc_draw_color_bar(sc_drawing *d);
/* Append the letters of the orientation cube; a volume without orientation gets a warning. */
sc_status sc_add_orientation(const sc_ctx *ctx, const sc_annotations *a, sc_line_list *list);
/* Draw the orientation cube of a frame, if there is one. @return SC_ERR_MEMORY. */
sc_status sc_draw_orientation(const sc_ctx *ctx, sc_drawing *d, const sc_scene *scene);
/* Draw the logo, if there is one. */
void sc_draw_logo(sc_drawing *d);
/* Draw the captions of frame @p k. */
void sc_draw_captions(sc_drawing *d, int k);

#endif
