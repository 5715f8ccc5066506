/* SPDX-License-Identifier: BSD-3-Clause */
#include "check.h"

#include "shapes.h"

#include <math.h>

static const double cube[3] = {1, 1, 1};

static int random_id(double x, double y, double z)
{
    uint64_t seed = 1 + (uint64_t)(x / 3) * 7919 + (uint64_t)(y / 2) * 104729 + (uint64_t)(z / 2);

    random_bits(&seed);
    return (int)(random_bits(&seed) >> 60) % 4;
}

static uint32_t id_at(const sc_prepared *v, int x, int y, int z)
{
    const size_t i = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x;

    if (x < 0 || y < 0 || z < 0 || x >= v->size[0] || y >= v->size[1] || z >= v->size[2])
        return 0;
    return v->label_bytes == 1 ? ((const uint8_t *)v->ids)[i] : ((const uint16_t *)v->ids)[i];
}

/* The bit of a voxel, by a formula of its own: this is the layout that prepared files have. */
static bool bit_at(const sc_prepared *v, int x, int y, int z)
{
    const int qx = x + 1, qy = y + 1, qz = z + 1;
    const int brick = ((qz >> 2) * v->bricks[1] + (qy >> 2)) * v->bricks[0] + (qx >> 2);

    return v->boundary.masks[brick] >> ((qx & 3) + 4 * (qy & 3) + 16 * (qz & 3)) & 1;
}

/* brick.h: packing and unpacking are inverse to each other, and the masks of faces have the right
 * bits. */
TEST(the_layout_of_bricks_and_records_can_be_inverted)
{
    const int bricks[3] = {5, 3, 4};

    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        const int x = sc_bit_x(bit), y = sc_bit_y(bit), z = sc_bit_z(bit);

        assert_int_equal(bit, x + 4 * y + 16 * z);
        assert_int_equal(sc_brick_bit(x - 8, y + 12, z + 400), bit);
        assert_int_equal(SC_BRICK_LOW_X >> bit & 1, x == 0);
        assert_int_equal(SC_BRICK_LOW_Y >> bit & 1, y == 0);
        assert_int_equal(SC_BRICK_LOW_Z >> bit & 1, z == 0);
        assert_int_equal(sc_brick_rank(~0ull, bit), bit);
    }
    assert_int_equal(sc_brick_of(-1), -1);
    assert_int_equal(sc_bricks_along(2), 1);
    assert_int_equal(sc_bricks_along(3), 2);
    for (size_t i = 0; i < sc_brick_count(bricks); i++) {
        int at[3], framed[3];

        sc_brick_at(bricks, i, at);
        sc_framed_size(bricks, framed);
        assert_int_equal(sc_brick_index(bricks, at[0], at[1], at[2]), i);
        assert_int_equal(
            sc_framed_index(sc_framed_row(bricks), sc_framed_layer(bricks), at[0], at[1], at[2]),
            sc_brick_index(framed, at[0] + 1, at[1] + 1, at[2] + 1));
    }
    for (int code = 0; code < SC_TISSUE_CODES; code++)
        assert_int_equal(sc_tissue_code(sc_tissue_step(code, 0), sc_tissue_step(code, 1),
                                        sc_tissue_step(code, 2)),
                         code);
    assert_int_equal(sc_tissue_code(0, 0, 0), SC_TISSUE_OWN);
}

/* The boundary voxels are those of the paper's rule, applied voxel by voxel; for both label widths,
 * and with sizes that are no multiples of a brick. */
TEST(the_boundary_follows_the_rule_of_the_paper)
{
    const int size[3] = {23, 9, 11};

    for (int bytes = 1; bytes <= 2; bytes++) {
        SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, bytes, 4, random_id);
        SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
        uint64_t counts[4] = {0}, voxels[4] = {0}, near = 0;

        for (int i = 0; i < (size[0] + 2) * (size[1] + 2) * (size[2] + 2); i++) {
            const int x = i % (size[0] + 2) - 1, y = i / (size[0] + 2) % (size[1] + 2) - 1;
            const int z = i / (size[0] + 2) / (size[1] + 2) - 1;
            const uint32_t id = id_at(&p.view, x, y, z);
            bool boundary = false;

            for (int n = 0; n < 27; n++)
                boundary = boundary ||
                           id_at(&p.view, x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1) != id;
            assert_int_equal(bit_at(&p.view, x, y, z), boundary);
            counts[id] += boundary && id;
            voxels[id] += id != 0;
            near += boundary;
        }
        assert_int_equal(p.view.boundary.count, near);
        for (int id = 1; id < 4; id++) {
            assert_int_equal(p.view.stats[id].boundary_voxels, counts[id]);
            assert_int_equal(p.view.stats[id].voxels, voxels[id]);
        }
        assert_int_equal(p.view.boundary.voxel_count, counts[1] + counts[2] + counts[3]);
    }
}

static int ellipsoid(double x, double y, double z)
{
    x = (x - 40) / 30;
    y = (y - 36.3) / 26;
    z = (z - 38) / 33;
    return x * x + y * y + z * z < 1;
}

/* A vertex record keeps the direction within one degree, value and tissue exactly, and the length
 * to an eighth. */
TEST(records_keep_value_direction_tissue_and_length)
{
    uint64_t seed = 3;

    for (int i = 0; i < 5000; i++) {
        const sc_vec3 n = sc_vec3_unit((sc_vec3){
            random_real(&seed, -1, 1), random_real(&seed, -1, 1), random_real(&seed, -1, 1)});
        const int value = i % 2 ? 1 + i / 2 % SC_VALUE_MAX : -1 - i / 2 % SC_VALUE_MAX;
        const int code = i % SC_TISSUE_CODES;
        const double length = random_real(&seed, 0.07, 1.4);
        const uint32_t record = sc_record_pack(value, sc_vec3_scale(n, 3), length) |
                                (uint32_t)code << SC_RECORD_TISSUE_SHIFT;
        float back[3];
        sc_vec3 b;

        sc_record_normal(record, back);
        b = (sc_vec3){back[0], back[1], back[2]};
        assert_true(sc_vec3_dot(sc_vec3_unit(b), n) > cos(1.0 * M_PI / 180));
        assert_int_equal(sc_record_value(record), value);
        assert_int_equal(sc_record_tissue(record), code);
        assert_near(sc_record_eighths(record), 8 * fmin(length, 1), 0.501);
        assert_near(sc_vec3_length(b), sc_record_eighths(record), 1e-5);
    }
    assert_int_equal(sc_record_eighths(sc_record_pack(9, (sc_vec3){0, 0, 0}, 0)), 1);
}

/* Is vertex (x, y, z) a corner of a cell that needs records of the outer field, or (@p inner) of
 * the inner one, by the rule of sc_prepared? */
static bool needs_record(const sc_prepared *v, int x, int y, int z, bool inner)
{
    for (int cell = 0; cell < 8; cell++) {
        const int q[3] = {x - (cell & 1), y - (cell >> 1 & 1), z - (cell >> 2)};
        sc_vertex first;
        bool sides = false, tissues = false, any = false;

        if (q[0] < 0 || q[1] < 0 || q[2] < 0 || q[0] > v->size[0] || q[1] > v->size[1] ||
            q[2] > v->size[2])
            continue;
        first = sc_vertex_at(v, q[0], q[1], q[2]);
        for (int i = 0; i < 8; i++) {
            const sc_vertex c =
                sc_vertex_at(v, q[0] + (i & 1), q[1] + (i >> 1 & 1), q[2] + (i >> 2));

            sides = sides || (c.outer_value > 0) != (first.outer_value > 0);
            tissues = tissues || c.tissue != first.tissue;
            any = any || c.outer_value > 0;
        }
        if (inner ? tissues && any : sides)
            return true;
    }
    return false;
}

/* Does a voxel of the 3x3x3 around vertex (x, y, z) have the label @p id? */
static bool is_around(const sc_prepared *v, int x, int y, int z, uint32_t id)
{
    bool is = false;

    for (int n = 0; n < 27; n++)
        is = is || sc_id_near_vertex(v, x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1) == id;
    return is;
}

/* The records are those of the rule, applied vertex by vertex, and, where nothing is smoothed, say
 * what the labels do: borders are then about half a voxel from voxels on either side. */
TEST(the_records_follow_the_rule)
{
    const int size[3] = {23, 9, 11};

    for (int bytes = 1; bytes <= 2; bytes++) {
        SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, bytes, 4, random_id);
        SC_OWN(clear_copy) prepared_copy p = prepare_copy_smooth(&volume, 2, 0);
        const sc_prepared *v = &p.view;
        uint64_t counts[2] = {0, 0};

        for (int i = 0; i < (size[0] + 2) * (size[1] + 2) * (size[2] + 2); i++) {
            const int x = i % (size[0] + 2), y = i / (size[0] + 2) % (size[1] + 2);
            const int z = i / (size[0] + 2) / (size[1] + 2);
            const uint32_t label = sc_id_near_vertex(v, x, y, z);
            const sc_vertex found = sc_vertex_at(v, x, y, z);
            const bool side = found.outer_value > 0;

            assert_int_equal(found.outer != 0,
                             needs_record(v, x, y, z, false) || side != (label != 0));
            assert_int_equal(found.inner != 0,
                             needs_record(v, x, y, z, true) || (label && found.tissue != label));
            assert_true(found.tissue ? is_around(v, x, y, z, found.tissue) : !side);
            if (sc_is_voxel(v, x, y, z)) {
                assert_int_equal(side, label != 0);
                assert_true(!label || found.tissue == label);
                assert_true(!found.outer || abs(found.outer_value) >= 2 * SC_BORDER_STEPS / 5);
            }
            counts[0] += found.outer != 0;
            counts[1] += found.inner != 0;
        }
        assert_int_equal(v->outer.count, counts[0]);
        assert_int_equal(v->inner.count, counts[1]);
    }
}

/* What sc_visible_cells and sc_cells_build should make of a cell. @param out set to the packed
 * cell.
 * @return whether it is visible. */
static bool expected_cell(const sc_prepared *v, const uint8_t *show, const int q[3],
                          sc_packed_cell *out)
{
    sc_vertex c[8];
    int sides = 0, inside = 0;
    uint32_t low = UINT32_MAX, high = 0;
    bool border = false, others = false, shown = false;

    *out = (sc_packed_cell){{0x81818181u, 0x81818181u}, 0};
    for (int i = 0; i < 3; i++)
        border = border || q[i] == 0 || q[i] == v->size[i];
    for (int i = 0; i < 8; i++) {
        const int at[3] = {q[0] + (i & 1), q[1] + (i >> 1 & 1), q[2] + (i >> 2)};

        c[i] = sc_vertex_at(v, at[0], at[1], at[2]);
        sides += c[i].outer_value > 0;
        inside += c[i].outer_value > 0 && sc_is_voxel(v, at[0], at[1], at[2]);
        low = c[i].tissue < low ? c[i].tissue : low;
        high = c[i].tissue > high ? c[i].tissue : high;
        shown = shown || show[c[i].tissue] & SC_SHOW_BOUNDARY;
    }
    for (int i = 0; i < 8; i++)
        others = others || (c[i].tissue != low && c[i].tissue != high);
    if (!border && sides == 8 && low < high && !others)
        out->labels = high << SC_CELL_LABEL_BITS | low;
    else if (!border && sides < 8 && low == high)
        out->labels = high << SC_CELL_LABEL_BITS;
    if (out->labels || (!border && sides < 8)) {
        out->values[0] = out->values[1] = 0;
        for (int i = 0; i < 8; i++) {
            const int vote = c[i].tissue == low ? c[i].inner_value : -c[i].inner_value;

            out->values[i / 4] |= (uint32_t)(uint8_t)(sides == 8 ? vote : -c[i].outer_value)
                                  << (8 * (i % 4));
        }
    }
    return shown && ((sides && sides < 8) || (sides && low < high) || (border && inside));
}

TEST_OF_THREADS(cells_are_marked_and_packed_by_the_rule)
{
    const int size[3] = {23, 9, 11};
    const uint8_t show[2][4] = {{0, 1, 1, 1}, {0, 0, 1, 0}};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 4, random_id);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
    const sc_prepared *v = &p.view;
    sc_team *team;

    assert_ok(sc_team_open(&quiet, NULL, 2, NULL, &team));
    for (int way = 0; way < 2; way++) {
        sc_cells cells;
        uint64_t *masks;
        size_t count = 0;
        int framed[3];

        assert_ok(sc_visible_cells(&quiet, team, v, show[way], &masks));
        assert_ok(sc_cells_build(&quiet, team, v, masks, &cells));
        sc_framed_size(v->bricks, framed);
        for (size_t brick = 0; brick < sc_brick_count(framed); brick++) {
            int low[3];

            sc_brick_low(framed, brick, low);
            assert_int_equal(cells.start[brick], count);
            for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
                const int q[3] = {low[0] + sc_bit_x(bit) - SC_BRICK,
                                  low[1] + sc_bit_y(bit) - SC_BRICK,
                                  low[2] + sc_bit_z(bit) - SC_BRICK};
                sc_packed_cell expected;
                bool visible = true;

                for (int i = 0; i < 3; i++)
                    visible = visible && q[i] >= 0 && q[i] <= size[i];
                visible = visible && expected_cell(v, show[way], q, &expected);
                assert_int_equal(masks[brick] >> bit & 1, visible);
                if (visible)
                    assert_memory_equal(&cells.cells[count++], &expected, sizeof expected);
            }
        }
        assert_int_equal(cells.count, count);
        assert_true(count > 500);
    }
    sc_team_close(team);
}

static int slab_and_rod(double x, double y, double z)
{
    if (z >= 20 && z < 29)
        return 1;
    x -= 30.2;
    y -= 29.7;
    return z >= 34 && x * x + y * y < 121 ? 2 : 0;
}

/* A slab 9 voxels thick, which ends in flat faces at the border of the volume, and a rod of radius
 * 11, in voxels of 1 x 1 x 0.5 mm. */
TEST(a_slab_and_a_rod_have_their_thickness_and_surface)
{
    const int size[3] = {60, 60, 200};
    const double spacing[3] = {1, 1, 0.5};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, spacing, 1, 3, slab_and_rod);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 3);
    const sc_label_stats *stats = p.view.stats;
    const double slab = 2 * 3600 + 4 * 60 * 4.5, rod = 2 * M_PI * 11 * 83 + 2 * M_PI * 121;

    assert_near(stats[1].surface_mm2, slab, 0.01 * slab);
    assert_near(stats[2].surface_mm2, rod, 0.02 * rod);
    assert_near(stats[1].thickness_mm, 2 * 3600 * 4.5 / slab, 0.04);
    assert_near(stats[2].thickness_mm, 2 * M_PI * 121 * 83 / rod, 0.2);
    assert_int_equal(stats[2].low[2], 34);
    assert_int_equal(stats[2].high[2], 199);
}

/* Labels 1 and 2: a ball of radius 12 with a core of radius 6. */
static int ball_with_core(double x, double y, double z)
{
    const double r = sqrt(pow(x - 20.2, 2) + pow(y - 19.7, 2) + pow(z - 20.1, 2));

    return r < 6 ? 2 : r < 12;
}

static int small_ball(double x, double y, double z)
{
    return pow(x - 20.2, 2) + pow(y - 19.7, 2) + pow(z - 20.1, 2) < 9;
}

/* Coordinates of a voxel along the edges of a box that is turned about no axis of the volume. */
static void turn(double x, double y, double z, double out[3])
{
    static const double rows[3][3] = {
        {2. / 3, -1. / 3, 2. / 3}, {2. / 3, 2. / 3, -1. / 3}, {-1. / 3, 2. / 3, 2. / 3}};

    for (int i = 0; i < 3; i++)
        out[i] = rows[i][0] * (x - 30.13) + rows[i][1] * (y - 29.8) + rows[i][2] * (z - 30.05);
}

static int turned_box(double x, double y, double z)
{
    double at[3];

    turn(x, y, z, at);
    return fabs(at[0]) < 20 && fabs(at[1]) < 15 && fabs(at[2]) < 10;
}

/* A sheet as thick as a voxel is, measured along the axis to which it is the most inclined. */
static int turned_sheet(double x, double y, double z)
{
    double at[3];

    turn(x, y, z, at);
    return fabs(at[0]) < 24 && fabs(at[1]) < 24 && fabs(at[2]) < 1. / 3;
}

static int flat_sheet(double x, double y, double z)
{
    return x > 3 && x < 57 && y > 3 && y < 57 && z > 29 && z < 31;
}

/* Of balls, of a box in no direction of the volume, whose edges are drawn round, and of sheets one
 * voxel thick, whose rims are. */
TEST(areas_are_those_of_the_shapes)
{
    static const struct {
        int (*id_of)(double x, double y, double z);
        int id, smooth;
        double mm2, less, more; /* the shares by which it may be smaller and larger */
    } shapes[] = {{small_ball, 1, 1, 4 * M_PI * 9, 0.02, 0.02},
                  {ball_with_core, 1, 1, 4 * M_PI * (144 + 36), 0.02, 0.02},
                  {ball_with_core, 2, 1, 4 * M_PI * 36, 0.02, 0.02},
                  {turned_box, 1, 1, 8 * (300 + 200 + 150), 0.05, 0.01},
                  {turned_sheet, 1, 1, 2 * 2304 + 4 * 48 * 2. / 3, 0.05, 0.02},
                  {flat_sheet, 1, 1, 2 * 2809 + 4 * 53, 0.05, 0.02},
                  {flat_sheet, 1, 0, 2 * 2809 + 4 * 53, 0.05, 0.02}};

    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++) {
        SC_OWN(sc_volume_clear)
        sc_volume volume = shape_volume((const int[3]){61, 61, 61}, cube, 1, 3, shapes[i].id_of);
        SC_OWN(clear_copy) prepared_copy p = prepare_copy_smooth(&volume, 2, shapes[i].smooth);
        const double share = p.view.stats[shapes[i].id].surface_mm2 / shapes[i].mm2;

        assert_true(share > 1 - shapes[i].less && share < 1 + shapes[i].more);
    }
}

TEST(the_surface_of_an_ellipsoid_is_right)
{
    const int size[3] = {81, 73, 77};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 2, ellipsoid);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 1);
    const double a = pow(30 * 26, 1.6), b = pow(30 * 33, 1.6), c = pow(26 * 33, 1.6);

    (void)state; /* Thomsen's formula, good to 1 % */
    assert_near(p.view.stats[1].surface_mm2 / (4 * M_PI * pow((a + b + c) / 3, 1 / 1.6)), 1, 0.02);
}

/* Bands of random labels, at least one among the bricks that a thread takes at a time. */
static int random_bands(double x, double y, double z)
{
    return fmod(z, 40) < 8 ? random_id(x, y, z) : 0;
}

TEST_OF_THREADS(the_result_does_not_depend_on_threads)
{
    const int size[3] = {96, 90, 100};            /* more bricks than the threads take at a time */
    const double spacing_mm[3] = {0.7, 1.1, 1.3}; /* areas that binary fractions do not hold */
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, spacing_mm, 1, 4, random_bands);
    prepared_copy copies[2];

    for (int i = 0; i < 2; i++)
        copies[i] =
            prepare_as(&volume, &(sc_prepare_settings){.smooth = {1, 1, 1}, .threads = 1 + 2 * i});
    assert_int_equal(copies[0].bytes, copies[1].bytes);
    assert_memory_equal(copies[0].block, copies[1].block, copies[0].bytes);
    sc_free(copies[0].block);
    sc_free(copies[1].block);
}

TEST_OF_THREADS(masks_hold_the_visible_voxels_and_hull_points_their_corners)
{
    const int size[3] = {81, 73, 77};
    const uint8_t nothing[2] = {0, 0}, shell[2] = {0, SC_SHOW_BOUNDARY};
    const uint8_t all[2] = {0, SC_SHOW_BOUNDARY | SC_SHOW_INTERIOR};
    const uint8_t *const shows[] = {nothing, shell, all};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 2, ellipsoid);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 1);
    const sc_prepared *v = &p.view;
    const size_t masks =
        (size_t)sc_framed_layer(v->bricks) * (size_t)(v->bricks[2] + 2 * SC_BRICK_FRAME);

    for (int i = 0; i < 3; i++) {
        const uint64_t wanted[] = {0, v->stats[1].boundary_voxels, v->stats[1].voxels};
        uint64_t *visible, count = 0;
        sc_team *team;
        sc_vec3 *points;
        size_t point_count;
        sc_vec3 low = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high = {-1, -1, -1};

        assert_ok(sc_team_open(&quiet, NULL, 2, NULL, &team));
        assert_ok(sc_visible_masks(&quiet, team, v, shows[i], &visible));
        for (size_t m = 0; m < masks; m++)
            count += (uint64_t)__builtin_popcountll(visible[m]);
        assert_int_equal(count, wanted[i]);
        assert_ok(sc_hull_points(&quiet, team, v, shows[i], &points, &point_count));
        for (size_t n = 0; n < point_count; n++) {
            const sc_vec3 at = points[n];

            low = (sc_vec3){fmin(low.x, at.x), fmin(low.y, at.y), fmin(low.z, at.z)};
            high = (sc_vec3){fmax(high.x, at.x), fmax(high.y, at.y), fmax(high.z, at.z)};
        }
        assert_int_equal(point_count > 0, i > 0);
        for (int k = 0; k < 3 && i; k++) { /* the faces of the outermost voxels */
            assert_near((&low.x)[k], v->stats[1].low[k] - 0.5, 0);
            assert_near((&high.x)[k], v->stats[1].high[k] + 0.5, 0);
        }
        sc_team_close(team);
    }
}

static int everything(double x, double y, double z)
{
    return 1;
}

/* Two small boxes in opposite corners, and a single voxel between. */
static int corners_and_dots(double x, double y, double z)
{
    return (x < 2 && y < 3 && z < 1) || (x > 72 && y > 18 && z > 15) ? 1
                                                                     : x == 30 && y == 9 && z == 5;
}

static int slab_on_block(double x, double y, double z)
{
    return z < 20 ? 0 : z < 29 ? 1 : 2;
}

/* Distances of bricks and cells against a search by brute force, and the pyramid level by level,
 * all with formulas of their own. Few cells are set, in two corners, so that distances are long. */
TEST_OF_THREADS(distances_and_the_pyramid_say_what_is_empty)
{
    static const uint8_t show[4] = {0, SC_SHOW_BOUNDARY, 0, 0};
    const int size[3] = {75, 21, 18};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 4, corners_and_dots);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
    const sc_prepared *v = &p.view;
    const int row = sc_framed_row(v->bricks), layer = sc_framed_layer(v->bricks);
    int framed[3], cells[512][3], count = 0;
    uint8_t *bricks, *by_metric[2];
    uint64_t *masks;
    sc_team *team;
    sc_pyramid y;

    sc_framed_size(v->bricks, framed);
    assert_ok(sc_team_open(&quiet, NULL, 2, NULL, &team));
    assert_ok(sc_visible_cells(&quiet, team, v, show, &masks));
    assert_ok(sc_brick_distances(&quiet, team, v->bricks, masks, &bricks));
    assert_ok(sc_cell_distances(&quiet, team, v, masks, SC_METRIC_CITY_BLOCK, &by_metric[0]));
    assert_ok(sc_cell_distances(&quiet, team, v, masks, SC_METRIC_CHESSBOARD, &by_metric[1]));
    assert_ok(sc_pyramid_build(&quiet, team, v, &masks, &y));
    for (size_t i = 0; i < sc_brick_count(framed) * 64; i++) {
        int brick[3];

        sc_brick_at(framed, i / 64, brick);
        if (!(masks[i / 64] >> i % 64 & 1))
            continue;
        assert_true(count < 512);
        cells[count][0] = 4 * brick[0] - 4 + (int)(i % 4);
        cells[count][1] = 4 * brick[1] - 4 + (int)(i / 4 % 4);
        cells[count++][2] = 4 * brick[2] - 4 + (int)(i / 16 % 4);
    }
    assert_true(count > 20);
    for (size_t i = 0; i < sc_brick_count(framed) * 64; i++) {
        int brick[3], q[3], least[3] = {254, 254, 254};

        sc_brick_at(framed, i / 64, brick);
        for (int a = 0; a < 3; a++)
            q[a] = 4 * brick[a] - 4 + (int)(i >> 2 * a & 3);
        for (int k = 0; k < count; k++) {
            int apart[3], largest[2] = {0, 0}; /* in cells, in bricks */

            for (int a = 0; a < 3; a++) {
                const int in_bricks = abs((q[a] >> 2) - (cells[k][a] >> 2));

                apart[a] = abs(q[a] - cells[k][a]);
                largest[0] = apart[a] > largest[0] ? apart[a] : largest[0];
                largest[1] = in_bricks > largest[1] ? in_bricks : largest[1];
            }
            least[0] = (int)fmin(least[0], apart[0] + apart[1] + apart[2]);
            least[1] = (int)fmin(least[1], largest[0]);
            least[2] = (int)fmin(least[2], largest[1]);
        }
        assert_int_equal(by_metric[0][i], least[0]);
        assert_int_equal(by_metric[1][i], least[1]);
        assert_int_equal(bricks[i / 64], least[2]);
        assert_int_equal(masks[i / 64] >> i % 64 & 1, least[0] == 0);
    }
    assert_int_equal(y.row[0], row);
    assert_int_equal(y.layer[0], layer);
    for (int level = 1; level < SC_PYRAMID_LEVELS; level++) {
        const int edge = 4 << 2 * level; /* of the cube of one mask, in cells */
        uint64_t bits = 0, expected = 0;

        for (int n = 0; n < 512; n++) { /* all cubes that reach into the grid, and more */
            const int at[3] = {n % 8, n / 8 % 8, n / 64};
            uint64_t mask = 0;

            if (at[0] * edge >= 80 || at[1] * edge >= 24 || at[2] * edge >= 20)
                continue;
            for (int k = 0; k < count; k++) {
                const int x = cells[k][0] - at[0] * edge, cy = cells[k][1] - at[1] * edge,
                          z = cells[k][2] - at[2] * edge, bit = edge / 4;

                if (x >= 0 && cy >= 0 && z >= 0 && x < edge && cy < edge && z < edge)
                    mask |= 1ull << (x / bit + 4 * (cy / bit) + 16 * (z / bit));
            }
            assert_int_equal(
                masks[y.origin[level] + at[2] * y.layer[level] + at[1] * y.row[level] + at[0]],
                mask);
            expected += (uint64_t)__builtin_popcountll(mask);
        }
        for (size_t n = (size_t)(y.origin[level] - y.row[level] - y.layer[level] - 1);
             n < (level + 1 < SC_PYRAMID_LEVELS
                      ? (size_t)(y.origin[level + 1] - y.row[level + 1] - y.layer[level + 1] - 1)
                      : y.count);
             n++)
            bits += (uint64_t)__builtin_popcountll(masks[n]);
        assert_int_equal(bits, expected); /* and the frame is empty */
    }
    sc_team_close(team);
}

/* Whether a volume was resampled, or has the grid on which it was drawn, is read back as it was
 * written. */
TEST(what_is_known_of_the_grid_is_kept)
{
    const int size[3] = {9, 8, 7};

    for (int i = 0; i < 3; i++) {
        SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 2, ellipsoid);
        const sc_prepare_settings settings = {
            .resampled = i == 1, .as_drawn = i == 2, .threads = 1};
        const prepared_copy p = prepare_as(&volume, &settings);

        assert_int_equal(p.view.how.resampled, i == 1);
        assert_int_equal(p.view.how.as_drawn, i == 2);
        sc_free(p.block);
    }
}

/* The local thickness at a vertex is that of its own tissue, not of the next one: a slab of 9
 * voxels of half a millimetre on a thick block. */
TEST(the_local_thickness_of_a_slab_is_that_of_the_slab)
{
    const int size[3] = {60, 60, 200};
    const double spacing[3] = {1, 1, 0.5};
    const sc_prepare_settings settings = {.local_thickness = true, .threads = 2};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, spacing, 1, 3, slab_on_block);
    const prepared_copy p = prepare_as(&volume, &settings);
    const sc_prepared *v = &p.view;

    assert_near(sc_thickness_mm(SC_THICKNESS_STEPS), 2 * SC_THICKNESS_LEAST_MM, 1e-12);
    assert_non_null(v->thickness);
    for (int side = 0; side < 2; side++) { /* the slab's faces, in the middle of the volume */
        const int q[3] = {31, 11, side ? 29 : 21};

        assert_true(sc_is_near(v, q[0], q[1], q[2]));
        assert_near(sc_thickness_mm(v->thickness[sc_near_index(v, q[0], q[1], q[2])]), 4.5, 0.6);
    }
    sc_free(p.block);
}

TEST(volumes_of_one_voxel_and_of_one_slice_are_prepared)
{
    static const int sizes[][3] = {{1, 1, 1}, {9, 7, 1}, {1, 300, 2}};

    for (int i = 0; i < 3; i++) {
        SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(sizes[i], cube, 1, 2, everything);
        SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);

        assert_int_equal(p.view.boundary.voxel_count, sc_volume_voxels(&volume));
    }
}

enum { MOSAIC = 40 }; /* voxels along an edge of a volume of small cubes, each another tissue */

static int id_of_cube(double x, double y, double z, int edge)
{
    const int along = MOSAIC / edge;

    return 1 + ((int)z / edge * along + (int)y / edge) * along + (int)x / edge;
}

static int cubes_of_four(double x, double y, double z)
{
    return id_of_cube(x, y, z, 4);
}

static int cubes_of_two(double x, double y, double z)
{
    return id_of_cube(x, y, z, 2);
}

/* 216 tissues lie around a block of 16 voxels, where each is smoothed, or 1728, where they are
 * drawn as their voxels are. */
TEST(many_tissues_around_a_block_all_keep_their_places)
{
    static const int size[3] = {MOSAIC, MOSAIC, MOSAIC};

    for (int edge = 2; edge <= 4; edge += 2) {
        const int along = MOSAIC / edge;
        SC_OWN(sc_volume_clear)
        sc_volume volume = shape_volume(size, cube, 2, 1 + along * along * along,
                                        edge == 2 ? cubes_of_two : cubes_of_four);
        SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);

        for (int i = 0; i < MOSAIC * MOSAIC * MOSAIC; i++) {
            const int x = i % MOSAIC, y = i / MOSAIC % MOSAIC, z = i / (MOSAIC * MOSAIC);
            const bool within = edge == 2 || ((x % 4 == 1 || x % 4 == 2) &&
                                              (y % 4 == 1 || y % 4 == 2) && z % 4 == 1);

            if (within)
                assert_int_equal(sc_vertex_at(&p.view, x + 1, y + 1, z + 1).tissue,
                                 id_of_cube(x, y, z, edge));
        }
    }
}

/* A thick body with a slanting line of another tissue upon it, two voxels high and one wide. */
static int line_upon_body(double x, double y, double z)
{
    const int along = (int)(y + z / 3);

    return z < 24 ? 1 : z < 26 && (int)x == 8 + along / 3 ? 2 : 0;
}

TEST(a_line_upon_a_thick_tissue_is_not_smoothed_away)
{
    static const int size[3] = {48, 48, 48};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 3, line_upon_body);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);

    for (int i = 0; i < 48 * 48 * 2; i++) {
        const int x = i % 48, y = i / 48 % 48, z = 24 + i / (48 * 48);

        if (line_upon_body(x, y, z) == 2) {
            const sc_vertex v = sc_vertex_at(&p.view, x + 1, y + 1, z + 1);

            assert_true(v.outer_value > 0);
            assert_int_equal(v.tissue, 2);
        }
    }
}

/* A rod of two by two voxels along a thick body of another tissue, with a gap of one voxel between
 * them. */
static int rod_before_body(double x, double y, double z)
{
    return z < 24 ? 1 : z >= 25 && z < 27 && x >= 20 && x < 22 ? 2 : 0;
}

TEST(a_rod_is_not_pushed_off_by_the_body_behind_a_gap)
{
    static const int size[3] = {48, 48, 48};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 3, rod_before_body);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);
    const sc_vertex top = sc_vertex_at(&p.view, 21, 24, 27);

    assert_true(top.outer_value > SC_BORDER_STEPS / 15); /* 7 of 96; 5 from cells' answer */
}

RUN_TESTS(NULL, NULL)
