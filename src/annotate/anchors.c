/* SPDX-License-Identifier: BSD-3-Clause */
/* The points to which names are tied: deep inside their tissue, and far from each other. Distances
 * to the border are found on a coarse grid, by chamfer distances (Borgefors 1986, "Distance
 * transformations in digital images"): two passes over the grid. */
#include "internal.h"

#include <math.h>

enum {
    CELLS = 56,          /* of the coarse grid along the longest edge of a tissue's bounding box */
    CELLS_MOST = 1 << 22 /* of a grid in all: 16 MiB */
};
#define DEEP 0.4   /* share of the largest depth that the other points have at least */
#define APART 0.12 /* share of the diagonal of the box that points lie apart at least */

/* The coarse grid of a tissue, with a frame of one empty cell on each side. */
typedef struct grid {
    const sc_prepared *volume;
    int id, low[3], high[3]; /* the box in voxels, inclusive */
    int stride[3], size[3];  /* voxels from cell to cell; cells, the frame included */
    double step_mm[3];
    float *depth_mm; /* [size z][size y][size x], 0 outside of the tissue; owned */
} grid;

static size_t cell_index(const grid *g, int x, int y, int z)
{
    return ((size_t)z * (size_t)g->size[1] + (size_t)y) * (size_t)g->size[0] + (size_t)x;
}

/* @return the voxel along an axis that stands for cell @p at of the grid, which is not of the
 * frame. */
static int voxel_of(const grid *g, int axis, int at)
{
    const int voxel = g->low[axis] + (at - 1) * g->stride[axis] + g->stride[axis] / 2;

    return voxel < g->high[axis] ? voxel : g->high[axis];
}

/* Begin the grid of a tissue, with cells of @p step_mm, but at least of a voxel. */
static void set_grid(grid *g, double step_mm)
{
    for (int i = 0; i < 3; i++) {
        const double voxel_mm = sc_vec3_length(sc_affine_column(&g->volume->to_ras_mm, i));
        const int extent = g->high[i] - g->low[i] + 1;
        const double stride = floor(step_mm / voxel_mm);

        g->stride[i] = stride < 1 ? 1 : stride > extent ? extent : (int)stride;
        g->step_mm[i] = g->stride[i] * voxel_mm;
        g->size[i] = (extent + g->stride[i] - 1) / g->stride[i] + 2;
    }
}

/* Set the depth of all cells of the tissue to a large one. @return how many there are. */
static size_t fill_grid(const sc_ctx *ctx, grid *g, sc_status *status)
{
    size_t count = 0;

    *status = SC_ZALLOC(ctx, cell_index(g, 0, 0, g->size[2]), &g->depth_mm);
    if (*status != SC_OK)
        return 0;
    for (int z = 1; z < g->size[2] - 1; z++) {
        for (int y = 1; y < g->size[1] - 1; y++) {
            for (int x = 1; x < g->size[0] - 1; x++) {
                const uint32_t id = sc_id_at_vertex(g->volume, voxel_of(g, 0, x) + 1,
                                                    voxel_of(g, 1, y) + 1, voxel_of(g, 2, z) + 1);

                if (id != (uint32_t)g->id)
                    continue;
                g->depth_mm[cell_index(g, x, y, z)] = HUGE_VALF;
                count++;
            }
        }
    }
    return count;
}

/* One pass of the chamfer distance over all cells but the frame: forwards with @p sign 1, backwards
 * with -1. */
static void pass(const grid *g, int sign)
{
    const int inner[3] = {g->size[0] - 2, g->size[1] - 2, g->size[2] - 2};
    const int cells = inner[0] * inner[1] * inner[2]; /* at most CELLS_MOST */
    ptrdiff_t offset[13];
    float length_mm[13];
    int count = 0;

    for (int n = 0; n < 13; n++) { /* the neighbours that come before in the order of the array */
        const int d[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};

        offset[count] =
            sign * ((d[2] * (ptrdiff_t)g->size[1] + d[1]) * (ptrdiff_t)g->size[0] + d[0]);
        length_mm[count++] = (float)sc_vec3_length(
            (sc_vec3){d[0] * g->step_mm[0], d[1] * g->step_mm[1], d[2] * g->step_mm[2]});
    }
    for (int i = 0; i < cells; i++) {
        const int at = sign > 0 ? i : cells - 1 - i;
        float *cell = &g->depth_mm[cell_index(g, at % inner[0] + 1, at / inner[0] % inner[1] + 1,
                                              at / inner[0] / inner[1] + 1)];

        if (*cell <= 0)
            continue;
        for (int n = 0; n < count; n++) {
            const float over = cell[offset[n]] + length_mm[n];

            *cell = over < *cell ? over : *cell;
        }
    }
}

/* @return the squared distance in mm of a cell to the nearest of @p count points. */
static double nearest_mm2(const grid *g, const int at[3], int points[][3], int count)
{
    double least = HUGE_VAL;

    for (int p = 0; p < count; p++) {
        double sum = 0;

        for (int i = 0; i < 3; i++) {
            const double d = g->step_mm[i] * (at[i] - points[p][i]);

            sum += d * d;
        }
        least = fmin(least, sum);
    }
    return least;
}

/* Find the next point: the deepest cell, or if there are points, that which lies farthest from all
 * of them, of cells that are deep enough. @return whether there is one. */
static bool find_next(const grid *g, float deepest_mm, int points[][3], int count, int out[3])
{
    double best = 0, diagonal_mm2 = 0;

    for (int i = 0; i < 3; i++)
        diagonal_mm2 += g->step_mm[i] * g->step_mm[i] * g->size[i] * g->size[i];
    for (int z = 1; z < g->size[2] - 1; z++) {
        for (int y = 1; y < g->size[1] - 1; y++) {
            for (int x = 1; x < g->size[0] - 1; x++) {
                const int at[3] = {x, y, z};
                const float depth_mm = g->depth_mm[cell_index(g, x, y, z)];
                double value = depth_mm;

                if (depth_mm <= 0 || (count && (double)depth_mm < DEEP * (double)deepest_mm))
                    continue;
                if (count)
                    value = nearest_mm2(g, at, points, count);
                if (value <= best)
                    continue;
                best = value;
                for (int i = 0; i < 3; i++)
                    out[i] = at[i];
            }
        }
    }
    return count ? best > APART * APART * diagonal_mm2 : best > 0;
}

/* Tie the name to the first voxel of a tissue whose few voxels lie far apart. */
static void take_first_voxel(const grid *g, sc_anchors *out)
{
    int at[3] = {g->low[0], g->low[1], g->low[2]};

    while (at[2] <= g->high[2] &&
           sc_id_at_vertex(g->volume, at[0] + 1, at[1] + 1, at[2] + 1) != (uint32_t)g->id) {
        at[0]++;
        for (int i = 0; i < 2 && at[i] > g->high[i]; i++) {
            at[i] = g->low[i];
            at[i + 1]++;
        }
    }
    if (at[2] <= g->high[2]) {
        memcpy(out->voxel[0], at, sizeof at);
        out->count = 1;
    }
}

sc_status sc_find_anchors(const sc_ctx *ctx, const sc_prepared *volume, int id, sc_anchors *out)
{
    const sc_label_stats *stats = &volume->stats[id];
    grid g = {.volume = volume, .id = id};
    int points[SC_ANCHORS_MAX][3];
    float deepest_mm = 0;
    double longest_mm = 0;
    sc_status status;

    *out = (sc_anchors){0};
    for (int i = 0; i < 3; i++) {
        g.low[i] = stats->low[i];
        g.high[i] = stats->high[i];
        longest_mm = fmax(longest_mm, (g.high[i] - g.low[i] + 1) *
                                          sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i)));
    }
    /* A thin tissue may fall between the cells: then they are made smaller. */
    for (double step_mm = longest_mm / CELLS;; step_mm /= 2) {
        set_grid(&g, step_mm);
        if ((double)g.size[0] * g.size[1] * g.size[2] > CELLS_MOST) {
            take_first_voxel(&g, out);
            return SC_OK;
        }
        if (fill_grid(ctx, &g, &status) || status != SC_OK ||
            (g.stride[0] == 1 && g.stride[1] == 1 && g.stride[2] == 1))
            break;
        sc_free(g.depth_mm);
        g.depth_mm = NULL;
    }
    if (status != SC_OK)
        return status;
    pass(&g, 1);
    pass(&g, -1);
    while (out->count < SC_ANCHORS_MAX &&
           find_next(&g, deepest_mm, points, out->count, points[out->count])) {
        const int *at = points[out->count];

        if (!out->count)
            deepest_mm = g.depth_mm[cell_index(&g, at[0], at[1], at[2])];
        for (int i = 0; i < 3; i++)
            out->voxel[out->count][i] = voxel_of(&g, i, at[i]);
        out->count++;
    }
    sc_free(g.depth_mm);
    return SC_OK;
}
