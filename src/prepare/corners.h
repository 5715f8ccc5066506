/* SPDX-License-Identifier: BSD-3-Clause */
/* What the two fields say of all corners of a brick's cells, side by side in memory. */
#ifndef SC_CORNERS_H
#define SC_CORNERS_H

#include "segcast/prepare.h"

#include <string.h>

enum {
    SC_CORNERS = SC_BRICK + 1, /* vertices along an edge: those of the brick, and the first layer of
                                  the next */
    SC_CORNER_ROW = 8,         /* room for a row of them: two vectors of four */
    SC_CORNER_AHEAD = 64       /* ids, further along x, that are called into the cache: the rows of
                                  a brick are more streams than processors follow by themselves */
};

/* A number for each corner, [z][y][x]; what lies beyond SC_CORNERS in a row is of no use. Of 32
 * bits each, because then compilers compute with four at a time on any processor. */
typedef int32_t sc_corner_rows[SC_CORNERS][SC_CORNERS][SC_CORNER_ROW];

/* See sc_vertex. */
typedef struct sc_corner_fields {
    sc_corner_rows tissue, outer, inner;
} sc_corner_fields;

/* Write the dense ids of the corners of the brick whose lowest vertex is @p low to @p out; outside
 * of the volume those of the nearest voxels. Ids are copied before they are widened: compilers must
 * assume that bytes in memory change with any store. */
static inline void sc_corner_ids_fetch(const sc_prepared *v, const int low[3], sc_corner_rows out)
{
    const size_t nx = (size_t)v->size[0], plane = nx * (size_t)v->size[1];
    const size_t voxels = plane * (size_t)v->size[2];
    const bool inside = low[0] > 0 && low[1] > 0 && low[2] > 0 && low[0] + SC_BRICK <= v->size[0] &&
                        low[1] + SC_BRICK <= v->size[1] && low[2] + SC_BRICK <= v->size[2];

    for (int row = 0; row < SC_CORNERS * SC_CORNERS; row++) {
        const int y = row % SC_CORNERS, z = row / SC_CORNERS;
        int32_t *to = out[z][y];
        const size_t from = inside ? (size_t)(low[2] + z - 1) * plane +
                                         (size_t)(low[1] + y - 1) * nx + (size_t)(low[0] - 1)
                                   : voxels;

        if (from + SC_CORNER_ROW > voxels) {
            for (int x = 0; x < SC_CORNERS; x++)
                to[x] = (int32_t)sc_id_near_vertex(v, low[0] + x, low[1] + y, low[2] + z);
            for (int x = SC_CORNERS; x < SC_CORNER_ROW; x++)
                to[x] = 0;
        } else if (v->label_bytes == 1) {
            uint8_t ids[SC_CORNER_ROW];

            __builtin_prefetch((const uint8_t *)v->ids + from + SC_CORNER_AHEAD);
            memcpy(ids, (const uint8_t *)v->ids + from, sizeof ids);
            for (int x = 0; x < SC_CORNER_ROW; x++)
                to[x] = ids[x];
        } else {
            uint16_t ids[SC_CORNER_ROW];

            __builtin_prefetch((const uint16_t *)v->ids + from + SC_CORNER_AHEAD);
            memcpy(ids, (const uint16_t *)v->ids + from, sizeof ids);
            for (int x = 0; x < SC_CORNER_ROW; x++)
                to[x] = ids[x];
        }
    }
}

/* Put what the records of a field say of those vertices of brick (x, y, z) that are corners to @p
 * values and out->tissue. @param at where its lowest vertex stands in the arrays: SC_BRICK along an
 * axis along which only the lowest layer is wanted, else 0. */
static inline void sc_corner_records_fetch(const sc_prepared *v, const sc_border *b,
                                           const int brick[3], const int at[3],
                                           sc_corner_rows values, sc_corner_fields *out)
{
    const size_t index = sc_brick_index(v->bricks, brick[0], brick[1], brick[2]);
    const uint64_t mask = b->masks[index];
    const uint64_t wanted = mask & (at[0] ? SC_BRICK_LOW_X : ~0ull) &
                            (at[1] ? SC_BRICK_LOW_Y : ~0ull) & (at[2] ? SC_BRICK_LOW_Z : ~0ull);
    uint32_t next = b->start[index]; /* of the records, if all are wanted */

    for (uint64_t left = wanted; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const int x = sc_bit_x(bit), y = sc_bit_y(bit), z = sc_bit_z(bit);
        const uint32_t record =
            b->records[wanted == mask ? next++ : b->start[index] + sc_brick_rank(mask, bit)];
        const int code = sc_record_tissue(record);

        values[at[2] + z][at[1] + y][at[0] + x] = sc_record_value(record);
        if (code != SC_TISSUE_OWN)
            out->tissue[at[2] + z][at[1] + y][at[0] + x] =
                (int32_t)sc_id_near_vertex(v, brick[0] * SC_BRICK + x + sc_tissue_step(code, 0),
                                           brick[1] * SC_BRICK + y + sc_tissue_step(code, 1),
                                           brick[2] * SC_BRICK + z + sc_tissue_step(code, 2));
    }
}

/* Fill @p out for brick @p brick (x, y, z; without a frame). Any thread. */
static inline void sc_corner_fields_fetch(const sc_prepared *v, const int brick[3],
                                          sc_corner_fields *out)
{
    const int low[3] = {brick[0] * SC_BRICK, brick[1] * SC_BRICK, brick[2] * SC_BRICK};

    sc_corner_ids_fetch(v, low, out->tissue);
    for (int row = 0; row < SC_CORNERS * SC_CORNERS; row++) {
        const int y = row % SC_CORNERS, z = row / SC_CORNERS;

        for (int x = 0; x < SC_CORNER_ROW; x++) {
            out->outer[z][y][x] = out->tissue[z][y][x] ? SC_VALUE_MAX : -SC_VALUE_MAX;
            out->inner[z][y][x] = SC_VALUE_MAX;
        }
    }
    for (int i = 0; i < 8; i++) {
        const int next[3] = {brick[0] + (i & 1), brick[1] + (i >> 1 & 1), brick[2] + (i >> 2)};
        const int at[3] = {i & 1 ? SC_BRICK : 0, i & 2 ? SC_BRICK : 0, i & 4 ? SC_BRICK : 0};

        if (next[0] >= v->bricks[0] || next[1] >= v->bricks[1] || next[2] >= v->bricks[2])
            continue;
        sc_corner_records_fetch(v, &v->outer, next, at, out->outer, out);
        sc_corner_records_fetch(v, &v->inner, next, at, out->inner, out);
    }
}

/* @return the cells of brick @p brick (x, y, z) that reach across the border of the volume, as
 * bits. */
static inline uint64_t sc_border_cells(const sc_prepared *v, const int brick[3])
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

#endif
