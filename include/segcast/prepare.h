/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 3: preprocessing (paper, section 2.3): which voxels lie on a tissue's boundary, the
 *  normals there, and what is measured of each label. */
#ifndef SEGCAST_PREPARE_H
#define SEGCAST_PREPARE_H

#include "segcast/volume.h"

enum { SC_BRICK = 4 /**< edge of a brick in voxels; its 64 voxels are the bits of one mask */ };

/** What is measured of one label. */
typedef struct sc_label_stats {
    uint64_t voxels, boundary_voxels;
    double thickness_mm; /**< mean local thickness: twice the distance of the medial voxels to
                              the tissue's surface, weighted by its square; 0 if no voxels */
    double surface_mm2;  /**< faces to other labels, projected onto the smoothed surface */
    int low[3], high[3]; /**< bounding box, voxels, inclusive; low > high if there are none */
} sc_label_stats;

/** A prepared volume: pointers into one block of memory, which stays borrowed. Read-only and
 *  therefore free to share between threads and, in a shared window, between processes. */
typedef struct sc_prepared {
    int size[3], bricks[3];
    int label_bytes, label_count;
    bool oriented;
    sc_affine to_ras_mm;
    uint64_t volume_hash;
    uint64_t boundary_count;
    const void *ids;              /**< [size z][size y][size x], 1 or 2 bytes */
    const sc_label *labels;       /**< [label_count] */
    const sc_label_stats *stats;  /**< [label_count] */
    const uint64_t *boundary;     /**< [bricks z][y][x]: bit x + 4 y + 16 z within the brick is
                                       set for a boundary voxel that is not background */
    const uint32_t *normal_start; /**< [bricks z][y][x]: index of the brick's first normal */
    const uint32_t *normals;      /**< [boundary_count], in the order of bricks and bits; see
                                       sc_normal_pack */
} sc_prepared;

typedef struct sc_preparation sc_preparation;

/** Preprocess a volume. @p volume stays borrowed until sc_preparation_free.
 *  The result does not depend on @p threads. @return SC_ERR_MEMORY.
 *  Source of the boundary rule: the paper, section 2.3: a boundary voxel's 3x3x3 neighbourhood
 *  holds another label; outside the volume is background. */
SC_MUST_USE sc_status sc_prepare(const sc_ctx *ctx, const sc_volume *volume, int threads,
                                 sc_preparation **out);
void sc_preparation_free(sc_preparation *preparation);
/** Size of the block that sc_preparation_pack fills. */
size_t sc_preparation_bytes(const sc_preparation *preparation);
/** Copy everything into one position-independent block, 64-byte aligned. */
void sc_preparation_pack(const sc_preparation *preparation, void *block);
/** Look into a packed block. @return SC_ERR_DATA if it is none. */
SC_MUST_USE sc_status sc_prepared_view(const sc_ctx *ctx, const void *block, size_t bytes,
                                       sc_prepared *out);

/** A normal in RAS as three signed 10-bit fractions (x lowest); 0: the voxel has no direction,
 *  as in the middle of a sheet one voxel thick. */
uint32_t sc_normal_pack(double x, double y, double z);
static inline void sc_normal_unpack(uint32_t packed, float out[3])
{
    out[0] = (float)((int32_t)(packed << 22) >> 22);
    out[1] = (float)((int32_t)(packed << 12) >> 22);
    out[2] = (float)((int32_t)(packed << 2) >> 22);
}

/** How a label takes part in a picture. */
enum { SC_SHOW_BOUNDARY = 1, SC_SHOW_INTERIOR = 2 };
/** Masks of the voxels that can contribute: boundary voxels of labels with SC_SHOW_BOUNDARY in
 *  @p show (by dense id) and interior ones of those with SC_SHOW_INTERIOR. Shape
 *  [bricks z + 2][bricks y + 2][bricks x + 2]: within a frame of empty bricks, so that a look
 *  just outside the volume needs no test. @return SC_ERR_MEMORY. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_visible_masks(const sc_ctx *ctx, const sc_prepared *volume,
                                       const uint8_t *show, int threads, uint64_t **out);
/** Centres in mm of the first and last set voxel of every row: all corners of the convex hull of
 *  what the masks show are among them. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_hull_points(const sc_ctx *ctx, const sc_prepared *volume,
                                     const uint64_t *masks, sc_vec3 **out, size_t *count);

#endif
