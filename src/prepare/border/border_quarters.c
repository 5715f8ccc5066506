/* SPDX-License-Identifier: BSD-3-Clause */
/* Waves longer than voxels, as a segmentation has that was drawn on coarser voxels and brought to
 * finer ones, pass the box of cells and stay, since steps on cells do not reach that far. So the
 * fields are averaged over quarters of four voxels and filtered by a wide binomial, which takes
 * such waves off. It also moves what is curved: the mean difference over the border around is given
 * back. This is the answer where the border hardly bends over the width of the filter, and as far
 * as it stays near the one of cells everywhere around: then both can have been drawn as these
 * voxels. Elsewhere there is detail, and cells decide; between the two the fields are blended. In
 * the same shares normals come from the gradient of the filtered field: what is left of waves,
 * since the box binds or shares change, is seen in the light as rings and stripes before it is seen
 * anywhere else. Nothing is decided for a whole volume. */
#include "border/border.h"

enum {
    BLURS = 4,      /* passes of the binomial: a standard deviation of 5.7 voxels */
    MEAN_BLURS = 3, /* of those over which the mean difference is taken */
    CELLS = SC_CUBE_CELLS + 2,
    INNER = SC_CUBE_QUARTERS + 2,
    HALO = 2, /* quarters that a gradient reads */
    WIDE = SC_CUBE_QUARTERS + 2 * HALO,
    BLURRED = SC_CUBE_QUARTERS + 2 * BLURS
};
_Static_assert((int)BLURS <= (int)SC_CUBE_QUARTERS, "a tile is filtered from those beside it");
/* What the filter makes of a plane's slope, since distances end at SC_FAR: the mean over all
 * directions, which differ by at most a hundredth. */
#define PLANE_SLOPE 0.556f
/* How much a filtered field may differ, over the reach of distances, from that of a plane, as a
 * share of it, for it alone to decide, and from where on it does not count: a ball differs
 * so much that has a radius of 15 voxels, and of 12. */
#define BENT_ALL 0.65f
#define BENT_FROM 0.85f
/* How near, in half drawn steps, the filtered border has to stay to that of cells everywhere around
 * to be the same without waves, and from where on it lacks detail. */
#define NEAR_ALL 0.6f
#define NEAR_FROM 1.1f
/* Cells within so many voxels of the border are compared; and moved. */
#define COMPARED 2.0f
#define MOVED 3.0f

typedef float quarters[SC_TILE_QUARTERS];

/* What the threads share: arrays by number of the tile. */
typedef struct smoother {
    sc_borders *b;
    quarters *mean;       /* of the field at cells; then the share of the filtered one */
    quarters *wide;       /* that filtered; about the distance near the border */
    quarters *difference; /* the largest one to cells in each quarter, in half drawn steps */
} smoother;

/* Take means of the cells of tiles [begin, end), to s->mean; an sc_range_fn on a smoother. */
static void average_tiles(void *user, size_t begin, size_t end, int thread)
{
    const smoother *s = user;
    const sc_borders *b = s->b;

    for (size_t tile = begin; tile < end; tile++) {
        for (int i = 0; i < SC_TILE_QUARTERS; i++) {
            const float *low = b->value[tile] +
                               (2 * (i / 16) * SC_CUBE_CELLS + 2 * (i / 4 % 4)) * SC_CUBE_CELLS +
                               2 * (i % 4);
            float sum = 0;

            for (int n = 0; n < 8; n++)
                sum += sc_clip(
                    low[((n >> 2) * SC_CUBE_CELLS + (n >> 1 & 1)) * SC_CUBE_CELLS + (n & 1)],
                    -SC_FAR, SC_FAR);
            s->mean[tile][i] = 0.125f * sum;
        }
    }
}

/* Filter the means of tiles [begin, end), to s->wide; an sc_range_fn on a smoother. */
SC_WIDE_VECTORS static void filter_tiles(void *user, size_t begin, size_t end, int thread)
{
    static const float constants[SC_BESIDE_CONSTANTS] = {0, SC_FAR, -SC_FAR, 0};
    const smoother *s = user;
    const sc_borders *b = s->b;

    for (size_t tile = begin; tile < end; tile++) {
        float region[BLURRED * BLURRED * BLURRED];

        sc_read_tile_volumes(b, s->mean[0], tile, BLURS, constants, region);
        sc_extrapolate(b, tile, SC_CUBE_QUARTERS, BLURS, region);
        for (int i = 0; i < BLURRED * BLURRED * BLURRED; i++)
            region[i] = sc_clip(region[i], -SC_FAR, SC_FAR);
        for (int i = 0; i < BLURS; i++)
            sc_binomial(region, BLURRED - 2 * i, region);
        for (int i = 0; i < SC_TILE_QUARTERS; i++)
            s->wide[tile][i] = region[i] * (1 / PLANE_SLOPE);
    }
}

/* Read the filtered field around a tile: [WIDE] along each axis. */
SC_ALWAYS_INLINE void read_wide(const smoother *s, size_t tile, float *out)
{
    static const float constants[SC_BESIDE_CONSTANTS] = {0, SC_FAR / PLANE_SLOPE,
                                                         -SC_FAR / PLANE_SLOPE, 0};

    sc_read_tile_volumes(s->b, s->wide[0], tile, 2, constants, out);
    sc_extrapolate(s->b, tile, SC_CUBE_QUARTERS, 2, out);
}

/* Write a filtered field, [WIDE] along each axis, at the cells of its tile to @p out. */
SC_ALWAYS_INLINE void at_cells(const float *wide, float *out)
{
    float sharp[INNER * INNER * INNER], cells[CELLS * CELLS * CELLS];

    sc_sharpen(wide, WIDE, sharp);
    sc_upsample(sharp, INNER, cells);
    for (int k = 0; k < SC_CUBE_CELLS * SC_CUBE_CELLS; k++)
        memcpy(out + (size_t)(k * SC_CUBE_CELLS),
               cells + ((k / SC_CUBE_CELLS + 1) * CELLS + k % SC_CUBE_CELLS + 1) * CELLS + 1,
               SC_CUBE_CELLS * sizeof *out);
}

/* @return the quarter that holds a cell of a tile. */
static inline int quarter_of(int cell)
{
    return (cell / 128 * 4 + cell / 16 % 4) * 4 + cell / 2 % 4;
}

/* Are quarters and cells compared at a cell? */
static inline bool is_compared(const sc_borders *b, size_t tile, int cell)
{
    return fabsf(b->data[tile][cell]) < COMPARED && b->box[tile][cell] < SC_BOX_FREE;
}

/* Sum differences to quarters over the cells at the border, of tiles [begin, end), to b->missing,
 * and count these in b->area; an sc_range_fn on a smoother. */
SC_WIDE_VECTORS static void sum_tiles(void *user, size_t begin, size_t end, int thread)
{
    const smoother *s = user;
    const sc_borders *b = s->b;

    for (size_t tile = begin; tile < end; tile++) {
        float wide[WIDE * WIDE * WIDE], cells[SC_TILE_CELLS];

        memset(b->quarters.missing[tile], 0, sizeof *b->quarters.missing);
        memset(b->quarters.area[tile], 0, sizeof *b->quarters.area);
        if (b->still[tile])
            continue;
        read_wide(s, tile, wide);
        at_cells(wide, cells);
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            const float is = is_compared(b, tile, i) ? 1 : 0;

            b->quarters.missing[tile][quarter_of(i)] += is * (b->value[tile][i] - cells[i]);
            b->quarters.area[tile][quarter_of(i)] += is;
        }
    }
}

/* Write what quarters make of the field of a tile, at its cells, to @p out. */
SC_ALWAYS_INLINE void smooth_cells(const smoother *s, size_t tile, const float *wide, float *out)
{
    float moves[CELLS * CELLS * CELLS];

    at_cells(wide, out);
    sc_find_moves(s->b, tile, MEAN_BLURS, moves);
    for (int i = 0; i < SC_TILE_CELLS; i++)
        out[i] += moves[((i / 64 + 1) * CELLS + i / 8 % 8 + 1) * CELLS + i % 8 + 1];
}

/* Find the largest differences between quarters and cells at the border, of tiles [begin, end); an
 * sc_range_fn on a smoother. */
SC_WIDE_VECTORS static void compare_tiles(void *user, size_t begin, size_t end, int thread)
{
    const smoother *s = user;

    for (size_t tile = begin; tile < end; tile++) {
        float wide[WIDE * WIDE * WIDE], smooth[SC_TILE_CELLS];

        memset(s->difference[tile], 0, sizeof *s->difference);
        if (s->b->still[tile])
            continue;
        read_wide(s, tile, wide);
        smooth_cells(s, tile, wide, smooth);
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            float *most = &s->difference[tile][quarter_of(i)];
            const float difference = fabsf(s->b->value[tile][i] - smooth[i]) * (1 / SC_CELL_BOX);

            if (is_compared(s->b, tile, i) && difference > *most)
                *most = difference;
        }
    }
}

/* @return the length of the second derivatives, in 1 / voxel, at element @p at of a region. */
static inline float bending(const float *at)
{
    static const int steps[3] = {1, WIDE, WIDE * WIDE};
    float sum = 0;

    for (int i = 0; i < 3; i++) {
        const int step = steps[i];
        const float along = (at[step] - 2 * at[0] + at[-step]) * (1.0f / 16);

        sum += along * along;
        for (int k = 0; k < i; k++) {
            const float across = (at[step + steps[k]] - at[step - steps[k]] -
                                  (at[steps[k] - step] - at[-step - steps[k]])) *
                                 (1.0f / 64);

            sum += 2 * across * across;
        }
    }
    return sqrtf(sum);
}

/* Write the gradient at element @p at of a region of a filtered field to @p out, and to @p bent how
 * much the field differs there from that of a plane, as a share of it. Differences are of the
 * fourth order: those of the second are too small where the border is steep along an axis, which
 * turns normals by up to two degrees. */
SC_ALWAYS_INLINE void slope_at(const float *at, float out[3], float *bent)
{
    static const int steps[3] = {1, WIDE, WIDE * WIDE};
    float slope = 0;

    for (int i = 0; i < 3; i++) {
        const int step = steps[i];

        out[i] = (8 * (at[step] - at[-step]) - (at[2 * step] - at[-2 * step])) * (1.0f / 48);
        slope += out[i] * out[i];
    }
    slope = sqrtf(slope);
    *bent = slope > 0 ? fabsf(1 - slope) + SC_REACH * bending(at) / slope : BENT_FROM;
}

/* Write the largest difference in the quarters of a tile and those around each. */
SC_ALWAYS_INLINE void largest_around(const smoother *s, size_t tile, float out[SC_TILE_QUARTERS])
{
    static const float none[SC_BESIDE_CONSTANTS] = {0, 0, 0, 0};
    float region[INNER * INNER * INNER];

    sc_read_tile_areas(s->b, s->difference[0], tile, 1, none, region);
    /* axis by axis the largest of three neighbours */
    for (int axis = 0, step = 1; axis < 3; axis++, step *= INNER) {
        for (int i = 0; i < INNER * INNER * INNER - 2 * step; i++) {
            const float next = region[i + step], last = region[i + 2 * step];
            const float later = next > last ? next : last;

            region[i] = region[i] > later ? region[i] : later;
        }
    }
    for (int i = 0; i < SC_TILE_QUARTERS; i++)
        out[i] = region[(i / 16 * INNER + i / 4 % 4) * INNER + i % 4];
}

/* Find the gradients of the filtered field at quarters of tiles [begin, end); an sc_range_fn on a
 * smoother. */
SC_WIDE_VECTORS static void find_slopes(void *user, size_t begin, size_t end, int thread)
{
    const smoother *s = user;
    const sc_borders *b = s->b;

    for (size_t tile = begin; tile < end; tile++) {
        float wide[WIDE * WIDE * WIDE], differences[SC_TILE_QUARTERS];

        read_wide(s, tile, wide);
        largest_around(s, tile, differences);
        for (int i = 0; i < SC_TILE_QUARTERS; i++) {
            const int x = i % 4, y = i / 4 % 4, z = i / 16;
            const int at = ((z + HALO) * WIDE + y + HALO) * WIDE + x + HALO;
            const float strength =
                sc_strength_at(b, tile, (2 * z * SC_CUBE_CELLS + 2 * y) * SC_CUBE_CELLS + 2 * x);
            const float more = strength > 1 ? strength : 1;
            sc_wide_slope *out = &b->quarters.wide[tile][i];
            float bent;

            slope_at(wide + at, out->slope, &bent);
            out->share =
                sc_cell_share(strength) *
                sc_clip((BENT_FROM - bent) * (1 / (BENT_FROM - BENT_ALL)), 0, 1) *
                sc_clip((NEAR_FROM - differences[i] / more) * (1 / (NEAR_FROM - NEAR_ALL)), 0, 1);
            s->mean[tile][i] = out->share;
        }
    }
}

/* Move the field at cells of tiles [begin, end) to the filtered one, in the shares of its
 * gradients; an sc_range_fn on a smoother. */
SC_WIDE_VECTORS static void blend_tiles(void *user, size_t begin, size_t end, int thread)
{
    static const float none[SC_BESIDE_CONSTANTS] = {0, 0, 0, 0};
    const smoother *s = user;
    const sc_borders *b = s->b;

    for (size_t tile = begin; tile < end; tile++) {
        float wide[WIDE * WIDE * WIDE], smooth[SC_TILE_CELLS], most = 0;
        float shares[INNER * INNER * INNER], share[CELLS * CELLS * CELLS];

        if (b->still[tile])
            continue;
        sc_read_tile_areas(b, s->mean[0], tile, 1, none, shares);
        for (int i = 0; i < INNER * INNER * INNER; i++)
            most = shares[i] > most ? shares[i] : most;
        if (!(most > 0))
            continue;
        read_wide(s, tile, wide);
        smooth_cells(s, tile, wide, smooth);
        sc_upsample(shares, INNER, share);
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            const int at = ((i / 64 + 1) * CELLS + i / 8 % 8 + 1) * CELLS + i % 8 + 1;
            const float data = b->data[tile][i], old = b->value[tile][i], box = b->box[tile][i];

            if (fabsf(data) < MOVED)
                b->value[tile][i] =
                    sc_clip(old + share[at] * (smooth[i] - old), data - box, data + box);
        }
    }
}

sc_status sc_smooth_quarters(const sc_ctx *ctx, sc_borders *b)
{
    smoother s = {.b = b};
    quarters **const arrays[] = {&s.mean, &s.wide, &s.difference};
    static sc_range_fn *const loops[] = {average_tiles, filter_tiles, sum_tiles,
                                         compare_tiles, find_slopes,  blend_tiles};
    void *block;
    sc_status status;

    SC_TRY(sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof *b->quarters.wide, &block));
    b->quarters.wide = block;
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        SC_TRY(sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof **arrays[i], &block));
        *arrays[i] = block;
    }
    for (size_t i = 0; i < sizeof loops / sizeof loops[0]; i++)
        sc_team_for(b->p->team, b->tiles.count, 64, loops[i], &s);
out:
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        sc_team_free(b->p->team, *arrays[i]);
    return status;
}
