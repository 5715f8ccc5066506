/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the skip method octree: a pyramid of binary volumes, in which a cell of every
 * level says whether anything within it is marked (Levoy 1990, "Efficient ray tracing of volume
 * data", section 3). Where a ray meets an empty cell of the pyramid it steps across it; where it
 * meets another it goes down; when it enters another cell of the level above, it goes up.
 *
 * Masks of 4x4x4 cells hold two levels of the pyramid each: a bit is a cell of the lower one, and 8
 * bits are one of the upper, so that one access to memory decides about both, and rays go up and
 * down by two levels. A parametric descent (Revelles, Urena and Lastra 2000) would find the part of
 * a cell that a ray is in from the distances of the planes that divide it; here it stands in the
 * bits of the place, which the walk keeps in whole numbers. */
#ifndef SC_KERNEL_EMPTY_OCTREE_H
#define SC_KERNEL_EMPTY_OCTREE_H

#include "empty/empty.h"

enum { EMPTY_IS_BALL = 0 };

/* The 2x2x2 cells of a mask's half that are one cell of the level above, at its lowest bit. */
#define OCTANT_BITS 0x00330033u

/* The masks that were looked at last, and where. */
typedef struct v_place {
    vi level, at[3];
} v_place;

static inline v_place v_first_place(void)
{
    return (v_place){.level = i_set(SC_PYRAMID_LEVELS - 1)};
}

/* The halves, of the masks of level @p level that hold the cells @p at, which hold these cells; 0
 * in lanes outside of @p on. @param in_level the cells in units of the level. */
static inline vi v_pyramid_half(const sc_march *m, vi level, const vi at[3], vm on, vi in_level[3])
{
    const sc_pyramid *y = m->marked.pyramid;
    vi node;

    for (int i = 0; i < 3; i++)
        in_level[i] = at[i] >> level * SC_BRICK_SHIFT;
    node = (in_level[2] >> SC_BRICK_SHIFT) * i_of_four(y->layer, level) +
           (in_level[1] >> SC_BRICK_SHIFT) * i_of_four(y->row, level) +
           (in_level[0] >> SC_BRICK_SHIFT) + i_of_four(y->origin, level);
    return v_half_mask(m->marked.masks, node, in_level[2], on);
}

static inline v_empty v_look(const sc_march *m, const vi at[3], v_place *place, vm on)
{
    const vi apart = (at[0] ^ place->at[0]) | (at[1] ^ place->at[1]) | (at[2] ^ place->at[2]);
    const vm inside = i_equal(apart >> (place->level + 1) * SC_BRICK_SHIFT, i_set(0));
    const vm up = m_without(i_below(place->level, i_set(SC_PYRAMID_LEVELS - 1)), inside);
    vi level = i_pick(up, place->level + 1, place->level), half = i_set(0), bit = half, size;
    vm looking = on, set, wide;

    while (m_any(looking)) {
        vi in_level[3];
        const vi found = v_pyramid_half(m, level, at, looking, in_level);

        half = i_pick(looking, found, half);
        bit = i_pick(looking, v_half_bit(in_level[0], in_level[1], in_level[2]), bit);
        looking = m_and(v_bit_set(half, bit, looking), i_below(i_set(0), level));
        level = i_pick(looking, level - 1, level);
    }
    set = v_bit_set(half, bit, on);
    /* Of the bit's number in its half those parts are kept that say which octant it is in. */
    wide = i_equal((vi)((vu)half >> (vu)(bit & (2 | 2 << SC_BRICK_Y_SHIFT))) & (int)OCTANT_BITS,
                   i_set(0));
    size = i_set(1) << (level * SC_BRICK_SHIFT + i_pick(wide, i_set(1), i_set(0)));
    place->level = i_pick(on, level, place->level);
    for (int i = 0; i < 3; i++)
        place->at[i] = at[i];
    return (v_empty){.marked = set,
                     .leaps = m_without(m_and(on, i_below(i_set(1), size)), set),
                     .mask = -size,
                     .ahead = size,
                     .back = i_set(0)};
}

#endif
