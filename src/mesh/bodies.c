/* SPDX-License-Identifier: BSD-3-Clause */
/* The surface of one tissue after the other, with vertices of its own numbers in the order in which
 * its triangles name them. */
#include "internal.h"

#define NO_VERTEX UINT32_MAX

void sc_bodies_clear(sc_bodies *bodies)
{
    sc_free(bodies->start);
    sc_free(bodies->order);
    sc_free(bodies->local);
    sc_free(bodies->vertices);
    sc_free(bodies->triangles);
}

/* Sort the numbers of triangles by the tissues on their sides. */
static void sort_triangles(sc_bodies *b, int label_count)
{
    const sc_mesh *m = b->mesh;

    for (size_t i = 0; i < m->triangle_count; i++) {
        for (int side = 0; side < 2; side++)
            b->start[m->sides[i][side] + 1]++;
    }
    for (int id = 0; id < label_count; id++)
        b->start[id + 1] += b->start[id];
    for (size_t i = m->triangle_count; i-- > 0;) {
        for (int side = 0; side < 2; side++)
            b->order[--b->start[m->sides[i][side] + 1]] = (uint32_t)i;
    }
    /* Each has been moved down to where its own triangles begin, which is one entry too far up. */
    memmove(b->start, b->start + 1, (size_t)label_count * sizeof *b->start);
    b->start[label_count] = 2 * m->triangle_count;
}

sc_status sc_bodies_begin(const sc_ctx *ctx, const sc_mesh *mesh, int label_count, sc_bodies *out)
{
    SC_OWN(sc_bodies_clear) sc_bodies b = {.mesh = mesh};
    size_t most = 0;

    SC_PASS(SC_ZALLOC(ctx, (size_t)label_count + 1, &b.start));
    SC_PASS(SC_ALLOC(ctx, 2 * mesh->triangle_count, &b.order));
    SC_PASS(SC_ALLOC(ctx, mesh->vertex_count, &b.local));
    memset(b.local, 0xff, mesh->vertex_count * sizeof *b.local);
    sort_triangles(&b, label_count);
    for (int id = 1; id < label_count; id++)
        most = b.start[id + 1] - b.start[id] > most ? b.start[id + 1] - b.start[id] : most;
    SC_PASS(SC_ALLOC(ctx, 3 * most, &b.vertices));
    SC_PASS(SC_ALLOC(ctx, most, &b.triangles));
    SC_HAND_OVER(b, out);
    return SC_OK;
}

void sc_bodies_get(sc_bodies *b, int id, sc_body *out)
{
    const size_t begin = b->start[id], count = b->start[id + 1] - begin;
    uint32_t vertices = 0;

    for (size_t i = 0; i < count; i++) {
        const uint32_t triangle = b->order[begin + i];
        /* Triangles face the second label, outward for the first one. */
        const bool turned = b->mesh->sides[triangle][1] == id;

        for (int k = 0; k < 3; k++) {
            const uint32_t vertex = b->mesh->triangles[triangle][turned ? 2 - k : k];

            if (b->local[vertex] == NO_VERTEX) {
                b->local[vertex] = vertices;
                b->vertices[vertices++] = vertex;
            }
            b->triangles[i][k] = b->local[vertex];
        }
    }
    for (uint32_t i = 0; i < vertices; i++)
        b->local[b->vertices[i]] = NO_VERTEX;
    *out = (sc_body){.vertices = b->vertices,
                     .vertex_count = vertices,
                     .triangles = (const uint32_t(*)[3])b->triangles,
                     .triangle_count = count};
}

/* Write the normal of triangle @p i of a body, as long as twice its area, to @p n. */
static void triangle_normal(const sc_mesh *mesh, const sc_body *body, size_t i, float n[3])
{
    const uint32_t *t = body->triangles[i];
    const float *a = mesh->vertices[body->vertices[t[0]]],
                *b = mesh->vertices[body->vertices[t[1]]],
                *c = mesh->vertices[body->vertices[t[2]]];

    for (int k = 0; k < 3; k++) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;

        n[k] = (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]);
    }
}

void sc_body_normals(const sc_bodies *bodies, const sc_body *body, float (*out)[3])
{
    const sc_mesh *mesh = bodies->mesh;

    memset(out, 0, body->vertex_count * sizeof *out);
    for (size_t i = 0; i < body->triangle_count; i++) {
        float n[3];

        triangle_normal(mesh, body, i, n);
        for (int k = 0; k < 9; k++)
            out[body->triangles[i][k / 3]][k % 3] += n[k % 3];
    }
    for (size_t i = 0; i < body->vertex_count; i++) {
        const float *model = mesh->normals[body->vertices[i]];
        float *n = out[i], length;

        if (model[0] != 0 || model[1] != 0 || model[2] != 0) {
            /* It leads from the lower of both labels, which this may be, or not: the triangles
             * tell. */
            const float along = model[0] * n[0] + model[1] * n[1] + model[2] * n[2];

            for (int k = 0; k < 3; k++)
                n[k] = along < 0 ? -model[k] : model[k];
        }
        length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (!(length > 0)) {
            n[2] = 1;
            length = 1;
        }
        for (int k = 0; k < 3; k++)
            n[k] /= length;
    }
}
