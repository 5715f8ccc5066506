/* SPDX-License-Identifier: BSD-3-Clause */
/* The steps from a job file to a renderer on every rank. Rank 0 reads the files; after each step
 * all ranks agree on the return code, so that they end together after an error. */
#include "app.h"

#include <string.h>

sc_status sc_session_check_tissues(sc_app *app, sc_session *session)
{
    const sc_job *job = &session->job;
    sc_ctx errors = *app->ctx;
    sc_app quieter = *app;
    sc_status status;

    if (!job->volume[0] || job->has_compare || /* others may have the tissues */
        job->rule_count + job->exception_count + job->verb_tissue_count + job->shot_count == 0 ||
        (sc_is_prepared_file(job->volume) && sc_comm_size(app->comm) > 1))
        return SC_OK;
    errors.level = SC_LOG_ERROR;
    quieter.ctx = &errors;
    SC_TRY(sc_session_inspect(&quieter, !app->options.scan, session));
    status = sc_check_tissues(&errors, job, session->volume.labels, session->volume.label_count);
out:
    return status;
}

/* The arrays of a job. */
enum { ARRAYS = 10 };
typedef struct job_array {
    void *data;
    size_t count, size;
} job_array;

static void get_arrays(const sc_job *job, job_array out[ARRAYS])
{
    const job_array arrays[ARRAYS] = {
        {job->rules, job->rule_count, sizeof *job->rules},
        {job->exceptions, job->exception_count, sizeof *job->exceptions},
        {job->verbs, job->verb_count, sizeof *job->verbs},
        {job->verb_tissues, job->verb_tissue_count, sizeof *job->verb_tissues},
        {job->captions, job->caption_count, sizeof *job->captions},
        {job->overlay_tissues, job->overlay_tissue_count, sizeof *job->overlay_tissues},
        {job->volume_tissues, job->volume_tissue_count, sizeof *job->volume_tissues},
        {job->shots, job->shot_count, sizeof *job->shots},
        {job->phases, job->phase_count, sizeof *job->phases},
        {job->tissue_tracks, job->tissue_track_count, sizeof *job->tissue_tracks}};

    memcpy(out, arrays, sizeof arrays);
}

static void set_arrays(sc_job *job, const job_array arrays[ARRAYS])
{
    job->rules = arrays[0].data;
    job->exceptions = arrays[1].data;
    job->verbs = arrays[2].data;
    job->verb_tissues = arrays[3].data;
    job->captions = arrays[4].data;
    job->overlay_tissues = arrays[5].data;
    job->volume_tissues = arrays[6].data;
    job->shots = arrays[7].data;
    job->phases = arrays[8].data;
    job->tissue_tracks = arrays[9].data;
}

/* Send a job of rank 0, without the jobs of its shots, to the others. Collective. */
static sc_status share_job_alone(sc_app *app, sc_job *job)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const job_array nothing[ARRAYS] = {0};
    job_array arrays[ARRAYS];
    sc_status status = SC_OK;

    if (first)
        get_arrays(job, arrays);
    sc_comm_broadcast(app->comm, job, sizeof *job);
    /* The pointers in the job that was received are addresses of rank 0. They are replaced by this
     * rank's own: NULL at first, then the copies of the arrays. */
    if (!first) {
        set_arrays(job, nothing);
        get_arrays(job, arrays);
    }
    for (int i = 0; i < ARRAYS && status == SC_OK; i++) {
        status = sc_broadcast_array(app, &arrays[i].data, arrays[i].count, arrays[i].size);
        set_arrays(job, arrays);
    }
    for (size_t i = 0; i < job->shot_count && !first && job->shots; i++)
        set_arrays(&job->shots[i].job, nothing);
    return status;
}

/* Send the job of rank 0 to all others. Collective. */
static sc_status share_job(sc_app *app, sc_job *job)
{
    sc_status status = share_job_alone(app, job);

    for (size_t i = 0; i < job->shot_count && status == SC_OK; i++)
        status = share_job_alone(app, &job->shots[i].job);
    return status;
}

sc_status sc_session_job(sc_app *app, const char *job_path, sc_session *session)
{
    const sc_job_sources sources = {.path = job_path,
                                    .settings = app->options.settings,
                                    .setting_count = app->options.setting_count,
                                    .defaults = app->options.defaults,
                                    .default_count = app->options.default_count,
                                    .environment = app->environment,
                                    .no_video = app->options.no_video,
                                    .check_inputs = true};
    sc_status status = app->mistake;

    *session = (sc_session){.times = {.threads = app->threads}};
    if (sc_comm_rank(app->comm) == 0)
        (void)sc_goes_on(&status, sc_job_load(app->ctx, &sources, &session->job));
    if (status == SC_ERR_USAGE || status == SC_ERR_DATA || status == SC_ERR_MISSING)
        (void)sc_session_check_tissues(app, session); /* so that all mistakes are told in one go */
    SC_TRY(sc_comm_agree(app->comm, status));
    status = share_job(app, &session->job);
out:
    return status;
}

/* Give interior voxels the opacity of their tissue where a job asks for that, as the paper's
 * unaccelerated pictures do. The smooth surface model draws no interior voxels: a job that asks for
 * them gets a warning. */
static void apply_interior(const sc_ctx *ctx, const sc_job *job, sc_session *session)
{
    bool shows_interior = false;

    for (int id = 1; id < session->volume.label_count; id++) {
        sc_tissue *tissue = &session->tissues[id];

        if (tissue->interior_opacity < 0)
            tissue->interior_opacity = tissue->opacity;
        shows_interior = shows_interior || (tissue->visible && tissue->interior_opacity > 0);
    }
    if (shows_interior && job->render.surface == SC_SURFACE_SMOOTH)
        sc_warn(ctx, "interior_opacity is not used: smooth surfaces have no inside; it needs "
                     "surface: voxel");
}

/* The part of sc_session_tissues that rank 0 does: fill session->tissues, fades, clip_sets,
 * clip_set_count, and an automatic background. */
static sc_status resolve_tissues(sc_app *app, sc_session *session)
{
    const sc_ctx *ctx = app->ctx;
    const sc_job *job = &session->job;
    const sc_verbs verbs = {job->verbs, job->verb_count, job->verb_tissues, job->verb_tissue_count,
                            job->tissue_tracks};
    sc_prepared colored = session->volume;
    sc_label *labels = NULL;
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)session->volume.label_count, sizeof(sc_tissue), &block));
    session->tissues = block;
    SC_TRY(sc_check_tissues(ctx, job, session->volume.labels, session->volume.label_count));
    SC_TRY(sc_color_labels(ctx, session, &labels));
    if (labels)
        colored.labels = labels;
    SC_TRY(sc_transfer_resolve(ctx, &colored, job->rules, job->rule_count,
                               (sc_opacity_rule)job->render.auto_opacity, session->tissues));
    apply_interior(ctx, job, session);
    if (job->render.background.is_auto)
        sc_choose_background(&session->volume, session->tissues,
                             session->job.render.background.rgb);
    if (!job->render.background.is_none)
        sc_part_from_background(session->volume.label_count, session->job.render.background.rgb,
                                session->tissues);
    sc_take_looks(session);
    SC_TRY(sc_clip_sets_find(ctx, &session->volume, job->exceptions, job->exception_count,
                             session->tissues, session->clip_sets, &session->clip_set_count));
    if (job->verb_count || job->tissue_track_count)
        SC_TRY(sc_verbs_resolve(ctx, &session->volume, session->tissues, &verbs, &session->fades,
                                &session->fade_count));
    status = sc_explodes_resolve(ctx, &session->volume, session->tissues, &verbs, &session->shifts,
                                 &session->shift_count);
out:
    sc_free(labels);
    return status;
}

/* Send how verbs move tissues to all ranks. Collective. */
static sc_status share_shifts(sc_app *app, sc_session *session)
{
    void *shifts = session->shifts;
    sc_status status;

    sc_comm_broadcast(app->comm, &session->shift_count, sizeof session->shift_count);
    if (!session->shift_count)
        return SC_OK;
    status = sc_broadcast_array(app, &shifts, session->shift_count, sizeof *session->shifts);
    session->shifts = shifts;
    return status;
}

/* @return whether the colour of any tissue has key frames of its own. */
static bool has_color_tracks(const sc_session *session)
{
    for (int id = 0; id < session->volume.label_count; id++) {
        if (session->tissues[id].color_track)
            return true;
    }
    return false;
}

/* Send the tones of the key frames of colours, if there are any, to all ranks. Collective. */
static sc_status share_tones(sc_app *app, sc_session *session)
{
    const sc_job *job = &session->job;
    const size_t labels = (size_t)session->volume.label_count;
    void *tones = NULL;
    sc_status status = SC_OK;

    if (!has_color_tracks(session))
        return SC_OK;
    if (sc_comm_rank(app->comm) == 0)
        status = sc_zalloc(app->ctx, job->tissue_track_count, sizeof *session->color_tones, &tones);
    for (size_t id = 0; id < labels && tones; id++) {
        const int track = session->tissues[id].color_track;

        if (track)
            sc_track_tones(&job->tissue_tracks[track - 1], (sc_track *)tones + track - 1);
    }
    session->color_tones = tones;
    SC_TRY(sc_comm_agree(app->comm, status));
    status = sc_broadcast_array(app, &tones, job->tissue_track_count, sizeof *session->color_tones);
    session->color_tones = tones;
out:
    return status;
}

sc_status sc_session_tissues(sc_app *app, sc_session *session)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    void *tissues = NULL, *fades = NULL;
    sc_status status;

    /* Colours and opacities are decided with floating point, in which the libraries of two hosts
     * could differ. */
    SC_TRY(sc_comm_agree(app->comm, first ? resolve_tissues(app, session) : SC_OK));
    tissues = session->tissues;
    SC_TRY(sc_broadcast_array(app, &tissues, (size_t)session->volume.label_count,
                              sizeof *session->tissues));
    session->tissues = tissues;
    sc_comm_broadcast(app->comm, &session->fade_count, sizeof session->fade_count);
    fades = session->fades;
    SC_TRY(sc_broadcast_array(app, &fades, session->fade_count, sizeof *session->fades));
    session->fades = fades;
    SC_TRY(share_shifts(app, session));
    SC_TRY(share_tones(app, session));
    SC_TRY(sc_share_column_values(app, session));
    status = sc_scene_room_init(app->ctx, session->volume.label_count, &session->room);
    SC_TRY(sc_comm_agree(app->comm, status));
    sc_comm_broadcast(app->comm, session->job.render.background.rgb,
                      sizeof session->job.render.background.rgb);
    sc_comm_broadcast(app->comm, &session->scale, sizeof session->scale);
    sc_comm_broadcast(app->comm, session->clip_sets, sizeof session->clip_sets);
    sc_comm_broadcast(app->comm, &session->clip_set_count, sizeof session->clip_set_count);
out:
    return status;
}

/* Make a renderer of a phase of a session from the job, the volume and the tissues. @param comm as
 * of sc_render_settings. */
static sc_status make_renderer(const sc_app *app, const sc_ctx *ctx, sc_comm *comm,
                               const sc_session *session, int phase, sc_renderer **out)
{
    const sc_job *job = &session->job;
    sc_render_settings settings = {
        .width_px = job->output.size_px[0],
        .height_px = job->output.size_px[1],
        .surface = (sc_surface)job->render.surface,
        .skip = (sc_skip)job->render.skip,
        .cpu = sc_cpu_names[job->render.cpu],
        .samples = job->render.samples,
        .to_the_end = !job->render.early_termination,
        .everywhere = job->render.antialiasing != 0,
        .step_voxels = job->render.step_voxels,
        .caps = job->render.caps != 0,
        .cap_outline = job->render.cap_outline,
        .grey = session->grey.codes ? &session->grey : NULL,
        .grey_look = {session->grey_window, job->image.shown.caps, job->image.shown.slices,
                      sc_track_most(&job->image.shown.backdrop_track, job->image.shown.backdrop)},
        .light = sc_light_of_all(&job->light, &job->light_tracks),
        .local_thickness = job->render.thickness != 0,
        .opacity_rule = (sc_opacity_rule)job->render.auto_opacity,
        .tile_px = job->farm.tile_px,
        .threads = app->threads,
        .give_up = sc_signals_give_up(),
        .comm = comm,
        .folder = sc_temporary_folder(),
        .lender = phase ? session->renderer : NULL, /* frames are drawn one after the other */
    };

    memcpy(settings.background, job->render.background.rgb, sizeof settings.background);
    settings.transparent = job->render.background.is_none;
    return sc_renderer_new(ctx, &settings, sc_session_phase_volume(session, phase),
                           session->tissues, out);
}

/* Tell on rank 0 how many ranks hold for themselves what is derived from the volume, @p bytes in
 * all.
 * @param alone whether this one does, for want of room. Collective. */
static void tell_alone(const sc_app *app, uint64_t bytes, bool alone)
{
    const int ranks = sc_comm_size(app->comm);
    const sc_ctx silent = {.rank = 0};
    uint8_t mine = alone;
    int copies = 0;
    void *all = NULL;
    sc_status status = SC_OK;

    if (sc_comm_rank(app->comm) == 0)
        status = sc_alloc(&silent, (size_t)ranks, sizeof mine, &all);
    if (sc_comm_agree(app->comm, status) != SC_OK)
        return; /* too little memory to tell: the run goes on all the same */
    sc_comm_gather(app->comm, &mine, sizeof mine, all);
    for (int i = 0; all && i < ranks; i++)
        copies += ((uint8_t *)all)[i];
    if (copies)
        sc_warn(app->ctx,
                "neither /dev/shm nor %s has room for what is derived from the volume (%.0f MB): "
                "%d of %d ranks hold a copy each; a larger /dev/shm (docker run --shm-size) saves "
                "that memory",
                sc_temporary_folder(), (double)bytes / 1e6, copies, ranks);
    sc_free(all);
}

/* Make the renderer of a phase together with the other ranks. Should that fail, each tries to make
 * its own, and says why if it cannot. @param alone set if this rank has one of its own, for want of
 * room. */
static sc_status make_together(const sc_app *app, const sc_session *session, int phase, bool *alone,
                               sc_renderer **out)
{
    sc_ctx silent = *app->ctx;
    bool failed;
    sc_status status = SC_ERR_MEMORY;

    silent.write = NULL;
    if (sc_comm_size(app->comm) > 1 || session->phases) /* a rank alone has files for phases, too */
        status = make_renderer(app, &silent, app->comm, session, phase, out);
    failed = status != SC_OK;
    if (failed)
        status = make_renderer(app, app->ctx, NULL, session, phase, out);
    *alone = *alone || failed;
    return sc_comm_agree(app->comm, status);
}

/* Tell on rank 0 if another kernel draws than the job asks for. */
static void tell_kernel(const sc_app *app, const sc_session *session)
{
    const sc_render_options *o = &session->job.render;
    const sc_kernel *kernel = sc_renderer_kernel(session->renderer);
    const bool other_cpu = o->cpu && strcmp(kernel->cpu, sc_cpu_names[o->cpu]) != 0;

    if (sc_comm_rank(app->comm) == 0 &&
        (kernel->skip != (sc_skip)o->skip || (sc_skip_is_wide(kernel->skip) && other_cpu)))
        sc_info(app->ctx,
                "kernel %s, %s: this segcast has none for render.skip and render.cpu as given, or "
                "the volume is too large for it; the pictures are the same",
                kernel->name, kernel->cpu);
}

sc_status sc_shot_renderer(const sc_app *app, sc_session *session)
{
    const int phases = sc_session_phase_count(session);
    uint64_t bytes = 0;
    bool alone = false;
    void *block = NULL;
    sc_status status;

    sc_stage_turn(app->ctx, 1, phases);
    SC_TRY(make_together(app, session, 0, &alone, &session->renderer));
    sc_session_unload_phase(session, 0);
    if (phases > 1)
        SC_TRY(sc_comm_agree(app->comm,
                             sc_zalloc(app->ctx, (size_t)phases, sizeof(sc_renderer *), &block)));
    session->phase_renderers = block;
    for (int i = 1; i < phases; i++) {
        sc_stage_turn(app->ctx, i + 1, phases);
        SC_TRY(make_together(app, session, i, &alone, &session->phase_renderers[i - 1]));
        sc_session_unload_phase(session, i);
    }
    sc_stage_turn(app->ctx, 0, 0);
    for (int i = 0; i < phases; i++)
        bytes += sc_renderer_derived_bytes(sc_session_phase_renderer(session, i));
    if (sc_comm_size(app->comm) > 1)
        tell_alone(app, bytes, alone);
    tell_kernel(app, session);
out:
    return status;
}

/* Find the ways of the moves of session->timeline that fly, on rank 0, which has their lines, and
 * send them to the others. Collective. */
static sc_status share_ways(sc_app *app, sc_session *session)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_timeline *t = &session->timeline;
    size_t ways = 0;
    void *block = NULL;
    sc_status status = SC_OK;

    for (int i = 0; i < t->animation.move_count; i++)
        ways += t->moves[i].verb.kind == SC_VERB_FLY;
    t->ways = NULL;
    if (!ways)
        return SC_OK;
    if (first)
        status = sc_alloc(app->ctx, ways * SC_WAY_POINTS, sizeof *session->ways, &block);
    SC_TRY(sc_comm_agree(app->comm, status));
    ways = 0;
    for (int i = 0; i < t->animation.move_count; i++) {
        sc_move *move = &t->moves[i];

        if (move->verb.kind != SC_VERB_FLY)
            continue;
        if (first)
            sc_way_make(move->points, move->point_count, move->verb.ahead,
                        (sc_way_point *)block + ways * SC_WAY_POINTS);
        move->points = NULL;
        move->way = (int)ways++;
    }
    status = sc_broadcast_array(app, &block, ways * SC_WAY_POINTS, sizeof *session->ways);
    sc_free(session->ways);
    session->ways = block;
    t->ways = block;
out:
    return status;
}

/* Find the points that the camera has to show, on rank 0, if verbs bring tissues further than the
 * points @p points [count]: those, and where the tissues come to. @param out caller owns; NULL
 * where no tissue moves. */
static sc_status find_framed(const sc_app *app, const sc_session *session, const sc_vec3 *points,
                             size_t count, sc_animation *animation, sc_vec3 **out)
{
    size_t reached = 0, at = count;
    const sc_session *one;
    void *block;
    sc_status status;

    for (int i = 0; count && (one = sc_framed_with(session, i)) != NULL; i++)
        reached += 8 * one->shift_count;
    if (!reached)
        return SC_OK;
    status = sc_alloc(app->ctx, count + reached, sizeof **out, &block);
    if (status != SC_OK)
        return status;
    *out = block;
    memcpy(*out, points, count * sizeof **out);
    for (int i = 0; (one = sc_framed_with(session, i)) != NULL; i++) {
        sc_shifts_reach(&one->volume, one->shifts, one->shift_count, *out + at);
        at += 8 * one->shift_count;
    }
    animation->framed = *out;
    animation->framed_count = count + reached;
    return SC_OK;
}

/* Warn that all pictures of the session will be empty: of a film those of one shot, which is named,
 * since the others may show tissues. */
static void warn_of_nothing(const sc_app *app, const sc_session *session)
{
    const char *where = session->shot ? session->shot->where : session->job.tissues_where;

    sc_warn(app->ctx, "%s%sno tissue is visible%s pictures will be empty", where,
            *where ? ": " : "", session->shot ? " in this shot; its" : "; the");
}

void sc_session_looks(sc_session *session)
{
    const sc_job *job = &session->job;
    sc_timeline *t = &session->timeline;

    memcpy(t->clip_sets, session->clip_sets, sizeof session->clip_sets);
    t->clip_set_count = session->clip_set_count;
    t->looks = (sc_looks){.tissues = session->tissues,
                          .label_count = session->tissues ? session->volume.label_count : 0,
                          .tissue_tracks = job->tissue_tracks,
                          .color_tones = session->color_tones,
                          .fades = session->fades,
                          .fade_count = session->fade_count,
                          .shifts = session->shifts,
                          .shift_count = session->shift_count,
                          .column_values = session->column_values,
                          .column_steps = &job->color_columns.steps,
                          .scale = &session->scale,
                          .level_linear = session->level_linear,
                          .light = &job->light,
                          .light_tracks = &job->light_tracks,
                          .background = &job->render.background,
                          .grey = &job->image.shown,
                          .grey_window = session->grey_window,
                          .fps = job->output.fps,
                          .divider = &job->compare.divider,
                          .divider_track = &job->compare.divider_track};
}

sc_status sc_session_timeline(sc_app *app, sc_session *session, const sc_vec3 *points, size_t count)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_animation animation = session->job.animation;
    sc_moves moves = {0};
    sc_vec3 *framed = NULL;
    sc_status status;

    if (count == 0 && session->volume.label_count > 1 && first)
        warn_of_nothing(app, session);
    SC_TRY(sc_comm_agree(app->comm, first ? sc_find_moves(app, session, &moves) : SC_OK));
    animation.moves = moves.moves;
    animation.move_count = moves.count;
    SC_TRY(sc_comm_agree(
        app->comm, first ? find_framed(app, session, points, count, &animation, &framed) : SC_OK));
    if (first)
        sc_timeline_resolve(&animation, points, count, sc_session_aspect(session),
                            &session->timeline);
    /* Framing, too, is decided with floating point: see sc_session_tissues. */
    sc_comm_broadcast(app->comm, &session->timeline, sizeof session->timeline);
    sc_session_looks(session);
    SC_TRY(share_ways(app, session));
    if (count > 0 && first)
        sc_warn_of_planes(app, session);
    status = sc_comm_agree(
        app->comm, count > 0 && first
                       ? sc_warn_of_zoom(app, session, sc_session_aspect(session), points, count)
                       : SC_OK);
out:
    sc_free(framed);
    sc_moves_clear(&moves);
    return status;
}

/* List the points around what is shown in any phase of a session. Caller owns *out: sc_free. */
static sc_status find_hull(const sc_ctx *ctx, const sc_session *session, sc_vec3 **out,
                           size_t *count)
{
    const int phases = sc_session_phase_count(session);
    size_t points = 0, used = 0, part;
    void *block;
    sc_status status;

    for (int i = 0; i < phases; i++) {
        (void)sc_renderer_hull(sc_session_phase_renderer(session, i), &part);
        points += part;
    }
    SC_TRY(sc_alloc(ctx, points + 1, sizeof **out, &block));
    *out = block;
    for (int i = 0; i < phases; i++) {
        const sc_vec3 *hull = sc_renderer_hull(sc_session_phase_renderer(session, i), &part);

        if (part)
            memcpy(*out + used, hull, part * sizeof **out);
        used += part;
    }
    *count = used;
out:
    return status;
}

sc_status sc_shot_timeline(sc_app *app, sc_session *session)
{
    sc_vec3 *hull = NULL;
    size_t count = 0;
    sc_status status;

    /* One framing holds for all phases, so that the camera does not move with the beat. */
    SC_TRY(sc_comm_agree(app->comm, find_hull(app->ctx, session, &hull, &count)));
    SC_TRY(sc_session_timeline(app, session, hull, count));
    status = sc_session_letter(app, session);
out:
    sc_free(hull);
    return status;
}

void sc_shot_clear(sc_session *session)
{
    if (!session->borrows_renderer) {
        for (sc_renderer **r = session->phase_renderers; r && *r; r++)
            sc_renderer_free(*r);
        sc_free(session->phase_renderers);
        sc_renderer_free(session->renderer);
    }
    session->renderer = NULL;
    session->phase_renderers = NULL;
    sc_free(session->tissues);
    sc_free(session->fades);
    sc_scene_room_clear(&session->room);
    sc_free(session->color_tones);
    sc_free(session->column_values);
    sc_free(session->shifts);
    sc_free(session->ways);
    sc_free(session->lettering);
    sc_free(session->names);
    sc_image_clear(&session->logo);
}
