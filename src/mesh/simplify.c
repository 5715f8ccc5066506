/* SPDX-License-Identifier: BSD-3-Clause */
/* Fewer triangles, by meshoptimizer: each surface between two labels by itself, without its border,
 * along which it meets others. So tissues that touch keep the same vertices, and every tissue stays
 * closed: what becomes of the edges of a surface is what becomes of its triangles, and those of its
 * border stay. */
#include "internal.h"

#include <stdlib.h>
#if SC_HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>

enum {
    UNUSED = -1,
    /* What this takes at most for each vertex and triangle, beside the mesh: the arrays of a
     * workshop, and those that version 0.18 of the library has at one time. */
    VERTEX_BYTES = 20 + 96,
    TRIANGLE_BYTES = 44 + 84
};

/* A triangle, and the labels on both sides of it as one number. */
typedef struct sided {
    uint32_t sides, triangle;
} sided;

static int by_sides(const void *a, const void *b)
{
    const sided *x = a, *y = b;

    return x->sides != y->sides ? (x->sides < y->sides ? -1 : 1)
                                : (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

/* Room for the largest surface between two labels. */
typedef struct workshop {
    int32_t *local;     /* [vertex_count of the mesh] number in the surface, or UNUSED */
    uint32_t *vertices; /* number in the mesh */
    float (*positions)[3];
    uint32_t *corners, *left; /* before and after, three for each triangle */
} workshop;

static void clear_workshop(workshop *w)
{
    sc_free(w->local);
    sc_free(w->vertices);
    sc_free(w->positions);
    sc_free(w->corners);
    sc_free(w->left);
}

/* Simplify the surface of @p count triangles, @p from of the mesh. @return how many corners are
 * left, in w->left. */
static size_t simplify_surface(const sc_mesh *mesh, const sided *from, size_t count, float error_mm,
                               workshop *w)
{
    uint32_t vertices = 0;
    size_t left;
    float scale;

    for (size_t i = 0; i < 3 * count; i++) {
        const uint32_t vertex = mesh->triangles[from[i / 3].triangle][i % 3];

        if (w->local[vertex] == UNUSED) {
            memcpy(w->positions[vertices], mesh->vertices[vertex], sizeof *w->positions);
            w->vertices[vertices] = vertex;
            w->local[vertex] = (int32_t)vertices++;
        }
        w->corners[i] = (uint32_t)w->local[vertex];
    }
    scale = meshopt_simplifyScale(w->positions[0], vertices, sizeof *w->positions);
    left = meshopt_simplify(w->left, w->corners, 3 * count, w->positions[0], vertices,
                            sizeof *w->positions, 0, error_mm / scale, meshopt_SimplifyLockBorder,
                            NULL);
    for (uint32_t i = 0; i < vertices; i++)
        w->local[w->vertices[i]] = UNUSED;
    return left;
}

sc_status sc_mesh_simplify(const sc_ctx *ctx, sc_mesh *mesh, double error_mm)
{
    const size_t all = mesh->triangle_count;
    SC_OWN(sc_free_at) sided *order = NULL;
    SC_OWN(sc_free_at) uint32_t(*triangles)[3] = NULL;
    SC_OWN(clear_workshop) workshop w = {.local = NULL};
    size_t kept = 0;

    SC_PASS(sc_mesh_check_memory(ctx, all,
                                 (double)mesh->vertex_count * VERTEX_BYTES +
                                     (double)all * (TRIANGLE_BYTES + sizeof *order)));
    SC_PASS(SC_ALLOC(ctx, all, &order));
    SC_PASS(SC_ALLOC(ctx, all, &triangles));
    SC_PASS(SC_ALLOC(ctx, mesh->vertex_count, &w.local));
    SC_PASS(SC_ALLOC(ctx, mesh->vertex_count, &w.vertices));
    SC_PASS(SC_ALLOC(ctx, mesh->vertex_count, &w.positions));
    SC_PASS(SC_ALLOC(ctx, 3 * all, &w.corners));
    SC_PASS(SC_ALLOC(ctx, 3 * all, &w.left));
    memset(w.local, 0xff, mesh->vertex_count * sizeof *w.local);
    for (size_t i = 0; i < all; i++)
        order[i] = (sided){(uint32_t)mesh->sides[i][0] << 16 | mesh->sides[i][1], (uint32_t)i};
    qsort(order, all, sizeof *order, by_sides);
    sc_stage_begin(ctx, "simplifying the mesh", 0, all);
    for (size_t begin = 0, end = 0; begin < all; begin = end) {
        const uint32_t sides = order[begin].sides;
        size_t left;

        while (end < all && order[end].sides == sides)
            end++;
        left = simplify_surface(mesh, order + begin, end - begin, (float)error_mm, &w);
        for (size_t i = 0; i < left; i++)
            triangles[kept + i / 3][i % 3] = w.vertices[w.left[i]];
        for (size_t i = kept; i < kept + left / 3; i++) {
            mesh->sides[i][0] = (uint16_t)(sides >> 16);
            mesh->sides[i][1] = (uint16_t)sides;
        }
        kept += left / 3;
        sc_stage_add(ctx, end - begin);
    }
    memcpy(mesh->triangles, triangles, kept * sizeof *triangles);
    mesh->triangle_count = kept;
    return sc_mesh_compact(ctx, mesh);
}

#else

sc_status sc_mesh_simplify(const sc_ctx *ctx, sc_mesh *mesh, double error_mm)
{
    return sc_fail(ctx, SC_ERR_USAGE,
                   "--simplify: this segcast was built without meshoptimizer, which it needs");
}

#endif
