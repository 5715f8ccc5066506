/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the skip method chessboard: as proximity, with the chessboard distance, by
 * which what is empty is a cube, so that a ray steps to where it leaves that (Sramek 1994, "Fast
 * surface rendering from raster data by voxel traversal using chessboard distance"). */
#ifndef SC_KERNEL_EMPTY_CHESSBOARD_H
#define SC_KERNEL_EMPTY_CHESSBOARD_H

#include "empty/empty_cells.h"

enum { EMPTY_IS_BALL = 0 };

static inline v_empty v_look(const sc_march *m, const vi at[3], v_place *place, vm on)
{
    const vi far = v_cell_distance(m, at, on);

    return (v_empty){.marked = m_and(on, i_equal(far, i_set(0))),
                     .leaps = m_and(on, i_below(i_set(1), far)),
                     .mask = i_set(-1),
                     .ahead = far,
                     .back = 1 - far};
}

#endif
