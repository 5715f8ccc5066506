/* SPDX-License-Identifier: BSD-3-Clause */
/* In which share the fields of cells are taken, where voxels could make them, too: all of it where
 * both sides of the border are thick, up to their sharp edges, along which voxels would leave a
 * thorn or a notch each. That is asked of the smoothed field, in which noise no longer looks like
 * thin tissue, and tissue too thin for cells is thin or gone. Around what it has lost, and in
 * slender tissue upon other tissue (border_slender.c), cells have no share. */
#include "border/border.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum {
    BALL_REACH = 4, /* cells that a ball reaches from its middle: EDGE_REACH / 2 */
    BALL_ROWS = 2 * BALL_REACH + 1,
    FIT_REACH = 2, /* cells around its middle that tell whether it fits */
    DEEP_REACH = BALL_REACH + FIT_REACH,
    DEEP_LEVELS = 3,  /* sizes of balls */
    BORDER_BLURS = 2, /* passes of the binomial that make a mean over the border */
    BORDER_EDGE = SC_CUBE_CELLS + 2 * BORDER_BLURS,
    BORDER_CELLS = BORDER_EDGE * BORDER_EDGE * BORDER_EDGE,
    DEEP_EDGE = BORDER_EDGE + 2 * DEEP_REACH,
    LENGTHS = 5 /* of the ways from the middle of a ball to the cells that tell whether it fits */
};
_Static_assert((int)BORDER_CELLS == (int)SC_SLENDER_CELLS, "slender tissue is told of all of them");
_Static_assert(DEEP_EDGE == 24, "find_cells takes six times four cells of a row");
/* A side of the border is thick at a cell near which a ball lies that fits into the side. So deep,
 * in voxels, has the middle of the largest one to be on both sides that cells count, and that they
 * decide alone. */
#define DEEP_FROM 2.6f
#define DEEP_ALL 3.8f
/* So far from the border, in voxels, the field tells the distance; deeper inside it is less where
 * voxels on the way are noise. */
#define KNOWN 1.8f
/* Balls reach so much farther, since the border is not known better. */
#define ROUNDING 1.7f
/* But tissue is thick up to so many voxels from the middle of all but the largest ball, of the
 * smallest up to an edge of 40 degrees: DEEP_FROM / sin 20. Background is not: a gap is thin up to
 * its mouth, however open it is beyond. */
#define EDGE_REACH 8.0f
/* Smoothing takes from sharp edges. What touches a cell, with data above -TOUCHED, is lost if no
 * cell with a field of KEPT lies within it and two steps away, the first of which may go across
 * edges and corners. Around it, LOST_AROUND voxels far, no cells decide. */
#define TOUCHED 0.65f
#define KEPT 0.6f
#define LOST_AROUND 5.5f
/* Cells with data below this, in voxels, lie at the border. */
#define AT_BORDER 1.0f

/* What the threads share. */
typedef struct weigher {
    const sc_borders *b;
    float (*field)[SC_TILE_CELLS]; /* not a number in cells with background; takes the place of
                                      b->box */
} weigher;

/* @return how many voxels of a cell of an inner field are free. */
static int free_voxels(const sc_borders *b, size_t tile, int cell)
{
    const int8_t *low =
        b->squares[tile] + (cell / 64 * SC_CUBE + cell / 8 % 8) * 2 * SC_CUBE + 2 * (cell % 8);
    int count = 0;

    for (int n = 0; n < 8; n++)
        count += !low[((n >> 2) * SC_CUBE + (n >> 1 & 1)) * SC_CUBE + (n & 1)];
    return b->tiles.labels[tile] ? count : 0;
}

/* Copy the fields of tiles [begin, end), but not of cells with free voxels: the background has no
 * say, so what lies on it counts as thick towards it, up to the rim where it tapers. No border is
 * asked for where all voxels are free: the data are set to SC_FAR; an sc_range_fn on a weigher. */
static void copy_tiles(void *user, size_t begin, size_t end, int thread)
{
    const weigher *w = user;

    for (size_t tile = begin; tile < end; tile++) {
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            const int free = free_voxels(w->b, tile, i);

            w->field[tile][i] = free > 0 ? NAN : w->b->value[tile][i];
            w->b->data[tile][i] = free == 8 ? SC_FAR : w->b->data[tile][i];
        }
    }
}

/* Rows of a region, whose cells are bits. */
typedef uint32_t cell_rows[DEEP_EDGE][DEEP_EDGE];
typedef uint32_t border_rows[BORDER_EDGE * BORDER_EDGE];

/* Find the cells of a region whose field, times @p sign, is as much as one of @p count numbers or
 * more, or is not known, to one of @p out each. */
SC_ALWAYS_INLINE void find_cells(const float *field, float sign, int count, const float *least,
                                 cell_rows *out)
{
    for (int k = 0; k < DEEP_EDGE * DEEP_EDGE; k++) {
        const float *row = field + k * DEEP_EDGE;
#ifdef __SSE2__
        enum { FOURS = DEEP_EDGE / 4 };
        __m128 values[FOURS];

        for (int n = 0; n < FOURS; n++)
            values[n] = _mm_mul_ps(_mm_set1_ps(sign), _mm_loadu_ps(row + 4 * n));
        for (int i = 0; i < count; i++) {
            __m128i is[FOURS];

            for (int n = 0; n < FOURS; n++)
                is[n] = _mm_castps_si128(_mm_cmpnlt_ps(values[n], _mm_set1_ps(least[i])));
            is[0] = _mm_packs_epi16(_mm_packs_epi32(is[0], is[1]), _mm_packs_epi32(is[2], is[3]));
            is[4] = _mm_packs_epi16(_mm_packs_epi32(is[4], is[5]), _mm_setzero_si128());
            out[i][k / DEEP_EDGE][k % DEEP_EDGE] =
                (uint32_t)_mm_movemask_epi8(is[0]) | (uint32_t)_mm_movemask_epi8(is[4]) << 16;
        }
#else
        for (int i = 0; i < count; i++) {
            uint32_t bits = 0;

            for (int x = 0; x < DEEP_EDGE; x++)
                bits |= (uint32_t) !(sign * row[x] < least[i]) << x;
            out[i][k / DEEP_EDGE][k % DEEP_EDGE] = bits;
        }
#endif
    }
}

/* Find the cells of a region in which the middle of a ball of @p radius voxels may lie that fits
 * into the side of @p sign: all cells around are as far from the border as they have to be, as far
 * as that is known. Those along the edge of the region are not found. */
SC_ALWAYS_INLINE void find_deep(const float *field, float sign, float radius, cell_rows out)
{
    /* to the cells that share a face, an edge or a corner, and to the next ones along the axes */
    static const float lengths[LENGTHS] = {0, 2, 2.828427f, 3.464102f, 4};
    float least[LENGTHS];
    cell_rows far[LENGTHS];

    for (int i = 0; i < LENGTHS; i++)
        least[i] = radius - lengths[i] < KNOWN ? radius - lengths[i] : KNOWN;
    find_cells(field, sign, LENGTHS, least, far);
    memset(out, 0, sizeof(cell_rows));
    for (int z = FIT_REACH; z < DEEP_EDGE - FIT_REACH; z++) {
        for (int y = FIT_REACH; y < DEEP_EDGE - FIT_REACH; y++) {
            const uint32_t *face = far[1][z] + y, *edge = far[2][z] + y, *low = far[2][z - 1] + y,
                           *high = far[2][z + 1] + y, *next = far[4][z] + y;
            const uint32_t faces = face[-1] & face[1] & far[1][z - 1][y] & far[1][z + 1][y];
            const uint32_t nexts = next[-2] & next[2] & far[4][z - 2][y] & far[4][z + 2][y];
            const uint32_t corners = far[3][z - 1][y - 1] & far[3][z - 1][y + 1] &
                                     far[3][z + 1][y - 1] & far[3][z + 1][y + 1];
            const uint32_t edges = edge[-1] & edge[1] & low[0] & high[0] & corners;

            out[z][y] = far[0][z][y] & faces & nexts & low[-1] & low[1] & high[-1] & high[1] &
                        (face[0] & edges) << 1 & (face[0] & edges) >> 1 & next[0] << 2 &
                        next[0] >> 2;
        }
    }
}

/* Find the cells at most @p radius cells away from one of @p in; those along the edge of the region
 * are not found. */
SC_ALWAYS_INLINE void spread(const cell_rows in, float radius, cell_rows out)
{
    cell_rows rows[BALL_REACH + 1]; /* in, spread so far along x */

    memcpy(rows[0], in, sizeof rows[0]);
    for (int d = 1; d <= BALL_REACH; d++) {
        const uint32_t *before = &rows[d - 1][0][0], *from = &in[0][0];
        uint32_t *to = &rows[d][0][0];

        for (int k = 0; k < DEEP_EDGE * DEEP_EDGE; k++)
            to[k] = before[k] | from[k] << d | from[k] >> d;
    }
    memset(out, 0, sizeof(cell_rows));
    for (int n = 0; n < BALL_ROWS * BALL_ROWS; n++) {
        const int dy = n % BALL_ROWS - BALL_REACH, dz = n / BALL_ROWS - BALL_REACH;
        const float left = radius * radius - (float)(dy * dy + dz * dz);

        for (int z = DEEP_REACH; z < DEEP_EDGE - DEEP_REACH && left >= 0; z++) {
            const uint32_t *from = &rows[(int)sqrtf(left)][z + dz][0] + dy;

            for (int y = DEEP_REACH; y < DEEP_EDGE - DEEP_REACH; y++)
                out[z][y] |= from[y];
        }
    }
}

/* Add to @p rows those cells of @p within that share a face with one of them, or with @p corners an
 * edge or a corner, too. Not right along the edge of the region. */
SC_ALWAYS_INLINE void grow(cell_rows rows, const cell_rows within, bool corners)
{
    enum { ROWS = DEEP_EDGE * DEEP_EDGE };
    uint32_t along[ROWS], across[ROWS], *to = &rows[0][0];

    for (int k = 0; k < ROWS; k++)
        along[k] = to[k] | to[k] << 1 | to[k] >> 1;
    for (int k = 1; k < ROWS - 1; k++)
        across[k] = along[k] | (corners ? along[k - 1] | along[k + 1] : to[k - 1] | to[k + 1]);
    across[0] = across[ROWS - 1] = 0;
    memcpy(along, corners ? across : to, sizeof along);
    for (int k = DEEP_EDGE; k < ROWS - DEEP_EDGE; k++)
        to[k] |= (across[k] | along[k - DEEP_EDGE] | along[k + DEEP_EDGE]) & (&within[0][0])[k];
}

/* Find the cells at the border that touch a side of which the field has lost what they touch:
 * tissue, or a gap, too thin for cells, but not sharp edges. Not right along the edge of the
 * region.
 * @param field, data [DEEP_EDGE] along each axis. */
SC_ALWAYS_INLINE void find_lost(const float *field, const float *data, cell_rows lost)
{
    enum { ROWS = DEEP_EDGE * DEEP_EDGE };
    static const float kept_least[] = {-KEPT}, none[] = {SC_FAR + 1};
    static const float touched_least[] = {-TOUCHED, AT_BORDER};
    cell_rows unknown[1], inside[2];

    memset(lost, 0, sizeof(cell_rows));
    memset(inside, 0, sizeof inside);
    find_cells(field, 1, 1, none, unknown);
    for (int side = 0; side < 2; side++) {
        cell_rows kept[1], found[2];
        uint32_t *own = &kept[0][0][0], *touched = &found[0][0][0];

        find_cells(field, side ? 1 : -1, 1, kept_least, kept);
        find_cells(data, side ? -1 : 1, 2, touched_least, found);
        for (int k = 0; k < ROWS; k++) {
            own[k] = ~own[k];
            touched[k] &= ~(&unknown[0][0][0])[k];
            (&inside[0][0][0])[k] |= (&found[1][0][0])[k];
        }
        grow(kept[0], (const uint32_t(*)[DEEP_EDGE])found[0], true);
        grow(kept[0], (const uint32_t(*)[DEEP_EDGE])found[0], false);
        for (int k = 0; k < ROWS; k++)
            (&lost[0][0])[k] |= touched[k] & ~own[k];
    }
    for (int k = 0; k < ROWS; k++)
        (&lost[0][0])[k] &= ~(&inside[0][0][0])[k];
}

/* Find those cells of @p within [BORDER_EDGE] near which balls of one size fit into both sides.
 * @return whether there are any. @param outer whether it is the field of background. */
SC_ALWAYS_INLINE bool find_fitting(const float *field, int level, bool outer,
                                   const border_rows within, border_rows out)
{
    const float deep = DEEP_FROM + (DEEP_ALL - DEEP_FROM) * (float)level / (DEEP_LEVELS - 1);
    const float to_edges = level + 1 < DEEP_LEVELS ? EDGE_REACH : deep + ROUNDING;
    cell_rows cells, reached[2];
    uint32_t any = 0;

    for (int side = 0; side < 2; side++) {
        find_deep(field, side ? -1 : 1, deep, cells);
        spread((const uint32_t(*)[DEEP_EDGE])cells,
               0.5f * (side && outer ? deep + ROUNDING : to_edges), reached[side]);
    }
    for (int k = 0; k < BORDER_EDGE * BORDER_EDGE; k++) {
        const int y = k % BORDER_EDGE + DEEP_REACH, z = k / BORDER_EDGE + DEEP_REACH;

        out[k] = (reached[0][z][y] & reached[1][z][y]) >> DEEP_REACH & within[k];
        any |= out[k];
    }
    return any;
}

/* Write to @p share, for the cells of a region [BORDER_EDGE] that lie at the border, in which part
 * of DEEP_LEVELS balls fit into both sides there, and 0 for others. @param field, data [DEEP_EDGE].
 * @param at_border 1 and 0 for them. @param outer whether it is the field of background. */
SC_ALWAYS_INLINE void find_thick(const float *field, const float *data, const float *at_border,
                                 bool outer, float *share)
{
    cell_rows lost, around;
    border_rows within, fits[DEEP_LEVELS];

    find_lost(field, data, lost);
    spread((const uint32_t(*)[DEEP_EDGE])lost, 0.5f * LOST_AROUND, around);
    for (int k = 0; k < BORDER_EDGE * BORDER_EDGE; k++)
        within[k] =
            ~around[k / BORDER_EDGE + DEEP_REACH][k % BORDER_EDGE + DEEP_REACH] >> DEEP_REACH &
            ((1u << BORDER_EDGE) - 1);
    for (int i = 0; i < BORDER_CELLS; i++)
        share[i] = 0;
    if (!find_fitting(field, 0, outer, within, fits[0]))
        return;
    find_fitting(field, 2, outer, fits[0], fits[2]);
    memcpy(fits[1], fits[0], sizeof fits[1]);
    if (memcmp(fits[2], fits[0], sizeof fits[2]) != 0) /* else what lies between fits, too */
        find_fitting(field, 1, outer, fits[0], fits[1]);
    for (int level = 0; level < DEEP_LEVELS; level++) {
        for (int i = 0; i < BORDER_CELLS; i++)
            share[i] += at_border[i] *
                        (float)(fits[level][i / BORDER_EDGE] >> i % BORDER_EDGE & 1) *
                        (1.0f / DEEP_LEVELS);
    }
}

/* Find in which share cells alone decide in tiles [begin, end), by w->field: the mean over the
 * border around; an sc_range_fn on a weigher. */
SC_WIDE_VECTORS static void weigh_tiles(void *user, size_t begin, size_t end, int thread)
{
    static const float far[SC_BESIDE_CONSTANTS] = {SC_FAR, SC_FAR, -SC_FAR, SC_FAR};
    static const float unknown[SC_BESIDE_CONSTANTS] = {NAN, SC_FAR, -SC_FAR, 0};
    const weigher *w = user;
    const sc_borders *b = w->b;
    uint8_t slender[SC_SLENDER_CELLS];
    uint32_t block = UINT32_MAX; /* of slender */

    for (size_t tile = begin; tile < end; tile++) {
        float field[DEEP_EDGE * DEEP_EDGE * DEEP_EDGE], data[DEEP_EDGE * DEEP_EDGE * DEEP_EDGE];
        float share[BORDER_CELLS], weight[BORDER_CELLS];
        bool any = false;

        for (int i = 0; i < SC_TILE_CELLS; i++)
            b->coarse[tile][i] = 1;
        if (b->still[tile])
            continue;
        sc_read_tile_cells(b, b->data[0], tile, BORDER_BLURS, far, weight);
        sc_extrapolate(b, tile, SC_CUBE_CELLS, BORDER_BLURS, weight);
        for (int i = 0; i < BORDER_CELLS; i++) {
            weight[i] = fabsf(weight[i]) < AT_BORDER ? 1 : 0;
            any = any || weight[i] > 0;
        }
        if (!any)
            continue;
        sc_read_tile_cells(b, w->field[0], tile, DEEP_REACH + BORDER_BLURS, unknown, field);
        sc_extrapolate(b, tile, SC_CUBE_CELLS, DEEP_REACH + BORDER_BLURS, field);
        sc_read_tile_cells(b, b->data[0], tile, DEEP_REACH + BORDER_BLURS, far, data);
        sc_extrapolate(b, tile, SC_CUBE_CELLS, DEEP_REACH + BORDER_BLURS, data);
        find_thick(field, data, weight, !b->tiles.labels[tile], share);
        if (b->tiles.cube_of[tile] != block)
            sc_find_slender(b, b->tiles.cube_of[tile], slender);
        block = b->tiles.cube_of[tile];
        for (int i = 0; i < BORDER_CELLS; i++)
            share[i] = slender[i] ? 0 : share[i];
        for (int i = 0; i < BORDER_BLURS; i++) {
            sc_binomial(share, BORDER_EDGE - 2 * i, share);
            sc_binomial(weight, BORDER_EDGE - 2 * i, weight);
        }
        for (int i = 0; i < SC_TILE_CELLS; i++) {
            const float cells = sc_cell_share(sc_strength_at(b, tile, i));

            if (weight[i] > 0)
                b->coarse[tile][i] = cells * (share[i] < weight[i] ? share[i] / weight[i] : 1);
        }
    }
}

sc_status sc_weigh_cells(const sc_ctx *ctx, sc_borders *b)
{
    weigher w = {.b = b, .field = b->box};
    sc_team *team = b->p->team;
    void *block;

    SC_PASS(sc_team_alloc(ctx, team, b->tiles.count + 1, sizeof *b->coarse, &block));
    b->coarse = block;
    sc_team_for(team, b->tiles.count, 64, copy_tiles, &w);
    sc_team_stage_for(ctx, SC_WORTH_WEIGHING, team, b->tiles.count, 64, weigh_tiles, &w);
    return SC_OK;
}
