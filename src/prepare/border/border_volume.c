/* SPDX-License-Identifier: BSD-3-Clause */
/* Fields keep the volumes of the voxels: smoothing takes from what bulges. What is missing of the
 * positive side is counted at voxels, gathered in quarters of four voxels along each axis, and
 * blurred, as is the area of the border; their quotient is how far the border has to be moved,
 * within the box. Without this a tube of radius 1.5 would lose 40 % of its volume. */
#include "border/border.h"

enum {
    COARSE_BLURS = 2, /* passes of the binomial over quarters, for the fields of cells */
    FINE_BLURS = 1,   /* for those of voxels, whose box is half as wide */
    COARSE_TIMES = 2,
    FINE_TIMES = 2,
    CELLS = SC_CUBE_CELLS + 2,
    AROUND = SC_CUBE_CELLS + 4,
    VOXELS = SC_CUBE + 2,
    ROWS = SC_CUBE * VOXELS /* numbers of a layer of rows with one more at either end */
};

/* @return @p share limited to -1/2 and 1/2: a voxel is at least empty and at most full. */
static inline float limited(float share)
{
    return sc_clip(share, -0.5f, 0.5f);
}

typedef float four_floats __attribute__((vector_size(4 * sizeof(float))));

/* @return the sums of the pairs of neighbours in a and c. */
static inline four_floats add_pairs(four_floats a, four_floats c)
{
    return SC_SHUFFLE(a, c, 0, 2, 4, 6) + SC_SHUFFLE(a, c, 1, 3, 5, 7);
}

/* Add the sums of each four of a row to the quarters of the row. */
static inline void add_fours(const float row[SC_CUBE], float out[SC_CUBE_QUARTERS])
{
    four_floats fours[SC_CUBE_QUARTERS], sum;

    memcpy(fours, row, sizeof fours);
    memcpy(&sum, out, sizeof sum);
    sum += add_pairs(add_pairs(fours[0], fours[1]), add_pairs(fours[2], fours[3]));
    memcpy(out, &sum, sizeof sum);
}

/* Add what is missing in a row of voxels, and the area, to the quarters of the row. Written so that
 * the opposite field gets the opposite numbers.
 * @param squares of the voxels. @param share of each voxel on the positive side, less one half. */
static inline void add_row(const int8_t *squares, const float *share, float *missing, float *area)
{
    float less[SC_CUBE], part[SC_CUBE];

    for (int x = 0; x < SC_CUBE; x++) {
        const float all = limited(share[x]);

        less[x] = squares[x] > 0 ? 0.5f - all : squares[x] < 0 ? -0.5f - all : 0;
        part[x] = squares[x] != 0 && share[x] > -0.5f && share[x] < 0.5f ? 1 : 0;
    }
    add_fours(less, missing);
    add_fours(part, area);
}

/* May any of @p count voxels be less than full, or more than empty? Not where all are farther from
 * the border than the field may be off. */
static inline bool is_near(const int8_t *squares, int count)
{
    int8_t near = 0;

    for (int x = 0; x < count; x++)
        near |= (int8_t)(squares[x] >= -4 && squares[x] <= 4);
    return near;
}

/* @return the first of the quarters of row @p row (y + SC_CUBE z) of a tile. */
static inline int quarters_of(int row)
{
    return (row / SC_CUBE / 4 * SC_CUBE_QUARTERS + row % SC_CUBE / 4) * SC_CUBE_QUARTERS;
}

/* Count what is missing in the fields of cells of tiles [begin, end); an sc_range_fn on
 * sc_borders. */
SC_WIDE_VECTORS static void count_cells(void *user, size_t begin, size_t end, int thread)
{
    const sc_borders *b = user;

    for (size_t tile = begin; tile < end; tile++) {
        float cells[AROUND * AROUND * AROUND], sharp[CELLS * CELLS * CELLS];
        float voxels[VOXELS * VOXELS * VOXELS];

        memset(b->quarters.missing[tile], 0, sizeof *b->quarters.missing);
        memset(b->quarters.area[tile], 0, sizeof *b->quarters.area);
        if (!is_near(b->squares[tile], SC_TILE_VOXELS))
            continue;
        sc_read_cells(b, (const float(*)[SC_TILE_CELLS])b->value, tile, 2, cells);
        sc_sharpen(cells, AROUND, sharp);
        sc_upsample(sharp, CELLS, voxels);
        for (int row = 0; row < SC_CUBE * SC_CUBE; row++) {
            const float *from =
                voxels + ((row / SC_CUBE + 1) * VOXELS + row % SC_CUBE + 1) * VOXELS + 1;

            if (is_near(b->squares[tile] + row * SC_CUBE, SC_CUBE))
                add_row(b->squares[tile] + row * SC_CUBE, from,
                        b->quarters.missing[tile] + quarters_of(row),
                        b->quarters.area[tile] + quarters_of(row));
        }
    }
}

/* Move the borders of the fields of cells of tiles [begin, end); an sc_range_fn on sc_borders. */
SC_WIDE_VECTORS static void move_cells(void *user, size_t begin, size_t end, int thread)
{
    const sc_borders *b = user;

    for (size_t tile = begin; tile < end; tile++) {
        float moves[CELLS * CELLS * CELLS];

        if (b->still[tile])
            continue;
        sc_find_moves(b, tile, COARSE_BLURS, moves);
        for (int k = 0; k < SC_CUBE_CELLS * SC_CUBE_CELLS; k++) {
            const float *by =
                moves + ((k / SC_CUBE_CELLS + 1) * CELLS + k % SC_CUBE_CELLS + 1) * CELLS + 1;
            const float *data = b->data[tile] + k * SC_CUBE_CELLS;
            const float *box = b->box[tile] + k * SC_CUBE_CELLS;
            float *value = b->value[tile] + k * SC_CUBE_CELLS, to[SC_CUBE_CELLS];

            for (int x = 0; x < SC_CUBE_CELLS; x++)
                to[x] = sc_clip(value[x] + by[x], data[x] - box[x], data[x] + box[x]);
            memcpy(value, to, sizeof to);
        }
    }
}

/* A layer of rows, a quarter of the way to the row before, and to the next one. */
typedef float between_rows[2][ROWS];

/* Write a layer of a region between its rows to @p out. @param at as of find_shares. */
SC_ALWAYS_INLINE void find_between(const float *at, between_rows out)
{
    for (int i = 0; i < ROWS; i++) {
        out[0][i] = 0.75f * at[i] + 0.25f * at[i - VOXELS];
        out[1][i] = 0.75f * at[i] + 0.25f * at[i + VOXELS];
    }
}

/* Write to @p out the share, less one half, of each voxel of a layer that is on the positive side,
 * by the field at eight points in it. Rows follow each other, two numbers longer than the tile's,
 * which are of no use, so that all are found side by side.
 * @param layers of the layer in the middle and those on both sides: find_between of the voxel
 * before the first one in a region of VOXELS voxels along each axis. */
SC_ALWAYS_INLINE void find_shares(between_rows *const layers[3], float out[ROWS])
{
    for (int i = 0; i < ROWS; i++)
        out[i] = 0;
    for (int corner = 0; corner < 4; corner++) {
        const float *middle = (*layers[1])[corner & 1];
        const float *beside = (*layers[corner & 2])[corner & 1];
        float line[ROWS];

        for (int i = 0; i < ROWS; i++)
            line[i] = 0.75f * middle[i] + 0.25f * beside[i];
        for (int i = 0; i < ROWS - 2; i++) /* the two points along x */
            out[i] += limited(1.5f * line[i + 1] + 0.5f * line[i]) +
                      limited(1.5f * line[i + 1] + 0.5f * line[i + 2]);
    }
    for (int i = 0; i < ROWS; i++)
        out[i] *= 0.125f;
}

/* Count what is missing in the fields of voxels of tiles [begin, end); an sc_range_fn on
 * sc_borders. */
SC_WIDE_VECTORS static void count_voxels(void *user, size_t begin, size_t end, int thread)
{
    const sc_borders *b = user;

    for (size_t tile = begin; tile < end; tile++) {
        const int8_t *squares = b->squares[tile];
        float region[VOXELS * VOXELS * VOXELS], shares[ROWS];
        between_rows between[3]; /* of layers z - 1 to z + 1, by their number */

        memset(b->quarters.missing[tile], 0, sizeof *b->quarters.missing);
        memset(b->quarters.area[tile], 0, sizeof *b->quarters.area);
        if (sc_is_coarse(b, tile) || !is_near(squares, SC_TILE_VOXELS))
            continue;
        sc_read_voxels(b, tile, 1, region);
        for (int z = -2; z < SC_CUBE; z++) {
            const int8_t *layer = squares + z * SC_CUBE * SC_CUBE;

            find_between(region + ((z + 2) * VOXELS + 1) * VOXELS, between[(z + 2) % 3]);
            if (z < 0 || !is_near(layer, SC_CUBE * SC_CUBE))
                continue;
            find_shares(
                (between_rows *[3]){&between[z % 3], &between[(z + 1) % 3], &between[(z + 2) % 3]},
                shares);
            for (int y = 0; y < SC_CUBE; y++) {
                const int at = quarters_of(z * SC_CUBE + y);

                if (is_near(layer + y * SC_CUBE, SC_CUBE))
                    add_row(layer + y * SC_CUBE, shares + y * VOXELS,
                            b->quarters.missing[tile] + at, b->quarters.area[tile] + at);
            }
        }
    }
}

/* Move the field of a row of voxels, in the cells from @p cell on, by @p by, within the box. */
SC_ALWAYS_INLINE void move_row(const sc_borders *b, size_t tile, int cell, const int8_t *squares,
                               const float *by, int16_t *fine)
{
    float share[SC_CUBE], half[SC_CUBE], middle[SC_CUBE], moved[SC_CUBE];

    for (int x = 0; x < SC_CUBE; x += 2) {
        const float strength = sc_strength_at(b, tile, cell + x / 2);
        const float narrow = SC_VOXEL_BOX * sc_voxel_share(strength);

        share[x] = share[x + 1] = b->coarse[tile][cell + x / 2];
        half[x] = half[x + 1] = narrow + share[x] * (SC_CELL_BOX - narrow);
    }
    sc_distances_of(squares, SC_CUBE, middle);
    for (int x = 0; x < SC_CUBE; x++) {
        const float width = squares[x] ? half[x] : SC_BOX_FREE;
        const float to = sc_of_fine(fine[x]) + (1 - share[x]) * by[x];

        moved[x] = sc_clip(to, middle[x] - width, middle[x] + width);
    }
    for (int x = 0; x < SC_CUBE; x++)
        fine[x] = sc_to_fine(moved[x]);
}

/* Move the borders of the fields of voxels of tiles [begin, end) where cells alone do not make
 * them; an sc_range_fn on sc_borders. */
SC_WIDE_VECTORS static void move_voxels(void *user, size_t begin, size_t end, int thread)
{
    const sc_borders *b = user;

    for (size_t tile = begin; tile < end; tile++) {
        float moves[CELLS * CELLS * CELLS], voxels[VOXELS * VOXELS * VOXELS];

        if (sc_is_coarse(b, tile) || !is_near(b->squares[tile], SC_TILE_VOXELS))
            continue;
        sc_find_moves(b, tile, FINE_BLURS, moves);
        sc_upsample(moves, CELLS, voxels);
        for (int row = 0; row < SC_CUBE * SC_CUBE; row++) {
            const int y = row % SC_CUBE, z = row / SC_CUBE;
            const float *by = voxels + ((z + 1) * VOXELS + y + 1) * VOXELS + 1;
            const int8_t *squares = b->squares[tile] + row * SC_CUBE;
            int16_t *fine = b->fine[tile] + row * SC_CUBE;

            if (is_near(squares, SC_CUBE))
                move_row(b, tile, (z / 2 * SC_CUBE_CELLS + y / 2) * SC_CUBE_CELLS, squares, by,
                         fine);
        }
    }
}

sc_status sc_keep_volume_of_cells(const sc_ctx *ctx, sc_borders *b)
{
    void *block;

    SC_PASS(
        sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof *b->quarters.missing, &block));
    b->quarters.missing = block;
    SC_PASS(sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof *b->quarters.area, &block));
    b->quarters.area = block;
    for (int i = 0; i < COARSE_TIMES; i++) {
        sc_team_stage_for(ctx, SC_WORTH_VOLUME / 8, b->p->team, b->tiles.count, 64, count_cells, b);
        sc_team_stage_for(ctx, SC_WORTH_VOLUME / 8, b->p->team, b->tiles.count, 64, move_cells, b);
    }
    return SC_OK;
}

void sc_keep_volume_of_voxels(const sc_ctx *ctx, sc_borders *b)
{
    for (int i = 0; i < FINE_TIMES; i++) {
        sc_team_stage_for(ctx, SC_WORTH_VOLUME / 8, b->p->team, b->tiles.count, 64, count_voxels,
                          b);
        sc_team_stage_for(ctx, SC_WORTH_VOLUME / 8, b->p->team, b->tiles.count, 64, move_voxels, b);
    }
}
