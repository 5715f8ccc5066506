/* SPDX-License-Identifier: BSD-3-Clause */
/* Several pictures side by side. */
#include "segcast/views.h"

void sc_place_panels(const int size_px[2], int count, int columns, int below_px, sc_viewport *out)
{
    const int rows = (count + columns - 1) / columns, missing = rows * columns - count;
    const int cell_px[2] = {size_px[0] / columns, size_px[1] / rows};
    const int free_px[2] = {size_px[0] - columns * cell_px[0], size_px[1] - rows * cell_px[1]};
    const int height_px = cell_px[1] - below_px;

    for (int i = 0; i < count; i++) {
        const int row = i / columns, aside = row == rows - 1 ? missing : 0;

        out[i] = (sc_viewport){(free_px[0] + aside * cell_px[0]) / 2 + i % columns * cell_px[0],
                               free_px[1] / 2 + row * cell_px[1], cell_px[0] > 0 ? cell_px[0] : 1,
                               height_px > 0 ? height_px : 1};
    }
}
