/* SPDX-License-Identifier: BSD-3-Clause */
/* The mesh of all surfaces: sc_kernel_cell_points gives the vertices, and each edge of the label
 * grid whose ends have different owners a square between those of the four cells around it. Threads
 * count and then fill what belongs to a brick of cells; where that stands follows from the counts
 * alone. */
#include "internal.h"

enum {
    BRICKS_AT_ONCE = 64, /* that a thread claims */
    VERTICES_AT_ONCE = 65536,
    AROUND = 4,                         /* cells around an edge */
    LOWEST_EDGES = 1 | 1 << 4 | 1 << 8, /* of a cell, along each axis from its lowest corner */
    POINT_BITS = 2                      /* of the number of a cell's point */
};

/* What belongs to a brick: at first how many, then the index of the first. */
typedef struct brick_counts {
    uint32_t cells, vertices, triangles;
} brick_counts;

/* A cell that the surface may pass through. */
typedef struct mesh_cell {
    uint32_t first;   /* index of the vertex of its first point */
    uint32_t of_edge; /* POINT_BITS for each edge: which of its points */
    uint16_t crossed; /* the edges that the surface crosses, as bits */
    uint16_t count;   /* of its points */
} mesh_cell;

/* What the threads share. */
typedef struct builder {
    const sc_prepared *volume;
    const bool *wanted;
    const uint64_t *masks; /* of sc_visible_cells, with a frame */
    brick_counts *bricks;  /* [bricks z][y][x] */
    mesh_cell *cells;
    float *lifts; /* [vertex_count] how far each vertex is moved along its normal, mm */
    sc_mesh *mesh;
    bool mirrored; /* the axes of the voxels are left-handed in patient space */
} builder;

void sc_mesh_clear(sc_mesh *mesh)
{
    sc_free(mesh->vertices);
    sc_free(mesh->normals);
    sc_free(mesh->triangles);
    sc_free(mesh->sides);
    *mesh = (sc_mesh){.vertex_count = 0};
}

/* @return the mask of the brick at @p at, in bricks. */
static uint64_t mask_at(const builder *b, const int at[3])
{
    const int *n = b->volume->bricks;

    return b->masks[sc_framed_index(sc_framed_row(n), sc_framed_layer(n), at[0], at[1], at[2])];
}

/* Write the lowest vertex of the cell of bit @p bit in the brick at @p at to @p q. */
static void cell_of_bit(const int at[3], int bit, int q[3])
{
    q[0] = at[0] * SC_BRICK + sc_bit_x(bit);
    q[1] = at[1] * SC_BRICK + sc_bit_y(bit);
    q[2] = at[2] * SC_BRICK + sc_bit_z(bit);
}

/* @return whether a triangle between two labels is made. */
static bool is_wanted(const builder *b, uint32_t x, uint32_t y)
{
    return x != y && (b->wanted[x] || b->wanted[y]);
}

/* Count what belongs to bricks [begin, end); an sc_range_fn on a builder. */
static void count_bricks(void *user, size_t begin, size_t end, int thread)
{
    const builder *b = user;

    for (size_t i = begin; i < end; i++) {
        brick_counts *counts = &b->bricks[i];
        int at[3];

        sc_brick_at(b->volume->bricks, i, at);
        for (uint64_t left = mask_at(b, at); left; left &= left - 1) {
            sc_cell_points points;
            int q[3];

            cell_of_bit(at, __builtin_ctzll(left), q);
            sc_kernel_cell_points(b->volume, q, false, &points);
            counts->cells++;
            counts->vertices += (uint32_t)points.count;
            for (int axis = 0; axis < 3; axis++)
                counts->triangles +=
                    is_wanted(b, points.owners[0], points.owners[1 << axis]) ? 2 : 0;
        }
    }
}

/* Store a cell and its vertices, of which @p first is the first one. @return how many these are. */
static uint32_t fill_cell(const builder *b, const int q[3], uint32_t first, mesh_cell *cell)
{
    sc_cell_points points;

    sc_kernel_cell_points(b->volume, q, true, &points);
    *cell = (mesh_cell){.first = first, .count = (uint16_t)points.count};
    for (int i = 0; i < SC_CELL_EDGES; i++) {
        if (points.of_edge[i] < 0)
            continue;
        cell->of_edge |= (uint32_t)points.of_edge[i] << POINT_BITS * i;
        cell->crossed |= (uint16_t)(1u << i);
    }
    for (int n = 0; n < points.count; n++) {
        const float *at = points.at[n];
        const sc_vec3 p = sc_affine_point(
            &b->volume->to_ras_mm, (sc_vec3){(double)at[0] + q[0] - 1, (double)at[1] + q[1] - 1,
                                             (double)at[2] + q[2] - 1});
        float *vertex = b->mesh->vertices[first + (uint32_t)n];

        vertex[0] = (float)p.x;
        vertex[1] = (float)p.y;
        vertex[2] = (float)p.z;
        memcpy(b->mesh->normals[first + (uint32_t)n], points.normals[n], sizeof points.normals[n]);
    }
    return (uint32_t)points.count;
}

/* Store the cells of bricks [begin, end) and their vertices; an sc_range_fn on a builder. */
static void fill_cells(void *user, size_t begin, size_t end, int thread)
{
    const builder *b = user;

    for (size_t i = begin; i < end; i++) {
        uint32_t first = b->bricks[i].vertices;
        mesh_cell *cell = b->cells + b->bricks[i].cells;
        int at[3];

        sc_brick_at(b->volume->bricks, i, at);
        for (uint64_t left = mask_at(b, at); left; left &= left - 1) {
            int q[3];

            cell_of_bit(at, __builtin_ctzll(left), q);
            first += fill_cell(b, q, first, cell++);
        }
    }
}

/* @return which point of a cell stands for the surface across one of its edges. */
static uint32_t point_of(const mesh_cell *cell, int edge)
{
    return cell->of_edge >> POINT_BITS * edge & ((1u << POINT_BITS) - 1);
}

/* @return the vertex that stands for the surface across edge @p edge of the cell @p q. */
static uint32_t vertex_of(const builder *b, const int q[3], int edge)
{
    const int at[3] = {sc_brick_of(q[0]), sc_brick_of(q[1]), sc_brick_of(q[2])};
    const size_t brick = sc_brick_index(b->volume->bricks, at[0], at[1], at[2]);
    const unsigned rank = sc_brick_rank(mask_at(b, at), sc_brick_bit(q[0], q[1], q[2]));
    const mesh_cell *cell = &b->cells[b->bricks[brick].cells + rank];

    return cell->first + point_of(cell, edge);
}

/* Find the vertex across a face of the cell @p q that is linked with vertex @p n of the cell.
 * @return false if there is none. @param face axis and, three more, the upper one of both. */
static bool find_linked(const builder *b, const int q[3], const mesh_cell *cell, uint32_t n,
                        int face, uint32_t *out)
{
    const int axis = face % 3, side = face / 3;
    int beyond[3] = {q[0], q[1], q[2]};

    beyond[axis] += side ? 1 : -1;
    for (int i = 0; i < SC_CELL_EDGES; i++) {
        const int along = i / 4, bit = (axis - along + 2) % 3; /* of the place along axis, in i */

        if (along == axis || (i >> bit & 1) != side || !(cell->crossed >> i & 1) ||
            point_of(cell, i) != n)
            continue;
        *out = vertex_of(b, beyond, i ^ 1 << bit);
        return true;
    }
    return false;
}

/* Find how far a vertex is to be moved along its normal, so that the triangles around it are as
 * much outside of the surface as inside: with all vertices on it, they would be on the hollow side,
 * and a vessel would lose volume. Of the distance of a vertex from the middle of those that it is
 * linked with that is a third: on a ball of radius r, cut into squares of side 1, the distance is 1
 * / 2r, and triangles with corners on it lie 1 / 6r beneath it on average. */
static float find_lift(const builder *b, const int q[3], const mesh_cell *cell, uint32_t n)
{
    const float *at = b->mesh->vertices[cell->first + n],
                *normal = b->mesh->normals[cell->first + n];
    float sum = 0;
    int count = 0;

    for (int face = 0; face < 6; face++) {
        uint32_t linked;

        if (!find_linked(b, q, cell, n, face, &linked))
            continue;
        for (int k = 0; k < 3; k++)
            sum += (at[k] - b->mesh->vertices[linked][k]) * normal[k];
        count++;
    }
    return count ? sum / (float)(3 * count) : 0;
}

/* Find how far the vertices of bricks [begin, end) are to be moved; an sc_range_fn on a builder. */
static void find_lifts(void *user, size_t begin, size_t end, int thread)
{
    const builder *b = user;

    for (size_t i = begin; i < end; i++) {
        const mesh_cell *cell = b->cells + b->bricks[i].cells;
        int at[3];

        sc_brick_at(b->volume->bricks, i, at);
        for (uint64_t left = mask_at(b, at); left; left &= left - 1, cell++) {
            int q[3];

            cell_of_bit(at, __builtin_ctzll(left), q);
            for (uint32_t n = 0; n < cell->count; n++)
                b->lifts[cell->first + n] = find_lift(b, q, cell, n);
        }
    }
}

/* Move vertices [begin, end) along their normals; an sc_range_fn on a builder. */
static void lift(void *user, size_t begin, size_t end, int thread)
{
    const builder *b = user;

    for (size_t i = begin; i < end; i++) {
        for (int k = 0; k < 3; k++)
            b->mesh->vertices[i][k] += b->lifts[i] * b->mesh->normals[i][k];
    }
}

/* @return the square of the distance of two vertices. */
static double square_between(const sc_mesh *mesh, uint32_t a, uint32_t b)
{
    double sum = 0;

    for (int k = 0; k < 3; k++) {
        const double d = (double)mesh->vertices[a][k] - (double)mesh->vertices[b][k];

        sum += d * d;
    }
    return sum;
}

/* Store the two triangles across the edge that leads from vertex @p q, whose owner is @p low, along
 * @p axis, to one whose owner is @p high, as number @p at of the mesh and the next. The square is
 * cut along its shorter diagonal. */
static void fill_square(const builder *b, const int q[3], int axis, uint32_t low, uint32_t high,
                        uint32_t at)
{
    /* The cells in turn, counter-clockwise as seen from the upper end: how far back they are along
     * the next axis, and along the one after that. */
    static const int back[AROUND][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const bool reversed = (low > high) != b->mirrored;
    sc_mesh *mesh = b->mesh;
    uint32_t v[AROUND];
    int begin;

    for (int i = 0; i < AROUND; i++) {
        const int *steps = back[reversed ? AROUND - 1 - i : i];
        int cell[3] = {q[0], q[1], q[2]};

        cell[(axis + 1) % 3] -= steps[0];
        cell[(axis + 2) % 3] -= steps[1];
        v[i] = vertex_of(b, cell, 4 * axis + steps[0] + 2 * steps[1]);
    }
    begin = square_between(mesh, v[1], v[3]) < square_between(mesh, v[0], v[2]);
    for (int n = 0; n < 2; n++) {
        uint32_t *triangle = mesh->triangles[at + (uint32_t)n];

        for (int k = 0; k < 3; k++)
            triangle[k] = v[(begin + 2 * n + k) % AROUND];
        mesh->sides[at + (uint32_t)n][0] = (uint16_t)(low < high ? low : high);
        mesh->sides[at + (uint32_t)n][1] = (uint16_t)(low < high ? high : low);
    }
}

/* Store the triangles of bricks [begin, end); an sc_range_fn on a builder. */
static void fill_triangles(void *user, size_t begin, size_t end, int thread)
{
    const builder *b = user;

    for (size_t i = begin; i < end; i++) {
        const mesh_cell *cell = b->cells + b->bricks[i].cells;
        uint32_t next = b->bricks[i].triangles;
        int at[3];

        sc_brick_at(b->volume->bricks, i, at);
        for (uint64_t left = mask_at(b, at); left; left &= left - 1, cell++) {
            uint32_t low;
            int q[3];

            if (!(cell->crossed & LOWEST_EDGES))
                continue;
            cell_of_bit(at, __builtin_ctzll(left), q);
            low = sc_kernel_vertex_owner(b->volume, q[0], q[1], q[2]);
            for (int axis = 0; axis < 3; axis++) {
                const uint32_t high = sc_kernel_vertex_owner(
                    b->volume, q[0] + (axis == 0), q[1] + (axis == 1), q[2] + (axis == 2));

                if (!is_wanted(b, low, high))
                    continue;
                fill_square(b, q, axis, low, high, next);
                next += 2;
            }
        }
    }
}

/* Turn the counts of the bricks into where what belongs to them begins. @return SC_ERR_SYSTEM if 32
 * bits cannot count it all. @param all how many there are in all. */
static sc_status add_up(const sc_ctx *ctx, const builder *b, brick_counts *all)
{
    const size_t count = sc_brick_count(b->volume->bricks);
    uint64_t sums[3] = {0};

    for (size_t i = 0; i < count; i++) {
        const brick_counts here = b->bricks[i];

        b->bricks[i] = (brick_counts){(uint32_t)sums[0], (uint32_t)sums[1], (uint32_t)sums[2]};
        sums[0] += here.cells;
        sums[1] += here.vertices;
        sums[2] += here.triangles;
    }
    for (int i = 0; i < 3; i++) {
        if (sums[i] > UINT32_MAX)
            return sc_fail(ctx, SC_ERR_SYSTEM,
                           "the mesh has more than %u vertices or triangles, which is the most; "
                           "crop or resample the volume",
                           UINT32_MAX);
    }
    *all = (brick_counts){(uint32_t)sums[0], (uint32_t)sums[1], (uint32_t)sums[2]};
    return SC_OK;
}

sc_status sc_mesh_check_memory(const sc_ctx *ctx, size_t triangles, double bytes)
{
    return sc_memory_check(ctx, bytes,
                           "choose fewer tissues (--tissue), crop or resample the volume, or ",
                           "the mesh of %zu triangles takes about", triangles);
}

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

/* Fill the mesh from b->masks. */
static sc_status build(const sc_ctx *ctx, builder *b, int threads)
{
    const size_t bricks = sc_brick_count(b->volume->bricks);
    const double vertex = sizeof *b->mesh->vertices + sizeof *b->mesh->normals + WORK_VERTEX_BYTES;
    const double triangle =
        sizeof *b->mesh->triangles + sizeof *b->mesh->sides + WORK_TRIANGLE_BYTES;
    SC_OWN(sc_free_at) brick_counts *counts = NULL;
    SC_OWN(sc_free_at) mesh_cell *cells = NULL;
    SC_OWN(sc_free_at) float *lifts = NULL;
    brick_counts all = {.cells = 0};

    SC_PASS(SC_ZALLOC(ctx, bricks, &counts));
    b->bricks = counts;
    sc_stage_begin(ctx, "making the mesh", 0, 4 * bricks);
    sc_stage_for(ctx, bricks, threads, bricks, BRICKS_AT_ONCE, count_bricks, b);
    SC_PASS(add_up(ctx, b, &all));
    SC_PASS(sc_mesh_check_memory(ctx, all.triangles,
                                 all.vertices * vertex + all.triangles * triangle +
                                     (double)all.cells * sizeof *cells));
    SC_PASS(SC_ALLOC(ctx, all.cells, &cells));
    SC_PASS(SC_ALLOC(ctx, all.vertices, &b->mesh->vertices));
    SC_PASS(SC_ALLOC(ctx, all.vertices, &b->mesh->normals));
    SC_PASS(SC_ALLOC(ctx, all.triangles, &b->mesh->triangles));
    SC_PASS(SC_ALLOC(ctx, all.triangles, &b->mesh->sides));
    SC_PASS(SC_ALLOC(ctx, all.vertices, &lifts));
    b->cells = cells;
    b->lifts = lifts;
    b->mesh->vertex_count = all.vertices;
    b->mesh->triangle_count = all.triangles;
    sc_stage_for(ctx, bricks, threads, bricks, BRICKS_AT_ONCE, fill_cells, b);
    sc_stage_for(ctx, bricks, threads, bricks, BRICKS_AT_ONCE, find_lifts, b);
    sc_parallel_for(threads, all.vertices, VERTICES_AT_ONCE, lift, b);
    sc_stage_for(ctx, bricks, threads, bricks, BRICKS_AT_ONCE, fill_triangles, b);
    return sc_mesh_compact(ctx, b->mesh); /* only of some tissues */
}

sc_status sc_mesh_build(const sc_ctx *ctx, const sc_prepared *volume, const bool *wanted,
                        int threads, sc_mesh *out)
{
    SC_OWN(sc_mesh_clear) sc_mesh mesh = {.vertex_count = 0};
    SC_OWN(sc_free_at) uint8_t *show = NULL;
    builder b = {.volume = volume,
                 .wanted = wanted,
                 .mesh = &mesh,
                 .mirrored = sc_affine_determinant(&volume->to_ras_mm) < 0};
    SC_OWN(sc_team_close_at) sc_team *team = NULL;
    uint64_t *masks = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)volume->label_count, &show));
    for (int id = 1; id < volume->label_count; id++)
        show[id] = SC_SHOW_BOUNDARY;
    SC_PASS(sc_team_open(ctx, NULL, threads, NULL, &team));
    SC_PASS(sc_visible_cells(ctx, team, volume, show, &masks));
    b.masks = masks;
    SC_PASS(build(ctx, &b, threads));
    SC_HAND_OVER(mesh, out);
    return SC_OK;
}
