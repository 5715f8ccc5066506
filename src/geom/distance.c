/* SPDX-License-Identifier: BSD-3-Clause */
/* One pass of the exact Euclidean distance transform: see geom.h. */
#include "segcast/geom.h"

#include <stddef.h>

void sc_distance_pass(double *values, int count, double step, double *work)
{
    const size_t room = (size_t)count + 3;
    double *height = work;        /* height[q] of the parabola over q - 1: those beyond are 0 */
    double *root = height + room; /* where the parabolas of the envelope have their vertices */
    double *begin = root + room;  /* where each of them begins to be the lowest */
    const double square = step * step;
    size_t top = 0, at = 0;

    height[0] = height[count + 1] = 0;
    for (int i = 0; i < count; i++)
        height[i + 1] = values[i];
    root[0] = 0;
    begin[0] = -HUGE_VAL;
    for (int q = 1; q <= count + 1; q++) {
        double cross;

        if (!(height[q] < HUGE_VAL))
            continue;
        for (;;) {
            const double r = root[top];

            cross = 0.5 * ((height[q] - height[(int)r]) / (square * (q - r)) + q + r);
            if (cross > begin[top])
                break;
            top--; /* never below the first one, which begins at minus infinity */
        }
        root[++top] = q;
        begin[top] = cross;
    }
    for (int i = 0; i < count; i++) {
        double away;

        while (at < top && begin[at + 1] <= i + 1)
            at++;
        away = i + 1 - root[at];
        values[i] = height[(int)root[at]] + square * away * away;
    }
}
