/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the normal of a surface at a point of a cell, from the gradients of the vertex
 * records. */
#ifndef SC_KERNEL_NORMAL_H
#define SC_KERNEL_NORMAL_H

#include "cell.h"

/* The gradients of two labels are taken as one field, partly from SC_OPPOSITE_FROM and fully from
 * SC_OPPOSITE_FROM + SC_OPPOSITE_RANGE: cosines of the angle between one gradient and the opposite
 * of the other. See sc_cell_normal. Beside a third tissue the angle changes from cell to cell, so
 * that a narrower range mottles the light there; one that begins later bends the normals of tissue
 * about a voxel thin. */
#define SC_OPPOSITE_FROM 0.8f
#define SC_OPPOSITE_RANGE 0.2f
/* Where both gradients point the same way, one is that of the far side of a layer about a voxel
 * thin, whose vertices know one side only. It is left out in part from an angle of 90 degrees on,
 * and fully from one whose cosine is SC_ALIKE_ALL: the one that faces the eye less, all of it where
 * the cosines of the two to the eye differ by 0.5 / SC_FACING_GAIN or more. With a larger gain thin
 * vessels seen from the side flash. */
#define SC_ALIKE_ALL 0.5f
#define SC_FACING_GAIN 0.5f

/* For each of two labels, add the gradients at its corners, weighted trilinearly for the point
 * @p a, to @p sums, and those weights to @p weights; the caller has set both to 0. Index 0 is
 * for @p first, 1 for @p second; corners with other labels are passed over. */
static inline void sc_cell_gradients(const sc_cell *c, uint32_t first, uint32_t second,
                                     const float a[3], float sums[2][3], float weights[2])
{
    for (int i = 0; i < SC_CORNERS; i++) {
        const float weight =
            (i & 1 ? a[0] : 1 - a[0]) * (i & 2 ? a[1] : 1 - a[1]) * (i & 4 ? a[2] : 1 - a[2]);
        const int side = c->labels[i] == second;
        float each[3];

        if (c->labels[i] != first && c->labels[i] != second)
            continue;
        sc_record_normal(c->records[i], each);
        weights[side] += weight;
        for (int k = 0; k < 3; k++)
            sums[side][k] += weight * each[k];
    }
}

static inline float sc_length3(const float v[3])
{
    return sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* The direction from label @p first to label @p second at the point @p a, in RAS, to @p n; it is
 * not of unit length and may be 0. Where there are only two labels, their gradients are
 * opposite: they form one field, which is interpolated over all corners. Near a third label they
 * are not opposite, and each label's gradient is the mean over its own corners, so that it does
 * not matter which corners those are. Between the two cases they are blended linearly. Where they
 * point the same way, that of the side which the eye cannot see is left out: see SC_ALIKE_ALL.
 * @param eye [3] unit, RAS, towards the eye, against a ray that passes from @p second to @p first.
 * @param left what the gradient of each of the two labels is multiplied by, see sc_sides_left;
 * NULL: 1. */
static inline void sc_cell_normal(const sc_cell *c, uint32_t first, uint32_t second,
                                  const float a[3], const float eye[3], const float left[2],
                                  float n[3])
{
    float sums[2][3] = {{0}, {0}}, weights[2] = {0, 0}, facing[2] = {0, 0}, length[2];
    float apart = 0, lengths, one, alike, seen;

    sc_cell_gradients(c, first, second, a, sums, weights);
    for (int k = 0; k < 3; k++) {
        apart -= sums[0][k] * sums[1][k];
        facing[0] += sums[0][k] * eye[k];
        facing[1] -= sums[1][k] * eye[k];
    }
    for (int side = 0; side < 2; side++)
        length[side] = sc_length3(sums[side]);
    lengths = length[0] * length[1];
    one = (apart - SC_OPPOSITE_FROM * lengths) / (SC_OPPOSITE_RANGE * lengths + 1e-12f);
    one = one < 0 ? 0 : one > 1 ? 1 : one;
    alike = -apart / (SC_ALIKE_ALL * lengths + 1e-12f);
    alike = alike < 0 ? 0 : alike > 1 ? 1 : alike;
    seen = (facing[0] * length[1] - facing[1] * length[0]) / (lengths + 1e-12f);
    seen = 0.5f + SC_FACING_GAIN * seen;
    seen = seen < 0 ? 0 : seen > 1 ? 1 : seen;
    if (left) {
        const float least = left[0] < left[1] ? left[0] : left[1];

        one *= least;
        alike *= least;
    }
    for (int side = 0; side < 2; side++)
        weights[side] =
            (one + (1 - one) / (weights[side] + 1e-9f)) * (1 - alike * (side ? seen : 1 - seen));
    for (int side = 0; side < 2 && left; side++)
        weights[side] *= left[side];
    for (int k = 0; k < 3; k++)
        n[k] = sums[0][k] * weights[0] - sums[1][k] * weights[1];
}

#endif
