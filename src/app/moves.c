/* SPDX-License-Identifier: BSD-3-Clause */
/* The verbs of a job that move the camera, with the corners of the tissues that they frame. */
#include "app.h"

#include <stdlib.h>
#include <string.h>

/* Fill points with the corners of the boxes around tissues, of a volume that was only inspected.
 * @param members [label_count]. */
static sc_status find_boxes(const sc_ctx *ctx, const sc_prepared *volume, const bool *members,
                            sc_vec3 **points, size_t *count)
{
    void *block;
    sc_status status = sc_alloc(ctx, 8 * (size_t)volume->label_count, sizeof **points, &block);

    if (status != SC_OK)
        return status;
    *points = block;
    *count = 0;
    for (int id = 1; id < volume->label_count; id++) {
        const sc_label_stats *s = &volume->stats[id];

        for (int corner = 0; corner < 8 && members[id] && s->low[0] <= s->high[0]; corner++)
            (*points)[(*count)++] = sc_affine_point(
                &volume->to_ras_mm, (sc_vec3){corner & 1 ? s->high[0] + 0.5 : s->low[0] - 0.5,
                                              corner & 2 ? s->high[1] + 0.5 : s->low[1] - 0.5,
                                              corner & 4 ? s->high[2] + 0.5 : s->low[2] - 0.5});
    }
    return SC_OK;
}

/* The same with points among which are the corners of the tissues themselves. */
static sc_status find_hull(const sc_app *app, const sc_prepared *volume, const bool *members,
                           sc_vec3 **points, size_t *count)
{
    sc_team *team = NULL;
    void *show = NULL, *copy = NULL;
    sc_vec3 *hull;
    size_t found;
    sc_status status;

    SC_TRY(sc_zalloc(app->ctx, (size_t)volume->label_count, 1, &show));
    for (int id = 1; id < volume->label_count; id++)
        ((uint8_t *)show)[id] = members[id] ? SC_SHOW_BOUNDARY : 0;
    SC_TRY(sc_team_open(app->ctx, NULL, app->threads, sc_temporary_folder(), &team));
    SC_TRY(sc_hull_points(app->ctx, team, volume, show, &hull, &found));
    SC_TRY(sc_alloc(app->ctx, found, sizeof *hull, &copy)); /* the team owns the hull */
    if (found)
        memcpy(copy, hull, found * sizeof *hull);
    *points = copy;
    *count = found;
out:
    sc_team_close(team);
    sc_free(show);
    return status;
}

sc_status sc_find_moves(const sc_app *app, const sc_session *session, sc_moves *out)
{
    const sc_job *job = &session->job;
    const sc_verbs verbs = {job->verbs, job->verb_count, job->verb_tissues, job->verb_tissue_count};
    const sc_prepared *volume = &session->volume;
    void *members = NULL;
    sc_status status;

    *out = (sc_moves){0};
    SC_TRY(sc_alloc(app->ctx, (size_t)volume->label_count, sizeof(bool), &members));
    for (size_t v = 0; v < job->verb_count; v++) {
        sc_move *move = &out->moves[out->count];
        sc_vec3 **points = &out->points[out->count];

        if (!sc_verb_moves_camera(job->verbs[v].kind))
            continue;
        *move = (sc_move){.verb = job->verbs[v]};
        out->count++;
        if (move->verb.kind != SC_VERB_FRAME ||
            !sc_verb_members(volume, session->tissues, &verbs, v, members))
            continue;
        SC_TRY(session->renderer
                   ? find_hull(app, volume, members, points, &move->point_count)
                   : find_boxes(app->ctx, volume, members, points, &move->point_count));
        move->points = *points;
    }
out:
    sc_free(members);
    return status;
}

void sc_moves_clear(sc_moves *moves)
{
    for (int i = 0; i < moves->count; i++)
        sc_free(moves->points[i]);
    *moves = (sc_moves){0};
}
