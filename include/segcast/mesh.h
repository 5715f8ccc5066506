/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The smooth surface as triangles, for other programs: one closed surface for each tissue, with
 * the vertices of both tissues the same wherever two touch. */
#ifndef SEGCAST_MESH_H
#define SEGCAST_MESH_H

#include "segcast/kernel.h"

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
/** Leave out vertices and triangles, as far as the error is no more than @p error_mm that the
 *  quadrics of meshoptimizer measure: the surface moves by a third of it on average, and by a few
 *  times as much at the most. Lines where more than two labels meet stay as they are, so that
 *  tissues that touch have the same vertices, and surfaces are closed.
 *  @return SC_ERR_USAGE in a build without that library, SC_ERR_SYSTEM if it takes more than
 *  ctx->memory_max_bytes, SC_ERR_MEMORY; @p mesh untouched. */
SC_MUST_USE sc_status sc_mesh_simplify(const sc_ctx *ctx, sc_mesh *mesh, double error_mm);
/** Free what a mesh owns. */
void sc_mesh_clear(sc_mesh *mesh);

/** What a mesh is written as: files that end in .stl, .ply, .glb or .3mf. Positions are RAS mm, but
 *  for glTF, which is in metres, with y up (superior) and z towards the viewer (anterior). */
typedef enum sc_mesh_format {
    SC_MESH_STL, /**< binary STL of one tissue, without name and colour */
    SC_MESH_PLY, /**< binary PLY: vertices that tissues share, and for each face a colour and label
                  */
    SC_MESH_GLB, /**< binary glTF 2.0: a node, mesh and material for each tissue, with normals */
    SC_MESH_3MF  /**< 3MF: an object and a material for each tissue */
} sc_mesh_format;
/** Tell the format by the ending of a file. @return false if it is that of no mesh. */
bool sc_mesh_format_of(const char *path, sc_mesh_format *out);
/** What a writer needs to know of a label. */
typedef struct sc_mesh_tissue {
    bool wanted; /**< it is written; never the background */
    char name[SC_NAME_BYTES];
    int64_t label;       /**< its number in the volume */
    uint8_t rgb[3];      /**< sRGB */
    float rgb_linear[3]; /**< the same in linear light, 0 to 1 */
} sc_mesh_tissue;
/** Write the wanted tissues of a mesh, each as a closed surface that is turned outward. The bytes
 *  depend on the arguments alone.
 *  @param tissues [label_count] by dense id; for STL one of them is wanted. @param path for
 * messages.
 *  @param stream new, and one that can be positioned; whether all was written is found when it is
 *  closed (sc_outfile_commit). @return SC_ERR_SYSTEM if it does not fit the format, SC_ERR_MEMORY.
 */
SC_MUST_USE sc_status sc_mesh_write(const sc_ctx *ctx, const sc_mesh *mesh,
                                    const sc_mesh_tissue *tissues, int label_count,
                                    sc_mesh_format format, const char *path, FILE *stream);

#endif
