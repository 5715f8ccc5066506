/* SPDX-License-Identifier: BSD-3-Clause */
/* Waves longer than voxels, as a segmentation has that was drawn on coarser voxels and brought to
 * finer ones, pass the box of cells and stay, since steps on cells do not reach that far. So the
 * fields are averaged over quarters of four voxels by a wide binomial, which takes such waves off.
 * It also moves what is curved: the mean difference over the border around is given back. This is
 * the answer where the border is nearly flat over the width of the filter, and as far as it stays
 * near the one of cells everywhere around: then both can have been drawn as these voxels. Where it
 * leaves that one there is detail, and cells decide; between the two the fields are blended.
 * Nothing is decided for a whole volume. */
#include "border.h"

enum {
    BLURS = 4,      /* passes of the binomial: a standard deviation of 5.7 voxels */
    MEAN_BLURS = 3, /* of those over which the mean difference is taken */
    CELLS = SC_CUBE_CELLS + 2,
    INNER = SC_CUBE_QUARTERS + 2,
    WIDE = SC_CUBE_QUARTERS + 4,
    BLURRED = SC_CUBE_QUARTERS + 2 * BLURS
};
_Static_assert((int)BLURS <= (int)SC_CUBE_QUARTERS, "a tile is filtered from those beside it");
/* What the filter makes of a plane's slope, since distances end at SC_FAR: the mean over all
 * directions, which differ by less than a hundredth. */
#define PLANE_SLOPE 0.551f
/* From this slope on, as a share of that of a plane, a border is flat enough that quarters count,
 * and that they decide. */
#define FLAT_FROM 0.7f
#define FLAT_ALL 0.9f
/* How near, in half drawn steps, quarters have to stay to decide, and from where on they do not
 * count. */
#define NEAR_ALL 0.6f
#define NEAR_FROM 1.1f
/* Cells within so many voxels of the border are compared; and moved. */
#define COMPARED 2.0f
#define MOVED 3.0f

typedef float quarters[SC_TILE_QUARTERS];

/* What the threads share: arrays by number of the tile. */
typedef struct smoother {
    const sc_borders *b;
    quarters *mean;       /* of the field at cells */
    quarters *wide;       /* that filtered; about the distance near the border */
    quarters *difference; /* the largest one to cells, in half drawn steps, in each quarter */
} smoother;

static inline float clip(float value, float low, float high)
{
    const float above = value < low ? low : value;

    return above > high ? high : above;
}

/* Take means of the cells of tiles [begin, end); an sc_range_fn on a smoother. */
static void average_tiles(void *user, size_t begin, size_t end, int thread)
{
    const smoother *s = user;

    (void)thread;
    for (size_t tile = begin; tile < end; tile++) {
        const float *value = s->b->value[tile];

        for (int i = 0; i < SC_TILE_QUARTERS && !s->b->dead[tile]; i++) {
            const float *low = value +
                               (2 * (i / 16) * SC_CUBE_CELLS + 2 * (i / 4 % 4)) * SC_CUBE_CELLS +
                               2 * (i % 4);
            float sum = 0;

            for (int n = 0; n < 8; n++)
                sum +=
                    clip(low[((n >> 2) * SC_CUBE_CELLS + (n >> 1 & 1)) * SC_CUBE_CELLS + (n & 1)],
                         -SC_FAR, SC_FAR);
            s->mean[tile][i] = 0.125f * sum;
        }
    }
}

/* Filter the means of tiles [begin, end); an sc_range_fn on a smoother. */
SC_WIDE_VECTORS static void filter_tiles(void *user, size_t begin, size_t end, int thread)
{
    static const float constants[SC_BESIDE_CONSTANTS] = {0, SC_FAR, -SC_FAR, 0};
    const smoother *s = user;

    (void)thread;
    for (size_t tile = begin; tile < end; tile++) {
        float region[BLURRED * BLURRED * BLURRED];

        if (s->b->dead[tile])
            continue;
        sc_read_tile_volumes(s->b, s->mean[0], tile, BLURS, constants, region);
        sc_extrapolate(s->b, tile, SC_CUBE_QUARTERS, BLURS, region);
        for (int i = 0; i < BLURRED * BLURRED * BLURRED; i++)
            region[i] = clip(region[i], -SC_FAR, SC_FAR);
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

    (void)thread;
    for (size_t tile = begin; tile < end; tile++) {
        float wide[WIDE * WIDE * WIDE], cells[SC_TILE_CELLS];

        if (b->dead[tile])
            continue;
        memset(b->missing[tile], 0, sizeof *b->missing);
        memset(b->area[tile], 0, sizeof *b->area);
        if (b->still[tile])
            continue;
        read_wide(s, tile, wide);
        at_cells(wide, cells);
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            const float is = is_compared(b, tile, i) ? 1 : 0;

            b->missing[tile][quarter_of(i)] += is * (b->value[tile][i] - cells[i]);
            b->area[tile][quarter_of(i)] += is;
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

    (void)thread;
    for (size_t tile = begin; tile < end; tile++) {
        float wide[WIDE * WIDE * WIDE], smooth[SC_TILE_CELLS];

        memset(s->difference[tile], 0, sizeof *s->difference);
        if (s->b->dead[tile] || s->b->still[tile])
            continue;
        read_wide(s, tile, wide);
        smooth_cells(s, tile, wide, smooth);
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            float *most = &s->difference[tile][quarter_of(i)];
            const float difference = fabsf(s->b->value[tile][i] - smooth[i]) /
                                     sc_wide_box(sc_strength_at(s->b, tile, i));

            if (is_compared(s->b, tile, i) && difference > *most)
                *most = difference;
        }
    }
}

/* @return in which share quarters decide by how flat the border is at element @p at of the region
 * of a filtered field. */
static inline float flat_share(const float *at)
{
    const float slopes[3] = {at[1] - at[-1], at[WIDE] - at[-WIDE],
                             at[WIDE * WIDE] - at[-WIDE * WIDE]};
    const float slope =
        sqrtf(slopes[0] * slopes[0] + slopes[1] * slopes[1] + slopes[2] * slopes[2]) * (1.0f / 8);

    return clip((slope - FLAT_FROM) * (1 / (FLAT_ALL - FLAT_FROM)), 0, 1);
}

/* Write the shares in which quarters decide, at a tile's quarters and one more on every side.
 * @return whether any is not 0. */
SC_ALWAYS_INLINE bool find_shares(const smoother *s, size_t tile, const float *wide, float *out)
{
    static const float none[SC_BESIDE_CONSTANTS] = {0, 0, 0, 0};
    float differences[WIDE * WIDE * WIDE], most = 0;

    for (int i = 0; i < INNER * INNER * INNER; i++) {
        const int x = i % INNER, y = i / INNER % INNER, z = i / (INNER * INNER);

        out[i] = flat_share(wide + ((z + 1) * WIDE + y + 1) * WIDE + x + 1);
        most = out[i] > most ? out[i] : most;
    }
    if (!(most > 0))
        return false;
    sc_read_tile_areas(s->b, s->difference[0], tile, 2, none, differences);
    for (int axis = 0, step = 1; axis < 3; axis++, step *= WIDE) { /* the largest of each three */
        for (int i = 0; i < WIDE * WIDE * WIDE - 2 * step; i++) {
            const float next = differences[i + step], last = differences[i + 2 * step];
            const float later = next > last ? next : last;

            differences[i] = differences[i] > later ? differences[i] : later;
        }
    }
    for (int i = 0; i < INNER * INNER * INNER; i++) {
        const int x = i % INNER, y = i / INNER % INNER, z = i / (INNER * INNER);
        const float largest = differences[(z * WIDE + y) * WIDE + x];

        out[i] *= clip((NEAR_FROM - largest) * (1 / (NEAR_FROM - NEAR_ALL)), 0, 1);
    }
    return true;
}

/* Replace the field at cells of tiles [begin, end) by the filtered one, in the shares of
 * find_shares; an sc_range_fn on a smoother. */
SC_WIDE_VECTORS static void blend_tiles(void *user, size_t begin, size_t end, int thread)
{
    const smoother *s = user;
    const sc_borders *b = s->b;

    (void)thread;
    for (size_t tile = begin; tile < end; tile++) {
        float wide[WIDE * WIDE * WIDE], smooth[SC_TILE_CELLS];
        float shares[INNER * INNER * INNER], share[CELLS * CELLS * CELLS];

        if (b->dead[tile] || b->still[tile])
            continue;
        read_wide(s, tile, wide);
        if (!find_shares(s, tile, wide, shares))
            continue;
        smooth_cells(s, tile, wide, smooth);
        sc_upsample(shares, INNER, share);
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            const int at = ((i / 64 + 1) * CELLS + i / 8 % 8 + 1) * CELLS + i % 8 + 1;
            const float data = b->data[tile][i], old = b->value[tile][i];
            const float box = b->box[tile][i] == SC_CELL_BOX
                                  ? sc_wide_box(sc_strength_at(b, tile, i))
                                  : b->box[tile][i];

            if (fabsf(data) < MOVED)
                b->value[tile][i] =
                    clip(old + share[at] * (smooth[i] - old), data - box, data + box);
        }
    }
}

sc_status sc_smooth_quarters(const sc_ctx *ctx, sc_borders *b)
{
    smoother s = {.b = b};
    quarters **const arrays[] = {&s.mean, &s.wide, &s.difference};
    static sc_range_fn *const loops[] = {average_tiles, filter_tiles, sum_tiles, compare_tiles,
                                         blend_tiles};
    sc_status status = SC_OK;

    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        void *block;

        SC_TRY(sc_team_alloc(ctx, b->p->team, b->tile_count + 1, sizeof **arrays[i], &block));
        *arrays[i] = block;
    }
    for (size_t i = 0; i < sizeof loops / sizeof loops[0]; i++)
        sc_team_for(b->p->team, b->tile_count, 64, loops[i], &s);
out:
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        sc_team_free(b->p->team, *arrays[i]);
    return status;
}
