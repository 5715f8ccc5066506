/* SPDX-License-Identifier: BSD-3-Clause */
/* Points that hold all corners of the convex hull of what is visible: in each layer of the volume
 * the corners of the hull of its visible voxels' centres, of which only the first and the last of a
 * row can be one, and of each the outer corners of the voxel's box. */
#include "segcast/prepare.h"

enum { OUTER = 4 /* corners of the box of a first or last voxel of a row: on that side */ };

/* What the threads that look for points share. */
typedef struct hull_finder {
    const sc_prepared *volume;
    const uint8_t *show; /* as of sc_hull_points */
    bool interior;       /* some label shows its interior */
    int32_t (*ends)[2];  /* [size z][size y], of the team: first and last visible voxel of a row, or
                            -1; then, of rows that are no corner, -1 again at that end */
    uint32_t *counts;    /* [size z], of the team: corners of the layer */
    sc_vec3 *points;     /* the result, of the team */
} hull_finder;

/* @return whether the voxel of grid vertex (x, y, z), near an interface or not, is visible. */
static bool is_visible(const hull_finder *h, int x, int y, int z, bool near)
{
    const uint32_t id = sc_id_at_vertex(h->volume, x, y, z);

    return h->show[id] & (near ? SC_SHOW_BOUNDARY : SC_SHOW_INTERIOR);
}

/* The bricks of a row of bricks from low to high; none if low is above high. */
typedef struct brick_range {
    int low, high;
} brick_range;

/* @return the first and the last brick that can hold a visible vertex of the rows of grid layer @p
 * z which share the bricks of row @p y: most of a row of bricks is empty. */
static brick_range used_bricks(const hull_finder *h, int y, int z)
{
    const sc_prepared *v = h->volume;
    const uint64_t *row =
        v->boundary.masks + sc_brick_index(v->bricks, 0, sc_brick_of(y), sc_brick_of(z));
    const uint64_t layer = (uint64_t)SC_BRICK_LAYER_BITS << sc_brick_bit(0, 0, z);
    brick_range used = {0, v->bricks[0] - 1};

    while (!h->interior && used.low <= used.high && !(row[used.low] & layer))
        used.low++;
    while (!h->interior && used.low <= used.high && !(row[used.high] & layer))
        used.high--;
    return used;
}

/* @return the x of the first (or the last) visible vertex of row (y, z) of the grid; -1 if there is
 * none. @param used of used_bricks. */
static int row_end(const hull_finder *h, brick_range used, int y, int z, bool last)
{
    const sc_prepared *v = h->volume;
    const int shift = sc_brick_bit(0, y, z);
    const uint64_t *row =
        v->boundary.masks + sc_brick_index(v->bricks, 0, sc_brick_of(y), sc_brick_of(z));

    for (int i = 0; i <= used.high - used.low; i++) {
        const int brick = last ? used.high - i : used.low + i;
        const unsigned near = (unsigned)(row[brick] >> shift) & SC_BRICK_ROW_BITS;
        unsigned left = h->interior ? SC_BRICK_ROW_BITS : near;

        while (left) {
            const int bit = last ? 31 - __builtin_clz(left) : __builtin_ctz(left);

            if (is_visible(h, brick * SC_BRICK + bit, y, z, near >> bit & 1))
                return brick * SC_BRICK + bit;
            left &= ~(1u << bit);
        }
    }
    return -1;
}

/* Remove from the rows of a layer one end of those that are no corner of the convex hull: a chain
 * of corners is built row by row, from which a corner is taken again when the next shows that it
 * lies within. @param which 0: the first visible voxels, 1: the last. @param chain room for the
 * numbers of size y rows. @return how many are left. */
static uint32_t keep_corners(int32_t (*ends)[2], int rows, int which, int32_t *chain)
{
    const int64_t side = which ? -1 : 1;
    int count = 0;

    for (int y = 0; y < rows; y++) {
        if (ends[y][which] < 0)
            continue;
        while (count > 1) {
            const int a = chain[count - 2], b = chain[count - 1];
            const int64_t turn = (int64_t)(ends[b][which] - ends[a][which]) * (y - a) -
                                 (int64_t)(ends[y][which] - ends[a][which]) * (b - a);

            if (turn * side < 0)
                break;
            count--;
        }
        chain[count++] = y;
    }
    for (int y = 0, next = 0; y < rows; y++) {
        if (next < count && chain[next] == y)
            next++;
        else
            ends[y][which] = -1;
    }
    return (uint32_t)count;
}

/* Find the corners of layers [begin, end); an sc_range_fn on a hull_finder. */
static void find_corners(void *user, size_t begin, size_t end, int thread)
{
    const hull_finder *h = user;
    const int rows = h->volume->size[1];

    for (size_t z = begin; z < end; z++) {
        int32_t(*ends)[2] = h->ends + z * (size_t)rows;
        /* The room of the layer in the second half of the array. */
        brick_range used = {0, -1};
        int32_t *chain = h->ends[(size_t)h->volume->size[2] * (size_t)rows + z * (size_t)rows];

        for (int y = 0; y < rows; y++) {
            if (y == 0 || !((y + 1) & SC_BRICK_MASK))
                used = used_bricks(h, y + 1, (int)z + 1);
            ends[y][0] = row_end(h, used, y + 1, (int)z + 1, false);
            ends[y][1] = ends[y][0] < 0 ? -1 : row_end(h, used, y + 1, (int)z + 1, true);
        }
        h->counts[z] = keep_corners(ends, rows, 0, chain);
        h->counts[z] += keep_corners(ends, rows, 1, chain);
    }
}

/* Write the outer corners of the box of voxel (x, y, z) to @p out [OUTER]. @param side -1: those of
 * lower x; 1: of higher x. */
static void store_box(const sc_prepared *v, int x, int y, int z, int side, sc_vec3 *out)
{
    for (int i = 0; i < OUTER; i++)
        out[i] = sc_affine_point(&v->to_ras_mm,
                                 (sc_vec3){x + 0.5 * side, y + (i & 1) - 0.5, z + (i >> 1) - 0.5});
}

/* Write the corners of layers [begin, end) to their places; an sc_range_fn on a hull_finder. */
static void store_corners(void *user, size_t begin, size_t end, int thread)
{
    const hull_finder *h = user;
    const sc_prepared *v = h->volume;
    size_t at = 0;

    for (size_t z = 0; z < begin; z++)
        at += (size_t)h->counts[z] * OUTER;
    for (size_t z = begin; z < end; z++) {
        for (int y = 0; y < v->size[1]; y++) {
            const int32_t *ends = h->ends[z * (size_t)v->size[1] + (size_t)y];

            for (int i = 0; i < 2; i++) {
                if (ends[i] < 0)
                    continue;
                store_box(v, ends[i] - 1, y, (int)z, 2 * i - 1, h->points + at);
                at += OUTER;
            }
        }
    }
}

sc_status sc_hull_points(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                         const uint8_t *show, sc_vec3 **out, size_t *count)
{
    const size_t layers = (size_t)volume->size[2], rows = layers * (size_t)volume->size[1];
    hull_finder h = {.volume = volume, .show = show};
    void *block, *ends = NULL, *counts = NULL;
    size_t found = 0;
    sc_status status;

    for (int id = 1; id < volume->label_count; id++)
        h.interior = h.interior || show[id] & SC_SHOW_INTERIOR;
    SC_TRY(sc_team_alloc(ctx, team, 2 * rows, sizeof *h.ends, &ends));
    h.ends = ends;
    SC_TRY(sc_team_alloc(ctx, team, layers, sizeof *h.counts, &counts));
    h.counts = counts;
    sc_team_for(team, layers, 8, find_corners, &h);
    for (size_t z = 0; z < layers; z++)
        found += (size_t)h.counts[z] * OUTER;
    SC_TRY(sc_team_alloc(ctx, team, found, sizeof *h.points, &block));
    h.points = block;
    sc_team_for(team, layers, 64, store_corners, &h);
    *out = h.points;
    *count = found;
out:
    sc_team_free(team, ends);
    sc_team_free(team, counts);
    return status;
}
