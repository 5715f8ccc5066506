/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to the fidelity tool: closed shapes whose surface is known exactly, and measurements of
 * the surfaces that are drawn from their voxels. */
#ifndef SC_FIDELITY_H
#define SC_FIDELITY_H

#include "segcast/kernel.h"
#include "segcast/resample.h"

/* A shape in a volume whose voxels measure 1 mm along x and y. Lengths are in mm unless a name says
 * otherwise. Errors are given in units of unit_mm. */
typedef struct shape {
    const char *name;
    int size[3];     /* of the volume, in voxels */
    double radius;   /* of the tube of a torus; 0: not a torus */
    double volume;   /* in mm3 */
    double slice_mm; /* edge of a voxel along z */
    int copied;      /* the shape is voxelised with voxels of this many mm, each of which is
                        copied up to copied^3 voxels; 1: none */
    double flipped;  /* share of the voxels on either side of the border, before copying up,
                        whose label is changed */
    double unit_mm;  /* what errors are given in: the edge of a voxel within its slice, or of
                        one that is copied up */
} shape;

/* The table of shapes [shape_count]: first IDEAL_SHAPES that are voxelised in the best way there
 * is. */
enum { IDEAL_SHAPES = 5 };
extern const shape shapes[];
extern const size_t shape_count;
/* Find a shape of the table by name. @return NULL if there is none. */
const shape *shape_find(const char *name);

/* Signed distance in units from a point to the surface of the shape, negative inside, and the
 * outward unit normal at the nearest point of the surface, to @p normal. @p p in mm. */
double shape_distance(const shape *s, sc_vec3 p, sc_vec3 *normal);
/* A point, in mm, on the middle line of a torus, @p u in [0, 1). */
sc_vec3 shape_middle(const shape *s, double u);
/* Make the voxels of a shape: label 1 where their middles lie inside; then flip some and copy them
 * up as the shape says. Caller owns @p out: sc_volume_clear. @return SC_ERR_MEMORY. */
sc_status shape_volume(const sc_ctx *ctx, const shape *s, int threads, sc_volume *out);

/* Change the label of a share of the voxels on either side of the border of a shape, drawn at
 * random with a fixed seed: background becomes the shape, the shape background. Which ones lie at
 * the border is seen before any label is changed; those changed by a share are among those of a
 * larger one. @return SC_ERR_MEMORY. */
sc_status flip_voxels(const sc_ctx *ctx, sc_volume *v, double share);

/* What was measured. Negative values and NaN mean: not measured. */
typedef struct fidelity {
    double position_rms, position_95, position_max; /* units */
    double normal_rms;                              /* degrees */
    double volume_kept;                             /* 1: as large as the shape */
    double owner_errors;                            /* points with a wrong owner, in a million */
    double silhouette;                              /* mean distance in units */
    int gaps; /* points outside, of 3600 on a torus's middle line */
    size_t hits;
} fidelity;

/* The errors of all hits, in units (with sign) and degrees: [count] each, owned. Starts as {0}. */
typedef struct errors {
    double *position, *angle;
    size_t count, capacity;
} errors;
/* Append the errors of one hit. Aborts without memory. */
void errors_add(errors *e, double position, double angle_deg);
/* Sum the errors up in position_*, normal_rms and hits of @p out, free them, and set @p e to
 * {0}. Without hits only hits is set. */
void errors_finish(errors *e, fidelity *out);

/* A volume that has been prepared for drawing, every label in full opacity, and all that rays
 * through it need. Owns what its pointers point to: stage_close. Starts as {0}. */
typedef struct stage {
    sc_prepared volume; /* its pointers go into block */
    sc_march march;
    const sc_kernel *kernel;
    sc_affine to_voxel;
    double reach_mm; /* radius of a ball around what is measured */
    sc_vec3 middle_mm;
    const sc_volume *voxels; /* what is measured, borrowed: not resampled */
    sc_affine to_measured;   /* RAS mm -> its voxels */
    void *block;
    sc_team *team; /* holds the cells */
    uint64_t *cells;
    sc_march_tissue *tissues;
} stage;

/* How a volume is drawn. */
typedef struct drawing {
    sc_surface surface;
    bool resample; /* on the grid of sc_find_drawn_grid */
    double smooth;
    int threads;
} drawing;

/* Prepare @p volume, which is only borrowed, to be drawn as @p how says. @param reach share of half
 * the diagonal of the volume that the ball of rays reaches. @param step_mm between samples of the
 * voxel surface. Free by stage_close, also after a failure. @return errors of preparing. */
sc_status stage_open(const sc_ctx *ctx, const sc_volume *volume, const drawing *how, double reach,
                     double step_mm, stage *st);
/* Free what the stage owns; it is {0} then. */
void stage_close(stage *st);
/* Fill in a ray from @p eye along the unit vector @p direction, both in RAS mm; one that misses
 * the volume has no parts. */
void make_ray(const stage *st, sc_vec3 eye, sc_vec3 direction, sc_ray *ray);
/* A random unit vector, uniformly distributed over the sphere. */
sc_vec3 random_direction(uint64_t *seed);
/* A random line through the ball around what is measured: its direction, and to @p eye where it
 * enters a ball of that radius about a point in the ball. Such lines meet surfaces in points that
 * are spread evenly over their area, in all directions. */
sc_vec3 random_line(const stage *st, uint64_t *seed, sc_vec3 *eye);
/* The dense id at a voxel; 0, the background, outside. */
int id_at(const sc_volume *v, int x, int y, int z);
/* Are the vertices of the cell that holds the point @p p, in voxels of the stage, and those around
 * it of one label, or is it outside? */
bool is_uniform(const stage *st, sc_vec3 p);
/* The dense id that the surface model gives the point @p mm (RAS); 0 outside of the volume. */
int owner_at(const stage *st, sc_vec3 mm);

/* A triangle mesh; owns its arrays (mesh_free). Starts as {0}. */
typedef struct mesh {
    size_t vertex_count, triangle_count, capacity;
    sc_vec3 *vertices;        /* [vertex_count], in mm */
    sc_vec3 *normals;         /* [vertex_count], all 0 after reading */
    uint32_t (*triangles)[3]; /* [triangle_count], room for capacity */
} mesh;
/* Read a PLY or binary STL file into @p m, which is {0}. The caller frees the mesh, also on
 * failure. @return SC_ERR_DATA, errors of reading, SC_ERR_MEMORY, with a message. */
sc_status mesh_read(const sc_ctx *ctx, const char *path, mesh *m);
/* Free the arrays of a mesh, also of one that was read only in part. */
void mesh_free(mesh *m);

/* Measure a triangle mesh (PLY or binary STL, in mm) against the surface of the shape's label 1.
 * @p out is set at once, also on failure. @return SC_ERR_DATA for a file that is none or
 * damaged, errors of reading, SC_ERR_MEMORY; each with a message. */
sc_status measure_mesh(const sc_ctx *ctx, const shape *s, const char *path, fidelity *out);
/* Measure what segcast draws, as @p how says, from the shape's voxels. Members of @p out are
 * overwritten; what cannot be measured of a shape gets NaN or -1. */
sc_status measure_volume(const sc_ctx *ctx, const shape *s, const drawing *how, fidelity *out);

/* A closed skin, one voxel thick, round two tissues. Every path of voxels that share faces from the
 * outside to a tissue leads through a voxel of the skin (it is 6-separating), but many of those
 * voxels touch only along edges or in corners. */
typedef struct skin {
    const char *name;
    double (*distance)(uint64_t seed, double scale, sc_vec3 p);
    bool ragged;       /* single voxels added and left out at random */
    double spacing[3]; /* mm along x, y, z */
    double scale;      /* mm of half the volume's edge */
} skin;
/* The table of skins [skin_count]. */
extern const skin skins[];
extern const size_t skin_count;
/* Find a skin of the table by name. @return NULL if there is none. */
const skin *skin_find(const char *name);

/* What rays from outside have met first. Rays that come upon a voxel of another tissue before one
 * of the skin are left out: there the skin itself is not closed. */
typedef struct leaks {
    double bare;    /* how many were left out */
    double rays;    /* that pass through a voxel of a tissue under the skin, and so have to pass
                       through a voxel of the skin before */
    double hits;    /* that met anything */
    double leaking; /* that met something else than the skin first */
} leaks;
/* The number of random skins of one kind that measure_skin looks at. */
enum { SKIN_VARIANTS = 4 };
/* Make the voxels of variant @p variant, counted from 0, of a skin: labels 1 and 2 for the tissues,
 * 3 for the skin. Caller owns @p out: sc_volume_clear. @return SC_ERR_MEMORY. */
sc_status skin_volume(const sc_ctx *ctx, const skin *k, int variant, sc_volume *out);
/* Count leaks of all variants of a skin, drawn as @p how says, to @p out, with about @p rays rays.
 * @return SC_ERR_MEMORY. */
sc_status measure_skin(const sc_ctx *ctx, const skin *k, const drawing *how, size_t rays,
                       leaks *out);
/* Add what @p rays random rays meet of @p volume, in which the label of dense id @p id is a closed
 * skin, to @p out. @param reach as of stage_open. @return SC_ERR_MEMORY. */
sc_status count_leaks(const sc_ctx *ctx, const sc_volume *volume, int id, const drawing *how,
                      double reach, size_t rays, leaks *out);

/* Print a member of a JSON object, followed by a comma unless @p last; null for what was not
 * measured: NAN and what is below 0. */
void print_value(const char *name, double value, bool last);

/* The next 64 random bits, or number in [0, 1), of a sequence whose state is *@p seed. */
uint64_t random_bits_of(uint64_t *seed);
double random_of(uint64_t *seed);

#endif
