/* SPDX-License-Identifier: BSD-3-Clause */
/* Meshes as glTF 2.0 in its binary form: a header, a chunk of JSON and a chunk of numbers. A tissue
 * is a node with a mesh and a material. glTF is in metres, with y up and the front towards +z: the
 * patient stands upright and looks at the viewer. */
#include "internal.h"

#include <jansson.h>

enum {
    CHUNK_JSON = 0x4e4f534a,
    CHUNK_BINARY = 0x004e4942,
    GLB_MAGIC = 0x46546c67,
    GLB_VERSION = 2,
    HEADER_BYTES = 12,
    CHUNK_HEADER_BYTES = 8,
    TYPE_FLOAT = 5126, /* of OpenGL, as the others */
    TYPE_UINT32 = 5125,
    ARRAY_BUFFER = 34962,
    ELEMENT_ARRAY_BUFFER = 34963,
    VECTOR_BYTES = 12
};

/* The description while it is made: references to its arrays, which the root owns, and the size of
 * the chunk of numbers so far. */
typedef struct description {
    json_t *root, *accessors, *views, *meshes, *nodes, *materials, *scene;
    uint64_t bytes;
} description;

/* A position or direction in RAS, turned into the axes of glTF: left, up, front. */
static void turn(const float ras[3], float out[3])
{
    out[0] = -ras[0];
    out[1] = ras[2];
    out[2] = ras[1];
}

/* Write a position in metres to @p out. */
static void position_of(const sc_mesh *mesh, uint32_t vertex, float out[3])
{
    turn(mesh->vertices[vertex], out);
    for (int k = 0; k < 3; k++)
        out[k] *= 0.001f;
}

/* Add an accessor with a view of its own behind the numbers so far. @return its number. */
static json_int_t add_accessor(description *d, const char *type, int component, size_t count,
                               size_t element_bytes)
{
    const int target = component == TYPE_FLOAT ? ARRAY_BUFFER : ELEMENT_ARRAY_BUFFER;
    const uint64_t bytes = (uint64_t)count * element_bytes;

    json_array_append_new(d->views, json_pack("{s:i, s:I, s:I, s:i}", "buffer", 0, "byteOffset",
                                              (json_int_t)d->bytes, "byteLength", (json_int_t)bytes,
                                              "target", target));
    json_array_append_new(d->accessors,
                          json_pack("{s:I, s:i, s:I, s:s}", "bufferView",
                                    (json_int_t)json_array_size(d->views) - 1, "componentType",
                                    component, "count", (json_int_t)count, "type", type));
    d->bytes += bytes;
    return (json_int_t)json_array_size(d->accessors) - 1;
}

/* @return an array of three numbers. */
static json_t *triple(const float v[3])
{
    return json_pack("[f, f, f]", (double)v[0], (double)v[1], (double)v[2]);
}

/* Add a tissue to the description. */
static void describe(description *d, const sc_mesh *mesh, const sc_body *body,
                     const sc_mesh_tissue *tissue)
{
    float low[3] = {HUGE_VALF, HUGE_VALF, HUGE_VALF};
    float high[3] = {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};
    const json_int_t number = (json_int_t)json_array_size(d->meshes);
    json_int_t positions, normals, triangles;
    json_t *accessor;

    for (size_t i = 0; i < body->vertex_count; i++) {
        float at[3];

        position_of(mesh, body->vertices[i], at);
        for (int k = 0; k < 3; k++) {
            low[k] = at[k] < low[k] ? at[k] : low[k];
            high[k] = at[k] > high[k] ? at[k] : high[k];
        }
    }
    positions = add_accessor(d, "VEC3", TYPE_FLOAT, body->vertex_count, VECTOR_BYTES);
    accessor = json_array_get(d->accessors, (size_t)positions);
    json_object_set_new(accessor, "min", triple(low));
    json_object_set_new(accessor, "max", triple(high));
    normals = add_accessor(d, "VEC3", TYPE_FLOAT, body->vertex_count, VECTOR_BYTES);
    triangles = add_accessor(d, "SCALAR", TYPE_UINT32, 3 * body->triangle_count, sizeof(uint32_t));
    json_array_append_new(d->materials,
                          json_pack("{s:s, s:{s:[f, f, f, i], s:i, s:f}}", "name", tissue->name,
                                    "pbrMetallicRoughness", "baseColorFactor",
                                    (double)tissue->rgb_linear[0], (double)tissue->rgb_linear[1],
                                    (double)tissue->rgb_linear[2], 1, "metallicFactor", 0,
                                    "roughnessFactor", 0.6));
    json_array_append_new(d->meshes,
                          json_pack("{s:s, s:[{s:{s:I, s:I}, s:I, s:I}]}", "name", tissue->name,
                                    "primitives", "attributes", "POSITION", positions, "NORMAL",
                                    normals, "indices", triangles, "material", number));
    json_array_append_new(d->nodes,
                          json_pack("{s:s, s:I, s:{s:I}}", "name", tissue->name, "mesh", number,
                                    "extras", "label", (json_int_t)tissue->label));
    json_array_append_new(d->scene, json_integer(number));
}

/* Make the description. @return its text, to be freed; NULL: there is no memory. @param bytes of
 * the chunk of numbers. */
static char *describe_all(const sc_mesh_file *f, uint64_t *bytes)
{
    json_t *root =
        json_pack("{s:{s:s, s:s}, s:i, s:[{s:[]}], s:[], s:[], s:[], s:[], s:[], s:[]}", "asset",
                  "version", "2.0", "generator", "segcast", "scene", 0, "scenes", "nodes", "nodes",
                  "meshes", "materials", "accessors", "bufferViews", "buffers");
    description d = {
        .root = root,
        .accessors = json_object_get(root, "accessors"),
        .views = json_object_get(root, "bufferViews"),
        .meshes = json_object_get(root, "meshes"),
        .nodes = json_object_get(root, "nodes"),
        .materials = json_object_get(root, "materials"),
        .scene = json_object_get(json_array_get(json_object_get(root, "scenes"), 0), "nodes")};
    char *text;

    for (int id = 1; id < f->label_count; id++) {
        sc_body body;

        if (!f->tissues[id].wanted)
            continue;
        sc_bodies_get(f->bodies, id, &body);
        describe(&d, f->bodies->mesh, &body, &f->tissues[id]);
    }
    json_array_append_new(json_object_get(root, "buffers"),
                          json_pack("{s:I}", "byteLength", (json_int_t)d.bytes));
    text = json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(9));
    json_decref(root);
    *bytes = d.bytes;
    return text;
}

/* Write the numbers of one tissue. @param normals room for one of each vertex. */
static void write_numbers(const sc_mesh_file *f, const sc_body *body, float (*normals)[3])
{
    float v[3];

    for (size_t i = 0; i < 3 * body->vertex_count; i++) {
        if (i % 3 == 0)
            position_of(f->bodies->mesh, body->vertices[i / 3], v);
        sc_put_float(f->stream, v[i % 3]);
    }
    sc_body_normals(f->bodies, body, normals);
    for (size_t i = 0; i < 3 * body->vertex_count; i++) {
        if (i % 3 == 0)
            turn(normals[i / 3], v);
        sc_put_float(f->stream, v[i % 3]);
    }
    for (size_t i = 0; i < 3 * body->triangle_count; i++)
        sc_put_u32(f->stream, body->triangles[i / 3][i % 3]);
}

sc_status sc_write_glb(const sc_ctx *ctx, const sc_mesh_file *f)
{
    uint64_t bytes = 0, whole;
    SC_OWN(sc_free_at) char *text = describe_all(f, &bytes);
    const size_t length = text ? strlen(text) : 0, padded = (length + 3) / 4 * 4;
    SC_OWN(sc_free_at) float(*normals)[3] = NULL;

    if (!text)
        return sc_fail(ctx, SC_ERR_MEMORY, "no memory for the description of the mesh");
    whole = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + padded + bytes;
    if (whole > UINT32_MAX)
        return sc_fail(ctx, SC_ERR_SYSTEM,
                       "%s: takes %s, and a GLB file has 4 GiB at most; choose fewer tissues "
                       "(--tissue), or write .ply",
                       f->path, sc_size_text((double)whole, (char[24]){0}));
    SC_PASS(SC_ALLOC(ctx, f->bodies->mesh->vertex_count, &normals));
    sc_put_u32(f->stream, GLB_MAGIC);
    sc_put_u32(f->stream, GLB_VERSION);
    sc_put_u32(f->stream, (uint32_t)whole);
    sc_put_u32(f->stream, (uint32_t)padded);
    sc_put_u32(f->stream, CHUNK_JSON);
    fprintf(f->stream, "%s%.*s", text, (int)(padded - length), "   ");
    sc_put_u32(f->stream, (uint32_t)bytes);
    sc_put_u32(f->stream, CHUNK_BINARY);
    for (int id = 1; id < f->label_count; id++) {
        sc_body body;

        if (!f->tissues[id].wanted)
            continue;
        sc_bodies_get(f->bodies, id, &body);
        write_numbers(f, &body, normals);
    }
    return SC_OK;
}
