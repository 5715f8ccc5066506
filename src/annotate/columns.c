/* SPDX-License-Identifier: BSD-3-Clause */
/* Names one below the other: as near to where they want to be as their height allows. */
#include "internal.h"

#include <math.h>

#define MOVE 0.6   /* share of a fade in which the others make room for a name */
#define LIGHT 1e-6 /* weight of a name that takes no room */

/* Names that touch each other and move as one. */
typedef struct run {
    double mean, weight;
    int count;
} run;

void sc_spread(const double *want_px, const double *room_px, int count, double low_px,
               double high_px, double *out)
{
    run runs[SC_NAMES_MAX];
    double above = 0, total = 0;
    int run_count = 0, at = 0;

    for (int i = 0; i < count; i++)
        total += room_px[i];
    /* Without the room that those above take, names need only be in order. Of all positions that
     * are, those of least squared distance are found by pooling neighbours that are not (isotonic
     * regression; Barlow et al. 1972, "Statistical inference under order restrictions"). */
    for (int i = 0; i < count; i++) {
        runs[run_count++] = (run){want_px[i] - above - room_px[i] / 2, room_px[i] + LIGHT, 1};
        above += room_px[i];
        while (run_count > 1 && runs[run_count - 2].mean > runs[run_count - 1].mean) {
            const run last = runs[--run_count];
            run *to = &runs[run_count - 1];

            to->mean =
                (to->mean * to->weight + last.mean * last.weight) / (to->weight + last.weight);
            to->weight += last.weight;
            to->count += last.count;
        }
    }
    above = 0;
    for (int r = 0; r < run_count; r++) {
        const double begin = fmax(low_px, fmin(high_px - total, runs[r].mean));

        for (int i = 0; i < runs[r].count; i++, at++) {
            out[at] = begin + above + room_px[at] / 2;
            above += room_px[at];
        }
    }
}

void sc_share_rows(const double *shown, int count, double rows, double *room, double *alpha)
{
    for (int i = 0; i < count; i++) {
        const double left = fmax(0, fmin(1, rows));

        room[i] = fmin(left, fmin(1, shown[i] / MOVE));
        /* Rows hold some leading: a name may be seen a little before it has all of its row. */
        alpha[i] = fmax(0, fmin((shown[i] - MOVE) / (1 - MOVE), 5 * left - 4));
        rows -= room[i];
    }
}
