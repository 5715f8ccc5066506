/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissue one voxel thick stays together. A field is interpolated between the corners of cells, so
 * that voxels of a line or of a sheet that touch only along an edge or in a corner would come
 * apart, and what lies behind a sheet would show through.
 *
 * A voxel is thin if none of the cells around it is all of its side. Where the voxels of the
 * positive side at the corners of a cell are thin and do not touch by faces, and none of the others
 * is thin, the cell is a link: the
 * field is SIDE there at all corners of the other side, at most, and so many times that at those of
 * the positive side that they are joined: by 1.3 times along edges, which also makes the two sides
 * of a closed sheet own regions that do not touch, and by 3 times through a corner. Both follow
 * from trilinear interpolation: at the middle of a face two corners have to outweigh two, and at
 * the middle of a cell two have to outweigh six. Where cells alone make the field nothing is
 * linked: voxels that stick out there are noise. */
#include "border/border.h"

enum {
    HALO = 2,
    EDGE = SC_CUBE + 2 * HALO, /* of the sides that are read */
    CELLS = SC_CUBE + 1,       /* with a corner in the tile */
    PATTERNS = 256
};
/* What the field is at most on the other side of a link, in voxels; so that three times as much
 * fits a record. */
#define SIDE 0.43f
#define BY_EDGE 1.3f
#define BY_CORNER 3.0f

/* What the threads share. */
typedef struct linker {
    const sc_borders *b;
    float least[PATTERNS]; /* the least field, in voxels, at the corners of the positive side of a
                              cell, by which these are; 0 if the cell is no link */
} linker;

/* @return the corners, as bits, that are joined with the lowest of @p corners by steps along at
 * most
 * @p axes axes at a time. */
static unsigned joined_corners(unsigned corners, int axes)
{
    unsigned joined = corners & -corners, before = 0;

    while (joined != before) {
        before = joined;
        for (int i = 0; i < 8; i++) {
            for (int k = 0; k < 8; k++) {
                const int apart = (i ^ k) & 1, steps = apart + ((i ^ k) >> 1 & 1) + ((i ^ k) >> 2);

                if (joined >> i & 1 && corners >> k & 1 && steps <= axes)
                    joined |= 1u << k;
            }
        }
    }
    return joined;
}

/* Fill l->least. */
static void find_patterns(linker *l)
{
    for (unsigned corners = 0; corners < PATTERNS; corners++)
        l->least[corners] = joined_corners(corners, 1) == corners   ? 0
                            : joined_corners(corners, 2) == corners ? BY_EDGE * SIDE
                                                                    : BY_CORNER * SIDE;
}

/* Find which voxels of the rows of a region are on the positive (@p sign 1) or negative side (-1),
 * to
 * @p sides, and which of them are thin, to @p thin, as bits. @return whether any is thin. */
SC_ALWAYS_INLINE bool find_thin(const int8_t *squares, int sign, uint32_t sides[EDGE][EDGE],
                                uint32_t thin[EDGE][EDGE])
{
    uint32_t full[EDGE][EDGE], any = 0;

    for (int k = 0; k < EDGE * EDGE; k++) {
        uint32_t bits = 0;

        for (int x = 0; x < EDGE; x++)
            bits |= (uint32_t)(squares[k * EDGE + x] * sign > 0) << x;
        sides[k / EDGE][k % EDGE] = bits;
    }
    memset(full, 0, sizeof full);
    memset(thin, 0, EDGE * sizeof *thin);
    for (int z = 0; z + 1 < EDGE; z++) {
        for (int y = 0; y + 1 < EDGE; y++) {
            const uint32_t both =
                sides[z][y] & sides[z][y + 1] & sides[z + 1][y] & sides[z + 1][y + 1];

            full[z][y] = both & both >> 1;
        }
    }
    for (int z = 1; z + 1 < EDGE; z++) {
        for (int y = 1; y + 1 < EDGE; y++) {
            const uint32_t in = full[z][y] | full[z][y - 1] | full[z - 1][y] | full[z - 1][y - 1];

            thin[z][y] = sides[z][y] & ~(in | in << 1);
            any |= thin[z][y];
        }
    }
    return any;
}

/* @return the eight corners of the cell whose lowest corner is (x, y, z), as bits. */
static unsigned corners_of(const uint32_t rows[EDGE][EDGE], int x, int y, int z)
{
    return (rows[z][y] >> x & 3) | (rows[z][y + 1] >> x & 3) << 2 | (rows[z + 1][y] >> x & 3) << 4 |
           (rows[z + 1][y + 1] >> x & 3) << 6;
}

/* @return @p fine raised to @p least where it is less, in the share @p share. */
static int16_t raised(int16_t fine, float least, float share)
{
    const float value = sc_of_fine(fine);

    return value < least ? sc_to_fine(value + share * (least - value)) : fine;
}

/* Raise or lower the corners, as far as they lie in the tile, of the link whose lowest corner is
 * (x, y, z) in the region. */
static void set_link(const sc_borders *b, size_t tile, unsigned corners, float least,
                     const int at[3])
{
    for (int i = 0; i < 8; i++) {
        const int x = at[0] + (i & 1) - HALO, y = at[1] + (i >> 1 & 1) - HALO,
                  z = at[2] + (i >> 2) - HALO;
        int16_t *fine;
        float share;

        if (x < 0 || y < 0 || z < 0 || x >= SC_CUBE || y >= SC_CUBE || z >= SC_CUBE)
            continue;
        fine = &b->fine[tile][(z * SC_CUBE + y) * SC_CUBE + x];
        share = 1 - b->coarse[tile][(z / 2 * SC_CUBE_CELLS + y / 2) * SC_CUBE_CELLS + x / 2];
        if (corners >> i & 1)
            *fine = raised(*fine, least, share);
        else if (b->squares[tile][(z * SC_CUBE + y) * SC_CUBE + x] < 0)
            *fine = raised(*fine, -SIDE, share);
    }
}

/* Keep the links of tiles [begin, end); an sc_range_fn on a linker. */
SC_WIDE_VECTORS static void link_tiles(void *user, size_t begin, size_t end, int thread)
{
    static const int8_t none[SC_BESIDE_CONSTANTS] = {0, SC_REACH_SQUARED, -SC_REACH_SQUARED, 0};
    const linker *l = user;
    const sc_borders *b = l->b;

    for (size_t tile = begin; tile < end; tile++) {
        int8_t squares[EDGE * EDGE * EDGE];
        uint32_t sides[EDGE][EDGE], thin[EDGE][EDGE];
        uint32_t others[EDGE][EDGE], thin_others[EDGE][EDGE];

        if (sc_is_coarse(b, tile))
            continue;
        sc_read_tile_squares(b, b->squares[0], tile, HALO, none, squares);
        if (!find_thin(squares, 1, sides, thin))
            continue;
        (void)find_thin(squares, -1, others, thin_others);
        for (int k = 0; k < CELLS * CELLS; k++) {
            const int y = k % CELLS + HALO - 1, z = k / CELLS + HALO - 1;
            const uint32_t row = thin[z][y] | thin[z][y + 1] | thin[z + 1][y] | thin[z + 1][y + 1];

            for (int x = HALO - 1; x < HALO + SC_CUBE && row >> x; x++) {
                const unsigned corners = corners_of((const uint32_t(*)[EDGE])sides, x, y, z);

                if (l->least[corners] > 0 &&
                    corners_of((const uint32_t(*)[EDGE])thin, x, y, z) == corners &&
                    !corners_of((const uint32_t(*)[EDGE])thin_others, x, y, z))
                    set_link(b, tile, corners, l->least[corners], (const int[3]){x, y, z});
            }
        }
    }
}

void sc_keep_links(const sc_ctx *ctx, sc_borders *b)
{
    linker l = {.b = b};

    find_patterns(&l);
    sc_team_stage_for(ctx, SC_WORTH_LINKS, b->p->team, b->tiles.count, 64, link_tiles, &l);
}
