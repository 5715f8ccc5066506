/* SPDX-License-Identifier: BSD-3-Clause */
/* The verbs of a job that move the camera or clip planes, with the corners of the tissues that they
 * frame and the lines along which they fly. */
#include "panels.h"

#include <math.h>

/* Fill points with the corners of the boxes around tissues, of a volume that was only inspected.
 * @param members [label_count]. */
static sc_status find_boxes(const sc_ctx *ctx, const sc_prepared *volume, const bool *members,
                            sc_vec3 **points, size_t *count)
{
    SC_PASS(SC_ALLOC(ctx, 8 * (size_t)volume->label_count, points));
    *count = 0;
    for (int id = 1; id < volume->label_count; id++) {
        const sc_label_stats *s = &volume->stats[id];

        for (int corner = 0; corner < 8 && members[id] && s->low[0] <= s->high[0]; corner++)
            (*points)[(*count)++] = sc_tissue_corner(volume, id, corner);
    }
    return SC_OK;
}

/* The same with points among which are the corners of the tissues themselves. */
static sc_status find_hull(const sc_app *app, const sc_prepared *volume, const bool *members,
                           sc_vec3 **points, size_t *count)
{
    SC_OWN(sc_team_close_at) sc_team *team = NULL;
    SC_OWN(sc_free_at) uint8_t *show = NULL;
    sc_vec3 *hull;

    SC_PASS(SC_ZALLOC(app->ctx, (size_t)volume->label_count, &show));
    for (int id = 1; id < volume->label_count; id++)
        show[id] = members[id] ? SC_SHOW_BOUNDARY : 0;
    SC_PASS(sc_team_open(app->ctx, NULL, app->threads, sc_temporary_folder(), &team));
    SC_PASS(sc_hull_points(app->ctx, team, volume, show, &hull, count));
    SC_PASS(SC_ALLOC(app->ctx, *count, points)); /* the team owns the hull */
    if (*count)
        memcpy(*points, hull, *count * sizeof *hull);
    return SC_OK;
}

/* ---- lines ---- */

/* Find the patterns of the tissues of verb @p v. @param out room for all patterns of the job.
 * @return how many there are. */
static size_t find_patterns(const sc_job *job, size_t v, const char **out)
{
    size_t count = 0;

    for (size_t i = 0; i < job->verbs.tissue_count; i++) {
        if (job->verbs.tissues[i].of == (int)v)
            out[count++] = job->verbs.tissues[i].pattern;
    }
    return count;
}

/* Get the voxels for a line: those that are drawn, so that it is the same for a prepared file, but
 * those of the volume file if the drawn ones lack a tissue of the line, which is hidden, or if the
 * volume was only inspected. A prepared file that lacks them is refused. @param read what was read
 * of the file already; the caller owns it. @param out borrows from the panel or from @p read. */
static sc_status get_voxels(const sc_app *app, const sc_panel *panel, const sc_line_wish *wish,
                            sc_volume *read, sc_volume *out)
{
    const sc_input *input = &panel->inputs->all[panel->input];
    const sc_prepared *v = &panel->volume;
    sc_prepared file;

    if (panel->renderers && !sc_hidden_on_line(v, wish)) {
        *out = sc_volume_of_prepared(v);
        return SC_OK;
    }
    if (input->mapped) { /* it may hold what was hidden when it was prepared anew for the job */
        SC_PASS(sc_prepared_view(app->ctx, input->mapped->begin, input->mapped->bytes, &file));
        file.labels = v->labels; /* with the names of the job's table */
        SC_PASS(sc_check_line_voxels(app->ctx, panel->job.volume.path, &file, wish));
        *out = sc_volume_of_prepared(&file);
        return SC_OK;
    }
    if (!read->ids) {
        sc_stage_begin(app->ctx, "reading", 0, 0);
        SC_PASS(sc_input_voxels(app, &panel->job, input, read));
    }
    *out = *read;
    return SC_OK;
}

/* @return how many points of a line, found for @p fly, a flight follows: if the line leads up to
 * the end of a vessel, up to two radii before, so that its wall does not fill the picture. */
static size_t flown_points(const sc_verb *fly, const sc_centerline *line)
{
    const double kept = 2 * line->points[line->count - 1].radius_mm / line->length_mm;

    if (fly->fly.middles || (fly->fly.through_count > 1 && !line->ends_at_wall))
        return line->count;
    return line->count - (size_t)(fmin(kept, 0.5) * (double)(line->count - 1));
}

/* Find the line of a fly, and the radius of the space around it, if it leads through tissues.
 * @param read as of get_voxels. @param points, around_mm caller owns; the latter may stay as it is.
 */
static sc_status find_line(const sc_app *app, const sc_panel *panel, size_t v,
                           const char **patterns, sc_volume *read, sc_vec3 **points,
                           double **around_mm, size_t *count)
{
    const sc_job *job = &panel->job;
    const sc_verb *fly = &job->verbs.list[v];
    const size_t pattern_count = find_patterns(job, v, patterns);
    const sc_line_wish wish = {
        patterns,           pattern_count, fly->fly.through, (size_t)fly->fly.through_count,
        fly->fly.clearance, fly->where,    fly->fly.middles};
    /* without voxels any line stands for the one through the tissues */
    const bool unknown = pattern_count && app->options.check.fast;
    size_t room = (size_t)fly->fly.through_count * SC_WAY_STEPS + 1;
    SC_OWN(sc_centerline_clear) sc_centerline line = {0};
    sc_volume volume;

    if (pattern_count && !unknown) {
        SC_PASS(get_voxels(app, panel, &wish, read, &volume));
        SC_PASS(sc_find_line(app, &volume, &wish, &line));
        room = line.count;
    }
    SC_PASS(SC_ZALLOC(app->ctx, room, points));
    if (line.count)
        SC_PASS(SC_ZALLOC(app->ctx, room, around_mm));
    for (size_t i = 0; i < line.count; i++) {
        (*points)[i] = line.points[i].at_mm;
        (*around_mm)[i] = line.points[i].radius_mm;
    }
    *count = unknown         ? 1
             : pattern_count ? flown_points(fly, &line)
                             : sc_way_curve(fly->fly.through, fly->fly.through_count, *points);
    if (unknown)
        sc_info(app->ctx, "%s: the way through the tissues is not looked for (--fast)", fly->where);
    return SC_OK;
}

/* Append points of the tissues that verb @p v frames in one subject to @p points [*count]. */
static sc_status add_framed(const sc_app *app, const sc_panel *panel, size_t v, sc_vec3 **points,
                            size_t *count)
{
    const sc_job *job = &panel->job;
    const sc_verbs verbs = {job->verbs.list, job->verbs.count, job->verbs.tissues,
                            job->verbs.tissue_count, job->tissues.tracks};
    const sc_prepared *volume = &panel->volume;
    SC_OWN(sc_free_at) bool *members = NULL;
    SC_OWN(sc_free_at) sc_vec3 *found = NULL;
    size_t found_count = 0;

    SC_PASS(SC_ALLOC(app->ctx, (size_t)volume->label_count, &members));
    if (!sc_verb_members(volume, panel->looks.tissues, &verbs, v, members))
        return SC_OK;
    SC_PASS(panel->renderers ? find_hull(app, volume, members, &found, &found_count)
                             : find_boxes(app->ctx, volume, members, &found, &found_count));
    SC_PASS(SC_RESIZE(app->ctx, *count, *count + found_count, points));
    if (found_count)
        memcpy(*points + *count, found, found_count * sizeof *found);
    *count += found_count;
    return SC_OK;
}

sc_status sc_find_moves(const sc_app *app, const sc_panel *panel, sc_moves *out)
{
    const sc_job *job = &panel->job;
    SC_OWN(sc_free_at) const char **patterns = NULL;
    SC_OWN(sc_volume_clear) sc_volume read = {0};

    *out = (sc_moves){0};
    SC_PASS(SC_ALLOC(app->ctx, job->verbs.tissue_count + 1, &patterns));
    for (size_t v = 0; v < job->verbs.count; v++) {
        sc_move *move = &out->moves[out->count];
        sc_vec3 **points = &out->points[out->count];
        double **around_mm = &out->around_mm[out->count];

        if (!sc_verb_is_move(job->verbs.list[v].kind))
            continue;
        *move = (sc_move){.verb = job->verbs.list[v]};
        out->count++;
        if (move->verb.kind == SC_VERB_FLY)
            SC_PASS(
                find_line(app, panel, v, patterns, &read, points, around_mm, &move->point_count));
        for (int i = 0; move->verb.kind == SC_VERB_FRAME && i < panel->group.count; i++)
            SC_PASS(add_framed(app, &panel->group.all[i], v, points, &move->point_count));
        move->points = *points;
        move->around_mm = *around_mm;
    }
    return SC_OK;
}

void sc_moves_clear(sc_moves *moves)
{
    for (int i = 0; i < moves->count; i++)
        sc_free(moves->points[i]);
    for (int i = 0; i < moves->count; i++)
        sc_free(moves->around_mm[i]);
    *moves = (sc_moves){0};
}
