/* SPDX-License-Identifier: BSD-3-Clause */
/* The labels of all corners of a brick's cells, side by side in memory. */
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

/* Dense ids [z][y][x]; what lies beyond SC_CORNERS in a row is of no use. Of 32 bits each, because
 * then compilers compute with four at a time on any processor. */
typedef struct sc_corner_labels {
    int32_t at[SC_CORNERS][SC_CORNERS][SC_CORNER_ROW];
} sc_corner_labels;

/* Fill @p out for the brick whose lowest vertex is @p low. Any thread. Ids are copied before they
 * are widened: compilers must assume that bytes in memory change with any store. */
static inline void sc_corner_labels_fetch(const sc_prepared *v, const int low[3],
                                          sc_corner_labels *out)
{
    const size_t nx = (size_t)v->size[0], plane = nx * (size_t)v->size[1];
    const size_t voxels = plane * (size_t)v->size[2];
    const bool inside = low[0] > 0 && low[1] > 0 && low[2] > 0 && low[0] + SC_BRICK <= v->size[0] &&
                        low[1] + SC_BRICK <= v->size[1] && low[2] + SC_BRICK <= v->size[2];

    for (int row = 0; row < SC_CORNERS * SC_CORNERS; row++) {
        const int y = row % SC_CORNERS, z = row / SC_CORNERS;
        int32_t *to = out->at[z][y];
        const size_t from = inside ? (size_t)(low[2] + z - 1) * plane +
                                         (size_t)(low[1] + y - 1) * nx + (size_t)(low[0] - 1)
                                   : voxels;

        if (from + SC_CORNER_ROW > voxels) {
            for (int x = 0; x < SC_CORNERS; x++)
                to[x] = (int32_t)sc_id_at_vertex(v, low[0] + x, low[1] + y, low[2] + z);
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

#endif
