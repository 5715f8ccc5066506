/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to the fidelity tool: closed shapes whose surface is known exactly, and what is measured
 * of surfaces drawn from their voxels. */
#ifndef SC_FIDELITY_H
#define SC_FIDELITY_H

#include "segcast/kernel.h"
#include "segcast/phantom.h"

/* A shape in a volume of voxels of 1 mm; the phantom has voxels of its own size. Distances in
 * voxels. */
typedef struct shape {
    const char *name;
    int size[3];
    double radius; /* of the tube; 0: not a torus */
    double volume; /* in voxels; 0: not known */
    double voxel_mm;
    sc_phantom *phantom;
} shape;

extern const shape shapes[];
extern const size_t shape_count;
const shape *shape_find(const char *name);

/* Signed distance in voxels from a point to the surface of what @p label owns, negative inside, and
 * the outward unit normal at the nearest point of the surface. @p p in mm. */
double shape_distance(const shape *s, int label, sc_vec3 p, sc_vec3 *normal);
/* The label that owns a point, and the distance in voxels to the nearest border (of the phantom
 * only whether it is more than half a voxel). */
int shape_owner(const shape *s, sc_vec3 p, double *border);
/* A point on the middle line of a torus, @p u in [0, 1). */
sc_vec3 shape_middle(const shape *s, double u);
sc_status shape_volume(const sc_ctx *ctx, const shape *s, int threads, sc_volume *out);

/* What was measured. Negative values and NaN stand for what was not. */
typedef struct fidelity {
    double position_rms, position_95, position_max; /* voxels */
    double normal_rms;                              /* degrees */
    double volume_kept;                             /* 1: as large as the shape */
    double owner_errors;                            /* of a million samples */
    double silhouette;                              /* mean distance in voxels */
    int gaps;                                       /* of 3600 points of the middle line */
    size_t hits;
} fidelity;

/* The errors of all hits, in voxels and degrees. errors_finish sums them up and frees them. */
typedef struct errors {
    double *position, *angle;
    size_t count, capacity;
} errors;
void errors_add(errors *e, double position, double angle_deg);
void errors_finish(errors *e, fidelity *out);

/* Measure a triangle mesh (PLY or STL) against the surface of the shape's label 1. */
sc_status measure_mesh(const sc_ctx *ctx, const shape *s, const char *path, fidelity *out);
/* Measure what segcast draws from the shape's voxels. */
sc_status measure_volume(const sc_ctx *ctx, const shape *s, sc_surface surface, double smooth,
                         int threads, fidelity *out);

uint64_t random_bits_of(uint64_t *seed);
double random_of(uint64_t *seed); /* [0, 1) */

#endif
