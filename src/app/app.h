/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to app and commands: what commands share. */
#ifndef SC_APP_APP_H
#define SC_APP_APP_H

#include "segcast/annotate.h"
#include "segcast/centerline.h"
#include "segcast/process.h"
#include "segcast/resample.h"

/* What the errors about an input begin with. */
typedef struct sc_input_place {
    const sc_ctx *to;
    const char *where, *path;
} sc_input_place;
/* @return a context as @p to, but whose errors about the file @p path, which begin with it, are
 * told behind @p where, the place in the job that names it; empty: as they are. All are borrowed.
 */
sc_ctx sc_ctx_of_input(const sc_ctx *to, const char *where, const char *path,
                       sc_input_place *place);

/* ---- a session: a job with its volume and renderer ----
 *
 * The functions are collective unless their comment says otherwise, and return the same on all
 * ranks. A session is filled in this order: sc_session_job, then sc_session_volume, which calls
 * sc_session_load, sc_session_tissues and sc_session_timeline; or for a check the last two after
 * sc_session_inspect. After an error of any of them only sc_session_clear may be called. */

typedef struct sc_film sc_film;       /* see film.c */
typedef struct sc_compare sc_compare; /* see compare.h */
typedef struct sc_phases sc_phases;   /* see phases.c */

/* Of a tissue of several subjects that are compared: the first of them that has voxels of it, or
 * else the first that knows it, and its dense id there. */
typedef struct sc_tissue_owner {
    int subject, id;
    bool has_voxels;
} sc_tissue_owner;

typedef struct sc_session {
    bool measure; /* set between job and volume: measure all labels, so that none is hidden */
    bool
        borrows_renderer; /* the renderer is that of another session, which draws in the same way */
    sc_job job;
    sc_shared *shared;  /* block that holds the prepared volume, or NULL: it is in a mapped file */
    const void *mapped; /* the prepared file that the job names as its volume, or NULL */
    sc_watched_file *watched; /* that file, for sc_signals_watch_file; NULL: not watched; owned */
    size_t mapped_bytes;
    size_t shared_bytes; /* size of the prepared volume, wherever it is; of a series: of all */
    sc_drawn_grid drawn; /* the grid on which the volume was drawn, if it was measured: drawn_known;
                            set before it is loaded, it is not measured again */
    bool drawn_known;
    /* Of a phase that is interpolated, on rank 0: its voxels, which are taken from here instead of
     * a file; as_given is set on all ranks. Borrowed, taken over when they are read. */
    sc_volume *given;
    bool as_given;
    bool is_later_phase;   /* it holds the volume of a phase, but not of the first, whose colours
                              count */
    sc_label *labels;      /* labels of a mapped or inspected volume with the job's names; owned */
    sc_label_stats *stats; /* label statistics of an inspected volume; owned */
    sc_prepared volume;    /* a view of what the members above hold */
    sc_tissue *tissues;
    sc_color_scale scale;  /* from values to colours; not used unless the job colours by values */
    double *column_values; /* [job.color_columns.steps.count][label_count of the volume]: the values
                              of the key frames of columns; NULL: there are none; owned */
    float level_linear[256]; /* with them: levels of sRGB in linear light, the same on all ranks */
    sc_renderer *renderer;
    sc_renderer **phase_renderers; /* of the phases after the first, one for each, then NULL; NULL:
                                      there are none; owned, unless borrows_renderer */
    sc_fade *fades;                /* [fade_count], what verbs do to tissues; owned */
    size_t fade_count;
    sc_track *color_tones; /* [job.tissue_track_count], owned: the tones of those of
                                   job.tissue_tracks that are of colours; NULL: none is */
    sc_shift *shifts;      /* [shift_count], how verbs move tissues; owned */
    size_t shift_count;
    sc_scene_room room;                      /* of the frame being drawn; owned */
    sc_clip_set clip_sets[SC_CLIP_SETS_MAX]; /* [clip_set_count] */
    int clip_set_count;
    sc_timeline timeline;
    sc_way_point *ways; /* of the timeline, the same on all ranks; owned */
    sc_lettering
        *lettering;        /* text on pictures, the same on all ranks; NULL: there is none; owned */
    sc_name_plan *names;   /* the same on all ranks; NULL: there are none; owned */
    sc_image logo;         /* the same on all ranks; empty: there is none; owned */
    sc_grey grey;          /* the grey volume of the job; codes NULL: there is none, or not yet */
    sc_shared *grey_codes; /* block that holds its codes, or NULL; not of the session of a shot */
    sc_grey_window grey_window; /* that of the job, or found; the same on all ranks */
    sc_vec3 moved_mm; /* how far a comparison has moved the volume from where its file places it */
    uint64_t grey_hash; /* of its codes and geometry; the same on all ranks */
    sc_rank_record times;
    /* Of a film of shots: each of them is a session, which borrows the volume, and what is above
     * from the tissues on is empty but for the renderer, which is that of a shot. NULL: there are
     * no shots. Owned. */
    sc_film *film;
    sc_phases *phases; /* the volumes of a series after the first, which is that above; NULL: there
                          is one volume; owned, but borrowed by the session of a shot */
    /* Of a comparison: each subject is a session, the first of which borrows the volume, and what
     * is above from the tissues on is empty but for the renderer, which is that of the first. NULL:
     * there is one volume. Owned. */
    sc_compare *compare;
    /* Of the session of a subject: all of them, [subject_count], and its index. Borrowed from the
     * comparison; else NULL. */
    const struct sc_session *subjects;
    int subject_count, subject;
    const sc_tissue_owner
        *owners;        /* [label_count] of the session of a subject, borrowed; else NULL */
    sc_viewport panel;  /* where the picture in space lies in the frame, if that is a part of it
                           which does not follow from the layout; else of width 0 */
    sc_viewport within; /* where overlays lie, if not in the panel; else of width 0 */
    /* Of the session of a subject: that which writes over the whole picture. Borrowed; else NULL.
     */
    const struct sc_session *front;
    bool is_divided;     /* it is that of a subject beside a divider */
    const sc_shot *shot; /* of the session of a shot: borrowed from the film's job; else NULL */
} sc_session;

/* If the job colours tissues by values: make a copy of the labels of session->volume with these
 * colours, and fill session->scale and, with key frames of columns, session->column_values; else
 * *out becomes NULL. The colours are those of the first key frame. Not collective. @return as of
 * sc_color_values. Caller owns *out: sc_free. */
sc_status sc_color_labels(const sc_ctx *ctx, sc_session *session, sc_label **out);
/* Send the values of key frames of columns, if there are any, to all ranks. Collective. */
sc_status sc_share_column_values(sc_app *app, sc_session *session);
/* Begin @p session: read the job on rank 0, into session->job, and send it to all others. @param
 * job_path NULL: there is no job file, only settings. Caller owns: sc_session_clear. */
sc_status sc_session_job(sc_app *app, const char *job_path, sc_session *session);
/* Check, on rank 0, the tissues that a job names against those of its volume, as far as that is
 * known: nothing is checked of a comparison. Unless the command is to scan the voxels, only the
 * tables of the volume are read, and numbers of labels are not checked.
 * @param session only its job is filled; gets the volume, as of sc_session_inspect.
 * @return the first mistake; all are logged. */
sc_status sc_session_check_tissues(sc_app *app, sc_session *session);
/* Prepare the volume of session->job, or map it if it is prepared already: fills session->volume.
 */
sc_status sc_session_load_one(sc_app *app, sc_session *session);
/* Free what a session holds its volume by. Collective. */
void sc_session_clear_volume(sc_session *session);

/* ---- phases.c: the volumes of a series, shown as the phases of a beat ---- */

/* As sc_session_load_one, of all phases of a series, or of the only volume: fills session->phases,
 * too. @return SC_ERR_DATA, logged, if phases differ in their grids or labels. */
sc_status sc_session_load(sc_app *app, sc_session *session);
/* Write to @p out a copy of @p app that keeps the phases of a session while they are read one after
 * the other: those of one file in a store, which the caller owns: sc_phase_store_free. @return
 * SC_ERR_MEMORY; the store is NULL then, as where there is none. Not collective. */
sc_status sc_begin_phase_store(sc_app *app, const sc_session *session, sc_app *out);
/* As sc_session_inspect, of all phases, or of the only volume. */
sc_status sc_session_inspect_all(sc_app *app, bool header_only, sc_session *session);
/* If the argument of a command that has no job file is a pattern, such as heart_*.nrrd, and no
 * file, let the series of files be phases of a beat, as the default. Not collective. */
sc_status sc_expect_series(sc_app *app);
/* @return the hash of the volume: of a series, of all its phases in their order. Not collective. */
uint64_t sc_phases_hash(const sc_session *session);
/* Begin a session @p out for phase @p phase alone, whose job is that of @p session with that volume
 * and no cine. It borrows from the job of @p session: sc_session_end_phase instead of
 * sc_session_clear. Not collective. */
void sc_session_begin_phase(const sc_session *session, int phase, sc_session *out);
/* The same for a phase that is interpolated between phase @p phase, which is prepared as @p before,
 * and the next one. The caller sets out->given on rank 0. Not collective. */
void sc_session_begin_between(const sc_session *session, int phase, const sc_prepared *before,
                              sc_session *out);
/* Refuse phase @p index of a session, @p b, if its grid or labels are not those of the first, @p a.
 * @param all labels of volumes whose voxels were read, so that the lack of one is known. Not
 * collective. @return SC_ERR_DATA. */
sc_status sc_check_phase(const sc_ctx *ctx, const sc_session *session, const sc_prepared *a,
                         const sc_prepared *b, int index, bool all);
/* Free what a session of a phase owns. Collective. */
void sc_session_end_phase(sc_session *phase);
/* Free phases; NULL is allowed. Collective. */
void sc_phases_free(sc_phases *phases);
/* Append the number of a phase to the name of a file, before its ending @p ending, with as many
 * digits as the last of @p count has, so that names sort. @param text empty; the caller clears it,
 * also after an error. Not collective. */
sc_status sc_phase_path(const sc_ctx *ctx, const char *path, const char *ending, int phase,
                        int count, sc_text *text);
/* ---- phase_memory.c: which phases are in the memory of a rank; not collective ---- */

/* @return how many phases a session has: 1 if its volume is no series. */
int sc_session_phase_count(const sc_session *session);
/* @return the volume of phase @p phase, borrowed. */
const sc_prepared *sc_session_phase_volume(const sc_session *session, int phase);
/* @return the renderer of phase @p phase; NULL before it is made. */
sc_renderer *sc_session_phase_renderer(const sc_session *session, int phase);
/* @return the phase that frame @p k of the session shows, which may be that of a shot. */
int sc_session_phase_at(const sc_session *session, int k);
/* As sc_session_phase_renderer of the phase of frame @p k, which is going to be drawn: the other
 * phases leave the memory of this rank, but for the one that was drawn before, and the system is
 * told which one may be next. */
sc_renderer *sc_session_begin_frame(const sc_session *session, int k);
/* Let a phase leave the memory of this rank, if it is in a file: its volume and what the session's
 * renderer of it has derived. It can be used as before. */
void sc_session_unload_phase(const sc_session *session, int phase);
/* Let all phases from which frames were drawn leave the memory of this rank; before their renderers
 * are freed. NULL is allowed. */
void sc_phases_unload(sc_phases *phases);
/* @return which share of what is prepared for a session, and derived from it, is in the memory of a
 * node at a time: 1 unless its phases are held in files. */
double sc_session_loaded_share(const sc_session *session);
/* Map the prepared file that session->job names on every rank, and make sure that it is the same
 * file on all: fills session->volume. @param usable whether the job can use it as it is; if not, a
 * warning says why, and it has to be prepared again. */
sc_status sc_session_map(const sc_app *app, sc_session *session, bool *usable);
/* Read the size in voxels from "phantom" or "phantom:WxDxH", the value of @p key. @return
 * SC_ERR_USAGE for another text. Not collective. */
sc_status sc_phantom_size(const sc_ctx *ctx, const char *key, const char *volume, int size[3]);
/* Log all tissues that the job names and that are not among the @p labels of its volume, and all
 * names that could stand for several. @return SC_ERR_DATA if there are any. Not collective. */
sc_status sc_check_tissues(const sc_ctx *ctx, const sc_job *job, const sc_label *labels,
                           int label_count);
/* Find the label table of a volume that has no names, where other programs look for it: for a
 * "..._dseg.nii.gz" of BIDS, a dseg.tsv whose words the name of the volume has, too, beside it or
 * above it in the data set; for an MGH file, FreeSurferColorLUT.txt beside it or in
 * $FREESURFER_HOME. It is told. @param out [SC_PATH_BYTES] its path; empty if there is none. */
void sc_find_labels(const sc_app *app, const char *volume, char *out);
/* Say where names and colours are to be had for a volume without a table whose numbers look like
 * those of FreeSurfer. */
void sc_hint_labels(const sc_app *app, const char *path, const sc_volume *volume);
/* Read a label table, or what the header of the volume at @p path says of its labels. @param volume
 * for which it is read, NULL: none; the numbers of a table must not be segcast's own unless those
 * of @p volume are. Caller owns *out: sc_label_table_clear, also after an error. */
sc_status sc_read_label_table(const sc_app *app, const char *path, sc_table_format format,
                              const sc_volume *volume, sc_label_table *out);
/* Read the label table of the job, if it names one, or else, if @p volume has no names, that of
 * sc_find_labels. Not collective. Caller owns *out, which may be empty: sc_label_source_clear. */
sc_status sc_read_labels_of(const sc_app *app, const sc_job *job, const sc_volume *volume,
                            sc_label_source *out);
/* Free the table and set @p source to zero. */
void sc_label_source_clear(sc_label_source *source);
/* Move @p source, or if it is empty the table of the file of @p volume, to app->label_source,
 * instead of what is there, if that is wanted. */
void sc_label_source_keep(const sc_app *app, const sc_job *job, sc_volume *volume,
                          sc_label_source *source);
/* Bring a table and the labels of a volume that has no numbers of its own (sc_volume.numbered)
 * together by their names: the labels get the numbers of their rows. Those of a mapped file, which
 * has ids NULL here and no scan, stay as they are, and the rows get theirs. If no name fits,
 * nothing changes, with a warning. @param scan that @p volume is of; NULL: none. Not collective.
 * @return SC_ERR_MEMORY. */
sc_status sc_match_labels(const sc_app *app, const sc_job *job, sc_label_source *source,
                          sc_volume *volume, sc_label_scan *scan);
/* Give @p volume the names and colours of its table (sc_read_labels_of, sc_match_labels), and keep
 * the table (sc_label_source_keep). Not collective. */
sc_status sc_apply_labels(const sc_app *app, const sc_job *job, sc_volume *volume,
                          sc_label_scan *scan);
/* Give colours to the tissues of @p volume that no table gives one, or not one that the job wants.
 * Not collective. @return SC_ERR_MEMORY. */
sc_status sc_color_tissues(const sc_app *app, const sc_job *job, sc_volume *volume);
/* @return whether a job changes its volume before anything else is done with it. */
bool sc_edits_volume(const sc_job *job);
/* Take from a job what it reads and changes of its volume. */
void sc_forget_volume_edits(sc_job *job);
/* Who reads a volume, for sc_read_choice.leave_out. */
typedef struct sc_keeping {
    const sc_app *app;
    const sc_job *job;
} sc_keeping;
/* Write what the job reads of its volume file to *out, which borrows from the job, and from @p
 * keeping, which is filled. @return
 * SC_ERR_DATA, logged, for a level or a box of what is no file. */
sc_status sc_read_choice_of(const sc_app *app, const sc_job *job, sc_keeping *keeping,
                            sc_read_choice *out);
/* Merge and leave out tissues of a volume, which has its names, and cut parts off, as the job says.
 * @param tell what was done. Not collective. @return SC_ERR_DATA: the job names tissues that are
 * not there, all are logged, or a box outside of the volume; SC_ERR_MEMORY. */
sc_status sc_edit_volume(const sc_app *app, const sc_job *job, bool tell, sc_volume *volume);
/* The same for what a scan has found, or for a header; without tallies nothing is cropped to what
 * is visible. */
sc_status sc_edit_scan(const sc_app *app, const sc_job *job, sc_label_scan *scan);
/* Fill in what can be known of the volume of session->job without preparing it: in session->volume
 * its size, geometry and labels, and in its label statistics their voxels and bounding boxes; the
 * rest stays empty. This takes one pass over the voxels, in bounded memory. With @p header_only
 * there is none: then the labels are those of the label tables and those that the job names by
 * number, and the boxes are empty. For a process that is the only rank. */
sc_status sc_session_inspect(sc_app *app, bool header_only, sc_session *session);
/* Read the grey volume of session->job, if it has one, once on every node, and choose its window:
 * fills session->grey and what goes with it, after sc_session_load. @return SC_ERR_DATA also for
 * one that lies nowhere in the box of the volume. */
sc_status sc_session_grey(sc_app *app, sc_session *session);
/* As sc_session_grey, for a subject whose grey volume is that of another one, which it borrows. */
sc_status sc_session_borrow_grey(sc_app *app, const sc_session *from, sc_session *session);
/* Check the header of the grey volume of session->job, if it has one, and where it lies. Not
 * collective. @return as sc_session_grey. */
sc_status sc_session_check_grey(const sc_app *app, const sc_session *session);
/* Resolve the tissues and clip sets of session->volume by the rules of the job: fills
 * session->tissues and session->clip_sets. */
sc_status sc_session_tissues(sc_app *app, sc_session *session);
/* The verbs of a job that move the camera. */
typedef struct sc_moves {
    sc_move moves[SC_VERBS_MAX]; /* [count] of them */
    int count;
    sc_vec3 *points[SC_VERBS_MAX]; /* [count] of them, those of the moves or NULL; owned */
} sc_moves;
/* Find the moves of session->job, after sc_session_tissues: with the lines along which they fly,
 * and all corners of the tissues that they frame, or those of boxes around them if there is no
 * renderer yet, and so perhaps no voxels. Not collective. Caller owns *out, also after an error:
 * sc_moves_clear. @return as sc_session_voxels and sc_find_line. */
sc_status sc_find_moves(const sc_app *app, const sc_session *session, sc_moves *out);
void sc_moves_clear(sc_moves *moves);
/* Fill session->timeline, framed on @p points (see sc_timeline_resolve), after sc_session_tissues.
 * Rank 0 does it, and warns of clip planes that leave nothing or do not cut what is shown; the
 * others get its result. @return as sc_find_moves. */
sc_status sc_session_timeline(sc_app *app, sc_session *session, const sc_vec3 *points,
                              size_t count);
/* Let session->timeline, which is resolved, know what else the frames of a session follow from: all
 * but the ways on which its camera flies. Not collective. */
void sc_session_looks(sc_session *session);
/* @return all that the overlays of a session follow from; borrowed from it. Not collective. */
sc_annotations sc_session_annotations(const sc_session *session);
/* Fill session->lettering, session->logo and, unless the voxels are not known, session->names, if
 * the job has overlays, after sc_session_timeline: rank 0 makes them, so that other ranks need no
 * fonts. If session->front is set, its lettering is made before. @return as sc_annotations_letter,
 * sc_annotations_logo and sc_annotations_plan_names. */
sc_status sc_session_letter(sc_app *app, sc_session *session);
/* Copy the voxels and the labels of a prepared volume. @return SC_ERR_MEMORY. Caller owns *out:
 * sc_volume_clear. Not collective. */
sc_status sc_copy_prepared(const sc_ctx *ctx, const sc_prepared *from, sc_volume *out);
/* A volume that was read for a job, and how it is to be prepared. */
typedef struct sc_volume_input {
    sc_volume volume;             /* owned */
    sc_prepare_settings settings; /* hidden and tissue_smooth are the arrays below; no team yet */
    bool *hidden;                 /* [label_count], owned: labels that became background */
    sc_vec3 *tissue_smooth;       /* [label_count], owned */
    bool resample; /* the job wants it on the grid on which it was drawn: sc_session_resample */
    sc_drawn_grid drawn; /* that grid, once it is measured: drawn_known */
    bool drawn_known;
} sc_volume_input;
/* On this rank alone: read the volume of session->job, and hide what the job does not show of it,
 * none if session->measure. @param times the durations are added to it, unless NULL. @param out
 * caller owns, also after an error: sc_volume_input_clear. Not collective. */
sc_status sc_session_read(const sc_app *app, const sc_session *session, sc_volume_input *out,
                          sc_rank_record *times);
/* On this rank alone: read the voxels of the volume of session->job as they stand in its file, or
 * in the prepared file that is mapped, with the names of its label table. Nothing is hidden,
 * resampled or coloured. @param out caller owns, also after an error: sc_volume_clear. Not
 * collective. */
sc_status sc_session_voxels(const sc_app *app, const sc_session *session, sc_volume *out);
/* A centre line that is asked for by names of tissues; see sc_centerline_request. Borrows. */
typedef struct sc_line_wish {
    const char *const *patterns; /* [pattern_count] names, globs or label numbers of tissues */
    size_t pattern_count;
    const sc_vec3 *through; /* [through_count], RAS mm */
    size_t through_count;
    double clearance;
    const char *where; /* "file:line" for messages; may be empty */
    bool middles;      /* from the middle of the tissues of a pattern to that of the next, instead
                        * of through points */
} sc_line_wish;
/* @return the first label that a line is to lead through and that a prepared volume has hidden, and
 * so lost; NULL: none. Not collective. */
const sc_label *sc_hidden_on_line(const sc_prepared *volume, const sc_line_wish *wish);
/* Refuse a prepared file, @p path, that has lost labels which a line is to lead through.
 * Not collective. @return SC_ERR_DATA. */
sc_status sc_check_line_voxels(const sc_ctx *ctx, const char *path, const sc_prepared *volume,
                               const sc_line_wish *wish);
/* Find a centre line, on this rank alone, and tell how long it is. @param volume with its ids.
 * @return as sc_pattern_check and sc_centerline_find. Caller owns *out: sc_centerline_clear. */
sc_status sc_find_line(const sc_app *app, const sc_volume *volume, const sc_line_wish *wish,
                       sc_centerline *out);
/* On this rank alone: bring a volume of which input->resample is set to the grid on which it was
 * drawn, and note in its settings what was done; resample becomes false. @param measured what was
 * measured of the volume; NULL: that is done here, unless session->drawn_known. @return
 * SC_ERR_MEMORY; then the volume can only be freed. Not collective. */
sc_status sc_session_resample(const sc_app *app, const sc_session *session,
                              const sc_drawn_grid *measured, sc_volume_input *input);
/* Free what @p input owns. */
void sc_volume_input_clear(sc_volume_input *input);
/* On this rank alone: read the volume of session->job into @p input and prepare what the job shows
 * of it; all of it if session->measure. @param preparation borrows @p input. Caller owns both
 * outputs, also after an error: sc_preparation_free, then sc_volume_input_clear. Not collective. */
sc_status sc_session_prepare(const sc_app *app, const sc_session *session, sc_volume_input *input,
                             sc_preparation **preparation);
/* Do everything between sc_session_job and the first sc_session_draw: load the volume, resolve the
 * tissues, make the renderer and the timeline. */
sc_status sc_session_volume(sc_app *app, sc_session *session);
/* Allocate a picture of the kind that the job draws: of its size, and with alpha if it has no
 * background. Not collective. @return SC_ERR_MEMORY. Caller owns: sc_image_clear. */
sc_status sc_session_image(const sc_app *app, const sc_session *session, sc_image *out);
/* Draw frame @p k, or @p rows of it, in the layout of the job, into @p image, which is as of
 * sc_session_image. The layout views may also write to other rows. One call at a time per
 * session. Not collective. */
sc_status sc_session_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                          sc_image *image, sc_render_stats *stats);
/* ---- session.c, session_draw.c: one shot, or a job without shots ---- */

/* Make session->renderer, after sc_session_tissues, together with the other ranks of the node. */
sc_status sc_shot_renderer(const sc_app *app, sc_session *session);
/* Fill what is left after sc_session_tissues and sc_shot_renderer: timeline and lettering. */
sc_status sc_shot_timeline(sc_app *app, sc_session *session);
/* As sc_session_draw, of a scene of the shot. */
sc_status sc_shot_draw(const sc_app *app, sc_session *session, const sc_scene *scene,
                       const sc_rows *rows, sc_image *image, sc_render_stats *stats);
/* Free what a shot has for itself: all but the volume and the job. On this rank alone. */
void sc_shot_clear(sc_session *session);
/* @return the scene of frame @p k of a shot or a subject, in session->room. Not collective. */
static inline sc_scene sc_session_scene_at(const sc_session *session, int k)
{
    return sc_timeline_scene(&session->timeline, k, &session->room);
}
/* Fill @p rows of a picture, NULL: all, with the background of a frame. Not collective. */
void sc_draw_background(const sc_scene *scene, const sc_rows *rows, sc_image *image);

/* ---- subjects.c: what the subjects of a comparison have in common ---- */

/* @return how many subjects are compared by the job: 1 without a comparison. */
int sc_subject_count(const sc_job *job);
/* Give the tissues of a subject, which are resolved, the looks that they have in session->owners,
 * if these are subjects before it. Not collective. */
void sc_take_looks(sc_session *session);
/* @return subject @p i of those that are framed and moved together with a session: the session
 * itself, unless it is a subject; NULL behind the last. */
const sc_session *sc_framed_with(const sc_session *session, int i);

/* ---- compare.c, compare_draw.c: several volumes in one picture ---- */

/* Begin the comparison of session->job, if it has one, when its own volume is there: load the
 * volumes of the other subjects. */
sc_status sc_compare_load(sc_app *app, sc_session *session);
/* The same when it was inspected: the others are inspected, too (sc_session_inspect). */
sc_status sc_compare_inspect(sc_app *app, bool header_only, sc_session *session);
/* Read the grey volumes of all subjects, after sc_compare_load; those of the same path once. */
sc_status sc_compare_grey(sc_app *app, sc_session *session);
/* As sc_session_check_grey, of all subjects, after sc_compare_inspect. */
sc_status sc_compare_check_grey(const sc_app *app, const sc_session *session);
/* Resolve the tissues of all subjects. */
sc_status sc_compare_tissues(sc_app *app, sc_session *session);
/* Fill the timelines of all subjects, framed on @p points, and what is written onto pictures, after
 * sc_compare_tissues and, unless the volumes were only inspected, the renderers. @return as
 * sc_session_timeline and sc_session_letter. */
sc_status sc_compare_timeline(sc_app *app, sc_session *session, const sc_vec3 *points,
                              size_t count);
/* All that is left after sc_compare_load. */
sc_status sc_compare_scene(sc_app *app, sc_session *session);
/* @return the session of subject @p i, and behind them of what is written beside the pictures; NULL
 * behind the last, and without a comparison. Not collective. */
sc_session *sc_compare_part(const sc_session *session, int i);
/* @return what is written below the picture of subject @p i. Not collective. */
const char *sc_compare_name(const sc_session *session, int i);
/* As sc_session_draw. */
sc_status sc_compare_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                          sc_image *image, sc_render_stats *stats);
/* As sc_session_counts. */
void sc_compare_counts(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                       sc_render_stats *stats);
/* @return the hash of what a session shows: its volume, or all phases or all subjects in their
 * order. Not collective. */
uint64_t sc_session_volume_hash(const sc_session *session);
/* @return the bytes of the prepared volume of a session, or of those of all subjects. Not
 * collective. */
uint64_t sc_session_prepared_bytes(const sc_session *session);
/* @return the bytes of the grey volumes of a session and of its subjects, of which a node holds
 * each once. Not collective. */
uint64_t sc_session_grey_bytes(const sc_session *session);
/* Free session->compare; nothing if there is none. Collective. */
void sc_compare_free(sc_session *session);

/* ---- film.c: the shots of a film ---- */

/* Make the sessions of the shots of session->job, if it has any, when its volume is there, and
 * resolve their tissues: an automatic background is the same in all of them. */
sc_status sc_film_open(sc_app *app, sc_session *session);
/* @return how many shots a session has: at least 1. Not collective. */
int sc_film_shot_count(const sc_session *session);
/* @return the session of shot @p i: the session itself if it has no shots. Not collective. */
sc_session *sc_film_shot(sc_session *session, int i);
/* @return renderer @p i of those that the shots of a session draw with; NULL behind the last of
 * them. Not collective. */
sc_renderer *sc_film_renderer(const sc_session *session, int i);
/* @return the bytes of all of them: sc_renderer_bytes, and *derived sc_renderer_derived_bytes. Not
 * collective. */
uint64_t sc_film_renderer_bytes(const sc_session *session, uint64_t *derived);
/* As sc_session_draw, for the farm: fill in the timing record except wait_s, rank and hash, which
 * are the farm's. @return SC_ERR_INCOMPLETE if the frame was given up (sc_signals_give_up). */
sc_status sc_session_draw_frame(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                                sc_image *image, sc_frame_result *result);
/* @return width divided by height of the picture in space within a frame. */
double sc_session_aspect(const sc_session *session);
/* Count the work of each pixel in a picture of frame @p k in space, of @p size_px; see
 * sc_render_counts. Not collective. */
void sc_session_counts(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                       sc_render_stats *stats);
/* The second part of sc_session_volume: all but the volume, which is there. */
sc_status sc_session_scene(sc_app *app, sc_session *session);
/* Move the volume from one session to another, whose job needs it prepared in the same way. What
 * the first one still has cannot be drawn any more, and is freed by sc_session_clear. Not
 * collective. */
void sc_session_move_volume(sc_session *from, sc_session *to);
/* Free everything. A zeroed session is allowed. Collective. */
void sc_session_clear(sc_session *session);

/* Warn of clip planes given in mm that remove everything or nothing in all frames, and of frames
 * that are empty because of them. Needs session->timeline. Not collective. */
void sc_warn_of_planes(const sc_app *app, const sc_session *session);
/* Warn if the zoom of session->timeline moves some of @p points out of the picture, which would be
 * in it without the zoom. @param aspect width of the picture divided by its height. Not collective.
 * @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_warn_of_zoom(const sc_app *app, const sc_session *session, double aspect,
                                      const sc_vec3 *points, size_t count);

#endif
