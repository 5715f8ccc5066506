/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to mesh: the surface of one tissue after the other, and the writers of the formats. */
#ifndef SC_MESH_INTERNAL_H
#define SC_MESH_INTERNAL_H

#include "segcast/mesh.h"

/* What a mesh takes for each vertex and triangle while it is written, beside itself: sc_bodies, and
 * normals. */
enum { WORK_VERTEX_BYTES = 16, WORK_TRIANGLE_BYTES = 32 };

/* Refuse a mesh that takes more memory than there may be taken. @return SC_ERR_SYSTEM. */
sc_status sc_mesh_check_memory(const sc_ctx *ctx, size_t triangles, double bytes);
/* Leave out the vertices that no triangle has. @return SC_ERR_MEMORY. */
sc_status sc_mesh_compact(const sc_ctx *ctx, sc_mesh *mesh);

/* The surface of one tissue, turned outward. */
typedef struct sc_body {
    const uint32_t *vertices; /* [vertex_count] indices of vertices of the mesh */
    size_t vertex_count;
    const uint32_t (*triangles)[3]; /* [triangle_count] indices of the vertices above */
    size_t triangle_count;
} sc_body;

/* Takes a mesh apart. Owns its arrays: sc_bodies_clear. */
typedef struct sc_bodies {
    const sc_mesh *mesh; /* borrowed */
    size_t *start;       /* [label_count + 1] of each tissue's triangles in order */
    uint32_t *order;     /* numbers of triangles, tissue by tissue */
    uint32_t *local;     /* [mesh->vertex_count] index in the body at hand, or NO_VERTEX */
    uint32_t *vertices;  /* room for the largest body */
    uint32_t (*triangles)[3];
} sc_bodies;

/* Begin to take a mesh apart. @return SC_ERR_MEMORY. Caller owns *out. */
sc_status sc_bodies_begin(const sc_ctx *ctx, const sc_mesh *mesh, int label_count, sc_bodies *out);
void sc_bodies_clear(sc_bodies *bodies);
/* Fill @p out with the surface of the tissue @p id, which is valid until the next call. */
void sc_bodies_get(sc_bodies *bodies, int id, sc_body *out);
/* Write the normals of a body, of unit length and outward, to @p out [body->vertex_count]: those of
 * the mesh, or, where it has none, the mean of the triangles around. */
void sc_body_normals(const sc_bodies *bodies, const sc_body *body, float (*out)[3]);

/* Write a number, lowest byte first. */
void sc_put_u32(FILE *stream, uint32_t value);
void sc_put_float(FILE *stream, float value);

/* What the writers get. Errors of the stream are found when it is closed. */
typedef struct sc_mesh_file {
    const char *path; /* for messages */
    FILE *stream;     /* which can be positioned */
    sc_bodies *bodies;
    const sc_mesh_tissue *tissues; /* [label_count] */
    int label_count;
} sc_mesh_file;
sc_status sc_write_glb(const sc_ctx *ctx, const sc_mesh_file *file);
sc_status sc_write_3mf(const sc_ctx *ctx, const sc_mesh_file *file);

#endif
