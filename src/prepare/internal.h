/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to prepare: a preparation in the making, before it is packed into one block, and the
 * stages that fill it. */
#ifndef SC_PREPARE_INTERNAL_H
#define SC_PREPARE_INTERNAL_H

#include "segcast/brick.h"
#include "segcast/prepare.h"

struct sc_preparation {
    const sc_volume *volume;
    sc_prepare_settings settings;
    int bricks[3];
    size_t brick_count;
    uint64_t *near;
    uint32_t *near_start;
    uint8_t *records, *thickness;
    uint64_t near_count, boundary_count;
    sc_label_stats *stats;
    uint64_t volume_hash;
    uint8_t *hidden; /* [label_count] */
};

/* The dense id of the voxel at an index of the volume. */
static inline uint32_t sc_id_at(const sc_volume *volume, size_t index)
{
    return volume->label_bytes == 1 ? ((const uint8_t *)volume->ids)[index]
                                    : ((const uint16_t *)volume->ids)[index];
}

/* The dense id of a voxel; background outside of the volume. */
static inline uint32_t sc_id_or_background(const sc_volume *v, int x, int y, int z)
{
    if (x < 0 || y < 0 || z < 0 || x >= v->size[0] || y >= v->size[1] || z >= v->size[2])
        return 0;
    return sc_id_at(v,
                    ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x);
}

/* A boundary voxel that is not background, as sc_each_boundary passes it on. */
typedef struct sc_boundary_voxel {
    int x, y, z;
    size_t record; /* index of its vertex record */
    uint32_t id;
} sc_boundary_voxel;
typedef void sc_boundary_fn(void *user, const sc_boundary_voxel *voxel);
/* Visit the boundary voxels of bricks [begin, end) in the order of their records. */
void sc_each_boundary(const sc_preparation *p, size_t begin, size_t end, sc_boundary_fn *visit,
                      void *user);

/* The stages, in their order. Each fills what it names and may read what the ones before it filled.
 * After an error the preparation can only be freed. */
sc_status sc_find_boundary(const sc_ctx *ctx, sc_preparation *p); /* near; voxels, boxes of stats */
sc_status sc_index_boundary(const sc_ctx *ctx, sc_preparation *p); /* near_start and the counts */
sc_status sc_find_fields(const sc_ctx *ctx, sc_preparation *p);    /* records */
sc_status sc_polish_fields(const sc_ctx *ctx, sc_preparation *p);  /* smoother directions in them */
sc_status sc_measure_surface(const sc_ctx *ctx, sc_preparation *p);   /* surface_mm2 of stats */
sc_status sc_measure_thickness(const sc_ctx *ctx, sc_preparation *p); /* thickness_mm, thickness */

#endif
