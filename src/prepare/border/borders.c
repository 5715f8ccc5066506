/* SPDX-License-Identifier: BSD-3-Clause */
/* Which vertices have a record of the two fields, by the rule of sc_prepared, and their numbering.
 */
#include "internal.h"

/* A layer of the vertices around a brick, or of the cells between them, as bits: x + 8 y. */
enum { LAYER_ROW = 8, CELLS = SC_BLOCK - 1 };
#define LAYER_CELLS 0x1f1f1f1f1full /* the cells of a layer */

void sc_fetch_ids(const sc_preparation *p, size_t brick, uint16_t ids[SC_BLOCK_ROWS][SC_BLOCK_ROOM])
{
    const sc_volume *v = p->volume;
    const size_t line = (size_t)v->size[0], layer = line * (size_t)v->size[1];
    int low[3];
    bool inside;

    sc_brick_low(p->bricks, brick, low);
    for (int i = 0; i < 3; i++)
        low[i] -= 2; /* the lowest voxel */
    inside = low[0] + SC_BLOCK_ROOM <= v->size[0];
    for (int i = 0; i < 3; i++)
        inside = inside && low[i] >= 0 && low[i] + SC_BLOCK <= v->size[i];
    for (int row = 0; row < SC_BLOCK_ROWS; row++) {
        const int y = low[1] + row % SC_BLOCK, z = low[2] + row / SC_BLOCK;

        if (inside) {
            sc_copy_ids(v, (size_t)z * layer + (size_t)y * line + (size_t)low[0], SC_BLOCK_ROOM,
                        ids[row]);
            continue;
        }
        for (int x = 0; x < SC_BLOCK_ROOM; x++)
            ids[row][x] = (uint16_t)sc_id_or_nearest(v, low[0] + x, y, z);
    }
}

/* @return the row of a block in which row @p row of its brick lies. */
static int row_of_block(int row)
{
    return (row / SC_BRICK + 1) * SC_BLOCK + row % SC_BRICK + 1;
}

/* @return the number of the brick at (x, y, z) in the arrays of the fields; 0: none, or there is no
 * such brick. */
static uint32_t number_of(const sc_preparation *p, const sc_fields *f, int x, int y, int z)
{
    if (x < 0 || y < 0 || z < 0 || x >= p->bricks[0] || y >= p->bricks[1] || z >= p->bricks[2])
        return 0;
    return f->number[sc_brick_index(p->bricks, x, y, z)];
}

/* @return the bits of vertices of a row of a block: of the last one of the brick before, of those
 * of a brick and of the first one of the next. @param first the bit of the first in a brick. */
static inline unsigned bits_of_row(const uint64_t bricks[3], int first)
{
    return (unsigned)(bricks[0] >> (first + SC_BRICK - 1) & 1) |
           (unsigned)(bricks[1] >> first & SC_BRICK_ROW_BITS) << 1 |
           (unsigned)(bricks[2] >> first & 1) << (SC_BRICK + 1);
}

/* Take what the fields say of the vertices of rows [begin, end) along y and z of a block: their
 * sides and tissues. @param number of the three bricks that hold them. @param low the lowest vertex
 * of the block. */
static void fetch_rows(const sc_preparation *p, const sc_fields *f, const uint32_t number[3],
                       const int begin[2], const int end[2], const int low[3], sc_block *out)
{
    uint64_t known[3], tissue[3], moved[3];
    unsigned is;

    for (int i = 0; i < 3; i++) {
        const sc_brick_sides *sides = number[i] ? &f->sides[number[i] - 1] : NULL;

        known[i] = sides ? ~0ull : 0;
        tissue[i] = sides ? sides->tissue : 0;
        moved[i] = sides ? sides->moved : 0;
    }
    is = bits_of_row(known, 0);
    for (int k = begin[1]; k < end[1] && is; k++) {
        for (int j = begin[0]; j < end[0]; j++) {
            const int row = k * SC_BLOCK + j, y = low[1] + j, z = low[2] + k;
            const int first = sc_brick_bit(0, y, z);

            out->sides[row] = (uint8_t)((out->sides[row] & ~is) | bits_of_row(tissue, first));
            for (unsigned left = bits_of_row(moved, first); left; left &= left - 1) {
                const int x = __builtin_ctz(left), part = x > 0 ? x > SC_BRICK ? 2 : 1 : 0;
                const int code = f->codes[number[part] - 1][first + ((x - 1) & SC_BRICK_MASK)];

                out->tissue[row][x] = (uint16_t)sc_id_or_nearest(
                    p->volume, low[0] + x - 1 + sc_tissue_step(code, 0),
                    y - 1 + sc_tissue_step(code, 1), z - 1 + sc_tissue_step(code, 2));
            }
        }
    }
}

void sc_fetch_block(const sc_preparation *p, const sc_fields *f, size_t brick, sc_block *out)
{
    static const int begin[4] = {0, 1, 1 + SC_BRICK,
                                 SC_BLOCK}; /* of the brick before, of it, ... */
    int at[3], low[3];

    sc_brick_at(p->bricks, brick, at);
    for (int i = 0; i < 3; i++)
        low[i] = at[i] * SC_BRICK - 1;
    sc_fetch_ids(p, brick, out->tissue);
    for (int row = 0; row < SC_BLOCK_ROWS; row++)
        out->sides[row] = (uint8_t)(~sc_equal_bits(out->tissue[row], 0) & ((1u << SC_BLOCK) - 1));
    out->labelled = 0;
    for (int row = 0; row < SC_BRICK_LAYER; row++)
        out->labelled |= (uint64_t)(out->sides[row_of_block(row)] >> 1 & SC_BRICK_ROW_BITS)
                         << (row * SC_BRICK);
    for (int n = 0; n < 9; n++) {
        const int y = n % 3, z = n / 3;
        uint32_t number[3];

        for (int x = 0; x < 3; x++)
            number[x] = number_of(p, f, at[0] + x - 1, at[1] + y - 1, at[2] + z - 1);
        fetch_rows(p, f, number, (const int[2]){begin[y], begin[z]},
                   (const int[2]){begin[y + 1], begin[z + 1]}, low, out);
    }
    out->moved = f->number[brick] ? f->sides[f->number[brick] - 1].moved : 0;
}

/* Which cells of a block hold a border, a layer after the other. */
typedef struct cell_layers {
    uint64_t outer[CELLS], inner[CELLS];
} cell_layers;

/* Find the cells with corners on both sides, and to @p tissue those with a corner on the side of
 * tissue. */
static void find_outer_cells(const sc_block *b, uint64_t outer[CELLS], uint64_t tissue[CELLS])
{
    uint64_t any[SC_BLOCK], all[SC_BLOCK];

    for (int z = 0; z < SC_BLOCK; z++) {
        uint64_t layer = 0;

        for (int y = 0; y < SC_BLOCK; y++)
            layer |= (uint64_t)b->sides[z * SC_BLOCK + y] << (LAYER_ROW * y);
        any[z] = layer | layer >> 1;
        any[z] |= any[z] >> LAYER_ROW;
        all[z] = layer & layer >> 1;
        all[z] &= all[z] >> LAYER_ROW;
    }
    for (int z = 0; z < CELLS; z++) {
        tissue[z] = any[z] | any[z + 1];
        outer[z] = tissue[z] & ~(all[z] & all[z + 1]);
    }
}

/* Find the cells whose corners that have a tissue do not all have the same. Rows follow each other,
 * so that all cells are compared side by side; what lies beyond a row or a layer is of no use. */
static void find_inner_cells(const sc_block *b, uint64_t inner[CELLS])
{
    enum { LAYER = SC_BLOCK * SC_BLOCK_ROOM, ALL = SC_BLOCK * LAYER };
    const uint16_t *at = b->tissue[0];
    /* least is kept less 1, by which background, 0, becomes the largest number */
    uint16_t least[ALL], most[ALL], any = 0;
    uint8_t differ[CELLS * LAYER];

    for (int i = 0; i < ALL - 1; i++) { /* of x and x + 1, */
        const uint16_t a = (uint16_t)(at[i] - 1), c = (uint16_t)(at[i + 1] - 1);

        least[i] = a < c ? a : c;
        most[i] = at[i] > at[i + 1] ? at[i] : at[i + 1];
    }
    for (int i = 0; i < ALL - SC_BLOCK_ROOM - 1; i++) { /* and of y and y + 1 */
        const uint16_t a = least[i + SC_BLOCK_ROOM], c = most[i + SC_BLOCK_ROOM];

        least[i] = least[i] < a ? least[i] : a;
        most[i] = most[i] > c ? most[i] : c;
    }
    for (int i = 0; i < CELLS * LAYER - SC_BLOCK_ROOM - 1; i++) {
        const uint16_t a = least[i + LAYER], c = most[i + LAYER];
        const uint16_t low = (uint16_t)((least[i] < a ? least[i] : a) + 1);

        differ[i] = low < (most[i] > c ? most[i] : c);
        any |= differ[i];
    }
    memset(inner, 0, CELLS * sizeof *inner);
    for (int k = 0; k < CELLS * CELLS * CELLS && any; k++) {
        const int x = k % CELLS, y = k / CELLS % CELLS, z = k / (CELLS * CELLS);

        inner[z] |= (uint64_t)differ[z * LAYER + y * SC_BLOCK_ROOM + x] << (LAYER_ROW * y + x);
    }
}

/* @return the vertices of the brick that are corners of cells of @p cells, as bits. */
static uint64_t corners_of(const uint64_t cells[CELLS])
{
    uint64_t spread[CELLS], out = 0;

    for (int z = 0; z < CELLS; z++) {
        spread[z] = cells[z] | cells[z] << 1;
        spread[z] |= spread[z] << LAYER_ROW;
    }
    for (int z = 0; z < SC_BRICK; z++) {
        const uint64_t layer = (spread[z] | spread[z + 1]) >> (LAYER_ROW + 1);

        for (int y = 0; y < SC_BRICK; y++)
            out |= (layer >> (LAYER_ROW * y) & SC_BRICK_ROW_BITS) << sc_brick_bit(0, y, z);
    }
    return out;
}

/* @return those of the first @p count places from @p first on that lie within 0 to @p last, as
 * bits. */
static uint64_t places_within(int first, int count, int last)
{
    uint64_t bits = 0;

    for (int i = 0; i < count; i++)
        bits |= (uint64_t)(first + i >= 0 && first + i <= last) << i;
    return bits;
}

/* Find the vertices of brick @p brick that have a record of the outer and of the inner field, as
 * bits, to @p masks. */
static void find_masks(const sc_preparation *p, const sc_fields *f, size_t brick, uint64_t masks[2])
{
    const int *size = p->volume->size;
    uint64_t outer[CELLS], inner[CELLS], tissue[CELLS], grid = 0, layer = 0, sides = 0;
    sc_block block;
    uint64_t cells[3], vertices[3]; /* along each axis, that lie in the grid */
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    sc_fetch_block(p, f, brick, &block);
    find_outer_cells(&block, outer, tissue);
    find_inner_cells(&block, inner);
    for (int i = 0; i < 3; i++) {
        cells[i] = places_within(low[i] - 1, CELLS, size[i]);
        vertices[i] = places_within(low[i], SC_BRICK, size[i] + 1);
    }
    for (int y = 0; y < CELLS; y++)
        layer |= (cells[1] >> y & 1) * (cells[0] << (LAYER_ROW * y));
    for (int z = 0; z < CELLS; z++) {
        const uint64_t within = cells[2] >> z & 1 ? layer : 0;

        outer[z] &= within;
        inner[z] &= within & tissue[z];
    }
    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const int y = row % SC_BRICK, z = row / SC_BRICK, at = row * SC_BRICK;

        grid |= (vertices[1] >> y & vertices[2] >> z & 1) * (vertices[0] << at);
        sides |= (uint64_t)(block.sides[row_of_block(row)] >> 1 & SC_BRICK_ROW_BITS) << at;
    }
    masks[0] = corners_of(outer) | ((sides ^ block.labelled) & grid);
    masks[1] = corners_of(inner) | (block.moved & block.labelled & grid);
}

/* What the threads share. */
typedef struct marking {
    const sc_preparation *p;
    const sc_fields *fields;
    uint64_t *masks[2];
} marking;

/* Find the masks of bricks [begin, end); an sc_range_fn on a marking. */
static void find_records(void *user, size_t begin, size_t end, int thread)
{
    const marking *m = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        uint64_t masks[2];

        if (!m->fields->number[brick])
            continue;
        find_masks(m->p, m->fields, brick, masks);
        for (int i = 0; i < 2; i++)
            m->masks[i][brick] = masks[i];
    }
}

sc_status sc_mark_borders(const sc_ctx *ctx, sc_preparation *p, const sc_fields *fields)
{
    sc_border *const borders[2] = {&p->outer, &p->inner};
    marking m = {.p = p, .fields = fields};

    for (int i = 0; i < 2; i++) {
        void *block;

        SC_PASS(sc_team_alloc(ctx, p->team, p->brick_count, sizeof(uint64_t), &block));
        borders[i]->masks = m.masks[i] = block;
    }
    sc_team_stage_for(ctx, SC_WORTH_BORDERS / 2, p->team, p->brick_count, 1024, find_records, &m);
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
