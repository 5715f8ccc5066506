/* SPDX-License-Identifier: BSD-3-Clause */
/* Cheapest ways from voxel to voxel (Dijkstra 1959, "A note on two problems in connexion with
 * graphs"), with a binary heap. Of two voxels of equal cost the one with the lower number comes
 * first, so that the ways are the same wherever they are found. */
#include "internal.h"

sc_status sc_search_open(const sc_ctx *ctx, const sc_region *region, sc_search *search)
{
    *search = (sc_search){0};
    SC_PASS(SC_ALLOC(ctx, region->count, &search->cost));
    SC_PASS(SC_ALLOC(ctx, region->count, &search->from));
    SC_PASS(SC_ALLOC(ctx, region->count, &search->heap));
    return SC_ALLOC(ctx, region->count, &search->slot);
}

void sc_search_clear(sc_search *search)
{
    sc_free(search->cost);
    sc_free(search->from);
    sc_free(search->heap);
    sc_free(search->slot);
    *search = (sc_search){0};
}

/* @return whether voxel @p a comes before @p b. */
static bool is_before(const sc_search *s, uint32_t a, uint32_t b)
{
    return s->cost[a] < s->cost[b] || (!(s->cost[b] < s->cost[a]) && a < b);
}

static void put(sc_search *s, uint32_t slot, uint32_t voxel)
{
    s->heap[slot] = voxel;
    s->slot[voxel] = slot;
}

/* Move a voxel of the heap towards its root, after its cost has become less. */
static void rise(sc_search *s, uint32_t voxel)
{
    uint32_t slot = s->slot[voxel];

    for (; slot > 0 && is_before(s, voxel, s->heap[(slot - 1) / 2]); slot = (slot - 1) / 2)
        put(s, slot, s->heap[(slot - 1) / 2]);
    put(s, slot, voxel);
}

/* Take the voxel of the least cost out of the heap. */
static uint32_t take_first(sc_search *s)
{
    const uint32_t first = s->heap[0], last = s->heap[--s->waiting];
    uint32_t slot = 0;

    for (uint32_t below; (below = 2 * slot + 1) < s->waiting; slot = below) {
        if (below + 1 < s->waiting && is_before(s, s->heap[below + 1], s->heap[below]))
            below++;
        if (!is_before(s, s->heap[below], last))
            break;
        put(s, slot, s->heap[below]);
    }
    if (s->waiting)
        put(s, slot, last);
    return first;
}

/* @return what a millimetre costs at a voxel. The cube keeps ways in the middle also where the
 * tissue bends; the middle itself is the same for any power. */
static double cost_per_mm(const sc_region *r, uint32_t voxel, bool is_short)
{
    const double depth = (double)r->depth_mm[voxel] / r->least_mm;

    return is_short ? 1 : 1 / (depth * depth * depth);
}

uint32_t sc_search_run(sc_search *search, const sc_region *region, uint32_t start, uint32_t end,
                       bool is_short)
{
    sc_search *s = search;
    uint32_t voxel = start;

    for (uint32_t n = 0; n < region->count; n++)
        s->cost[n] = HUGE_VAL;
    s->cost[start] = 0;
    s->from[start] = SC_NO_VOXEL;
    s->waiting = 1;
    put(s, 0, start);
    while (s->waiting) {
        double here;

        voxel = take_first(s);
        if (voxel == end)
            break;
        here = cost_per_mm(region, voxel, is_short);
        for (int i = 0; i < 26; i++) {
            const uint32_t number =
                region->number[(int64_t)region->place[voxel] + region->offset[i]];
            const uint32_t other = number - 1;
            double cost;

            if (!number)
                continue;
            cost = s->cost[voxel] +
                   0.5 * region->length_mm[i] * (here + cost_per_mm(region, other, is_short));
            if (!(cost < s->cost[other]))
                continue;
            if (!(s->cost[other] < HUGE_VAL))
                put(s, s->waiting++, other);
            s->cost[other] = cost;
            s->from[other] = voxel;
            rise(s, other);
        }
    }
    return voxel;
}
