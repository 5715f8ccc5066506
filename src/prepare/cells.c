/* SPDX-License-Identifier: BSD-3-Clause */
/* Packing of the visible cells for the smooth surface: what the fields say at the eight corners of
 * a cell in twelve bytes, cells side by side in memory. From these alone a kernel finds whether a
 * ray crosses a border in a cell, which in most cells it does not. */
#include "corners.h"

#include <string.h>

/* What the packing threads share. The arrays are as of sc_cells and sc_visible_cells. */
typedef struct cell_packer {
    const sc_prepared *volume;
    const uint64_t *masks; /* which cells to pack */
    uint64_t *counts;      /* of the team: cells of each chunk of bricks */
    uint32_t *start;
    sc_packed_cell *cells;
} cell_packer;

enum { CHUNK = 4096 /* bricks that a thread claims at a time */ };

static inline int32_t lesser(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t greater(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/* What the rows of corners of four cells say, side by side: compilers compute with all of them at a
 * time. */
typedef struct row_labels {
    int32_t low[SC_BRICK], high[SC_BRICK]; /* the least and the largest tissue */
    int32_t other[SC_BRICK];               /* not 0: a corner has another one, or none */
    int32_t background[SC_BRICK];          /* not 0: a corner is on the side of the background */
} row_labels;

/* @return a tissue; larger than all if there is none: then the corner has no vote. */
static inline int32_t some_tissue(int32_t tissue)
{
    return tissue ? tissue : INT32_MAX;
}

/* Find @p out of the cells whose corners stand in the rows @p tissue and @p outer. */
static void find_labels(const int32_t *const tissue[4], const int32_t *const outer[4],
                        row_labels *out)
{
    int32_t least[SC_CORNER_ROW], most[SC_CORNER_ROW], sign[SC_CORNER_ROW];

    for (int x = 0; x < SC_CORNER_ROW; x++) {
        least[x] = lesser(lesser(some_tissue(tissue[0][x]), some_tissue(tissue[1][x])),
                          lesser(some_tissue(tissue[2][x]), some_tissue(tissue[3][x])));
        most[x] = greater(greater(tissue[0][x], tissue[1][x]), greater(tissue[2][x], tissue[3][x]));
        sign[x] = outer[0][x] | outer[1][x] | outer[2][x] | outer[3][x];
    }
    for (int x = 0; x < SC_BRICK; x++) {
        out->low[x] = lesser(least[x], least[x + 1]);
        out->high[x] = greater(most[x], most[x + 1]);
        out->background[x] = (sign[x] | sign[x + 1]) < 0;
        out->other[x] = 0;
    }
    for (int i = 0; i < 8; i++) {
        const int32_t *label = tissue[i >> 1] + (i & 1);

        for (int x = 0; x < SC_BRICK; x++)
            out->other[x] |= (label[x] != out->low[x]) & (label[x] != out->high[x]);
    }
}

/* A general cell of which nothing can be told. */
static const sc_packed_cell all_tissue = {{0x81818181u, 0x81818181u}, 0};
_Static_assert((int8_t)0x81 == -SC_VALUE_MAX, "all corners lie on the side of tissue");

/* Write the packed cells (brick.h) of row (y, z) of a brick to @p out. Those on one side are taken
 * for cells between tissues, all others for such at the background. */
static void pack_row(const sc_corner_fields *f, int y, int z, sc_packed_cell out[SC_BRICK])
{
    const int32_t *tissue[4], *outer[4], *inner[4];
    uint32_t words[2][SC_BRICK] = {{0}};
    row_labels labels;

    for (int i = 0; i < 4; i++) {
        tissue[i] = f->tissue[z + (i >> 1)][y + (i & 1)];
        outer[i] = f->outer[z + (i >> 1)][y + (i & 1)];
        inner[i] = f->inner[z + (i >> 1)][y + (i & 1)];
    }
    find_labels(tissue, outer, &labels);
    for (int i = 0; i < 8; i++) {
        const int32_t *label = tissue[i >> 1] + (i & 1);
        const int32_t *side = outer[i >> 1] + (i & 1), *vote = inner[i >> 1] + (i & 1);
        uint32_t *word = words[i / SC_CELL_WORD_CORNERS];

        for (int x = 0; x < SC_BRICK; x++) {
            const int32_t own = label[x] == labels.low[x] ? vote[x] : -vote[x];
            const int32_t value = labels.background[x] ? -side[x] : own;

            word[x] |= ((uint32_t)value & ((1u << SC_CELL_VALUE_BITS) - 1))
                       << (SC_CELL_VALUE_BITS * (i % SC_CELL_WORD_CORNERS));
        }
    }
    for (int x = 0; x < SC_BRICK; x++) {
        const uint32_t low = (uint32_t)labels.low[x], high = (uint32_t)labels.high[x];

        if (labels.background[x])
            out[x] = (sc_packed_cell){{words[0][x], words[1][x]},
                                      low == high ? high << SC_CELL_LABEL_BITS : 0};
        else if (low < high && !labels.other[x])
            out[x] = (sc_packed_cell){{words[0][x], words[1][x]}, low | high << SC_CELL_LABEL_BITS};
        else
            out[x] = all_tissue;
    }
}

/* Write the packed cells of @p mask of brick @p brick (x, y, z) to @p out, one after the other. */
static void pack_brick(const sc_prepared *v, const int brick[3], uint64_t mask, sc_packed_cell *out)
{
    const uint64_t border = sc_border_cells(v, brick);
    sc_corner_fields fields;

    sc_corner_fields_fetch(v, brick, &fields);
    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        unsigned left = (unsigned)(mask >> (row * SC_BRICK)) & SC_BRICK_ROW_BITS;
        sc_packed_cell cells[SC_BRICK];

        if (!left)
            continue;
        pack_row(&fields, row % SC_BRICK, row / SC_BRICK, cells);
        for (; left; left &= left - 1) {
            const int x = __builtin_ctz(left);

            *out++ = border >> (row * SC_BRICK + x) & 1 ? all_tissue : cells[x];
        }
    }
}

/* Count the cells of bricks [begin, end), a chunk of the array with a frame; an sc_range_fn on a
 * cell_packer. */
static void count_cells(void *user, size_t begin, size_t end, int thread)
{
    const cell_packer *p = user;
    uint64_t count = 0;

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
