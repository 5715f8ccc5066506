/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the skip method proximity: every empty cell holds the city-block distance to
 * the nearest marked one (Cohen and Sheffer 1994, "Proximity clouds - an acceleration technique for
 * 3D grid traversal"). A ray that crosses as many grid planes as that reaches a marked cell at the
 * earliest. */
#ifndef SC_KERNEL_EMPTY_PROXIMITY_H
#define SC_KERNEL_EMPTY_PROXIMITY_H

#include "empty/empty_cells.h"

enum { EMPTY_IS_BALL = 1 };

static inline v_empty v_look(const sc_march *m, const vi at[3], v_place *place, vm on)
{
    const vi far = v_cell_distance(m, at, on);

    return (v_empty){.marked = m_and(on, i_equal(far, i_set(0))),
                     .leaps = m_and(on, i_below(i_set(1), far)),
                     .ahead = far};
}

#endif
