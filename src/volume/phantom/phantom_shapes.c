/* SPDX-License-Identifier: BSD-3-Clause */
#include "phantom/phantom_shapes.h"

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

/* What stands for a part that is too far away to matter: finite, because the difference of two of
 * them is taken. */
static const double FAR_MM = 1e9;

/* The first segment of a span of a tube, whose segments are numbered from 0. */
static int span_begin(const sc_part *part, int span)
{
    return (part->point_count - 1) * span / SC_TUBE_SPANS;
}

/* Set part->spans of a tube. */
static void measure_tube(sc_part *part)
{
    const double step = (part->radius_b_mm - part->radius_a_mm) / (part->point_count - 1);

    for (int i = 0; i < SC_TUBE_SPANS; i++) {
        const int begin = span_begin(part, i), end = span_begin(part, i + 1);
        const double first = part->radius_a_mm + step * begin,
                     last = part->radius_a_mm + step * end;
        sc_tube_span *span = &part->spans[i];

        *span = (sc_tube_span){part->points[begin], part->points[begin], fmax(first, last)};
        for (int k = begin + 1; k <= end; k++) {
            const sc_vec3 p = part->points[k];

            span->low =
                (sc_vec3){fmin(span->low.x, p.x), fmin(span->low.y, p.y), fmin(span->low.z, p.z)};
            span->high = (sc_vec3){fmax(span->high.x, p.x), fmax(span->high.y, p.y),
                                   fmax(span->high.z, p.z)};
        }
    }
}

/* How far @p x lies outside of the interval from @p low to @p high. */
static double outside(double low, double x, double high)
{
    return x < low ? low - x : x > high ? x - high : 0;
}

/* @return what the field of the cones of a span is at least, less a nanometre for rounding. */
static double span_bound(const sc_tube_span *span, sc_vec3 p)
{
    const sc_vec3 off = {outside(span->low.x, p.x, span->high.x),
                         outside(span->low.y, p.y, span->high.y),
                         outside(span->low.z, p.z, span->high.z)};

    return sc_vec3_length(off) - span->radius_mm - 1e-6;
}

/* The least field of the cones of a span. */
static double span_field(const sc_part *part, int span, sc_vec3 p)
{
    const double step = (part->radius_b_mm - part->radius_a_mm) / (part->point_count - 1);
    double best = FAR_MM;

    for (int i = span_begin(part, span); i < span_begin(part, span + 1); i++) {
        const double radius = part->radius_a_mm + step * i;
        const double d = cone_field(part->points[i], part->points[i + 1], radius, radius + step, p);

        best = d < best ? d : best;
    }
    return best;
}

/* The union of the cones along part->points: exact below @p limit_mm. The nearest span is looked at
 * first, so that most others cannot hold a lesser field. */
static double tube_field(const sc_part *part, sc_vec3 p, double limit_mm)
{
    double bounds[SC_TUBE_SPANS], best = FAR_MM;
    int nearest = 0;

    for (int i = 0; i < SC_TUBE_SPANS; i++) {
        bounds[i] = span_bound(&part->spans[i], p);
        nearest = bounds[i] < bounds[nearest] ? i : nearest;
    }
    if (bounds[nearest] >= limit_mm)
        return FAR_MM;
    best = span_field(part, nearest, p);
    for (int i = 0; i < SC_TUBE_SPANS; i++) {
        if (i != nearest && bounds[i] < best && bounds[i] < limit_mm) {
            const double d = span_field(part, i, p);

            best = d < best ? d : best;
        }
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

/* Field of a part of any kind: exact below @p limit_mm, and elsewhere at least that. */
static double part_field(const sc_part *part, sc_vec3 p, double limit_mm)
{
    switch (part->kind) {
    case SC_PART_CONE:
        return cone_field(part->a, part->b, part->radius_a_mm, part->radius_b_mm, p);
    case SC_PART_ELLIPSOID:
        return ellipsoid_field(part->a, part->b, p);
    case SC_PART_TUBE:
        return tube_field(part, p, limit_mm);
    case SC_PART_LEAFLET:
        return leaflet_field(part, p);
    }
    return HUGE_VAL;
}

/* A smooth union is at most a quarter of its width below its parts, and a part has no influence
 * where it is farther than the width beyond the others. So what is left out with all parts that lie
 * at least reach beyond a limit, reach = widest blend + a quarter of all blends, does not change
 * the union where that is below the limit, nor lower what is above it to below it. */
void sc_shape_measure(sc_shape *shape)
{
    double widest = 0, all = 0;

    for (int i = 0; i < shape->part_count; i++) {
        sc_part *part = &shape->parts[i];

        widest = fmax(widest, part->blend_mm);
        all += part->blend_mm;
        if (part->kind == SC_PART_TUBE)
            measure_tube(part);
    }
    shape->blend_reach_mm = widest + 0.25 * all;
}

double sc_shape_field(const sc_shape *shape, sc_vec3 p, double limit_mm)
{
    const double limit = limit_mm + shape->blend_reach_mm;
    double field = part_field(&shape->parts[0], p, limit);

    for (int i = 1; i < shape->part_count; i++) {
        const double blend = shape->parts[i].blend_mm;

        field = sc_smooth_min(
            field, part_field(&shape->parts[i], p, field + blend < limit ? field + blend : limit),
            blend);
    }
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
