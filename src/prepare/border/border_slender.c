/* SPDX-License-Identifier: BSD-3-Clause */
/* Where tissue is slender: where no block of three voxels along each axis of its label is near. The
 * fields tell where a border may be smoothed by cells (border_weights.c), but not of thin tissue
 * that lies upon other tissue, as a rib upon the lung: together the two are thick. Labels tell.
 * Noise is not slender, as it is near the tissue that it belongs to. */
#include "border/border.h"

enum {
    SUB = SC_SUB,
    AROUND = SUB + 2, /* voxels along an edge of what blocks with their middle in a cube cover */
    ROW = 8,          /* room for a row of them */
    NEAR = 2,         /* cubes in whose distance a block tells of tissue: 8 to 12 voxels */
    PER_CUBE = SC_CUBE / SUB,
    BEFORE = 2,                   /* cubes before a block that cells are looked at in */
    SPAN = PER_CUBE + 2 * BEFORE, /* cubes along an edge */
    CELLS = SPAN * SUB / 2,       /* cells along it */
    SPARE = BEFORE * SUB / 2 - SC_SLENDER_HALO
};
_Static_assert(SPARE >= 1, "cells beside the outermost ones are known");

/* Note a label of which a block was found. Of more than two any label counts as found. */
static void note(uint16_t found[2], uint16_t id)
{
    if (found[0] == id || found[1] == id)
        return;
    if (!found[0])
        found[0] = id;
    else
        found[1] = found[1] ? SC_NO_LABEL : id;
}

/* @return whether a block of @p id has its middle in the cube in the middle of @p ids. */
static bool has_block(uint16_t ids[AROUND * AROUND][ROW], uint16_t id)
{
    uint32_t rows[AROUND * AROUND], any = 0;

    for (int k = 0; k < AROUND * AROUND; k++) {
        const uint32_t bits = sc_equal_bits(ids[k], id);

        rows[k] = bits & bits >> 1 & bits >> 2;
    }
    for (int k = 0; k + 2 * AROUND + 2 < AROUND * AROUND; k++) {
        uint32_t all = k % AROUND < SUB ? (1u << SUB) - 1 : 0;

        for (int n = 0; n < 9; n++)
            all &= rows[k + n / 3 * AROUND + n % 3];
        any |= all;
    }
    return any;
}

/* Find the tissues of which blocks have their middle in a cube, whose lowest voxel is @p low.
 * @param list of the labels there. */
static void find_blocks_in(const sc_volume *v, const int low[3], const sc_sub_labels *list,
                           uint16_t found[2])
{
    const bool all = list->count <= SC_SUB_LABELS; /* known labels */
    uint16_t ids[AROUND * AROUND][ROW];

    for (int k = 0; k < AROUND * AROUND; k++) {
        const int y = sc_nearest_voxel(low[1] + k % AROUND - 1, v->size[1]);
        const int z = sc_nearest_voxel(low[2] + k / AROUND - 1, v->size[2]);
        const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0];

        if (low[0] >= 1 && low[0] - 1 + ROW <= v->size[0]) {
            sc_volume_read_ids(v, row + (size_t)(low[0] - 1), ROW, ids[k]);
            continue;
        }
        for (int x = 0; x < ROW; x++)
            ids[k][x] = (uint16_t)sc_volume_id(
                v, row + (size_t)sc_nearest_voxel(low[0] + x - 1, v->size[0]));
    }
    for (int i = 0; i < (all ? list->count : SUB * SUB * SUB); i++) {
        const uint16_t id =
            all ? list->ids[i]
                : ids[(i / (SUB * SUB) + 1) * AROUND + i / SUB % SUB + 1][i % SUB + 1];

        if (id && has_block(ids, id))
            note(found, id);
    }
}

/* Find blocks in cubes [begin, end); an sc_range_fn on sc_borders. */
static void find_blocks(void *user, size_t begin, size_t end, int thread)
{
    const sc_borders *b = user;

    for (size_t sub = begin; sub < end; sub++) {
        int low[3];

        sc_brick_at(b->subs.size, sub, low);
        for (int i = 0; i < 3; i++)
            low[i] = low[i] * SUB - b->phase[i];
        if (b->subs.lists[sub].count == 1)
            b->subs.blocks[sub][0] = b->subs.lists[sub].ids[0];
        else
            find_blocks_in(b->p->volume, low, &b->subs.lists[sub], b->subs.blocks[sub]);
    }
}

/* @return whether no block of tissue @p id is near the cube at @p at. */
static bool is_slender(const sc_borders *b, const int at[3], uint16_t id)
{
    int low[3], high[3];

    for (int i = 0; i < 3; i++) {
        low[i] = at[i] > NEAR ? at[i] - NEAR : 0;
        high[i] = at[i] + NEAR < b->subs.size[i] ? at[i] + NEAR : b->subs.size[i] - 1;
    }
    for (int z = low[2]; z <= high[2]; z++) {
        for (int y = low[1]; y <= high[1]; y++) {
            for (int x = low[0]; x <= high[0]; x++) {
                const uint16_t *found = b->subs.blocks[sc_brick_index(b->subs.size, x, y, z)];

                if (found[0] == id || found[1] == id || found[1] == SC_NO_LABEL)
                    return false;
            }
        }
    }
    return true;
}

/* @return whether any of the labels of a cube may be slender there. */
static bool may_be_slender(const sc_borders *b, const int at[3], const sc_sub_labels *list)
{
    bool any = list->count > SC_SUB_LABELS;

    for (int i = 0; i < list->count && list->count > 1 && !any; i++)
        any = list->ids[i] && is_slender(b, at, list->ids[i]);
    return any;
}

/* Mark the cells of the cube at @p at in which there is slender tissue. @param cells of the region
 * around a block, from cell @p first on. */
static void mark_cube(const sc_borders *b, const int at[3], const int first[3],
                      uint8_t cells[CELLS][CELLS][CELLS])
{
    const sc_volume *v = b->p->volume;
    uint16_t last = 0;
    bool slender = false;

    for (int i = 0; i < SUB * SUB * SUB; i++) {
        const int x = i % SUB, y = i / SUB % SUB, z = i / (SUB * SUB);
        const uint16_t id = (uint16_t)sc_id_or_background(v, at[0] * SUB - b->phase[0] + x,
                                                          at[1] * SUB - b->phase[1] + y,
                                                          at[2] * SUB - b->phase[2] + z);

        slender = id && (id == last ? slender : is_slender(b, at, id));
        last = id;
        cells[first[2] + z / 2][first[1] + y / 2][first[0] + x / 2] |= slender;
    }
}

sc_status sc_find_blocks_of_three(const sc_ctx *ctx, sc_borders *b)
{
    void *block;

    SC_PASS(sc_team_alloc(ctx, b->p->team, sc_brick_count(b->subs.size), sizeof *b->subs.blocks,
                          &block));
    b->subs.blocks = block;
    sc_team_for(b->p->team, sc_brick_count(b->subs.size), 1024, find_blocks, b);
    return SC_OK;
}

void sc_find_slender(const sc_borders *b, size_t block, uint8_t out[SC_SLENDER_CELLS])
{
    uint8_t cells[CELLS][CELLS][CELLS];
    int cube[3];
    bool any = false;

    memset(out, 0, SC_SLENDER_CELLS);
    if (b->around[block].tissue < SC_TWO_TISSUES || b->around[block].second == SC_NO_LABEL)
        return;
    memset(cells, 0, sizeof cells);
    sc_brick_at(b->cubes, block, cube);
    for (int n = 0; n < SPAN * SPAN * SPAN; n++) {
        const int place[3] = {n % SPAN, n / SPAN % SPAN, n / (SPAN * SPAN)};
        const int first[3] = {place[0] * SUB / 2, place[1] * SUB / 2, place[2] * SUB / 2};
        int at[3];
        bool within = true;

        for (int i = 0; i < 3; i++) {
            at[i] = cube[i] * PER_CUBE - BEFORE + place[i];
            within = within && at[i] >= 0 && at[i] < b->subs.size[i];
        }
        if (within &&
            may_be_slender(b, at,
                           &b->subs.lists[sc_brick_index(b->subs.size, at[0], at[1], at[2])])) {
            mark_cube(b, at, first, cells);
            any = true;
        }
    }
    for (int i = 0; i < SC_SLENDER_CELLS && any; i++) {
        const int x = i % SC_SLENDER_EDGE + SPARE,
                  y = i / SC_SLENDER_EDGE % SC_SLENDER_EDGE + SPARE,
                  z = i / (SC_SLENDER_EDGE * SC_SLENDER_EDGE) + SPARE;

        for (int n = 0; n < 9; n++) { /* the cell and those around it */
            const uint8_t *row = cells[z + n / 3 - 1][y + n % 3 - 1] + x;

            out[i] |= row[-1] | row[0] | row[1];
        }
    }
}
