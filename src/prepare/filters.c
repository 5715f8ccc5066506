/* SPDX-License-Identifier: BSD-3-Clause */
/* The filters of memberships: their lengths, values and taps. */
#include "filters.h"

/* The filter for weights. Lengths are in reference voxels: see sc_filter_steps. */
#define WEIGHT_WIDTH 1.55   /* standard deviation of its Gaussian, s */
#define WEIGHT_EXCESS 1.283 /* c as a multiple of s^2 / 2 */
#define WEIGHT_THIRD 0.75   /* share of the third-order term */
#define WEIGHT_REACH 5.7    /* the filter is 0 beyond this distance */
/* Lengthens the steps of an axis that is not smoothed, so that the next voxel is out of reach. */
#define FAR 1e6

enum { TAPS_MAX = 64 };

static double squared(double x)
{
    return x * x;
}

void sc_filter_steps(const sc_volume *v, double steps[3])
{
    double spacing[3], reference;

    for (int i = 0; i < 3; i++)
        spacing[i] = sc_vec3_length(sc_affine_column(&v->to_ras_mm, i));
    reference = cbrt(spacing[0] * spacing[1] * spacing[2]);
    for (int i = 0; i < 3; i++)
        steps[i] = fmin(fmax(spacing[i] / reference, 1 / 1.2), 1 / 0.7);
}

sc_weight_filter sc_weight_filter_of(const double steps[3], sc_vec3 strength)
{
    const double along[3] = {strength.x, strength.y, strength.z};
    sc_weight_filter f = {.strength = fmax(fmax(along[0], along[1]), along[2])};

    for (int i = 0; i < 3; i++) {
        const bool smoothed = WEIGHT_REACH * along[i] > steps[i];

        f.dimensions += smoothed;
        f.steps[i] = steps[i] * (smoothed ? f.strength / along[i] : FAR);
    }
    if (f.dimensions == 0) /* one voxel alone, with lengths whose squares are no longer 0 */
        f.strength = 1;
    return f;
}

/* The orders of the series are powers of the Laplacian, and those of a Gaussian are Laguerre
 * polynomials of u, which depend on the number n of dimensions. */
double sc_weight_filter_at(const sc_weight_filter *f, double square)
{
    const double s = WEIGHT_WIDTH * f->strength, u = square / (s * s), k = WEIGHT_EXCESS / 2;
    const double n = f->dimensions;
    const double second = u * u - 2 * (n + 2) * u + n * (n + 2);
    const double third =
        u * u * u - 3 * (n + 4) * u * u + 3 * (n + 2) * (n + 4) * u - n * (n + 2) * (n + 4);

    if (square >= WEIGHT_REACH * WEIGHT_REACH * f->strength * f->strength)
        return 0;
    return exp(-u / 2) *
           (1 - k * (u - n) + k * k / 2 * second - WEIGHT_THIRD * k * k * k / 6 * third);
}

void sc_normal_taps(int radius, double step, double width, float *value, float *slope)
{
    const double rim = exp(-squared((radius + 1) / width) / 2);
    double values[TAPS_MAX], slopes[TAPS_MAX], sum = 0, flat = 0;

    for (int i = -radius; i <= radius; i++) {
        const double x = i * step, bell = exp(-squared(x / width) / 2);

        values[i + radius] = fmax(bell - rim, 0);
        slopes[i + radius] = step * x * bell;
        sum += values[i + radius];
        flat += i > 0 ? slopes[i + radius] : 0;
    }
    for (int i = 0; i <= 2 * radius; i++) {
        value[i] = (float)(values[i] / sum);
        slope[i] = (float)(slopes[i] / flat);
    }
}

/* Farther than this from the last voxel the copies are left alone: they take less from what meets
 * the border, and a surface that only runs beside it would be turned. */
#define BORDER_VOXELS 1
/* So far around a vertex, in the last layer of voxels, is looked for what meets the border. */
#define BORDER_AROUND 4
/* The most that a gradient is multiplied by: a voxel outside of the volume it would be 3. */
#define BORDER_GAIN_MAX 3.0f

/* Does the last layer of voxels across @p axis, on the side of @p voxel, hold more than one label
 * around it: does an interface meet the border there? */
static bool meets_border(const sc_volume *v, const int voxel[3], int axis)
{
    const int across = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
    int at[3] = {voxel[0], voxel[1], voxel[2]};
    uint32_t first;

    at[axis] = 2 * voxel[axis] < v->size[axis] ? 0 : v->size[axis] - 1;
    first = sc_id_or_nearest(v, at[0], at[1], at[2]);
    for (int j = -BORDER_AROUND; j <= BORDER_AROUND; j++) {
        for (int i = -BORDER_AROUND; i <= BORDER_AROUND; i++) {
            at[across] = voxel[across] + i;
            at[up] = voxel[up] + j;
            if (sc_id_or_nearest(v, at[0], at[1], at[2]) != first)
                return true;
        }
    }
    return false;
}

void sc_gradient_at_border(const sc_volume *v, const int voxel[3], int radius,
                           const float *const slope[3], float gradient[3])
{
    for (int axis = 0; axis < 3; axis++) {
        float whole = 0, seen = 0; /* of an even rise, and of one that ends at the border */

        if ((voxel[axis] > BORDER_VOXELS && voxel[axis] < v->size[axis] - 1 - BORDER_VOXELS) ||
            !meets_border(v, voxel, axis))
            continue;
        for (int i = -radius; i <= radius; i++) {
            const float tap = slope[axis][i + radius];

            whole += tap * (float)i;
            seen += tap * (float)(sc_nearest_voxel(voxel[axis] + i, v->size[axis]) - voxel[axis]);
        }
        if (seen > 0) /* not so if the volume is one voxel thick */
            gradient[axis] *= fminf(whole / seen, BORDER_GAIN_MAX);
    }
}

bool sc_is_by_border(const sc_volume *v, const int low[3], int radius)
{
    for (int i = 0; i < 3; i++) {
        if (low[i] - 1 < radius || low[i] - 1 + SC_BRICK + radius > v->size[i])
            return true;
    }
    return false;
}

void sc_gradient_to_mm(const sc_volume *v, const double steps[3], double to_mm[3][3])
{
    sc_affine inverse = {0};
    double reference = 1;

    /* Gradients per reference voxel, times the length of a voxel, are gradients per voxel; those
     * map to RAS by the transposed inverse. It exists: the reader of the volume has checked. The
     * map is scaled so that a gradient of 1 keeps its length, on the average of the axes, where
     * their steps are limited; it does not depend on their order. */
    (void)sc_affine_invert(&v->to_ras_mm, &inverse);
    for (int i = 0; i < 3; i++)
        reference *= sc_vec3_length(sc_affine_column(&v->to_ras_mm, i)) / steps[i];
    reference = cbrt(reference);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            to_mm[i][j] = inverse.m[j][i] * reference * steps[j];
    }
}

uint32_t sc_field_record(const double to_mm[3][3], int weight, const float outward[3])
{
    double n[3], length;

    for (int i = 0; i < 3; i++)
        n[i] = to_mm[i][0] * outward[0] + to_mm[i][1] * outward[1] + to_mm[i][2] * outward[2];
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 1e-6))
        return sc_record_pack(weight, (sc_vec3){0, 0, 1}, 0);
    return sc_record_pack(weight, (sc_vec3){n[0], n[1], n[2]}, length);
}

int sc_filter_table_of(double *squares, int *count, double square)
{
    for (int i = 0; i < *count; i++) {
        if (fabs(squares[i] - square) < 1e-9)
            return i;
    }
    squares[*count] = square;
    return (*count)++;
}
