/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the phantom's shapes as implicit functions ("fields"). A field gives about the
 * signed distance to the surface in mm, negative inside. It changes by at most SC_SHAPE_LIPSCHITZ
 * mm per mm, so that its value at the centre of a block bounds its values in the whole block, and
 * blocks far from every surface are classified at once. */
#ifndef SC_PHANTOM_SHAPES_H
#define SC_PHANTOM_SHAPES_H

#include "segcast/geom.h"

/* Most that a field changes from point to point, in mm per mm. */
#define SC_SHAPE_LIPSCHITZ 1.3

typedef enum sc_part_kind {
    SC_PART_CONE,      /* two spheres and the cone that touches both */
    SC_PART_ELLIPSOID, /* axes along x, y, z */
    SC_PART_TUBE,      /* a chain of cones along points */
    SC_PART_LEAFLET    /* a piece of spherical shell: a valve */
} sc_part_kind;

/* A box, in mm, that holds a stretch of a tube's course, and the largest radius along it. */
typedef struct sc_tube_span {
    sc_vec3 low, high;
    double radius_mm;
} sc_tube_span;

/* Spans that the course of a tube is divided into, evenly. */
enum { SC_TUBE_SPANS = 5 };

/* One part of a shape; positions and radii in mm. */
typedef struct sc_part {
    sc_part_kind kind;
    double blend_mm; /* width of the smooth union with the parts before it */
    sc_vec3 a, b;    /* cone: ends; ellipsoid: centre, radii; leaflet: centre, unit axis */
    double radius_a_mm, radius_b_mm; /* cone, tube: at the ends; leaflet: radius, half thickness */
    const sc_vec3 *points;           /* tube: [point_count], its course; borrowed */
    int point_count;                 /* tube: more than SC_TUBE_SPANS */
    sc_tube_span spans[SC_TUBE_SPANS]; /* tube: set by sc_shape_measure */
} sc_part;

/* A half-space that is taken out of a shape. */
typedef struct sc_cut {
    sc_vec3 point, normal; /* what lies beyond, along the unit normal, is cut off */
    double blend_mm;       /* over how much the edge is rounded */
} sc_cut;

enum { SC_SHAPE_PARTS = 8, SC_SHAPE_CUTS = 4 };

/* The smooth union of its parts, at least one, less its cuts. */
typedef struct sc_shape {
    sc_part parts[SC_SHAPE_PARTS];
    int part_count;
    sc_cut cuts[SC_SHAPE_CUTS];
    int cut_count;
    double blend_reach_mm; /* set by sc_shape_measure: a part that is farther than this beyond a
                            * limit has no influence on where the field is below the limit */
} sc_shape;

/* Set the members of the shape that make its field quick. To be called when its parts are whole,
 * and again after the course of a tube has moved. */
void sc_shape_measure(sc_shape *shape);
/* Field of the shape, which has been measured, at @p p (mm), in mm, negative inside: exact, to the
 * last bit, where it is below @p limit_mm, and elsewhere any value of at least that. With
 * HUGE_VAL it is exact everywhere; the lower the limit, the fewer cones are looked at. */
double sc_shape_field(const sc_shape *shape, sc_vec3 p, double limit_mm);
/* Polynomial smooth minimum: equals the smaller value where they differ by more than @p width,
 * and lies below it, by up to a quarter of @p width, where they do not. A @p width of 0 gives
 * the minimum. */
double sc_smooth_min(double a, double b, double width);
/* Write @p count points, at least 2, of the Catmull-Rom spline through @p controls, at least 2,
 * to @p out: from the first control to the last, evenly by the spline's parameter. */
void sc_spline_points(const sc_vec3 *controls, int control_count, sc_vec3 *out, int count);

#endif
