/* SPDX-License-Identifier: BSD-3-Clause */
/* Vectors, affine maps and boxes: the functions that are not inline. */
#include "segcast/geom.h"

sc_vec3 sc_vec3_perpendicular(sc_vec3 a)
{
    const double ax = fabs(a.x), ay = fabs(a.y), az = fabs(a.z);
    sc_vec3 other = {0, 0, 1};

    if (ax <= ay && ax <= az)
        other = (sc_vec3){1, 0, 0};
    else if (ay <= az)
        other = (sc_vec3){0, 1, 0};
    return sc_vec3_unit(sc_vec3_cross(a, other));
}

sc_vec3 sc_vec3_rotate(sc_vec3 v, sc_vec3 axis, double angle_rad)
{
    const double c = cos(angle_rad), s = sin(angle_rad);
    const double along = sc_vec3_dot(axis, v) * (1 - c);
    const sc_vec3 across = sc_vec3_cross(axis, v);

    return sc_vec3_add(sc_vec3_scale(v, c), sc_vec3_along(sc_vec3_scale(across, s), along, axis));
}

sc_vec3 sc_affine_vector(const sc_affine *a, sc_vec3 v)
{
    return (sc_vec3){a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                     a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                     a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z};
}

sc_vec3 sc_affine_point(const sc_affine *a, sc_vec3 p)
{
    const sc_vec3 shift = {a->m[0][3], a->m[1][3], a->m[2][3]};

    return sc_vec3_add(sc_affine_vector(a, p), shift);
}

sc_vec3 sc_affine_column(const sc_affine *a, int axis)
{
    return (sc_vec3){a->m[0][axis], a->m[1][axis], a->m[2][axis]};
}

double sc_affine_determinant(const sc_affine *a)
{
    return sc_vec3_dot(sc_affine_column(a, 0),
                       sc_vec3_cross(sc_affine_column(a, 1), sc_affine_column(a, 2)));
}

sc_affine sc_affine_compose(const sc_affine *then, const sc_affine *first)
{
    sc_affine out;

    for (int axis = 0; axis < 4; axis++) {
        const sc_vec3 column = sc_affine_column(first, axis);
        const sc_vec3 to =
            axis < 3 ? sc_affine_vector(then, column) : sc_affine_point(then, column);

        out.m[0][axis] = to.x;
        out.m[1][axis] = to.y;
        out.m[2][axis] = to.z;
    }
    return out;
}

bool sc_affine_invert(const sc_affine *a, sc_affine *out)
{
    const double determinant = sc_affine_determinant(a);
    const sc_vec3 x = sc_affine_column(a, 0), y = sc_affine_column(a, 1);
    const sc_vec3 z = sc_affine_column(a, 2), shift = sc_affine_column(a, 3);
    const double scale = sc_vec3_length(x) * sc_vec3_length(y) * sc_vec3_length(z);
    const sc_vec3 rows[3] = {sc_vec3_cross(y, z), sc_vec3_cross(z, x), sc_vec3_cross(x, y)};
    sc_affine inverse;

    if (!isfinite(determinant) || !isfinite(1 / determinant) || fabs(determinant) <= 1e-9 * scale)
        return false;
    for (int i = 0; i < 3; i++) {
        const sc_vec3 row = sc_vec3_scale(rows[i], 1 / determinant);

        inverse.m[i][0] = row.x;
        inverse.m[i][1] = row.y;
        inverse.m[i][2] = row.z;
        inverse.m[i][3] = -sc_vec3_dot(row, shift);
    }
    *out = inverse;
    return true;
}

/* Clip a line to slab[0] <= coordinate <= slab[1], along one axis: shorten [*begin, *end] as
 * sc_box3_clip_line does. @return false if nothing is left. */
static bool clip_slab(const double slab[2], double origin, double direction, double *begin,
                      double *end)
{
    double near, far;

    if (direction == 0)
        return origin >= slab[0] && origin <= slab[1];
    near = (slab[0] - origin) / direction;
    far = (slab[1] - origin) / direction;
    if (near > far) {
        const double swap = near;

        near = far;
        far = swap;
    }
    *begin = *begin > near ? *begin : near;
    *end = *end < far ? *end : far;
    return *begin < *end;
}

bool sc_box3_clip_line(const sc_box3 *box, sc_vec3 origin, sc_vec3 direction, double *begin,
                       double *end)
{
    const double x[2] = {box->low.x, box->high.x}, y[2] = {box->low.y, box->high.y};
    const double z[2] = {box->low.z, box->high.z};

    return clip_slab(x, origin.x, direction.x, begin, end) &&
           clip_slab(y, origin.y, direction.y, begin, end) &&
           clip_slab(z, origin.z, direction.z, begin, end);
}
