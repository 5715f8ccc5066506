/* SPDX-License-Identifier: BSD-3-Clause */
/* How the tissues of a panel look, decided by rank 0. */
#include "panels.h"

/* Give interior voxels the opacity of their tissue where a job asks for that, as the paper's
 * unaccelerated pictures do. The smooth surface model draws no interior voxels: a job that asks for
 * them gets a warning. */
static void apply_interior(const sc_ctx *ctx, const sc_job *job, sc_panel *panel)
{
    bool shows_interior = false;

    for (int id = 1; id < panel->volume.label_count; id++) {
        sc_tissue *tissue = &panel->looks.tissues[id];

        if (tissue->interior_opacity < 0)
            tissue->interior_opacity = tissue->opacity;
        shows_interior = shows_interior || (tissue->visible && tissue->interior_opacity > 0);
    }
    if (shows_interior && job->render.surface == SC_SURFACE_SMOOTH)
        sc_warn(ctx, "interior_opacity is not used: smooth surfaces have no inside; it needs "
                     "surface: voxel");
}

/* Give a tissue the look of another one. Which planes cut it and what verbs do to it stays. */
static void take_look(const sc_tissue *from, sc_tissue *to)
{
    const sc_tissue own = *to;

    *to = *from;
    to->clip_set = own.clip_set;
    to->fade_group = own.fade_group;
    to->part = own.part;
}

/* Give the tissues of a subject the looks that they have in the subjects before it. */
static void take_looks(sc_panel *panel)
{
    const sc_panel_group *group = &panel->group;

    for (int id = 1; group->owners && id < panel->volume.label_count; id++) {
        const sc_tissue_owner *owner = &group->owners[id];

        if (owner->subject < group->index)
            take_look(&group->all[owner->subject].looks.tissues[owner->id],
                      &panel->looks.tissues[id]);
    }
}

/* The part of sc_panel_tissues that rank 0 does: fill panel->looks.tissues, fades, clip_sets,
 * clip_set_count, and an automatic background. */
static sc_status resolve_tissues(sc_app *app, sc_panel *panel)
{
    const sc_ctx *ctx = app->ctx;
    const sc_job *job = &panel->job;
    const sc_verbs verbs = {job->verbs.list, job->verbs.count, job->verbs.tissues,
                            job->verbs.tissue_count, job->tissues.tracks};
    sc_prepared colored = panel->volume;
    SC_OWN(sc_free_at) sc_label *labels = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)panel->volume.label_count, &panel->looks.tissues));
    SC_PASS(sc_check_tissues(ctx, job, panel->volume.labels, panel->volume.label_count));
    SC_PASS(sc_color_labels(ctx, panel, &labels));
    if (labels)
        colored.labels = labels;
    sc_transfer_resolve(&colored, job->tissues.rules, job->tissues.rule_count,
                        sc_job_opacity_rule(job), panel->looks.tissues);
    apply_interior(ctx, job, panel);
    if (job->render.background.is_auto)
        sc_choose_background(&panel->volume, panel->looks.tissues,
                             panel->job.render.background.rgb);
    if (!job->render.background.is_none)
        sc_part_from_background(panel->volume.label_count, panel->job.render.background.rgb,
                                panel->looks.tissues);
    take_looks(panel);
    SC_PASS(sc_clip_sets_find(ctx, &panel->volume, job->tissues.exceptions,
                              job->tissues.exception_count, panel->looks.tissues,
                              panel->looks.clip_sets, &panel->looks.clip_set_count));
    if (job->verbs.count || job->tissues.track_count)
        SC_PASS(sc_verbs_resolve(ctx, &panel->volume, panel->looks.tissues, &verbs,
                                 &panel->looks.fades, &panel->looks.fade_count));
    return sc_explodes_resolve(ctx, &panel->volume, panel->looks.tissues, &verbs,
                               &panel->looks.shifts, &panel->looks.shift_count);
}

/* @return whether the colour of any tissue has key frames of its own. */
static bool has_color_tracks(const sc_panel *panel)
{
    for (int id = 0; id < panel->volume.label_count; id++) {
        if (panel->looks.tissues[id].color_track)
            return true;
    }
    return false;
}

/* Send the tones of the key frames of colours, if there are any, to all ranks. Collective. */
static sc_status share_tones(sc_app *app, sc_panel *panel)
{
    const sc_job *job = &panel->job;
    sc_track **tones = &panel->looks.color_tones;
    sc_status status = SC_OK;

    if (!has_color_tracks(panel))
        return SC_OK;
    if (sc_comm_rank(app->comm) == 0)
        status = SC_ZALLOC(app->ctx, job->tissues.track_count, tones);
    for (int id = 0; id < panel->volume.label_count && *tones; id++) {
        const int track = panel->looks.tissues[id].color_track;

        if (track)
            sc_track_tones(&job->tissues.tracks[track - 1], *tones + track - 1);
    }
    SC_PASS(sc_comm_agree(app->comm, status));
    return SC_BROADCAST(app, job->tissues.track_count, tones);
}

sc_status sc_panel_tissues(sc_app *app, sc_panel *panel)
{
    const bool first = sc_comm_rank(app->comm) == 0;

    /* Colours and opacities are decided with floating point, in which the libraries of two hosts
     * could differ. */
    SC_PASS(sc_comm_agree(app->comm, first ? resolve_tissues(app, panel) : SC_OK));
    SC_PASS(SC_BROADCAST(app, (size_t)panel->volume.label_count, &panel->looks.tissues));
    sc_comm_broadcast(app->comm, &panel->looks.fade_count, sizeof panel->looks.fade_count);
    SC_PASS(SC_BROADCAST(app, panel->looks.fade_count, &panel->looks.fades));
    sc_comm_broadcast(app->comm, &panel->looks.shift_count, sizeof panel->looks.shift_count);
    SC_PASS(SC_BROADCAST(app, panel->looks.shift_count, &panel->looks.shifts));
    SC_PASS(share_tones(app, panel));
    SC_PASS(sc_share_column_values(app, panel));
    SC_PASS(sc_comm_agree(app->comm,
                          sc_scene_room_init(app->ctx, panel->volume.label_count, &panel->room)));
    sc_comm_broadcast(app->comm, panel->job.render.background.rgb,
                      sizeof panel->job.render.background.rgb);
    sc_comm_broadcast(app->comm, &panel->looks.scale, sizeof panel->looks.scale);
    sc_comm_broadcast(app->comm, panel->looks.clip_sets, sizeof panel->looks.clip_sets);
    sc_comm_broadcast(app->comm, &panel->looks.clip_set_count, sizeof panel->looks.clip_set_count);
    return SC_OK;
}
