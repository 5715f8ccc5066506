/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to the fidelity tool: closed shapes whose surface is known exactly, and measurements of
 * the surfaces that are drawn from their voxels. */
#ifndef SC_FIDELITY_H
#define SC_FIDELITY_H

#include "segcast/kernel.h"
#include "segcast/phantom.h"

/* A shape in a volume of voxels of 1 mm; the phantom has voxels of its own size. Lengths are in
 * voxels. */
typedef struct shape {
    const char *name;
    int size[3];         /* of the volume */
    double radius;       /* of the tube; 0: not a torus */
    double volume;       /* in voxels; 0: not known */
    double voxel_mm;     /* 0 for the phantom in the table: the caller sets it in a copy */
    sc_phantom *phantom; /* set by the caller in a copy; NULL for all other shapes */
} shape;

/* The table of shapes [shape_count], the phantom last. */
extern const shape shapes[];
extern const size_t shape_count;
/* Find a shape of the table by name. @return NULL if there is none. */
const shape *shape_find(const char *name);

/* Signed distance in voxels from a point to the surface of what @p label owns, negative inside,
 * and the outward unit normal at the nearest point of the surface, to @p normal. @p p in mm.
 * Shapes other than the phantom have one label, and @p label is ignored. */
double shape_distance(const shape *s, int label, sc_vec3 p, sc_vec3 *normal);
/* The label that owns the point @p p in mm, and the distance in voxels to the nearest border, to
 * @p border; of the phantom only 0.5 for a border within half a voxel, else HUGE_VAL. */
int shape_owner(const shape *s, sc_vec3 p, double *border);
/* A point, in mm, on the middle line of a torus, @p u in [0, 1). */
sc_vec3 shape_middle(const shape *s, double u);
/* Make the voxels of a shape: label 1 where their middles lie inside, or the phantom's labels.
 * Caller owns @p out: sc_volume_clear. @return SC_ERR_MEMORY. */
sc_status shape_volume(const sc_ctx *ctx, const shape *s, int threads, sc_volume *out);

/* What was measured. Negative values and NaN mean: not measured. */
typedef struct fidelity {
    double position_rms, position_95, position_max; /* voxels */
    double normal_rms;                              /* degrees */
    double volume_kept;                             /* 1: as large as the shape */
    double owner_errors;                            /* points with a wrong owner, in a million */
    double silhouette;                              /* mean distance in voxels */
    int gaps; /* points outside, of 3600 on a torus's middle line */
    size_t hits;
} fidelity;

/* The errors of all hits, in voxels (with sign) and degrees: [count] each, owned. Starts as {0}. */
typedef struct errors {
    double *position, *angle;
    size_t count, capacity;
} errors;
/* Append the errors of one hit. Aborts without memory. */
void errors_add(errors *e, double position, double angle_deg);
/* Sum the errors up in position_*, normal_rms and hits of @p out, free them, and set @p e to
 * {0}. Without hits only hits is set. */
void errors_finish(errors *e, fidelity *out);

/* Measure a triangle mesh (PLY or binary STL, in mm) against the surface of the shape's label 1.
 * @p out is set at once, also on failure. @return SC_ERR_DATA for a file that is none or
 * damaged, errors of reading, SC_ERR_MEMORY; each with a message. */
sc_status measure_mesh(const sc_ctx *ctx, const shape *s, const char *path, fidelity *out);
/* Prepare the shape's voxels with the smoothing @p smooth and measure what segcast draws from
 * them. Members of @p out are overwritten; what cannot be measured of a shape gets NaN or -1. */
sc_status measure_volume(const sc_ctx *ctx, const shape *s, sc_surface surface, double smooth,
                         int threads, fidelity *out);

/* The next 64 random bits, or number in [0, 1), of a sequence whose state is *@p seed. */
uint64_t random_bits_of(uint64_t *seed);
double random_of(uint64_t *seed);

#endif
