/* SPDX-License-Identifier: BSD-3-Clause */
#include "cell.h"

uint32_t sc_kernel_owner(const sc_prepared *volume, const float place[3])
{
    sc_cell cell;
    float a[3];

    for (int i = 0; i < 3; i++) {
        if (!(place[i] >= 0 && place[i] <= (float)(volume->size[i] + 1)))
            return 0;
        cell.q[i] = (int)place[i];
        a[i] = place[i] - (float)cell.q[i];
    }
    if (!sc_cell_labels(volume, volume->label_bytes, &cell))
        return cell.labels[0];
    sc_cell_fill(volume, &cell);
    return sc_cell_owner(&cell, a);
}
