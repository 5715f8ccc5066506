/* SPDX-License-Identifier: BSD-3-Clause */
/* What is done for all places, by the ranks of the team together or by one of them. */
#include "gather.h"
#include "internal.h"

void sc_gather_for(sc_gather *g, size_t count, size_t chunk, sc_range_fn *body)
{
    if (g->together)
        sc_team_for(g->renderer->team, count, chunk, body, g);
    else
        sc_parallel_for(g->renderer->settings.threads, count, chunk, body, g);
}

bool sc_gather_ends(const sc_gather *g)
{
    return !g->together && sc_is_given_up(g->renderer);
}

uint32_t sc_gather_number(const sc_gather *g, uint32_t first, uint32_t *counts)
{
    const size_t bricks = sc_brick_count(g->renderer->volume->bricks);

    if (sc_team_is_first(g->renderer->team)) {
        for (size_t brick = 0; brick <= bricks; brick++) {
            const uint32_t own = counts[brick];

            counts[brick] = first;
            first += own;
        }
    }
    (void)!sc_team_agree(g->renderer->team, SC_OK); /* all wait until it is done */
    return counts[bricks];
}
