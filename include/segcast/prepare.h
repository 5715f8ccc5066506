/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Preprocessing of a label volume (paper, section 2.3), once per job: finds the voxels on the
 *  boundaries of tissues, the weights and normals from which smooth surfaces are drawn, and the
 *  thickness and surface of each label. The result is one block of memory, which ranks share and
 *  which may be kept as a file; what a picture can show is derived from it when a job begins.
 *
 *  Functions that take a team are collective in it: all its ranks call them, in the same order and
 *  for the same volume, get the same return code and the same result, which does not depend on how
 *  many they are; arrays that they give out are the team's (sc_team_free, sc_team_close). None of
 *  the others is collective. Those that take a number of threads start them; all others may be
 *  called by any thread. */
#ifndef SEGCAST_PREPARE_H
#define SEGCAST_PREPARE_H

#include "segcast/brick.h"
#include "segcast/team.h"
#include "segcast/volume.h"

/** Wide kernels gather four bytes at a time even where they need one, and read the records of two
 *  vertices where there may be none. Arrays that they read are followed by this many bytes that may
 *  be read. */
enum { SC_GATHER_BYTES = 2 * SC_RECORD_BYTES };

/** Measurements of one label. */
typedef struct sc_label_stats {
    uint64_t voxels, boundary_voxels;
    double thickness_mm; /**< mean thickness, 2 V / S: twice the volume of its voxels divided by
                              surface_mm2. Of a sheet its thickness, of a rod its radius, of a ball
                              2/3 of its radius; 0 without voxels */
    double surface_mm2;  /**< area of the faces to other labels, each projected onto the smoothed
                              surface; 0 of the background */
    int low[3], high[3]; /**< bounding box in voxels, inclusive; low > high if there are none */
    double shown;        /**< share of what is seen from outside, 0 to 1: sc_find_covers */
    int64_t cover_layer; /**< 1 for the outermost cover, 2 for the next; 0: none */
} sc_label_stats;

/** What pictures of smooth surfaces are drawn from as long as every tissue is shown, as
 *  sc_preparation_derive has made it. Plain pointers, borrowed. */
typedef struct sc_stored {
    const uint64_t *masks;      /**< of sc_visible_cells, with its shape; NULL: nothing is stored */
    const uint32_t *cell_start; /**< as sc_cells.start */
    const sc_packed_cell *cells;   /**< [cell_count] as sc_cells.cells */
    const uint8_t *distances;      /**< of sc_brick_distances */
    const sc_vec3 *hull;           /**< [hull_count] of sc_hull_points */
    const uint8_t (*occlusion)[2]; /**< as sc_occlusion.filled, for the opacities below; NULL: it is
                                        not stored */
    const float *opacity; /**< [label_count], for which occlusion was made; NULL without it */
    size_t cell_count, hull_count;
} sc_stored;

/** The vertex records of one field. Read-only and borrowed. */
typedef struct sc_border {
    const uint64_t *masks;   /**< [bricks z][y][x]: the vertices that have a record */
    const uint32_t *start;   /**< [bricks z][y][x]: index of the brick's first record */
    const uint32_t *records; /**< [count] vertex records (brick.h), in the order of bricks and bits;
                                  SC_GATHER_BYTES more may be read */
    uint64_t count;
} sc_border;

/** The boundary of all labels. Read-only and borrowed. */
typedef struct sc_boundary {
    const uint64_t *masks; /**< [bricks z][y][x]: the boundary vertices, whose 3x3x3 holds another
                                label; outside of the volume is background */
    const uint32_t *start; /**< [bricks z][y][x]: how many there are in the bricks before */
    uint64_t count;        /**< of boundary vertices */
    uint64_t voxel_count;  /**< of boundary voxels that are not background */
} sc_boundary;

/** How a volume was prepared. The pointers are borrowed. */
typedef struct sc_prepared_how {
    const sc_vec3 *smooth; /**< [label_count] strength of the smoothing of each label along the axes
                                of the volume; 0 for the background */
    bool resampled;        /**< the grid is not that of the volume file: sc_resample */
    bool as_drawn;         /**< the grid is that on which the volume was drawn, as was measured
                                (sc_find_drawn_grid): there is nothing to resample */
    const uint8_t *hidden; /**< [label_count]: 1 for labels turned into background */
} sc_prepared_how;

/** A prepared volume: pointers into one block of memory, which stays borrowed. Read-only, so that
 *  threads and, in a shared window, processes may share it.
 *
 *  The label grid is one vertex wider than the volume on every side: grid vertex q is the centre of
 *  voxel q - 1. Masks have a bit for each of its vertices, brick by brick (brick.h).
 *
 *  Smooth surfaces are drawn from two fields, of which vertices near a border have records. The
 *  outer one separates the background from all tissue: it has a value at every vertex, whose sign
 *  tells the side. The inner one separates the tissues from each other: every vertex has a tissue,
 *  of which the background has no say, and a positive value, the weight of the tissue's vote. A
 *  point of a cell belongs to tissue where the trilinear sum of the outer values is positive, and
 *  there to the tissue with the largest vote: the trilinear sum of the inner values of the corners
 *  that have it; of equal votes the lower id wins. sc_vertex_at gives what holds at a vertex.
 *
 *  A vertex has an outer record if it is a corner of a cell with corners on both sides, or if its
 *  side is not that of its label. It has an inner record if it is a corner of a cell whose corners
 *  do not all have the same tissue and lie not all on the side of the background, or if its tissue
 *  is not its label and that is not the background. Vertices outside of the volume count with the
 *  label of the nearest voxel. */
typedef struct sc_prepared {
    int size[3];            /**< voxels along x, y, z */
    int bricks[3];          /**< bricks along x, y, z, without a frame: sc_bricks_along(size) */
    int label_bytes;        /**< of an id: 1 or 2 */
    int label_count;        /**< the background, id 0, included */
    bool oriented;          /**< false: the file does not say where left is; RAS was taken */
    bool numbered;          /**< the numbers of its labels are segcast's own: see sc_volume */
    sc_affine to_ras_mm;    /**< voxel index -> patient mm, RAS+ */
    uint64_t volume_hash;   /**< sc_volume_hash of what was prepared */
    uint64_t file_hash;     /**< checksum of the prepared file it was mapped from; 0: of no file */
    const void *ids;        /**< [size z][size y][size x] dense ids */
    const sc_label *labels; /**< [label_count] */
    const sc_label_stats *stats; /**< [label_count] */
    sc_boundary boundary;
    sc_border outer, inner;   /**< the records of the two fields */
    const uint8_t *thickness; /**< [boundary.count], in the order of bricks and bits of its masks:
                                   codes of the local thickness (sc_thickness_mm), 0 for background;
                                   NULL if it was not asked for */
    sc_prepared_how how;
    sc_stored stored; /**< of a prepared file; else all NULL and 0 */
} sc_prepared;

/** What to prepare, and how. */
typedef struct sc_prepare_settings {
    sc_vec3 smooth; /**< strength of the smoothing of surfaces along the volume's own axes, each 0
                         (crisp) to SC_SMOOTH_MAX */
    const sc_vec3
        *tissue_smooth;   /**< [label_count]: the strength of each label instead; that of
                               the background is not read. NULL: smooth for all. Borrowed
                               during the call. At most SC_SMOOTH_KINDS_MAX different ones */
    bool resampled;       /**< only noted in the result: the volume was brought to another grid */
    bool as_drawn;        /**< only noted in the result: see sc_prepared */
    bool local_thickness; /**< store the local thickness at every boundary voxel */
    const bool *hidden;   /**< [label_count]: the hidden labels, which the caller has turned into
                               background; only noted in the result. NULL: none. Borrowed during
                               the call. */
    int threads;          /**< how many to use, at least 1, if there is no team */
    sc_team *team;        /**< the ranks that prepare the volume together; borrowed until
                               sc_preparation_free. NULL: this rank alone, by its threads */
} sc_prepare_settings;
/** The strongest smoothing. */
#define SC_SMOOTH_MAX 2.5
/** The most different strengths in one volume: each takes tables of its own. */
#define SC_SMOOTH_KINDS_MAX 8
/** @return whether two strengths are the same, but for rounding. */
static inline bool sc_strength_is_same(sc_vec3 a, sc_vec3 b)
{
    return fabs(a.x - b.x) < 1e-9 && fabs(a.y - b.y) < 1e-9 && fabs(a.z - b.z) < 1e-9;
}
/** The strength on the grid on which a volume was drawn (sc_find_drawn_grid). */
#define SC_SMOOTH_AUTO 1.0

/** A preparation in memory, before it is packed or saved. */
typedef struct sc_preparation sc_preparation;

/** Preprocess a volume. A boundary voxel is one whose 3x3x3 neighbourhood holds another label
 *  (paper, section 2.3). Blocks until all threads are done. The result does not depend on their
 *  number, nor on that of the ranks. Collective in settings->team, whose ranks pass the same
 *  settings and the same volume; only the labels of the first rank's volume are read.
 *  @param volume stays borrowed until sc_preparation_free.
 *  @param out caller owns: sc_preparation_free.
 *  @return the same on all ranks of the team: SC_ERR_MEMORY, also for more vertices near an
 * interface than 32 bits can count; SC_ERR_DATA for more than SC_SMOOTH_KINDS_MAX strengths. */
SC_MUST_USE sc_status sc_prepare(const sc_ctx *ctx, const sc_volume *volume,
                                 const sc_prepare_settings *settings, sc_preparation **out);
/** Free a preparation; the volume and the team of the settings are left alone. Not collective; NULL
 *  is allowed. */
void sc_preparation_free(sc_preparation *preparation);
/** @return the size in bytes of the block that sc_preparation_pack fills. */
size_t sc_preparation_bytes(const sc_preparation *preparation);
/** Copy everything into one block, which may be moved or mapped to any 64-byte aligned address and
 *  needs neither the preparation nor the volume any more. Read it by sc_prepared_view.
 *  Not collective: of a team, the first rank does it. @param block of sc_preparation_bytes, 64-byte
 *  aligned. */
void sc_preparation_pack(const sc_preparation *preparation, void *block);
/** As sc_preparation_pack, by all ranks of the team together, whose blocks are one and the same
 *  memory. Returns when all is copied. Collective in the team. */
void sc_preparation_pack_together(const sc_preparation *preparation, void *block);
/** Derive what sc_stored holds, for the file that sc_preparation_save writes: a job that maps it
 *  need not do so. Blocks hold nothing of it. Once per preparation; collective in its team.
 *  @param opacity [label_count] as of sc_occlusion_build, the same on all ranks, borrowed during
 *  the call; NULL: the occlusion is left out. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_preparation_derive(const sc_ctx *ctx, sc_preparation *preparation,
                                            const float *opacity);
/** @return a view of what a preparation holds, which borrows from it and from its volume. */
sc_prepared sc_preparation_view(const sc_preparation *preparation);
/** Write the same block, with what sc_preparation_derive has made, as a file, with a checksum: the
 *  prepared file (.segc). It can be read by this version of segcast on machines of the same byte
 *  order. The file appears whole or not at
 *  all. @param replace as of sc_outfile_open. @param lasting false: it may be lost with the power.
 *  @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_preparation_save(const sc_ctx *ctx, const sc_preparation *preparation,
                                          const char *path, bool replace, bool lasting);
/** @return the size in bytes of the file that sc_preparation_save writes. */
uint64_t sc_preparation_file_bytes(const sc_preparation *preparation);
/** @return whether the file at @p path can be read and begins as a prepared file does. What follows
 *  is not looked at. Nothing is logged. */
bool sc_is_prepared_file(const char *path);
/** Check a prepared file, checksum and contents, for which all of it is read, and fill @p out with
 *  pointers into it. @param path for messages. @param block the whole mapped file, of @p bytes
 * bytes, 64-byte aligned; stays borrowed as long as @p out is used. @return SC_ERR_DATA if the file
 * is damaged, cut off, of another version or byte order, or holds what segcast never writes. After
 * a success the file can be drawn without a crash, whoever has written it. */
SC_MUST_USE sc_status sc_prepared_file_view(const sc_ctx *ctx, const char *path, const void *block,
                                            size_t bytes, sc_prepared *out);
/** Fill @p out with pointers into a packed block, which stays borrowed as long as @p out is used.
 *  Its contents are not checked; file_hash is 0. @param block of at least @p bytes bytes, 64-byte
 *  aligned. @return SC_ERR_DATA if it is no block of this version, or cut off. */
SC_MUST_USE sc_status sc_prepared_view(const sc_ctx *ctx, const void *block, size_t bytes,
                                       sc_prepared *out);

/** The most covers that sc_find_covers looks for. */
enum { SC_COVERS_MAX = 5 };
/** Find the covers: the tissue that hides others on at least 55 % of those rays along the axes of
 *  the volume, in both directions, that meet others at all; then the next with that one removed,
 *  for which 25 % are enough if it also encloses the others: lies before and behind them on 10 % of
 *  the rays along every axis.
 *  @param volume of which size, ids and label_count are read.
 *  @param hidden [label_count] by dense id: as if they were not there; NULL: none.
 *  @param layers [label_count]: 1 for the outermost cover, 2 for the next; 0 for all that are none.
 *  @param shown [label_count]: the share of the rays that meet anything which meet the tissue
 *  first; NULL: not wanted. @return SC_ERR_MEMORY, with nothing of use written. */
SC_MUST_USE sc_status sc_find_covers(const sc_ctx *ctx, const sc_volume *volume, const bool *hidden,
                                     int *layers, double *shown);
/** Find the outermost cover alone: that of layer 1 of sc_find_covers, for nothing hidden.
 *  @param cover set to its dense id; 0: none. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_find_outer_cover(const sc_ctx *ctx, const sc_volume *volume, int *cover);
/** @return the volume that was prepared, which borrows ids and labels from @p v: not to be cleared.
 */
sc_volume sc_volume_of_prepared(const sc_prepared *v);

/** @return whether (x, y, z) is the grid vertex of a voxel. */
static inline bool sc_is_voxel(const sc_prepared *v, int x, int y, int z)
{
    return x >= 1 && y >= 1 && z >= 1 && x <= v->size[0] && y <= v->size[1] && z <= v->size[2];
}

/** @return the dense id at a grid vertex; 0, the background, outside of the volume. */
static inline uint32_t sc_id_at_vertex(const sc_prepared *v, int x, int y, int z)
{
    const size_t index =
        ((size_t)(z - 1) * (size_t)v->size[1] + (size_t)(y - 1)) * (size_t)v->size[0] +
        (size_t)(x - 1);

    if (!sc_is_voxel(v, x, y, z))
        return 0;
    return v->label_bytes == 1 ? ((const uint8_t *)v->ids)[index]
                               : ((const uint16_t *)v->ids)[index];
}

/** As sc_id_at_vertex, but outside of the volume the id of the nearest voxel. */
static inline uint32_t sc_id_near_vertex(const sc_prepared *v, int x, int y, int z)
{
    int at[3] = {x, y, z};

    for (int i = 0; i < 3; i++)
        at[i] = at[i] < 1 ? 1 : at[i] > v->size[i] ? v->size[i] : at[i];
    return sc_id_at_vertex(v, at[0], at[1], at[2]);
}

/** @return whether (x, y, z), which must be a vertex of the label grid, is a boundary vertex. */
static inline bool sc_is_near(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick = sc_brick_index(v->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));

    return v->boundary.masks[brick] >> sc_brick_bit(x, y, z) & 1;
}

/** @return the index, in thickness, of vertex (x, y, z), which must be a boundary vertex. */
static inline size_t sc_near_index(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick = sc_brick_index(v->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));

    return v->boundary.start[brick] +
           sc_brick_rank(v->boundary.masks[brick], sc_brick_bit(x, y, z));
}

/** @return the record of the vertex at bit @p bit of brick @p brick; 0 if it has none. */
static inline uint32_t sc_border_record(const sc_border *b, size_t brick, int bit)
{
    const uint64_t mask = b->masks[brick];

    return mask >> bit & 1 ? b->records[b->start[brick] + sc_brick_rank(mask, bit)] : 0;
}

/** What the two fields say of a vertex. */
typedef struct sc_vertex {
    uint32_t outer, inner; /**< its records; 0: it has none */
    int outer_value; /**< positive on the side of tissue; without a record SC_VALUE_MAX, by the
                          side of its label */
    int inner_value; /**< without a record SC_VALUE_MAX */
    uint32_t tissue; /**< dense id; 0, far from tissue: none */
} sc_vertex;

/** Set the values and the tissue of the vertex (x, y, z) from its records, which are set. */
static inline void sc_vertex_complete(const sc_prepared *v, int x, int y, int z, sc_vertex *vertex)
{
    const uint32_t record = vertex->outer ? vertex->outer : vertex->inner;
    const int code = record ? sc_record_tissue(record) : SC_TISSUE_OWN;
    const uint32_t own = sc_id_near_vertex(v, x, y, z);

    vertex->outer_value = vertex->outer ? sc_record_value(vertex->outer)
                          : own         ? SC_VALUE_MAX
                                        : -SC_VALUE_MAX;
    vertex->inner_value = vertex->inner ? sc_record_value(vertex->inner) : SC_VALUE_MAX;
    vertex->tissue = code == SC_TISSUE_OWN ? own
                                           : sc_id_near_vertex(v, x + sc_tissue_step(code, 0),
                                                               y + sc_tissue_step(code, 1),
                                                               z + sc_tissue_step(code, 2));
}

/** @return what the fields say of (x, y, z), which must be a vertex of the label grid. */
static inline sc_vertex sc_vertex_at(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick = sc_brick_index(v->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));
    const int bit = sc_brick_bit(x, y, z);
    sc_vertex vertex = {.outer = sc_border_record(&v->outer, brick, bit),
                        .inner = sc_border_record(&v->inner, brick, bit)};

    sc_vertex_complete(v, x, y, z, &vertex);
    return vertex;
}

/** Codes of local thickness: SC_THICKNESS_STEPS of them for every doubling, code 0 standing for
 *  SC_THICKNESS_LEAST_MM. */
enum { SC_THICKNESS_STEPS = 16 };
#define SC_THICKNESS_LEAST_MM 0.05
/** @return the thickness in mm that a code, 0 to 255, of sc_prepared.thickness stands for. */
double sc_thickness_mm(int code);

/** What of a label takes part in a picture: bits, either or both. */
enum { SC_SHOW_BOUNDARY = 1, SC_SHOW_INTERIOR = 2 };
/** Write masks of the voxels that can contribute to a picture to @p out: boundary voxels of labels
 *  with SC_SHOW_BOUNDARY and interior voxels of labels with SC_SHOW_INTERIOR.
 *  @param show [label_count] bits by dense id; 0 for the background.
 *  Shape [bricks z + 2][bricks y + 2][bricks x + 2]: with a frame of empty bricks, so that kernels
 *  need not test whether a position is just outside. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_visible_masks(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                                       const uint8_t *show, uint64_t **out);
/** Write masks of the cells (cubes between 2x2x2 neighbouring vertices, named by the lowest) that
 * can hold a surface to @p out: those with corners on both sides of the outer field; those with a
 * corner on the side of tissue whose corners do not all have the same tissue; and those that reach
 * across the border of the volume and have a corner in it on the side of tissue. Of these such a
 * corner of which has a tissue with SC_SHOW_BOUNDARY. Parameters, shape, errors and owner as of
 *  sc_visible_masks. */
SC_MUST_USE sc_status sc_visible_cells(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                                       const uint8_t *show, uint64_t **out);
/** Write the chessboard distance, in bricks, from every brick to the nearest one that is not empty
 *  to @p out: 0 for a brick that is not empty itself; 254 also stands for all larger distances, and
 *  for no such brick at all. SC_GATHER_BYTES more may be read.
 *  @param bricks along x, y, z. @param masks 0 for bricks that are empty, with a frame, as of
 *  sc_visible_masks or sc_visible_cells. @param out one byte for each brick of @p masks, the frame
 *  included. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_brick_distances(const sc_ctx *ctx, sc_team *team, const int bricks[3],
                                         const uint64_t *masks, uint8_t **out);
/** How the distance between two cells is counted. */
typedef enum sc_metric {
    SC_METRIC_CITY_BLOCK, /**< the sum of the distances along the axes: steps to face neighbours */
    SC_METRIC_CHESSBOARD  /**< the largest of them: steps to any of 26 neighbours */
} sc_metric;
/** Write the distance from every cell (or voxel) to the nearest one that is set in @p masks to @p
 *  out: 0 for those that are set; 254 also stands for all larger distances, and for no such cell at
 *  all. SC_GATHER_BYTES more may be read. One thread does the work.
 *  @param masks of sc_visible_masks or sc_visible_cells. @param out SC_BRICK_VERTICES bytes for
 *  each brick of @p masks, the frame included, in the order of bricks and bits.
 *  @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_cell_distances(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                                        const uint64_t *masks, sc_metric metric, uint8_t **out);
/** Levels of masks in a pyramid. */
enum { SC_PYRAMID_LEVELS = 4 };
/** Where the masks of a pyramid of binary volumes stand: each bit of a mask of level n + 1 says
 *  whether any is set in one mask of level n, so that it stands for a cube of 4^(n + 1) cells.
 *  Every level is an array [z][y][x] with a frame of one empty mask around it. Plain numbers. */
typedef struct sc_pyramid {
    int32_t row[SC_PYRAMID_LEVELS], layer[SC_PYRAMID_LEVELS]; /**< steps in the array from a mask to
                                                                   the next along y and z */
    int32_t origin[SC_PYRAMID_LEVELS]; /**< index of mask (0, 0, 0) of the level */
    size_t count;                      /**< masks of all levels */
} sc_pyramid;
/** Put the upper levels of the pyramid behind the masks that are its lowest one.
 *  @param masks of sc_visible_masks or sc_visible_cells; replaced by a longer array of the team,
 *  which begins with the same masks. @return SC_ERR_MEMORY; *@p masks is then unchanged. */
SC_MUST_USE sc_status sc_pyramid_build(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                                       uint64_t **masks, sc_pyramid *out);
/** The cells of sc_visible_cells, packed in the order of bricks and bits. The arrays are those of a
 *  team. */
typedef struct sc_cells {
    uint32_t *start; /**< [bricks z + 2][y + 2][x + 2]: index in cells of the brick's first one */
    sc_packed_cell *cells; /**< [count] */
    size_t count;
} sc_cells;
/** Fill @p out with the packed cells of @p masks (of sc_visible_cells; only borrowed).
 *  @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_cells_build(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                                     const uint64_t *masks, sc_cells *out);
/** How much of the surroundings of a brick is filled with visible tissue, from which the kernels
 *  estimate how much light reaches a point in a cavity, and shadows: the opacity of the voxels,
 *  blurred by two Gaussians; 255 stands for opaque tissue everywhere. */
typedef struct sc_occlusion {
    int size[3];                /**< bricks along each axis, the frame of empty ones included */
    const uint8_t (*filled)[2]; /**< [z][y][x], of a team or stored with the volume: by the narrow
                                   [0] and the wide [1] blur */
    float brick_offset;         /**< a grid coordinate / SC_BRICK + brick_offset is the coordinate
                                     in this array, whole numbers being the middles of bricks */
    double narrow_mm, wide_mm;  /**< standard deviations of the blurs */
    double mm_per_step;         /**< the shortest edge of a brick */
} sc_occlusion;
/** Fill @p out; what is stored with the volume is taken if it was made for the same opacities.
 * @param opacity [label_count] by dense id, 0 to 1; 0 for tissues that are not visible and for the
 * background. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_occlusion_build(const sc_ctx *ctx, sc_team *team,
                                         const sc_prepared *volume, const float *opacity,
                                         sc_occlusion *out);
/** Write corners of the boxes of visible voxels (as of sc_visible_masks, from @p show), in RAS mm,
 * to
 *  @p out: all corners of the convex hull of all such boxes are among them. @param out [count], in
 *  the order of layers. @param count how many were found; 0 if nothing is visible. @return
 *  SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_hull_points(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                                     const uint8_t *show, sc_vec3 **out, size_t *count);

#endif
