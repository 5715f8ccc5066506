/* SPDX-License-Identifier: BSD-3-Clause */
/* Distance of every brick from the nearest one that is not empty, in one pass per axis. The
 * chessboard distance is the largest of the distances along the axes, so that the least of it over
 * all bricks is found axis by axis: after a pass a brick has its distance from the nearest one that
 * differs in none but the axes so far (after Saito and Toriwaki 1994, "New algorithms for euclidean
 * distance transformation", whose sum of squares is a maximum here). Rows do not depend on each
 * other. */
#include "segcast/prepare.h"

#include <string.h>

enum { FARTHEST = 254, /* larger distances count as this one */ ROWS = 64 /* claimed at a time */ };

/* One pass; its threads share it. Arrays are [z][y][x], the frame included. */
typedef struct distance_pass {
    int size[3];           /* bricks along x, y, z */
    int axis;              /* of the pass, 1 or 2 */
    const uint64_t *masks; /* source of the pass along x */
    const uint8_t *from;   /* source of the others */
    uint8_t *to;           /* distances in bricks, at most FARTHEST */
} distance_pass;

static inline uint8_t least(uint8_t a, uint8_t b)
{
    return a < b ? a : b;
}

/* Write rows [begin, end) of distances along x alone; an sc_range_fn on a distance_pass. */
static void measure_rows(void *user, size_t begin, size_t end, int thread)
{
    const distance_pass *p = user;
    const int nx = p->size[0];

    for (size_t row = begin; row < end; row++) {
        const uint64_t *masks = p->masks + row * (size_t)nx;
        uint8_t *to = p->to + row * (size_t)nx;
        uint8_t before = FARTHEST;

        for (int x = 0; x < nx; x++)
            to[x] = before = masks[x] ? 0 : least((uint8_t)(before + 1), FARTHEST);
        for (int x = nx - 1; x >= 0; x--)
            to[x] = before = least(to[x], least((uint8_t)(before + 1), FARTHEST));
    }
}

/* @return the largest of @p count distances. */
static uint8_t largest(const uint8_t *at, int count)
{
    uint8_t most = 0;

    for (int i = 0; i < count; i++)
        most = at[i] > most ? at[i] : most;
    return most;
}

/* Lower each of @p count distances to that of the brick @p steps away along another axis, or to the
 * number of steps if that is more. */
static void lower(uint8_t *restrict to, const uint8_t *restrict other, int count, uint8_t steps)
{
    for (int i = 0; i < count; i++) {
        const uint8_t there = other[i] > steps ? other[i] : steps;

        to[i] = least(to[i], there);
    }
}

/* Write rows [begin, end) of distances, taking the pass's axis in; an sc_range_fn on a
 * distance_pass. Other rows are looked at nearest first, as long as one may be nearer than what has
 * been found. */
static void widen_rows(void *user, size_t begin, size_t end, int thread)
{
    const distance_pass *p = user;
    const size_t nx = (size_t)p->size[0], ny = (size_t)p->size[1];
    const size_t step = p->axis == 1 ? nx : nx * ny;

    for (size_t row = begin; row < end; row++) {
        const int place = (int)(p->axis == 1 ? row % ny : row / ny);
        const int after = p->size[p->axis] - 1 - place;
        const uint8_t *from = p->from + row * nx;
        uint8_t *to = p->to + row * nx;

        memcpy(to, from, nx);
        for (int i = 1; (i <= place || i <= after) && i < largest(to, (int)nx); i++) {
            if (i <= place)
                lower(to, from - (size_t)i * step, (int)nx, (uint8_t)i);
            if (i <= after)
                lower(to, from + (size_t)i * step, (int)nx, (uint8_t)i);
        }
    }
}

sc_status sc_brick_distances(const sc_ctx *ctx, sc_team *team, const int bricks[3],
                             const uint64_t *masks, uint8_t **out)
{
    distance_pass p = {.masks = masks};
    size_t count, rows;
    void *distances, *other;

    sc_framed_size(bricks, p.size);
    count = sc_brick_count(p.size);
    rows = (size_t)p.size[1] * (size_t)p.size[2];
    SC_PASS(sc_team_alloc(ctx, team, count + SC_GATHER_BYTES, 1, &distances));
    SC_PASS(sc_team_alloc(ctx, team, count, 1, &other));
    p.to = distances;
    sc_team_for(team, rows, ROWS, measure_rows, &p);
    p.axis = 1;
    p.from = distances;
    p.to = other;
    sc_team_for(team, rows, ROWS, widen_rows, &p);
    p.axis = 2;
    p.from = other;
    p.to = distances;
    sc_team_for(team, rows, ROWS, widen_rows, &p);
    *out = distances;
    sc_team_free(team, other);
    return SC_OK;
}
