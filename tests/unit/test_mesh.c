/* SPDX-License-Identifier: BSD-3-Clause */
/* The mesh of all surfaces: closed around every tissue, where the surface is drawn, and the same
 * for any number of threads. */
#include "check.h"

#include "segcast/mesh.h"
#include "shapes.h"

static const double cube[3] = {1, 1, 1}, mirrored[3] = {-0.7, 1, 1.2};

/* A ball in two halves, one of which goes on beyond the volume. */
static int halves(double x, double y, double z)
{
    x -= 9.3, y -= 10.1, z -= 15.2;
    return x * x + y * y + z * z > 11 * 11 ? 0 : z < 0.4 * x ? 1 : 2;
}

/* One of four labels at each voxel, as a hash of its place. */
static int noise(double x, double y, double z)
{
    const double place[3] = {x, y, z};

    return (int)(sc_hash_bytes(place, sizeof place, 5) % 4);
}

/* A vessel that is three voxels wide, and bends. */
static int vessel(double x, double y, double z)
{
    const double r = hypot(x - 2, y - 2) - 17;

    return r * r + (z - 8) * (z - 8) < 1.6 * 1.6;
}

/* A directed edge of a triangle of one tissue. */
typedef struct edge {
    uint32_t from, to;
} edge;

static int compare_edges(const void *a, const void *b)
{
    const edge *x = a, *y = b;

    return x->from != y->from ? (x->from < y->from ? -1 : 1) : (x->to > y->to) - (x->to < y->to);
}

/* @return how many edges of a tissue have not as many triangles on one side as on the other, and
 * the volume that it encloses in *volume. */
static size_t open_edges(const sc_mesh *m, int tissue, double *volume)
{
    edge *edges = calloc(6 * m->triangle_count + 1, sizeof *edges);
    size_t count = 0, open = 0;

    *volume = 0;
    assert_non_null(edges);
    for (size_t i = 0; i < m->triangle_count; i++) {
        const int side = m->sides[i][0] == tissue ? 1 : m->sides[i][1] == tissue ? -1 : 0;
        sc_vec3 p[3];

        assert_true(m->sides[i][0] < m->sides[i][1]);
        for (int k = 0; side && k < 3; k++) {
            const uint32_t at = m->triangles[i][k], next = m->triangles[i][(k + 1) % 3];
            const float *v = m->vertices[at];

            edges[count++] = side > 0 ? (edge){at, next} : (edge){next, at};
            p[k] = (sc_vec3){(double)v[0], (double)v[1], (double)v[2]};
        }
        if (side)
            *volume += side * sc_vec3_dot(p[0], sc_vec3_cross(p[1], p[2])) / 6;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0, next; i < count; i = next) {
        const edge back = {edges[i].to, edges[i].from};
        const edge *found = bsearch(&back, edges, count, sizeof *edges, compare_edges);
        size_t backs = 0;

        for (next = i; next < count && !compare_edges(&edges[i], &edges[next]); next++)
            ;
        for (; found && found > edges && !compare_edges(found - 1, &back);)
            found--;
        for (; found && found < edges + count && !compare_edges(found, &back); found++)
            backs++;
        open += backs != next - i;
    }
    free(edges);
    return open;
}

/* @return the volume that a tissue has by the rule of the drawing, sampled at 6 x 6 x 6 points of
 * each voxel. */
static double drawn_volume(const sc_prepared *v, uint32_t tissue)
{
    enum { POINTS = 6 };
    size_t count = 0;

    for (int z = 0; z <= v->size[2] * POINTS; z++) {
        for (int y = 0; y <= v->size[1] * POINTS; y++) {
            for (int x = 0; x <= v->size[0] * POINTS; x++) {
                const float point[3] = {((float)x + 3.5f) / POINTS, ((float)y + 3.5f) / POINTS,
                                        ((float)z + 3.5f) / POINTS};

                count += sc_kernel_owner(v, point) == tissue;
            }
        }
    }
    return (double)count / (POINTS * POINTS * POINTS) * fabs(sc_affine_determinant(&v->to_ras_mm));
}

/* Make the mesh of a volume, and check that it is closed and encloses what is drawn, to a share of
 * @p off. @param off 0: the volume is not compared. */
static void check_mesh(int (*inside)(double, double, double), const double spacing[3], int labels,
                       double off)
{
    const int size[3] = {24, 23, 26};
    const bool wanted[4] = {false, true, true, true};
    SC_OWN(sc_volume_clear)
    sc_volume volume = shape_volume(size, spacing, 1, labels, inside);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
    SC_OWN(sc_mesh_clear) sc_mesh mesh = {.vertex_count = 0}, again = {.vertex_count = 0};

    assert_int_equal(sc_mesh_build(&quiet, &p.view, wanted, 1, &mesh), SC_OK);
    assert_int_equal(sc_mesh_build(&quiet, &p.view, wanted, 3, &again), SC_OK);
    assert_int_equal(mesh.triangle_count, again.triangle_count);
    assert_memory_equal(mesh.vertices, again.vertices, mesh.vertex_count * sizeof *mesh.vertices);
    assert_memory_equal(mesh.normals, again.normals, mesh.vertex_count * sizeof *mesh.normals);
    assert_memory_equal(mesh.triangles, again.triangles,
                        mesh.triangle_count * sizeof *mesh.triangles);
    assert_memory_equal(mesh.sides, again.sides, mesh.triangle_count * sizeof *mesh.sides);
    for (int tissue = 1; tissue < labels; tissue++) {
        double enclosed, drawn = drawn_volume(&p.view, (uint32_t)tissue);

        assert_int_equal(open_edges(&mesh, tissue, &enclosed), 0);
        assert_true(enclosed > 0);
        if (off > 0)
            assert_near(enclosed / drawn, 1, off);
    }
}

TEST(two_halves_of_a_ball_at_the_edge_of_a_volume_are_closed)
{
    check_mesh(halves, cube, 3, 0.005);
    check_mesh(halves, mirrored, 3, 0.005);
}

TEST_OF_THREADS(a_vessel_of_three_voxels_has_its_volume_to_two_percent)
{
    check_mesh(vessel, cube, 2, 0.02);
}

TEST(any_labels_give_closed_surfaces)
{
    check_mesh(noise, cube, 4, 0);
}

/* Meshes of one tissue have no vertices of others; and each failure of an allocation is one message
 * and leaves nothing behind. */
TEST(a_mesh_of_one_tissue_is_made_or_refused_as_a_whole)
{
    const int size[3] = {24, 23, 26};
    const bool wanted[3] = {false, true, false};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 3, halves);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
    sc_ctx ctx = quiet;
    double enclosed;

    for (int budget = 0;; budget++) {
        long left = budget;
        SC_OWN(sc_mesh_clear) sc_mesh mesh = {.vertex_count = 0};
        sc_status status;

        assert_true(budget < 1000);
        ctx.alloc_budget = &left;
        status = sc_mesh_build(&ctx, &p.view, wanted, 1, &mesh);
        if (status != SC_OK) {
            assert_int_equal(status, SC_ERR_MEMORY);
            continue;
        }
        assert_int_equal(open_edges(&mesh, 1, &enclosed), 0);
        for (size_t i = 0; i < mesh.triangle_count; i++)
            assert_true(mesh.sides[i][0] == 1 || mesh.sides[i][1] == 1);
        break;
    }
}

TEST(a_mesh_beyond_the_memory_is_told_before)
{
    const int size[3] = {24, 23, 26};
    const bool wanted[3] = {false, true, true};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 3, halves);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
    SC_OWN(sc_mesh_clear) sc_mesh mesh = {.vertex_count = 0};
    sc_ctx ctx = listening;

    ctx.memory_max_bytes = 100000;
    assert_int_equal(sc_mesh_build(&ctx, &p.view, wanted, 1, &mesh), SC_ERR_SYSTEM);
    assert_non_null(strstr(said.text, "more than the limit of 97.7 KiB"));
    assert_null(mesh.vertices);
}

/* @return the number at @p at, lowest byte first. */
static uint32_t u32_at(const uint8_t *at)
{
    return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* Write a mesh of one tissue in a format. @return the bytes, to be freed. */
static uint8_t *written(const sc_mesh *mesh, sc_mesh_format format, size_t *bytes)
{
    const sc_mesh_tissue tissues[3] = {
        {.wanted = false},
        {.wanted = true, .name = "<A> & \"B\"", .label = 7, .rgb = {1, 2, 3}},
        {.wanted = false}};
    FILE *stream = tmpfile();
    uint8_t *block;

    assert_non_null(stream);
    assert_ok(sc_mesh_write(&quiet, mesh, tissues, 3, format, "it", stream));
    fseek(stream, 0, SEEK_END);
    *bytes = (size_t)ftell(stream);
    rewind(stream);
    block = calloc(1, *bytes + 1);
    assert_non_null(block);
    assert_int_equal(fread(block, 1, *bytes, stream), *bytes);
    fclose(stream);
    return block;
}

/* What the files say of their own lengths; data.meshes reads them by other programs. */
TEST(files_have_the_lengths_that_they_tell)
{
    const int size[3] = {24, 23, 26};
    const bool wanted[3] = {false, true, false};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 3, halves);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
    SC_OWN(sc_mesh_clear) sc_mesh mesh = {.vertex_count = 0};
    uint8_t *file;
    char header[64];
    size_t bytes;

    assert_ok(sc_mesh_build(&quiet, &p.view, wanted, 1, &mesh));
    file = written(&mesh, SC_MESH_STL, &bytes);
    assert_int_equal(u32_at(file + 80), mesh.triangle_count);
    assert_int_equal(bytes, 84 + 50 * mesh.triangle_count);
    free(file);
    file = written(&mesh, SC_MESH_PLY, &bytes);
    snprintf(header, sizeof header, "element face %zu\n", mesh.triangle_count);
    assert_non_null(strstr((char *)file, header));
    assert_non_null(strstr((char *)file, "comment label 7 <A> & \"B\"\n"));
    assert_int_equal(bytes, (size_t)(strstr((char *)file, "end_header\n") + 11 - (char *)file) +
                                12 * mesh.vertex_count + 20 * mesh.triangle_count);
    free(file);
    file = written(&mesh, SC_MESH_GLB, &bytes);
    assert_int_equal(u32_at(file + 8), bytes);
    assert_int_equal(20 + u32_at(file + 12) + 8 + 24 * mesh.vertex_count + 12 * mesh.triangle_count,
                     bytes);
    free(file);
    file = written(&mesh, SC_MESH_3MF, &bytes);
    assert_int_equal(u32_at(file), 0x04034b50);
    assert_int_equal(u32_at(file + bytes - 22), 0x06054b50);
    assert_int_equal(u32_at(file + bytes - 10) + u32_at(file + bytes - 6), bytes - 22);
    assert_int_equal(u32_at(file + u32_at(file + bytes - 6)), 0x02014b50);
    free(file);
}

RUN_TESTS(NULL, NULL)
