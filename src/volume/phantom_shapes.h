/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the phantom's shapes as implicit functions ("fields"). A field gives about the
 * signed distance to the surface in mm, negative inside. It changes by at most SC_SHAPE_LIPSCHITZ
 * mm per mm, so that its value at the centre of a block bounds its values in the whole block, and
 * blocks far from every surface are classified at once. */
#ifndef SC_PHANTOM_SHAPES_H
#define SC_PHANTOM_SHAPES_H

#include "segcast/geom.h"

#define SC_SHAPE_LIPSCHITZ 1.3

typedef enum sc_part_kind {
    SC_PART_CONE,      /* two spheres and the cone that touches both */
    SC_PART_ELLIPSOID, /* axes along x, y, z */
    SC_PART_TUBE,      /* a chain of cones along points */
    SC_PART_LEAFLET    /* a piece of spherical shell: a valve */
} sc_part_kind;

typedef struct sc_part {
    sc_part_kind kind;
    double blend_mm; /* width of the smooth union with the parts before it */
    sc_vec3 a, b;    /* cone: ends; ellipsoid: centre, radii; leaflet: centre, axis */
    double radius_a_mm, radius_b_mm; /* cone: at the ends; leaflet: radius, half thickness */
    const sc_vec3 *points;           /* tube */
    int point_count;
} sc_part;

typedef struct sc_cut {
    sc_vec3 point, normal; /* what lies beyond, along the unit normal, is cut off */
    double blend_mm;
} sc_cut;

enum { SC_SHAPE_PARTS = 8, SC_SHAPE_CUTS = 4 };

typedef struct sc_shape {
    sc_part parts[SC_SHAPE_PARTS];
    int part_count;
    sc_cut cuts[SC_SHAPE_CUTS];
    int cut_count;
} sc_shape;

double sc_shape_field(const sc_shape *shape, sc_vec3 p);
/* Polynomial smooth minimum: equals the smaller value where they differ by more than @p width. */
double sc_smooth_min(double a, double b, double width);
/* @p count points evenly over a Catmull-Rom spline through @p controls. */
void sc_spline_points(const sc_vec3 *controls, int control_count, sc_vec3 *out, int count);

#endif
