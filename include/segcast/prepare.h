/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 3: preprocessing (paper, section 2.3): which voxels lie on a tissue's boundary, the
 *  normals there, and what is measured of each label. */
#ifndef SEGCAST_PREPARE_H
#define SEGCAST_PREPARE_H

#include "segcast/brick.h"
#include "segcast/volume.h"

/** Wide kernels read single bytes by four: so many may be read beyond the end of what they use. */
enum { SC_GATHER_BYTES = 3 };

/** What is measured of one label. */
typedef struct sc_label_stats {
    uint64_t voxels, boundary_voxels;
    double thickness_mm; /**< mean local thickness: twice the distance of the medial voxels to
                              the tissue's surface, weighted by its square; 0 if not measured */
    double surface_mm2;  /**< faces to other labels, projected onto the smoothed surface */
    int low[3], high[3]; /**< bounding box, voxels, inclusive; low > high if there are none */
} sc_label_stats;

/** A prepared volume: pointers into one block of memory, which stays borrowed. Read-only and
 *  therefore free to share between threads and, in a shared window, between processes.
 *
 *  Masks stand on a grid one voxel wider on every side than the volume (what lies outside is
 *  background): place q of that grid is voxel q - 1, and a brick holds 4^3 places. */
typedef struct sc_prepared {
    int size[3], bricks[3];
    int label_bytes, label_count;
    bool oriented;
    sc_affine to_ras_mm;
    uint64_t volume_hash;
    uint64_t boundary_count;     /**< boundary voxels that are not background */
    uint64_t near_count;         /**< places near an interface */
    const void *ids;             /**< [size z][size y][size x], 1 or 2 bytes */
    const sc_label *labels;      /**< [label_count] */
    const sc_label_stats *stats; /**< [label_count] */
    const uint64_t *near;        /**< [bricks z][y][x]: bit sc_brick_bit of a place is set
                                      where the 3x3x3 neighbourhood holds another label: for
                                      every corner of a cell that holds more than one */
    const uint32_t *near_start;  /**< [bricks z][y][x]: index of the brick's first record */
    const uint8_t *records;      /**< [near_count] of SC_RECORD_BYTES, in the order of bricks and
                                      bits: see brick.h */
    const uint8_t *thickness;    /**< [near_count] codes of the local thickness (see
                                      sc_thickness_mm), or NULL if it was not asked for */
    /* how it was prepared */
    double smooth;
    bool has_thickness, has_surface; /**< they were measured */
    const uint8_t *hidden;           /**< [label_count]: 1 for labels turned into background */
} sc_prepared;

typedef struct sc_prepare_settings {
    double smooth;        /**< strength of the smoothing of surfaces, 0 (crisp) to SC_SMOOTH_MAX */
    bool thickness;       /**< measure the thickness of every label */
    bool local_thickness; /**< also at every place */
    bool surface;         /**< measure the surface of every label */
    const bool *hidden;   /**< [label_count]: labels that were turned into background, to be noted;
                               NULL: none. Borrowed. */
    int threads;
} sc_prepare_settings;
#define SC_SMOOTH_MAX 1.25

typedef struct sc_preparation sc_preparation;

/** Preprocess a volume. @p volume stays borrowed until sc_preparation_free.
 *  The result does not depend on the number of threads. @return SC_ERR_MEMORY.
 *  Source of the boundary rule: the paper, section 2.3: a boundary voxel's 3x3x3 neighbourhood
 *  holds another label; outside the volume is background. */
SC_MUST_USE sc_status sc_prepare(const sc_ctx *ctx, const sc_volume *volume,
                                 const sc_prepare_settings *settings, sc_preparation **out);
void sc_preparation_free(sc_preparation *preparation);
/** Size of the block that sc_preparation_pack fills. */
size_t sc_preparation_bytes(const sc_preparation *preparation);
/** Copy everything into one position-independent block, 64-byte aligned. */
void sc_preparation_pack(const sc_preparation *preparation, void *block);
/** Write the same block as a file, with a checksum: the prepared file (.segc), for this version of
 *  segcast on machines with this order of bytes. @return SC_ERR_CREATE, SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_preparation_save(const sc_ctx *ctx, const sc_preparation *preparation,
                                          const char *path);
/** Does a file begin as a prepared one does? */
bool sc_is_prepared_file(const char *path);
/** Look into a mapped prepared file. @param path for messages. @return SC_ERR_DATA if it is
 *  damaged, cut off, or of another version or byte order. */
SC_MUST_USE sc_status sc_prepared_file_view(const sc_ctx *ctx, const char *path, const void *block,
                                            size_t bytes, sc_prepared *out);
/** Look into a packed block. @return SC_ERR_DATA if it is none. */
SC_MUST_USE sc_status sc_prepared_view(const sc_ctx *ctx, const void *block, size_t bytes,
                                       sc_prepared *out);

/** The dense id at a place; outside of the volume background. */
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

/** Is the vertex near an interface? */
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

/** Thickness of a code: SC_THICKNESS_STEPS codes to an octave, from SC_THICKNESS_LEAST_MM up. */
enum { SC_THICKNESS_STEPS = 16 };
#define SC_THICKNESS_LEAST_MM 0.05
double sc_thickness_mm(int code);

/** How a label takes part in a picture. */
enum { SC_SHOW_BOUNDARY = 1, SC_SHOW_INTERIOR = 2 };
/** Masks of the voxels that can contribute: boundary voxels of labels with SC_SHOW_BOUNDARY in
 *  @p show (by dense id) and interior ones of those with SC_SHOW_INTERIOR. Shape
 *  [bricks z + 2][bricks y + 2][bricks x + 2]: within a frame of empty bricks, so that a look
 *  just outside the volume needs no test. @return SC_ERR_MEMORY. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_visible_masks(const sc_ctx *ctx, const sc_prepared *volume,
                                       const uint8_t *show, int threads, uint64_t **out);
/** Masks of the cells (between the centres of 2x2x2 places, named by the lowest) that hold more
 *  than one label, one of them with SC_SHOW_BOUNDARY; shape as of sc_visible_masks. */
SC_MUST_USE sc_status sc_visible_cells(const sc_ctx *ctx, const sc_prepared *volume,
                                       const uint8_t *show, int threads, uint64_t **out);
/** Chessboard distance, in bricks, of every brick of @p masks (of sc_visible_masks or
 *  sc_visible_cells; same shape) to the nearest one that is not empty: all bricks less than that
 *  away are. 0 for those that are not; no more than 254. SC_GATHER_BYTES more may be read.
 *  @return SC_ERR_MEMORY. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_brick_distances(const sc_ctx *ctx, const sc_prepared *volume,
                                         const uint64_t *masks, uint8_t **out);
/** The cells of sc_visible_cells, packed (brick.h tells how) in the order of bricks and bits. */
typedef struct sc_cells {
    uint32_t *start; /**< [bricks z + 2][y + 2][x + 2]: index of the brick's first cell */
    uint64_t *cells; /**< [count] */
    size_t count;
} sc_cells;
/** @return SC_ERR_MEMORY. The result does not depend on @p threads. Caller owns: sc_cells_clear. */
SC_MUST_USE sc_status sc_cells_build(const sc_ctx *ctx, const sc_prepared *volume,
                                     const uint64_t *masks, int threads, sc_cells *out);
void sc_cells_clear(sc_cells *cells);
/** How much of its surroundings is filled with visible tissue, coarsely: for the light in
 *  cavities and for shadows. Values of two Gaussian blurs, 255 for all filled. */
typedef struct sc_occlusion {
    int size[3];               /**< bricks in each direction, within a frame of empty ones */
    uint8_t (*filled)[2];      /**< [z][y][x]: by the narrow and by the wide blur */
    float brick_offset;        /**< brick coordinate = place / SC_BRICK + brick_offset */
    double narrow_mm, wide_mm; /**< widths of the blurs */
    double mm_per_step;        /**< edge of a brick along its shortest side */
} sc_occlusion;
/** @param opacity by dense id, 0 for what is not visible. @return SC_ERR_MEMORY. The result does
 *  not depend on @p threads. Caller owns: sc_occlusion_clear. */
SC_MUST_USE sc_status sc_occlusion_build(const sc_ctx *ctx, const sc_prepared *volume,
                                         const float *opacity, int threads, sc_occlusion *out);
void sc_occlusion_clear(sc_occlusion *occlusion);
/** Centres in mm of the first and last set voxel of every row: all corners of the convex hull of
 *  what the masks show are among them. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_hull_points(const sc_ctx *ctx, const sc_prepared *volume,
                                     const uint64_t *masks, sc_vec3 **out, size_t *count);

#endif
