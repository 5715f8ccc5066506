/* SPDX-License-Identifier: BSD-3-Clause */
/* The owner of a single point, by which the smooth surface is compared with known shapes. */
#include "cell.h"

uint32_t sc_kernel_owner(const sc_prepared *volume, const float point[3])
{
    sc_cell cell;
    float a[3];

    for (int i = 0; i < 3; i++) {
        if (!(point[i] >= 0 && point[i] <= (float)(volume->size[i] + 1)))
            return 0;
        cell.q[i] = (int)point[i];
        a[i] = point[i] - (float)cell.q[i];
    }
    (void)sc_cell_read(volume, &cell);
    return sc_cell_owner_at(&cell, a);
}
