/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoothed distances from tissues, as a reference for surfaces drawn of their voxels. */
#include "rulers.h"

#include <stdlib.h>
#include <string.h>

#define SIGMA 2.2 /* of the Gaussian, in units of the smallest spacing */
#define REACH 4   /* of the Gaussian, in sigmas */
/* The largest distance, in units of the smallest spacing: of all tissue, and of one label. */
#define MOST 8
#define MOST_OF_LABEL 4
/* Squares of distances that are farther than any. */
#define FAR 1e30f

enum { WEIGHTS_MAX = 16 };

/* A filter along an axis: at each place, the least of in + weight of all places within reach, or
 * the sum of in * weight. */
typedef struct filter {
    bool is_least;
    int reach;
    float weights[WEIGHTS_MAX]; /* by distance */
} filter;

void field_open(const sc_volume *volume, field *f)
{
    *f = (field){.volume = volume, .unit = HUGE_VAL};
    for (int i = 0; i < 3; i++) {
        f->spacing[i] = sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i));
        f->unit = fmin(f->unit, f->spacing[i]);
    }
}

void field_free(field *f)
{
    free(f->at);
    free(f->room);
    free(f->sheet);
    *f = (field){0};
}

/* How many voxels along @p axis the Gaussian reaches. */
static int blur_reach(const field *f, int axis)
{
    return (int)ceil(REACH * SIGMA * f->unit / f->spacing[axis]);
}

/* How many voxels along @p axis a distance of @p most_mm reaches. */
static int distance_reach(const field *f, int axis, double most_mm)
{
    return (int)ceil(most_mm / f->spacing[axis]);
}

/* Make room for @p count voxels. */
static void reserve(field *f, size_t count)
{
    if (f->capacity >= count)
        return;
    f->capacity = count;
    f->at = realloc(f->at, count * sizeof(float));
    f->room = realloc(f->room, count * sizeof(float));
    f->sheet = realloc(f->sheet, count * sizeof(float));
    if (!f->at || !f->room || !f->sheet)
        abort();
}

/* Add one term of a filter for @p n places that stand side by side. */
static void add_term(const filter *k, int off, const float *restrict in, int n, float *restrict out)
{
    const float weight = k->weights[abs(off)];

    if (k->is_least) {
        for (int i = 0; i < n; i++) {
            const float value = in[i] + weight;

            out[i] = value < out[i] ? value : out[i];
        }
    } else {
        for (int i = 0; i < n; i++)
            out[i] += in[i] * weight;
    }
}

/* Filter @p count lines of @p n floats across them: line i is at @p lines + i * @p stride. Beyond
 * the ends the lines count as the last ones. @p sheet: room for a copy. */
static void filter_lines(const filter *k, float *lines, int count, size_t stride, int n,
                         float *sheet)
{
    for (int i = 0; i < count; i++) {
        memcpy(sheet + (size_t)i * (size_t)n, lines + (size_t)i * stride,
               (size_t)n * sizeof(float));
        for (int x = 0; x < n; x++)
            lines[(size_t)i * stride + (size_t)x] = k->is_least ? FAR : 0;
    }
    for (int i = 0; i < count; i++) {
        for (int off = -k->reach; off <= k->reach; off++) {
            const int from = i + off < 0 ? 0 : i + off >= count ? count - 1 : i + off;

            add_term(k, off, sheet + (size_t)from * (size_t)n, n, lines + (size_t)i * stride);
        }
    }
}

/* Filter one line of @p n floats along itself. @p sheet: room for it and its ends. */
static void filter_row(const filter *k, float *row, int n, float *sheet)
{
    for (int i = 0; i < n + 2 * k->reach; i++) {
        const int from = i - k->reach;

        sheet[i] = row[from < 0 ? 0 : from >= n ? n - 1 : from];
    }
    for (int i = 0; i < n; i++)
        row[i] = k->is_least ? FAR : 0;
    for (int off = -k->reach; off <= k->reach; off++)
        add_term(k, off, sheet + k->reach + off, n, row);
}

/* Filter @p values, which has the shape of the box, along @p axis. */
static void filter_along(const field *f, const filter *k, int axis, float *values)
{
    const size_t row = (size_t)f->size[0], layer = row * (size_t)f->size[1];

    if (axis == 2) {
        for (int y = 0; y < f->size[1]; y++)
            filter_lines(k, values + (size_t)y * row, f->size[2], layer, f->size[0], f->sheet);
        return;
    }
    for (int z = 0; z < f->size[2]; z++) {
        float *at = values + (size_t)z * layer;

        if (axis == 1)
            filter_lines(k, at, f->size[1], row, f->size[0], f->sheet);
        for (int y = 0; y < f->size[1] && axis == 0; y++)
            filter_row(k, at + (size_t)y * row, f->size[0], f->sheet);
    }
}

/* Set f->room to FAR in the voxels of one side of @p label, within (@p inside) or not, and to 0 in
 * all others. */
static void mark_side(field *f, int label, bool inside)
{
    const sc_volume *v = f->volume;
    float *mark = f->room;

    for (int z = f->low[2]; z < f->low[2] + f->size[2]; z++) {
        const int k = z < 0 ? 0 : z >= v->size[2] ? v->size[2] - 1 : z;

        for (int y = f->low[1]; y < f->low[1] + f->size[1]; y++) {
            const int j = y < 0 ? 0 : y >= v->size[1] ? v->size[1] - 1 : y;

            for (int x = f->low[0]; x < f->low[0] + f->size[0]; x++) {
                const int i = x < 0 ? 0 : x >= v->size[0] ? v->size[0] - 1 : x;
                const int id = id_at(v, i, j, k);

                *mark++ = (label == FIELD_TISSUE ? id != 0 : id == label) == inside ? FAR : 0;
            }
        }
    }
}

/* Add @p scale times the distance of one side of @p label, @p inside or outside of it, from the
 * other side: at most @p most_mm. */
static void add_distances(field *f, int label, bool inside, double most_mm, float scale)
{
    const size_t count = (size_t)f->size[0] * (size_t)f->size[1] * (size_t)f->size[2];
    const float half = (float)(f->unit / 2), most = (float)most_mm;

    mark_side(f, label, inside);
    for (int axis = 0; axis < 3; axis++) {
        filter k = {.is_least = true, .reach = distance_reach(f, axis, most_mm)};

        for (int i = 0; i <= k.reach; i++)
            k.weights[i] = (float)(i * f->spacing[axis] * i * f->spacing[axis]);
        filter_along(f, &k, axis, f->room);
    }
    for (size_t i = 0; i < count; i++) {
        const float mm = f->room[i] < most * most ? sqrtf(f->room[i]) : most;

        if (f->room[i] > 0)
            f->at[i] += scale * (mm - half);
    }
}

void field_make(field *f, const int low[3], const int high[3], int a, int b)
{
    const double most_mm = (a == FIELD_TISSUE ? MOST : MOST_OF_LABEL) * f->unit;
    size_t count = 1;

    for (int i = 0; i < 3; i++) {
        const int around = blur_reach(f, i) + distance_reach(f, i, most_mm) + 2;

        f->low[i] = low[i] - around;
        f->size[i] = high[i] - low[i] + 1 + 2 * around;
        count *= (size_t)f->size[i];
    }
    reserve(f, count);
    memset(f->at, 0, count * sizeof(float));
    add_distances(f, a, false, most_mm, -1);
    if (a == FIELD_TISSUE)
        add_distances(f, a, true, most_mm, 1);
    else
        add_distances(f, b, false, most_mm, 1);
    for (int axis = 0; axis < 3; axis++) {
        filter k = {.reach = blur_reach(f, axis)};
        double sum = 0;

        for (int i = -k.reach; i <= k.reach; i++)
            sum += exp(-0.5 * pow(i * f->spacing[axis] / (SIGMA * f->unit), 2));
        for (int i = 0; i <= k.reach; i++)
            k.weights[i] =
                (float)(exp(-0.5 * pow(i * f->spacing[axis] / (SIGMA * f->unit), 2)) / sum);
        filter_along(f, &k, axis, f->at);
    }
}

double field_value(const field *f, const float p[3])
{
    const size_t row = (size_t)f->size[0], layer = row * (size_t)f->size[1];
    size_t at = 0, step = 1;
    double part[3], sum = 0;

    for (int i = 0; i < 3; i++) {
        const int cell = (int)floorf(p[i]);

        at += (size_t)(cell - f->low[i]) * step;
        step *= (size_t)f->size[i];
        part[i] = (double)p[i] - cell;
    }
    for (int n = 0; n < 8; n++) {
        const int x = n & 1, y = n >> 1 & 1, z = n >> 2;
        const double weight =
            (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]) * (z ? part[2] : 1 - part[2]);

        sum += weight * (double)f->at[at + (size_t)x + (size_t)y * row + (size_t)z * layer];
    }
    return sum;
}

double field_slope(const field *f, const float p[3], double out[3])
{
    double square = 0;

    for (int i = 0; i < 3; i++) {
        float before[3] = {p[0], p[1], p[2]}, behind[3] = {p[0], p[1], p[2]};

        before[i] -= 1;
        behind[i] += 1;
        out[i] = (field_value(f, behind) - field_value(f, before)) / (2 * f->spacing[i]);
        square += out[i] * out[i];
    }
    return sqrt(square);
}
