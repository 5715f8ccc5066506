/* SPDX-License-Identifier: BSD-3-Clause */
/* The records of the two fields: which vertices have one, by the rule of sc_prepared, and their
 * numbering. What stands in them is the business of who has found the fields. */
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
        for (int x = 0; x < SC_BLOCK; x++)
            ids[row][x] = (uint16_t)sc_id_or_nearest(v, low[0] + x, y, z);
    }
}

/* @return the number of the brick at (x, y, z) in the arrays of the fields; 0: none, or there is no
 * such brick. */
static uint32_t number_of(const sc_preparation *p, const sc_fields *f, int x, int y, int z)
{
    if (x < 0 || y < 0 || z < 0 || x >= p->bricks[0] || y >= p->bricks[1] || z >= p->bricks[2])
        return 0;
    return f->number[sc_brick_index(p->bricks, x, y, z)];
}

/* Take what the fields say of vertices [@p from, @p to) of row @p row of a block from the brick of
 * number @p number: their sides and tissues. @param vertex the first of these. */
static void fetch_part(const sc_preparation *p, const sc_fields *f, uint32_t number, int row,
                       int from, int to, const int vertex[3], sc_block *out)
{
    const int first = sc_brick_bit(vertex[0], vertex[1], vertex[2]);
    const unsigned some = (1u << (to - from)) - 1;
    const uint8_t *codes = f->codes[number - 1] + first;
    const unsigned sides = (unsigned)(f->sides[number - 1] >> first) & some;

    out->sides[row] = (uint8_t)((out->sides[row] & ~(some << from)) | sides << from);
    for (int x = 0; x < to - from; x++) {
        if (codes[x] != SC_TISSUE_OWN)
            out->tissue[row][from + x] = (uint16_t)sc_id_or_nearest(
                p->volume, vertex[0] + x - 1 + sc_tissue_step(codes[x], 0),
                vertex[1] - 1 + sc_tissue_step(codes[x], 1),
                vertex[2] - 1 + sc_tissue_step(codes[x], 2));
    }
}

void sc_fetch_block(const sc_preparation *p, const sc_fields *f, size_t brick, sc_block *out)
{
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    sc_fetch_ids(p, brick, out->tissue);
    out->labelled = out->moved = 0;
    for (int row = 0; row < SC_BLOCK_ROWS; row++) {
        const int y = low[1] - 1 + row % SC_BLOCK, z = low[2] - 1 + row / SC_BLOCK;
        const int bx = sc_brick_of(low[0]), by = sc_brick_of(y), bz = sc_brick_of(z);

        out->sides[row] = 0;
        for (int x = 0; x < SC_BLOCK; x++)
            out->sides[row] |= (uint8_t)((out->tissue[row][x] != 0) << x);
        if (by * SC_BRICK == low[1] && bz * SC_BRICK == low[2])
            out->labelled |= (uint64_t)(out->sides[row] >> 1 & SC_BRICK_ROW_BITS)
                             << sc_brick_bit(0, y, z);
        for (int part = 0; part < 3; part++) {
            static const int begin[4] = {0, 1, 1 + SC_BRICK, SC_BLOCK};
            const uint32_t number = number_of(p, f, bx + part - 1, by, bz);
            const int first[3] = {low[0] - 1 + begin[part], y, z};

            if (number)
                fetch_part(p, f, number, row, begin[part], begin[part + 1], first, out);
        }
    }
    for (int bit = 0; f->number[brick] && bit < SC_BRICK_VERTICES; bit++)
        out->moved |= (uint64_t)(f->codes[f->number[brick] - 1][bit] != SC_TISSUE_OWN) << bit;
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

/* Find the cells whose corners that have a tissue do not all have the same. */
static void find_inner_cells(const sc_block *b, uint64_t inner[CELLS])
{
    uint16_t least[SC_BLOCK_ROWS][SC_BLOCK_ROOM], most[SC_BLOCK_ROWS][SC_BLOCK_ROOM];

    for (int row = 0; row < SC_BLOCK_ROWS; row++) { /* of x and x + 1 */
        const uint16_t *at = b->tissue[row];

        for (int x = 0; x < CELLS; x++) {
            const uint16_t a = at[x] ? at[x] : UINT16_MAX, c = at[x + 1] ? at[x + 1] : UINT16_MAX;

            least[row][x] = a < c ? a : c;
            most[row][x] = at[x] > at[x + 1] ? at[x] : at[x + 1];
        }
    }
    for (int z = 0; z < CELLS; z++) {
        inner[z] = 0;
        for (int k = 0; k < CELLS * CELLS; k++) {
            const int x = k % CELLS, y = k / CELLS, row = z * SC_BLOCK + y;
            uint16_t low = UINT16_MAX, high = 0;

            for (int n = 0; n < 4; n++) {
                const int at = row + n / 2 * SC_BLOCK + n % 2;

                low = least[at][x] < low ? least[at][x] : low;
                high = most[at][x] > high ? most[at][x] : high;
            }
            inner[z] |= (uint64_t)(low < high) << (LAYER_ROW * y + x);
        }
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
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    sc_fetch_block(p, f, brick, &block);
    find_outer_cells(&block, outer, tissue);
    find_inner_cells(&block, inner);
    for (int y = 0; y < CELLS; y++)
        layer |= (places_within(low[1] - 1, CELLS, size[1]) >> y & 1) *
                 (places_within(low[0] - 1, CELLS, size[0]) << (LAYER_ROW * y));
    for (int z = 0; z < CELLS; z++) {
        const uint64_t within = places_within(low[2] - 1, CELLS, size[2]) >> z & 1 ? layer : 0;

        outer[z] &= within;
        inner[z] &= within & tissue[z];
    }
    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const int y = row % SC_BRICK, z = row / SC_BRICK, at = row * SC_BRICK;

        if (low[1] + y <= size[1] + 1 && low[2] + z <= size[2] + 1)
            grid |= places_within(low[0], SC_BRICK, size[0] + 1) << at;
        sides |= (uint64_t)(block.sides[(z + 1) * SC_BLOCK + y + 1] >> 1 & SC_BRICK_ROW_BITS) << at;
    }
    masks[0] = corners_of(outer) | ((sides ^ block.labelled) & grid);
    masks[1] = corners_of(inner) | (block.moved & block.labelled & grid);
}

/* What the threads share that make the records. */
typedef struct storing {
    const sc_preparation *p;
    const sc_fields *fields;
    uint64_t *masks[2];
    uint32_t *start[2], *records[2];
} storing;

/* Find the masks of bricks [begin, end); an sc_range_fn on a storing. */
static void find_records(void *user, size_t begin, size_t end, int thread)
{
    const storing *s = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        uint64_t masks[2];

        if (!s->fields->number[brick])
            continue;
        find_masks(s->p, s->fields, brick, masks);
        for (int i = 0; i < 2; i++)
            s->masks[i][brick] = masks[i];
    }
}

/* Write the records of bricks [begin, end); an sc_range_fn on a storing. */
static void fill_records(void *user, size_t begin, size_t end, int thread)
{
    const storing *s = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const uint64_t masks[2] = {s->masks[0][brick], s->masks[1][brick]};
        uint32_t *const out[2] = {s->records[0] + s->start[0][brick],
                                  s->records[1] + s->start[1][brick]};

        if (!(masks[0] | masks[1]))
            continue;
        s->fields->fill(s->fields->user, brick, masks, out);
        for (int i = 0; i < 2; i++) {
            uint32_t *record = out[i];

            for (uint64_t left = masks[i]; left; left &= left - 1, record++)
                *record |=
                    (uint32_t)s->fields->codes[s->fields->number[brick] - 1][__builtin_ctzll(left)]
                    << SC_RECORD_TISSUE_SHIFT;
        }
    }
}

/* As sc_mark_borders, and set masks, start and records of @p s, of which p and fields are set. */
static sc_status mark(const sc_ctx *ctx, sc_preparation *p, storing *s)
{
    sc_border *const borders[2] = {&p->outer, &p->inner};
    sc_status status;

    for (int i = 0; i < 2; i++) {
        void *block;

        SC_TRY(sc_team_alloc(ctx, p->team, p->brick_count, sizeof(uint64_t), &block));
        borders[i]->masks = s->masks[i] = block;
    }
    sc_team_stage_for(ctx, SC_WORTH_BORDERS / 2, p->team, p->brick_count, 1024, find_records, s);
    for (int i = 0; i < 2; i++) {
        void *block;

        SC_TRY(sc_number_vertices(ctx, p, s->masks[i], &s->start[i], &borders[i]->count));
        borders[i]->start = s->start[i];
        SC_TRY(sc_team_alloc(ctx, p->team, borders[i]->count + SC_GATHER_BYTES / SC_RECORD_BYTES,
                             SC_RECORD_BYTES, &block));
        borders[i]->records = s->records[i] = block;
    }
out:
    return status;
}

sc_status sc_mark_borders(const sc_ctx *ctx, sc_preparation *p, const sc_fields *fields)
{
    storing s = {.p = p, .fields = fields};

    return mark(ctx, p, &s);
}

sc_status sc_store_borders(const sc_ctx *ctx, sc_preparation *p, const sc_fields *fields)
{
    storing s = {.p = p, .fields = fields};
    const sc_status status = mark(ctx, p, &s);

    if (status == SC_OK)
        sc_team_stage_for(ctx, SC_WORTH_BORDERS / 2, p->team, p->brick_count, 1024, fill_records,
                          &s);
    return status;
}
