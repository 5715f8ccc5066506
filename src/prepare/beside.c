/* SPDX-License-Identifier: BSD-3-Clause */
/* Which vertices of tissue lie beside the background, and which of these at seams, the lines in
 * which the surfaces of two tissues meet. */
#include "internal.h"

enum {
    EDGE = SC_BRICK + 2, /* of the block of vertices that is looked at: the brick, and one around */
    ROWS = EDGE * EDGE,
    ROOM = 8 /* ids that are read for a row of EDGE: sc_copy_ids copies multiples of eight */
};

/* Write the labels of the block around the brick whose lowest vertex is @p low to @p ids, [z and
 * y][x]; vertices outside of the volume get the label of the nearest voxel. */
static void fetch_block(const sc_volume *v, const int low[3], uint16_t ids[ROWS][ROOM])
{
    const int first[3] = {low[0] - 2, low[1] - 2, low[2] - 2}; /* lowest voxel */
    const size_t line = (size_t)v->size[0], layer = line * (size_t)v->size[1];
    bool inside = first[0] + ROOM <= v->size[0];

    for (int i = 0; i < 3; i++)
        inside = inside && first[i] >= 0 && first[i] + EDGE <= v->size[i];
    for (int row = 0; row < ROWS; row++) {
        const int y = first[1] + row % EDGE, z = first[2] + row / EDGE;

        if (inside) {
            sc_copy_ids(v, (size_t)z * layer + (size_t)y * line + (size_t)first[0], ROOM, ids[row]);
            continue;
        }
        for (int x = 0; x < EDGE; x++)
            ids[row][x] = (uint16_t)sc_id_or_nearest(v, first[0] + x, y, z);
    }
}

/* Find the vertices of the brick that carry @p id, by bit, to @p own, and those with such a vertex
 * in the 3 x 3 x 3 around them, to @p around. Take its vertices out of @p left, [z and y] bit x. */
static void find_label(const uint16_t ids[ROWS][ROOM], uint16_t id, uint32_t left[ROWS],
                       uint64_t *own, uint64_t *around)
{
    uint32_t bits[ROWS], spread[ROWS]; /* the label's vertices of a row, and spread along it: bit x
                                          is that of the brick's vertex x */

    *own = *around = 0;
    for (int row = 0; row < ROWS; row++) {
        bits[row] = 0;
        for (int x = 0; x < EDGE; x++)
            bits[row] |= (uint32_t)(ids[row][x] == id) << x;
        left[row] &= ~bits[row];
        spread[row] = (bits[row] | bits[row] >> 1 | bits[row] >> 2) & ((1u << SC_BRICK) - 1);
    }
    for (int z = 0; z < SC_BRICK; z++) {
        for (int y = 0; y < SC_BRICK; y++) {
            const int row = z * EDGE + y, at = sc_brick_bit(0, y, z);
            uint32_t any = 0;

            for (int n = 0; n < 9; n++)
                any |= spread[row + n / 3 * EDGE + n % 3];
            *around |= (uint64_t)any << at;
            *own |= (uint64_t)(bits[row + EDGE + 1] >> 1 & ((1u << SC_BRICK) - 1)) << at;
        }
    }
}

uint64_t sc_beside_background(const sc_volume *v, const int low[3], uint64_t *at_seam)
{
    uint16_t ids[ROWS][ROOM];
    uint32_t left[ROWS];
    uint64_t background = 0, beside_background = 0, beside_tissue = 0;

    fetch_block(v, low, ids);
    for (int row = 0; row < ROWS; row++)
        left[row] = (1u << EDGE) - 1;
    for (int row = 0; row < ROWS; row++) {
        while (left[row]) {
            const uint16_t id = ids[row][__builtin_ctz(left[row])];
            uint64_t own, around;

            find_label((const uint16_t(*)[ROOM])ids, id, left, &own, &around);
            if (id == 0) {
                background = own;
                beside_background = around;
            } else {
                beside_tissue |= around & ~own; /* another one than their own */
            }
        }
    }
    beside_background &= ~background;
    *at_seam = beside_background & beside_tissue;
    return beside_background;
}
