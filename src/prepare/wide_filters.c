/* SPDX-License-Identifier: BSD-3-Clause */
/* Tables of the filters of strong smoothing. */
#include "wide_filters.h"

#include <string.h>

enum { PLAIN_RADIUS = 6 }; /* of the standard and the narrow filter for normals */
/* Strengths up to this one have the standard filter for normals, and do not tear tissue. */
#define PLAIN_MAX 1.25

static double squared(double x)
{
    return x * x;
}

/* Fill a table: for every pattern of a chunk and each of the four vertices x along the row, the sum
 * of the taps whose bits are set; the taps of vertex x begin at bit x of the row.
 * @param stride quads from the sums of a pattern to those of the next. */
static void fill_table(quad *table, size_t stride, int chunk, const float taps[TAPS])
{
    table[0] = (quad){0, 0, 0, 0};
    for (int bits = 1; bits < PATTERNS; bits++) {
        const int column = chunk * CHUNK_BITS + __builtin_ctz((unsigned)bits);
        quad sum = table[(size_t)(bits & (bits - 1)) * stride];

        for (int x = 0; x < SC_BRICK; x++)
            sum[x] += column >= x && column - x < TAPS ? taps[column - x] : 0;
        table[(size_t)bits * stride] = sum;
    }
}

void sc_flat_margins(const sc_weight_filter *w, double margins[3], double *total)
{
    double layers[3] = {0, 0, 0}, sum = 0;

    for (int i = 0; i < TAPS * TAPS * TAPS; i++) {
        const int at[3] = {i % TAPS - RADIUS, i / TAPS % TAPS - RADIUS, i / TAPS / TAPS - RADIUS};
        const double value =
            sc_weight_filter_at(w, squared(at[0] * w->steps[0]) + squared(at[1] * w->steps[1]) +
                                       squared(at[2] * w->steps[2]));

        sum += value;
        for (int axis = 0; axis < 3; axis++)
            layers[axis] += at[axis] == 0 ? value : 0;
    }
    *total = sum;
    for (int axis = 0; axis < 3; axis++)
        margins[axis] = layers[axis] / sum;
}

double sc_flat_margin(const sc_weight_filter *w, double *total)
{
    double margins[3];

    sc_flat_margins(w, margins, total);
    return fmax(fmax(margins[0], margins[1]), margins[2]);
}

/* Fill the rows of a filter for weights, and @p squares, the squared distance of each table. */
static void fill_rows(const sc_weight_filter *w, weights *out, double squares[TAPS * TAPS])
{
    for (int dz = -RADIUS; dz <= RADIUS; dz++) {
        for (int dy = -RADIUS; dy <= RADIUS; dy++) {
            const double square = squared(dy * w->steps[1]) + squared(dz * w->steps[2]);

            if (sc_weight_filter_at(w, square) != 0)
                out->rows[out->row_count++] =
                    (weight_row){(dz + RADIUS) * WINDOW + dy + RADIUS,
                                 sc_filter_table_of(squares, &out->table_count, square)};
        }
    }
}

/* @return whether the filter for weights reaches @p distance vertices along an axis. */
static bool reaches(const sc_weight_filter *w, int axis, int distance)
{
    return sc_weight_filter_at(w, squared(distance * w->steps[axis])) != 0;
}

/* Fill a filter for weights, which is zero, but for thin. @param steps of sc_filter_steps. Returns
 * SC_ERR_MEMORY. */
static sc_status fill_weights(const sc_ctx *ctx, filters *f, const double steps[3],
                              sc_vec3 strength, weights *out)
{
    const bool crisp = !(sc_most_strength(strength) > 0);
    const sc_weight_filter w = sc_weight_filter_of(steps, crisp ? (sc_vec3){1, 1, 1} : strength);
    double squares[TAPS * TAPS], total;
    int reach = 0;
    void *block;
    sc_status status;

    out->crisp = crisp;
    if (crisp)
        return SC_OK;
    out->gain = (float)(f->flat / fmin(sc_flat_margin(&w, &total), 1)); /* weak ones overshoot */
    fill_rows(&w, out, squares);
    status = sc_alloc(ctx, (size_t)out->table_count, sizeof *out->tables, &block);
    if (status != SC_OK)
        return status;
    out->tables = block;
    for (int t = 0; t < out->table_count; t++) {
        float taps[TAPS];

        for (int x = -RADIUS; x <= RADIUS; x++)
            taps[x + RADIUS] =
                (float)(sc_weight_filter_at(&w, squares[t] + squared(x * w.steps[0])) / total);
        for (int chunk = 0; chunk < CHUNKS; chunk++)
            fill_table(out->tables[t][chunk], 1, chunk, taps);
    }
    while (reach < RADIUS && reaches(&w, 0, reach + 1))
        reach++;
    out->first_chunk = (RADIUS - reach) / CHUNK_BITS;
    out->last_chunk = (RADIUS + SC_BRICK - 1 + reach) / CHUNK_BITS;
    for (int axis = 1; axis < 3; axis++) {
        while (reach < RADIUS && reaches(&w, axis, reach + 1))
            reach++;
    }
    f->reach = reach > f->reach ? reach : f->reach;
    return SC_OK;
}

/* Fill a filter for normals, which is zero. @param widths standard deviation along each axis, in
 * reference voxels. Returns SC_ERR_MEMORY.
 * The slopes are such that an interface across any axis has a gradient of 1, so that the length
 * tells how thin tissue is. The true gradient is that divided by the width: of a tilted plane the
 * component along an axis that is smoothed twice as much would come out twice as large, and its
 * normal lean. Upright makes up for that. */
static sc_status fill_normals(const sc_ctx *ctx, filters *f, const double steps[3], int radius,
                              const double widths[3], normals *out)
{
    float along_x[2][TAPS] = {{0}};
    void *block;
    sc_status status = sc_alloc(ctx, CHUNKS, sizeof *out->table, &block);

    if (status != SC_OK)
        return status;
    out->table = block;
    out->radius = radius;
    f->reach = radius > f->reach ? radius : f->reach;
    for (int axis = 0; axis < 3; axis++) {
        sc_normal_taps(radius, steps[axis], widths[axis], out->value[axis], out->slope[axis]);
        out->upright[axis] = (float)(fmin(fmin(widths[0], widths[1]), widths[2]) / widths[axis]);
    }
    memcpy(along_x[0] + RADIUS - radius, out->value[0],
           (size_t)(2 * radius + 1) * sizeof out->value[0][0]);
    memcpy(along_x[1] + RADIUS - radius, out->slope[0],
           (size_t)(2 * radius + 1) * sizeof out->slope[0][0]);
    for (int chunk = 0; chunk < CHUNKS; chunk++) {
        fill_table(&out->table[chunk][0][0], 2, chunk, along_x[0]);
        fill_table(&out->table[chunk][0][1], 2, chunk, along_x[1]);
    }
    return SC_OK;
}

/* @return how many times as wide as the standard filter for normals that of a strength is. */
static double widening(double strength)
{
    return fmax(strength / PLAIN_MAX, 1);
}

/* Fill the filters of kind @p k: for weights, for those where tissue is thin, and for normals.
 * Returns SC_ERR_MEMORY. */
static sc_status fill_kind(const sc_ctx *ctx, filters *f, const double steps[3], int k)
{
    const sc_vec3 s = f->p->kinds[k];
    const double wider[3] = {widening(s.x), widening(s.y), widening(s.z)};
    const double most = fmax(fmax(wider[0], wider[1]), wider[2]);
    const int radius = (int)fmin(ceil(PLAIN_RADIUS * most), RADIUS);
    double widths[3];
    sc_status status;

    f->weights[k].thin = -1;
    SC_TRY(fill_weights(ctx, f, steps, s, &f->weights[k]));
    if (!(most > 1))
        return SC_OK;
    f->weights[k].thin = f->filter_count++;
    f->weights[f->weights[k].thin].thin = -1;
    SC_TRY(fill_weights(ctx, f, steps, (sc_vec3){fmin(s.x, 1), fmin(s.y, 1), fmin(s.z, 1)},
                        &f->weights[f->weights[k].thin]));
    for (int i = 0; i < 3; i++)
        widths[i] = SC_NORMAL_WIDTH * wider[i];
    status = fill_normals(ctx, f, steps, radius, widths, &f->normals[STANDARD + 1 + k]);
out:
    return status;
}

sc_status sc_wide_filters_fill(const sc_ctx *ctx, filters *f)
{
    static const double standard[3] = {SC_NORMAL_WIDTH, SC_NORMAL_WIDTH, SC_NORMAL_WIDTH};
    static const double narrow[3] = {SC_NARROW_WIDTH, SC_NARROW_WIDTH, SC_NARROW_WIDTH};
    double steps[3], total;
    sc_weight_filter one;
    sc_status status;

    sc_filter_steps(f->p->volume, steps);
    one = sc_weight_filter_of(steps, (sc_vec3){1, 1, 1});
    f->flat = (float)sc_flat_margin(&one, &total);
    f->filter_count = f->p->kind_count;
    for (int k = 0; k < f->p->kind_count; k++)
        SC_TRY(fill_kind(ctx, f, steps, k));
    SC_TRY(fill_normals(ctx, f, steps, PLAIN_RADIUS, standard, &f->normals[STANDARD]));
    SC_TRY(fill_normals(ctx, f, steps, PLAIN_RADIUS, narrow, &f->normals[NARROW]));
    sc_gradient_to_mm(f->p->volume, steps, f->to_mm);
out:
    return status;
}

void sc_wide_filters_clear(filters *f)
{
    for (int i = 0; i < FILTERS_MAX; i++)
        sc_free(f->weights[i].tables);
    for (int i = 0; i < NORMALS_MAX; i++)
        sc_free(f->normals[i].table);
}
