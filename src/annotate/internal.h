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
    SC_WORD_MORE,    /* a part of the last row of a legend that has no room for all tissues, "and 12
                        more": the code of a digit, or of the letter that the word begins with; the
                        data of "more" is how many tissues have no row in the lettering */
    SC_WORD_COLOR_BAR,   /* a text of the colour bar: SC_BAR_* */
    SC_WORD_ORIENTATION, /* a letter of the orientation cube: its code */
    SC_WORD_CARD,        /* a line of a title card: its number from the top; its data is
                            the distance in pixels of its base line from the one above */
    SC_WORD_NAME         /* the name of a tissue, to be written beside it: dense id; the largest
                            tissue comes first */
};
/* The most rows of a legend at a time, and the most tissues whose names are prepared for it. */
enum { SC_LEGEND_ROWS_MAX = 60, SC_LEGEND_TISSUES_MAX = 256 };

/* ---- layout.c ---- */

/* A drawing over one frame. */
typedef struct sc_drawing {
    const sc_annotations *a;
    sc_image *image;
    const sc_rows *rows;
    sc_letters letters;                /* their colours */
    int margin_px;                     /* from the edges of the picture, and between overlays */
    int used_px[SC_PLACE_COUNT];       /* height of what stands at each place already */
    sc_viewport taken[SC_PLACE_COUNT]; /* the rectangle around that; of width 0: nothing */
} sc_drawing;

/* @return the font size of all but captions. */
double sc_text_px(const sc_annotations *a);
/* @return the drawing over @p image, with nothing placed yet. */
sc_drawing sc_drawing_begin(const sc_annotations *a, const sc_scene *scene, sc_image *image,
                            const sc_rows *rows);
/* @return how far overlays stand from the edges of the picture, and from each other. */
int sc_margin_px(const sc_annotations *a);
/* Take room at a place, behind what stands there already. @return the rectangle, of that size. */
sc_viewport sc_take_room(sc_drawing *d, int place, int width_px, int height_px);
/* Let a rectangle, of width 0 if it is none yet, hold another one. */
void sc_hold(sc_viewport *around, const sc_viewport *other);
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
/* @return how much of a tissue is shown in a frame, 0 to 255, by its verbs and the clip planes. */
int sc_shown_alpha(const sc_annotations *a, const sc_scene *scene, int id);
/* Find the tissues that are chosen for an overlay and are seen in the film.
 * @param ids the largest of them, at most @p room, the largest first. @param all how many there
 * are. @return SC_ERR_MEMORY. */
sc_status sc_choose_tissues(const sc_ctx *ctx, const sc_annotations *a, sc_tissue_use use, int room,
                            int *ids, int *all);
/* Find the name of a tissue, its words separated by blanks, or "label 5". @param key of the
 * job that asks for it. @return SC_ERR_DATA if it cannot be written. */
sc_status sc_name_of(const sc_ctx *ctx, const sc_annotations *a, int id, const char *key,
                     sc_line_list *list, const char **out);
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
/* Append the names that are written beside tissues; warns if there is no room for all of them.
 * @return as sc_name_of. */
sc_status sc_add_names(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                       sc_line_list *list);
/* @return the font size of names. */
double sc_names_px(const sc_annotations *a);
/* Draw the names of a frame, if there are any. @return SC_ERR_MEMORY. */
sc_status sc_draw_names(const sc_ctx *ctx, sc_drawing *d, const sc_scene *scene);
/* Append the letters of the orientation cube; a volume without orientation gets a warning. */
sc_status sc_add_orientation(const sc_ctx *ctx, const sc_annotations *a, sc_line_list *list);
/* Draw the orientation cube of a frame, if there is one. @return SC_ERR_MEMORY. */
sc_status sc_draw_orientation(const sc_ctx *ctx, sc_drawing *d, const sc_scene *scene);
/* Draw the logo, if there is one. */
void sc_draw_logo(sc_drawing *d);
/* Draw what has the same size in all frames: all but names and captions. @return SC_ERR_MEMORY. */
sc_status sc_draw_fixed(const sc_ctx *ctx, sc_drawing *d, const sc_scene *scene);
/* Break a text into lines that are no wider than @p width pixels, where they can be. @return how
 * many there are; of more than @p room only the first are written to @p out: their text, bytes and
 * size_px. */
int sc_break_lines(const char *text, sc_font *font, double size_px, double width, int room,
                   sc_text_line *out);
/* Append the lines of the title card. @return SC_ERR_DATA if they do not fit. */
sc_status sc_add_card(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                      sc_line_list *list);
/* Draw the title card, if it is one. */
void sc_draw_card(sc_drawing *d);
/* Draw the captions that are shown at a time. */
void sc_draw_captions(sc_drawing *d, double at);

/* ---- anchors.c ---- */

/* Points deep inside a tissue, the deepest first, in voxels. */
enum { SC_ANCHORS_MAX = 16 };
typedef struct sc_anchors {
    int count; /* 0 only of a tissue without voxels */
    int voxel[SC_ANCHORS_MAX][3];
} sc_anchors;
/* Find the anchors of tissue @p id, which has voxels: that with the largest distance to the border,
 * of equal ones the first in the order of the volume, and others far from it. Any thread. @return
 * SC_ERR_MEMORY. */
sc_status sc_find_anchors(const sc_ctx *ctx, const sc_prepared *volume, int id, sc_anchors *out);

/* ---- sight.c ---- */

/* @return the share of light, 0 to 1, that reaches the camera from a point of tissue @p id, which
 * lies before it; 0 if a clip plane has taken it away. What the tissue itself hides does not count.
 * @param from_ras_mm to voxels. Any thread. */
double sc_light_of(const sc_annotations *a, const sc_affine *from_ras_mm, const sc_scene *scene,
                   int id, sc_vec3 point_mm);

/* ---- columns.c ---- */

/* Spread names over a column: out[i] is as near to want_px[i] as can be so that name i has
 * room_px[i] around it, the order stays, and all lie between @p low_px and @p high_px, where there
 * is room for them. It follows the arguments without jumps. @param want_px [count], rising.
 * @param count at most SC_NAMES_MAX. */
void sc_spread(const double *want_px, const double *room_px, int count, double low_px,
               double high_px, double *out);
/* Share out the rows of a column to names, the most important first. @param shown [count]: from 0,
 * not shown, to 1; first a name gets its room, and then it is seen. @param rows that there are.
 * @param room [count]: share of a row. @param alpha [count]: how much is seen of the name. */
void sc_share_rows(const double *shown, int count, double rows, double *room, double *alpha);

/* ---- name_states.c ---- */

/* The state of a name in a frame: which of its points it names, and on which side it stands. */
typedef struct sc_name_state {
    int8_t anchor;   /* -1: the tissue cannot be seen at any */
    uint8_t shown;   /* of the tissue: sc_shown_alpha */
    bool right;      /* it stands on the right */
    bool changes;    /* from the frame before: its anchor, its side, or its order among names of
                        larger tissues on its side */
    float dot_px[2]; /* where the anchor lies in the picture */
} sc_name_state;
/* The two columns of names in a frame. */
typedef struct sc_columns {
    double middle_px;   /* x that parts the sides */
    double edge_px[2];  /* x where names on the left end, and those on the right begin */
    double elbow_px[2]; /* x where leader lines turn to them */
} sc_columns;
/* What the places of names follow from. */
typedef struct sc_name_film {
    const sc_annotations *a;
    const sc_word *words[SC_NAMES_MAX]; /* [count] */
    int count, frames;
    double row_px, widest_px;     /* height of a row; width of the widest name */
    double low_px[2], high_px[2]; /* between which y names stand, by side */
    /* [taken_count] where overlays stand, but for captions, which come and go */
    sc_viewport taken[2 * SC_PLACE_COUNT];
    int taken_count;
    sc_anchors anchors[SC_NAMES_MAX]; /* [count] */
    sc_affine from_ras_mm;            /* to voxels */
    sc_columns *columns;              /* [frames] */
    sc_name_state *states;            /* [frames][count] */
} sc_name_film;
/* Find the states of all names in all frames. @return SC_ERR_MEMORY. */
sc_status sc_find_name_states(const sc_ctx *ctx, int threads, sc_name_film *film);
/* Find how much each name is shown in frame @p k, 0 to 1: it is less the nearer the next change of
 * its state is. @param fade_frames in which a name becomes fully shown, at least 1.
 * @param out [count]. */
void sc_name_fades(const sc_name_film *film, int k, int fade_frames, double *out);

#endif
