/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The smooth surface as triangles, for other programs: one closed surface for each tissue, with
 * the vertices of both tissues the same wherever two touch. */
#ifndef SEGCAST_MESH_H
#define SEGCAST_MESH_H

#include "segcast/kernel.h"

/** What a mesh takes for each vertex and triangle while it is decimated and written, beside itself.
 */
enum { SC_MESH_WORK_VERTEX_BYTES = 8, SC_MESH_WORK_TRIANGLE_BYTES = 24 };
/** All surfaces of a volume together: a triangle lies between two labels and belongs to the
 * surfaces of both. */
typedef struct sc_mesh {
    float (*vertices)[3]; /**< [vertex_count] RAS mm; owned, as all arrays */
    float (*normals)[3]; /**< [vertex_count] unit length, from the lower of the two labels that meet
                              there to the other; 0 where more meet, or at a face of the volume */
    size_t vertex_count;
    uint32_t (*triangles)[3]; /**< [triangle_count] indices of vertices, counter-clockwise as seen
                                   from the side of the second label */
    uint16_t (*sides)[2];     /**< [triangle_count] dense ids of the labels on both sides, the lower
                                   one first */
    size_t triangle_count;
} sc_mesh;

/** Make the mesh of all triangles that have a tissue of @p wanted on one side, at the resolution of
 *  the volume: two triangles where the surface crosses the line between two neighbouring voxels.
 *  @param wanted [label_count] by dense id. @param threads at least 1; the result does not depend
 *  on it.
 *  @return SC_ERR_SYSTEM if it takes more than ctx->memory_max_bytes, before any of it is made, or
 *  has more vertices than 32 bits can count; SC_ERR_MEMORY. Caller owns *out: sc_mesh_clear. */
SC_MUST_USE sc_status sc_mesh_build(const sc_ctx *ctx, const sc_prepared *volume,
                                    const bool *wanted, int threads, sc_mesh *out);
/** Free what a mesh owns. */
void sc_mesh_clear(sc_mesh *mesh);

#endif
