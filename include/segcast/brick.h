/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The layout of bricks, vertex records and packed cells: which bit of a mask stands for which
 *  vertex, where a brick stands in an array of bricks, and which bits of a record hold what. All
 *  code that reads or writes one of them uses the constants and functions of this header.
 *
 *  Vertices are those of the label grid, which is one vertex wider than the volume on every side:
 *  vertex q is voxel q - 1. All functions are pure and check nothing. */
#ifndef SEGCAST_BRICK_H
#define SEGCAST_BRICK_H

#include "segcast/geom.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/** A brick: 4x4x4 vertices (or cells, each named by its lowest vertex), one bit each in a 64-bit
 *  mask. The bit of the vertex at (x, y, z) within the brick is x + 4 y + 16 z. The wide kernels
 *  read a mask as two halves of 32 bits, of two layers of vertices each. */
enum {
    SC_BRICK_SHIFT = 2,                    /**< vertex >> SC_BRICK_SHIFT is its brick */
    SC_BRICK = 1 << SC_BRICK_SHIFT,        /**< edge of a brick in vertices */
    SC_BRICK_MASK = SC_BRICK - 1,          /**< vertex & SC_BRICK_MASK: where in its brick */
    SC_BRICK_Y_SHIFT = SC_BRICK_SHIFT,     /**< of y in the bit of a vertex */
    SC_BRICK_Z_SHIFT = 2 * SC_BRICK_SHIFT, /**< of z */
    SC_BRICK_LAYER = SC_BRICK * SC_BRICK,  /**< vertices of one z */
    SC_BRICK_VERTICES = SC_BRICK_LAYER * SC_BRICK,
    SC_BRICK_FRAME = 1, /**< empty bricks on every side of the arrays that have a frame */
    SC_BRICK_MASK_BYTES = 8,
    SC_BRICK_HALF_BYTES = SC_BRICK_MASK_BYTES / 2,
    SC_BRICK_HALF = SC_BRICK / 2,          /**< the bit of z that is set in the upper half */
    SC_BRICK_HALF_MASK = SC_BRICK_HALF - 1 /**< z & SC_BRICK_HALF_MASK: where in its half */
};
#define SC_BRICK_ROW_BITS 0xfu               /**< the vertices of one y and z, at bit 0 */
#define SC_BRICK_LAYER_BITS 0xffffu          /**< the vertices of one z, at bit 0 */
#define SC_BRICK_LOW_X 0x1111111111111111ull /**< the vertices whose x is 0 in the brick */
#define SC_BRICK_LOW_Y 0x000f000f000f000full
#define SC_BRICK_LOW_Z 0x000000000000ffffull
_Static_assert(SC_BRICK_VERTICES == 8 * sizeof(uint64_t), "a brick is one 64-bit mask");

/** @return the coordinate, in bricks, of the brick that holds a vertex, along one axis. Negative
 * coordinates are rounded down too, as GCC and Clang shift them arithmetically. */
static inline int sc_brick_of(int vertex)
{
    return vertex >> SC_BRICK_SHIFT;
}

/** @return the bit, 0 to 63, of the vertex at (x, y, z) of the grid in the mask of its brick. */
static inline int sc_brick_bit(int x, int y, int z)
{
    return (x & SC_BRICK_MASK) | (y & SC_BRICK_MASK) << SC_BRICK_Y_SHIFT |
           (z & SC_BRICK_MASK) << SC_BRICK_Z_SHIFT;
}

/** @return x, 0 to 3, of the vertex of bit @p bit in its brick: the inverse of sc_brick_bit. */
static inline int sc_bit_x(int bit)
{
    return bit & SC_BRICK_MASK;
}

/** As sc_bit_x, for y. */
static inline int sc_bit_y(int bit)
{
    return bit >> SC_BRICK_Y_SHIFT & SC_BRICK_MASK;
}

/** As sc_bit_x, for z. */
static inline int sc_bit_z(int bit)
{
    return bit >> SC_BRICK_Z_SHIFT;
}

/** @return how many bricks cover an edge of @p voxels voxels and one vertex more on either side. */
static inline int sc_bricks_along(int voxels)
{
    return (voxels + 2 + SC_BRICK - 1) / SC_BRICK;
}

/** @return the number of bricks in an array of @p bricks along x, y and z. */
static inline size_t sc_brick_count(const int bricks[3])
{
    return (size_t)bricks[0] * (size_t)bricks[1] * (size_t)bricks[2];
}

/** Index of brick (x, y, z) in an array [bricks z][bricks y][bricks x]. */
static inline size_t sc_brick_index(const int bricks[3], int x, int y, int z)
{
    return ((size_t)z * (size_t)bricks[1] + (size_t)y) * (size_t)bricks[0] + (size_t)x;
}

/** Write the coordinates x, y, z, in bricks, of the brick at @p index of an array without a frame
 *  to @p out: the inverse of sc_brick_index. */
static inline void sc_brick_at(const int bricks[3], size_t index, int out[3])
{
    const size_t bx = (size_t)bricks[0], by = (size_t)bricks[1];

    out[0] = (int)(index % bx);
    out[1] = (int)(index / bx % by);
    out[2] = (int)(index / bx / by);
}

/** Write the grid coordinates x, y, z of the lowest vertex of the brick at @p index (see
 * sc_brick_index) to @p out. */
static inline void sc_brick_low(const int bricks[3], size_t index, int out[3])
{
    sc_brick_at(bricks, index, out);
    for (int i = 0; i < 3; i++)
        out[i] *= SC_BRICK;
}

/** Write the size x, y, z of an array of @p bricks with a frame of empty ones around it,
 *  [bricks z + 2][bricks y + 2][bricks x + 2], to @p out. */
static inline void sc_framed_size(const int bricks[3], int out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = bricks[i] + 2 * SC_BRICK_FRAME;
}

/** @return the step of the index from a brick to the next along y in an array with a frame. */
static inline int sc_framed_row(const int bricks[3])
{
    return bricks[0] + 2 * SC_BRICK_FRAME;
}

/** @return the step of the index from a brick to the next along z in an array with a frame. */
static inline int sc_framed_layer(const int bricks[3])
{
    return (bricks[0] + 2 * SC_BRICK_FRAME) * (bricks[1] + 2 * SC_BRICK_FRAME);
}

/** @return the index of brick (x, y, z) in an array with a frame. The frame has the coordinates -1
 *  and one beyond the last brick. It fits an int: see sc_kernel_find.
 *  @param row of sc_framed_row. @param layer of sc_framed_layer. */
static inline int sc_framed_index(int row, int layer, int x, int y, int z)
{
    return (z + SC_BRICK_FRAME) * layer + (y + SC_BRICK_FRAME) * row + x + SC_BRICK_FRAME;
}

/** @return how many bits are set in @p mask. */
static inline unsigned sc_count_bits(uint64_t mask)
{
#ifdef __POPCNT__
    return (unsigned)__builtin_popcountll(mask);
#else
    mask -= mask >> 1 & 0x5555555555555555u;
    mask = (mask & 0x3333333333333333u) + (mask >> 2 & 0x3333333333333333u);
    mask = (mask + (mask >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (unsigned)(mask * 0x0101010101010101u >> 56);
#endif
}

/** @return how many vertices of @p mask come before the one at @p bit: where it stands among what
 * is packed of its brick. */
static inline unsigned sc_brick_rank(uint64_t mask, int bit)
{
    return sc_count_bits(mask & ((1ull << bit) - 1));
}

/** A vertex record: what is stored of a vertex near an interface, in SC_RECORD_BYTES bytes, the
 *  lowest first.
 *
 *  - Bits 0 to 4: the weight of the vote of its own label, 1 to 31. It stands for half of the
 *    difference between the label's smoothed membership and the largest one of any other label; 31
 *    stands for one half.
 *  - Bits 5 to 7: a code for the length of the gradient, as m: it is 2^-m of that at a flat
 *    interface. Codes 0 to 3 are m, and SC_RECORD_SHORTEST is an m of 10. Of the codes above it,
 *    which have an m of 8, 6 and 4, the lowest says that here all SC_RECORD_FADES parts of a
 *    surface of the label are missing, and the highest that one is, because a layer tapers
 *    below a voxel. The more is missing, the shorter is the gradient, so that what lies under the
 *    layer is lit by its own.
 *  - Bits 8 to 23: the direction of the gradient, outward, in RAS: octahedral coordinates x and y
 *    as signed bytes in 127ths (Cigolle et al. 2014, "A survey of efficient representations for
 *    independent unit vectors"). */
enum {
    SC_RECORD_BYTES = 3,
    SC_RECORD_WEIGHT_MASK = 31,
    SC_RECORD_LENGTH_SHIFT = 5,
    SC_RECORD_LENGTH_MASK = 7, /**< after the shift */
    SC_RECORD_SHORTEST = 4,    /**< the code for the largest m without anything missing */
    SC_RECORD_FADES = SC_RECORD_LENGTH_MASK - SC_RECORD_SHORTEST,
    SC_RECORD_X_SHIFT = 8,
    SC_RECORD_Y_SHIFT = 16,
    SC_RECORD_OCTANT_BITS = 8, /**< of x and of y */
    SC_RECORD_OCTANT_MASK = 255,
    SC_RECORD_DIRECTION_BITS =
        SC_RECORD_OCTANT_MASK << SC_RECORD_X_SHIFT | SC_RECORD_OCTANT_MASK << SC_RECORD_Y_SHIFT,
    SC_WEIGHT_MAX = SC_RECORD_WEIGHT_MASK
};
/** A direction's octahedral coordinate of 1. */
#define SC_RECORD_OCTANT_ONE 127

/** @return a packed record. @param weight 0 to SC_WEIGHT_MAX; stored records have 1 at least.
 *  @param outward direction of the gradient, RAS, of any length but zero.
 *  @param strength length of the gradient as a share of that at a flat interface; stored as the
 *  nearest power of two from 1 down to 2^-3, or as 2^-10 if it is smaller. */
static inline uint32_t sc_record_pack(int weight, sc_vec3 outward, double strength)
{
    const double share = 1 / (fabs(outward.x) + fabs(outward.y) + fabs(outward.z));
    double octant[2] = {outward.x * share, outward.y * share};
    uint32_t m = 0, packed[2];

    if (outward.z < 0) {
        const double x = (1 - fabs(octant[1])) * (octant[0] < 0 ? -1 : 1);
        const double y = (1 - fabs(octant[0])) * (octant[1] < 0 ? -1 : 1);

        octant[0] = x;
        octant[1] = y;
    }
    while (m < SC_RECORD_SHORTEST && strength < 0.7071) /* the nearest power of two */
        strength *= 2, m++;
    /* Adding ONE + 1/2 makes the number positive, so that the conversion rounds down. */
    for (int i = 0; i < 2; i++)
        packed[i] =
            (uint32_t)((int)(octant[i] * SC_RECORD_OCTANT_ONE + (SC_RECORD_OCTANT_ONE + 0.5)) -
                       SC_RECORD_OCTANT_ONE) &
            SC_RECORD_OCTANT_MASK;
    return (uint32_t)weight | m << SC_RECORD_LENGTH_SHIFT | packed[0] << SC_RECORD_X_SHIFT |
           packed[1] << SC_RECORD_Y_SHIFT;
}

/** @return the record at @p index of an array of packed records of SC_RECORD_BYTES each. */
static inline uint32_t sc_record_read(const uint8_t *records, size_t index)
{
    const uint8_t *at = records + index * SC_RECORD_BYTES;

    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16;
}

/** Store @p record at @p index of such an array; its bits from 24 on are dropped. */
static inline void sc_record_write(uint8_t *records, size_t index, uint32_t record)
{
    for (int i = 0; i < SC_RECORD_BYTES; i++)
        records[index * SC_RECORD_BYTES + (size_t)i] = (uint8_t)(record >> (8 * i));
}

/** @return the weight in a record, 0 to SC_WEIGHT_MAX. */
static inline int sc_record_weight(uint32_t record)
{
    return (int)(record & SC_RECORD_WEIGHT_MASK);
}

/** @return the bits of a record that hold the length of the gradient or a fade: 0 to 7. */
static inline int sc_record_length_code(uint32_t record)
{
    return (int)(record >> SC_RECORD_LENGTH_SHIFT & SC_RECORD_LENGTH_MASK);
}

/** @return 2^m, 1 to 1024: the length of the gradient is 2^-m of that at a flat interface. */
static inline int sc_record_inverse_length(uint32_t record)
{
    const int code = sc_record_length_code(record);

    return 1 << (code < SC_RECORD_SHORTEST ? code : 2 * (SC_RECORD_LENGTH_MASK + 2 - code));
}

/** @return how many parts of SC_RECORD_FADES of a surface are missing at a vertex: 0 to
 * SC_RECORD_FADES. */
static inline int sc_record_missing(uint32_t record)
{
    const int code = sc_record_length_code(record);

    return code > SC_RECORD_SHORTEST ? SC_RECORD_LENGTH_MASK + 1 - code : 0;
}

/** @return the record with so many parts missing, 0 to SC_RECORD_FADES; for 0 as it is. */
static inline uint32_t sc_record_fade(uint32_t record, uint32_t missing)
{
    if (!missing)
        return record;
    return (record & ~((uint32_t)SC_RECORD_LENGTH_MASK << SC_RECORD_LENGTH_SHIFT)) |
           (SC_RECORD_LENGTH_MASK + 1 - missing) << SC_RECORD_LENGTH_SHIFT;
}

/** @return the record with the shortest gradient: next to others, it tells nothing of the
 * direction.
 */
static inline uint32_t sc_record_shortest(uint32_t record)
{
    return (record & ~((uint32_t)SC_RECORD_LENGTH_MASK << SC_RECORD_LENGTH_SHIFT)) |
           (uint32_t)SC_RECORD_SHORTEST << SC_RECORD_LENGTH_SHIFT;
}

/** The record of a vertex outside of the volume, beside a voxel of tissue at its border, that says:
 *  the tissue ends between that voxel and the border. Other vertices outside of the volume stand
 * for copies of the voxels beside them, whatever is in their records. The mark is an x of -128 in
 *  octahedral coordinates, which no direction has; instead of y there is the height of the end:
 *  how far above the middle of the voxel it lies, in steps of 1 / SC_RECORD_END_STEPS of a voxel, 1
 *  to SC_RECORD_END_MAX. The weight is 1 and tells nothing. */
enum {
    SC_RECORD_END_MARK = 0x80,
    SC_RECORD_END_STEPS = 254,
    SC_RECORD_END_MAX = SC_RECORD_END_STEPS / 2 /**< that is at the border */
};

/** @return the record of a vertex at which tissue ends. @param height 1 to SC_RECORD_END_MAX. */
static inline uint32_t sc_record_pack_end(int height)
{
    return 1u | (uint32_t)SC_RECORD_END_MARK << SC_RECORD_X_SHIFT |
           (uint32_t)height << SC_RECORD_Y_SHIFT;
}

/** @return the height of sc_record_pack_end in the record of a vertex outside of the volume; 0 if
 *  no tissue ends there. */
static inline int sc_record_end(uint32_t record)
{
    const int height = (int)(record >> SC_RECORD_Y_SHIFT & SC_RECORD_OCTANT_MASK);

    if ((record >> SC_RECORD_X_SHIFT & SC_RECORD_OCTANT_MASK) != SC_RECORD_END_MARK)
        return 0;
    return height < 1 ? 1 : height > SC_RECORD_END_MAX ? SC_RECORD_END_MAX : height;
}

/** Write the direction of the gradient, RAS, to @p out. It is not of unit length: its absolute
 *  coordinates add up to 127. */
static inline void sc_record_octant(uint32_t record, float out[3])
{
    const float x = (float)(int8_t)(record >> SC_RECORD_X_SHIFT);
    const float y = (float)(int8_t)(record >> SC_RECORD_Y_SHIFT);
    const float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y, z = SC_RECORD_OCTANT_ONE - ax - ay;
    const float fold = z < 0 ? -z : 0;

    out[0] = x < 0 ? x + fold : x - fold;
    out[1] = y < 0 ? y + fold : y - fold;
    out[2] = z;
}

/** Write the gradient, RAS, to @p out: a unit direction times the length, 2^-m. */
static inline void sc_record_normal(uint32_t record, float out[3])
{
    float inverse;

    sc_record_octant(record, out);
    inverse = 1 / ((float)sc_record_inverse_length(record) *
                   sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]));
    for (int i = 0; i < 3; i++)
        out[i] *= inverse;
}

/** A packed cell: the weights of its corners (x + 2 y + 4 z), positive for the lowest label and
 *  negative for all others, as signed fields in two words of 32 bits: corners 0 to 4 in the lower,
 *  5 to 7 in the upper, each from its lowest bit up. */
enum { SC_CELL_FIELD_BITS = 6, SC_CELL_LOW_FIELDS = 5, SC_CELL_WORD_BITS = 32 };
#define SC_CELL_MANY                                                                               \
    (1ull << 63) /**< there are more than two labels, or the cell reaches across the               \
                 border of the volume */
#define SC_CELL_ENDS (1ull << 62) /**< tissue ends at one of its corners: see sc_record_end */

/** @return the lowest bit, within its word, of the field of corner @p corner, 0 to 7. */
static inline int sc_cell_field_shift(int corner)
{
    return SC_CELL_FIELD_BITS * (corner % SC_CELL_LOW_FIELDS);
}

/** @return the word that holds the field of a corner: 0, the lower, or 1. */
static inline int sc_cell_field_word(int corner)
{
    return corner / SC_CELL_LOW_FIELDS;
}

#endif
