/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Vectors, affine maps and axis-aligned boxes in double precision. Everything here is a value or
 *  a pure function: nothing is allocated, nothing fails, and any thread may call it. Lengths have
 *  the unit of their arguments; angles are in radians. */
#ifndef SEGCAST_GEOM_H
#define SEGCAST_GEOM_H

#include <math.h>
#include <stdbool.h>

/** A point or a vector. */
typedef struct sc_vec3 {
    double x, y, z;
} sc_vec3;

/** Affine map p -> M p + t: m[row][column], M in columns 0 to 2, t in column 3. */
typedef struct sc_affine {
    double m[3][4];
} sc_affine;

/** Axis-aligned box; empty if a component of low exceeds that of high. */
typedef struct sc_box3 {
    sc_vec3 low, high;
} sc_box3;

/** @return a + b. */
static inline sc_vec3 sc_vec3_add(sc_vec3 a, sc_vec3 b)
{
    return (sc_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

/** @return a - b. */
static inline sc_vec3 sc_vec3_sub(sc_vec3 a, sc_vec3 b)
{
    return (sc_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

/** @return s a. */
static inline sc_vec3 sc_vec3_scale(sc_vec3 a, double s)
{
    return (sc_vec3){a.x * s, a.y * s, a.z * s};
}

/** @return a + s b, a point on a line. */
static inline sc_vec3 sc_vec3_along(sc_vec3 a, double s, sc_vec3 b)
{
    return (sc_vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

/** @return the scalar product. */
static inline double sc_vec3_dot(sc_vec3 a, sc_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/** @return the vector product, right-handed. */
static inline sc_vec3 sc_vec3_cross(sc_vec3 a, sc_vec3 b)
{
    return (sc_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/** @return the Euclidean length. */
static inline double sc_vec3_length(sc_vec3 a)
{
    return sqrt(sc_vec3_dot(a, a));
}

/** @return the unit vector along @p a; the zero vector stays zero. */
static inline sc_vec3 sc_vec3_unit(sc_vec3 a)
{
    const double length = sc_vec3_length(a);

    return length > 0 ? sc_vec3_scale(a, 1 / length) : a;
}

/** @return a unit vector perpendicular to the unit vector @p a, always the same one for @p a. */
sc_vec3 sc_vec3_perpendicular(sc_vec3 a);
/** @return @p v rotated by @p angle_rad about the unit vector @p axis, right-handed (Rodrigues'
 *  formula). */
sc_vec3 sc_vec3_rotate(sc_vec3 v, sc_vec3 axis, double angle_rad);

/** @return M p + t. */
sc_vec3 sc_affine_point(const sc_affine *a, sc_vec3 p);
/** @return M v: vectors, unlike points, are not translated. */
sc_vec3 sc_affine_vector(const sc_affine *a, sc_vec3 v);
/** @return column @p axis: for 0 to 2 what a step of 1 along that axis adds, for 3 the translation.
 */
sc_vec3 sc_affine_column(const sc_affine *a, int axis);
/** @return the determinant of M. */
double sc_affine_determinant(const sc_affine *a);
/** @return the map that applies @p first, and then @p then. */
sc_affine sc_affine_compose(const sc_affine *then, const sc_affine *first);
/** Invert a map. @return false, with @p out untouched, if it is not finite or singular: the volume
 * of the parallelepiped of its columns is at most 1e-9 of the product of their lengths. */
bool sc_affine_invert(const sc_affine *a, sc_affine *out);

/** A box that holds nothing. */
#define SC_BOX3_EMPTY ((sc_box3){{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}})
/** @return corner @p i, 0 to 7, of a box: its lowest three bits tell which side along x, y and z.
 */
static inline sc_vec3 sc_box3_corner(const sc_box3 *box, int i)
{
    return (sc_vec3){i & 1 ? box->high.x : box->low.x, i & 2 ? box->high.y : box->low.y,
                     i & 4 ? box->high.z : box->low.z};
}
/** Let a box hold a point, too. */
static inline void sc_box3_hold(sc_box3 *box, sc_vec3 p)
{
    box->low = (sc_vec3){fmin(box->low.x, p.x), fmin(box->low.y, p.y), fmin(box->low.z, p.z)};
    box->high = (sc_vec3){fmax(box->high.x, p.x), fmax(box->high.y, p.y), fmax(box->high.z, p.z)};
}
/** Clip the line origin + t direction to @p box: shorten the interval [*begin, *end] of t to the
 * part inside. A line parallel to a face is inside if it lies between that face and the opposite
 * one, or in one of them. @return false if nothing is left; *begin and *end are unspecified then.
 */
bool sc_box3_clip_line(const sc_box3 *box, sc_vec3 origin, sc_vec3 direction, double *begin,
                       double *end);

/** One pass of the exact Euclidean distance transform along a line, within a run of samples whose
 *  two neighbours beyond the ends lie outside: replace values[i] by the least of
 *  values[q] + (step (i - q))^2, q over the whole run, and of the squared distances to those two
 *  neighbours. Done along each axis of a grid in turn, for every run of samples inside, with
 *  values that are HUGE_VAL before the first pass, it gives the squared distance from each sample
 *  to the nearest one outside: what lies beyond the end of a run is never nearer than that end.
 *  By the lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012, "Distance transforms of
 *  sampled functions"), in time linear in @p count.
 *  @param values [count] squared lengths, at least 0, of the unit of @p step squared.
 *  @param work room for SC_DISTANCE_WORK(count) numbers. */
void sc_distance_pass(double *values, int count, double step, double *work);
/** How many numbers sc_distance_pass needs room for. */
#define SC_DISTANCE_WORK(count) (3 * ((size_t)(count) + 3))

#endif
