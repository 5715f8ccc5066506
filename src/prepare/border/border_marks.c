/* SPDX-License-Identifier: BSD-3-Clause */
/* Which vertices have a record of the two fields, by the rule of sc_prepared, and their numbering:
 * for a group of bricks at a time, whose vertices, and those around, are bits of rows. */
#include "border/border_group.h"

enum {
    VERTICES = SC_IDS_EDGE,     /* of a group and around it, along an axis; */
    CELLS = VERTICES - 1,       /* cells between them; */
    BRICKS = SC_GROUP_EDGE + 2, /* and bricks that hold them */
    BEFORE = SC_BRICK - 1, /* bits of a row before the first vertex: so a row is one of bricks */
    ROWS = SC_IDS_EDGE * SC_IDS_ROW /* ids of a layer */
};

/* Bits of vertices, or of the cells from them on, [z][y]: BEFORE of them are of no use. */
typedef uint32_t bit_rows[VERTICES][VERTICES];

/* What the fields say of the vertices of a group and of those around it. */
typedef struct group_vertices {
    sc_group_ids tissue; /* dense ids; 0: none */
    bit_rows sides;      /* those on the side of tissue */
    bit_rows labelled;   /* those whose label is not the background */
    bit_rows moved;      /* those whose tissue is at another place */
} group_vertices;

/* @return the labels of a row that are not background, as bits. */
static uint32_t labelled_bits(const uint16_t ids[SC_IDS_ROW])
{
    const uint32_t none =
        sc_equal_bits(ids, 0) | sc_equal_bits(ids + 8, 0) << 8 | sc_equal_bits(ids + 16, 0) << 16;

    return (~none & ((1u << VERTICES) - 1)) << BEFORE;
}

/* Take the tissue of a vertex, @p at along x, y and z of a group, from the place that its code
 * names. @param low the lowest vertex of the group. */
static void take_tissue(const sc_record_writer *w, const int low[3], const int at[3], int code,
                        group_vertices *out)
{
    out->tissue.at[at[2]][at[1]][at[0]] = (uint16_t)sc_id_or_nearest(
        w->p->volume, low[0] + at[0] - 2 + sc_tissue_step(code, 0),
        low[1] + at[1] - 2 + sc_tissue_step(code, 1), low[2] + at[2] - 2 + sc_tissue_step(code, 2));
}

/* Take what is known of the vertices of a brick, @p place along x, y and z of those that hold a
 * group and what is around it. */
static void take_brick(const sc_record_writer *w, const int low[3], const int place[3],
                       uint32_t number, group_vertices *out)
{
    const sc_brick_sides *sides = &w->sides[number - 1];
    const uint8_t *codes = w->codes[number - 1];
    const int shift = place[0] * SC_BRICK;

    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const int y = place[1] * SC_BRICK + row % SC_BRICK - BEFORE,
                  z = place[2] * SC_BRICK + row / SC_BRICK - BEFORE, first = row * SC_BRICK;
        const uint32_t tissue = (uint32_t)(sides->tissue >> first) & SC_BRICK_ROW_BITS;
        const uint32_t moved = (uint32_t)(sides->moved >> first) & SC_BRICK_ROW_BITS;

        if (y < 0 || z < 0 || y >= VERTICES || z >= VERTICES)
            continue;
        out->sides[z][y] = (out->sides[z][y] & ~(SC_BRICK_ROW_BITS << shift)) | tissue << shift;
        out->moved[z][y] |= moved << shift;
        for (uint32_t left = moved; left; left &= left - 1) {
            const int bit = __builtin_ctz(left), x = shift + bit - BEFORE;

            if (x >= 0 && x < VERTICES)
                take_tissue(w, low, (const int[3]){x, y, z}, codes[first + bit], out);
        }
    }
}

/* Fill @p out for the group whose lowest vertex is @p low. */
static void read_vertices(const sc_record_writer *w, const int low[3], group_vertices *out)
{
    const int *bricks = w->p->bricks;

    sc_read_group_ids(w->p->volume, (const int[3]){low[0] - 1, low[1] - 1, low[2] - 1},
                      &out->tissue);
    for (int k = 0; k < VERTICES * VERTICES; k++)
        out->labelled[k / VERTICES][k % VERTICES] =
            labelled_bits(out->tissue.at[k / VERTICES][k % VERTICES]);
    memcpy(out->sides, out->labelled, sizeof out->sides);
    memset(out->moved, 0, sizeof out->moved);
    for (int n = 0; n < BRICKS * BRICKS * BRICKS; n++) {
        const int place[3] = {n % BRICKS, n / BRICKS % BRICKS, n / (BRICKS * BRICKS)};
        const int x = low[0] / SC_BRICK + place[0] - 1, y = low[1] / SC_BRICK + place[1] - 1,
                  z = low[2] / SC_BRICK + place[2] - 1;
        uint32_t number;

        if (x < 0 || y < 0 || z < 0 || x >= bricks[0] || y >= bricks[1] || z >= bricks[2])
            continue;
        number = w->number[sc_brick_index(bricks, x, y, z)];
        if (number)
            take_brick(w, low, place, number, out);
    }
}

/* Find the cells with corners on both sides, to @p outer, and to @p tissue those with a corner on
 * the side of tissue. */
static void find_outer_cells(const bit_rows sides, bit_rows outer, bit_rows tissue)
{
    for (int z = 0; z < CELLS; z++) {
        for (int y = 0; y < CELLS; y++) {
            const uint32_t any =
                sides[z][y] | sides[z][y + 1] | sides[z + 1][y] | sides[z + 1][y + 1];
            const uint32_t all =
                sides[z][y] & sides[z][y + 1] & sides[z + 1][y] & sides[z + 1][y + 1];

            tissue[z][y] = any | any >> 1;
            outer[z][y] = tissue[z][y] & ~(all & all >> 1);
        }
    }
}

/* Find the cells whose corners that have a tissue do not all have the same. Rows of ids follow each
 * other, so that all cells of a layer are compared side by side; what lies beyond a row is of no
 * use. */
SC_ALWAYS_INLINE void find_inner_cells(const sc_group_ids *ids, bit_rows inner)
{
    /* least is kept less 1, by which background, 0, becomes the largest number */
    uint16_t least[2][ROWS], most[2][ROWS], differ[ROWS];

    memset(differ, 0, sizeof differ);
    for (int z = 0; z < VERTICES; z++) {
        const uint16_t *at = ids->at[z][0];
        uint16_t *low = least[z & 1], *high = most[z & 1], lows[ROWS], highs[ROWS];
        const uint16_t *low_before = least[~z & 1], *high_before = most[~z & 1];

        for (int i = 0; i < ROWS - 1; i++) { /* of x and x + 1, */
            const uint16_t a = (uint16_t)(at[i] - 1), c = (uint16_t)(at[i + 1] - 1);

            lows[i] = a < c ? a : c;
            highs[i] = at[i] > at[i + 1] ? at[i] : at[i + 1];
        }
        for (int i = 0; i < ROWS - SC_IDS_ROW - 1; i++) { /* and of y and y + 1, */
            const uint16_t a = lows[i + SC_IDS_ROW], c = highs[i + SC_IDS_ROW];

            low[i] = lows[i] < a ? lows[i] : a;
            high[i] = highs[i] > c ? highs[i] : c;
        }
        if (z == 0)
            continue;
        for (int i = 0; i < ROWS - SC_IDS_ROW - 1; i++) { /* and of z and z + 1 */
            const uint16_t a = low_before[i], c = high_before[i];

            differ[i] =
                (uint16_t)((uint16_t)((low[i] < a ? low[i] : a) + 1) ^ (high[i] > c ? high[i] : c));
        }
        for (int y = 0; y < CELLS; y++)
            inner[z - 1][y] = labelled_bits(differ + y * SC_IDS_ROW);
    }
}

/* Let @p out be the vertices of a group that are corners of cells of @p cells. */
static void spread(const bit_rows cells, bit_rows out)
{
    for (int z = 1; z <= SC_CUBE; z++) {
        for (int y = 1; y <= SC_CUBE; y++) {
            const uint32_t any =
                cells[z][y] | cells[z][y - 1] | cells[z - 1][y] | cells[z - 1][y - 1];

            out[z][y] = any | any << 1;
        }
    }
}

/* @return those of @p count places from @p first on that lie within 0 to @p last, as bits. */
static uint32_t places_within(int first, int count, int last)
{
    uint32_t bits = 0;

    for (int i = 0; i < count; i++)
        bits |= (uint32_t)(first + i >= 0 && first + i <= last) << i;
    return bits;
}

/* Keep of rows the places that lie within the volume's @p last ones along each axis. @param low the
 * place of the first. */
static void keep_within(bit_rows rows, const int low[3], const int last[3])
{
    const uint32_t x = places_within(low[0], VERTICES, last[0]) << BEFORE,
                   y = places_within(low[1], VERTICES, last[1]),
                   z = places_within(low[2], VERTICES, last[2]);

    for (int k = 0; k < VERTICES * VERTICES; k++)
        rows[k / VERTICES][k % VERTICES] &= y >> (k % VERTICES) & z >> (k / VERTICES) & 1 ? x : 0;
}

/* What the threads share. */
typedef struct marking {
    const sc_record_writer *writer;
    uint64_t *masks[2];
} marking;

/* Write the bits of rows of a group to the masks of its bricks. */
static void store_masks(const marking *m, const int low[3], int field, const bit_rows rows)
{
    const sc_record_writer *w = m->writer;

    for (int n = 0; n < SC_GROUP_BRICKS; n++) {
        const size_t brick = sc_brick_of_group(w, low, n);
        const int x = (n % SC_GROUP_EDGE + 1) * SC_BRICK,
                  y = n / SC_GROUP_EDGE % SC_GROUP_EDGE * SC_BRICK + 1,
                  z = n / (SC_GROUP_EDGE * SC_GROUP_EDGE) * SC_BRICK + 1;
        uint64_t mask = 0;

        if (brick == SIZE_MAX || !w->number[brick])
            continue;
        for (int row = 0; row < SC_BRICK_LAYER; row++)
            mask |=
                (uint64_t)(rows[z + row / SC_BRICK][y + row % SC_BRICK] >> x & SC_BRICK_ROW_BITS)
                << (row * SC_BRICK);
        m->masks[field][brick] = mask;
    }
}

/* Find the vertices of groups [begin, end) that have a record of the outer and of the inner field;
 * an sc_range_fn on a marking. */
SC_WIDE_VECTORS static void find_records(void *user, size_t begin, size_t end, int thread)
{
    const marking *m = user;
    const sc_record_writer *w = m->writer;
    const int *size = w->p->volume->size;
    const int grid[3] = {size[0] + 1, size[1] + 1, size[2] + 1};
    const uint64_t *wanted[2] = {w->wanted, w->wanted};

    for (size_t group = begin; group < end; group++) {
        bit_rows outer = {{0}}, inner = {{0}}, tissue = {{0}}, out[2] = {{{0}}};
        group_vertices g;
        int low[3], first[3];

        if (!sc_begin_group(w, wanted, group, low))
            continue;
        for (int i = 0; i < 3; i++)
            first[i] = low[i] - 1;
        read_vertices(w, low, &g);
        find_outer_cells((const uint32_t(*)[VERTICES])g.sides, outer, tissue);
        find_inner_cells(&g.tissue, inner);
        for (int k = 0; k < VERTICES * VERTICES; k++)
            inner[k / VERTICES][k % VERTICES] &= tissue[k / VERTICES][k % VERTICES];
        keep_within(outer, first, size);
        keep_within(inner, first, size);
        spread((const uint32_t(*)[VERTICES])outer, out[0]);
        spread((const uint32_t(*)[VERTICES])inner, out[1]);
        for (int k = 0; k < VERTICES * VERTICES; k++) {
            const int y = k % VERTICES, z = k / VERTICES;

            g.sides[z][y] ^= g.labelled[z][y];
            g.moved[z][y] &= g.labelled[z][y];
        }
        keep_within(g.sides, first, grid);
        keep_within(g.moved, first, grid);
        for (int k = 0; k < VERTICES * VERTICES; k++) {
            const int y = k % VERTICES, z = k / VERTICES;

            out[0][z][y] |= g.sides[z][y];
            out[1][z][y] |= g.moved[z][y];
        }
        for (int field = 0; field < 2; field++)
            store_masks(m, low, field, (const uint32_t(*)[VERTICES])out[field]);
    }
}

sc_status sc_mark_borders(const sc_ctx *ctx, const sc_record_writer *w)
{
    sc_preparation *p = w->p;
    sc_border *const borders[2] = {&p->outer, &p->inner};
    marking m = {.writer = w};

    for (int i = 0; i < 2; i++) {
        void *block;

        SC_PASS(sc_team_alloc(ctx, p->team, p->brick_count, sizeof(uint64_t), &block));
        borders[i]->masks = m.masks[i] = block;
    }
    sc_team_stage_for(ctx, SC_WORTH_BORDERS / 2, p->team, sc_brick_count(w->groups), 4,
                      find_records, &m);
    for (int i = 0; i < 2; i++) {
        uint32_t *start = NULL;
        void *block;

        SC_PASS(sc_number_vertices(ctx, p, m.masks[i], &start, &borders[i]->count));
        borders[i]->start = start;
        SC_PASS(sc_team_alloc(ctx, p->team, borders[i]->count + SC_GATHER_BYTES / SC_RECORD_BYTES,
                              SC_RECORD_BYTES, &block));
        borders[i]->records = block;
    }
    return SC_OK;
}
