/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: brick.h for MARCH_LANES vertices side by side. Lanes have 32 bits, so that a
 * mask is read as two halves of 32 bits, the lower for z of 0 and 1 within the brick, the upper for
 * 2 and 3. Coordinates x, y and z are those of grid vertices (or cells). In all functions @p on are
 * the lanes in use: others read no memory. */
#ifndef SC_KERNEL_LANES_BRICK_H
#define SC_KERNEL_LANES_BRICK_H

#include "lanes/lanes.h"

#include "segcast/brick.h"

/* The number, 0 to 31, of the bit of a vertex in the half of its brick's mask that holds it. */
static inline vi v_half_bit(vi x, vi y, vi z)
{
    return (x & SC_BRICK_MASK) | (y & SC_BRICK_MASK) << SC_BRICK_Y_SHIFT |
           (z & SC_BRICK_HALF_MASK) << SC_BRICK_Z_SHIFT;
}

/* The half, of the mask of brick number @p brick, that holds the vertices at @p z; 0 in lanes
 * outside of @p on. */
static inline vi v_half_mask(const uint64_t *masks, vi brick, vi z, vm on)
{
    return i_gather(masks,
                    brick * SC_BRICK_MASK_BYTES +
                        (z & SC_BRICK_HALF) * (SC_BRICK_HALF_BYTES / SC_BRICK_HALF),
                    on);
}

/* Lanes of @p on in whose half mask bit number @p half_bit (of v_half_bit) is set. */
static inline vm v_bit_set(vi half_mask, vi half_bit, vm on)
{
    return m_without(on, i_equal((vi)((vu)half_mask >> (vu)half_bit) & 1, i_set(0)));
}

/* Index of the brick that holds a vertex, in an array [bricks[2]][bricks[1]][bricks[0]] without
 * a frame. */
static inline vi v_brick_index(const int bricks[3], vi x, vi y, vi z)
{
    return ((z >> SC_BRICK_SHIFT) * bricks[1] + (y >> SC_BRICK_SHIFT)) * bricks[0] +
           (x >> SC_BRICK_SHIFT);
}

/* The same in an array with a frame of empty bricks, whose steps along y and z are @p row and @p
 * layer; see sc_framed_index. */
static inline vi v_framed_index(int row, int layer, vi x, vi y, vi z)
{
    return (z >> SC_BRICK_SHIFT) * layer + (y >> SC_BRICK_SHIFT) * row + (x >> SC_BRICK_SHIFT) +
           SC_BRICK_FRAME * (layer + row + 1);
}

/* Index, in an array packed in the order of bricks and bits, of what is kept of a vertex: @p
 * start of its brick plus the number of bits set before its own. 0 in lanes outside of @p on.
 * @param brick of the vertex. @param bit of v_half_bit. @param half is set to the half mask that
 * holds the vertex, for v_bit_set. */
static inline vi v_packed_index(const uint64_t *masks, const uint32_t *start, vi brick, vi bit,
                                vi z, vm on, vi *half)
{
    const vi low = i_gather(masks, brick * SC_BRICK_MASK_BYTES, on);
    const vi high = i_gather(masks, brick * SC_BRICK_MASK_BYTES + SC_BRICK_HALF_BYTES, on);
    const vm upper = i_equal(z & SC_BRICK_HALF, i_set(SC_BRICK_HALF));
    vi rank;

    *half = i_pick(upper, high, low);
    rank =
        i_count_bits(*half & ((i_set(1) << bit) - 1)) + i_pick(upper, i_count_bits(low), i_set(0));
    return i_gather(start, brick * (int)sizeof *start, on) + rank;
}

#endif
