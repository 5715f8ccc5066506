/* SPDX-License-Identifier: BSD-3-Clause */
#include "walls.h"

/* A wall passes over a pixel only if its interpolated distance is less than this. Labels farther
 * away are no walls, but lie behind others. */
#define FARTHEST 1.0f

/* A layer behind slice z, while its walls are being found. */
typedef struct wall_search {
    const distances *d;
    const blend *layer;
    int z;
    const uint16_t *below, *above; /* [y][x] the ids in the two slices */
    /* [y][x] the least distance of walls found so far: FARTHEST where a pixel is left between its
     * labels in the two slices and none was found; negative where it is not left. */
    float *open;
} wall_search;

/* Find the pixels that are left between the labels of the two slices: neither label reaches them.
 * @return whether there are any. */
static bool find_open(const wall_search *w, const float *least, const uint32_t *winner)
{
    const size_t pixels = (size_t)w->d->s->size[0] * (size_t)w->d->s->size[1];
    bool any = false;

    for (size_t at = 0; at < pixels; at++) {
        const bool open = least[at] > 0 && w->below[at] != w->above[at] &&
                          (winner[at] == w->below[at] || winner[at] == w->above[at]);

        w->open[at] = open ? FARTHEST : -1;
        any = any || open;
    }
    return any;
}

/* @return the distance of pixel (@p x, @p y) of slice @p z from the border of the label @p id. */
static float distance_from(const distances *d, uint32_t id, int x, int y, int z)
{
    int first = 0, end = d->count;

    while (first < end) {
        const int middle = (first + end) / 2;

        if ((uint32_t)d->boxes[middle].id < id)
            first = middle + 1;
        else
            end = middle;
    }
    if (first < d->count && (uint32_t)d->boxes[first].id == id) {
        const label_box *box = &d->boxes[first];

        if (x >= box->low[0] && x <= box->high[0] && y >= box->low[1] && y <= box->high[1])
            return sc_distances_row(d, box, z, y)[x - box->low[0]];
    }
    return NO_BORDER;
}

/* Write which way pixel (@p x, @p y) of slice @p z lies from a label: in which direction the
 * distance from it grows. */
static void direction_from(const distances *d, const label_box *box, int x, int y, int z,
                           float way[2])
{
    const int west = x > box->low[0] ? x - 1 : x, east = x < box->high[0] ? x + 1 : x;
    const int south = y > box->low[1] ? y - 1 : y, north = y < box->high[1] ? y + 1 : y;
    const float *row = sc_distances_row(d, box, z, y) - box->low[0];

    way[0] = (row[east] - row[west]) / d->s->step[0];
    way[1] = (sc_distances_row(d, box, z, north)[x - box->low[0]] -
              sc_distances_row(d, box, z, south)[x - box->low[0]]) /
             d->s->step[1];
}

/* Does a label pass over pixel (@p x, @p y), where it is @p below and @p above far away? It has to
 * lie on either side, and in each slice before the label that the other slice has there: else it
 * would be no wall between the two, but lie beside them. */
static bool passes(const wall_search *w, const label_box *box, int x, int y, float below,
                   float above)
{
    const size_t at = (size_t)y * (size_t)w->d->s->size[0] + (size_t)x;
    float way[2], next_way[2];

    direction_from(w->d, box, x, y, w->z, way);
    direction_from(w->d, box, x, y, w->z + 1, next_way);
    return way[0] * next_way[0] + way[1] * next_way[1] < 0 &&
           below < distance_from(w->d, w->above[at], x, y, w->z) &&
           above < distance_from(w->d, w->below[at], x, y, w->z + 1);
}

/* Let a label have the pixels of row @p y that it passes over, if none found before is nearer. */
static void pass_in_row(const wall_search *w, const label_box *box, int y, uint32_t *winner)
{
    const uint32_t id = (uint32_t)box->id;
    const float *rows[AROUND];

    rows_around(w->d, box, w->z, y, rows);
    for (int x = box->low[0]; x <= box->high[0]; x++) {
        const size_t at = (size_t)y * (size_t)w->d->s->size[0] + (size_t)x;
        const int n = x - box->low[0];
        float distance;

        if (w->open[at] < 0 || id == w->below[at] || id == w->above[at])
            continue;
        distance = interpolate(rows[0][n], rows[1][n], rows[2][n], rows[3][n], w->layer);
        if (distance < w->open[at] && passes(w, box, x, y, rows[1][n], rows[2][n])) {
            w->open[at] = distance;
            winner[at] = id;
        }
    }
}

void sc_walls_keep(const distances *d, const blend *layer, int z, const float *least, float *open,
                   uint32_t *winner)
{
    const size_t pixels = (size_t)d->s->size[0] * (size_t)d->s->size[1];
    const uint16_t *below = d->s->ids + (size_t)z * pixels;
    const wall_search w = {d, layer, z, below, below + pixels, open};

    if (!find_open(&w, least, winner))
        return;
    for (int n = 0; n < d->count; n++) {
        const label_box *box = &d->boxes[n];

        if (z < box->low[2] || z + 1 > box->high[2])
            continue;
        for (int y = box->low[1]; y <= box->high[1]; y++)
            pass_in_row(&w, box, y, winner);
    }
}
