/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: what all kernels for backdrops share. */
#ifndef SC_KERNEL_BACKDROP_H
#define SC_KERNEL_BACKDROP_H

#include "shade.h"

/* Of the cells between centres of voxels along an axis with so many voxels, the number of the last
 * one; with one voxel the cell has no width. */
static inline int sc_lowest_max(int size)
{
    return size > 1 ? size - 2 : 0;
}

#endif
