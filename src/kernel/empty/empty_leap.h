/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the skip method leap. A brick of 4x4x4 cells is one mask of 64 bits, and of
 * each empty one the chessboard distance in bricks to the nearest that is not is known: all bricks
 * less far away are empty. So the distances of a large volume are few and stay in the caches. */
#ifndef SC_KERNEL_EMPTY_LEAP_H
#define SC_KERNEL_EMPTY_LEAP_H

#include "empty/empty.h"

enum { EMPTY_IS_BALL = 0 };

/* Nothing needs to be remembered. */
typedef struct v_place {
    char unused;
} v_place;

static inline v_place v_first_place(void)
{
    return (v_place){0};
}

static inline v_empty v_look(const sc_march *m, const vi at[3], v_place *place, vm on)
{
    const vi brick = v_framed_index(m->marked.row, m->marked.layer, at[0], at[1], at[2]);
    const vi far = i_gather(m->marked.distances, brick, on) & 255;
    const vi half = v_half_mask(m->marked.masks, brick, at[2], on);
    const vm leaps = m_and(on, i_below(i_set(0), far));

    return (v_empty){.marked = v_bit_set(half, v_half_bit(at[0], at[1], at[2]), on),
                     .leaps = leaps,
                     .mask = i_pick(leaps, i_set(~SC_BRICK_MASK), i_set(-1)),
                     .ahead = i_pick(leaps, far * SC_BRICK, i_set(1)),
                     .back = i_pick(leaps, (1 - far) * SC_BRICK, i_set(0))};
}

#endif
