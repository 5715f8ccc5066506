/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: light from all around at a point of a surface, from what has been gathered at
 * the vertices. */
#ifndef SC_KERNEL_AROUND_H
#define SC_KERNEL_AROUND_H

#include "cell.h"
#include "shade.h"

/* The light around the point @p a of the cell @p q, on a surface with the unit normal @p n, which
 * is turned to the eye, to @p out: the mean over the corners of the cell, weighted by how near each
 * is, and how alike its own normal is. The normals keep the light of one side of a thin wall from
 * the other. Where no corner looks that way, the eye is behind the surface, and sees what shines
 * through it. @param outer whether the surface borders on the background.
 * @return false, with nothing written, if it is not known. */
static inline bool sc_around(const sc_march *m, bool outer, const int q[3], const float a[3],
                             const float n[3], float out[3])
{
    const sc_border *b = outer ? &m->volume->outer : &m->volume->inner;
    const uint32_t *around = m->around[outer ? 0 : 1];
    float front[3] = {0}, back[3] = {0}, front_weights = 0, back_weights = 0;

    if (!around)
        return false;
    for (int i = 0; i < SC_CORNERS; i++) {
        const int x = q[0] + (i & 1), y = q[1] + (i >> 1 & 1), z = q[2] + (i >> 2),
                  bit = sc_brick_bit(x, y, z);
        const size_t brick =
            sc_brick_index(m->volume->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));
        const uint64_t mask = b->masks[brick];
        const float share =
            (i & 1 ? a[0] : 1 - a[0]) * (i & 2 ? a[1] : 1 - a[1]) * (i & 4 ? a[2] : 1 - a[2]);
        float octant[3], alike, weight;
        uint32_t at;

        if (!(mask >> bit & 1))
            continue;
        at = b->start[brick] + sc_brick_rank(mask, bit);
        sc_record_octant(b->records[at], octant);
        alike = sc_dot3(octant, n) / sqrtf(sc_dot3(octant, octant));
        weight = share * alike * alike;
        for (int k = 0; k < 3; k++) {
            const float root = (float)(around[at] >> SC_AROUND_BITS * k & SC_AROUND_MASK) *
                               (SC_AROUND_ROOT / SC_AROUND_MASK);

            if (alike > 0)
                front[k] += weight * root * root;
            else
                back[k] += weight * root * root;
        }
        if (alike > 0)
            front_weights += weight;
        else
            back_weights += weight;
    }
    if (!(front_weights + back_weights > 0))
        return false;
    for (int k = 0; k < 3; k++)
        out[k] = front_weights > 0 ? front[k] / front_weights : back[k] / back_weights;
    return true;
}

#endif
