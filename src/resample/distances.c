/* SPDX-License-Identifier: BSD-3-Clause */
/* Exact Euclidean distances within slices, in two passes: down the columns, then along the rows by
 * the lower envelope of parabolas (Felzenszwalb and Huttenlocher, Distance Transforms of Sampled
 * Functions, 2012). */
#include "distances.h"

/* How far around the voxels of a label distances from it are measured, in distances of slices.
 * Farther away another label is always nearer. */
#define MARGIN 2.5

/* @return how many pixels a box is wide, or high. */
static size_t length_of(const label_box *box, int axis)
{
    return (size_t)box->high[axis] - (size_t)box->low[axis] + 1;
}

/* @return the box of a label with its margin, the values of which begin at @p at. */
static label_box with_margin(const stack *s, const sc_label_tally *voxels, int id, size_t at)
{
    label_box box = {.id = id, .at = at, .low[2] = voxels->low[2], .high[2] = voxels->high[2]};

    for (int i = 0; i < 2; i++) {
        const int last = s->size[i] - 1;
        const int margin = (int)fmin(last, 1 + MARGIN / s->step[i]);

        box.low[i] = voxels->low[i] > margin ? voxels->low[i] - margin : 0;
        box.high[i] = voxels->high[i] < last - margin ? voxels->high[i] + margin : last;
    }
    return box;
}

sc_status sc_distances_open(const sc_ctx *ctx, const stack *s, const sc_label_tally *voxels,
                            int label_count, int slots, int threads, distances *d)
{
    *d = (distances){.s = s, .slots = slots, .threads = threads};
    SC_PASS(SC_ALLOC(ctx, (size_t)label_count, &d->boxes));
    for (int id = 0; id < label_count; id++) {
        label_box *box = &d->boxes[d->count];

        if (!voxels[id].voxels)
            continue;
        *box = with_margin(s, &voxels[id], id, d->room);
        d->room += length_of(box, 0) * length_of(box, 1);
        d->count++;
    }
    SC_PASS(SC_ALLOC(ctx, (size_t)slots * d->room, &d->values));
    return SC_ALLOC(ctx, (size_t)threads * 3 * (size_t)s->size[0], &d->scratch);
}

double sc_distances_bytes(const stack *s, const sc_label_tally *voxels, int label_count, int slots,
                          int threads)
{
    double room = 0;

    for (int id = 0; id < label_count; id++) {
        const label_box box = with_margin(s, &voxels[id], id, 0);

        if (voxels[id].voxels)
            room += (double)length_of(&box, 0) * (double)length_of(&box, 1);
    }
    return (slots * room + 3.0 * threads * s->size[0]) * sizeof(float);
}

void sc_distances_clear(distances *d)
{
    sc_free(d->boxes);
    sc_free(d->values);
    sc_free(d->scratch);
    *d = (distances){0};
}

/* ---- distances ---- */

/* @return where the values of a label in slice @p z are. */
static float *values_of(const distances *d, const label_box *box, int z)
{
    return d->values + (size_t)(z % d->slots) * d->room + box->at;
}

/* @return the ids of row @p y of slice @p z from the first pixel of a box on. */
static const uint16_t *ids_of(const distances *d, const label_box *box, int z, int y)
{
    const int *size = d->s->size;

    return d->s->ids + ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0] + box->low[0];
}

/* Write to @p out, for each pixel of a label's box in slice @p z, how many pixels it is down or up
 * its column to one on the other side of the border. */
static void measure_columns(const distances *d, const label_box *box, int z, float *out)
{
    const size_t nx = length_of(box, 0);
    const uint16_t *ids;

    for (size_t x = 0; x < nx; x++)
        out[x] = NO_BORDER;
    for (int y = box->low[1] + 1; y <= box->high[1]; y++) {
        const uint16_t *before = ids_of(d, box, z, y - 1);
        float *row = out + (size_t)(y - box->low[1]) * nx, *last = row - nx;

        ids = ids_of(d, box, z, y);
        for (size_t x = 0; x < nx; x++)
            row[x] = (ids[x] == box->id) == (before[x] == box->id) ? last[x] + 1 : 1;
    }
    for (int y = box->high[1] - 1; y >= box->low[1]; y--) {
        const uint16_t *behind = ids_of(d, box, z, y + 1);
        float *row = out + (size_t)(y - box->low[1]) * nx;

        ids = ids_of(d, box, z, y);
        for (size_t x = 0; x < nx; x++) {
            const float up = (ids[x] == box->id) == (behind[x] == box->id) ? row[x + nx] + 1 : 1;

            row[x] = up < row[x] ? up : row[x];
        }
    }
}

/* The parabolas x -> height + (x - at)^2 that are the lowest of all somewhere. */
typedef struct envelope {
    float *at, *height; /* [count] of each, at rising */
    float *begin;       /* [count]: the parabola is the lowest from here on */
    int count;
} envelope;

/* Add a parabola whose place is behind those of all others. */
static void add_parabola(envelope *e, float at, float height)
{
    float begin = -NO_BORDER;

    if (height >= NO_BORDER)
        return;
    while (e->count > 0) {
        const int last = e->count - 1;

        begin = 0.5f * ((height - e->height[last]) / (at - e->at[last]) + at + e->at[last]);
        if (begin > e->begin[last])
            break;
        begin = -NO_BORDER;
        e->count--;
    }
    e->at[e->count] = at;
    e->height[e->count] = height;
    e->begin[e->count++] = begin;
}

/* Turn the distances down the columns into signed ones in the whole slice, for the pixels [begin,
 * end) of a row, which all lie on the same side of the border, up to pixels of the other side or to
 * the end of the row of @p nx pixels. @param sign that of the result. */
static void measure_run(const stack *s, float *row, int begin, int end, int nx, float sign,
                        envelope e)
{
    const float ratio = s->step[1] / s->step[0];
    const float half = 0.5f * (s->step[0] < s->step[1] ? s->step[0] : s->step[1]);

    e.count = 0;
    if (begin > 0)
        add_parabola(&e, (float)(begin - 1), 0);
    for (int x = begin; x < end; x++)
        add_parabola(&e, (float)x,
                     row[x] < NO_BORDER ? ratio * row[x] * (ratio * row[x]) : NO_BORDER);
    if (end < nx)
        add_parabola(&e, (float)end, 0);
    for (int x = begin, n = 0; x < end; x++) {
        while (n + 1 < e.count && e.begin[n + 1] < (float)x)
            n++;
        if (e.count == 0) {
            row[x] = sign * NO_BORDER;
        } else {
            const float off = (float)x - e.at[n];

            row[x] = sign * (s->step[0] * sqrtf(off * off + e.height[n]) - half);
        }
    }
}

/* Measure the distances of the labels and slices numbered [begin, end) from those to be measured;
 * an sc_range_fn on distances. */
static void measure(void *user, size_t begin, size_t end, int thread)
{
    const distances *d = user;
    float *scratch = d->scratch + (size_t)thread * 3 * (size_t)d->s->size[0];
    const envelope e = {scratch, scratch + d->s->size[0], scratch + 2 * d->s->size[0], 0};

    for (size_t n = begin; n < end; n++) {
        const label_box *box = &d->boxes[n % (size_t)d->count];
        const int z = d->end + (int)(n / (size_t)d->count), nx = (int)length_of(box, 0);
        float *row = values_of(d, box, z);

        measure_columns(d, box, z, row);
        for (int y = box->low[1]; y <= box->high[1]; y++, row += nx) {
            const uint16_t *ids = ids_of(d, box, z, y);

            for (int x = 0, last; x < nx; x = last + 1) {
                const bool inside = ids[x] == box->id;

                for (last = x; last + 1 < nx && (ids[last + 1] == box->id) == inside;)
                    last++;
                measure_run(d->s, row, x, last + 1, nx, inside ? -1 : 1, e);
            }
        }
    }
}

void sc_distances_measure(distances *d, int end)
{
    if (end <= d->end)
        return;
    sc_parallel_for(d->threads, (size_t)(end - d->end) * (size_t)d->count, 1, measure, d);
    d->end = end;
}

const float *sc_distances_row(const distances *d, const label_box *box, int z, int y)
{
    return values_of(d, box, z) + (size_t)(y - box->low[1]) * length_of(box, 0);
}
