/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What is written onto the pictures of a film, its overlays: captions, time code, scale bar,
 * legend. A process that has fonts turns all their text into pixels, once for the film; what is
 * then drawn onto a frame follows from these, from the job and from the number of the frame. */
#ifndef SEGCAST_ANNOTATE_H
#define SEGCAST_ANNOTATE_H

#include "segcast/color_by.h"
#include "segcast/lettering.h"
#include "segcast/timeline.h"

/** Where something is written onto the picture. What has the same place stands in a stack: logo,
 * time code, scale bar, colour bar, orientation cube, legend, then the caption, from the edge of
 * the picture inwards. */
typedef enum sc_overlay_place {
    SC_PLACE_NONE, /**< it is not written at all */
    SC_PLACE_TOP_LEFT,
    SC_PLACE_TOP, /**< in the middle of the upper edge */
    SC_PLACE_TOP_RIGHT,
    SC_PLACE_BOTTOM_LEFT,
    SC_PLACE_BOTTOM,
    SC_PLACE_BOTTOM_RIGHT,
    SC_PLACE_COUNT
} sc_overlay_place;

enum { SC_CAPTIONS_MAX = 100, SC_CAPTION_BYTES = 512, SC_CAPTION_LINES_MAX = 8 };

/** A text that is shown during a part of the animation. */
typedef struct sc_caption {
    char text[SC_CAPTION_BYTES]; /**< UTF-8, all of whose characters sc_font_refuses allows; lines
                                      are separated by \\n, and longer ones are broken */
    double begin, end;           /**< as of sc_ramp; not shown at the end, unless that is 1 */
    int place;                   /**< sc_overlay_place, not SC_PLACE_NONE */
    char where[160];             /**< "file:line" for messages; may be empty */
} sc_caption;
/** @return whether the caption is shown in frame @p k of @p frames. */
bool sc_caption_is_shown(const sc_caption *caption, int k, int frames);

/** Which overlays a film has. Members that hold an enum are of type int, as in job.h. */
typedef struct sc_overlays {
    char font[64];        /**< family */
    char font_where[160]; /**< "file:line" for messages; may be empty */
    double text_percent;  /**< font size in percent of the height of the picture */
    int time, scale_bar, color_bar, orientation, legend, logo_place; /**< sc_overlay_place */
    char logo[4096];     /**< path of a PNG file; empty: none */
    double logo_percent; /**< its height in percent of that of the picture */
} sc_overlays;

/** All that the overlays of a film follow from. Borrows everything. */
typedef struct sc_annotations {
    const sc_overlays *overlays;
    const sc_caption *captions; /**< [caption_count] */
    size_t caption_count;
    const sc_prepared *volume; /**< of which only labels, geometry and statistics are read */
    const sc_tissue *tissues;  /**< [label_count] */
    const sc_timeline *timeline;
    sc_viewport within; /**< where the picture in space lies in the frame: overlays lie in it */
    int fps;
    uint8_t background[3];         /**< sRGB, by which the colour of text is chosen */
    const sc_color_scale *scale;   /**< NULL: tissues are not coloured by values */
    sc_image logo;                 /**< from sc_annotations_logo, borrowed; empty: none is drawn */
    const sc_lettering *lettering; /**< from sc_annotations_letter; NULL: nothing is drawn */
} sc_annotations;

/** @return whether there are any overlays. */
bool sc_annotations_any(const sc_annotations *annotations);
/** Turn all text of the overlays into pixels. @param annotations all but lettering.
 *  @return SC_ERR_DATA if the font is not there or a caption does not fit into the picture,
 *  or if the name of a tissue cannot be written; SC_ERR_SYSTEM without any font, SC_ERR_MEMORY.
 * Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_annotations_letter(const sc_ctx *ctx, const sc_annotations *annotations,
                                            sc_lettering **out);
/** Read the logo, which there is, and scale it to its size in the picture; it is not enlarged.
 * @param annotations all but logo and lettering. @param out with alpha. @return as
 *  sc_image_load_png_alpha. Caller owns: sc_image_clear. */
SC_MUST_USE sc_status sc_annotations_logo(const sc_ctx *ctx, const sc_annotations *annotations,
                                          sc_image *out);
/** Draw the overlays of frame @p k over its picture. @param scene of that frame. @param rows as of
 *  sc_overlay_begin_within. Any thread. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_annotations_draw(const sc_ctx *ctx, const sc_annotations *annotations,
                                          int k, const sc_scene *scene, sc_image *image,
                                          const sc_rows *rows);

/** Room for a time code. */
enum { SC_TIME_CODE_BYTES = 32 };
/** Write the time at which frame @p k is shown to @p out: minutes, seconds and hundredths, 1:02.40.
 *  With more than 50 frames per second these would be the same for several: then thousandths. */
void sc_time_code(int k, int fps, char out[SC_TIME_CODE_BYTES]);

#endif
