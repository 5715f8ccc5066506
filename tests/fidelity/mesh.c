/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads triangle meshes of other programs, PLY (ASCII, binary little-endian) and binary STL, and
 * measures them. */
#include "fidelity.h"

#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 200000, MESH_MAX_BYTES = 1 << 30, PROPERTIES_MAX = 32 };

void mesh_free(mesh *m)
{
    free(m->vertices);
    free(m->normals);
    free(m->triangles);
}

/* Append a triangle of three vertices, given by index. @return SC_ERR_DATA, with a message, if
 * one is beyond m->vertex_count; SC_ERR_MEMORY. */
static sc_status add_triangle(const sc_ctx *ctx, mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    if (a >= m->vertex_count || b >= m->vertex_count || c >= m->vertex_count)
        return sc_fail(ctx, SC_ERR_DATA, "triangle %zu names a vertex beyond the %zu there are",
                       m->triangle_count, m->vertex_count);
    if (m->triangle_count == m->capacity) {
        const size_t grown = m->capacity ? 2 * m->capacity : 1024;
        void *block = realloc(m->triangles, grown * sizeof *m->triangles);

        if (!block)
            return sc_fail(ctx, SC_ERR_MEMORY, "no memory for %zu triangles", grown);
        m->triangles = block;
        m->capacity = grown;
    }
    memcpy(m->triangles[m->triangle_count++], (uint32_t[3]){a, b, c}, 3 * sizeof(uint32_t));
    return SC_OK;
}

/* A PLY file being read: the position in its data, which is borrowed and ends with a 0, and how
 * its numbers are written. */
typedef struct ply {
    const char *at, *end;
    bool ascii;
} ply;

/* Bytes of a number of a PLY type; 0 for a type that does not exist. */
static size_t bytes_of(const char *type)
{
    static const struct {
        const char *name;
        size_t bytes;
    } types[] = {{"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},
                 {"short", 2}, {"ushort", 2},  {"int16", 2},  {"uint16", 2},
                 {"int", 4},   {"uint", 4},    {"int32", 4},  {"uint32", 4},
                 {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};

    for (size_t i = 0; i < SC_COUNT_OF(types); i++) {
        if (!strcmp(types[i].name, type))
            return types[i].bytes;
    }
    return 0;
}

/* Read the next number, of a PLY type (which only binary files depend on), to @p out and go on
 * behind it. Integers are taken as unsigned. @return false, with the position unchanged, at the
 * end, for a type unknown, or for what is no number. */
static bool next_number(ply *p, const char *type, double *out)
{
    const size_t bytes = bytes_of(type);
    char *end;
    union {
        uint8_t u8;
        uint16_t u16;
        uint32_t u32;
        float f;
        double d;
    } value;

    if (p->ascii) {
        *out = strtod(p->at, &end);
        if (end == p->at)
            return false;
        p->at = end;
        return true;
    }
    if (!bytes || (size_t)(p->end - p->at) < bytes)
        return false;
    memcpy(&value, p->at, bytes);
    p->at += bytes;
    if (bytes == 8)
        *out = value.d;
    else if (type[0] == 'f')
        *out = (double)value.f;
    else
        *out = bytes == 1 ? value.u8 : bytes == 2 ? value.u16 : value.u32;
    return true;
}

/* What the header of a PLY file says: how many vertices and faces there are, the properties of a
 * vertex in order, and the types of a face's list. */
typedef struct ply_header {
    size_t vertices, faces;
    char names[PROPERTIES_MAX][32], types[PROPERTIES_MAX][16];
    int properties;
    char count_type[16], index_type[16];
} ply_header;

/* Read the header up to the line end_header into @p h, which has been cleared, leaving @p p
 * behind it with p->ascii set. Lines it does not know are ignored. @return SC_ERR_DATA, with a
 * message. */
static sc_status read_ply_header(const sc_ctx *ctx, ply *p, ply_header *h)
{
    bool in_vertex = false;
    int line_number = 0;

    while (p->at < p->end) {
        const char *stop = memchr(p->at, '\n', (size_t)(p->end - p->at));
        char line[256];

        if (!stop || stop - p->at >= (long)sizeof line)
            break;
        snprintf(line, sizeof line, "%.*s", (int)(stop - p->at), p->at);
        line[strcspn(line, "\r")] = '\0';
        p->at = stop + 1;
        line_number++;
        if (!strcmp(line, "end_header"))
            return SC_OK;
        if (!strncmp(line, "format ", 7)) {
            p->ascii = !strncmp(line + 7, "ascii", 5);
            if (!p->ascii && strncmp(line + 7, "binary_little_endian", 20))
                return sc_fail(ctx, SC_ERR_DATA,
                               "line %d: \"%s\", expected ascii or "
                               "binary_little_endian",
                               line_number, line);
        } else if (sscanf(line, "element vertex %zu", &h->vertices) == 1) {
            in_vertex = true;
        } else if (sscanf(line, "element face %zu", &h->faces) == 1) {
            in_vertex = false;
        } else if (in_vertex && h->properties < PROPERTIES_MAX &&
                   sscanf(line, "property %15s %31s", h->types[h->properties],
                          h->names[h->properties]) == 2) {
            h->properties++;
        } else if (!in_vertex) {
            (void)sscanf(line, "property list %15s %15s", h->count_type, h->index_type);
        }
    }
    return sc_fail(ctx, SC_ERR_DATA, "line %d: the header does not end", line_number);
}

/* Read vertices and faces of a PLY file into @p m, which is {0}; faces of more than three
 * corners become fans of triangles. The caller frees the mesh, also on failure. @return
 * SC_ERR_DATA, SC_ERR_MEMORY, with a message. */
static sc_status read_ply(const sc_ctx *ctx, ply p, mesh *m)
{
    ply_header h = {0};
    sc_status status = read_ply_header(ctx, &p, &h);

    if (status != SC_OK)
        return status;
    m->vertices = calloc(h.vertices + 1, sizeof *m->vertices);
    m->normals = calloc(h.vertices + 1, sizeof *m->normals);
    m->vertex_count = h.vertices;
    if (!m->vertices || !m->normals)
        return sc_fail(ctx, SC_ERR_MEMORY, "no memory for %zu vertices", h.vertices);
    for (size_t i = 0; i < h.vertices; i++) {
        for (int k = 0; k < h.properties; k++) {
            double value;

            if (!next_number(&p, h.types[k], &value))
                return sc_fail(ctx, SC_ERR_DATA, "the file ends at vertex %zu of %zu", i,
                               h.vertices);
            if (!strcmp(h.names[k], "x"))
                m->vertices[i].x = value;
            if (!strcmp(h.names[k], "y"))
                m->vertices[i].y = value;
            if (!strcmp(h.names[k], "z"))
                m->vertices[i].z = value;
        }
    }
    for (size_t i = 0; i < h.faces && status == SC_OK; i++) {
        double count, corners[3] = {0};

        if (!next_number(&p, h.count_type, &count))
            return sc_fail(ctx, SC_ERR_DATA, "the file ends at face %zu of %zu", i, h.faces);
        for (int k = 0; k < (int)count && status == SC_OK; k++) {
            if (!next_number(&p, h.index_type, &corners[k < 2 ? k : 2]))
                return sc_fail(ctx, SC_ERR_DATA, "the file ends at face %zu of %zu", i, h.faces);
            if (k >= 2) {
                status = add_triangle(ctx, m, (uint32_t)corners[0], (uint32_t)corners[1],
                                      (uint32_t)corners[2]);
                corners[1] = corners[2];
            }
        }
    }
    return status;
}

/* The vertices that compare_corners compares: qsort passes no argument of ours. */
static const sc_vec3 *sort_vertices;

/* Order of two indices of vertices by the bytes of these; 0 for equal positions. */
static int compare_corners(const void *a, const void *b)
{
    const sc_vec3 *x = &sort_vertices[*(const uint32_t *)a];
    const sc_vec3 *y = &sort_vertices[*(const uint32_t *)b];

    return memcmp(x, y, sizeof *x);
}

/* Read a binary STL file into @p m, which is {0}. STL repeats the corners of every triangle:
 * equal ones become one vertex. The caller frees the mesh, also on failure. @return SC_ERR_DATA,
 * SC_ERR_MEMORY, with a message. */
static sc_status read_stl(const sc_ctx *ctx, const char *data, size_t bytes, mesh *m)
{
    uint32_t triangles = 0, *order, *vertex_of;
    sc_status status = SC_OK;

    if (bytes >= 84)
        memcpy(&triangles, data + 80, sizeof triangles);
    if (!triangles || bytes != 84 + (size_t)triangles * 50)
        return sc_fail(ctx, SC_ERR_DATA, "%zu bytes, expected a PLY or a binary STL file", bytes);
    m->vertex_count = (size_t)triangles * 3;
    m->vertices = calloc(m->vertex_count, sizeof *m->vertices);
    m->normals = calloc(m->vertex_count, sizeof *m->normals);
    order = calloc(m->vertex_count, sizeof *order);
    vertex_of = calloc(m->vertex_count, sizeof *vertex_of);
    if (!m->vertices || !m->normals || !order || !vertex_of) {
        status = sc_fail(ctx, SC_ERR_MEMORY, "no memory for %u triangles", triangles);
        goto out;
    }
    for (size_t i = 0; i < m->vertex_count; i++) {
        float p[3];

        memcpy(p, data + 84 + i / 3 * 50 + 12 + i % 3 * 12, sizeof p);
        m->vertices[i] = (sc_vec3){(double)p[0], (double)p[1], (double)p[2]};
        order[i] = (uint32_t)i;
    }
    sort_vertices = m->vertices;
    qsort(order, m->vertex_count, sizeof *order, compare_corners);
    for (size_t i = 0; i < m->vertex_count; i++)
        vertex_of[order[i]] =
            i && !compare_corners(&order[i - 1], &order[i]) ? vertex_of[order[i - 1]] : order[i];
    for (size_t i = 0; i < m->vertex_count && status == SC_OK; i += 3)
        status = add_triangle(ctx, m, vertex_of[i], vertex_of[i + 1], vertex_of[i + 2]);
out:
    free(order);
    free(vertex_of);
    return status;
}

/* Set the normals of the vertices (the mean of the triangles around, weighted by area; not of
 * unit length) and @p areas [triangle_count], the area of all triangles up to each one. @return
 * the enclosed volume, by the divergence theorem; negative if the triangles are turned inside. */
static double finish_mesh(mesh *m, double *areas)
{
    double volume = 0, sum = 0;

    for (size_t i = 0; i < m->triangle_count; i++) {
        const uint32_t *t = m->triangles[i];
        const sc_vec3 a = m->vertices[t[0]], b = m->vertices[t[1]], c = m->vertices[t[2]];
        const sc_vec3 cross = sc_vec3_cross(sc_vec3_sub(b, a), sc_vec3_sub(c, a));

        volume += sc_vec3_dot(a, sc_vec3_cross(b, c)) / 6;
        sum += sc_vec3_length(cross) / 2;
        areas[i] = sum;
        for (int k = 0; k < 3; k++)
            m->normals[t[k]] = sc_vec3_add(m->normals[t[k]], cross);
    }
    return volume;
}

/* Add the errors of SAMPLES points, spread evenly over the area of the mesh, to @p e. @param
 * areas of finish_mesh. @param sign 1, or -1 if the normals of the mesh point inward. */
static void sample_mesh(const shape *s, const mesh *m, const double *areas, double sign, errors *e)
{
    uint64_t seed = 23;

    for (int n = 0; n < SAMPLES; n++) {
        const double at = random_of(&seed) * areas[m->triangle_count - 1];
        double u = random_of(&seed), v = random_of(&seed), distance;
        size_t low = 0, high = m->triangle_count - 1;
        sc_vec3 p = {0}, normal = {0}, truth;

        while (low < high) {
            const size_t middle = (low + high) / 2;

            if (areas[middle] < at)
                low = middle + 1;
            else
                high = middle;
        }
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        for (int k = 0; k < 3; k++) {
            const uint32_t vertex = m->triangles[low][k];
            const double share = k == 0 ? 1 - u - v : k == 1 ? u : v;

            p = sc_vec3_along(p, share, m->vertices[vertex]);
            normal = sc_vec3_along(normal, share, sc_vec3_unit(m->normals[vertex]));
        }
        distance = shape_distance(s, p, &truth);
        errors_add(e, distance,
                   acos(fmin(1, fmax(-1, sign * sc_vec3_dot(sc_vec3_unit(normal), truth)))) * 180 /
                       M_PI);
    }
}

sc_status mesh_read(const sc_ctx *ctx, const char *path, mesh *m)
{
    SC_OWN(sc_free_at) char *data = NULL;
    size_t bytes = 0;

    SC_PASS(sc_file_read(ctx, path, MESH_MAX_BYTES, &data, &bytes));
    if (bytes >= 4 && !memcmp(data, "ply", 3))
        SC_PASS(read_ply(ctx, (ply){.at = data, .end = data + bytes}, m));
    else
        SC_PASS(read_stl(ctx, data, bytes, m));
    return SC_OK;
}

sc_status measure_mesh(const sc_ctx *ctx, const shape *s, const char *path, fidelity *out)
{
    SC_OWN(mesh_free) mesh m = {0};
    SC_OWN(sc_free_at) double *areas = NULL;
    errors e = {0};
    double volume;

    *out = (fidelity){.volume_kept = 0, .owner_errors = NAN, .silhouette = NAN, .gaps = -1};
    SC_PASS(mesh_read(ctx, path, &m));
    if (!m.triangle_count) { /* smoothing has removed the whole mesh */
        out->position_rms = out->position_95 = out->position_max = out->normal_rms = NAN;
        return SC_OK;
    }
    SC_PASS(SC_ALLOC(ctx, m.triangle_count, &areas));
    volume = finish_mesh(&m, areas);
    sample_mesh(s, &m, areas, volume < 0 ? -1 : 1, &e);
    errors_finish(&e, out);
    out->volume_kept = fabs(volume) / s->volume;
    return SC_OK;
}
