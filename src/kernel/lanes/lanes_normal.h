/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: normal.h for one point per SIMD lane, with the same bits; see lanes_cell.h. */
#ifndef SC_KERNEL_LANES_NORMAL_H
#define SC_KERNEL_LANES_NORMAL_H

#include "lanes/lanes_cell.h"
#include "normal.h"

/* The normals at the points @p a of the cells @p q, in RAS, to @p n, not of unit length, as
 * sc_cell_normal finds them, for cells that are packed (sc_packed_cell). @param values of these.
 * @param at_background the lanes with cells of the first kind. @param upward the lanes in which the
 * label entered is the higher one. */
static inline void v_cell_normal(const sc_prepared *v, const vi q[3], const vi values[2],
                                 vm at_background, vm upward, const vf a[3], vm on, vf n[3])
{
    const vm outer = m_and(on, at_background), inner = m_without(on, at_background);
    const vm flipped = m_or(m_without(outer, upward), m_and(inner, upward));
    const vi flip = i_pick(flipped, i_set(INT32_MIN), i_set(0));
    const vi own = i_pick(inner, i_set(INT32_MIN), i_set(0));
    vi records[SC_CORNERS];

    v_cell_records(v, q, outer, on, records);
    for (int k = 0; k < 3; k++)
        n[k] = f_set(0);
    for (int i = 0; i < SC_CORNERS; i++) {
        /* The sign of the value tells which of the two tissues the corner has. */
        const vi sign = values[i / SC_CELL_WORD_CORNERS]
                        << (32 - SC_CELL_VALUE_BITS * (i % SC_CELL_WORD_CORNERS + 1));
        const vf weight = (vf)((vi)v_corner_share(i, a) ^ (sign & own) ^ flip);
        vf octant[3], share;

        v_record_octant(records[i], octant);
        share = weight * v_record_eighths(records[i]) / f_length(octant);
        for (int k = 0; k < 3; k++)
            n[k] += share * octant[k];
    }
}

#endif
