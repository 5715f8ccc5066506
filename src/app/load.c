/* SPDX-License-Identifier: BSD-3-Clause */
/* The volume of a job: mapped by every rank from a prepared file, or read by rank 0 and brought to
 * the grid on which it was drawn. */
#include "app.h"

#include "segcast/phantom.h"
#include "segcast/resample.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void sc_add_time(const sc_app *app, sc_rank_record *times, sc_phase phase, double wall_s,
                 double cpu_s)
{
    static const sc_trace_kind kinds[SC_PHASE_COUNT] = {[SC_PHASE_READ] = SC_TRACE_READ,
                                                        [SC_PHASE_PREPARE] = SC_TRACE_PREPARE,
                                                        [SC_PHASE_SHARE] = SC_TRACE_SHARE};

    if (!times)
        return;
    if (app->trace && phase <= SC_PHASE_SHARE)
        sc_trace_add(app->trace, kinds[phase], 0, -1, wall_s, sc_wall_s());
    times->phases[phase].wall_s += sc_wall_s() - wall_s;
    times->phases[phase].cpu_s += sc_cpu_s() - cpu_s;
}

sc_status sc_phantom_size(const sc_ctx *ctx, const char *volume, int size[3])
{
    int used = 0;

    size[0] = SC_PHANTOM_WIDTH;
    size[1] = SC_PHANTOM_DEPTH;
    size[2] = SC_PHANTOM_HEIGHT;
    if (strcmp(volume, "phantom") &&
        (sscanf(volume, "phantom:%dx%dx%d%n", &size[0], &size[1], &size[2], &used) != 3 ||
         volume[used]))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "volume is \"%s\", expected phantom or for example phantom:128x96x128",
                       volume);
    return SC_OK;
}

/* Voxelise the phantom at the size in @p text. Caller owns *out: sc_volume_clear. */
static sc_status make_phantom(const sc_app *app, const char *text, sc_volume *out)
{
    sc_phantom *phantom = NULL;
    int size[3];
    sc_status status;

    SC_TRY(sc_phantom_size(app->ctx, text, size));
    SC_TRY(sc_volume_memory_check(app->ctx, text, size, 0));
    SC_TRY(sc_phantom_new(app->ctx, &phantom));
    status = sc_phantom_volume(app->ctx, phantom, size, app->threads, out);
out:
    sc_phantom_free(phantom);
    return status;
}

/* @return whether a table has named a label of @p volume. */
static bool has_names(const sc_volume *volume)
{
    for (int id = 1; id < volume->label_count; id++) {
        if (volume->labels[id].name[0])
            return true;
    }
    return false;
}

sc_status sc_read_labels_of(const sc_app *app, const sc_job *job, const sc_volume *volume,
                            sc_label_source *out)
{
    const bool named = job->labels[0];

    *out = (sc_label_source){0};
    if (named)
        snprintf(out->path, sizeof out->path, "%s", job->labels);
    else if (!has_names(volume))
        sc_find_labels(app, job->volume, out->path);
    if (!out->path[0])
        return SC_OK;
    return sc_label_table_read(app->ctx, out->path,
                               named ? (sc_table_format)job->labels_format : SC_TABLE_AUTO,
                               &out->table);
}

void sc_label_source_clear(sc_label_source *source)
{
    sc_label_table_clear(&source->table);
    *source = (sc_label_source){0};
}

void sc_label_source_keep(const sc_app *app, sc_label_source *source)
{
    if (!app->label_source)
        return;
    sc_label_source_clear(app->label_source); /* a prepared file may be read twice */
    *app->label_source = *source;
    *source = (sc_label_source){0};
}

sc_status sc_apply_labels(const sc_app *app, const sc_job *job, sc_volume *volume)
{
    sc_label_source source;
    const sc_status status = sc_read_labels_of(app, job, volume, &source);

    if (status == SC_OK)
        sc_volume_apply_table(volume, &source.table);
    if (status == SC_OK)
        sc_label_source_keep(app, &source);
    sc_label_source_clear(&source);
    return status;
}

/* What a job needs of a preparation; see sc_prepare_settings. */
typedef struct needs {
    sc_vec3 smooth;
    sc_vec3 *tissue_smooth; /* [label_count], owned */
    bool resample;          /* to the grid on which the volume was drawn */
    bool resize;            /* to volume_size, before anything else */
    int size[3];            /* that many voxels */
    bool thickness, local_thickness, surface;
    bool *hidden; /* [label_count], owned: labels that become background */
} needs;

/* Free the arrays of @p n. */
static void clear_needs(needs *n)
{
    sc_free(n->hidden);
    sc_free(n->tissue_smooth);
}

/* Add what one job, or one shot, needs. @param is_first hidden labels are those of this one;
 * otherwise they stay hidden only if this one hides them, too. */
static sc_status add_needs(const sc_app *app, const sc_job *job, const sc_label *labels,
                           int label_count, bool is_first, needs *n)
{
    const sc_color_by *by = &job->color_by;
    bool thickness = false;
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(app->ctx, (size_t)label_count, sizeof(bool), &block));
    SC_TRY(sc_hidden_labels(app->ctx, labels, label_count, job->rules, job->rule_count, block,
                            &thickness));
    for (int id = 0; id < label_count; id++)
        n->hidden[id] = (is_first || n->hidden[id]) && ((bool *)block)[id];
    n->local_thickness = n->local_thickness || job->render.thickness != 0;
    n->thickness =
        n->thickness || thickness || (by->has_measure && by->measure == SC_MEASURE_THICKNESS);
    n->surface = n->surface || (by->has_measure && by->measure == SC_MEASURE_SURFACE);
out:
    sc_free(block);
    return status;
}

/* Fill in what the job of a session, or each of its shots, needs. No label is hidden if
 * session->measure. Caller owns @p out: clear_needs. */
static sc_status find_needs(const sc_app *app, const sc_session *session, const sc_label *labels,
                            int label_count, needs *out)
{
    const sc_job *job = &session->job;
    const bool is_auto = sc_smooth_is_auto(job->render.smooth);
    needs n = {.smooth = is_auto ? (sc_vec3){SC_SMOOTH_AUTO, SC_SMOOTH_AUTO, SC_SMOOTH_AUTO}
                                 : job->render.smooth,
               .resample = is_auto && job->render.surface == SC_SURFACE_SMOOTH &&
                           !session->measure && !job->has_volume_size,
               .resize = job->has_volume_size,
               .thickness = session->measure,
               .surface = session->measure};
    bool is_first = true;
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(app->ctx, (size_t)label_count, sizeof(bool), &block));
    n.hidden = block;
    SC_TRY(sc_alloc(app->ctx, (size_t)label_count, sizeof(sc_vec3), &block));
    n.tissue_smooth = block;
    sc_tissue_strengths(labels, label_count, job->rules, job->rule_count, n.smooth,
                        n.tissue_smooth);
    if (!job->shot_count)
        SC_TRY(add_needs(app, job, labels, label_count, true, &n));
    for (size_t i = 0; i < job->shot_count; i++) {
        if (job->shots[i].has_card)
            continue;
        SC_TRY(add_needs(app, &job->shots[i].job, labels, label_count, is_first, &n));
        is_first = false;
    }
    if (session->measure)
        memset(n.hidden, 0, (size_t)label_count * sizeof *n.hidden);
    memcpy(n.size, job->volume_size, sizeof n.size);
    *out = n;
    return SC_OK;
out:
    clear_needs(&n);
    return status;
}

/* ---- prepared files: every rank maps the file; a node holds it once, and checks it once ---- */

/* What the first rank of a node tells the others of the file that it has mapped and checked. */
typedef struct checked_file {
    sc_file_identity identity;
    uint64_t hash; /* of the file */
    int64_t word;  /* HAS_CHECKED, HAS_FAILED; 0 of those that only listen */
} checked_file;
enum { HAS_CHECKED = 1, HAS_FAILED = 2 };

/* @return what the one rank of a team that has checked its file says, of @p all [count]. */
static const checked_file *word_of(const checked_file *all, int count)
{
    int i = 0;

    while (i < count - 1 && !all[i].word)
        i++;
    return &all[i];
}

/* View the mapped file of a session. It is checked by the first rank of a node; the others take its
 * word if they have mapped the same file, and check by themselves if they have not, or if the ranks
 * cannot share memory to talk by. @param mapped the return code of mapping on this rank. @param
 * identity of the mapped file. @return of mapping, or of the check; what the first rank has found
 * wrong, others find as well. Collective on the node. */
static sc_status view_file(const sc_app *app, const sc_ctx *ctx, sc_session *session,
                           sc_status mapped, const sc_file_identity *identity)
{
    const sc_ctx silent = {.rank = 0};
    checked_file mine = {.identity = *identity};
    const checked_file *told;
    sc_team *team = NULL;
    void *all = NULL;
    bool first = true, trusted = false;
    sc_status status = mapped;

    if (sc_team_open(&silent, app->comm, 1, NULL, &team) == SC_OK)
        first = sc_team_is_first(team);
    if (first && status == SC_OK)
        status = sc_prepared_file_view(ctx, session->job.volume, session->mapped,
                                       session->mapped_bytes, &session->volume);
    if (first) {
        mine.hash = session->volume.file_hash;
        mine.word = status == SC_OK ? HAS_CHECKED : HAS_FAILED;
    }
    if (team && sc_team_collect(&silent, team, &mine, sizeof mine, &all) == SC_OK) {
        told = word_of(all, sc_team_ranks(team));
        trusted =
            told->word == HAS_CHECKED && memcmp(&told->identity, identity, sizeof *identity) == 0;
        mine.hash = told->hash;
    }
    if (!first && status == SC_OK && trusted) {
        status = sc_prepared_view(ctx, session->mapped, session->mapped_bytes, &session->volume);
        session->volume.file_hash = mine.hash;
    } else if (!first && status == SC_OK) {
        status = sc_prepared_file_view(ctx, session->job.volume, session->mapped,
                                       session->mapped_bytes, &session->volume);
    }
    sc_team_close(team);
    return status;
}

/* What a rank reports of the file that it has mapped. Sent as bytes. */
typedef struct mapped_file {
    uint64_t hash;
    int32_t status;
    char host[SC_HOST_BYTES];
} mapped_file;

/* @return words for what a rank has mapped instead of rank 0's file. */
static const char *difference_of(const mapped_file *file)
{
    return file->status == SC_OK            ? "another file"
           : file->status == SC_ERR_MISSING ? "no such file"
                                            : "a damaged file";
}

/* Make sure that all ranks have mapped the same file: the same path can name different files on
 * different nodes (a node's own disk, a copy that was not renewed). Rank 0 compares and logs.
 * @param mine the return code of mapping on this rank. Collective, the same result on all ranks. */
static sc_status agree_on_file(const sc_app *app, const sc_session *session, sc_status mine)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const int ranks = sc_comm_size(app->comm);
    mapped_file file = {.hash = session->volume.file_hash, .status = mine}, *all;
    int different = 0, example = 0;
    void *block = NULL;
    sc_status status = SC_OK;

    sc_host_name(file.host);
    if (first)
        status = sc_alloc(app->ctx, (size_t)ranks, sizeof file, &block);
    SC_TRY(sc_comm_agree(app->comm, status));
    all = block;
    sc_comm_gather(app->comm, &file, sizeof file, all);
    for (int i = ranks - 1; first && i > 0; i--) {
        if (all[i].status != SC_OK || all[i].hash != all[0].hash) {
            different++;
            example = i;
        }
    }
    status = mine;
    if (mine == SC_OK && different &&
        (all[example].status == SC_ERR_MEMORY || all[example].status == SC_ERR_WRITE))
        status =
            sc_fail(app->ctx, (sc_status)all[example].status,
                    "%s: rank %d on %s could not map the file into memory: %s", session->job.volume,
                    example, all[example].host,
                    all[example].status == SC_ERR_MEMORY ? "out of memory" : "reading it failed");
    else if (mine == SC_OK && different)
        status = sc_fail(app->ctx, SC_ERR_DATA,
                         "%s: is not the same on all nodes: rank 0 has mapped it on %s, but %d of "
                         "%d ranks have not, the first of them rank %d, which has %s on %s; copy "
                         "the file to all nodes, or put it on a file system that they share",
                         session->job.volume, all[0].host, different, ranks, example,
                         difference_of(&all[example]), all[example].host);
    if (!first)
        status = SC_OK; /* rank 0 decides for all */
    status = sc_comm_agree(app->comm, status);
out:
    sc_free(block);
    return status;
}

/* Give colours to the tissues that no table gives one, or not one that the job wants. */
static sc_status color_volume(const sc_app *app, const sc_job *job, sc_volume *volume)
{
    const sc_appearance appearance = (sc_appearance)job->appearance;
    int cover;
    sc_status status;

    if (!sc_volume_lacks_colors(volume, appearance))
        return SC_OK;
    SC_TRY(sc_find_outer_cover(app->ctx, volume, &cover));
    SC_TRY(sc_volume_color(app->ctx, volume, cover, appearance, app->threads));
out:
    return status;
}

/* Give the labels of a mapped file the names and colours of the job's label table, which rank 0
 * reads: session->labels becomes a copy of them. Collective, the same result on all ranks. */
static sc_status share_labels(const sc_app *app, sc_session *session)
{
    const size_t bytes = (size_t)session->volume.label_count * sizeof(sc_label);
    sc_volume named = sc_volume_of_prepared(&session->volume);
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_comm_agree(app->comm, sc_alloc(app->ctx, bytes, 1, &block)));
    memcpy(block, session->volume.labels, bytes);
    named.labels = block;
    if (sc_comm_rank(app->comm) == 0)
        status = sc_apply_labels(app, &session->job, &named);
    /* Colours have been found when the file was prepared; others are found only if the job wants.
     */
    if (sc_comm_rank(app->comm) == 0 && status == SC_OK &&
        session->job.appearance != SC_APPEARANCE_TABLE)
        status = color_volume(app, &session->job, &named);
    SC_TRY(sc_comm_agree(app->comm, status));
    sc_comm_broadcast(app->comm, block, bytes);
    session->labels = block;
    session->volume.labels = block;
    block = NULL;
out:
    sc_free(block);
    return status;
}

/* @return whether a mapped file holds the grid from which the job's surfaces are taken. */
static bool has_grid(const sc_app *app, const sc_prepared *v, const needs *n)
{
    const sc_volume view = sc_volume_of_prepared(v);
    const sc_ctx silent = {.rank = 0};
    sc_drawn_grid grid;

    if (n->resize && memcmp(v->size, n->size, sizeof n->size) != 0)
        return false;
    if (!n->resample || v->resampled)
        return n->resample == v->resampled;
    if (v->as_drawn)
        return true;
    return sc_find_drawn_grid(&silent, &view, app->threads, &grid) == SC_OK &&
           !sc_is_resampled(&grid);
}

/* @return whether the tissues of a mapped file that the job shows are smoothed as it wants. */
static bool has_strengths(const sc_prepared *v, const needs *n)
{
    for (int id = 1; id < v->label_count; id++) {
        if (v->stats[id].voxels && !n->hidden[id] &&
            !sc_strength_is_same(v->smooth[id], n->tissue_smooth[id]))
            return false;
    }
    return true;
}

/* Does the prepared file hold what the job needs? @param why if not, what it was prepared with
 * instead; otherwise NULL. */
static bool fits(const sc_app *app, const sc_prepared *v, const needs *n, const char **why)
{
    *why = NULL;
    if (!has_grid(app, v, n))
        *why = "another grid of voxels";
    else if (!has_strengths(v, n))
        *why = "another strength of smoothing";
    else if ((n->thickness && !v->has_thickness) || (n->surface && !v->has_surface))
        *why = "less measured";
    else if (n->local_thickness && !v->thickness)
        *why = "no local thickness";
    for (int id = 1; id < v->label_count && !*why; id++) {
        if (n->hidden[id] && !v->hidden[id] && v->stats[id].voxels)
            *why = "tissues that the job hides";
    }
    return !*why;
}

/* Refuse a prepared file in which a tissue that the job shows was turned into background. */
static sc_status check_hidden(const sc_ctx *ctx, const char *path, const sc_session *session,
                              const needs *n)
{
    for (int id = 1; id < session->volume.label_count && !session->measure; id++) {
        if (session->volume.hidden[id] && !n->hidden[id])
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: was prepared without \"%s\" (label %lld), which the job shows; "
                           "prepare it again",
                           path, session->volume.labels[id].name,
                           (long long)session->volume.labels[id].value);
    }
    return SC_OK;
}

/* Have a message name the file that a session has mapped, should it be cut off meanwhile. */
static sc_status watch(const sc_ctx *ctx, const char *path, sc_session *session)
{
    const size_t bytes = 4 * strlen(path) + 1; /* a byte is shown by 4 characters at most */
    void *name = NULL, *block = NULL;
    sc_status status;

    SC_TRY(sc_alloc(ctx, bytes, 1, &name));
    SC_TRY(sc_alloc(ctx, 1, sizeof *session->watched, &block));
    sc_printable(path, name, bytes);
    session->watched = block;
    *session->watched = (sc_watched_file){name, session->mapped, session->mapped_bytes};
    name = NULL;
    sc_signals_watch_file(session->watched);
out:
    sc_free(name);
    return status;
}

sc_status sc_session_map(const sc_app *app, sc_session *session, bool *usable)
{
    const char *path = session->job.volume, *why = NULL;
    uint8_t fitting;
    const bool first = sc_comm_rank(app->comm) == 0;
    const sc_ctx silent = {.rank = 0};
    const sc_ctx *ctx = first ? app->ctx : &silent;
    sc_file_identity identity = {0};
    needs n = {0};
    sc_status status;

    if (sc_edits_volume(&session->job))
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: is prepared, and merge, keep and crop change a volume before that: give "
            "them to `segcast prepare JOB.yaml`, or the volume that it was made from",
            path);
    sc_stage_begin(ctx, "checking the prepared volume", 0, 0);
    status = sc_file_map_identified(ctx, path, &session->mapped, &session->mapped_bytes, &identity);
    if (status == SC_OK)
        status = watch(ctx, path, session);
    status = view_file(app, ctx, session, status, &identity);
    SC_TRY(agree_on_file(app, session, status));
    SC_TRY(share_labels(app, session));
    status = find_needs(app, session, session->volume.labels, session->volume.label_count, &n);
    SC_TRY(sc_comm_agree(app->comm, status));
    SC_TRY(check_hidden(ctx, path, session, &n));
    if (session->volume.resampled && !n.resample && !session->measure) {
        status = sc_fail(ctx, SC_ERR_DATA,
                         "%s: was prepared with render.smooth: auto, which has changed its grid of "
                         "voxels; prepare the volume again with the settings of this job",
                         path);
        goto out;
    }
    /* Rank 0 decides for all: measuring the grid takes memory, which may fail on one rank only. */
    fitting = first && fits(app, &session->volume, &n, &why);
    sc_comm_broadcast(app->comm, &fitting, sizeof fitting);
    *usable = fitting != 0;
    if (*usable)
        session->shared_bytes = session->mapped_bytes;
    else if (first)
        sc_warn(app->ctx,
                "%s: was prepared with %s; that is done anew, which takes seconds each time: "
                "`segcast prepare` with the job instead of the volume makes a file that fits",
                path, why);
out:
    clear_needs(&n);
    return status;
}

/* Copy the voxels and labels of the mapped file, in order to prepare them with other settings.
 * Caller owns *out: sc_volume_clear. */
static sc_status unpack_volume(const sc_app *app, const sc_session *session, sc_volume *out)
{
    const sc_prepared *from = &session->volume;
    sc_volume v = sc_volume_of_prepared(from);
    void *labels;
    sc_status status;

    v.ids = NULL;
    v.labels = NULL;
    SC_TRY(sc_alloc(app->ctx, sc_volume_voxels(&v), (size_t)v.label_bytes, &v.ids));
    memcpy(v.ids, from->ids, sc_volume_voxels(&v) * (size_t)v.label_bytes);
    SC_TRY(sc_alloc(app->ctx, (size_t)v.label_count, sizeof *v.labels, &labels));
    v.labels = labels;
    memcpy(v.labels, from->labels, (size_t)v.label_count * sizeof *v.labels);
    *out = v;
    return SC_OK;
out:
    sc_volume_clear(&v);
    return status;
}

/* As sc_check_tissues, of one job, or of one shot, whose rules from the film have been checked. */
static sc_status check_tissues_of(const sc_ctx *ctx, const sc_job *job, const sc_prepared *view)
{
    const sc_status rules = sc_tissue_rules_check(ctx, view, job->rules + job->film_rules,
                                                  job->rule_count - job->film_rules);
    sc_status exceptions = SC_OK, verbs = SC_OK, overlays = SC_OK;

    if (rules == SC_OK || rules == SC_ERR_DATA)
        exceptions = sc_clip_exceptions_check(ctx, view, job->exceptions, job->exception_count);
    if (exceptions == SC_OK || exceptions == SC_ERR_DATA)
        verbs = sc_verb_tissues_check(ctx, view, job->verb_tissues, job->verb_tissue_count);
    if (verbs == SC_OK || verbs == SC_ERR_DATA)
        overlays =
            sc_overlay_tissues_check(ctx, view, job->overlay_tissues, job->overlay_tissue_count);
    verbs = overlays < verbs ? overlays : verbs;
    exceptions = verbs < exceptions ? verbs : exceptions;
    return exceptions < rules ? exceptions : rules;
}

sc_status sc_check_tissues(const sc_ctx *ctx, const sc_job *job, const sc_label *labels,
                           int label_count)
{
    const sc_prepared view = {.label_count = label_count, .labels = labels};
    sc_status status = check_tissues_of(ctx, job, &view);

    /* Shots after one with mistakes are not checked: those of keys of the film are in all. */
    for (size_t i = 0; i < job->shot_count && status == SC_OK; i++)
        status = check_tissues_of(ctx, &job->shots[i].job, &view);
    return status;
}

/* Bring the volume to the number of voxels that the job asks for. */
static sc_status resize_volume(const sc_app *app, const sc_job *job, sc_volume *volume)
{
    const double old_bytes = (double)sc_volume_voxels(volume) * volume->label_bytes;
    sc_status status;

    SC_TRY(sc_volume_memory_check(app->ctx, job->volume, job->volume_size, old_bytes));
    SC_TRY(sc_resample_nearest(app->ctx, volume, job->volume_size, app->threads));
out:
    return status;
}

/* Get the volume of the job, with the names of its label table: from the mapped file, made as
 * phantom, or read. Refuses a job that names tissues which the volume has not. @param colored give
 * colours to tissues that lack them. */
static sc_status read_volume(const sc_app *app, const sc_session *session, bool colored,
                             sc_volume *volume)
{
    const sc_job *job = &session->job;
    sc_status status;

    if (session->mapped)
        SC_TRY(unpack_volume(app, session, volume));
    else if (sc_job_is_phantom(job->volume))
        SC_TRY(make_phantom(app, job->volume, volume));
    else
        SC_TRY(sc_volume_read_by(app->ctx, job->volume, (sc_overlap)job->overlap, volume));
    if (job->has_volume_size)
        SC_TRY(resize_volume(app, job, volume));
    SC_TRY(sc_apply_labels(app, job, volume));
    SC_TRY(sc_edit_volume(app, job, colored, volume));
    if (colored && !session->mapped) /* in a prepared file, colours have been found */
        SC_TRY(color_volume(app, job, volume));
    if (volume->label_count == 1)
        sc_warn(app->ctx, "%s: holds background only; there is nothing to see", job->volume);
    status = sc_check_tissues(app->ctx, job, volume->labels, volume->label_count);
out:
    return status;
}

/* Tell how the grid on which surfaces are found differs from that of the file. */
static void tell_grid(const sc_app *app, const char *path, const sc_volume *v,
                      const sc_drawn_grid *grid)
{
    char text[320];

    sc_drawn_grid_text(grid, text, sizeof text);
    sc_info(app->ctx, "%s: %s; surfaces are found on %d x %d x %d voxels", path, text, v->size[0],
            v->size[1], v->size[2]);
}

sc_status sc_session_resample(const sc_app *app, const sc_session *session,
                              const sc_drawn_grid *measured, sc_volume_input *input)
{
    const sc_ctx silent = {.rank = 0, .memory_max_bytes = app->ctx->memory_max_bytes};
    const char *path = session->job.volume;
    sc_volume *volume = &input->volume;
    sc_drawn_grid grid;
    double bytes;
    int size[3];
    sc_status status;

    sc_stage_begin(app->ctx, "measuring the grid", 0, 0);
    if (measured)
        grid = *measured;
    else
        SC_TRY(sc_find_drawn_grid(app->ctx, volume, app->threads, &grid));
    SC_TRY(sc_resample_bytes(app->ctx, volume, &grid, app->threads, &bytes));
    sc_resampled_size(volume, &grid, size);
    input->resample = false;
    input->settings.as_drawn = !sc_is_resampled(&grid);
    if (sc_volume_memory_check(&silent, path, size, bytes) != SC_OK) {
        sc_warn(app->ctx,
                "%s: --max-memory leaves no room for layers between its slices, nor to smooth its "
                "borders, so slices and noise will show as steps",
                path);
        for (int i = 0; i < 3; i++) { /* copied voxels alone are removed */
            grid.split[i] = 1;
            grid.moved[i] = 0;
        }
        grid.noise = 0;
    }
    input->settings.resampled = sc_is_resampled(&grid);
    if (!input->settings.resampled)
        return SC_OK;
    sc_stage_begin(app->ctx, "resampling", 0, 0);
    SC_TRY(sc_resample(app->ctx, volume, &grid, app->threads));
    tell_grid(app, path, volume, &grid);
out:
    return status;
}

sc_status sc_session_read(const sc_app *app, const sc_session *session, bool measure_all,
                          sc_volume_input *out, sc_rank_record *times)
{
    const double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    const bool resampled = session->mapped && session->volume.resampled;
    sc_volume *volume = &out->volume;
    needs n = {0};
    sc_status status;

    SC_TRY(read_volume(app, session, true, volume));
    SC_TRY(find_needs(app, session, volume->labels, volume->label_count, &n));
    out->hidden = n.hidden;
    out->tissue_smooth = n.tissue_smooth;
    out->resample = n.resample && !resampled;
    sc_volume_hide(volume, n.hidden, app->threads);
    out->settings = (sc_prepare_settings){.smooth = n.smooth,
                                          .tissue_smooth = n.tissue_smooth,
                                          .resampled = resampled,
                                          .thickness = n.thickness || measure_all,
                                          .local_thickness = n.local_thickness,
                                          .surface = n.surface || measure_all,
                                          .hidden = n.hidden,
                                          .threads = app->threads};
    sc_add_time(app, times, SC_PHASE_READ, wall_s, cpu_s);
out:
    return status;
}

sc_status sc_session_voxels(const sc_app *app, const sc_session *session, sc_volume *out)
{
    return read_volume(app, session, false, out);
}

void sc_volume_input_clear(sc_volume_input *input)
{
    sc_volume_clear(&input->volume);
    sc_free(input->hidden);
    sc_free(input->tissue_smooth);
    *input = (sc_volume_input){0};
}

sc_status sc_session_prepare(const sc_app *app, const sc_session *session, bool measure_all,
                             sc_volume_input *input, sc_preparation **preparation)
{
    sc_status status;

    SC_TRY(sc_session_read(app, session, measure_all, input, NULL));
    if (input->resample)
        SC_TRY(sc_session_resample(app, session, NULL, input));
    status = sc_prepare(app->ctx, &input->volume, &input->settings, preparation);
out:
    return status;
}

const char *sc_temporary_folder(void)
{
    const char *folder = getenv("TMPDIR");

    return folder && folder[0] ? folder : "/tmp";
}
