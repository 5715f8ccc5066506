/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to film: how a panel is made and drawn. The functions are collective, unless their
 * comment says otherwise. */
#ifndef SC_FILM_PANELS_H
#define SC_FILM_PANELS_H

#include "segcast/film.h"

/* What the view of the volume of one subject got beside its own. */
typedef struct sc_joined {
    void *owned[7]; /* arrays that the view points to; freed by sc_joined_clear */
    int added;      /* tissues that only others have */
} sc_joined;

struct sc_compare {
    sc_joined joined[SC_SUBJECTS_MAX];    /* of the subjects */
    sc_caption captions[SC_SUBJECTS_MAX]; /* their names */
    sc_label_stats *stats;                /* of all tissues, for what is written over all; owned */
};

/* ---- join.c ---- */

/* Give the view of each subject's volume the labels that only others have, without voxels, behind
 * its own, and fill group.owners. The views stay valid until sc_joined_clear. Not collective; the
 * same on all ranks. @param out [count], zeroed; to be cleared also after an error. @return
 * SC_ERR_MEMORY. */
sc_status sc_join_labels(const sc_ctx *ctx, sc_panel *subjects, int count, sc_joined *out);
void sc_joined_clear(sc_joined *joined);

/* ---- subject_places.c ---- */

/* Move the volumes of the subjects as compare.align says: only their views change. @param joined
 * [count] as of sc_join_labels. @return SC_ERR_MEMORY. */
sc_status sc_align_subjects(sc_app *app, sc_panel *subjects, int count, sc_joined *joined);
/* Where the subjects lie in a picture. */
typedef struct sc_places {
    sc_viewport panels[SC_SUBJECTS_MAX]; /* of each */
    int below_px;                        /* height that is free below each, for the names */
    double text_px; /* size of the font of the names: smaller than that of other text if they are
                       long */
} sc_places;
/* Find where the pictures of the subjects lie in one of @p size_px. @param names [sc_subject_count]
 * what is written below them. Whatever fonts there are, the result is the same. Not collective. */
void sc_place_subjects(const sc_job *job, const sc_caption *names, const int size_px[2],
                       sc_places *out);
/* Find what is written below a subject of which the job gives no name: the name of its file,
 * without what tells its format. Not collective. */
void sc_name_of_file(const char *volume, char out[SC_CAPTION_BYTES]);

/* ---- looks.c, color_by.c ---- */

/* Resolve the tissues and clip sets of a panel by the rules of its job: fills panel->looks. Those
 * of a subject that subjects before it have look as there. */
sc_status sc_panel_tissues(sc_app *app, sc_panel *panel);
/* If the job colours tissues by values: make a copy of the labels of a panel with these colours,
 * and fill looks.scale and, with key frames of columns, looks.column_values; else *out becomes
 * NULL. The colours are those of the first key frame. Not collective. @return as of
 * sc_color_values. Caller owns *out: sc_free. */
sc_status sc_color_labels(const sc_ctx *ctx, sc_panel *panel, sc_label **out);
/* Send the values of key frames of columns, if there are any, to all ranks. */
sc_status sc_share_column_values(sc_app *app, sc_panel *panel);

/* ---- renderers.c ---- */

/* Read what stands in place of the sky of a panel, if its light has something: rank 0 does it.
 * Collective. */
sc_status sc_panel_environment(sc_app *app, sc_panel *panel);
/* Make the renderers of a panel, after sc_panel_tissues, together with the other ranks of the node.
 */
sc_status sc_panel_renderers(const sc_app *app, sc_panel *panel);
/* Gather light for the renderers of all panels, after their timelines are made, as far as frames
 * have it in common. */
sc_status sc_panels_gather(sc_app *app, sc_session *session);
/* @return the renderer of the phase that frame @p k of a panel shows, which is going to be drawn:
 * the other phases leave the memory of this rank, but for the one that was drawn before, and the
 * system is told which one may be next. Not collective. */
sc_renderer *sc_panel_begin_frame(const sc_panel *panel, int k);
/* Let a phase leave the memory of this rank, if it is in a file: its volume and what the renderer
 * of it has derived. It can be used as before. Not collective. */
void sc_panel_unload(const sc_panel *panel, int phase);
/* Let all phases from which frames were drawn leave the memory of this rank; before their renderers
 * are freed. NULL is allowed. Not collective. */
void sc_inputs_unload(sc_inputs *inputs);

/* ---- moves.c ---- */

/* The verbs of a job that move the camera. */
typedef struct sc_moves {
    sc_move moves[SC_VERBS_MAX]; /* [count] of them */
    int count;
    sc_vec3 *points[SC_VERBS_MAX];   /* [count] of them, those of the moves or NULL; owned */
    double *around_mm[SC_VERBS_MAX]; /* likewise */
} sc_moves;
/* Find the moves of a panel, after sc_panel_tissues: with the lines along which they fly, and all
 * corners of the tissues that they frame, or those of boxes around them if there is no renderer
 * yet, and so perhaps no voxels. Not collective. Caller owns *out, also after an error:
 * sc_moves_clear. @return as sc_input_voxels and sc_find_line. */
sc_status sc_find_moves(const sc_app *app, const sc_panel *panel, sc_moves *out);
void sc_moves_clear(sc_moves *moves);

/* ---- hints.c; not collective ---- */

/* Warn of clip planes given in mm that remove everything or nothing in all frames, and of frames
 * that are empty because of them. Needs panel->timeline. */
void sc_warn_of_planes(const sc_app *app, const sc_panel *panel);
/* Propose a picture that is higher than wide for a job, not of several shots or subjects, that
 * shows something so long that it fills little of a wide one. Needs panel->timeline. */
void sc_tell_shape(const sc_app *app, const sc_panel *panel);
/* Tell which tissues are thinner than a pixel, of a picture of one subject. Needs panel->timeline.
 */
void sc_tell_thin(const sc_app *app, const sc_panel *panel);
/* Tell which tissues are hidden because of their names (sc_tissue.is_rest). */
void sc_tell_rests(const sc_app *app, const sc_panel *panel);
/* Warn if the zoom of panel->timeline moves some of @p points out of the picture, which would be in
 * it without the zoom. @param aspect width of the picture divided by its height. @return
 * SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_warn_of_zoom(const sc_app *app, const sc_panel *panel, double aspect,
                                      const sc_vec3 *points, size_t count);

/* ---- timeline.c ---- */

/* Fill panel->timeline, framed on @p points (see sc_timeline_resolve), after sc_panel_tissues. Rank
 * 0 does it, and warns of clip planes that leave nothing or do not cut what is shown; the others
 * get its result. @return as sc_find_moves. */
sc_status sc_panel_timeline(sc_app *app, sc_panel *panel, const sc_vec3 *points, size_t count);
/* Let panel->timeline, which is resolved, know what else the frames of a panel follow from: all but
 * the ways on which its camera flies. Not collective. */
void sc_panel_set_looks(sc_panel *panel);
/* A sc_points_fn: the points around what is shown in any phase of a panel, by its renderers. */
sc_status sc_panel_hull(const sc_app *app, const sc_panel *panel, sc_vec3 **out, size_t *count);

/* ---- letter.c ---- */

/* @return all that the overlays of a panel follow from; borrowed from it. Not collective. */
sc_annotations sc_panel_annotations(const sc_panel *panel);
/* Fill panel->text, the names only if the voxels are known, if the job has overlays, after
 * sc_panel_timeline: rank 0 makes it, so that other ranks need no fonts. That of group.front is
 * made before. @return as sc_annotations_letter, sc_annotations_logo and sc_annotations_plan_names.
 */
sc_status sc_panel_letter(sc_app *app, sc_panel *panel);

/* ---- panels.c ---- */

/* Free session->panels. */
void sc_panels_free(sc_session *session);

#endif
