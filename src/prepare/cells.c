/* SPDX-License-Identifier: BSD-3-Clause */
/* Packing of the visible cells for the smooth surface: labels and weights of the eight corners of a
 * cell in eight bytes, cells side by side in memory. From these alone a kernel finds whether a ray
 * crosses an interface in a cell, which in most cells it does not. */
#include "segcast/prepare.h"

#include <string.h>

enum { SIDE = SC_BRICK + 1, VERTICES = SIDE * SIDE * SIDE };

/* What the packing threads share. The arrays are as of sc_cells and sc_visible_cells. */
typedef struct cell_packer {
    const sc_prepared *volume;
    const uint64_t *masks; /* which cells to pack */
    uint32_t *start;       /* filled before packing begins */
    uint64_t *cells;       /* filled by pack_bricks */
} cell_packer;

/* Labels and weights of the vertices that are corners of a brick's cells: those of the brick, and
 * the first layer of those after it along each axis. Arrays are [z][y][x]. */
typedef struct brick_corners {
    uint16_t labels[VERTICES]; /* dense ids */
    uint8_t weights[VERTICES]; /* 0 for vertices that are not near an interface */
} brick_corners;

/* @return the index, in the arrays of brick_corners, of the vertex of a bit. @param at x, y, z of
 * its brick's lowest vertex in them: 0 or SC_BRICK each. */
static inline int box_index(const int at[3], int bit)
{
    return ((at[2] + sc_bit_z(bit)) * SIDE + at[1] + sc_bit_y(bit)) * SIDE + at[0] + sc_bit_x(bit);
}

/* Write the weights of those vertices of brick (x, y, z) that are corners of the cells to be packed
 * to out->weights, which must be zeroed before; see box_index for @p at. Of a brick whose at is
 * SC_BRICK along an axis, only the lowest layer is wanted. Bricks beyond the last have no vertices.
 */
static void fetch_weights(const sc_prepared *v, int x, int y, int z, const int at[3],
                          brick_corners *out)
{
    const size_t brick = sc_brick_index(v->bricks, x, y, z);
    uint64_t wanted = ~0ull;

    if (x >= v->bricks[0] || y >= v->bricks[1] || z >= v->bricks[2])
        return;
    wanted &= at[0] ? SC_BRICK_LOW_X : ~0ull;
    wanted &= at[1] ? SC_BRICK_LOW_Y : ~0ull;
    wanted &= at[2] ? SC_BRICK_LOW_Z : ~0ull;
    for (uint64_t left = v->near[brick] & wanted; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const size_t index = v->near_start[brick] + sc_brick_rank(v->near[brick], bit);

        out->weights[box_index(at, bit)] =
            (uint8_t)sc_record_weight(sc_record_read(v->records, index));
    }
}

/* Fill both arrays of @p out for brick @p brick (x, y, z; without a frame). */
static void fetch_corners(const sc_prepared *v, const int brick[3], brick_corners *out)
{
    int n = 0;

    memset(out->weights, 0, sizeof out->weights);
    for (int i = 0; i < 8; i++) {
        const int at[3] = {i & 1 ? SC_BRICK : 0, i & 2 ? SC_BRICK : 0, i & 4 ? SC_BRICK : 0};

        fetch_weights(v, brick[0] + (i & 1), brick[1] + (i >> 1 & 1), brick[2] + (i >> 2), at, out);
    }
    for (int z = 0; z < SIDE; z++) {
        for (int y = 0; y < SIDE; y++) {
            for (int x = 0; x < SIDE; x++, n++)
                out->labels[n] = (uint16_t)sc_id_at_vertex(
                    v, brick[0] * SC_BRICK + x, brick[1] * SC_BRICK + y, brick[2] * SC_BRICK + z);
        }
    }
}

/* @return the packed cell (brick.h) whose lowest vertex has index @p first in the arrays. */
static uint64_t pack_cell(const brick_corners *c, int first)
{
    static const int corner[8] = {0,
                                  1,
                                  SIDE,
                                  SIDE + 1,
                                  SIDE * SIDE,
                                  SIDE * SIDE + 1,
                                  SIDE * SIDE + SIDE,
                                  SIDE * SIDE + SIDE + 1};
    uint32_t low = UINT16_MAX, high = 0;
    uint64_t out = 0;

    for (int i = 0; i < 8; i++) {
        const uint32_t label = c->labels[first + corner[i]];

        low = label < low ? label : low;
        high = label > high ? label : high;
    }
    for (int i = 0; i < 8; i++) {
        const uint32_t label = c->labels[first + corner[i]];
        const int weight = c->weights[first + corner[i]];
        const uint64_t field =
            (uint64_t)(label == low ? weight : -weight) & ((1u << SC_CELL_FIELD_BITS) - 1);

        out |= field << (SC_CELL_WORD_BITS * sc_cell_field_word(i) + sc_cell_field_shift(i));
        if (label != low && label != high)
            out |= SC_CELL_MANY;
    }
    return out;
}

/* Does the cell of a bit of brick @p brick (x, y, z) reach across the border of the volume? Kernels
 * handle such cells one by one. */
static bool is_at_border(const sc_prepared *v, const int brick[3], int bit)
{
    const int q[3] = {brick[0] * SC_BRICK + sc_bit_x(bit), brick[1] * SC_BRICK + sc_bit_y(bit),
                      brick[2] * SC_BRICK + sc_bit_z(bit)};

    for (int i = 0; i < 3; i++) {
        if (q[i] == 0 || q[i] == v->size[i])
            return true;
    }
    return false;
}

/* Write the packed cells of bricks [begin, end) of the array with a frame to their place in cells;
 * an sc_range_fn on a cell_packer. */
static void pack_bricks(void *user, size_t begin, size_t end, int thread)
{
    const cell_packer *p = user;
    static const int first[3] = {0, 0, 0};
    int framed[3];

    (void)thread;
    sc_framed_size(p->volume->bricks, framed);
    for (size_t i = begin; i < end; i++) {
        uint64_t *out = p->cells + p->start[i];
        brick_corners corners;
        int brick[3];

        if (!p->masks[i])
            continue;
        sc_brick_at(framed, i, brick);
        for (int axis = 0; axis < 3; axis++)
            brick[axis] -= SC_BRICK_FRAME;
        fetch_corners(p->volume, brick, &corners);
        for (uint64_t left = p->masks[i]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);

            *out++ = pack_cell(&corners, box_index(first, bit)) |
                     (is_at_border(p->volume, brick, bit) ? SC_CELL_MANY : 0);
        }
    }
}

sc_status sc_cells_build(const sc_ctx *ctx, const sc_prepared *volume, const uint64_t *masks,
                         int threads, sc_cells *out)
{
    cell_packer p = {.volume = volume, .masks = masks};
    size_t count = 0, bricks;
    int framed[3];
    void *block = NULL;
    sc_status status;

    sc_framed_size(volume->bricks, framed);
    bricks = sc_brick_count(framed);
    SC_TRY(sc_alloc(ctx, bricks, sizeof *p.start, &block));
    p.start = block;
    for (size_t i = 0; i < bricks; i++) {
        p.start[i] = (uint32_t)count;
        count += sc_count_bits(masks[i]);
    }
    SC_TRY(sc_alloc(ctx, count + 1, sizeof *p.cells, &block));
    p.cells = block;
    sc_parallel_for(threads, bricks, 4096, pack_bricks, &p);
    *out = (sc_cells){.start = p.start, .cells = p.cells, .count = count};
    p.start = NULL;
out:
    sc_free(p.start);
    return status;
}

void sc_cells_clear(sc_cells *cells)
{
    sc_free(cells->start);
    sc_free(cells->cells);
    *cells = (sc_cells){0};
}
