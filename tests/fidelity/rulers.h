/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to the fidelity tool: rulers that need no true surface, or volumes of their own. They
 * look at what is drawn through owner_at and the rays of the kernels alone, so that they measure
 * any way of making surfaces from labels. */
#ifndef SC_FIDELITY_RULERS_H
#define SC_FIDELITY_RULERS_H

#include "fidelity.h"

/* A smoothed distance in the voxels of a box of a volume. */
typedef struct field {
    const sc_volume *volume; /* borrowed */
    double spacing[3], unit; /* of its voxels, in mm; the smallest of the three */
    int low[3], size[3];     /* the box, which may reach beyond the volume */
    size_t capacity;
    float *at, *room, *sheet; /* [capacity], in mm at x + size[0] (y + size[1] z); two arrays for
                                 work */
} field;
/* What field_make takes instead of a label for all tissue together. */
enum { FIELD_TISSUE = -1 };
/* Set up a field without a box. Cannot fail: memory comes with field_make. field_free. */
void field_open(const sc_volume *volume, field *f);
/* Free the arrays of a field. */
void field_free(field *f);
/* Compute, for the voxels from @p low to @p high, inclusive, and one more around them, a function
 * of distances that has been smoothed by a Gaussian of 2.2 times the smallest spacing. Distances
 * are those to the nearest voxel centre, less half the smallest spacing. Beyond its border a volume
 * counts as going on as it ends.
 * @param a FIELD_TISSUE: the distance from the background, in tissue, and minus that from the
 * tissue, in the background; at most 8 times the smallest spacing. Otherwise two dense ids, @p a
 * and @p b: the distance from voxels of @p b minus that from voxels of @p a, which are 0 in these
 * themselves and at most 4 times the smallest spacing: so it grows from @p b to @p a, along the
 * surface of both too. Aborts without memory. */
void field_make(field *f, const int low[3], const int high[3], int a, int b);
/* The field at a point in voxels of the volume, between those it was made for, by trilinear
 * interpolation. */
double field_value(const field *f, const float p[3]);
/* Its gradient, without unit, to @p out: by differences over two voxels. @return its length. */
double field_slope(const field *f, const float p[3], double out[3]);

/* A point of a surface or line, and how far it lies from a smooth reference. */
typedef struct wobble_point {
    float at[3];     /* voxels of the volume */
    uint32_t pair;   /* of a seam: the smaller dense id << 16 | the larger; of an outline 0 */
    float normal[3]; /* of the reference of the outline, there; set for points of seams */
    float off_mm;    /* along the normal, or of seams within the surface; NAN: left out */
} wobble_point;
/* A list of them that grows; owns its array. Starts as {0}. */
typedef struct wobble_points {
    wobble_point *list;
    size_t count, capacity;
} wobble_points;
/* Append a point. Aborts without memory. */
void wobble_add(wobble_points *to, const wobble_point *p);

/* Find points of the surface between background and tissue, and of the seams on it, 10 voxels or
 * more from the faces of the volume that the stage has been opened with. Outlines: where the owner
 * changes between background and tissue along the lines through voxel centres along each axis.
 * Seams: where, on the surface seen along such a line, the tissue changes on the way to the next
 * line; so seams are cut by the planes of the grid, wherever the line is within 45 degrees of the
 * normal. The tissue is that which a ray from outside meets first.
 * Aborts without memory. */
void wobble_find(const stage *st, int threads, wobble_points *outline, wobble_points *seams);

/* Outline and seam wobble of a volume. NAN: not enough points. */
typedef struct wobble {
    double outline, seam; /* RMS in units of the smallest spacing */
    size_t outline_points, seam_points, pairs;
} wobble;
/* Measure how much surfaces, drawn as @p how says, waver within less than 8 voxels. Where tissue
 * meets the background, and where, on that surface, two tissues meet: the distance of each point
 * from a smooth reference (see field_make), minus its mean over the points around, which have
 * Gaussian weights of 2 voxels. RMS. Left out are points more than 2 voxels from the reference,
 * and those where it does not determine the surface: where its slope is below 0.85, or at seams
 * that of the outline or that of the seam within the surface below 0.5; also pairs of tissues with
 * fewer than 50 points.
 * Voxels are those of the volume, and the smallest spacing is their length. @return errors of
 * preparing. */
sc_status measure_wobble(const sc_ctx *ctx, const sc_volume *volume, const drawing *how,
                         wobble *out);

/* The number of volumes of lines and points one voxel thick. */
size_t line_count(void);
/* What is drawn of the lines of one volume. */
typedef struct survivors {
    const char *name;
    double voxels, links;    /* share of the voxel centres, and of the midpoints between successive
                                voxels, that the line owns; NAN without links */
    int pieces, true_pieces; /* connected parts of what is drawn, by samples a quarter of a voxel
                                apart, at the voxel centres too, whose cubes share faces; and of
                                what should be */
    double width; /* in voxels: square root of the drawn volume, by these samples, divided by the
                     true length of the line; of points the cube root of their mean volume. So
                     what is thinner than a quarter counts as a quarter */
} survivors;
/* Make the lines number @p n, draw them as @p how says, and look what is left of them. @return
 * errors of preparing. */
sc_status measure_lines(const sc_ctx *ctx, size_t n, const drawing *how, survivors *out);

/* The number of volumes with sharp edges, and with thin tissue on thick one. */
size_t edge_count(void);
/* What is drawn of one of them. */
typedef struct sharp_edge {
    const char *name;
    double
        retreat;   /* of a sharp edge: how far inside of the true one it is drawn, in voxels, and */
    double wobble; /* the standard deviation along it; NAN without one */
    double voxels; /* share of the voxels of the wedge, or of thin tissue, whose centres are drawn
                      as they are labelled */
} sharp_edge;
/* Make number @p n of these volumes, draw it as @p how says, and measure. @return errors of
 * preparing. */
sc_status measure_edge(const sc_ctx *ctx, size_t n, const drawing *how, sharp_edge *out);

/* How much of what is drawn depends on voxels farther away than a halo. */
typedef struct locality {
    int crops;
    double points, points_off; /* random points at borders, and those with another owner */
    double rays, rays_off;     /* random rays that meet something, and those that meet another
                                  tissue, or at another depth, or with another normal, by a bit */
} locality;
/* Draw crops of a volume by themselves and compare them with the whole. A crop lies about a random
 * voxel at a border: a cube of 64 voxels and @p halo more on all sides, as far as the volume
 * reaches; its corner has even coordinates. Only the cube is looked at. Both are drawn as the
 * smooth surface with the strength of @p how, on their own voxels: what is found out about a volume
 * as a whole (copies, slices that jump, thick slices) is left out. Points and rays are such that
 * their coordinates are the same numbers in both. @return errors of preparing. */
sc_status measure_locality(const sc_ctx *ctx, const sc_volume *volume, const drawing *how, int halo,
                           locality *out);

/* How evenly what is drawn of a shape changes while noise or a strength grows step by step. */
typedef struct cliff {
    const char *shape;
    bool by_noise; /* from none to 20 % of the voxels at the border; else the strength of smoothing,
                      from 0.5 to 2 */
    int steps, at; /* at: the largest of the steps, counted from 1 */
    double largest, median; /* of the steps: mean of how far the surface has moved, in voxels */
} cliff;
/* The number of combinations of a shape and what changes. */
size_t cliff_count(void);
/* Measure number @p n of them, drawn as @p how says but for a strength that changes. The surface is
 * met along rays from 6 voxels outside of the true surface, along its normals, which stay the same
 * for all steps. Noise flips voxels at the border of the shape; the flipped voxels of a step are
 * among those of the next. @return errors of preparing. */
sc_status measure_cliff(const sc_ctx *ctx, size_t n, const drawing *how, cliff *out);

/* What a ruler is asked for. */
typedef struct ruling {
    const char *path; /* of the volume; NULL: the ruler makes its own */
    int halo;         /* of locality */
    drawing how;
    bool json;
} ruling;
/* Measure and print as a line or JSON. @return errors of reading and preparing. */
sc_status print_wobble(const sc_ctx *ctx, const ruling *r);
sc_status print_lines(const sc_ctx *ctx, const ruling *r);
sc_status print_edges(const sc_ctx *ctx, const ruling *r);
sc_status print_locality(const sc_ctx *ctx, const ruling *r);
sc_status print_cliffs(const sc_ctx *ctx, const ruling *r);

#endif
