/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to the fidelity tool: surfaces as many small flat tiles, the distance of points from
 * them, and the comparison of a volume with its truth. */
#ifndef SC_FIDELITY_AGAINST_H
#define SC_FIDELITY_AGAINST_H

#include "fidelity.h"

/* A small flat piece of a surface in RAS mm: the points middle + s a + t b with s and t from -1 to
 * 1; a and b are at right angles, or 0: then it is a point. */
typedef struct tile {
    float middle[3], a[3], b[3];
} tile;

/* A list of tiles that grows; owns its array. Starts as {0}; tiles_free. */
typedef struct tiles {
    tile *list; /* [count], room for capacity */
    size_t count, capacity;
} tiles;
/* Append a tile. Aborts without memory. */
void tiles_add(tiles *t, const tile *piece);
/* Free the array; @p t is {0} then. */
void tiles_free(tiles *t);

/* Boxes around tiles, in which the nearest one is found. Owns its array; borrows the tiles. */
typedef struct tree tree;
/* Bring the tiles of @p t into an order in which neighbours stand together, and build boxes around
 * them; they must stay where they are then. Without tiles every distance is HUGE_VAL. Caller owns
 * *@p out: tree_free. @return SC_ERR_MEMORY. */
sc_status tree_build(const sc_ctx *ctx, tiles *t, tree **out);
/* Free the tree; NULL is allowed. */
void tree_free(tree *t);
/* The distance in mm of the point @p p, RAS mm, from the nearest tile. Threads: any number. */
double tree_distance(const tree *t, sc_vec3 p);

/* Are the vertices of the cell that holds the point @p p, in voxels of the stage, and those around
 * it of one label, or is it outside? */
bool is_uniform(const stage *st, sc_vec3 p);
/* Add the surfaces that are drawn of a prepared volume to @p out, tissue by tissue, by random
 * lines: each point where a line passes from one owner to another belongs to the surfaces of both,
 * as the middle of a tile. Tiles are spread evenly over the area, so large that they nearly cover
 * it.
 * @param tissue_of [label_count] index into @p out by dense id; negative: left out. @return
 * SC_ERR_MEMORY. */
sc_status add_drawn(const sc_ctx *ctx, const stage *st, const int *tissue_of, int threads,
                    tiles **out);
/* Add all faces between voxels of different labels, tissue by tissue, to @p out. @p tissue_of as
 * of add_drawn. */
void add_faces(const sc_volume *volume, const int *tissue_of, tiles **out);
/* Add tiles spread evenly over the area of a mesh in RAS mm to @p out. */
void add_mesh(const mesh *m, tiles *out);

/* What two volumes have in common, in voxels of the first: the voxels from low to high, inclusive,
 * none of them at the border of either volume. */
typedef struct region {
    sc_affine to_voxel, to_ras_mm; /* of the first volume */
    int low[3], high[3];
} region;
/* Does the point @p mm (RAS) lie in the region? */
bool region_holds(const region *r, sc_vec3 mm);

/* What to compare, and how. */
typedef struct comparison {
    const char *truth, *volume; /* paths */
    const char *meshes;         /* directory of LABEL.ply, in RAS mm, to be measured instead of
                                   what is drawn of the volume; NULL: none */
    double truth_smooth;        /* the truth is drawn, too, with this smoothing; NAN: the truth
                                   are the faces of its voxels */
    drawing how;
    bool json;
} comparison;
/* Distances in mm: all from one surface to another. Owned. */
typedef struct distances {
    double *mm;
    size_t count;
} distances;

/* One tissue of the truth. Volumes and distances are those within the region. */
typedef struct tissue {
    int64_t value;
    const char *name;
    bool in_volume;        /* the volume has the label */
    double true_mm3, kept; /* kept: as a share of true_mm3; NAN if that is 0 */
    double thickness_mm;   /* in the truth: twice the volume divided by the surface; of a plate its
                              thickness, of a tube its radius, of a ball a third of its diameter */
    tiles truth, drawn;    /* surfaces */
    distances to, from;    /* of the drawn surface to the truth, of the truth from it */
} tissue;
/* Print what has been measured: a row for each tissue that the volume has or that is gone, and one
 * for all large ones. Distances get sorted. */
void print_comparison(const comparison *c, tissue *tissues, int count);

/* Measure the surfaces of the volume against those of the truth, tissue by tissue, and print them.
 * @return errors of reading and preparing, with a message; SC_ERR_DATA if the volumes have no
 * tissue or no space in common. */
sc_status compare_volumes(const sc_ctx *ctx, const comparison *c);

#endif
