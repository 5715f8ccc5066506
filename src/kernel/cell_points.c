/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the smooth surface passes through one cell, for a mesh: dual contouring (Ju et al. 2002,
 * "Dual contouring of Hermite data") of the votes of the cell. Edges whose ends have different
 * owners belong together if a face of the cell joins them, and what belongs together has one point,
 * on the surface that rays find. Both cells at a face join its edges alike, as they compute the
 * same bits there; so a mesh that links these points has no gap, and at every edge of it two sides
 * of each tissue meet (Nielson 2004, "Dual marching cubes"). */
#include "normal.h"

enum {
    FACE_EDGES = 4,
    STEPS_MAX = 8,  /* towards a point of the surface; each makes the error ten times smaller */
    FIELDS_MAX = 8, /* that are zero there: one of the background, and those of seven tissues */
    LABELS_MAX = 8
};
/* The steps end where all fields are so small, which is 1/2000 of a voxel. */
#define FIELD_TOLERANCE 0.05f
/* Points stay so far within their cell, in voxels, that two are never the same. */
#define CELL_MARGIN 0.004f
/* What is added to the diagonal of the equations of a step, as a share of it, so that they can be
 * solved where fewer than three fields meet, or where two are alike. */
#define DAMPING 1e-3f

/* What belongs together, from which its point is found. */
typedef struct group {
    uint32_t labels[LABELS_MAX]; /* that meet, in rising order */
    int label_count;
    float at[3];    /* the middle of the crossings of its edges, then its point */
    bool pinned[3]; /* it lies on the face of the volume that cuts this axis */
    bool outer;     /* the outer field is zero there */
} group;

/* The lower end of edge @p edge of a cell. */
static int low_corner(int edge)
{
    const int axis = edge / 4;

    return (edge & 1) << (axis + 1) % 3 | (edge >> 1 & 1) << (axis + 2) % 3;
}

/* The upper end. */
static int high_corner(int edge)
{
    return low_corner(edge) | 1 << edge / 4;
}

uint32_t sc_kernel_vertex_owner(const sc_prepared *volume, int x, int y, int z)
{
    sc_vertex vertex;

    if (!sc_is_voxel(volume, x, y, z))
        return 0;
    vertex = sc_vertex_at(volume, x, y, z);
    return vertex.outer_value < 0 ? 0 : vertex.tissue;
}

/* Let edges @p a and @p b be in one group. */
static void join(int8_t group_of[SC_CELL_EDGES], int a, int b)
{
    const int8_t keep = group_of[a], drop = group_of[b];

    for (int i = 0; i < SC_CELL_EDGES; i++) {
        if (group_of[i] == drop)
            group_of[i] = keep;
    }
}

/* Join the crossed edges of one face of the cell. If all four are, its corners in turn have labels
 * such as a b a b, and the owner of its middle tells whether those that are alike are joined there.
 * @param axis the face is across it. @param side 0 or 1. */
static void join_face(const sc_cell *c, const uint32_t owners[SC_CORNERS], int axis, int side,
                      int8_t group_of[SC_CELL_EDGES])
{
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    /* In turn around the face: edge i leads from corner i to corner i + 1. */
    const int corners[FACE_EDGES] = {side << axis, side << axis | 1 << u,
                                     side << axis | 1 << u | 1 << v, side << axis | 1 << v};
    const int edges[FACE_EDGES] = {4 * u + 2 * side, 4 * v + side + 2, 4 * u + 1 + 2 * side,
                                   4 * v + side};
    float middle[3] = {0.5f, 0.5f, 0.5f};
    int crossed[FACE_EDGES], count = 0, begin;
    uint32_t owner;

    for (int i = 0; i < FACE_EDGES; i++) {
        if (group_of[edges[i]] >= 0)
            crossed[count++] = edges[i];
    }
    if (count < FACE_EDGES) {
        for (int i = 1; i < count; i++)
            join(group_of, crossed[0], crossed[i]);
        return;
    }
    middle[axis] = (float)side;
    owner = sc_cell_owner_at(c, middle);
    /* Where corners 0 and 2 are joined, corners 1 and 3 are cut off, each by two edges. */
    if (owners[corners[0]] == owners[corners[2]] && owners[corners[0]] == owner)
        begin = 0;
    else if (owners[corners[1]] == owners[corners[3]] && owners[corners[1]] == owner)
        begin = 1;
    else
        begin = owners[corners[0]] == owners[corners[2]] && owners[corners[1]] == owners[corners[3]]
                    ? 1
                    : -1;
    if (begin < 0) {
        for (int i = 1; i < FACE_EDGES; i++)
            join(group_of, edges[0], edges[i]);
        return;
    }
    join(group_of, edges[begin], edges[begin + 1]);
    join(group_of, edges[begin + 2], edges[(begin + 3) % FACE_EDGES]);
}

/* Number the groups of the crossed edges from 0, in the order of their first edges, in
 * out->of_edge.
 */
static void find_groups(const sc_cell *c, sc_cell_points *out)
{
    int8_t group_of[SC_CELL_EDGES], number[SC_CELL_EDGES];

    for (int i = 0; i < SC_CELL_EDGES; i++) {
        const bool crossed = out->owners[low_corner(i)] != out->owners[high_corner(i)];

        group_of[i] = (int8_t)(crossed ? i : -1);
        number[i] = -1;
    }
    for (int axis = 0; axis < 3; axis++) {
        for (int side = 0; side < 2; side++)
            join_face(c, out->owners, axis, side, group_of);
    }
    for (int i = 0; i < SC_CELL_EDGES; i++) {
        if (group_of[i] >= 0 && number[group_of[i]] < 0)
            number[group_of[i]] = (int8_t)out->count++;
        out->of_edge[i] = group_of[i] < 0 ? (int8_t)-1 : number[group_of[i]];
    }
}

/* Add a label to those of a group, in rising order. */
static void add_label(group *g, uint32_t label)
{
    int at = 0;

    while (at < g->label_count && g->labels[at] < label)
        at++;
    if (at < g->label_count && g->labels[at] == label)
        return;
    for (int i = g->label_count++; i > at; i--)
        g->labels[i] = g->labels[i - 1];
    g->labels[at] = label;
}

/* @return where, 0 to 1, the owner changes along a crossed edge, and note in @p g by what. */
static float cross_edge(const sc_cell *c, const uint32_t owners[SC_CORNERS], int edge, group *g)
{
    const int low = low_corner(edge), high = high_corner(edge), axis = edge / 4;
    const bool cut = (c->border | c->border >> 3) >> axis & 1;
    float at[3] = {0, 0, 0};

    if (owners[low] && owners[high])
        return c->inner[low] / (c->inner[low] + c->inner[high]);
    if ((c->background >> low & 1) != (c->background >> high & 1)) {
        at[axis] = c->outer[low] / (c->outer[low] - c->outer[high]);
        if (!cut || sc_cell_inside(c, axis, at) >= 0) {
            g->outer = true;
            return at[axis];
        }
    }
    g->pinned[axis] = true; /* tissue goes on beyond the volume */
    return 0.5f;
}

/* Begin a group: which labels meet in it, and the middle of its crossings. */
static void begin_group(const sc_cell *c, const sc_cell_points *points, int number, group *g)
{
    int count = 0;

    *g = (group){.label_count = 0};
    for (int i = 0; i < SC_CELL_EDGES; i++) {
        const int low = low_corner(i), high = high_corner(i), axis = i / 4;

        if (points->of_edge[i] != number)
            continue;
        add_label(g, points->owners[low]);
        add_label(g, points->owners[high]);
        for (int k = 0; k < 3; k++)
            g->at[k] += k == axis ? cross_edge(c, points->owners, i, g) : (float)(low >> k & 1);
        count++;
    }
    for (int k = 0; k < 3; k++)
        g->at[k] = g->pinned[k] ? 0.5f : g->at[k] / (float)count;
}

/* Keep a point within the cell, and within the volume. */
static void clamp(const sc_cell *c, float at[3])
{
    for (int k = 0; k < 3; k++) {
        const float low = c->border >> k & 1 ? 0.5f : CELL_MARGIN;
        const float high = c->border >> 3 >> k & 1 ? 0.5f : 1 - CELL_MARGIN;

        at[k] = at[k] < low ? low : at[k] > high ? high : at[k];
    }
}

/* Solve the equations @p m x = @p r of three unknowns, of which @p m is symmetric and positive, by
 * Cramer's rule; to @p x. */
static void solve(const float m[3][3], const float r[3], float x[3])
{
    float cofactors[3][3], determinant;

    for (int i = 0; i < 3; i++) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;

        for (int k = 0; k < 3; k++) {
            const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;

            cofactors[i][k] = m[i1][k1] * m[i2][k2] - m[i1][k2] * m[i2][k1];
        }
    }
    determinant = m[0][0] * cofactors[0][0] + m[0][1] * cofactors[0][1] + m[0][2] * cofactors[0][2];
    for (int k = 0; k < 3; k++)
        x[k] = determinant > 0
                   ? (cofactors[0][k] * r[0] + cofactors[1][k] * r[1] + cofactors[2][k] * r[2]) /
                         determinant
                   : 0;
}

/* Move the point of a group by one step of Gauss and Newton to where all @p fields are zero, the
 * shortest way. @return the largest of their values before. */
static float step(const sc_cell *c, float (*fields)[SC_CORNERS], int field_count, group *g)
{
    float m[3][3] = {{0}}, r[3] = {0}, move[3], largest = 0, trace;

    for (int n = 0; n < field_count; n++) {
        const float value = sc_trilinear(fields[n], g->at);
        float slope[3];

        sc_cell_slope(fields[n], g->at, slope);
        largest = fmaxf(largest, fabsf(value));
        for (int i = 0; i < 3; i++) {
            if (g->pinned[i])
                continue;
            r[i] -= slope[i] * value;
            for (int k = 0; k < 3; k++)
                m[i][k] += g->pinned[k] ? 0 : slope[i] * slope[k];
        }
    }
    trace = m[0][0] + m[1][1] + m[2][2];
    if (largest < FIELD_TOLERANCE || !(trace > 0))
        return largest;
    for (int i = 0; i < 3; i++)
        m[i][i] += DAMPING * trace;
    solve((const float(*)[3])m, r, move);
    for (int i = 0; i < 3; i++)
        g->at[i] += move[i];
    clamp(c, g->at);
    return largest;
}

/* Find the point of a group: where the outer field is zero, and where the votes of all its tissues
 * are the same, or as near to that as the cell lets it. */
static void place(const sc_cell *c, group *g)
{
    float fields[FIELDS_MAX][SC_CORNERS];
    const int first = g->labels[0] ? 0 : 1; /* of the tissues among the labels */
    int count = 0;

    if (g->outer)
        memcpy(fields[count++], c->outer, sizeof c->outer);
    for (int k = first + 1; k < g->label_count; k++)
        sc_cell_difference(c, g->labels[first], g->labels[k], fields[count++]);
    clamp(c, g->at);
    for (int i = 0; i < STEPS_MAX; i++) {
        if (!count || step(c, fields, count, g) < FIELD_TOLERANCE)
            break;
    }
}

/* Find the owners of the corners of a cell: sc_kernel_vertex_owner of each. @return whether there
 * are several. */
static bool find_owners(const sc_prepared *volume, const sc_cell *c, uint32_t owners[SC_CORNERS])
{
    const unsigned beyond = c->border ? ~sc_cell_voxels(volume, c) : 0;
    bool several = false;

    for (int i = 0; i < SC_CORNERS; i++) {
        owners[i] = (c->background | beyond) >> i & 1 ? 0
                    : c->distinct_count > 1           ? c->labels[i]
                                                      : c->distinct[0];
        several = several || owners[i] != owners[0];
    }
    return several;
}

void sc_kernel_cell_points(const sc_prepared *volume, const int q[3], bool placed,
                           sc_cell_points *out)
{
    sc_cell c;

    memcpy(c.q, q, sizeof c.q);
    c.distinct_count = 1; /* of a cell in the background it is not read */
    (void)sc_cell_read(volume, &c);
    out->count = 0;
    memset(out->of_edge, -1, sizeof out->of_edge);
    if (!find_owners(volume, &c, out->owners))
        return;
    find_groups(&c, out);
    for (int n = 0; placed && n < out->count; n++) {
        float *normal = out->normals[n], length;
        group g;

        begin_group(&c, out, n, &g);
        place(&c, &g);
        memcpy(out->at[n], g.at, sizeof g.at);
        normal[0] = normal[1] = normal[2] = 0;
        if (g.label_count != 2 || g.pinned[0] || g.pinned[1] || g.pinned[2])
            continue;
        sc_cell_normal(&c, g.labels[0], g.labels[1], g.at, normal);
        length = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        for (int k = 0; k < 3 && length > SC_GRADIENT_LEAST; k++)
            normal[k] /= length;
    }
}
