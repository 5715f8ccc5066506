/* SPDX-License-Identifier: BSD-3-Clause */
/* Meshes as STL and PLY, both binary, and the choice of the format. */
#include "internal.h"

#include <strings.h>

enum { STL_HEADER_BYTES = 80 };

static const struct {
    const char *ending;
    sc_mesh_format format;
} endings[] = {
    {".stl", SC_MESH_STL}, {".ply", SC_MESH_PLY}, {".glb", SC_MESH_GLB}, {".3mf", SC_MESH_3MF}};

bool sc_mesh_format_of(const char *path, sc_mesh_format *out)
{
    const char *dot = strrchr(path, '.');

    for (size_t i = 0; dot && i < SC_COUNT_OF(endings); i++) {
        if (!strcasecmp(dot, endings[i].ending)) {
            *out = endings[i].format;
            return true;
        }
    }
    return false;
}

/* Write the only tissue. The normals of triangles are left to the reader, as the format allows. */
static void write_stl(const sc_mesh_file *f)
{
    const sc_mesh *mesh = f->bodies->mesh;
    char header[STL_HEADER_BYTES + 1] = "";

    for (int id = 1; id < f->label_count; id++) {
        const sc_mesh_tissue *tissue = &f->tissues[id];
        sc_body body;

        if (!tissue->wanted)
            continue;
        /* A file that begins with "solid" would be taken for text. */
        snprintf(header, sizeof header, "segcast, RAS mm: %.40s", tissue->name);
        fwrite(header, 1, STL_HEADER_BYTES, f->stream);
        sc_bodies_get(f->bodies, id, &body);
        sc_put_u32(f->stream, (uint32_t)body.triangle_count);
        for (size_t i = 0; i < body.triangle_count; i++) {
            for (int k = 0; k < 3; k++)
                sc_put_float(f->stream, 0);
            for (int k = 0; k < 9; k++)
                sc_put_float(f->stream,
                             mesh->vertices[body.vertices[body.triangles[i][k / 3]]][k % 3]);
            fwrite("\0", 1, 2, f->stream); /* no attributes */
        }
    }
}

/* Write all tissues, with the vertices that they share; a face says whose it is. */
static void write_ply(const sc_mesh_file *f)
{
    const sc_mesh *mesh = f->bodies->mesh;
    size_t faces = 0;

    for (int id = 1; id < f->label_count; id++)
        faces += f->tissues[id].wanted ? f->bodies->start[id + 1] - f->bodies->start[id] : 0;
    fprintf(f->stream, "ply\nformat binary_little_endian 1.0\ncomment segcast, RAS mm\n");
    for (int id = 1; id < f->label_count; id++) {
        if (f->tissues[id].wanted)
            fprintf(f->stream, "comment label %lld %s\n", (long long)f->tissues[id].label,
                    f->tissues[id].name);
    }
    fprintf(f->stream,
            "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
            "element face %zu\nproperty list uchar int vertex_indices\nproperty uchar red\n"
            "property uchar green\nproperty uchar blue\nproperty int label\nend_header\n",
            mesh->vertex_count, faces);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        for (int k = 0; k < 3; k++)
            sc_put_float(f->stream, mesh->vertices[i][k]);
    }
    for (int id = 1; id < f->label_count; id++) {
        const sc_mesh_tissue *tissue = &f->tissues[id];
        sc_body body;

        if (!tissue->wanted)
            continue;
        sc_bodies_get(f->bodies, id, &body);
        for (size_t i = 0; i < body.triangle_count; i++) {
            fputc(3, f->stream);
            for (int k = 0; k < 3; k++)
                sc_put_u32(f->stream, body.vertices[body.triangles[i][k]]);
            fwrite(tissue->rgb, 1, 3, f->stream);
            sc_put_u32(f->stream, (uint32_t)tissue->label);
        }
    }
}

sc_status sc_mesh_write(const sc_ctx *ctx, const sc_mesh *mesh, const sc_mesh_tissue *tissues,
                        int label_count, sc_mesh_format format, const char *path, FILE *stream)
{
    SC_OWN(sc_bodies_clear) sc_bodies bodies = {.mesh = NULL};
    const sc_mesh_file file = {.path = path,
                               .stream = stream,
                               .bodies = &bodies,
                               .tissues = tissues,
                               .label_count = label_count};

    SC_PASS(sc_bodies_begin(ctx, mesh, label_count, &bodies));
    sc_stage_begin(ctx, "writing the mesh", 0, 0);
    if (format == SC_MESH_GLB)
        return sc_write_glb(ctx, &file);
    if (format == SC_MESH_3MF)
        return sc_write_3mf(ctx, &file);
    if (format == SC_MESH_STL)
        write_stl(&file);
    else
        write_ply(&file);
    return SC_OK;
}
