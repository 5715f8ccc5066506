/* SPDX-License-Identifier: BSD-3-Clause */
/* The volume of a job, prepared, on every rank: mapped from a prepared file, or read by rank 0,
 * prepared by the ranks of its node together, and shared. */
#include "recipe.h"

#include <unistd.h>

/* Tell on rank 0 if a node does not hold the prepared volume once in its shared memory, for want of
 * room. Collective. @return SC_ERR_MEMORY, the same on all ranks. */
static sc_status tell_place(const sc_app *app, const sc_job *job, const sc_input *input)
{
    const size_t ranks = (size_t)sc_comm_size(app->comm);
    const int32_t mine = sc_shared_place_of(input->shared);
    const double mb = (double)input->bytes / 1e6;
    int in_file = 0, copied = 0;
    SC_OWN(sc_free_at) int32_t *all = NULL;

    SC_PASS(sc_comm_gather(app->ctx, app->comm, &mine, sizeof mine, &all));
    for (size_t i = 0; all && i < ranks; i++) {
        in_file += all[i] == SC_SHARED_IN_FILE;
        copied += all[i] == SC_SHARED_COPIED;
    }
    if (in_file && !job->volume.phase_count) /* the phases of a series are to be in files */
        sc_warn(app->ctx,
                "/dev/shm has no room for the prepared volume (%.0f MB): %d of %zu ranks map a "
                "file in %s instead; a larger /dev/shm (docker run --shm-size) or a volume from "
                "`segcast convert` needs none",
                mb, in_file, ranks, sc_temporary_folder());
    if (copied)
        sc_warn(app->ctx,
                "neither /dev/shm nor %s has room for the prepared volume (%.0f MB): %d of %zu "
                "ranks hold a copy each; a larger /dev/shm (docker run --shm-size) or a volume "
                "from `segcast convert` saves that memory",
                sc_temporary_folder(), mb, copied, ranks);
    return SC_OK;
}

/* ---- preparing together ---- */

/* What the ranks of rank 0's node prepare together, as rank 0 tells it to the others. */
typedef struct told_volume {
    int size[3];
    int label_bytes, label_count;
    sc_affine to_ras_mm;
    bool oriented, numbered, resample;
    sc_prepare_settings settings; /* its pointers say only whether there is an array */
} told_volume;

/* The ranks of rank 0's node while they prepare a volume, as one of them sees it. */
typedef struct preparing {
    sc_team *team;                /* NULL: no other rank takes part */
    sc_volume volume;             /* borrowed from the team, or from what rank 0 has read */
    sc_prepare_settings settings; /* with arrays that are borrowed in the same way */
    bool resample;                /* as of sc_edited */
    sc_preparation *preparation;  /* owned; NULL on ranks that have no part in it */
} preparing;

/* Give the ranks of p->team what the first one has in p->volume, p->settings and p->resample, in
 * arrays of the team; the labels stay with the first rank alone. Collective in the team. @return
 * SC_ERR_MEMORY, the same on all ranks, with nothing changed. */
static sc_status share_input(const sc_ctx *ctx, preparing *p)
{
    const sc_volume *v = &p->volume;
    const told_volume mine = {.size = {v->size[0], v->size[1], v->size[2]},
                              .label_bytes = v->label_bytes,
                              .label_count = v->label_count,
                              .to_ras_mm = v->to_ras_mm,
                              .oriented = v->oriented,
                              .numbered = v->numbered,
                              .resample = p->resample,
                              .settings = p->settings};
    const told_volume *told;
    size_t labels, bytes;
    void *block, *ids, *hidden, *smooth;

    SC_PASS(sc_team_collect(ctx, p->team, &mine, sizeof mine, &block));
    told = block;
    labels = (size_t)told->label_count;
    bytes = (size_t)told->size[0] * (size_t)told->size[1] * (size_t)told->size[2] *
            (size_t)told->label_bytes;
    SC_PASS(sc_team_alloc(ctx, p->team, bytes, 1, &ids));
    SC_PASS(sc_team_alloc(ctx, p->team, labels, sizeof(bool), &hidden));
    SC_PASS(sc_team_alloc(ctx, p->team, labels, sizeof(sc_vec3), &smooth));
    if (sc_team_is_first(p->team)) {
        memcpy(ids, v->ids, bytes);
        memcpy(hidden, p->settings.hidden, labels * sizeof(bool));
        memcpy(smooth, p->settings.tissue_smooth, labels * sizeof(sc_vec3));
    }
    SC_PASS(sc_team_agree(p->team, SC_OK));
    p->volume = (sc_volume){.label_bytes = told->label_bytes,
                            .ids = ids,
                            .label_count = told->label_count,
                            .labels = p->volume.labels,
                            .to_ras_mm = told->to_ras_mm,
                            .oriented = told->oriented,
                            .numbered = told->numbered};
    memcpy(p->volume.size, told->size, sizeof told->size);
    p->resample = told->resample;
    p->settings = told->settings;
    p->settings.hidden = hidden;
    p->settings.tissue_smooth = smooth;
    return SC_OK;
}

/* Measure the grid on which the volume of a team was drawn, by all its ranks; then the first brings
 * @p edited to it, and if that has changed the voxels, all get them anew. Collective in the team.
 * @param wrong set to the return code if the first rank could not resample, after which @p edited
 * can only be freed. @return the same on all ranks. */
static sc_status resample_together(const sc_app *app, const sc_ctx *ctx, const sc_job *job,
                                   const sc_input *input, sc_edited *edited, preparing *p,
                                   sc_status *wrong)
{
    const bool first = sc_team_is_first(p->team);
    sc_drawn_grid grid;
    void *all;

    sc_stage_begin(ctx, "measuring the grid", 0, 0);
    if (input->drawn_known) /* on all ranks of the team, or on none */
        grid = input->drawn;
    else
        SC_PASS(sc_find_drawn_grid_together(ctx, p->team, &p->volume, &grid));
    if (first)
        *wrong = sc_input_resample(app, job, input, &grid, edited);
    SC_PASS(sc_team_agree(p->team, *wrong));
    SC_PASS(sc_team_collect(ctx, p->team, &edited->settings, sizeof edited->settings, &all));
    p->resample = false;
    p->settings.resampled = ((const sc_prepare_settings *)all)->resampled;
    p->settings.as_drawn = ((const sc_prepare_settings *)all)->as_drawn;
    if (!p->settings.resampled)
        return SC_OK;
    sc_team_free(p->team, p->volume.ids);
    p->volume = edited->volume;
    p->settings = edited->settings;
    return share_input(ctx, p);
}

/* Have all ranks of this node, which is rank 0's, prepare the volume that rank 0 has read, if the
 * memory that they share has room for it. What they share then, beside the prepared volume itself,
 * are its voxels once more, the vertex records and the distances for the local thickness. @param
 * edited on rank 0: its voxels are freed as soon as the team has them. @param wrong as of
 * resample_together. Collective on the node. @return the same on all its ranks: SC_ERR_MEMORY,
 * SC_ERR_DATA. */
static sc_status prepare_together(const sc_app *app, const sc_ctx *ctx, const sc_job *job,
                                  const sc_input *input, sc_edited *edited, preparing *p,
                                  sc_status *wrong)
{
    const uint64_t each = 4 + 2 * (uint64_t)p->volume.label_bytes; /* bytes for a voxel, at most */

    SC_PASS(sc_team_open(ctx, app->comm, app->threads, NULL, &p->team));
    if (sc_team_ranks(p->team) == 1)
        return SC_ERR_MEMORY;
    if (!sc_team_has_room(p->team, each * sc_volume_voxels(&p->volume))) {
        if (sc_team_is_first(p->team))
            sc_info(ctx, "/dev/shm is too small for the ranks of a node to prepare the volume "
                         "together: rank 0 prepares it alone");
        return SC_ERR_MEMORY;
    }
    SC_PASS(share_input(ctx, p));
    if (p->resample)
        SC_PASS(resample_together(app, ctx, job, input, edited, p, wrong));
    sc_free(edited->volume.ids);
    edited->volume.ids = NULL;
    p->settings.team = p->team;
    return sc_prepare(ctx, &p->volume, &p->settings, &p->preparation);
}

/* Pass on all messages but errors to the sc_ctx @p user. */
static void write_no_errors(void *user, sc_log_level level, const char *text)
{
    const sc_ctx *ctx = user;

    if (level != SC_LOG_ERROR && ctx->write)
        ctx->write(ctx->user, level, text);
}

/* Prepare the volume that rank 0 has read: all ranks of its node together, or, should that fail,
 * rank 0 alone, which says why if it cannot. @param edited filled on rank 0, empty on the others.
 * Collective on rank 0's node. @return of others than rank 0: SC_OK. */
static sc_status prepare_volume(const sc_app *app, const sc_job *job, const sc_input *input,
                                sc_edited *edited, preparing *p)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_ctx lenient = *app->ctx;
    sc_status status = SC_ERR_MEMORY, wrong = SC_OK;

    lenient.write = write_no_errors;
    lenient.user = (void *)(uintptr_t)app->ctx;
    *p = (preparing){
        .volume = edited->volume, .settings = edited->settings, .resample = edited->resample};
    if (sc_comm_size(app->comm) > 1)
        status = prepare_together(app, &lenient, job, input, edited, p, &wrong);
    if (status == SC_OK)
        return SC_OK;
    p->settings.team = NULL; /* what it has not prepared it cannot pack together either */
    if (!first)
        return SC_OK;
    SC_PASS(wrong);
    if (edited->resample)
        SC_PASS(sc_input_resample(app, job, input, NULL, edited));
    if (edited->volume.ids) /* the team has not got them, or not for good */
        p->volume = edited->volume;
    p->settings = edited->settings;
    return sc_prepare(app->ctx, &p->volume, &p->settings, &p->preparation);
}

/* Copy what was prepared to the block of this node, which is rank 0's. Where every rank has a block
 * of its own, only that of rank 0 counts. Collective on the node. */
static void pack(const sc_app *app, const sc_input *input, const preparing *p)
{
    if (p->settings.team && sc_shared_place_of(input->shared) != SC_SHARED_COPIED)
        sc_preparation_pack_together(p->preparation, sc_shared_data(input->shared));
    else if (sc_comm_rank(app->comm) == 0)
        sc_preparation_pack(p->preparation, sc_shared_data(input->shared));
}

/* Free what @p p owns. */
static void clear_preparing(preparing *p)
{
    sc_preparation_free(p->preparation);
    sc_team_close(p->team);
    *p = (preparing){0};
}

/* Look for what was prepared before, and kept. @param edited filled on rank 0. @param kept set on
 * rank 0 to where; NULL: nowhere. @param found it was: sc_kept_find. Collective. @return the same
 * on all ranks: SC_ERR_MEMORY. */
static sc_status find_kept(const sc_app *app, const sc_job *job, sc_edited *edited, sc_input *input,
                           char **kept, bool *found)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_status status = SC_OK;

    if (app->measures)
        return SC_OK;
    if (first)
        status = sc_kept_path(app->ctx, input, edited, kept);
    SC_PASS(sc_comm_agree(app->comm, status));
    SC_PASS(sc_kept_find(app, edited, kept, input, found));
    if (!*found)
        return SC_OK;
    if (first)
        sc_info(app->ctx, "%s: the volume was prepared before, and kept", *kept);
    if (first && job->volume.phase_count &&
        edited->resample) { /* the other phases have the same grid */
        edited->drawn = input->drawn;
        edited->drawn_known = true;
        if (!input->drawn_known)
            status = sc_find_drawn_grid(app->ctx, &edited->volume, app->threads, &edited->drawn);
    }
    return sc_comm_agree(app->comm, status);
}

/* Read the volume on rank 0, prepare it on the ranks of its node while the others wait, and copy it
 * to one block on each node: fills input->shared and input->volume. Collective. */
static sc_status share_volume(sc_app *app, const sc_job *job, sc_rank_record *times,
                              sc_input *input)
{
    const bool first = sc_comm_rank(app->comm) == 0, near = sc_comm_is_near_root(app->comm);
    double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    SC_OWN(sc_edited_clear) sc_edited edited = {0};
    SC_OWN(clear_preparing) preparing p = {0};
    uint64_t bytes = 0;
    SC_OWN(sc_free_at) char *kept = NULL;
    bool found = false;
    sc_status status = SC_OK;

    if (first)
        status = sc_input_read(app, job, input, times, &edited);
    SC_PASS(sc_comm_agree(app->comm, status));
    if (!first)
        sc_add_time(app, times, SC_PHASE_IDLE, wall_s, cpu_s);
    wall_s = sc_wall_s();
    cpu_s = sc_cpu_s();
    SC_PASS(find_kept(app, job, &edited, input, &kept, &found));
    if (!found && near)
        status = prepare_volume(app, job, input, &edited, &p);
    SC_PASS(sc_comm_agree(app->comm, status));
    /* What is kept is drawn from the file, and not copied to memory once more. */
    if (!found && sc_kept_add(app, kept, p.preparation, sc_cpu_s() - cpu_s))
        SC_PASS(sc_kept_find(app, &edited, &kept, input, &found));
    sc_add_time(app, times, p.preparation || found ? SC_PHASE_PREPARE : SC_PHASE_IDLE, wall_s,
                cpu_s);
    input->drawn = edited.drawn;
    input->drawn_known = edited.drawn_known;
    if (found)
        return SC_OK;
    wall_s = sc_wall_s();
    cpu_s = sc_cpu_s();
    bytes = first ? sc_preparation_bytes(p.preparation) : 0;
    sc_comm_broadcast(app->comm, &bytes, sizeof bytes);
    input->bytes = bytes;
    SC_PASS(sc_shared_alloc(app->ctx, app->comm, bytes, sc_temporary_folder(), &input->shared));
    SC_PASS(tell_place(app, job, input));
    sc_stage_begin(app->ctx, "sharing", 0, 0);
    pack(app, input, &p);
    clear_preparing(&p);
    sc_edited_clear(&edited);
    sc_shared_publish(app->comm, input->shared);
    status = sc_comm_agree(app->comm, sc_prepared_view(app->ctx, sc_shared_data(input->shared),
                                                       bytes, &input->volume));
    sc_add_time(app, times, SC_PHASE_SHARE, wall_s, cpu_s);
    return status;
}

sc_status sc_input_load(sc_app *app, sc_job *job, sc_rank_record *times, sc_input *input)
{
    uint8_t is_prepared = 0;
    bool usable = false;
    double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    sc_status status;

    if (sc_comm_rank(app->comm) == 0)
        is_prepared = !input->is_between && sc_is_prepared_file(job->volume.path);
    sc_comm_broadcast(app->comm, &is_prepared, sizeof is_prepared);
    if (!is_prepared)
        return share_volume(app, job, times, input);
    status = sc_input_map(app, job, input, &usable);
    sc_add_time(app, times, SC_PHASE_READ, wall_s, cpu_s);
    if (status != SC_OK || usable)
        return status;
    return share_volume(app, job, times, input);
}

void sc_input_clear(sc_input *input)
{
    sc_shared_free(input->shared);
    sc_free(input->labels);
    sc_free(input->stats);
    sc_unmap_prepared(&input->mapped);
    sc_unmap_prepared(&input->kept);
    *input = (sc_input){0};
}
