/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Vectors, affine maps and axis-aligned boxes in double precision. Everything here is a value or
 *  a pure function: nothing is allocated, nothing fails, and any thread may call it. Lengths have
 *  the unit of their arguments; angles are in radians. */
#ifndef SEGCAST_GEOM_H
#define SEGCAST_GEOM_H

#include <math.h>
#include <stdbool.h>

typedef struct sc_vec3 {
    double x, y, z;
} sc_vec3;

/** Affine map p -> M p + t; row-major 3x4. */
typedef struct sc_affine {
    double m[3][4];
} sc_affine;

/** Axis-aligned box; empty when a low exceeds a high. */
typedef struct sc_box3 {
    sc_vec3 low, high;
} sc_box3;

static inline sc_vec3 sc_vec3_add(sc_vec3 a, sc_vec3 b)
{
    return (sc_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline sc_vec3 sc_vec3_sub(sc_vec3 a, sc_vec3 b)
{
    return (sc_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline sc_vec3 sc_vec3_scale(sc_vec3 a, double s)
{
    return (sc_vec3){a.x * s, a.y * s, a.z * s};
}

/** a + s b */
static inline sc_vec3 sc_vec3_along(sc_vec3 a, double s, sc_vec3 b)
{
    return (sc_vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline double sc_vec3_dot(sc_vec3 a, sc_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline sc_vec3 sc_vec3_cross(sc_vec3 a, sc_vec3 b)
{
    return (sc_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double sc_vec3_length(sc_vec3 a)
{
    return sqrt(sc_vec3_dot(a, a));
}

/** Unit vector along @p a; the zero vector stays zero. */
static inline sc_vec3 sc_vec3_unit(sc_vec3 a)
{
    const double length = sc_vec3_length(a);

    return length > 0 ? sc_vec3_scale(a, 1 / length) : a;
}

/** Some unit vector perpendicular to the unit vector @p a. */
sc_vec3 sc_vec3_perpendicular(sc_vec3 a);
/** @p v turned by @p angle_rad about the unit vector @p axis, right-handed (Rodrigues). */
sc_vec3 sc_vec3_rotate(sc_vec3 v, sc_vec3 axis, double angle_rad);

sc_vec3 sc_affine_point(const sc_affine *a, sc_vec3 p);
/** The linear part only. */
sc_vec3 sc_affine_vector(const sc_affine *a, sc_vec3 v);
/** Column @p axis of the linear part: what one step along that axis adds. */
sc_vec3 sc_affine_column(const sc_affine *a, int axis);
double sc_affine_determinant(const sc_affine *a);
/** @return false, @p out untouched, if singular or not finite. */
bool sc_affine_invert(const sc_affine *a, sc_affine *out);

/** The interval of the line origin + t direction inside @p box, intersected with [*begin, *end].
 *  A zero component of the direction keeps or drops the line whole. @return false if empty. */
bool sc_box3_clip_line(const sc_box3 *box, sc_vec3 origin, sc_vec3 direction, double *begin,
                       double *end);

#endif
