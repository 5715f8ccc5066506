/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the normal of a surface at a point of a cell, from the gradients of the vertex
 * records. */
#ifndef SC_KERNEL_NORMAL_H
#define SC_KERNEL_NORMAL_H

#include "cell.h"

/* Where the gradients of the corners cancel each other out to less than this, in eighths of that of
 * a flat border, they tell of no direction, and the surface is taken to face the eye. */
#define SC_GRADIENT_LEAST 0.01f

/* Add the gradient of a vertex record, times @p weight, to @p n. */
static inline void sc_add_gradient(uint32_t record, float weight, float n[3])
{
    float octant[3], share;

    sc_record_octant(record, octant);
    share = weight * (float)sc_record_eighths(record) /
            sqrtf(octant[0] * octant[0] + octant[1] * octant[1] + octant[2] * octant[2]);
    for (int k = 0; k < 3; k++)
        n[k] += share * octant[k];
}

/* The direction from label @p first to label @p second at the point @p a, in RAS, to @p n; it is
 * not of unit length and may be 0. At the background that is the gradient of the outer field,
 * interpolated over all corners. Between two tissues the gradient of each corner points away from
 * its own, so that those of the corners with @p second count against. */
static inline void sc_cell_normal(const sc_cell *c, uint32_t first, uint32_t second,
                                  const float a[3], float n[3])
{
    const bool at_background = !first || !second;

    n[0] = n[1] = n[2] = 0;
    for (int i = 0; i < SC_CORNERS; i++) {
        const float weight =
            (i & 1 ? a[0] : 1 - a[0]) * (i & 2 ? a[1] : 1 - a[1]) * (i & 4 ? a[2] : 1 - a[2]);

        if (at_background)
            sc_add_gradient(c->outer_records[i], first ? weight : -weight, n);
        else if (c->labels[i] == first || c->labels[i] == second)
            sc_add_gradient(c->inner_records[i], c->labels[i] == first ? weight : -weight, n);
    }
}

#endif
