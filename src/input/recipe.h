/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to input: the steps from the file of a volume to the labels that are prepared. */
#ifndef SC_INPUT_RECIPE_H
#define SC_INPUT_RECIPE_H

#include "segcast/input.h"

/* ---- needs.c: what a job asks of the preparation of its volume; see sc_prepare_settings ---- */

typedef struct sc_needs {
    sc_vec3 smooth;
    sc_vec3 *tissue_smooth; /* [label_count], owned */
    bool as_prepared; /* accept a prepared file with any grid and strengths: it is only described */
    bool resample;    /* to the grid on which the volume was drawn */
    bool resize;      /* to volume_size, before anything else */
    int size[3];      /* that many voxels */
    bool local_thickness;
    bool *hidden; /* [label_count], owned: labels that become background */
} sc_needs;
/* Fill in what a job, or each of its shots, needs. No label is hidden with @p measure. @return
 * SC_ERR_MEMORY. Caller owns @p out: sc_needs_clear. */
sc_status sc_needs_find(const sc_app *app, const sc_job *job, bool measure, const sc_label *labels,
                        int label_count, sc_needs *out);
/* Free the arrays of @p needs. */
void sc_needs_clear(sc_needs *needs);

/* ---- place.c: errors about a file that a job names begin with the place that names it ---- */

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

/* ---- recipe.c ---- */

/* The steps, in their order. */
typedef enum sc_step {
    SC_STEP_TAKE,   /* get the volume: from its file, or what is known of it already */
    SC_STEP_RESIZE, /* to the number of voxels that the job asks for */
    SC_STEP_NAME,   /* by the label table */
    SC_STEP_EDIT,   /* merge, keep, box, resample */
    SC_STEP_COLOR,  /* tissues that have no colour */
    SC_STEP_CHECK,  /* that there is something to see, and what the job names */
    SC_STEP_HIDE,   /* what the job does not show, and decide how to prepare the rest */
    SC_STEP_COUNT
} sc_step;
/* A volume on its way. */
typedef struct sc_recipe {
    const sc_app *app;
    const sc_job *job;
    const sc_input *input; /* what is given or held of it already */
    sc_volume *volume;
    sc_read_depth depth; /* what is known of it: without ids the last steps are not done */
    bool is_fixed;       /* of a volume: it is mapped, so that its voxels do not change */
    bool tell;           /* what is edited */
    sc_edited *edited;   /* what SC_STEP_HIDE fills in; else NULL */
    unsigned done;       /* the steps that were done before: bits by sc_step */
} sc_recipe;
/* Give the labels of a mapped volume, a copy of which is in @p labels, the names of the job, and
 * the colours if the job wants others than those of the file. */
sc_status sc_name_mapped(const sc_app *app, const sc_job *job, const sc_input *input,
                         sc_volume *labels);
/* Find what is known of a volume that is not prepared without its voxels in memory, and name and
 * edit it. Caller owns *out, also after an error: sc_volume_clear. */
sc_status sc_scan_labels(const sc_app *app, const sc_job *job, const sc_input *input,
                         bool header_only, sc_volume *out);
/* On this rank alone: read the volume of a job, and hide what the job does not show of it, none if
 * input->measure. @param times the durations are added to it, unless NULL. @param out caller owns,
 * also after an error: sc_edited_clear. */
sc_status sc_input_read(const sc_app *app, const sc_job *job, const sc_input *input,
                        sc_rank_record *times, sc_edited *out);
/* On this rank alone: bring a volume of which edited->resample is set to the grid on which it was
 * drawn, and note in its settings what was done; resample becomes false. @param measured what was
 * measured of the volume; NULL: that is done here, unless input->drawn_known. @return
 * SC_ERR_MEMORY; then the volume can only be freed. */
sc_status sc_input_resample(const sc_app *app, const sc_job *job, const sc_input *input,
                            const sc_drawn_grid *measured, sc_edited *edited);

/* ---- kept.c: what was prepared, kept for the next command ---- */

/* Write the path under which the preparation of @p edited is kept to *out, on rank 0; NULL: nothing
 * is kept. @return SC_ERR_MEMORY. Caller owns *out: sc_free. */
sc_status sc_kept_path(const sc_ctx *ctx, const sc_input *input, const sc_edited *edited,
                       char **out);
/* If there is what sc_kept_add has kept under *path, which rank 0 names, map it on all ranks: fill
 * input->kept, bytes and volume, with the labels of @p edited. Where the ranks do not see the same
 * file, *path becomes NULL: it is of no use to them. @param path of others than rank 0, and for
 * nothing: NULL. Collective. @return SC_ERR_MEMORY, the same on all ranks. */
sc_status sc_kept_find(const sc_app *app, const sc_edited *edited, char **path, sc_input *input,
                       bool *found);
/* Keep a preparation under @p path, NULL for nowhere, if it is worth that, with what pictures are
 * drawn from. That it cannot be kept is no error. Collective in the team of the preparation.
 * @param preparation NULL on ranks that have no part in it. @param cpu_s what it has cost rank 0.
 * @return whether it is kept now, on all ranks. */
bool sc_kept_add(const sc_app *app, const char *path, sc_preparation *preparation, double cpu_s);

/* ---- prepared_file.c ---- */

/* Map the prepared file @p path on every rank. It is checked by the first rank of a node; the
 * others take its word if they have mapped the same file, and check by themselves if they have not,
 * or if the ranks cannot share memory to talk by. Errors are told by @p ctx. Collective on the
 * node.
 * @return of mapping, or of the check; what the first rank has found wrong, others find as well.
 * Caller owns *file, which is NULL before: sc_unmap_prepared. */
sc_status sc_map_prepared(const sc_app *app, const sc_ctx *ctx, const char *path,
                          sc_watched_file **file, sc_prepared *out);
/* End that, and set *file to NULL; NULL is allowed. */
void sc_unmap_prepared(sc_watched_file **file);
/* Give the volume of an input the @p labels of rank 0: input->labels becomes a copy of them.
 * Collective. @return SC_ERR_MEMORY, the same on all ranks. */
sc_status sc_share_labels(const sc_app *app, const sc_label *labels, sc_input *input);

/* ---- labels.c, sidecar.c: SC_STEP_NAME ---- */

/* Give a volume the names and colours of its table, by number, or by name where the volume has no
 * numbers of its own; of a header, also the labels of the tables and of the job. */
sc_status sc_name_labels(sc_recipe *r);
/* A visit to a pattern by which a job names tissues. @param where "file:line"; may be empty. */
typedef sc_status sc_pattern_fn(void *user, const char *pattern, const char *where);
/* Visit the patterns of a job and of its shots: the tissues that are drawn, not those that are
 * edited before. @return the first error. */
sc_status sc_each_pattern(const sc_job *job, sc_pattern_fn *visit, void *user);
/* Say where names and colours are to be had for a volume without a table whose numbers look like
 * those of FreeSurfer. */
void sc_hint_labels(const sc_app *app, const char *path, const sc_volume *volume);

/* ---- edit.c: SC_STEP_EDIT ---- */

/* @return whether a job changes its volume before anything else is done with it. */
bool sc_edits_volume(const sc_job *job);
/* Take from a job what it reads and changes of its volume. */
void sc_forget_volume_edits(sc_job *job);
/* Write what the job reads of its volume file to *out, which borrows from the recipe. @return
 * SC_ERR_DATA, logged, for a level or a box of what is no file. */
sc_status sc_read_choice_of(sc_recipe *r, sc_read_choice *out);
/* Merge and leave out tissues of a volume, which has its names, and cut parts off, as the job says.
 * Without ids and tallies nothing is cropped to what is visible. @return SC_ERR_DATA: the job
 * names tissues that are not there, all are logged, or a box outside of the volume; SC_ERR_MEMORY.
 */
sc_status sc_edit_volume(sc_recipe *r);

#endif
