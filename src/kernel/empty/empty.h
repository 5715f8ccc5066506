/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: what a skip method finds out about the space around a place, for one ray per
 * SIMD lane. The wide templates ask it at every step. A cell is one of the surface model: a cube
 * between grid vertices (smooth), or the surroundings of one vertex (voxel).
 *
 * Each skip method is a file empty_METHOD.h, which defines
 * - v_place: what it remembers of a ray between two steps,
 * - v_first_place(): that of a ray which begins,
 * - v_look(march, at, place, on): looks at the cells @p at of the lanes of @p on,
 * - EMPTY_IS_BALL: 0: what is empty is a box of cells; 1: a ball by the city-block distance. */
#ifndef SC_KERNEL_EMPTY_H
#define SC_KERNEL_EMPTY_H

#include "lanes/lanes_brick.h"

#include "segcast/kernel.h"

/* What is empty around the cell of each lane. */
typedef struct v_empty {
    vm marked; /* lanes whose own cell is marked: nothing else is said of these */
    vm leaps;  /* lanes around whose cell more than this one cell is empty */
    /* A box: from (at & mask) + back to before (at & mask) + ahead along every axis. A ball: all
     * cells at a city-block distance less than ahead; mask and back are not set. */
    vi mask, ahead, back;
} v_empty;

#endif
