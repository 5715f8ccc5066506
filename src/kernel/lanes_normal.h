/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: normal.h for one point per SIMD lane, with the same bits; see lanes_cell.h. */
#ifndef SC_KERNEL_LANES_NORMAL_H
#define SC_KERNEL_LANES_NORMAL_H

#include "lanes_cell.h"
#include "normal.h"

/* The direction from label @p first to label @p second at the point @p a, in RAS, to @p n, not
 * of unit length; see sc_cell_normal, also for @p eye and @p left. c->labels and c->records must
 * be set. */
static inline void v_cell_normal(const v_cell *c, vi first, vi second, const vf a[3],
                                 const vf eye[3], const vf left[2], vf n[3])
{
    vf sums[2][3] = {{{0}}}, weights[2] = {{0}}, facing[2] = {{0}}, length[2];
    vf apart = {0}, lengths, one, alike, seen;

    for (int i = 0; i < SC_CORNERS; i++) {
        const vf weight = v_corner_share(i, a);
        const vm side[2] = {i_equal(c->labels[i], first), i_equal(c->labels[i], second)};
        vf each[3];

        v_record_normal(c->records[i], each);
        for (int s = 0; s < 2; s++) {
            weights[s] = f_pick(side[s], weights[s] + weight, weights[s]);
            for (int k = 0; k < 3; k++)
                sums[s][k] = f_pick(side[s], sums[s][k] + weight * each[k], sums[s][k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        apart -= sums[0][k] * sums[1][k];
        facing[0] += sums[0][k] * eye[k];
        facing[1] -= sums[1][k] * eye[k];
    }
    for (int s = 0; s < 2; s++)
        length[s] = f_length(sums[s]);
    lengths = length[0] * length[1];
    one = (apart - SC_OPPOSITE_FROM * lengths) / (SC_OPPOSITE_RANGE * lengths + 1e-12f);
    one = f_clamp01(one);
    alike = f_clamp01(-apart / (SC_ALIKE_ALL * lengths + 1e-12f));
    seen = (facing[0] * length[1] - facing[1] * length[0]) / (lengths + 1e-12f);
    seen = f_clamp01(0.5f + SC_FACING_GAIN * seen);
    if (left) {
        const vf least = f_pick(f_below(left[0], left[1]), left[0], left[1]);

        one *= least;
        alike *= least;
    }
    for (int s = 0; s < 2; s++)
        weights[s] = (one + (1 - one) / (weights[s] + 1e-9f)) * (1 - alike * (s ? seen : 1 - seen));
    for (int s = 0; s < 2 && left; s++)
        weights[s] *= left[s];
    for (int k = 0; k < 3; k++)
        n[k] = sums[0][k] * weights[0] - sums[1][k] * weights[1];
}

#endif
