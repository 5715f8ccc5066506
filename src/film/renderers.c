/* SPDX-License-Identifier: BSD-3-Clause */
/* The renderers of a panel, one for each phase that it shows, and which phases are in the memory of
 * a rank. Where they are held in files, of which each rank maps all, only those count from which
 * frames are being drawn: what was read of a phase leaves the memory of the rank when others are
 * drawn, and the system begins to fetch the next one. No rank waits for another: each tells the
 * system what itself needs. */
#include "panels.h"

/* ---- memory ---- */

/* @return the phase that frame @p k of a panel shows. */
static int phase_at(const sc_panel *panel, int k)
{
    const int first = panel->shot ? panel->shot->span.first : 0;
    const sc_job *job = &panel->job;

    return panel->phases > 1
               ? sc_cine_phase(&job->cine.cine, panel->phases, job->output.fps, first + k)
               : 0;
}

/* Tell the system what becomes of the volume of a phase, and of what @p renderer, unless it is
 * NULL, has derived from it. */
static void advise(const sc_inputs *inputs, int phase, sc_renderer *renderer, sc_memory_use use)
{
    sc_input_advise(&inputs->all[phase], use);
    if (renderer)
        sc_renderer_advise(renderer, use);
}

void sc_panel_unload(const sc_panel *panel, int phase)
{
    if (panel->phases > 1)
        advise(panel->inputs, phase, panel->renderers ? panel->renderers[phase] : NULL,
               SC_MEMORY_NOT_NEEDED);
}

/* Note that a frame is drawn from a phase: what has not been used for longest is unloaded. */
static void load(sc_inputs *inputs, int phase, sc_renderer *renderer)
{
    sc_loaded_phase *loaded = inputs->loaded, out;
    int at = 0;

    while (at < SC_PHASES_LOADED - 1 && loaded[at].renderer != renderer && loaded[at].renderer)
        at++;
    out = loaded[at];
    for (; at > 0; at--)
        loaded[at] = loaded[at - 1];
    loaded[0] = (sc_loaded_phase){renderer, phase};
    if (out.renderer && out.renderer != renderer)
        advise(inputs, out.phase, out.renderer, SC_MEMORY_NOT_NEEDED);
}

sc_renderer *sc_panel_begin_frame(const sc_panel *panel, int k)
{
    const int phase = phase_at(panel, k), next = phase_at(panel, k + 1);

    if (panel->phases == 1)
        return panel->renderers[0];
    load(panel->inputs, phase, panel->renderers[phase]);
    if (next != phase) /* which a rank that draws whole GOPs draws next */
        advise(panel->inputs, next, panel->renderers[next], SC_MEMORY_NEEDED_SOON);
    return panel->renderers[phase];
}

void sc_inputs_unload(sc_inputs *inputs)
{
    for (int i = 0; inputs && i < SC_PHASES_LOADED; i++) {
        const sc_loaded_phase out = inputs->loaded[i];

        inputs->loaded[i] = (sc_loaded_phase){0};
        if (out.renderer)
            advise(inputs, out.phase, out.renderer, SC_MEMORY_NOT_NEEDED);
    }
}

double sc_session_loaded_share(const sc_session *session)
{
    const int count = session->inputs->count;

    return session->job.volume.phase_count && count > SC_PHASES_LOADED && session->inputs->in_files
               ? (double)SC_PHASES_LOADED / count
               : 1;
}

/* ---- making them ---- */

/* Make a renderer of a phase of a panel from the job, the volume and the tissues. @param comm as
 * of sc_render_settings. */
static sc_status make_renderer(const sc_app *app, const sc_ctx *ctx, sc_comm *comm,
                               const sc_panel *panel, int phase, sc_renderer **out)
{
    static const int samples[] = {1, 5, 8}; /* by sc_quality */
    const sc_job *job = &panel->job;
    sc_render_settings settings = {
        .width_px = job->output.size_px[0],
        .height_px = job->output.size_px[1],
        .surface = (sc_surface)job->render.surface,
        .skip = (sc_skip)job->render.skip,
        .cpu = sc_cpu_names[job->render.cpu],
        .sampling.samples = samples[job->render.quality],
        .sampling.lens_samples = job->animation.camera.optics.aperture_mm > 0 ||
                                         job->light.constant.method == SC_LIGHT_PATH
                                     ? 4 << samples[job->render.quality]
                                     : 0,
        .sampling.to_the_end = !job->render.early_termination,
        .sampling.everywhere = job->render.quality == SC_QUALITY_STILL,
        .step_voxels = job->render.step_voxels,
        .caps = job->render.caps != 0,
        .floor = job->render.stage,
        .cap_outline = job->render.cap_outline,
        .grey = panel->grey.grey.codes ? &panel->grey.grey : NULL,
        .grey_look = {panel->grey.window, job->image.shown.caps, job->image.shown.slices,
                      sc_track_most(&job->image.shown.backdrop_track, job->image.shown.backdrop)},
        .light = sc_light_of_all(&job->light.constant, &job->light.tracks),
        .environment = panel->environment.rgb ? &panel->environment : NULL,
        .environment_turn_deg = job->light.environment.turn_deg,
        .local_thickness = (job->render.auto_opacity & SC_OPACITY_LOCAL) != 0,
        .opacity_rule = sc_job_opacity_rule(job),
        .work = {.tile_px = job->farm.tile_px,
                 .threads = app->threads,
                 .give_up = panel->give_up ? panel->give_up : sc_signals_give_up(),
                 .comm = comm,
                 .folder = sc_temporary_folder()},
        .work.lender =
            phase ? panel->renderers[0] : NULL, /* frames are drawn one after the other */
    };

    memcpy(settings.background, job->render.background.rgb, sizeof settings.background);
    settings.transparent = job->render.background.is_none;
    return sc_renderer_new(ctx, &settings,
                           phase ? &panel->inputs->all[phase].volume : &panel->volume,
                           panel->looks.tissues, out);
}

/* Tell on rank 0 how many ranks hold for themselves what is derived from the volume, @p bytes in
 * all. @param alone whether this one does, for want of room. Collective. */
static void tell_alone(const sc_app *app, uint64_t bytes, bool alone)
{
    const int ranks = sc_comm_size(app->comm);
    const sc_ctx silent = {.rank = 0};
    uint8_t mine = alone;
    int copies = 0;
    SC_OWN(sc_free_at) uint8_t *all = NULL;

    if (sc_comm_gather(&silent, app->comm, &mine, sizeof mine, &all) != SC_OK)
        return; /* too little memory to tell: the run goes on all the same */
    for (int i = 0; all && i < ranks; i++)
        copies += all[i];
    if (copies)
        sc_warn(app->ctx,
                "neither /dev/shm nor %s has room for what is derived from the volume (%.0f MB): "
                "%d of %d ranks hold a copy each; a larger /dev/shm (docker run --shm-size) saves "
                "that memory",
                sc_temporary_folder(), (double)bytes / 1e6, copies, ranks);
}

/* Make the renderer of a phase together with the other ranks. Should that fail, each tries to make
 * its own, and says why if it cannot. @param alone set if this rank has one of its own, for want of
 * room. */
static sc_status make_together(const sc_app *app, const sc_panel *panel, int phase, bool *alone,
                               sc_renderer **out)
{
    sc_ctx silent = *app->ctx;
    bool failed;
    sc_status status = SC_ERR_MEMORY;

    silent.write = NULL;
    if (sc_comm_size(app->comm) > 1 ||
        panel->phases > 1) /* a rank alone has files for phases, too */
        status = make_renderer(app, &silent, app->comm, panel, phase, out);
    failed = status != SC_OK;
    if (failed)
        status = make_renderer(app, app->ctx, NULL, panel, phase, out);
    *alone = *alone || failed;
    return sc_comm_agree(app->comm, status);
}

/* Tell on rank 0 if another kernel draws than the job asks for. */
static void tell_kernel(const sc_app *app, const sc_panel *panel)
{
    const sc_render_options *o = &panel->job.render;
    const sc_kernel *kernel = sc_renderer_kernel(panel->renderers[0]);
    const bool other_cpu = o->cpu && strcmp(kernel->cpu, sc_cpu_names[o->cpu]) != 0;

    if (sc_comm_rank(app->comm) == 0 &&
        (kernel->skip != (sc_skip)o->skip || (sc_skip_is_wide(kernel->skip) && other_cpu)))
        sc_info(app->ctx,
                "kernel %s, %s: this segcast has none for render.skip and render.cpu as given, or "
                "the volume is too large for it; the pictures are the same",
                kernel->name, kernel->cpu);
}

sc_status sc_environment_load(const sc_ctx *ctx, const sc_job *job, sc_panorama *out)
{
    const sc_lighting all = sc_light_of_all(&job->light.constant, &job->light.tracks);

    if (all.method != SC_LIGHT_FLAT && !(all.ambient + all.key + all.head > 0))
        sc_warn(ctx, "light.ambient, light.key and light.head are 0: all tissues are black");
    return job->light.environment.file[0] ? sc_panorama_load(ctx, job->light.environment.file, out)
                                          : SC_OK;
}

sc_status sc_panel_environment(sc_app *app, sc_panel *panel)
{
    sc_panorama *map = &panel->environment;
    void *pixels;
    sc_status status = SC_OK;

    if (!panel->phases)
        return SC_OK; /* it does not draw */
    if (sc_comm_rank(app->comm) == 0)
        status = sc_environment_load(app->ctx, &panel->job, map);
    SC_PASS(sc_comm_agree(app->comm, status));
    if (!panel->job.light.environment.file[0])
        return SC_OK;
    pixels = map->rgb;
    sc_comm_broadcast(app->comm, map, sizeof *map);
    map->rgb = NULL; /* what was received is an address of rank 0 */
    SC_PASS(sc_broadcast_array(app, &pixels, (size_t)map->width_px * (size_t)map->height_px,
                               sizeof *map->rgb));
    map->rgb = pixels;
    return SC_OK;
}

sc_status sc_panel_renderers(const sc_app *app, sc_panel *panel)
{
    const int phases = panel->phases;
    uint64_t bytes = 0;
    bool alone = false;

    SC_PASS(sc_comm_agree(app->comm, SC_ZALLOC(app->ctx, (size_t)phases, &panel->renderers)));
    for (int i = 0; i < phases; i++) {
        sc_stage_turn(app->ctx, i + 1, phases);
        SC_PASS(make_together(app, panel, i, &alone, &panel->renderers[i]));
        sc_panel_unload(panel, i);
    }
    sc_stage_turn(app->ctx, 0, 0);
    for (int i = 0; i < phases; i++)
        bytes += sc_renderer_derived_bytes(panel->renderers[i]);
    if (sc_comm_size(app->comm) > 1)
        tell_alone(app, bytes, alone);
    tell_kernel(app, panel);
    return SC_OK;
}

/* ---- light ---- */

/* How much of the light differs between the frames of panels that have the same renderers. */
typedef struct light_frames {
    sc_panel *lit; /* the first one with a frame out of vessels; NULL: there is none */
    int frame;     /* that frame */
    sc_light_change change;
} light_frames;

/* @return the most that the tissues of a panel alone may change light. */
static sc_light_change change_of_tissues(const sc_panel *panel)
{
    const sc_looks *looks = &panel->timeline.looks;
    sc_light_change change =
        looks->color_tones || looks->column_values ? SC_LIGHT_NEW_SUMS : SC_LIGHT_STAYS;

    for (int id = 1; id < panel->volume.label_count; id++) {
        if (panel->looks.tissues[id].fade_group)
            change = SC_LIGHT_NEW_RAYS;
    }
    return change;
}

/* Add the frames of a panel. */
static void add_frames(sc_panel *panel, light_frames *f)
{
    const sc_light_change tissues = change_of_tissues(panel);
    sc_scene first;

    f->change = tissues > f->change ? tissues : f->change;
    if (f->lit)
        first = sc_timeline_scene(&f->lit->timeline, f->frame, NULL);
    for (int k = 0; k < panel->job.animation.frames; k++) {
        const sc_scene scene = sc_timeline_scene(&panel->timeline, k, NULL);
        sc_light_change change;

        if (scene.inside)
            continue;
        if (!f->lit) {
            f->lit = panel;
            f->frame = k;
            first = scene;
        }
        change =
            sc_light_between(&first, &scene, panel->volume.label_count, panel->job.render.stage);
        f->change = change > f->change ? change : f->change;
    }
}

/* Gather light for the renderers of a panel. */
static sc_status gather(sc_app *app, const sc_panel *panel, const light_frames *f)
{
    const sc_scene first = sc_timeline_scene(&f->lit->timeline, f->frame, &f->lit->room);

    for (int i = 0; i < panel->phases; i++) {
        const sc_watched_file *kept = panel->inputs->all[panel->input + i].kept;
        sc_status status;

        sc_stage_turn(app->ctx, i + 1, panel->phases);
        status = sc_renderer_gather(app->ctx, panel->renderers[i], &first, f->change,
                                    kept ? kept->name : NULL);
        SC_PASS(sc_comm_agree(app->comm, status));
        sc_panel_unload(panel, i);
    }
    sc_stage_turn(app->ctx, 0, 0);
    return SC_OK;
}

sc_status sc_session_light(const sc_app *app, sc_session *session)
{
    for (int i = 0; i < session->panel_count; i++) {
        sc_panel *panel = &session->panels[i];
        sc_scene first;

        if (!panel->renderers) /* it only writes */
            continue;
        first = sc_timeline_scene(&panel->timeline, 0, &panel->room);
        for (int k = 0; k < panel->phases; k++)
            SC_PASS(
                sc_renderer_gather(app->ctx, panel->renderers[k], &first, SC_LIGHT_NEW_RAYS, NULL));
    }
    return SC_OK;
}

sc_status sc_panels_gather(sc_app *app, sc_session *session)
{
    for (int i = 0; i < session->panel_count; i++) {
        const sc_panel *panel = &session->panels[i];
        light_frames f = {.lit = NULL};

        if (!panel->renderers || panel->borrows_renderers ||
            panel->job.light.constant.method != SC_LIGHT_GLOBAL)
            continue;
        for (int j = i; j < session->panel_count; j++) {
            if (session->panels[j].renderers == panel->renderers)
                add_frames(&session->panels[j], &f);
        }
        if (f.lit)
            SC_PASS(gather(app, panel, &f));
    }
    return SC_OK;
}
