/* SPDX-License-Identifier: BSD-3-Clause */
/* Distance of every cell from the nearest one that is marked, in two passes
 * in opposite directions. In each, the distance of a cell becomes the least distance of those of
 * its neighbours that the pass has already visited, plus one, if that is less. For the chessboard
 * distance, in which all 26 neighbours are one step away, and for the city-block distance, in which
 * the 6 are that share a face, the result is exact (Rosenfeld and Pfaltz 1968, "Distance functions
 * on digital pictures"). */
#include "segcast/prepare.h"

#include <string.h>

enum { FARTHEST = 254 /* larger distances count as this one */, CELL_ROW = SC_BRICK };

/* One pass over planes [y][x] of distances, which are at most FARTHEST. */
typedef struct sweep {
    sc_metric metric;
    int size[3];   /* places along x, y, z */
    int step;      /* 1 in the first pass, -1 in the second */
    uint8_t *near; /* scratch: [x] */
} sweep;

static inline uint8_t least(uint8_t a, uint8_t b)
{
    return a < b ? a : b;
}

/* out[x] becomes the least of itself and row[x]. */
static void lower_to_same(const uint8_t *restrict row, int size, uint8_t *restrict out)
{
    for (int x = 0; x < size; x++)
        out[x] = least(out[x], row[x]);
}

/* out[x] becomes the least of itself and of row[x - 1], row[x] and row[x + 1], as far as they
 * exist. Both rows have @p size elements, at least 1. */
static void lower_to_row(const uint8_t *restrict row, int size, uint8_t *restrict out)
{
    out[0] = least(out[0], least(row[0], row[size > 1]));
    for (int x = 1; x < size - 1; x++)
        out[x] = least(out[x], least(row[x - 1], least(row[x], row[x + 1])));
    out[size - 1] = least(out[size - 1], least(row[size - 1], row[size > 1 ? size - 2 : 0]));
}

/* Lower s->near, [x], to the least of those neighbours of row y of the plane @p now in the rows
 * that the pass has already visited. @param before the plane that it has visited last, NULL: none.
 */
static void find_nearest(const sweep *s, int y, const uint8_t *now, const uint8_t *before)
{
    const int nx = s->size[0], ny = s->size[1], last = y - s->step;
    const bool first = last < 0 || last >= ny;

    memset(s->near, FARTHEST, (size_t)nx);
    if (s->metric == SC_METRIC_CITY_BLOCK) {
        if (!first)
            lower_to_same(now + (size_t)last * (size_t)nx, nx, s->near);
        if (before)
            lower_to_same(before + (size_t)y * (size_t)nx, nx, s->near);
        return;
    }
    if (!first)
        lower_to_row(now + (size_t)last * (size_t)nx, nx, s->near);
    for (int i = y > 0 ? y - 1 : 0; before && i <= y + 1 && i < ny; i++)
        lower_to_row(before + (size_t)i * (size_t)nx, nx, s->near);
}

/* Lower the distances of the plane @p now, in place, to one more than the least of those neighbours
 * that the pass has already visited. They never exceed FARTHEST. @param before as of
 * find_nearest. */
static void sweep_plane(const sweep *s, uint8_t *now, const uint8_t *before)
{
    const int nx = s->size[0], ny = s->size[1];

    for (int i = 0; i < ny; i++) {
        const int y = s->step > 0 ? i : ny - 1 - i;
        uint8_t *row = now + (size_t)y * (size_t)nx;
        uint8_t last = FARTHEST;

        find_nearest(s, y, now, before);
        for (int x = s->step > 0 ? 0 : nx - 1; x >= 0 && x < nx; x += s->step) {
            const uint8_t closest = least(s->near[x], last);

            last = row[x] = least(row[x], closest < FARTHEST ? (uint8_t)(closest + 1) : FARTHEST);
        }
    }
}

/* Set the distances of all cells to 0 or, where they are not set in @p masks, [count], FARTHEST. */
static void begin_cells(const uint64_t *masks, size_t count, uint8_t *at)
{
    for (size_t i = 0; i < count; i++) {
        memset(at + i * SC_BRICK_VERTICES, FARTHEST, SC_BRICK_VERTICES);
        for (uint64_t left = masks[i]; left; left &= left - 1)
            at[i * SC_BRICK_VERTICES + (size_t)__builtin_ctzll(left)] = 0;
    }
    memset(at + count * SC_BRICK_VERTICES, 0, SC_GATHER_BYTES);
}

/* Copy plane @p z of the cells, of @p size along x, y and z, from bricks to @p plane, [y][x], or
 * back if @p store. */
static void copy_plane(const int size[3], int z, bool store, uint8_t *bricks, uint8_t *plane)
{
    const int bx = size[0] / SC_BRICK, by = size[1] / SC_BRICK;
    uint8_t *layer = bricks + (size_t)sc_brick_of(z) * (size_t)bx * (size_t)by * SC_BRICK_VERTICES +
                     (z & SC_BRICK_MASK) * SC_BRICK_LAYER;

    for (int y = 0; y < size[1]; y++) {
        uint8_t *from = layer + (size_t)sc_brick_of(y) * (size_t)bx * SC_BRICK_VERTICES +
                        (y & SC_BRICK_MASK) * CELL_ROW;
        uint8_t *to = plane + (size_t)y * (size_t)size[0];

        for (int x = 0; x < bx; x++) {
            uint8_t *in_brick = from + (size_t)x * SC_BRICK_VERTICES;
            uint8_t *in_plane = to + (size_t)x * CELL_ROW;

            memcpy(store ? in_brick : in_plane, store ? in_plane : in_brick, CELL_ROW);
        }
    }
}

/* Pass over all planes of the cells in @p bricks. @param planes scratch: two of them. */
static void sweep_cells(const sweep *s, uint8_t *bricks, uint8_t *planes[2])
{
    for (int i = 0; i < s->size[2]; i++) {
        const int z = s->step > 0 ? i : s->size[2] - 1 - i;
        uint8_t *now = planes[i & 1];

        copy_plane(s->size, z, false, bricks, now);
        sweep_plane(s, now, i ? planes[~i & 1] : NULL);
        copy_plane(s->size, z, true, bricks, now);
    }
}

/* What one thread does for the team. */
typedef struct cell_job {
    sweep sweep;
    const uint64_t *masks;
    size_t bricks;
    uint8_t *distances, *planes[2];
} cell_job;

/* Fill in the distances; an sc_range_fn on a cell_job, for one item. */
static void measure_cells(void *user, size_t begin, size_t end, int thread)
{
    cell_job *job = user;

    begin_cells(job->masks, job->bricks, job->distances);
    job->sweep.step = 1;
    sweep_cells(&job->sweep, job->distances, job->planes);
    job->sweep.step = -1;
    sweep_cells(&job->sweep, job->distances, job->planes);
}

sc_status sc_cell_distances(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                            const uint64_t *masks, sc_metric metric, uint8_t **out)
{
    cell_job job = {.sweep = {.metric = metric}, .masks = masks};
    int framed[3];
    size_t plane;
    void *distances, *scratch;

    sc_framed_size(volume->bricks, framed);
    job.bricks = sc_brick_count(framed);
    for (int i = 0; i < 3; i++)
        job.sweep.size[i] = framed[i] * SC_BRICK;
    plane = (size_t)job.sweep.size[0] * (size_t)job.sweep.size[1];
    SC_PASS(
        sc_team_alloc(ctx, team, job.bricks * SC_BRICK_VERTICES + SC_GATHER_BYTES, 1, &distances));
    SC_PASS(sc_team_alloc(ctx, team, 2 * plane + (size_t)job.sweep.size[0], 1, &scratch));
    job.distances = distances;
    job.planes[0] = scratch;
    job.planes[1] = job.planes[0] + plane;
    job.sweep.near = job.planes[1] + plane;
    sc_team_for(team, 1, 1, measure_cells, &job);
    *out = distances;
    sc_team_free(team, scratch);
    return SC_OK;
}
