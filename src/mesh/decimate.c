/* SPDX-License-Identifier: BSD-3-Clause */
/* Fewer triangles, by meshoptimizer: it moves vertices onto neighbours, all surfaces together, so
 * that what two tissues share stays shared. To the surface of any tissue that is the same move of
 * its vertices, which leaves a closed surface closed. */
#include "internal.h"

#include <string.h>
#if SC_HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

enum {
    DIGIT_BITS = 8, /* by which triangles are sorted */
    DIGITS = 4,     /* of both sides together */
    ROW = 1024,     /* markers side by side */
    MARKERS_MAX = ROW * ROW
};
/* How far the markers lie outside of the box of the mesh, as a share of its longest edge. */
#define MARGIN 0.01f
#define NO_ENTRY UINT32_MAX

sc_status sc_mesh_compact(const sc_ctx *ctx, sc_mesh *mesh)
{
    SC_OWN(sc_free_at) uint32_t *number = NULL;
    uint32_t next = 0;

    SC_PASS(SC_ZALLOC(ctx, mesh->vertex_count, &number));
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++)
        number[mesh->triangles[i / 3][i % 3]] = 1;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        if (!number[i])
            continue;
        memmove(mesh->vertices[next], mesh->vertices[i], sizeof *mesh->vertices);
        memmove(mesh->normals[next], mesh->normals[i], sizeof *mesh->normals);
        number[i] = next++;
    }
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++)
        mesh->triangles[i / 3][i % 3] = number[mesh->triangles[i / 3][i % 3]];
    mesh->vertex_count = next;
    return SC_OK;
}

#if SC_HAVE_MESHOPTIMIZER
/* @return the labels on both sides of a triangle as one number. */
static uint32_t sides_of(const sc_mesh *m, uint32_t triangle)
{
    return (uint32_t)m->sides[triangle][0] << 16 | m->sides[triangle][1];
}

/* Sort the numbers of the triangles by their sides; those of the same stay in their order. @param
 * order, other [triangle_count]. */
static void sort_by_sides(const sc_mesh *m, uint32_t *order, uint32_t *other)
{
    for (size_t i = 0; i < m->triangle_count; i++)
        order[i] = (uint32_t)i;
    for (int digit = 0; digit < DIGITS; digit++) {
        size_t start[(1 << DIGIT_BITS) + 1] = {0};
        const int shift = digit * DIGIT_BITS, mask = (1 << DIGIT_BITS) - 1;

        for (size_t i = 0; i < m->triangle_count; i++)
            start[(sides_of(m, order[i]) >> shift & (uint32_t)mask) + 1]++;
        for (int i = 0; i < mask; i++)
            start[i + 1] += start[i];
        for (size_t i = 0; i < m->triangle_count; i++)
            other[start[sides_of(m, order[i]) >> shift & (uint32_t)mask]++] = order[i];
        memcpy(order, other, m->triangle_count * sizeof *order);
    }
}

/* What meshoptimizer gets. Its result names no triangles, but has them in the order in which they
 * were: so a marker, a triangle far outside whose vertices no other has, stands before those
 * between each two labels, and still does so in the result. */
typedef struct marked {
    float (*vertices)[3]; /* those of the mesh, then three for each marker */
    uint32_t *indices;    /* three for each triangle */
    uint32_t *sides;      /* [markers] of the triangles behind each marker */
    size_t markers, triangle_count;
} marked;

static void clear_marked(marked *m)
{
    sc_free(m->vertices);
    sc_free(m->indices);
    sc_free(m->sides);
}

/* Place the markers in rows below and behind the box of the mesh. */
static void place_markers(const sc_mesh *mesh, marked *out)
{
    float low[3] = {HUGE_VALF, HUGE_VALF, HUGE_VALF},
          high[3] = {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};
    float size = 0;

    for (size_t i = 0; i < mesh->vertex_count; i++) {
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], mesh->vertices[i][k]);
            high[k] = fmaxf(high[k], mesh->vertices[i][k]);
        }
    }
    for (int k = 0; k < 3; k++)
        size = fmaxf(size, high[k] - low[k]);
    for (size_t i = 0; i < 3 * out->markers; i++) {
        const size_t in_row = i / 3 % ROW, row_number = i / 3 / ROW;
        const float column = (float)in_row / ROW, row = (float)row_number / ROW;
        float *at = out->vertices[mesh->vertex_count + i];

        at[0] = low[0] + column * size;
        at[1] = low[1] - MARGIN * size * (i % 3 == 2 ? 3 + row : 1 + row);
        at[2] = low[2] - MARGIN * size * (i % 3 == 1 ? 2 : 1);
    }
}

/* Put a marker before the triangles between each two labels. @return SC_ERR_MEMORY; SC_ERR_SYSTEM
 * if more tissues touch each other than there is room for markers. Caller owns *out. */
static sc_status mark(const sc_ctx *ctx, const sc_mesh *mesh, marked *out)
{
    SC_OWN(sc_free_at) uint32_t *order = NULL, *other = NULL;
    SC_OWN(clear_marked) marked m = {.markers = 0};
    uint32_t *next;

    SC_PASS(SC_ALLOC(ctx, mesh->triangle_count, &order));
    SC_PASS(SC_ALLOC(ctx, mesh->triangle_count, &other));
    sort_by_sides(mesh, order, other);
    for (size_t i = 0; i < mesh->triangle_count; i++)
        m.markers += i == 0 || sides_of(mesh, order[i]) != sides_of(mesh, order[i - 1]);
    if (m.markers > MARKERS_MAX)
        return sc_fail(ctx, SC_ERR_SYSTEM,
                       "%zu pairs of tissues touch, and a mesh of at most %d can be decimated; "
                       "choose fewer tissues (--tissue), or --error-mm 0",
                       m.markers, MARKERS_MAX);
    m.triangle_count = mesh->triangle_count + m.markers;
    SC_PASS(SC_ALLOC(ctx, mesh->vertex_count + 3 * m.markers, &m.vertices));
    SC_PASS(SC_ALLOC(ctx, 3 * m.triangle_count, &m.indices));
    SC_PASS(SC_ALLOC(ctx, m.markers, &m.sides));
    memcpy(m.vertices, mesh->vertices, mesh->vertex_count * sizeof *m.vertices);
    place_markers(mesh, &m);
    next = m.indices;
    m.markers = 0;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        if (i == 0 || sides_of(mesh, order[i]) != sides_of(mesh, order[i - 1])) {
            for (uint32_t k = 0; k < 3; k++)
                *next++ = (uint32_t)(mesh->vertex_count + 3 * m.markers) + k;
            m.sides[m.markers++] = sides_of(mesh, order[i]);
        }
        memcpy(next, mesh->triangles[order[i]], sizeof *mesh->triangles);
        next += 3;
    }
    SC_HAND_OVER(m, out);
    return SC_OK;
}

/* @return the number of the vertex of a triangle that is lowest. */
static int lowest_corner(const uint32_t t[3])
{
    return t[0] < t[1] ? (t[0] < t[2] ? 0 : 2) : t[1] < t[2] ? 1 : 2;
}

/* @return whether two triangles between the same labels are one and the same, seen from both sides.
 */
static bool are_opposite(const sc_mesh *m, size_t a, size_t b)
{
    const uint32_t *x = m->triangles[a], *y = m->triangles[b];
    const int i = lowest_corner(x), k = lowest_corner(y);

    return !memcmp(m->sides[a], m->sides[b], sizeof *m->sides) && x[i] == y[k] &&
           x[(i + 1) % 3] == y[(k + 2) % 3] && x[(i + 2) % 3] == y[(k + 1) % 3];
}

/* Leave out the pairs of triangles that have become one and the same, seen from both sides: what
 * was between them is gone, and they would be a flap without thickness. @param table room, NO_ENTRY
 * everywhere, for the numbers of triangles by a hash of their vertices. */
static void drop_flaps(sc_mesh *m, uint32_t *table, size_t table_mask)
{
    size_t next = 0;

    for (size_t i = 0; i < m->triangle_count; i++) {
        const uint32_t *t = m->triangles[i];
        const uint64_t sum = (uint64_t)t[0] + t[1] + t[2];
        size_t at = (size_t)(sum * 0x9e3779b97f4a7c15u >> 20) & table_mask;

        while (table[at] != NO_ENTRY && !are_opposite(m, table[at], i))
            at = (at + 1) & table_mask;
        if (table[at] == NO_ENTRY)
            table[at] = (uint32_t)i;
        else /* what is left in the table has no vertices, and is opposite to nothing */
            m->triangles[table[at]][0] = m->triangles[table[at]][1] = m->triangles[i][0] =
                m->triangles[i][1];
    }
    for (size_t i = 0; i < m->triangle_count; i++) {
        if (m->triangles[i][0] == m->triangles[i][1])
            continue;
        memmove(m->triangles[next], m->triangles[i], sizeof *m->triangles);
        memmove(m->sides[next++], m->sides[i], sizeof *m->sides);
    }
    m->triangle_count = next;
}

/* Let the mesh have the triangles of the result. */
static sc_status take(const sc_ctx *ctx, const marked *m, const uint32_t *indices, size_t count,
                      sc_mesh *mesh)
{
    size_t marker = 0, next = 0, table_mask = 1023;
    SC_OWN(sc_free_at) uint32_t *table = NULL;

    for (size_t i = 0; i < count; i++) {
        const uint32_t *triangle = indices + 3 * i;

        if (triangle[0] >= mesh->vertex_count) {
            marker++;
            continue;
        }
        if (!marker || marker > m->markers)
            break;
        memcpy(mesh->triangles[next], triangle, sizeof *mesh->triangles);
        mesh->sides[next][0] = (uint16_t)(m->sides[marker - 1] >> 16);
        mesh->sides[next++][1] = (uint16_t)m->sides[marker - 1];
    }
    if (marker != m->markers)
        return sc_fail(ctx, SC_ERR_INTERNAL,
                       "decimating has lost the order of the triangles; --error-mm 0 does without");
    mesh->triangle_count = next;
    while (table_mask < 2 * next)
        table_mask = 2 * table_mask + 1;
    SC_PASS(SC_ALLOC(ctx, table_mask + 1, &table));
    memset(table, 0xff, (table_mask + 1) * sizeof *table);
    drop_flaps(mesh, table, table_mask);
    return sc_mesh_compact(ctx, mesh);
}

sc_status sc_mesh_decimate(const sc_ctx *ctx, sc_mesh *mesh, double error_mm)
{
    SC_OWN(clear_marked) marked m = {.markers = 0};
    SC_OWN(sc_free_at) uint32_t *out = NULL;
    size_t vertices, count;
    float scale;

    if (!(error_mm > 0) || !mesh->triangle_count)
        return SC_OK;
    SC_PASS(mark(ctx, mesh, &m));
    SC_PASS(SC_ALLOC(ctx, 3 * m.triangle_count, &out));
    vertices = mesh->vertex_count + 3 * m.markers;
    sc_stage_begin(ctx, "decimating the mesh", 0, 0);
    scale = meshopt_simplifyScale(m.vertices[0], vertices, sizeof *m.vertices);
    /* Locked borders keep the markers, which alone have any. */
    count = meshopt_simplify(out, m.indices, 3 * m.triangle_count, m.vertices[0], vertices,
                             sizeof *m.vertices, 0, (float)error_mm / scale,
                             meshopt_SimplifyLockBorder, NULL);
    return take(ctx, &m, out, count / 3, mesh);
}

bool sc_mesh_can_decimate(void)
{
    return true;
}
#else
sc_status sc_mesh_decimate(const sc_ctx *ctx, sc_mesh *mesh, double error_mm)
{
    (void)mesh;
    return error_mm > 0 ? sc_fail(ctx, SC_ERR_INTERNAL, "this build cannot decimate") : SC_OK;
}

bool sc_mesh_can_decimate(void)
{
    return false;
}
#endif
