/* SPDX-License-Identifier: BSD-3-Clause */
/* The order of the stages that find the fields of borders, and how long their arrays are kept. */
#include "border/border.h"

/* Free the arrays of the fields. */
static void clear_borders(sc_borders *b)
{
    const sc_tiles *t = &b->tiles;
    const sc_quarters *q = &b->quarters;
    void *const arrays[] = {b->around, b->subs.lists, b->subs.blocks, b->start,
                            t->labels, t->cube_of,    t->beside,      b->squares,
                            b->fine,   b->value,      b->still,       b->coarse,
                            q->wide,   q->missing,    q->area,        b->strengths};

    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        sc_team_free(b->p->team, arrays[i]);
}

/* Free an array that no later stage reads. */
static void drop(void **array, const sc_preparation *p)
{
    sc_team_free(p->team, *array);
    *array = NULL;
}

sc_status sc_smooth_borders(const sc_ctx *ctx, sc_preparation *p)
{
    sc_borders b = {.p = p};
    sc_status status;

    SC_TRY(sc_find_tiles(ctx, &b));
    SC_TRY(sc_find_blocks_of_three(ctx, &b));
    SC_TRY(sc_measure_distances(ctx, &b));
    if (sc_is_smoothed(p)) {
        SC_TRY(sc_smooth_cells(ctx, &b));
        SC_TRY(sc_keep_volume_of_cells(ctx, &b));
        SC_TRY(sc_smooth_quarters(ctx, &b));
        SC_TRY(sc_weigh_cells(ctx, &b));
    } else {
        SC_TRY(sc_take_data(ctx, &b));
    }
    sc_smooth_voxels(ctx, &b);
    drop((void **)&b.value, p);
    drop((void **)&b.subs.lists, p);
    drop((void **)&b.subs.blocks, p);
    if (sc_is_smoothed(p))
        sc_keep_volume_of_voxels(ctx, &b);
    sc_keep_links(ctx, &b);
    drop((void **)&b.squares, p);
    SC_TRY(sc_write_records(ctx, p, &b));
out:
    clear_borders(&b);
    return status;
}
