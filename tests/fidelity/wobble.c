/* SPDX-License-Identifier: BSD-3-Clause */
/* How much drawn outlines and seams waver about smooth references. */
#include "rulers.h"

#include <stdlib.h>
#include <string.h>

enum {
    BLOCK = 32,       /* voxels along an edge of the blocks whose points are placed together */
    LEAST_POINTS = 50 /* of a pair of tissues that is measured */
};
/* Lengths in units of the smallest spacing: the farthest from the reference, the Gaussian of the
 * local mean, and its reach. */
#define FARTHEST 2.0
#define MEAN_SIGMA 2.0
#define MEAN_REACH 6.0
/* Least slopes of the references: of outlines, and of both outline and seam at points of seams. */
#define LEAST_SLOPE 0.85
#define LEAST_SEAM_SLOPE 0.5

/* A point and the key by which points are sorted. */
typedef struct keyed {
    uint64_t key;
    wobble_point *point;
} keyed;

/* Points of a list that are sorted by keys, in groups of the same key. */
typedef struct groups {
    const sc_volume *volume;
    keyed *points;
    size_t *starts; /* [count + 1]: of the groups, and the end of the last */
    size_t count;
} groups;

/* Order of two keyed points, for qsort: by key, then by their order in the list. */
static int by_key(const void *a, const void *b)
{
    const keyed *x = a, *y = b;

    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->point > y->point) - (x->point < y->point);
}

/* The key of a place counted in blocks or cells, of which there may be 1024 along an axis, and the
 * pair. */
static uint64_t key_of(const int at[3], uint32_t pair)
{
    return (uint64_t)pair << 30 | (uint64_t)at[2] << 20 | (uint64_t)at[1] << 10 | (uint64_t)at[0];
}

/* Make room for @p count elements of @p bytes. Aborts without memory. */
static void *make(size_t count, size_t bytes)
{
    void *block = calloc(count, bytes);

    if (!block)
        abort();
    return block;
}

/* Group the points of a list by blocks and, with @p by_pair, pairs. groups_free. */
static groups group(const sc_volume *volume, const wobble_points *points, bool by_pair)
{
    groups g = {.volume = volume, .points = make(points->count + 1, sizeof *g.points)};

    g.starts = make(points->count + 1, sizeof *g.starts);
    for (size_t n = 0; n < points->count; n++) {
        wobble_point *p = &points->list[n];
        int block[3];

        for (int i = 0; i < 3; i++)
            block[i] = (int)p->at[i] / BLOCK;
        g.points[n] = (keyed){key_of(block, by_pair ? p->pair : 0), p};
    }
    qsort(g.points, points->count, sizeof *g.points, by_key);
    for (size_t n = 0; n < points->count; n++) {
        if (!n || g.points[n].key != g.points[n - 1].key)
            g.starts[g.count++] = n;
    }
    g.starts[g.count] = points->count;
    return g;
}

/* Free what groups own. */
static void groups_free(groups *g)
{
    free(g->points);
    free(g->starts);
}

/* Make the field @p a, @p b around the points of group @p n. */
static void make_around(field *f, const groups *g, size_t n, int a, int b)
{
    int low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {0};

    for (size_t k = g->starts[n]; k < g->starts[n + 1]; k++) {
        for (int i = 0; i < 3; i++) {
            const int at = (int)g->points[k].point->at[i];

            low[i] = at < low[i] ? at : low[i];
            high[i] = at + 1 > high[i] ? at + 1 : high[i];
        }
    }
    field_make(f, low, high, a, b);
}

/* Worker of sc_parallel_for: for the points of groups [@p begin, @p end) set the normal of the
 * reference of the outline, and their distance from it. @p user: groups. */
static void place_on_outline(void *user, size_t begin, size_t end, int thread)
{
    const groups *g = user;
    SC_OWN(field_free) field f = {0};

    field_open(g->volume, &f);
    for (size_t n = begin; n < end; n++) {
        make_around(&f, g, n, FIELD_TISSUE, 0);
        for (size_t k = g->starts[n]; k < g->starts[n + 1]; k++) {
            wobble_point *p = g->points[k].point;
            const double least = p->pair ? LEAST_SEAM_SLOPE : LEAST_SLOPE;
            double normal[3];
            const double slope = field_slope(&f, p->at, normal), off = field_value(&f, p->at);

            for (int i = 0; i < 3 && slope > 0; i++)
                p->normal[i] = (float)(normal[i] / slope);
            p->off_mm =
                fabs(off) < FARTHEST * f.unit && slope >= least ? (float)(off / slope) : (float)NAN;
        }
    }
}

/* Worker of sc_parallel_for: for the points of seams of groups [@p begin, @p end), which have
 * normals, set their distance from the reference of the seam, within the surface. @p user: groups
 * by blocks and pairs. */
static void place_on_seams(void *user, size_t begin, size_t end, int thread)
{
    const groups *g = user;
    SC_OWN(field_free) field f = {0};

    field_open(g->volume, &f);
    for (size_t n = begin; n < end; n++) {
        const uint32_t pair = g->points[g->starts[n]].point->pair;

        make_around(&f, g, n, (int)(pair >> 16), (int)(pair & 0xffff));
        for (size_t k = g->starts[n]; k < g->starts[n + 1]; k++) {
            wobble_point *p = g->points[k].point;
            double slope[3], along = 0, square = 0, off;

            (void)field_slope(&f, p->at, slope);
            for (int i = 0; i < 3; i++)
                along += slope[i] * (double)p->normal[i];
            for (int i = 0; i < 3; i++)
                square += pow(slope[i] - along * (double)p->normal[i], 2);
            off = field_value(&f, p->at) / sqrt(square);
            if (isnan(p->off_mm) || !(square >= LEAST_SEAM_SLOPE * LEAST_SEAM_SLOPE) ||
                fabs(off) > FARTHEST * f.unit)
                p->off_mm = (float)NAN;
            else
                p->off_mm = (float)off;
        }
    }
}

/* Points that have been placed, sorted by the cells of MEAN_REACH that hold them, and by pairs; and
 * what the worker take_means needs. */
typedef struct means {
    double spacing[3], unit; /* mm */
    keyed *points;           /* [count] */
    size_t count;
    double *rests; /* [count]: the distance of each less that of those around, mm */
} means;

/* The cell that holds a point, to @p out; counted from 1, so that each has one before it. */
static void cell_of(const means *m, const wobble_point *p, int out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = 1 + (int)((double)p->at[i] * m->spacing[i] / (MEAN_REACH * m->unit));
}

/* The first of the points whose key is @p key or more. */
static size_t first_from(const means *m, uint64_t key)
{
    size_t low = 0, high = m->count;

    while (low < high) {
        const size_t middle = low + (high - low) / 2;

        if (m->points[middle].key < key)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Worker of sc_parallel_for: set the rests of points [@p begin, @p end). @p user: means. */
static void take_means(void *user, size_t begin, size_t end, int thread)
{
    const means *m = user;
    const double scale = 0.5 / (MEAN_SIGMA * m->unit * MEAN_SIGMA * m->unit);
    const double most = MEAN_REACH * m->unit * MEAN_REACH * m->unit;

    for (size_t n = begin; n < end; n++) {
        const wobble_point *p = m->points[n].point;
        double sum = 0, weights = 0;
        int cell[3];

        cell_of(m, p, cell);
        for (int row = 0; row < 9; row++) {
            const int y = cell[1] + row % 3 - 1, z = cell[2] + row / 3 - 1;
            const uint64_t last = key_of((const int[3]){cell[0] + 1, y, z}, p->pair);
            size_t k = first_from(m, key_of((const int[3]){cell[0] - 1, y, z}, p->pair));

            for (; k < m->count && m->points[k].key <= last; k++) {
                const wobble_point *q = m->points[k].point;
                double square = 0, weight;

                for (int i = 0; i < 3; i++)
                    square += pow((double)(q->at[i] - p->at[i]) * m->spacing[i], 2);
                if (square > most)
                    continue;
                weight = exp(-scale * square);
                sum += weight * (double)q->off_mm;
                weights += weight;
            }
        }
        m->rests[n] = (double)p->off_mm - sum / weights;
    }
}

/* Sort the points that have been placed, by pairs and cells; without the pairs that have fewer than
 * @p least. @p pairs: how many are left. */
static void sort_placed(means *m, const wobble_points *points, size_t least, size_t *pairs)
{
    size_t count = 0, kept = 0;

    m->points = make(points->count + 1, sizeof *m->points);
    for (size_t n = 0; n < points->count; n++) {
        wobble_point *p = &points->list[n];
        int cell[3];

        if (isnan(p->off_mm))
            continue;
        cell_of(m, p, cell);
        m->points[count++] = (keyed){key_of(cell, p->pair), p};
    }
    qsort(m->points, count, sizeof *m->points, by_key);
    *pairs = 0;
    for (size_t n = 0, end; n < count; n = end) {
        for (end = n; end < count && m->points[end].point->pair == m->points[n].point->pair;)
            end++;
        if (end - n < least)
            continue;
        ++*pairs;
        memmove(&m->points[kept], &m->points[n], (end - n) * sizeof *m->points);
        kept += end - n;
    }
    m->count = kept;
}

/* The RMS, in units of the smallest spacing, of the distances of the points less their local means;
 * NAN for fewer than LEAST_POINTS. @p least: points of a pair. */
static double rms_of(const sc_volume *volume, int threads, const wobble_points *points,
                     size_t least, size_t *count, size_t *pairs)
{
    means m = {.unit = HUGE_VAL};
    double squares = 0;

    for (int i = 0; i < 3; i++) {
        m.spacing[i] = sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i));
        m.unit = fmin(m.unit, m.spacing[i]);
    }
    sort_placed(&m, points, least, pairs);
    m.rests = make(m.count + 1, sizeof *m.rests);
    sc_parallel_for(threads, m.count, 256, take_means, &m);
    for (size_t n = 0; n < m.count; n++)
        squares += m.rests[n] * m.rests[n];
    *count = m.count;
    free(m.points);
    free(m.rests);
    return m.count < LEAST_POINTS ? NAN : sqrt(squares / (double)m.count) / m.unit;
}

sc_status measure_wobble(const sc_ctx *ctx, const sc_volume *volume, const drawing *how,
                         wobble *out)
{
    wobble_points outline = {0}, seams = {0};
    SC_OWN(stage_close) stage st = {0};
    size_t ignored;
    groups g;
    sc_status status;

    *out = (wobble){NAN, NAN, 0, 0, 0};
    SC_TRY(stage_open(ctx, volume, how, 1.02, 0.1, &st));
    wobble_find(&st, how->threads, &outline, &seams);
    g = group(volume, &outline, false);
    sc_parallel_for(how->threads, g.count, 1, place_on_outline, &g);
    groups_free(&g);
    g = group(volume, &seams, false);
    sc_parallel_for(how->threads, g.count, 1, place_on_outline, &g);
    groups_free(&g);
    g = group(volume, &seams, true);
    sc_parallel_for(how->threads, g.count, 1, place_on_seams, &g);
    groups_free(&g);
    out->outline = rms_of(volume, how->threads, &outline, 0, &out->outline_points, &ignored);
    out->seam = rms_of(volume, how->threads, &seams, LEAST_POINTS, &out->seam_points, &out->pairs);
out:
    free(outline.list);
    free(seams.list);
    return status;
}
