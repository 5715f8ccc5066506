/* SPDX-License-Identifier: BSD-3-Clause */
/* The timeline of a panel: the camera, framed on what is seen, and all else that its frames follow
 * from. */
#include "panels.h"

/* Make the ways of flights on rank 0, and send them to the others. Collective. */
static sc_status share_ways(sc_app *app, sc_panel *panel)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_timeline *t = &panel->timeline;
    size_t ways = 0;
    sc_way_point *all = NULL;
    sc_status status = SC_OK;

    for (int i = 0; i < t->animation.move_count; i++)
        ways += t->moves[i].verb.kind == SC_VERB_FLY;
    t->ways = NULL;
    if (!ways)
        return SC_OK;
    if (first)
        status = SC_ALLOC(app->ctx, ways * SC_WAY_POINTS, &all);
    SC_PASS(sc_comm_agree(app->comm, status));
    ways = 0;
    for (int i = 0; i < t->animation.move_count; i++) {
        sc_move *move = &t->moves[i];

        if (move->verb.kind != SC_VERB_FLY)
            continue;
        if (first)
            sc_way_make(move->points, move->around_mm, move->point_count, move->verb.fly.ahead,
                        all + ways * SC_WAY_POINTS);
        move->points = NULL;
        move->around_mm = NULL;
        move->way = (int)ways++;
    }
    status = sc_broadcast_array(app, &all, ways * SC_WAY_POINTS, sizeof *all);
    sc_free(panel->ways);
    panel->ways = all;
    t->ways = all;
    return status;
}

/* Find the points that the camera has to show, on rank 0, if verbs bring tissues further than the
 * points @p points [count]: those, and where the tissues come to. @param out caller owns; NULL
 * where no tissue moves. */
static sc_status find_framed(const sc_app *app, const sc_panel *panel, const sc_vec3 *points,
                             size_t count, sc_animation *animation, sc_vec3 **out)
{
    const sc_panel_group *group = &panel->group;
    size_t reached = 0, at = count;

    for (int i = 0; count && i < group->count; i++)
        reached += 8 * group->all[i].looks.shift_count;
    if (!reached)
        return SC_OK;
    SC_PASS(SC_ALLOC(app->ctx, count + reached, out));
    memcpy(*out, points, count * sizeof **out);
    for (int i = 0; i < group->count; i++) {
        const sc_panel *one = &group->all[i];

        sc_shifts_reach(&one->volume, one->looks.shifts, one->looks.shift_count, *out + at);
        at += 8 * one->looks.shift_count;
    }
    animation->framed = *out;
    animation->framed_count = count + reached;
    return SC_OK;
}

/* Warn that all pictures of the panel will be empty: of a film those of one shot, which is named,
 * since the others may show tissues. */
static void warn_of_nothing(const sc_app *app, const sc_panel *panel)
{
    const char *where = panel->shot ? panel->shot->where : panel->job.lines.tissues;

    sc_warn(app->ctx, "%s%sno tissue is visible%s pictures will be empty", where,
            *where ? ": " : "", panel->shot ? " in this shot; its" : "; the");
}

/* Find the box around the tissue that the camera is focused on, if it is on one. If no voxels are
 * read, another box stands for it. */
static sc_status find_focus(const sc_app *app, const sc_panel *panel, sc_optics *o)
{
    const sc_pattern pattern = sc_pattern_of(o->pattern);
    const sc_prepared *v = &panel->volume;
    const sc_match best = sc_pattern_match(v->labels, v->label_count, &pattern);
    sc_box3 box = SC_BOX3_EMPTY;

    if (!(o->aperture_mm > 0) || o->focus != SC_FOCUS_TISSUE)
        return SC_OK;
    o->tissue = 0;
    for (int id = 1; id < v->label_count; id++) {
        const sc_label_stats *s = &v->stats[id];
        const sc_box3 own = {{s->low[0], s->low[1], s->low[2]},
                             {s->high[0], s->high[1], s->high[2]}};

        if (best == SC_MATCH_NONE || sc_label_match(&v->labels[id], &pattern) != best ||
            !panel->looks.tissues[id].visible ||
            (s->low[0] > s->high[0] && !app->options.check.fast))
            continue;
        o->tissue = id;
        for (int i = 0; i < 8; i++)
            sc_box3_hold(&box, sc_affine_point(&v->to_ras_mm, sc_box3_corner(&own, i)));
    }
    if (!o->tissue)
        return sc_fail(app->ctx, SC_ERR_DATA,
                       "%s%sfocus: nothing of \"%s\" is visible; expected a tissue that is shown",
                       o->where, o->where[0] ? ": " : "", o->pattern);
    o->focus_mm = sc_vec3_scale(sc_vec3_add(box.low, box.high), 0.5);
    o->half_mm = sc_vec3_scale(sc_vec3_sub(box.high, box.low), 0.5);
    return SC_OK;
}

void sc_panel_set_looks(sc_panel *panel)
{
    const sc_job *job = &panel->job;
    sc_timeline *t = &panel->timeline;

    memcpy(t->clip_sets, panel->looks.clip_sets, sizeof panel->looks.clip_sets);
    t->clip_set_count = panel->looks.clip_set_count;
    t->looks = (sc_looks){.tissues = panel->looks.tissues,
                          .label_count = panel->looks.tissues ? panel->volume.label_count : 0,
                          .tissue_tracks = job->tissues.tracks,
                          .color_tones = panel->looks.color_tones,
                          .fades = panel->looks.fades,
                          .fade_count = panel->looks.fade_count,
                          .shifts = panel->looks.shifts,
                          .shift_count = panel->looks.shift_count,
                          .column_values = panel->looks.column_values,
                          .column_steps = &job->color_columns.steps,
                          .scale = &panel->looks.scale,
                          .level_linear = panel->looks.level_linear,
                          .light = &job->light.constant,
                          .light_tracks = &job->light.tracks,
                          .background = &job->render.background,
                          .grey = &job->image.shown,
                          .grey_window = panel->grey.window,
                          .fps = job->output.fps,
                          .divider = &job->compare.divider,
                          .divider_track = &job->compare.divider_track};
}

sc_status sc_panel_timeline(sc_app *app, sc_panel *panel, const sc_vec3 *points, size_t count)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_animation animation = panel->job.animation;
    SC_OWN(sc_moves_clear) sc_moves moves = {0};
    SC_OWN(sc_free_at) sc_vec3 *framed = NULL;

    if (count == 0 && panel->volume.label_count > 1 && first)
        warn_of_nothing(app, panel);
    SC_PASS(sc_comm_agree(app->comm, first ? sc_find_moves(app, panel, &moves) : SC_OK));
    SC_PASS(
        sc_comm_agree(app->comm, first ? find_focus(app, panel, &animation.camera.optics) : SC_OK));
    animation.moves = moves.moves;
    animation.move_count = moves.count;
    SC_PASS(sc_comm_agree(
        app->comm, first ? find_framed(app, panel, points, count, &animation, &framed) : SC_OK));
    if (first)
        sc_timeline_resolve(&animation, points, count, sc_space_aspect(&panel->job),
                            &panel->timeline);
    /* Framing, too, is decided with floating point: see sc_panel_tissues. */
    sc_comm_broadcast(app->comm, &panel->timeline, sizeof panel->timeline);
    sc_panel_set_looks(panel);
    SC_PASS(share_ways(app, panel));
    if (count > 0 && first) {
        sc_warn_of_planes(app, panel);
        sc_tell_shape(app, panel);
        sc_tell_thin(app, panel);
        sc_tell_rests(app, panel);
    }
    return sc_comm_agree(
        app->comm, count > 0 && first
                       ? sc_warn_of_zoom(app, panel, sc_space_aspect(&panel->job), points, count)
                       : SC_OK);
}

sc_status sc_panel_hull(const sc_app *app, const sc_panel *panel, sc_vec3 **out, size_t *count)
{
    size_t points = 0, used = 0, part;

    for (int i = 0; i < panel->phases; i++) {
        (void)sc_renderer_hull(panel->renderers[i], &part);
        points += part;
    }
    SC_PASS(SC_ALLOC(app->ctx, points + 1, out));
    for (int i = 0; i < panel->phases; i++) {
        const sc_vec3 *hull = sc_renderer_hull(panel->renderers[i], &part);

        if (part)
            memcpy(*out + used, hull, part * sizeof **out);
        used += part;
    }
    *count = used;
    return SC_OK;
}
