/* SPDX-License-Identifier: BSD-3-Clause */
/* Distance of every brick from the nearest one that is not empty, in two passes over the bricks in
 * opposite directions. In each, the distance of a brick becomes the least distance of those of its
 * neighbours that the pass has already visited, plus one, if that is less. For the chessboard
 * distance, in which all 26 neighbours are one step away, the result is exact (Rosenfeld and Pfaltz
 * 1968, "Distance functions on digital pictures"). */
#include "segcast/prepare.h"

#include <string.h>

enum { FARTHEST = 254 }; /* larger distances count as this one */

typedef struct distance_grid {
    int size[3]; /* bricks along x, y, z, the frame included */
    uint8_t *at; /* [z][y][x] distances in bricks, at most FARTHEST */
} distance_grid;

static inline uint8_t least(uint8_t a, uint8_t b)
{
    return a < b ? a : b;
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

/* Lower the distances of row (y, z) of the grid, in place, to one more than the least of those
 * neighbours that the pass has already visited: in the rows (y - step, z - step), (y, z - step),
 * (y + step, z - step) and (y - step, z), as far as they exist, and then along the row itself. They
 * never exceed FARTHEST. @param step 1 in the first pass, -1 in the second. @param near scratch of
 * size[0] bytes. */
static void pass_row(const distance_grid *g, int y, int z, int step, uint8_t *near)
{
    const int nx = g->size[0], ny = g->size[1], nz = g->size[2];
    uint8_t *row = g->at + ((size_t)z * (size_t)ny + (size_t)y) * (size_t)nx;
    uint8_t before = FARTHEST;

    memset(near, FARTHEST, (size_t)nx);
    for (int i = 0; i < 4; i++) {
        const int other_y = i < 3 ? y - step + step * i : y - step;
        const int other_z = i < 3 ? z - step : z;

        if (other_y >= 0 && other_y < ny && other_z >= 0 && other_z < nz)
            lower_to_row(g->at + ((size_t)other_z * (size_t)ny + (size_t)other_y) * (size_t)nx, nx,
                         near);
    }
    for (int x = step > 0 ? 0 : nx - 1; x >= 0 && x < nx; x += step) {
        const uint8_t closest = least(near[x], before);

        before = row[x] = least(row[x], closest < FARTHEST ? (uint8_t)(closest + 1) : FARTHEST);
    }
}

sc_status sc_brick_distances(const sc_ctx *ctx, const sc_prepared *volume, const uint64_t *masks,
                             uint8_t **out)
{
    distance_grid g;
    size_t count;
    void *block = NULL, *near = NULL;
    sc_status status;

    sc_framed_size(volume->bricks, g.size);
    count = sc_brick_count(g.size);
    SC_TRY(sc_alloc(ctx, count + SC_GATHER_BYTES, 1, &block));
    g.at = block;
    SC_TRY(sc_alloc(ctx, (size_t)g.size[0], 1, &near));
    for (size_t i = 0; i < count; i++)
        g.at[i] = masks[i] ? 0 : FARTHEST;
    memset(g.at + count, 0, SC_GATHER_BYTES);
    for (int z = 0; z < g.size[2]; z++) {
        for (int y = 0; y < g.size[1]; y++)
            pass_row(&g, y, z, 1, near);
    }
    for (int z = g.size[2] - 1; z >= 0; z--) {
        for (int y = g.size[1] - 1; y >= 0; y--)
            pass_row(&g, y, z, -1, near);
    }
    *out = g.at;
    block = NULL;
out:
    sc_free(near);
    sc_free(block);
    return status;
}
