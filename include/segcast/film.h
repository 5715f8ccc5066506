/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  A job with its volumes, drawn: a list of panels, each with a volume, what it shows of it in
 * every frame, and its place in the picture. Shots are panels one after the other, compared
 * subjects are panels side by side. */
#ifndef SEGCAST_FILM_H
#define SEGCAST_FILM_H

#include "segcast/annotate.h"
#include "segcast/centerline.h"
#include "segcast/input.h"

/** How the tissues of a panel look in all frames; the same on all ranks. Owned, but by a panel that
 * draws nothing. */
typedef struct sc_panel_looks {
    sc_tissue *tissues;      /**< [label_count]; NULL: a panel that draws nothing, or not yet */
    sc_color_scale scale;    /**< from values to colours, if the job colours by values */
    double *column_values;   /**< [job.color_columns.steps.count][label_count]: the values of the
                                key frames of columns; NULL: there are none */
    float level_linear[256]; /**< with them: levels of sRGB in linear light */
    sc_change *fades;        /**< [fade_count], what verbs do to tissues */
    size_t fade_count;       /**< of them */
    sc_track *color_tones;   /**< [job.tissue_track_count], the tones of those of
                                job.tissue_tracks that are of colours; NULL: none is */
    sc_change *shifts;       /**< [shift_count], how verbs move tissues */
    size_t shift_count;      /**< of them */
    sc_clip_set clip_sets[SC_CLIP_SETS_MAX]; /**< [clip_set_count] */
    int clip_set_count;                      /**< of them */
} sc_panel_looks;

/** What is written onto a panel; the same on all ranks, owned. */
typedef struct sc_panel_text {
    sc_lettering *lettering; /**< NULL: there is none */
    sc_name_plan *names;     /**< NULL: there are none */
    sc_image logo;           /**< empty: there is none */
} sc_panel_text;

/** Where a panel lies in the picture. */
typedef struct sc_panel_place {
    sc_viewport space;  /**< its picture in space, if that is a part of the frame which does not
                           follow from the layout; else of width 0 */
    sc_viewport within; /**< where overlays lie, if not in the picture; else of width 0 */
    bool is_divided;    /**< it is beside a divider */
} sc_panel_place;

/** Of a tissue of several subjects that are compared: the first of them that has voxels of it, or
 * else the first that knows it, and its dense id there. */
typedef struct sc_tissue_owner {
    int subject, id; /**< which, and there */
    bool has_voxels; /**< of it */
} sc_tissue_owner;

/** The panels that have one camera, framed on all of them: the subjects of a comparison, or one
 * panel alone. */
typedef struct sc_panel_group {
    struct sc_panel *all;          /**< [count], borrowed */
    int count;                     /**< of them */
    int index;                     /**< of this one; -1: it belongs to the group, but only writes */
    const sc_tissue_owner *owners; /**< [label_count], borrowed; NULL: the group is one panel */
    struct sc_panel *front;        /**< that which writes over all of them; NULL: none */
} sc_panel_group;

/** What is drawn, or only written, in one place of some frames. */
typedef struct sc_panel {
    sc_job job;                /**< what it draws; its arrays are those of the session's job */
    const sc_shot *shot;       /**< whose frames it shows; NULL: all */
    int nameless[2];           /**< as of sc_annotations */
    sc_inputs *inputs;         /**< of the session, borrowed */
    int input;                 /**< the first of them that it shows, */
    int phases;                /**< of so many, in turn; 0: it only writes */
    const atomic_int *give_up; /**< as of sc_session; borrowed */
    sc_prepared volume;        /**< a view of that: with the labels of all subjects, and moved */
    sc_grey_input grey;        /**< the grey volume */
    sc_panorama environment;   /**< what stands in place of the sky; empty: nothing; owned */
    sc_renderer **renderers;   /**< [phases]; NULL: not yet */
    bool borrows_renderers;    /**< from a panel that draws in the same way */
    sc_panel_looks looks;      /**< of its tissues */
    sc_scene_room room;        /**< of the frame being drawn; owned */
    sc_timeline timeline;      /**< what it shows in each frame */
    sc_way_point *ways;        /**< of the timeline, the same on all ranks; owned */
    sc_panel_text text;        /**< what is written onto it */
    sc_panel_place place;      /**< where it lies */
    sc_panel_group group;      /**< with which it has the camera in common */
} sc_panel;

typedef struct sc_compare sc_compare; /**< what only a comparison has; see panels.h */

/** A job, its volumes, and the panels that are drawn of them. Its functions are collective unless
 * their comment says otherwise, and return the same on all ranks. It is filled in this order:
 * sc_session_job, then sc_session_volume, which calls sc_session_load and sc_session_scene. After
 * an error of any of them only sc_session_clear may be called. */
typedef struct sc_session {
    bool measure; /**< set between job and volume: measure all labels, so that none is hidden */
    const atomic_int *give_up; /**< set likewise: that which sc_render_settings has; NULL: that of
                                    sc_signals_give_up. Borrowed */
    struct sc_session *lender; /**< set likewise: NULL, or a session whose volumes are as this one's
                                    job needs them, which are borrowed, and so are its renderers by
                                    panels that draw in the same way; it is cleared later */
    sc_job job;
    sc_inputs *inputs;    /**< its volumes; owned */
    sc_rank_record times; /**< what this rank did how long */
    sc_panel *panels;    /**< [panel_count], owned: one for each shot; or the subjects, then what is
                            written below each, then what is written over all; or one */
    int panel_count;     /**< of them */
    sc_shot_span *spans; /**< [panel_count] of a film of shots; NULL: there are none; owned */
    sc_mixer mixer;      /**< the same on all ranks */
    sc_compare *compare; /**< NULL: there is one volume at a time; owned */
    sc_image other;      /**< the second picture of a cross-fade or beside a divider; empty until it
                            is needed; owned */
    sc_image moment;     /**< a picture at one moment of a frame with motion blur; likewise */
    float *light;        /**< sums of such, as of sc_image_add; likewise */
} sc_session;

/** Send the job of rank 0 to all others, whose own is empty. */
sc_status sc_job_share(sc_app *app, sc_job *job);
/** Begin @p session: read the job on rank 0, into session->job, and send it to all others. @param
 * job_path NULL: there is no job file, only settings. Caller owns: sc_session_clear. */
sc_status sc_session_job(sc_app *app, const char *job_path, sc_session *session);
/** Check, on rank 0, the tissues that a job names against those of its volume, as far as that is
 * known: nothing is checked of a comparison. Unless the command is to scan the voxels, only the
 * tables of the volume are read, and numbers of labels are not checked.
 * @return the first mistake; all are logged. */
sc_status sc_check_job_tissues(sc_app *app, sc_job *job);
/** Load the volumes: sc_inputs_load. */
sc_status sc_session_load(sc_app *app, sc_session *session);
/** Make the panels of a session whose volumes are there. */
sc_status sc_session_panels(sc_app *app, sc_session *session);
/** Resolve how the tissues of all panels look: an automatic background is the same in all. */
sc_status sc_session_tissues(sc_app *app, sc_session *session);
/** Find points that a panel has to show, on rank 0 at least. Caller owns *out: sc_free. */
typedef sc_status sc_points_fn(const sc_app *app, const sc_panel *panel, sc_vec3 **out,
                               size_t *count);
/** Replace verbs of the job by the key frames that they stand for, after sc_session_tissues: orbit,
 *  and fade and appear of tissues that are opaque; where frames would not be the same to the last
 *  bit, verbs stay. Afterwards only the job may be used. Not collective. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_session_expand(const sc_ctx *ctx, sc_session *session);
/** Fill the timelines, after sc_session_tissues, each framed on what @p find finds in the panels of
 * its group, and what is written onto the panels. @param find NULL: the renderers are made, which
 * know what is seen. */
sc_status sc_session_timelines(sc_app *app, sc_session *session, sc_points_fn *find);
/** All that is left after sc_session_load. */
sc_status sc_session_scene(sc_app *app, sc_session *session);
/** Do everything between sc_session_job and the first sc_session_draw. */
sc_status sc_session_volume(sc_app *app, sc_session *session);
/** Check the grey volumes of all panels, which need not have been loaded. Not collective. @return
 * as sc_grey_check. */
sc_status sc_session_check_grey(const sc_app *app, const sc_session *session);
/** Move the volumes from one session to another, whose job needs them prepared in the same way.
 * What the first one still has cannot be drawn any more, and is freed by sc_session_clear. Not
 * collective. */
void sc_session_move_inputs(sc_session *from, sc_session *to);
/** Free everything. A zeroed session is allowed. */
void sc_session_clear(sc_session *session);

/** Allocate a picture of the kind that the job draws: of its size, and with alpha if it has no
 * background. Not collective. @return SC_ERR_MEMORY. Caller owns: sc_image_clear. */
sc_status sc_session_image(const sc_app *app, const sc_session *session, sc_image *out);
/** Draw frame @p k, or @p rows of it, in the layout of the job, into @p image, which is as of
 * sc_session_image. The layout views may also write to other rows. One call at a time per
 * session. Not collective. */
sc_status sc_session_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                          sc_image *image, sc_render_stats *stats);
/** As sc_session_draw, for the farm: fill in the timing record except wait_s, rank and hash, which
 * are the farm's. @return SC_ERR_INCOMPLETE if the frame was given up (sc_signals_give_up). */
sc_status sc_session_draw_frame(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                                sc_image *image, sc_frame_result *result);
/** Let all renderers draw in a hurry, or not any more: sc_renderer_hurry. Not collective. */
void sc_session_hurry(sc_session *session, bool hurries);
/** Make room for light that is gathered, of a session whose frames can be given up: each of those
 * that are drawn without hurry then gathers what it needs. @return SC_ERR_MEMORY. */
sc_status sc_session_light(const sc_app *app, sc_session *session);
/** As sc_session_draw, into @p image of any size with about the shape of the job's, without what is
 * written onto it, and of a cross-fade the shot that comes. A comparison is drawn as by
 * sc_session_draw, at the size of the job, for which @p image has to be. */
sc_status sc_session_sketch(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                            sc_image *image, sc_render_stats *stats);
/** @return the panel that frame @p k shows: of a cross-fade the one that comes, of a comparison the
 * first; and in *frame the number of the frame in it. Not collective. */
sc_panel *sc_session_panel(sc_session *session, int k, int *frame);
/** @return the scene of frame @p k of a panel, which borrows from it. Not collective. */
sc_scene sc_panel_scene(sc_panel *panel, int k);
/** Count the work of each pixel in a picture of frame @p k in space, of @p size_px; see
 * sc_render_counts. Not collective. */
void sc_session_counts(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                       sc_render_stats *stats);
/** @return width divided by height of the picture in space within a frame of a job. */
double sc_space_aspect(const sc_job *job);

/** @return the volume of a session, or the first of several. Not collective. */
static inline const sc_prepared *sc_session_view(const sc_session *session)
{
    return &session->inputs->all[0].volume;
}
/** @return renderer @p i of those that the panels draw with; NULL behind the last of them. Not
 * collective. */
sc_renderer *sc_session_renderer(const sc_session *session, int i);
/** @return the bytes of all of them: sc_renderer_bytes, and *derived sc_renderer_derived_bytes. Not
 * collective. */
uint64_t sc_session_renderer_bytes(const sc_session *session, uint64_t *derived);
/** @return the bytes of all grey volumes, of which a node holds each once. Not collective. */
uint64_t sc_session_grey_bytes(const sc_session *session);
/** @return which share of what is prepared for a session, and derived from it, is in the memory of
 * a node at a time: 1 unless its phases are held in files. Not collective. */
double sc_session_loaded_share(const sc_session *session);
/** @return what is written below the picture of subject @p i of a comparison. Not collective. */
const char *sc_subject_name(const sc_session *session, int i);

/** A centre line that is asked for by names of tissues; see sc_centerline_request. Borrows. */
typedef struct sc_line_wish {
    const char *const *patterns; /**< [pattern_count] names, globs or label numbers of tissues */
    size_t pattern_count;        /**< of them */
    const sc_vec3 *through;      /**< [through_count], RAS mm */
    size_t through_count;        /**< of them */
    double clearance;            /**< as of sc_centerline_request */
    const char *where;           /**< "file:line" for messages; may be empty */
    bool middles; /**< from the middle of the tissues of a pattern to that of the next, instead of
                   * through points */
} sc_line_wish;
/** @return the first label that a line is to lead through and that a prepared volume has hidden,
 * and so lost; NULL: none. Not collective. */
const sc_label *sc_hidden_on_line(const sc_prepared *volume, const sc_line_wish *wish);
/** Refuse a prepared file, @p path, that has lost labels which a line is to lead through.
 * Not collective. @return SC_ERR_DATA. */
sc_status sc_check_line_voxels(const sc_ctx *ctx, const char *path, const sc_prepared *volume,
                               const sc_line_wish *wish);
/** Find a centre line, on this rank alone, and tell how long it is. @param volume with its ids.
 * @return as sc_pattern_check and sc_centerline_find. Caller owns *out: sc_centerline_clear. */
sc_status sc_find_line(const sc_app *app, const sc_volume *volume, const sc_line_wish *wish,
                       sc_centerline *out);

/** Read what stands in place of the sky of a job or shot, if anything does, and warn if no light
 *  comes from anywhere. @return as of sc_panorama_load. Caller owns *out: sc_panorama_clear. */
SC_MUST_USE sc_status sc_environment_load(const sc_ctx *ctx, const sc_job *job, sc_panorama *out);

#endif
