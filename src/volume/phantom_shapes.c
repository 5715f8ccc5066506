/* SPDX-License-Identifier: BSD-3-Clause */
#include "phantom_shapes.h"

double sc_smooth_min(double a, double b, double width)
{
    const double overlap = width - fabs(a - b);
    const double least = a < b ? a : b;

    if (overlap <= 0)
        return least;
    return least - overlap * overlap / (4 * width);
}

/* The functions *_field: the field of one kind of part at @p p, in mm, negative inside. For a
 * cone, the distance to a segment minus a radius that changes linearly along it. */
static double cone_field(sc_vec3 a, sc_vec3 b, double radius_a, double radius_b, sc_vec3 p)
{
    const sc_vec3 along = sc_vec3_sub(b, a);
    const double length2 = sc_vec3_dot(along, along);
    double s = length2 > 0 ? sc_vec3_dot(sc_vec3_sub(p, a), along) / length2 : 0;

    s = s < 0 ? 0 : s > 1 ? 1 : s;
    return sc_vec3_length(sc_vec3_sub(p, sc_vec3_along(a, s, along))) -
           (radius_a + s * (radius_b - radius_a));
}

/* By scaling to a unit sphere: zero on the surface, never steeper than the distance, and
 * between it and the distance times the ratio of the smallest radius to the largest. */
static double ellipsoid_field(sc_vec3 centre, sc_vec3 radii, sc_vec3 p)
{
    const sc_vec3 d = sc_vec3_sub(p, centre);
    const sc_vec3 unit = {d.x / radii.x, d.y / radii.y, d.z / radii.z};
    double least = radii.x < radii.y ? radii.x : radii.y;

    least = least < radii.z ? least : radii.z;
    return (sc_vec3_length(unit) - 1) * least;
}

/* The union of the cones along part->points. */
static double tube_field(const sc_part *part, sc_vec3 p)
{
    const double step = (part->radius_b_mm - part->radius_a_mm) / (part->point_count - 1);
    double best = HUGE_VAL;

    for (int i = 0; i + 1 < part->point_count; i++) {
        const double radius = part->radius_a_mm + step * i;
        const double d = cone_field(part->points[i], part->points[i + 1], radius, radius + step, p);

        best = d < best ? d : best;
    }
    return best;
}

/* A cap, of radius part->radius_a_mm across, of a spherical shell of 1.4 times that radius; it
 * goes through part->a and bulges along part->b. */
static double leaflet_field(const sc_part *part, sc_vec3 p)
{
    const double sphere = 1.4 * part->radius_a_mm;
    const sc_vec3 centre = sc_vec3_along(part->a, -sphere, part->b);
    const sc_vec3 d = sc_vec3_sub(p, part->a);
    const double along = sc_vec3_dot(d, part->b);
    const double across = sqrt(fmax(sc_vec3_dot(d, d) - along * along, 0));
    const double shell = fabs(sc_vec3_length(sc_vec3_sub(p, centre)) - sphere) - part->radius_b_mm;
    const double inside = fmax(across - part->radius_a_mm, -along - sphere);

    return -sc_smooth_min(-shell, -inside, part->radius_b_mm);
}

/* Field of a part of any kind. */
static double part_field(const sc_part *part, sc_vec3 p)
{
    switch (part->kind) {
    case SC_PART_CONE:
        return cone_field(part->a, part->b, part->radius_a_mm, part->radius_b_mm, p);
    case SC_PART_ELLIPSOID:
        return ellipsoid_field(part->a, part->b, p);
    case SC_PART_TUBE:
        return tube_field(part, p);
    case SC_PART_LEAFLET:
        return leaflet_field(part, p);
    }
    return HUGE_VAL;
}

double sc_shape_field(const sc_shape *shape, sc_vec3 p)
{
    double field = part_field(&shape->parts[0], p);

    for (int i = 1; i < shape->part_count; i++)
        field = sc_smooth_min(field, part_field(&shape->parts[i], p), shape->parts[i].blend_mm);
    for (int i = 0; i < shape->cut_count; i++) {
        const sc_cut *cut = &shape->cuts[i];
        const double beyond = sc_vec3_dot(sc_vec3_sub(p, cut->point), cut->normal);

        field = -sc_smooth_min(-field, -beyond, cut->blend_mm);
    }
    return field;
}

/* The point at @p s, from 0 at p[1] to 1 at p[2], of a Catmull-Rom spline. */
static sc_vec3 catmull_rom(const sc_vec3 p[4], double s)
{
    const double w[4] = {0.5 * s * (-1 + s * (2 - s)), 0.5 * (2 + s * s * (3 * s - 5)),
                         0.5 * s * (1 + s * (4 - 3 * s)), 0.5 * s * s * (s - 1)};
    sc_vec3 out = sc_vec3_scale(p[0], w[0]);

    for (int i = 1; i < 4; i++)
        out = sc_vec3_along(out, w[i], p[i]);
    return out;
}

void sc_spline_points(const sc_vec3 *controls, int control_count, sc_vec3 *out, int count)
{
    const int spans = control_count - 1;

    for (int i = 0; i < count; i++) {
        const double at = (double)spans * i / (count - 1);
        const int span = at >= spans ? spans - 1 : (int)at;
        sc_vec3 p[4] = {controls[span > 0 ? span - 1 : 0], controls[span], controls[span + 1],
                        controls[span + 2 < control_count ? span + 2 : span + 1]};

        /* Reflected neighbours at the ends keep the spline's slope there. */
        if (span == 0)
            p[0] = sc_vec3_sub(sc_vec3_scale(p[1], 2), p[2]);
        if (span + 2 >= control_count)
            p[3] = sc_vec3_sub(sc_vec3_scale(p[2], 2), p[1]);
        out[i] = catmull_rom(p, at - span);
    }
}
