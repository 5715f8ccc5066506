/* SPDX-License-Identifier: BSD-3-Clause */
/* Packing of the visible cells for the smooth surface: labels and weights of the eight corners of a
 * cell in eight bytes, cells side by side in memory. From these alone a kernel finds whether a ray
 * crosses an interface in a cell, which in most cells it does not. */
#include "corners.h"

#include <string.h>

/* What the packing threads share. The arrays are as of sc_cells and sc_visible_cells. */
typedef struct cell_packer {
    const sc_prepared *volume;
    const uint64_t *masks; /* which cells to pack */
    uint64_t *counts;      /* of the team: cells of each chunk of bricks */
    uint32_t *start;
    uint64_t *cells;
} cell_packer;

enum { CHUNK = 4096 /* bricks that a thread claims at a time */ };

/* Weights of the vertices that are corners of a brick's cells: [z][y][x], 0 for vertices that are
 * not near an interface. Rows are as long as those of sc_corner_labels. */
typedef struct corner_weights {
    int32_t at[SC_CORNERS][SC_CORNERS][SC_CORNER_ROW];
} corner_weights;

/* Write the weights of those vertices of brick (x, y, z) that are corners of the cells to be packed
 * to out->weights, which must be zeroed before. Of a brick whose @p at, the place of its lowest
 * vertex in the arrays, is SC_BRICK along an axis (else 0), only the lowest layer is wanted. Bricks
 * beyond the last have no vertices. The records of a brick are passed row by row, in their order.
 */
static void fetch_weights(const sc_prepared *v, int x, int y, int z, const int at[3],
                          corner_weights *out)
{
    static const uint8_t bits_in[SC_BRICK_ROW_BITS + 1] = {0, 1, 1, 2, 1, 2, 2, 3,
                                                           1, 2, 2, 3, 2, 3, 3, 4};
    const size_t brick = sc_brick_index(v->bricks, x, y, z);
    const unsigned wanted = at[0] ? 1 : SC_BRICK_ROW_BITS;
    const uint8_t *record;
    uint64_t left;

    if (x >= v->bricks[0] || y >= v->bricks[1] || z >= v->bricks[2])
        return;
    left = v->near[brick] & (at[2] ? SC_BRICK_LOW_Z : ~0ull);
    record = v->records + (size_t)v->near_start[brick] * SC_RECORD_BYTES;
    for (int row = 0; left; row++, left >>= SC_BRICK) {
        const unsigned bits = (unsigned)left & SC_BRICK_ROW_BITS;
        const uint8_t *from = record;
        int32_t *to;

        record += (size_t)bits_in[bits] * SC_RECORD_BYTES;
        if (at[1] && row % SC_BRICK)
            continue;
        to = out->at[at[2] + row / SC_BRICK][at[1] + row % SC_BRICK] + at[0];
        for (unsigned some = bits & wanted; some; some &= some - 1, from += SC_RECORD_BYTES)
            to[__builtin_ctz(some)] = sc_record_weight(*from);
    }
}

/* Fill @p out for the brick at @p brick (x, y, z; without a frame). */
static void fetch_all_weights(const sc_prepared *v, const int brick[3], corner_weights *out)
{
    memset(out, 0, sizeof *out);
    for (int i = 0; i < 8; i++) {
        const int at[3] = {i & 1 ? SC_BRICK : 0, i & 2 ? SC_BRICK : 0, i & 4 ? SC_BRICK : 0};

        fetch_weights(v, brick[0] + (i & 1), brick[1] + (i >> 1 & 1), brick[2] + (i >> 2), at, out);
    }
}

static inline int32_t lesser(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t greater(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/* Write the packed cells (brick.h) of row (y, z) of a brick to @p out, side by side: compilers
 * compute with all of them at a time. */
static void pack_row(const sc_corner_labels *labels, const corner_weights *weights, int y, int z,
                     uint64_t out[SC_BRICK])
{
    const int32_t *l[4], *w[4];
    int32_t least[SC_CORNER_ROW], most[SC_CORNER_ROW];
    int32_t low[SC_BRICK], high[SC_BRICK], many[SC_BRICK] = {0};
    uint32_t words[2][SC_BRICK] = {{0}};

    for (int i = 0; i < 4; i++) {
        l[i] = labels->at[z + (i >> 1)][y + (i & 1)];
        w[i] = weights->at[z + (i >> 1)][y + (i & 1)];
    }
    for (int x = 0; x < SC_CORNER_ROW; x++) {
        least[x] = lesser(lesser(l[0][x], l[1][x]), lesser(l[2][x], l[3][x]));
        most[x] = greater(greater(l[0][x], l[1][x]), greater(l[2][x], l[3][x]));
    }
    for (int x = 0; x < SC_BRICK; x++) {
        low[x] = lesser(least[x], least[x + 1]);
        high[x] = greater(most[x], most[x + 1]);
    }
    for (int i = 0; i < 8; i++) {
        uint32_t *word = words[sc_cell_field_word(i)];
        const int32_t *label = l[i >> 1] + (i & 1), *weight = w[i >> 1] + (i & 1);

        for (int x = 0; x < SC_BRICK; x++) {
            const int32_t not_low = -(label[x] != low[x]), not_high = -(label[x] != high[x]);
            const int32_t field = (weight[x] ^ not_low) - not_low; /* negated if not_low */

            many[x] |= not_low & not_high;
            word[x] |= ((uint32_t)field & ((1u << SC_CELL_FIELD_BITS) - 1))
                       << sc_cell_field_shift(i);
        }
    }
    for (int x = 0; x < SC_BRICK; x++)
        out[x] =
            words[0][x] | (uint64_t)words[1][x] << SC_CELL_WORD_BITS | (many[x] ? SC_CELL_MANY : 0);
}

/* @return the cells of brick @p brick (x, y, z) that reach across the border of the volume, as
 * bits. Kernels handle such cells one by one. */
static uint64_t border_cells(const sc_prepared *v, const int brick[3])
{
    static const uint64_t lowest[3] = {SC_BRICK_LOW_X, SC_BRICK_LOW_Y, SC_BRICK_LOW_Z};
    uint64_t bits = 0;

    for (int i = 0; i < 3; i++) {
        const int last = v->size[i] - brick[i] * SC_BRICK; /* where the last cells are */

        if (brick[i] == 0)
            bits |= lowest[i];
        if (last >= 0 && last < SC_BRICK)
            bits |= lowest[i] << (last << (i * SC_BRICK_SHIFT));
    }
    return bits;
}

/* Does tissue end at a corner of the cell @p q, which reaches across the border of the volume? */
static bool has_end(const sc_prepared *v, const int q[3])
{
    for (int i = 0; i < 8; i++) {
        const int x = q[0] + (i & 1), y = q[1] + (i >> 1 & 1), z = q[2] + (i >> 2);
        const bool outside =
            x < 1 || y < 1 || z < 1 || x > v->size[0] || y > v->size[1] || z > v->size[2];

        if (outside && sc_end_at_vertex(v, x, y, z))
            return true;
    }
    return false;
}

/* @return what is set of a packed cell at @p bit of a brick, if it reaches across the border of the
 * volume. @param low the lowest vertex of the brick. */
static uint64_t flags_at_border(const sc_prepared *v, const int low[3], int bit)
{
    const int q[3] = {low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit), low[2] + sc_bit_z(bit)};

    return SC_CELL_MANY | (has_end(v, q) ? SC_CELL_ENDS : 0);
}

/* Write the packed cells of @p mask of brick @p brick (x, y, z) to @p out, one after the other. */
static void pack_brick(const sc_prepared *v, const int brick[3], uint64_t mask, uint64_t *out)
{
    const int low[3] = {brick[0] * SC_BRICK, brick[1] * SC_BRICK, brick[2] * SC_BRICK};
    const uint64_t border = border_cells(v, brick);
    sc_corner_labels labels;
    corner_weights weights;

    sc_corner_labels_fetch(v, low, &labels);
    fetch_all_weights(v, brick, &weights);
    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        unsigned left = (unsigned)(mask >> (row * SC_BRICK)) & SC_BRICK_ROW_BITS;
        uint64_t cells[SC_BRICK];

        if (!left)
            continue;
        pack_row(&labels, &weights, row % SC_BRICK, row / SC_BRICK, cells);
        for (; left; left &= left - 1) {
            const int x = __builtin_ctz(left), bit = row * SC_BRICK + x;

            *out++ = cells[x] | (border >> bit & 1 ? flags_at_border(v, low, bit) : 0);
        }
    }
}

/* Count the cells of bricks [begin, end), a chunk of the array with a frame; an sc_range_fn on a
 * cell_packer. */
static void count_cells(void *user, size_t begin, size_t end, int thread)
{
    const cell_packer *p = user;
    uint64_t count = 0;

    (void)thread;
    for (size_t i = begin; i < end; i++)
        count += sc_count_bits(p->masks[i]);
    p->counts[begin / CHUNK] = count;
}

/* Write the packed cells of bricks [begin, end), a chunk, to their place; an sc_range_fn on a
 * cell_packer. */
static void pack_bricks(void *user, size_t begin, size_t end, int thread)
{
    const cell_packer *p = user;
    uint64_t at = 0;
    int framed[3];

    (void)thread;
    sc_framed_size(p->volume->bricks, framed);
    for (size_t chunk = 0; chunk < begin / CHUNK; chunk++)
        at += p->counts[chunk];
    for (size_t i = begin; i < end; i++) {
        int brick[3];

        p->start[i] = (uint32_t)at;
        if (!p->masks[i])
            continue;
        sc_brick_at(framed, i, brick);
        for (int axis = 0; axis < 3; axis++)
            brick[axis] -= SC_BRICK_FRAME;
        pack_brick(p->volume, brick, p->masks[i], p->cells + at);
        at += sc_count_bits(p->masks[i]);
    }
}

sc_status sc_cells_build(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                         const uint64_t *masks, sc_cells *out)
{
    cell_packer p = {.volume = volume, .masks = masks};
    size_t count = 0, bricks, chunks;
    void *block, *counts = NULL;
    int framed[3];
    sc_status status;

    sc_framed_size(volume->bricks, framed);
    bricks = sc_brick_count(framed);
    chunks = (bricks + CHUNK - 1) / CHUNK;
    SC_TRY(sc_team_alloc(ctx, team, chunks, sizeof *p.counts, &counts));
    p.counts = counts;
    sc_team_for(team, bricks, CHUNK, count_cells, &p);
    for (size_t i = 0; i < chunks; i++)
        count += p.counts[i];
    SC_TRY(sc_team_alloc(ctx, team, bricks, sizeof *p.start, &block));
    p.start = block;
    SC_TRY(sc_team_alloc(ctx, team, count + 1, sizeof *p.cells, &block));
    p.cells = block;
    sc_team_for(team, bricks, CHUNK, pack_bricks, &p);
    *out = (sc_cells){.start = p.start, .cells = p.cells, .count = count};
out:
    sc_team_free(team, counts);
    return status;
}
