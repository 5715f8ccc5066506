/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What is written onto the pictures of a film, its overlays: captions, time code, scale bar,
 * legend, names beside the tissues. A process that has fonts turns all their text into pixels, once
 * for the film; what is then drawn onto a frame follows from these, from the job and from the
 * scene of the frame. */
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

/** The end of a caption that is shown until after the last frame. */
enum { SC_CAPTION_STAYS = 2 };
enum { SC_CAPTIONS_MAX = 100, SC_CAPTION_BYTES = 512, SC_CAPTION_LINES_MAX = 8 };

/** A text that is shown during a part of the animation. */
typedef struct sc_caption {
    char text[SC_CAPTION_BYTES]; /**< UTF-8, all of whose characters sc_font_refuses allows; lines
                                      are separated by \\n, and longer ones are broken */
    double begin, end;           /**< as of sc_verb; not shown at the end any more */
    int place;                   /**< sc_overlay_place, not SC_PLACE_NONE */
    bool may_be_cut;             /**< where it has no room, its last lines are left out */
    char where[SC_WHERE_BYTES];  /**< "file:line" for messages; may be empty */
} sc_caption;
/** @return whether the caption is shown at a time, 0 to 1. */
bool sc_caption_is_shown(const sc_caption *caption, double at);

/** A title card: text in the middle of the picture, instead of tissues. */
typedef struct sc_card {
    char title[SC_CAPTION_BYTES]; /**< as of sc_caption */
    bool has_subtitle;
    char subtitle[SC_CAPTION_BYTES]; /**< if there is one: below it, and smaller */
    char where[SC_WHERE_BYTES];      /**< "file:line" for messages; may be empty */
} sc_card;

/** The overlays for which tissues can be chosen. */
typedef enum sc_tissue_use {
    SC_USE_NAMES, /**< names are written beside them; if none are listed, there are no names */
    SC_USE_LEGEND /**< they have a row in the legend; if none are listed, all have one */
} sc_tissue_use;

/** The most tissues whose names are written beside them. */
enum { SC_NAMES_MAX = 60 };
/** Where the name of a tissue stands in one frame, and the point of the tissue that it names. All
 *  in pixels of the picture. */
typedef struct sc_name_place {
    float dot_px[2];   /**< the point of the tissue: x, y */
    float elbow_px;    /**< x at which the leader line, which begins at the dot along the row, turns
                            to the name */
    float label_px[2]; /**< x where the name begins, or ends if it stands on the left; y of its
                            middle */
    uint8_t alpha;     /**< opacity of name and line, 0 to 255; 0: there is none in this frame */
    uint8_t is_right;  /**< it stands on the right of the tissues */
    uint8_t is_crowded; /**< it is not shown for want of room alone */
    uint8_t unused;     /**< 0 */
} sc_name_place;
/** Where the names of a film stand, in all of its frames: one block without pointers, which may be
 *  copied as bytes. */
typedef struct sc_name_plan {
    uint64_t bytes;         /**< of the whole block */
    int32_t frames, count;  /**< count: of names, in the order of the lettering: largest first */
    sc_name_place places[]; /**< [frames][count] */
} sc_name_plan;

/** The lists of overlays. */
typedef struct sc_overlay_lists {
    sc_caption *captions; /**< [caption_count], owned */
    size_t caption_count;
    sc_named_tissue *tissues; /**< [tissue_count], owned; of an sc_tissue_use each */
    size_t tissue_count;
} sc_overlay_lists;

/** Which overlays a film has. Members that hold an enum are of type int, as in job.h. */
typedef struct sc_overlays {
    char font[64];                   /**< family */
    char font_where[SC_WHERE_BYTES]; /**< "file:line" for messages; may be empty */
    double text_percent;             /**< font size in percent of the height of the picture */
    int time, scale_bar, color_bar, orientation, legend, logo_place; /**< sc_overlay_place */
    char logo[4096];      /**< path of a PNG file; empty: none */
    double logo_percent;  /**< its height in percent of that of the picture */
    double names_percent; /**< font size of names, in percent of the height of the picture */
} sc_overlays;

/** All that the overlays of a film follow from. Borrows everything. */
typedef struct sc_annotations {
    const sc_overlays *overlays;
    sc_overlay_lists lists;
    const sc_prepared *volume; /**< of which only labels, geometry and statistics are read, and by
                                    sc_annotations_plan_names the ids */
    const sc_tissue *tissues;  /**< [label_count] */
    const sc_timeline *timeline;
    sc_font_told
        *told; /**< what shots before this one have told about fonts; NULL: there are none */
    sc_viewport within; /**< where the picture in space lies in the frame: overlays lie in it */
    sc_viewport
        space; /**< where it lies if it is not there, for the scale bar; of width 0: there */
    int fps;
    int first_frame;     /**< frame of the film that is frame 0 here: by it times are counted */
    const sc_card *card; /**< NULL: it is no title card */
    const sc_color_scale *scale;   /**< NULL: tissues are not coloured by values */
    sc_image logo;                 /**< from sc_annotations_logo, borrowed; empty: none is drawn */
    const sc_lettering *lettering; /**< from sc_annotations_letter; NULL: nothing is drawn */
    const sc_name_plan *names;     /**< from sc_annotations_plan_names; NULL: none are drawn */
    const struct sc_annotations *over; /**< what is written over the whole picture of which this
                                            one is a part, with its lettering: the plan of names
                                            leaves room for it; NULL: nothing is */
    int divided_px; /**< width of the picture in which what is shown ends, or begins, at a divider
                         (sc_divider_px); 0: all of it is shown. Names then stand on the side away
                         from it, and only beside points that are shown */
    bool is_behind_divider; /**< it is shown from the divider on, not up to it */
    int nameless[2]; /**< how many frames at the beginning and at the end show more of another
                          shot, whose names then stand alone */
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
 *  sc_image_load_png. Caller owns: sc_image_clear. */
SC_MUST_USE sc_status sc_annotations_logo(const sc_ctx *ctx, const sc_annotations *annotations,
                                          sc_image *out);
/** @return whether the film has names beside its tissues. */
bool sc_annotations_names(const sc_annotations *annotations);
/** Find where the names beside the tissues stand in all frames of the film. A name stands in a
 *  column on the left or right of what is shown; a line leads from it to a point deep inside the
 *  tissue. Names of tissues that cannot be seen at any such point, as far as rays through voxels
 *  tell, are left out. Where a name has to change its side, its point, or its order among others,
 *  it fades out before and in behind: nothing jumps. The result does not depend on @p threads.
 *  @param annotations all but names. Its volume has ids. @return SC_ERR_MEMORY. Caller owns *out:
 *  sc_free. */
SC_MUST_USE sc_status sc_annotations_plan_names(const sc_ctx *ctx,
                                                const sc_annotations *annotations, int threads,
                                                sc_name_plan **out);
/** Draw the overlays of a frame over its picture. @param rows as of sc_overlay_begin_within. Any
 * thread. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_annotations_draw(const sc_ctx *ctx, const sc_annotations *annotations,
                                          const sc_scene *scene, sc_image *image,
                                          const sc_rows *rows);

/** Room for a time code. */
enum { SC_TIME_CODE_BYTES = 32 };
/** Write the time at which frame @p k is shown to @p out: minutes, seconds and hundredths, 1:02.40.
 *  With more than 50 frames per second these would be the same for several: then thousandths. */
void sc_time_code(int k, int fps, char out[SC_TIME_CODE_BYTES]);

#endif
