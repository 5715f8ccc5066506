/* SPDX-License-Identifier: BSD-3-Clause */
/* Framing of an orbit: see framing.h. The tissues are given by points, in RAS mm. */
#include "framing.h"

/* Slices of the swept body along the axis, and points of the rim of each. */
enum { SLICES = 48, ANGLES = 96 };
#define MARGIN 1.06 /* the picture shows this multiple of what must be in it */

void sc_extent(const sc_vec3 *points, size_t count, sc_vec3 direction, double *low, double *high)
{
    *low = count ? HUGE_VAL : -0.5;
    *high = count ? -HUGE_VAL : 0.5;
    for (size_t i = 0; i < count; i++) {
        const double at = sc_vec3_dot(points[i], direction);

        *low = at < *low ? at : *low;
        *high = at > *high ? at : *high;
    }
}

sc_vec3 sc_orbit_reference(sc_vec3 axis)
{
    const sc_vec3 front = {0, 1, 0}, above = {0, 0, 1};
    sc_vec3 out = sc_vec3_along(front, -sc_vec3_dot(front, axis), axis);

    if (sc_vec3_length(out) < 0.1)
        out = sc_vec3_along(above, -sc_vec3_dot(above, axis), axis);
    return sc_vec3_unit(out);
}

/* @return the middle of the points' extent along the unit @p axis and two directions across it, in
 * mm. */
static sc_vec3 middle(const sc_vec3 *points, size_t count, sc_vec3 axis)
{
    const sc_vec3 side = sc_orbit_reference(axis);
    const sc_vec3 basis[3] = {axis, side, sc_vec3_cross(axis, side)};
    sc_vec3 out = {0, 0, 0};

    for (int i = 0; i < 3; i++) {
        double low, high;

        sc_extent(points, count, basis[i], &low, &high);
        out = sc_vec3_along(out, 0.5 * (low + high), basis[i]);
    }
    return out;
}

/* The body that the points sweep out when turned about the axis through the target. Lengths in mm.
 */
typedef struct swept {
    double low, high;      /* its extent along the axis, from the target */
    double radius[SLICES]; /* the largest radius in each of as many slices of that extent */
} swept;

/* @return the swept body of @p points. @param axis unit. */
static swept sweep_points(const sc_vec3 *points, size_t count, sc_vec3 axis, sc_vec3 target)
{
    swept s = {0};

    sc_extent(points, count, axis, &s.low, &s.high);
    s.low -= sc_vec3_dot(target, axis);
    s.high -= sc_vec3_dot(target, axis);
    for (size_t i = 0; i < count; i++) {
        const sc_vec3 d = sc_vec3_sub(points[i], target);
        const double height = sc_vec3_dot(d, axis);
        const double radius = sc_vec3_length(sc_vec3_along(d, -height, axis));
        int slice = (int)((height - s.low) / (s.high - s.low + 1e-9) * SLICES);

        slice = slice < 0 ? 0 : slice >= SLICES ? SLICES - 1 : slice;
        s.radius[slice] = radius > s.radius[slice] ? radius : s.radius[slice];
    }
    return s;
}

/* @return the smallest distance (perspective) or half height (orthographic), in mm, at which every
 * point of the swept body is in the picture, with a margin. The body is round, so that one
 * direction of view stands for all.
 * @param tangent of half the vertical field of view. */
static double needed(const swept *s, const sc_orbit *orbit, double aspect, double tangent)
{
    const double elevation = orbit->elevation_deg * M_PI / 180;
    const double c = cos(elevation), e = sin(elevation);
    double most = 1e-3;

    for (int i = 0; i < 2 * SLICES; i++) {
        const int edge = (i + 1) / 2; /* of slice i / 2: its lower, then its upper */
        const double h = s->low + (s->high - s->low) * edge / SLICES;
        const double r = s->radius[i / 2];

        for (int n = 0; n < ANGLES; n++) {
            const double angle = 2 * M_PI * n / ANGLES;
            const double across = fabs(r * sin(angle)) / aspect;
            const double upward = fabs(h * c - r * cos(angle) * e);
            const double nearer = r * cos(angle) * c + h * e;
            const double half = across > upward ? across : upward;
            const double need = orbit->projection == SC_ORTHOGRAPHIC
                                    ? half * MARGIN
                                    : nearer + half * MARGIN / tangent;

            most = need > most ? need : most;
        }
    }
    return most;
}

void sc_frame_orbit(sc_orbit *orbit, const sc_vec3 *points, size_t count, double aspect,
                    double *half_height)
{
    const double tangent = tan(orbit->fov_deg * M_PI / 360);
    const bool orthographic = orbit->projection == SC_ORTHOGRAPHIC;
    swept s;
    double need;

    *half_height = tangent;
    if (orbit->fixed) {
        if (orthographic) /* the half height of the field of view at the target */
            *half_height =
                tangent * sc_vec3_length(sc_vec3_sub(orbit->target_mm, orbit->position_mm));
        return;
    }
    if (!orbit->has_target)
        orbit->target_mm = middle(points, count, orbit->axis);
    s = sweep_points(points, count, orbit->axis, orbit->target_mm);
    need = needed(&s, orbit, aspect, tangent);
    if (orthographic) {
        *half_height = orbit->has_distance ? tangent * orbit->distance_mm : need;
        orbit->distance_mm = 2 * (need + s.high - s.low) + 1; /* anywhere outside of the body */
    } else if (!orbit->has_distance) {
        orbit->distance_mm = need;
    }
}
