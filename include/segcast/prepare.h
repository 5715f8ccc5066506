/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Preprocessing of a label volume (paper, section 2.3), once per job: finds the voxels on the
 *  boundaries of tissues, the weights and normals from which smooth surfaces are drawn, and the
 *  thickness and surface of each label. The result is one block of memory, which ranks share and
 *  which may be kept as a file; what a picture can show is derived from it when a job begins.
 *
 *  None of the functions is collective. Those that take a number of threads start them; all others
 *  may be called by any thread. */
#ifndef SEGCAST_PREPARE_H
#define SEGCAST_PREPARE_H

#include "segcast/brick.h"
#include "segcast/volume.h"

/** Wide kernels gather four bytes at a time even where they need one. Arrays that they read are
 *  followed by this many bytes that may be read. */
enum { SC_GATHER_BYTES = 3 };

/** Measurements of one label. */
typedef struct sc_label_stats {
    uint64_t voxels, boundary_voxels;
    double thickness_mm; /**< mean local thickness: twice the mean distance from the medial voxels
                              to the tissue's surface, each weighted by its square; 0 if not
                              measured */
    double surface_mm2;  /**< area of the faces to other labels, each projected onto the smoothed
                              surface; 0 if not measured */
    int low[3], high[3]; /**< bounding box in voxels, inclusive; low > high if there are none */
} sc_label_stats;

/** A prepared volume: pointers into one block of memory, which stays borrowed. Read-only, so that
 *  threads and, in a shared window, processes may share it.
 *
 *  The label grid is one vertex wider than the volume on every side, and the vertices around the
 *  volume are background: grid vertex q is the centre of voxel q - 1. Masks have a bit for each of
 *  its vertices, brick by brick (brick.h). A vertex is near an interface if its 3x3x3 neighbourhood
 *  holds another label; then it has a vertex record. */
typedef struct sc_prepared {
    int size[3], bricks[3];
    int label_bytes, label_count;
    bool oriented;
    sc_affine to_ras_mm;
    uint64_t volume_hash;
    uint64_t file_hash;      /**< checksum of the prepared file it was mapped from; 0: of no file */
    uint64_t boundary_count; /**< boundary voxels that are not background */
    uint64_t near_count;     /**< vertices near an interface */
    const void *ids;         /**< [size z][size y][size x], 1 or 2 bytes */
    const sc_label *labels;  /**< [label_count] */
    const sc_label_stats *stats; /**< [label_count] */
    const uint64_t *near;        /**< [bricks z][y][x]: masks of the vertices near an interface.
                                      All corners of a cell that holds more than one label are. */
    const uint32_t *near_start;  /**< [bricks z][y][x]: index of the brick's first record */
    const uint8_t *records;      /**< [near_count] vertex records of SC_RECORD_BYTES (brick.h), in
                                      the order of bricks and bits */
    const uint8_t *thickness;    /**< [near_count] codes of the local thickness (sc_thickness_mm),
                                      0 for background; NULL if it was not asked for */
    /* how it was prepared */
    double smooth;                   /**< sc_prepare_settings.smooth */
    bool has_thickness, has_surface; /**< the labels were measured so */
    const uint8_t *hidden;           /**< [label_count]: 1 for labels turned into background */
} sc_prepared;

/** What to prepare, and how. */
typedef struct sc_prepare_settings {
    double smooth;        /**< strength of the smoothing of surfaces, 0 (crisp) to SC_SMOOTH_MAX */
    bool thickness;       /**< measure the mean thickness of every label */
    bool local_thickness; /**< store the local thickness at every vertex near an interface */
    bool surface;         /**< measure the surface of every label */
    const bool *hidden;   /**< [label_count]: the hidden labels, which the caller has turned into
                               background; only noted in the result. NULL: none. Borrowed during
                               the call. */
    int threads;
} sc_prepare_settings;
#define SC_SMOOTH_MAX 1.25

/** A preparation in memory, before it is packed or saved. */
typedef struct sc_preparation sc_preparation;

/** Preprocess a volume. A boundary voxel is one whose 3x3x3 neighbourhood holds another label
 *  (paper, section 2.3). @p volume stays borrowed until sc_preparation_free. The result does not
 *  depend on the number of threads. @param out caller owns: sc_preparation_free.
 *  @return SC_ERR_MEMORY, also for more vertices near an interface than 32 bits can count. */
SC_MUST_USE sc_status sc_prepare(const sc_ctx *ctx, const sc_volume *volume,
                                 const sc_prepare_settings *settings, sc_preparation **out);
void sc_preparation_free(sc_preparation *preparation);
/** @return size of the block that sc_preparation_pack fills. */
size_t sc_preparation_bytes(const sc_preparation *preparation);
/** Copy everything into one block, which may be moved or mapped to any address.
 *  @param block of sc_preparation_bytes, 64-byte aligned. */
void sc_preparation_pack(const sc_preparation *preparation, void *block);
/** Write the same block as a file, with a checksum: the prepared file (.segc). It can be read by
 *  this version of segcast on machines of the same byte order. The file appears whole or not at
 *  all.
 *  @return SC_ERR_CREATE, SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_preparation_save(const sc_ctx *ctx, const sc_preparation *preparation,
                                          const char *path);
/** @return whether a file can be read and begins as a prepared file does. */
bool sc_is_prepared_file(const char *path);
/** View a mapped prepared file, after its checksum has been compared. @p block stays borrowed.
 *  @param path for messages. @return SC_ERR_DATA if the file is damaged, cut off, or of another
 *  version or byte order. */
SC_MUST_USE sc_status sc_prepared_file_view(const sc_ctx *ctx, const char *path, const void *block,
                                            size_t bytes, sc_prepared *out);
/** View a packed block, which stays borrowed. Its contents are not checked.
 *  @return SC_ERR_DATA if it is no block of this version. */
SC_MUST_USE sc_status sc_prepared_view(const sc_ctx *ctx, const void *block, size_t bytes,
                                       sc_prepared *out);

/** The dense id at a grid vertex; background outside of the volume. */
static inline uint32_t sc_id_at_vertex(const sc_prepared *v, int x, int y, int z)
{
    const size_t index =
        ((size_t)(z - 1) * (size_t)v->size[1] + (size_t)(y - 1)) * (size_t)v->size[0] +
        (size_t)(x - 1);

    if (x < 1 || y < 1 || z < 1 || x > v->size[0] || y > v->size[1] || z > v->size[2])
        return 0;
    return v->label_bytes == 1 ? ((const uint8_t *)v->ids)[index]
                               : ((const uint16_t *)v->ids)[index];
}

/** Is the vertex near an interface? It must be one of the label grid. */
static inline bool sc_is_near(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick = sc_brick_index(v->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));

    return v->near[brick] >> sc_brick_bit(x, y, z) & 1;
}

/** Index of the record of vertex (x, y, z), which must be near an interface. */
static inline size_t sc_record_index(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick = sc_brick_index(v->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));

    return v->near_start[brick] + sc_brick_rank(v->near[brick], sc_brick_bit(x, y, z));
}

/** Codes of local thickness: SC_THICKNESS_STEPS of them for every doubling, code 0 standing for
 *  SC_THICKNESS_LEAST_MM. */
enum { SC_THICKNESS_STEPS = 16 };
#define SC_THICKNESS_LEAST_MM 0.05
/** @return the thickness of a code. */
double sc_thickness_mm(int code);

/** How a label takes part in a picture. */
enum { SC_SHOW_BOUNDARY = 1, SC_SHOW_INTERIOR = 2 };
/** Masks of the voxels that can contribute to a picture: boundary voxels of labels with
 *  SC_SHOW_BOUNDARY in @p show (by dense id) and interior voxels of labels with SC_SHOW_INTERIOR.
 *  Shape [bricks z + 2][bricks y + 2][bricks x + 2]: with a frame of empty bricks, so that kernels
 *  need not test whether a position is just outside. @return SC_ERR_MEMORY. Caller owns: sc_free.
 */
SC_MUST_USE sc_status sc_visible_masks(const sc_ctx *ctx, const sc_prepared *volume,
                                       const uint8_t *show, int threads, uint64_t **out);
/** Masks of the cells (cubes between 2x2x2 neighbouring vertices, named by the lowest) that hold
 *  more than one label, one of them with SC_SHOW_BOUNDARY. Shape, errors and owner as of
 *  sc_visible_masks. */
SC_MUST_USE sc_status sc_visible_cells(const sc_ctx *ctx, const sc_prepared *volume,
                                       const uint8_t *show, int threads, uint64_t **out);
/** Chessboard distance, in bricks, from every brick to the nearest one that is not empty: 0 for a
 *  brick that is not empty itself, and 254 for distances beyond. SC_GATHER_BYTES more may be read.
 *  @param masks of sc_visible_masks or sc_visible_cells. @param out of the same shape.
 *  @return SC_ERR_MEMORY. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_brick_distances(const sc_ctx *ctx, const sc_prepared *volume,
                                         const uint64_t *masks, uint8_t **out);
/** The cells of sc_visible_cells, packed (brick.h tells how) in the order of bricks and bits. */
typedef struct sc_cells {
    uint32_t *start; /**< [bricks z + 2][y + 2][x + 2]: index of the brick's first cell */
    uint64_t *cells; /**< [count] */
    size_t count;
} sc_cells;
/** Pack the cells of @p masks. The result does not depend on @p threads. Caller owns:
 *  sc_cells_clear.
 *  @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_cells_build(const sc_ctx *ctx, const sc_prepared *volume,
                                     const uint64_t *masks, int threads, sc_cells *out);
void sc_cells_clear(sc_cells *cells);
/** How much of the surroundings of a brick is filled with visible tissue, from which the kernels
 *  estimate how much light reaches a point in a cavity, and shadows: the opacity of the voxels,
 *  blurred by two Gaussians; 255 stands for opaque tissue everywhere. */
typedef struct sc_occlusion {
    int size[3];               /**< bricks along each axis, the frame of empty ones included */
    uint8_t (*filled)[2];      /**< [z][y][x]: by the narrow and by the wide blur */
    float brick_offset;        /**< a grid coordinate / SC_BRICK + brick_offset is the coordinate
                                    in this array, whole numbers being the middles of bricks */
    double narrow_mm, wide_mm; /**< standard deviations of the blurs */
    double mm_per_step;        /**< the shortest edge of a brick */
} sc_occlusion;
/** Make one. @param opacity by dense id, 0 for tissues that are not visible. The result does not
 *  depend on @p threads. Caller owns: sc_occlusion_clear. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_occlusion_build(const sc_ctx *ctx, const sc_prepared *volume,
                                         const float *opacity, int threads, sc_occlusion *out);
void sc_occlusion_clear(sc_occlusion *occlusion);
/** The centres, in RAS mm, of the first and the last voxel of every row that is set in @p masks (of
 *  sc_visible_masks or sc_visible_cells). All corners of the convex hull of what can be seen are
 *  among them. @param out [count]; caller owns: sc_free. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_hull_points(const sc_ctx *ctx, const sc_prepared *volume,
                                     const uint64_t *masks, sc_vec3 **out, size_t *count);

#endif
