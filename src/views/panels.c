/* SPDX-License-Identifier: BSD-3-Clause */
/* Several pictures side by side. */
#include "segcast/views.h"

/* @return the shorter side of panels in so many columns: what is shown in them turns, so that it
 * is about as wide as it is high. */
static int shorter_side(const int size_px[2], int count, int columns, int below_px)
{
    const int rows = (count + columns - 1) / columns;
    const int width_px = size_px[0] / columns, height_px = size_px[1] / rows - below_px;

    return width_px < height_px ? width_px : height_px;
}

void sc_place_panels(const int size_px[2], int count, int below_px, sc_viewport *out)
{
    int columns = 1, rows, cell_px[2], free_px[2];

    for (int tried = 2; tried <= count; tried++) {
        if (shorter_side(size_px, count, tried, below_px) >
            shorter_side(size_px, count, columns, below_px))
            columns = tried;
    }
    rows = (count + columns - 1) / columns;
    cell_px[0] = size_px[0] / columns;
    cell_px[1] = size_px[1] / rows;
    for (int i = 0; i < 2; i++)
        free_px[i] = size_px[i] - (i ? rows : columns) * cell_px[i];
    for (int i = 0; i < count; i++) {
        const int row = i / columns, missing = row == rows - 1 ? rows * columns - count : 0;
        const int height_px = cell_px[1] - below_px;

        out[i] = (sc_viewport){(free_px[0] + missing * cell_px[0]) / 2 + i % columns * cell_px[0],
                               free_px[1] / 2 + row * cell_px[1], cell_px[0] > 0 ? cell_px[0] : 1,
                               height_px > 0 ? height_px : 1};
    }
}
