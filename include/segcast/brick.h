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

/** A vertex record: what is stored of one of the two fields (sc_prepared) at a vertex near a
 * border.
 *
 *  - Bits 0 to 7: the value of the field, a signed byte of -127 to 127 and never 0, in steps of
 *    1 / SC_BORDER_STEPS of a voxel. In the outer field it is positive on the side of tissue; in
 * the inner field it is always positive.
 *  - Bits 8 to 23: the direction of the gradient, in RAS, outward: octahedral coordinates x and y
 * as signed bytes in 127ths (Cigolle et al. 2014, "A survey of efficient representations for
 *    independent unit vectors"). Outward is towards the background in the outer field, and away
 * from the tissue of the vertex in the inner one.
 *  - Bits 24 to 28: the tissue of the vertex, as the place of a voxel that carries it: see
 *    sc_tissue_code. Both records of a vertex say the same.
 *  - Bits 29 to 31: the length of the gradient as a share of that at a flat border, in eighths,
 * less one. */
enum {
    SC_BORDER_STEPS = 96, /**< of a value, to a voxel */
    SC_VALUE_MAX = 127,
    SC_RECORD_X_SHIFT = 8,
    SC_RECORD_Y_SHIFT = 16,
    SC_RECORD_OCTANT_BITS = 8, /**< of x and of y */
    SC_RECORD_OCTANT_MASK = 255,
    SC_RECORD_TISSUE_SHIFT = 24,
    SC_RECORD_TISSUE_MASK = 31, /**< after the shift */
    SC_RECORD_LENGTH_SHIFT = 29,
    SC_RECORD_LENGTH_STEPS = 8, /**< of a length, to that at a flat border */
    SC_RECORD_BYTES = 4
};
/** A direction's octahedral coordinate of 1. */
#define SC_RECORD_OCTANT_ONE 127

/** The place of a voxel in the 3x3x3 around a vertex: (dx + 1) + 3 (dy + 1) + 9 (dz + 1). */
enum { SC_TISSUE_OWN = 13 /**< the vertex itself */, SC_TISSUE_CODES = 27 };

/** @return the code of the place at (dx, dy, dz), each -1 to 1, from a vertex. */
static inline int sc_tissue_code(int dx, int dy, int dz)
{
    return (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1);
}

/** @return how far, -1 to 1, the place of a code lies from the vertex along @p axis. */
static inline int sc_tissue_step(int code, int axis)
{
    return code / (axis == 0 ? 1 : axis == 1 ? 3 : 9) % 3 - 1;
}

/** @return a record whose tissue has code 0; that of another is or-ed to it, shifted by
 *  SC_RECORD_TISSUE_SHIFT. @param value -SC_VALUE_MAX to SC_VALUE_MAX, not 0.
 *  @param outward direction of the gradient, RAS, of any length; none is stored as that of z.
 *  @param length of the gradient as a share of that at a flat border; stored as the nearest eighth
 *  from 1/8 to 1. */
static inline uint32_t sc_record_pack(int value, sc_vec3 outward, double length)
{
    const double sum = fabs(outward.x) + fabs(outward.y) + fabs(outward.z);
    const double share = sum > 0 ? 1 / sum : 0;
    double octant[2] = {outward.x * share, outward.y * share};
    const int eighths =
        length < 1 ? (int)(length * SC_RECORD_LENGTH_STEPS + 0.5) : (int)SC_RECORD_LENGTH_STEPS;
    uint32_t packed[2];

    if (outward.z < 0) {
        const double x = (1 - fabs(octant[1])) * (octant[0] < 0 ? -1 : 1);
        const double y = (1 - fabs(octant[0])) * (octant[1] < 0 ? -1 : 1);

        octant[0] = x;
        octant[1] = y;
    }
    /* Adding ONE + 1/2 makes the number positive, so that the conversion rounds down. */
    for (int i = 0; i < 2; i++)
        packed[i] =
            (uint32_t)((int)(octant[i] * SC_RECORD_OCTANT_ONE + (SC_RECORD_OCTANT_ONE + 0.5)) -
                       SC_RECORD_OCTANT_ONE) &
            SC_RECORD_OCTANT_MASK;
    return (uint32_t)(uint8_t)value | packed[0] << SC_RECORD_X_SHIFT |
           packed[1] << SC_RECORD_Y_SHIFT |
           (uint32_t)(eighths > 1 ? eighths - 1 : 0) << SC_RECORD_LENGTH_SHIFT;
}

/** @return the value in a record. */
static inline int sc_record_value(uint32_t record)
{
    return (int8_t)record;
}

/** @return the code of the tissue in a record; 0 to 26 in what segcast has written. */
static inline int sc_record_tissue(uint32_t record)
{
    return (int)(record >> SC_RECORD_TISSUE_SHIFT & SC_RECORD_TISSUE_MASK);
}

/** @return the length of the gradient in a record, 1 to 8 eighths of that at a flat border. */
static inline int sc_record_eighths(uint32_t record)
{
    return (int)(record >> SC_RECORD_LENGTH_SHIFT) + 1;
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

/** Write the gradient, RAS, to @p out: a unit direction times the length in eighths. */
static inline void sc_record_normal(uint32_t record, float out[3])
{
    float share;

    sc_record_octant(record, out);
    share = (float)sc_record_eighths(record) /
            sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    for (int i = 0; i < 3; i++)
        out[i] *= share;
}

/** A packed cell: what the fields say at its corners x + 2 y + 4 z, so that kernels need nothing
 *  else to find where a ray crosses the border in it. There are two kinds: in one the corners lie
 * on both sides of the outer field and have the same tissue, in the other all lie on the side of
 * tissue and have one of two tissues. All other cells, and those that reach across the border of
 * the volume, are general: what is packed of them tells only where there is nothing but background.
 */
typedef struct sc_packed_cell {
    uint32_t values[2]; /**< a signed byte for each corner, from the lowest up; corners 0 to 3 in
                           the first: the vote of the lower label minus that of the higher one. In a
                             general cell that of the background minus that of tissue; -SC_VALUE_MAX
                             at all corners if these do not lie on both sides, or reach across the
                             border */
    uint32_t labels; /**< dense ids of the two labels that the cell separates, the lower one in the
                          lower half: 0, the background, in the first kind. 0: a general cell */
} sc_packed_cell;
enum { SC_CELL_VALUE_BITS = 8, SC_CELL_WORD_CORNERS = 4, SC_CELL_LABEL_BITS = 16 };

#endif
