/* SPDX-License-Identifier: BSD-3-Clause */
/* The stages of preprocessing, in their order. */
#include "internal.h"

/* @return the sum of what the stages are worth that a preparation's settings ask for. */
static uint64_t worth_of(const sc_preparation *p)
{
    const sc_prepare_settings *s = &p->settings;

    return SC_WORTH_BOUNDARY + SC_WORTH_FIELDS + SC_WORTH_BORDERS + SC_WORTH_SURFACE +
           (s->local_thickness ? SC_WORTH_THICKNESS : 0);
}

/* Make what a rank has for itself before the stages: all but the arrays that they fill. @param out
 * caller owns: sc_preparation_free. @return SC_ERR_MEMORY; SC_ERR_DATA of sc_find_strengths. */
static sc_status begin(const sc_ctx *ctx, const sc_volume *volume,
                       const sc_prepare_settings *settings, sc_preparation **out)
{
    sc_preparation *p = NULL;
    sc_status status;

    SC_TRY(SC_ZALLOC(ctx, 1, &p));
    p->volume = volume;
    p->settings = *settings;
    if (!settings->team)
        SC_TRY(sc_team_open(ctx, NULL, settings->threads, NULL, &p->own_team));
    p->team = settings->team ? settings->team : p->own_team;
    p->settings.threads = sc_team_threads(p->team);
    for (int i = 0; i < 3; i++)
        p->bricks[i] = sc_bricks_along(volume->size[i]);
    p->brick_count = sc_brick_count(p->bricks);
    SC_TRY(sc_zalloc(ctx, (size_t)volume->label_count, 1, &p->hidden));
    for (int id = 0; settings->hidden && id < volume->label_count; id++)
        p->hidden[id] = settings->hidden[id];
    SC_TRY(sc_find_strengths(ctx, p));
    p->settings.hidden = NULL; /* were only borrowed for this call */
    p->settings.tissue_smooth = NULL;
    *out = p;
    return SC_OK;
out:
    sc_preparation_free(p);
    return status;
}

sc_status sc_prepare(const sc_ctx *ctx, const sc_volume *volume,
                     const sc_prepare_settings *settings, sc_preparation **out)
{
    sc_preparation *p = NULL;
    sc_status status = begin(ctx, volume, settings, &p);

    if (settings->team)
        status = sc_team_agree(settings->team, status);
    SC_TRY(status);
    sc_stage_begin(ctx, "preparing", 0, worth_of(p));
    SC_TRY(sc_find_boundary(ctx, p));
    SC_TRY(sc_index_boundary(ctx, p));
    SC_TRY(sc_smooth_borders(ctx, p));
    SC_TRY(sc_measure_covers(ctx, p));
    SC_TRY(sc_measure_surface(ctx, p));
    if (settings->local_thickness)
        SC_TRY(sc_measure_thickness(ctx, p));
    *out = p;
    return SC_OK;
out:
    sc_preparation_free(p);
    return status;
}

/* Free the arrays of the records of a field. */
static void free_border(sc_team *team, const sc_border *b)
{
    sc_team_free_const(team, b->masks);
    sc_team_free_const(team, b->start);
    sc_team_free_const(team, b->records);
}

void sc_preparation_free(sc_preparation *p)
{
    if (!p)
        return;
    if (p->team) {
        sc_team_free(p->team, p->near);
        sc_team_free(p->team, p->near_start);
        free_border(p->team, &p->outer);
        free_border(p->team, &p->inner);
        sc_team_free(p->team, p->thickness);
        sc_free_stored(p);
    }
    sc_team_close(p->own_team);
    sc_free(p->stats);
    sc_free(p->hidden);
    sc_free(p->smooth);
    sc_free(p);
}
