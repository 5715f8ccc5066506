/* SPDX-License-Identifier: BSD-3-Clause */
/* A session from its volumes to pictures: the panels get their looks, renderers, cameras and texts,
 * one group of panels after the other. */
#include "panels.h"

#include <math.h>

/* ---- messages that name the shot ---- */

/* What a shot does with a message. */
typedef struct speaker {
    sc_app app; /* as that of the film, but with the context below */
    sc_ctx ctx;
    sc_app *film; /* borrowed */
    const sc_shot *shot;
    int number; /* of the shot, from 1 */
} speaker;

/* Pass a message on, for sc_ctx.write: an error or a warning with the number and the name of the
 * shot, unless it begins with the file in which the shot stands, so that it tells its place
 * already. */
static void write_with_shot(void *user, sc_log_level level, const char *text)
{
    const speaker *s = user;
    const sc_ctx *ctx = s->film->ctx;
    const char *name = s->shot->name, *colon = strrchr(s->shot->where, ':');
    const size_t length = colon ? (size_t)(colon - s->shot->where) : 0;

    if (level > SC_LOG_WARN || (length > 0 && !strncmp(text, s->shot->where, length)))
        ctx->write(ctx->user, level, text);
    else if (level == SC_LOG_WARN)
        sc_warn(ctx, "shot %d%s%s%s: %s", s->number, name[0] ? " (" : "", name, name[0] ? ")" : "",
                text);
    else
        (void)sc_fail(ctx, SC_ERR_INTERNAL, "shot %d%s%s%s: %s", s->number, name[0] ? " (" : "",
                      name, name[0] ? ")" : "", text);
}

/* Begin to speak for a panel: for the shot @p number, if it is one. */
static void begin_to_speak(sc_app *app, const sc_panel *panel, int number, speaker *out)
{
    *out = (speaker){
        .app = *app, .ctx = *app->ctx, .film = app, .shot = panel->shot, .number = number};
    out->app.ctx = &out->ctx;
    if (!app->ctx->write || !panel->shot)
        return;
    out->ctx.rank = 0; /* that of the film's context is told */
    out->ctx.write = write_with_shot;
    out->ctx.user = out;
}

/* ---- tissues ---- */

/* Give all panels that leave their background to be chosen the one that was chosen for @p from. */
static void share_background(sc_session *session, const sc_panel *from)
{
    for (int i = 0; i < session->panel_count; i++) {
        sc_background *background = &session->panels[i].job.render.background;

        if (!background->is_auto)
            continue;
        memmove(background->rgb, from->job.render.background.rgb, sizeof background->rgb);
        background->is_auto = false;
    }
}

sc_status sc_session_tissues(sc_app *app, sc_session *session)
{
    speaker voice;
    bool chosen = false;

    for (int i = 0; i < session->panel_count; i++) {
        sc_panel *panel = &session->panels[i];

        if (!panel->phases)
            continue;
        begin_to_speak(app, panel, i + 1, &voice);
        SC_PASS(sc_panel_tissues(&voice.app, panel));
        if (!chosen) /* for title cards, also if the shot has one of its own */
            share_background(session, panel);
        chosen = true;
    }
    return SC_OK;
}

/* ---- grey volumes ---- */

/* @return the first of @p count panels that has the grey volume @p path; NULL: none. */
static const sc_panel *find_grey(const sc_panel *panels, int count, const char *path)
{
    for (int i = 0; i < count; i++) {
        if (panels[i].phases && panels[i].job.given.image &&
            !strcmp(panels[i].job.image.path, path))
            return &panels[i];
    }
    return NULL;
}

/* @return a panel before @p i, or of the lender, that has the same grey volume; NULL: none. */
static const sc_panel *lender_of(const sc_session *session, int i)
{
    const char *path = session->panels[i].job.image.path;
    const sc_panel *found = find_grey(session->panels, i, path);

    return found || !session->lender
               ? found
               : find_grey(session->lender->panels, session->lender->panel_count, path);
}

/* Read the grey volumes of all panels, those of the same file once. */
static sc_status load_grey(sc_app *app, sc_session *session)
{
    for (int i = 0; i < session->panel_count; i++) {
        sc_panel *panel = &session->panels[i];
        const sc_panel *lender = lender_of(session, i);

        if (!panel->phases || !panel->job.given.image)
            continue;
        if (lender)
            SC_PASS(sc_grey_borrow(app, &panel->job, &panel->volume, &lender->grey, &panel->grey));
        else
            SC_PASS(sc_grey_load(app, &panel->job, &panel->volume, &session->times, &panel->grey));
        /* What is found for the first one holds for all, so that the same value looks the same. */
        for (int j = 1; i == 0 && j < session->panel_count; j++) {
            session->panels[j].job.image.window_auto = false;
            session->panels[j].job.image.shown.window = panel->grey.window;
        }
    }
    return SC_OK;
}

sc_status sc_session_check_grey(const sc_app *app, const sc_session *session)
{
    for (int i = 0; i < session->panel_count; i++) {
        const sc_panel *panel = &session->panels[i], *lender = lender_of(session, i);

        if (panel->phases && (!lender || lender->input != panel->input))
            SC_PASS(sc_grey_check(app, &panel->job, &panel->volume, panel->grey.moved_mm));
    }
    return SC_OK;
}

uint64_t sc_session_grey_bytes(const sc_session *session)
{
    uint64_t bytes = 0;

    for (int i = 0; i < session->panel_count; i++)
        bytes += session->panels[i].grey.codes ? sc_grey_bytes(&session->panels[i].grey.grey) : 0;
    return bytes;
}

/* ---- renderers ---- */

static bool are_same_bytes(const void *a, const void *b, size_t bytes)
{
    return memcmp(a, b, bytes) == 0;
}

/* Do two panels, whose tissues are resolved, draw in the same way? All keys that are added later
 * are compared, too. Should bytes between two members differ without a reason, each has its
 * renderer, and draws the same. */
static bool draws_alike(const sc_panel *a, const sc_panel *b)
{
    const sc_grey_tracks *grey = &a->job.image.shown, *other = &b->job.image.shown;

    return a->phases && a->input == b->input &&
           are_same_bytes(&a->job.render, &b->job.render, sizeof a->job.render) &&
           are_same_bytes(&a->job.light.constant, &b->job.light.constant,
                          sizeof a->job.light.constant) &&
           a->job.light.environment.turn_deg == b->job.light.environment.turn_deg &&
           !strcmp(a->job.light.environment.file, b->job.light.environment.file) &&
           are_same_bytes(&a->job.light.tracks, &b->job.light.tracks, sizeof a->job.light.tracks) &&
           are_same_bytes(&grey->caps, &other->caps, sizeof grey->caps) &&
           are_same_bytes(&grey->slices, &other->slices, sizeof grey->slices) &&
           sc_track_most(&grey->backdrop_track, grey->backdrop) ==
               sc_track_most(&other->backdrop_track, other->backdrop) &&
           are_same_bytes(a->looks.tissues, b->looks.tissues,
                          (size_t)a->volume.label_count * sizeof *a->looks.tissues);
}

/* @return the first of @p count panels that draws as @p panel does; @p count: none. */
static int find_alike(const sc_panel *panels, int count, const sc_panel *panel)
{
    int same = 0;

    while (same < count && !(panels[same].renderers && draws_alike(&panels[same], panel)))
        same++;
    return same;
}

/* Fill the renderers of panel @p i: those of an earlier one, or of one of the lender's, if it draws
 * in the same way. */
static sc_status find_renderers(sc_app *app, sc_session *session, int i)
{
    const sc_session *lender = session->lender;
    const int lent = lender ? lender->panel_count : 0;
    sc_panel *panel = &session->panels[i];
    int same = i; /* those of the lender are counted from i on */

    if (sc_comm_rank(app->comm) == 0)
        same = find_alike(session->panels, i, panel);
    if (same == i && lent && sc_comm_rank(app->comm) == 0)
        same += find_alike(lender->panels, lent, panel);
    sc_comm_broadcast(app->comm, &same, sizeof same);
    if (same == i + lent)
        return sc_panel_renderers(app, panel);
    panel->renderers = (same < i ? &session->panels[same] : &lender->panels[same - i])->renderers;
    panel->borrows_renderers = true;
    return SC_OK;
}

sc_renderer *sc_session_renderer(const sc_session *session, int i)
{
    for (int p = 0; p < session->panel_count; p++) {
        const sc_panel *panel = &session->panels[p];

        if (!panel->renderers || panel->borrows_renderers)
            continue;
        if (i < panel->phases)
            return panel->renderers[i];
        i -= panel->phases;
    }
    return NULL;
}

uint64_t sc_session_renderer_bytes(const sc_session *session, uint64_t *derived)
{
    sc_renderer *renderer;
    uint64_t bytes = 0;

    *derived = 0;
    for (int i = 0; (renderer = sc_session_renderer(session, i)) != NULL; i++) {
        bytes += sc_renderer_bytes(renderer);
        *derived += sc_renderer_derived_bytes(renderer);
    }
    return bytes;
}

/* ---- timelines and texts ---- */

/* Find the box, in voxels of the volume @p to, of a tissue that only another one has. */
static sc_label_stats stats_for(const sc_prepared *from, const sc_label_stats *stats,
                                const sc_prepared *to)
{
    const sc_box3 box = {{stats->low[0], stats->low[1], stats->low[2]},
                         {stats->high[0], stats->high[1], stats->high[2]}};
    sc_label_stats out = *stats;
    sc_affine to_voxel;
    sc_box3 there = SC_BOX3_EMPTY;

    if (!stats->voxels || !sc_affine_invert(&to->to_ras_mm, &to_voxel))
        return out;
    for (int i = 0; i < 8; i++)
        sc_box3_hold(&there, sc_affine_point(&to_voxel, sc_affine_point(&from->to_ras_mm,
                                                                        sc_box3_corner(&box, i))));
    for (int i = 0; i < 3; i++) {
        const double low = ((const double[]){there.low.x, there.low.y, there.low.z})[i];
        const double high = ((const double[]){there.high.x, there.high.y, there.high.z})[i];

        out.low[i] = (int)floor(fmax(low, -1e6));
        out.high[i] = (int)ceil(fmin(high, 1e6));
    }
    return out;
}

/* Let what is written over all know the tissues of all subjects: as the first one does, but with
 * the extent of those that only others have. */
static sc_status fill_front(const sc_ctx *ctx, sc_session *session)
{
    sc_compare *c = session->compare;
    const sc_panel *first = &session->panels[0];
    const int labels = first->volume.label_count, own = labels - c->joined[0].added;
    sc_panel *front = first->group.front;

    SC_PASS(SC_ALLOC(ctx, (size_t)labels, &c->stats));
    memcpy(c->stats, first->volume.stats, (size_t)labels * sizeof *c->stats);
    for (int id = own; id < labels; id++) {
        const sc_tissue_owner *owner = &first->group.owners[id];
        const sc_prepared *v = &session->panels[owner->subject].volume;

        c->stats[id] = stats_for(v, &v->stats[owner->id], &first->volume);
    }
    front->volume = first->volume;
    front->volume.ids = NULL; /* it has no names beside tissues */
    front->volume.stats = c->stats;
    front->looks.tissues = first->looks.tissues;
    return SC_OK;
}

/* List the points that the panels of a group show. Caller owns *out: sc_free. */
static sc_status gather_points(const sc_app *app, const sc_panel_group *group, sc_points_fn *find,
                               sc_vec3 **out, size_t *count)
{
    SC_OWN(sc_free_at) sc_vec3 *points = NULL;

    *count = 0;
    for (int i = 0; i < group->count; i++) {
        SC_OWN(sc_free_at) sc_vec3 *found = NULL;
        size_t more;

        SC_PASS(find(app, &group->all[i], &found, &more));
        SC_PASS(SC_RESIZE(app->ctx, *count, *count + more + 1, &points));
        if (more)
            memcpy(points + *count, found, more * sizeof *points);
        *count += more;
    }
    SC_HAND_OVER(points, out);
    return SC_OK;
}

/* Fill the timelines of a group. @param lead its first panel. */
static sc_status frame_group(sc_app *app, sc_session *session, sc_panel *lead, sc_points_fn *find)
{
    SC_OWN(sc_free_at) sc_vec3 *points = NULL;
    size_t count = 0;

    if (!lead->phases) { /* a title card */
        sc_timeline_resolve(&lead->job.animation, NULL, 0, sc_space_aspect(&lead->job),
                            &lead->timeline);
        sc_panel_set_looks(lead);
        return SC_OK;
    }
    /* One framing holds for all phases and subjects, so that the camera does not move with them. */
    SC_PASS(sc_comm_agree(app->comm, gather_points(app, &lead->group, find, &points, &count)));
    SC_PASS(sc_panel_timeline(app, lead, points, count));
    for (int i = 0; session->compare && i < session->panel_count; i++) {
        sc_panel *panel = &session->panels[i];

        panel->timeline = lead->timeline;
        if (panel->phases)
            sc_panel_set_looks(panel);
    }
    if (session->compare)
        return sc_comm_agree(app->comm, fill_front(app->ctx, session));
    return SC_OK;
}

/* Make the renderers of the panels of a group, its timelines, and what is written onto it. */
static sc_status make_group(sc_app *app, sc_session *session, sc_panel *lead, sc_points_fn *find)
{
    const int first = (int)(lead - session->panels);
    const int count = session->compare ? session->panel_count : 1;
    sc_panel *front = lead->group.front;
    speaker voice;
    sc_status status = SC_OK;

    for (int i = 0; !find && i < count; i++) {
        if (session->panels[first + i].phases)
            SC_PASS(find_renderers(app, session, first + i));
    }
    begin_to_speak(app, lead, first + 1, &voice);
    if (!lead->renderers) /* nothing is drawn: the mistakes of shots are told once */
        voice.app.ctx = app->ctx;
    SC_TRY(frame_group(&voice.app, session, lead, find ? find : sc_panel_hull));
    if (front) /* first: the names of the subjects leave room for it */
        SC_TRY(sc_panel_letter(&voice.app, front));
    for (int i = 0; i < count; i++) {
        if (&session->panels[first + i] != front)
            SC_TRY(sc_panel_letter(&voice.app, &session->panels[first + i]));
    }
out:
    app->font_told = voice.app.font_told;
    return status;
}

sc_status sc_session_timelines(sc_app *app, sc_session *session, sc_points_fn *find)
{
    for (int i = 0; i < session->panel_count; i++) {
        if (session->panels[i].group.index == 0)
            SC_PASS(make_group(app, session, &session->panels[i], find));
    }
    return SC_OK;
}

/* ---- all of it ---- */

sc_status sc_session_load(sc_app *app, sc_session *session)
{
    if (session->lender) {
        session->inputs = session->lender->inputs;
        return SC_OK;
    }
    return sc_inputs_load(app, &session->job, session->measure, &session->times, &session->inputs);
}

sc_status sc_session_scene(sc_app *app, sc_session *session)
{
    const double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();

    SC_PASS(sc_session_panels(app, session));
    SC_PASS(load_grey(app, session));
    for (int i = 0; i < session->panel_count; i++)
        SC_PASS(sc_panel_environment(app, &session->panels[i]));
    sc_stage_begin(app->ctx, "preparing the light", 0, 0);
    SC_PASS(sc_session_tissues(app, session));
    SC_PASS(sc_session_timelines(app, session, NULL));
    if (!session->give_up) /* else a picture is wanted at once: sc_session_light */
        SC_PASS(sc_panels_gather(app, session));
    for (int i = 0; i < session->panel_count; i++)
        sc_panel_unload(&session->panels[i], 0); /* names and flights look into its voxels */
    sc_add_time(app, &session->times, SC_PHASE_PREPARE, wall_s, cpu_s);
    return SC_OK;
}

sc_status sc_session_volume(sc_app *app, sc_session *session)
{
    SC_PASS(sc_session_load(app, session));
    return sc_session_scene(app, session);
}

void sc_session_move_inputs(sc_session *from, sc_session *to)
{
    sc_inputs_unload(from->inputs);
    to->inputs = from->inputs;
    from->inputs = NULL;
    for (int i = 0; i < from->panel_count; i++) {
        sc_grey_input *grey = &from->panels[i].grey;

        for (int j = 0; j < to->panel_count && grey->codes; j++) {
            if (to->panels[j].grey.grey.codes != grey->grey.codes || to->panels[j].grey.codes)
                continue;
            to->panels[j].grey.codes = grey->codes;
            grey->codes = NULL;
        }
    }
}

void sc_session_clear(sc_session *session)
{
    sc_panels_free(session);
    sc_image_clear(&session->other);
    sc_image_clear(&session->moment);
    sc_free(session->light);
    if (!session->lender)
        sc_inputs_free(session->inputs);
    sc_job_clear(&session->job);
    *session = (sc_session){0};
}
