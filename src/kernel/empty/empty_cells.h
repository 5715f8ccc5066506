/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: distances of single cells, for the skip methods proximity and chessboard. */
#ifndef SC_KERNEL_EMPTY_CELLS_H
#define SC_KERNEL_EMPTY_CELLS_H

#include "empty/empty.h"

/* Nothing needs to be remembered. */
typedef struct v_place {
    char unused;
} v_place;

static inline v_place v_first_place(void)
{
    return (v_place){0};
}

/* Distances of the cells @p at; 0 in lanes outside of @p on. The 64 cells of a brick stand side by
 * side, so that a ray finds several in one line of the cache. */
static inline vi v_cell_distance(const sc_march *m, const vi at[3], vm on)
{
    const vi brick = v_framed_index(m->marked.row, m->marked.layer, at[0], at[1], at[2]);
    const vi cell = (at[0] & SC_BRICK_MASK) | (at[1] & SC_BRICK_MASK) << SC_BRICK_Y_SHIFT |
                    (at[2] & SC_BRICK_MASK) << SC_BRICK_Z_SHIFT;

    return i_gather(m->marked.cell_distances, brick * SC_BRICK_VERTICES + cell, on) & 255;
}

#endif
