/* SPDX-License-Identifier: BSD-3-Clause */
/* The grid on which a volume was drawn: copied voxels are found and removed without loss, thick
 * slices get layers between them that keep the slices as they are. */
#include "check.h"

#include <limits.h>

#include "internal.h"
#include "shapes.h"

enum { SIDE = 24 };

/* Voxels of two overlapping balls and a plate, without any order that could be taken for copies. */
static int drawn_id(double x, double y, double z)
{
    const double ball = hypot(hypot(x - 11.3, y - 12.1), z - 10.7);
    const double other = hypot(hypot(x - 15.2, y - 9.4), z - 13.1);

    return ball < 7.3 ? 1 : other < 6.1 ? 2 : y > 18 && x + z < 30 ? 3 : 0;
}

/* @return the dense id of a voxel. */
static int id_at(const sc_volume *v, const int at[3])
{
    const size_t n =
        ((size_t)at[2] * (size_t)v->size[1] + (size_t)at[1]) * (size_t)v->size[0] + (size_t)at[0];

    return v->label_bytes == 1 ? ((uint8_t *)v->ids)[n] : ((uint16_t *)v->ids)[n];
}

/* Go on to the next voxel, x fastest. @return false behind the last. */
static bool next_voxel(const sc_volume *v, int at[3])
{
    for (int i = 0; i < 3; i++) {
        if (++at[i] < v->size[i])
            return true;
        at[i] = 0;
    }
    return false;
}

/* How the volume of copied_id was copied up. */
static double copies[3], phase[3];

/* @return the drawn voxel from which plane @p n along an axis was copied. */
static double drawn_of(int axis, double n)
{
    return floor((n + 0.5 - phase[axis]) / copies[axis]);
}

static int copied_id(double x, double y, double z)
{
    return drawn_id(drawn_of(0, x), drawn_of(1, y), drawn_of(2, z));
}

/* Check that a volume holds drawn_id, and that its voxels lie where their copies were. */
static void check_drawn(const sc_volume *v, const double spacing[3])
{
    int at[3] = {0, 0, 0};

    do {
        const sc_vec3 p = sc_affine_point(&v->to_ras_mm, (sc_vec3){at[0], at[1], at[2]});
        const double mm[3] = {p.x, p.y, p.z};

        assert_int_equal(id_at(v, at), drawn_id(at[0], at[1], at[2]));
        for (int i = 0; i < 3; i++) {
            const double face = mm[i] / spacing[i] + 0.5; /* from the outer face, in voxels */

            assert_true(fabs(face - phase[i] - (at[i] + 0.5) * copies[i]) < 0.6);
        }
    } while (next_voxel(v, at));
}

TEST_OF_THREADS(copied_voxels_are_found_and_removed)
{
    static const double tries[][3] = {{4, 4, 4}, {2, 3, 1}, {2.5, 1.75, 3.2}, {1, 1, 4.11}};
    static const double begins[][3] = {{0, 0, 0}, {-1, -2, 0}, {-0.3, -1.1, -2}, {0, 0, -0.7}};
    const double spacing[3] = {0.4, 0.5, 0.6};

    for (size_t t = 0; t < SC_COUNT_OF(tries); t++) {
        sc_drawn_grid grid;
        SC_OWN(sc_volume_clear) sc_volume v = {0};
        int size[3];

        for (int i = 0; i < 3; i++) {
            copies[i] = tries[t][i];
            phase[i] = begins[t][i];
            size[i] = (int)ceil(SIDE * copies[i] + phase[i]);
        }
        v = shape_volume(size, spacing, t % 2 ? 2 : 1, 4, copied_id);
        assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
        for (int i = 0; i < 3; i++) {
            assert_true(fabs(grid.copies[i] - copies[i]) < 0.05);
            assert_true(fabs(grid.drawn_mm[i] - copies[i] * spacing[i]) < 0.05);
            grid.split[i] = 1;
        }
        assert_true(sc_is_resampled(&grid));
        sc_resampled_size(&v, &grid, size);
        assert_ok(sc_resample(&quiet, &v, &grid, 2));
        assert_memory_equal(size, v.size, sizeof size);
        check_drawn(&v, spacing);
    }
}

/* Voxels drawn at random, each copied 3.0781 times along x. */
static int random_id(double x, double y, double z)
{
    const uint64_t n = (uint64_t)(floor((x + 1.06) / 3.0781) + 1000 * y + 100000 * z);

    return n * 0x9e3779b97f4a7c15u >> 63;
}

TEST(copies_are_found_among_many_planes)
{
    const int size[3] = {480, 9, 9};
    SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, (double[3]){1, 1, 1}, 1, 2, random_id);
    sc_drawn_grid grid;

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    assert_true(fabs(grid.copies[0] - 3.0781) < 0.001);
    assert_true(grid.copies[1] == 1 && grid.copies[2] == 1);
}

TEST(volumes_that_were_not_copied_stay_as_they_are)
{
    const double spacing[3] = {1, 1.2, 1.6};
    const int size[3] = {SIDE, SIDE, SIDE};
    SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, spacing, 1, 4, drawn_id);
    const uint64_t hash = sc_volume_hash(&v);
    sc_drawn_grid grid;

    assert_ok(sc_find_drawn_grid(&quiet, &v, 1, &grid));
    assert_false(sc_is_resampled(&grid));
    assert_ok(sc_resample(&quiet, &v, &grid, 1));
    assert_true(sc_volume_hash(&v) == hash);
    memset(v.ids, 0, sc_volume_voxels(&v)); /* nothing to tell it by */
    assert_ok(sc_find_drawn_grid(&quiet, &v, 1, &grid));
    assert_false(sc_is_resampled(&grid));
}

/* A tilted plane, a plate one voxel thin, and a column that is too thin for the filter. */
static int thick_id(double x, double y, double z)
{
    if (y == 3)
        return 2;
    if (y < 3)
        return 0;
    return hypot(x - 30, y - 20) < 2.2 ? 3 : x + 0.5 * y < 12 + 4 * z ? 1 : 0;
}

/* The axis across the slices of thick_volume. */
static int across;

/* thick_id with the axes z and `across` exchanged. */
static int turned_id(double x, double y, double z)
{
    double p[3] = {x, y, z}, along = p[across];

    p[across] = z;
    return thick_id(p[0], p[1], along);
}

/* @return thick_id in nine slices across an axis, five times as far apart as pixels are wide. */
static sc_volume thick_volume(int axis)
{
    double spacing[3] = {1, 1, 1};
    int size[3] = {40, 30, 40};

    across = axis;
    size[2] = size[axis];
    size[axis] = 9;
    spacing[axis] = 5;
    return shape_volume(size, spacing, axis == 2 ? 1 : 2, 4, turned_id);
}

/* Check a volume that was resampled: slices are as they were, and thin tissue is whole. @return the
 * share of voxels on the wrong side of the tilted plane, near it. */
static double check_layers(const sc_volume *v, int axis, int split)
{
    int at[3] = {0, 0, 0};
    double wrong = 0, count = 0;

    do {
        const int id = id_at(v, at);
        const double z = (at[axis] + 0.5) / split - 0.5;
        double p[3] = {at[0], at[1], at[2]}, border;

        p[axis] = at[2];
        if (at[axis] % split == split / 2) /* a slice */
            assert_int_equal(id, thick_id(p[0], p[1], z));
        if (p[1] == 3)
            assert_int_equal(id, 2);
        if (hypot(p[0] - 30, p[1] - 20) < 1)
            assert_int_equal(id, 3);
        border = 12 + 4 * z - 0.5 * p[1];
        if (z < 2 || z > 4 || p[1] < 10 || fabs(p[0] - border) > 6)
            continue;
        wrong += (id == 1) != (p[0] < border);
        count++;
    } while (next_voxel(v, at));
    assert_true(count > 1000);
    return wrong / count;
}

TEST(layers_between_slices_keep_the_slices)
{
    for (int axis = 0; axis < 3; axis++) {
        SC_OWN(sc_volume_clear) sc_volume one = thick_volume(axis), three = thick_volume(axis);
        sc_drawn_grid grid;
        assert_ok(sc_find_drawn_grid(&quiet, &one, 1, &grid));
        assert_int_equal(grid.split[axis], 5);
        assert_ok(sc_resample(&quiet, &one, &grid, 1));
        assert_ok(sc_resample(&quiet, &three, &grid, 3));
        assert_int_equal(one.size[axis], 45);
        assert_memory_equal(one.ids, three.ids, sc_volume_voxels(&one) * (size_t)one.label_bytes);
        /* Slices that are only copied put a tenth of the points near the plane on the wrong side.
         */
        assert_true(check_layers(&one, axis, grid.split[axis]) < 0.02);
    }
}

/* Which lump in_lump tells of. */
static int lump;

/* Is a point in a lump, a ball with dents? Every lump is another one. */
static bool in_lump(double x, double y, double z)
{
    const double p[3] = {x - 19.7 - 0.1 * lump, y - 20.3, 5 * z - 25 + 0.3 * lump};
    const double dents = sin(0.5 * p[0] + lump) + sin(0.4 * p[1] - 2 * lump) + sin(0.35 * p[2]);

    return hypot(hypot(p[0], p[1]), p[2]) < 14 + 1.3 * dents;
}

/* The lump closed under a skin: those of its voxels that share a face with one outside. */
static int skin_id(double x, double y, double z)
{
    for (int n = 0; n < 6 && in_lump(x, y, z); n++) {
        const double side = n % 2 ? 1 : -1;

        if (!in_lump(x + side * (n / 2 == 0), y + side * (n / 2 == 1), z + side * (n / 2 == 2)))
            return 2;
    }
    return in_lump(x, y, z);
}

/* Check that no voxel of the tissue under the skin of a lump, brought to layers, lies beside one of
 * the background. */
static void check_skin(void)
{
    const int size[3] = {42, 42, 11};
    SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, (double[3]){1, 1, 5}, 1, 3, skin_id);
    double skin = 0, inside = 0;
    sc_drawn_grid grid;
    int at[3] = {0, 0, 0};

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    assert_int_equal(grid.split[2], 5);
    assert_ok(sc_resample(&quiet, &v, &grid, 2));
    do {
        skin += id_at(&v, at) == 2;
        inside += id_at(&v, at) == 1;
        for (int i = 0; i < 3; i++) {
            int next[3] = {at[0], at[1], at[2]};

            if (++next[i] < v.size[i])
                assert_false(id_at(&v, at) + id_at(&v, next) == 1); /* 0 beside 1 */
        }
    } while (next_voxel(&v, at));
    assert_true(inside > 3000 && skin > 1000 && skin < 12000);
}

TEST_OF_THREADS(closed_skins_stay_closed)
{
    for (lump = 0; lump < 20; lump++)
        check_skin();
}

/* A steep plane: in each slice its border is four pixels farther along x. */
static int steep_id(double x, double y, double z)
{
    return x < 4 * z + 3.5;
}

/* Beyond the first and the last slice tissue goes on as between the slices, and not straight. Every
 * layer is right up to a pixel. */
TEST_OF_THREADS(tissue_goes_on_beyond_the_last_slice)
{
    enum { NX = 40, NY = 12, SLICES = 8, SPLIT = 5, LAYERS = SLICES * SPLIT };
    const sc_drawn_grid grid = {
        .copies = {1, 1, 1}, .drawn_mm = {0.2, 0.2, 1}, .split = {1, 1, SPLIT}};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((const int[3]){NX, NY, SLICES}, grid.drawn_mm, 1, 2, steep_id);
    const uint8_t *ids;

    assert_ok(sc_resample(&quiet, &v, &grid, 2));
    ids = v.ids;
    for (int i = 0; i < NX * NY * LAYERS; i++) {
        const int layer = i / (NX * NY);
        const double x = i % NX, z = (layer + 0.5) / SPLIT - 0.5;

        if (fabs(x - (4 * z + 3.5)) > 1)
            assert_int_equal(ids[i], steep_id(x, 0, z));
    }
}

/* A block and a step on it, between which a sheet lies that covers the block in one slice. */
static int patch_id(double x, double y, double z)
{
    if (z == 4 && x > 8 && x < 22 && y > 5 && y < 25)
        return 2;
    return x < 26 && (z < 4 || x < 16);
}

TEST(sheets_end_between_slices)
{
    const int size[3] = {30, 30, 9};
    SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, (double[3]){1, 1, 5}, 1, 3, patch_id);
    sc_drawn_grid grid;
    int at[3] = {0, 0, 0}, patch = 0;

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    assert_ok(sc_resample(&quiet, &v, &grid, 2));
    do {
        if (id_at(&v, at) != 2)
            continue;
        patch++;
        assert_true(abs(at[2] - 4 * 5 - 2) < 4); /* layers from the slice: the next one is at 5 */
    } while (next_voxel(&v, at));
    assert_true(patch >= 19);
}

/* A wall three pixels thick that moves by more than twice that from one slice to the next, between
 * tissue and, on the other side, either other tissue or none. */
static int wall_id(double x, double y, double z)
{
    const double from_wall = x - 12 - 7 * z;

    return from_wall < 0 ? 1 : from_wall < 3 ? 3 : y < 10 ? 2 : 0;
}

TEST(walls_that_move_sideways_stay_whole)
{
    const int size[3] = {80, 20, 9};
    SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, (double[3]){1, 1, 5}, 1, 4, wall_id);
    sc_drawn_grid grid;
    char text[320];

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    assert_int_equal(grid.split[2], 5);
    sc_drawn_grid_text(&grid, text, sizeof text);
    assert_non_null(strstr(text, "each slice along z becomes 5 layers"));
    assert_ok(sc_resample(&quiet, &v, &grid, 2));
    /* Not beside the first and the last slice: nothing tells there how the wall moves on. */
    for (int z = 7; z < v.size[2] - 7; z++) {
        for (int y = 0; y < size[1]; y++) {
            int wall = 0;

            for (int x = 0; x < size[0]; x++)
                wall += id_at(&v, (int[3]){x, y, z}) == 3;
            assert_in_range(wall, 2, 5);
        }
    }
}

/* A tube in a wall, of one tissue below and another above. */
static int junction_id(double x, double y, double z)
{
    return hypot(x - 15.2, y - 14.7) < 4.3 ? 1 + (z > 4) : 3;
}

TEST(walls_beside_two_tissues_do_not_part_them)
{
    const int size[3] = {30, 30, 9};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume(size, (double[3]){1, 1, 5}, 1, 4, junction_id);
    sc_drawn_grid grid;
    int at[3] = {0, 0, 0};

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    assert_ok(sc_resample(&quiet, &v, &grid, 2));
    do {
        if (hypot(at[0] - 15.2, at[1] - 14.7) < 3)
            assert_int_not_equal(id_at(&v, at), 3);
    } while (next_voxel(&v, at));
}

/* A tube that moves across its slices by nearly its radius from one to the next, a ball, and a
 * column that ends between two slices while another one of its label, far away, goes on. */
static int oblique_id(double x, double y, double z)
{
    const double mm = 6 * z;

    if (hypot(x - 10 - 0.7 * mm, y - 15.3) < 6)
        return 1;
    if (hypot(hypot(x - 40.4, y - 42.2), mm - 36.3) < 20.2)
        return 2;
    if (hypot(x - 9, y - 60) < 6 && mm < 33)
        return 3;
    return hypot(x - 60, y - 63) < 1.2 ? 3 : 0;
}

TEST_OF_THREADS(oblique_and_round_tissue_keeps_its_volume)
{
    const int size[3] = {70, 70, 13};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume(size, (double[3]){1, 1, 6}, 1, 4, oblique_id);
    double truth[4] = {0}, kept[4] = {0}, wrong = 0;
    sc_drawn_grid grid;
    int at[3] = {0, 0, 0};

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    assert_int_equal(grid.split[2], 5);
    assert_ok(sc_resample(&quiet, &v, &grid, 2));
    do {
        const int id = id_at(&v, at), true_id = oblique_id(at[0], at[1], (at[2] - 2) / 5.0);

        if (at[2] < 2 || at[2] > 62)
            continue;
        truth[true_id]++;
        kept[id]++;
        wrong += id != true_id;
    } while (next_voxel(&v, at));
    for (int id = 1; id < 4; id++)
        assert_true(kept[id] > 0.97 * truth[id] && kept[id] < 1.03 * truth[id]);
    assert_true(wrong < 0.05 * (truth[1] + truth[2]));
}

/* A label in one voxel, or one at two ends. */
static int small_id(double x, double y, double z)
{
    return x == 30 && y == 30 && z == 4;
}
static int wide_id(double x, double y, double z)
{
    return (x == 1 && y == 1 && z == 4) || (x == 58 && y == 58 && z == 4);
}

/* @return how many bytes resampling a volume of 60 x 60 x @p slices voxels takes. */
static double bytes_of(int slices, double slice_mm, int threads, int (*id)(double, double, double))
{
    const int size[3] = {60, 60, slices};
    SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, (double[3]){1, 1, slice_mm}, 1, 2, id);
    sc_drawn_grid grid;
    double bytes = -1;

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    assert_ok(sc_resample_bytes(&quiet, &v, &grid, threads, &bytes));
    return bytes;
}

TEST(bytes_grow_with_boxes_slices_and_threads)
{
    const double least = bytes_of(12, 5, 1, small_id), box = 60 * 60 * sizeof(float);

    assert_true(bytes_of(12, 1, 1, small_id) == 0);
    assert_true(least > 20 * box && least < 27 * box); /* eleven of them of background alone */
    assert_true(bytes_of(12, 5, 1, wide_id) - least > 8 * box);
    assert_true(bytes_of(12, 5, 3, small_id) - least > 3 * box);
    assert_true(bytes_of(40, 5, 1, small_id) - least == 28 * 60 * 60 * 3);
}

TEST(boxes_of_labels_without_voxels_are_empty)
{
    const int size[3] = {60, 60, 9};
    SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, (double[3]){1, 1, 1}, 1, 3, small_id);
    SC_OWN(sc_free_at) sc_label_tally *boxes = NULL;

    assert_ok(sc_resample_find_boxes(&quiet, &v, 2, &boxes));
    assert_int_equal(boxes[0].voxels, 60 * 60 * 9 - 1);
    assert_int_equal(boxes[1].voxels, 1);
    assert_memory_equal(boxes[1].low, ((int[3]){30, 30, 4}), sizeof boxes[1].low);
    assert_memory_equal(boxes[1].high, boxes[1].low, sizeof boxes[1].high);
    assert_int_equal(boxes[2].voxels, 0);
    for (int i = 0; i < 3; i++)
        assert_true(boxes[2].low[i] > boxes[2].high[i]);
}

enum { JUMPING = 56 };

/* @return the next of a series of random numbers from 0 to 1. */
static double random_of(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) / 16777216.0;
}

/* @return how many voxels of a volume do not carry the label of @p id. */
static int count_wrong(const sc_volume *v, int (*id)(double x, double y, double z))
{
    int at[3] = {0, 0, 0}, wrong = 0;

    do {
        wrong += id(at[0], at[1], at[2]) != id_at(v, at);
    } while (next_voxel(v, at));
    return wrong;
}

/* By how much the slices of jumping_id were moved, from -2 to 2. */
static int jumps[JUMPING][2];

static void set_jumps(void)
{
    uint32_t seed = 3;

    for (int z = 0; z < JUMPING; z++) {
        for (int i = 0; i < 2; i++)
            jumps[z][i] = (int)(5 * random_of(&seed)) - 2;
    }
}

/* A ball and an oblique rod. */
static int leaning_id(double x, double y, double z)
{
    const double rod = hypot(x - 18 - 0.3 * z, y - 30);
    const double ball = hypot(hypot(x - 27.3, y - 28.1), z - 27.7);

    return rod < 12 ? 2 : ball < 17.3;
}

static int jumping_id(double x, double y, double z)
{
    return leaning_id(x - jumps[(int)z][0], y - jumps[(int)z][1], z);
}

/* By how much moved_id moves all slices. */
static int offset[2];

static int moved_id(double x, double y, double z)
{
    return leaning_id(x - offset[0], y - offset[1], z);
}

/* @return how many voxels differ from leaning_id, wherever that fits best: nothing tells where
 * all slices together were. */
static int count_wrong_anywhere(const sc_volume *v)
{
    int least = INT_MAX;

    for (offset[0] = -2; offset[0] <= 2; offset[0]++) {
        for (offset[1] = -2; offset[1] <= 2; offset[1]++) {
            const int wrong = count_wrong(v, moved_id);

            least = wrong < least ? wrong : least;
        }
    }
    return least;
}

/* A body whose outline grows and shrinks by some pixels from slice to slice, with two more labels.
 */
static int body_id(double x, double y, double z)
{
    const double a = (x - 19) / 16, b = (y - 16) / 13, c = (z - 13) / 11;

    if (x >= 4 && x < 12 && y >= 14 && y < 20 && z >= 20 && z < 27)
        return 3;
    return a * a + b * b + c * c >= 1 ? 0 : x > 22 && y > 18 && z > 9 ? 2 : 1;
}

/* Contours that grow or shrink are no slices that jump. */
TEST(growing_contours_are_not_moved)
{
    static const double spacing[3] = {1, 1.25, 1.5};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((const int[3]){40, 34, 28}, spacing, 1, 4, body_id);
    sc_drawn_grid grid;

    assert_ok(sc_find_drawn_grid(&quiet, &v, 2, &grid));
    for (int axis = 0; axis < 3; axis++)
        assert_int_equal(grid.moved[axis], 0);
}

TEST_OF_THREADS(slices_that_jump_are_moved_back)
{
    const int size[3] = {JUMPING, JUMPING, JUMPING};
    const double spacing[3] = {1, 1, 1};
    sc_volume still = shape_volume(size, spacing, 2, 4, leaning_id), one, three;
    sc_drawn_grid grid;
    char text[320];
    int wrong;

    set_jumps();
    one = shape_volume(size, spacing, 2, 4, jumping_id);
    three = shape_volume(size, spacing, 2, 4, jumping_id);
    wrong = count_wrong_anywhere(&one);
    assert_ok(sc_find_drawn_grid(&quiet, &still, 1, &grid));
    assert_false(sc_is_resampled(&grid));
    assert_ok(sc_find_drawn_grid(&quiet, &one, 2, &grid));
    assert_int_equal(grid.moved[0], 0);
    assert_int_equal(grid.moved[1], 0);
    assert_true(grid.moved[2] > 20);
    sc_drawn_grid_text(&grid, text, sizeof text);
    assert_non_null(strstr(text, "slices along z jump"));
    assert_ok(sc_resample(&quiet, &one, &grid, 1));
    assert_ok(sc_resample(&quiet, &three, &grid, 3));
    assert_memory_equal(one.ids, three.ids, 2 * sc_volume_voxels(&one));
    assert_true(count_wrong_anywhere(&one) * 3 < wrong);
    sc_volume_clear(&still);
    sc_volume_clear(&one);
    sc_volume_clear(&three);
}

TEST(a_spacing_in_a_wrong_unit_gets_no_layers)
{
    const int size[3] = {SIDE, SIDE, SIDE};
    const double spacings[][3] = {{1, 1, 1000}, {1, 1, 0.001}, {1000, 1, 1}};

    for (size_t i = 0; i < SC_COUNT_OF(spacings); i++) {
        SC_OWN(sc_volume_clear) sc_volume v = shape_volume(size, spacings[i], 1, 4, drawn_id);
        sc_drawn_grid grid;

        assert_ok(sc_find_drawn_grid(&quiet, &v, 1, &grid));
        assert_false(sc_is_resampled(&grid));
    }
}

/* Check that want of memory is told wherever it strikes. @param least how often memory is taken at
 * least. */
static void check_lack_of_memory(const int size[3], double slice_mm,
                                 int (*id)(double x, double y, double z), int least)
{
    int n;

    for (n = 0; n < 200; n++) {
        SC_OWN(sc_volume_clear)
        sc_volume v = shape_volume(size, (double[3]){1, 1, slice_mm}, 1, 4, id);
        sc_drawn_grid grid;
        long left = n;
        sc_ctx ctx = quiet;
        sc_status status;

        ctx.alloc_budget = &left;
        status = sc_find_drawn_grid(&ctx, &v, 1, &grid);
        if (status == SC_OK)
            status = sc_resample(&ctx, &v, &grid, 1);
        if (status == SC_OK)
            break;
        assert_int_equal(status, SC_ERR_MEMORY);
    }
    assert_true(n > least && n < 200);
}

TEST(lack_of_memory_is_told)
{
    const int thick[3] = {20, 20, 8}, cube[3] = {JUMPING, JUMPING, JUMPING};
    const int copied[3] = {SIDE * 2, SIDE * 3, SIDE * 4};

    check_lack_of_memory(thick, 5, thick_id, 8);
    set_jumps();
    check_lack_of_memory(cube, 1, jumping_id, 24);
    for (int i = 0; i < 3; i++) {
        copies[i] = 2 + i;
        phase[i] = 0;
    }
    check_lack_of_memory(copied, 1, copied_id, 24);
}

static int no_id(double x, double y, double z)
{
    (void)x, (void)y, (void)z;
    return 0;
}

/* Thick slices in which many labels are scattered at random. */
static sc_volume scattered_volume(int label_count)
{
    const int size[3] = {40, 25, 6};
    const double spacing[3] = {0.2, 0.2, 1};
    sc_volume v = shape_volume(size, spacing, 2, label_count, no_id);
    uint64_t seed = 5;

    for (size_t i = 0; i < sc_volume_voxels(&v); i++)
        ((uint16_t *)v.ids)[i] = (uint16_t)(random_bits(&seed) >> 40) % (uint16_t)label_count;
    return v;
}

/* The work for scattered labels is limited, by copying those that are scattered the most. */
TEST_OF_THREADS(scattered_labels_are_copied)
{
    static const int label_counts[] = {40, 400};
    const sc_drawn_grid grid = {.copies = {1, 1, 1}, .drawn_mm = {0.2, 0.2, 1}, .split = {1, 1, 5}};

    for (size_t i = 0; i < SC_COUNT_OF(label_counts); i++) {
        SC_OWN(sc_volume_clear) sc_volume drawn = scattered_volume(label_counts[i]);
        SC_OWN(sc_volume_clear) sc_volume one = scattered_volume(label_counts[i]);
        SC_OWN(sc_volume_clear) sc_volume three = scattered_volume(label_counts[i]);
        const size_t pixels = 40 * 25;
        size_t copied = 0;
        const sc_ctx *ctx = listening_anew();

        assert_ok(sc_resample(ctx, &one, &grid, 1));
        assert_ok(sc_resample(&quiet, &three, &grid, 3));
        assert_int_equal(one.size[2], 30);
        assert_memory_equal(one.ids, three.ids, sc_volume_voxels(&one) * 2);
        for (size_t at = 0; at < sc_volume_voxels(&one); at++)
            copied += ((uint16_t *)one.ids)[at] ==
                      ((uint16_t *)drawn.ids)[at / pixels / 5 * pixels + at % pixels];
        assert_int_equal(said.warnings, i);
        assert_true(!i || strstr(said.text, "of 400 labels are scattered over the slices"));
        assert_true((double)copied / (double)sc_volume_voxels(&one) > (i ? 0.85 : 0));
    }
}

/* @return the label of the old voxel nearest to a point, which lies in the volume. */
static int nearest_id(const sc_volume *old, sc_vec3 p_mm)
{
    sc_affine to_voxel;
    sc_vec3 p;

    assert_true(sc_affine_invert(&old->to_ras_mm, &to_voxel));
    p = sc_affine_point(&to_voxel, p_mm);
    return id_at(old, (int[3]){(int)lround(p.x), (int)lround(p.y), (int)lround(p.z)});
}

TEST_OF_THREADS(resizing_keeps_the_nearest_label_and_the_place)
{
    static const int sizes[][3] = {{SIDE, SIDE, SIDE}, {7, 11, 100}, {1, 2, 1}, {50, 17, 24}};
    const double spacing[3] = {0.7, 1.1, 1.3};
    const int side[3] = {SIDE, SIDE, SIDE};

    for (int t = 0; t < (int)SC_COUNT_OF(sizes) * 2; t++) {
        const int *size = sizes[t / 2], bytes = 1 + t % 2;
        SC_OWN(sc_volume_clear) sc_volume old = shape_volume(side, spacing, bytes, 4, drawn_id);
        SC_OWN(sc_volume_clear) sc_volume v = shape_volume(side, spacing, bytes, 4, drawn_id);
        int at[3] = {0, 0, 0};
        sc_vec3 corner, old_corner;

        assert_ok(sc_resample_nearest(&quiet, &v, size, 2));
        assert_memory_equal(v.size, size, sizeof v.size);
        if (t < 2)
            assert_true(sc_volume_hash(&v) == sc_volume_hash(&old));
        corner = sc_affine_point(&v.to_ras_mm, (sc_vec3){-0.5, -0.5, -0.5});
        old_corner = sc_affine_point(&old.to_ras_mm, (sc_vec3){-0.5, -0.5, -0.5});
        assert_true(sc_vec3_length(sc_vec3_sub(corner, old_corner)) < 1e-9);
        do {
            const sc_vec3 p =
                sc_affine_point(&v.to_ras_mm, (sc_vec3){at[0] + 1e-6, at[1] + 1e-6, at[2] + 1e-6});

            assert_int_equal(id_at(&v, at), nearest_id(&old, p));
        } while (next_voxel(&v, at));
    }
}

/* ---- votes ---- */

/* A tilted ellipsoid of radii 33, 27 and 38 voxels, of which the left and the right half have
 * labels of their own. */
static int halves_id(double x, double y, double z)
{
    const double dx = x - 44.8, dy = y - 45.1, dz = z - 44.9;
    const double u = 0.8 * dx + 0.6 * dy, w = -0.6 * dx + 0.8 * dy;
    const double v = 0.6 * w + 0.8 * dz, t = 0.8 * w - 0.6 * dz;

    if (u * u / (33 * 33) + v * v / (27 * 27) + t * t / (38 * 38) > 1)
        return 0;
    return u < 0.3 * v ? 1 : 2;
}

/* How far the ellipsoid of halves_id and its halves lie from where they should in a volume that was
 * resampled from spacings of 1: *volume is that of what is kept, *off_voxels the volume of what has
 * another label than it should for each unit of surface, in the larger of the old and new voxels.
 */
static void measure_halves(const sc_volume *v, double *volume, double *off_voxels)
{
    const double step = v->to_ras_mm.m[0][0], each = step * step * step;
    const double a = pow(33 * 27, 1.6), b = pow(33 * 38, 1.6), c = pow(27 * 38, 1.6);
    const double area = 4 * M_PI * pow((a + b + c) / 3, 1 / 1.6) + M_PI * 27 * 38; /* and between */
    double inside = 0, wrong = 0;
    int at[3] = {0, 0, 0};

    do {
        const sc_vec3 p = sc_affine_point(&v->to_ras_mm, (sc_vec3){at[0], at[1], at[2]});
        const int id = id_at(v, at);

        assert_true(id >= 0 && id < 3);
        inside += id != 0;
        wrong += id != halves_id(p.x, p.y, p.z);
    } while (next_voxel(v, at));
    *volume = inside * each;
    *off_voxels = wrong * each / area / fmax(1, step);
}

TEST(votes_keep_volumes_and_surfaces)
{
    static const double steps[] = {0.7, 2, 1.6, 1};
    const double whole = 4.0 / 3 * M_PI * 33 * 27 * 38;

    for (size_t i = 0; i < SC_COUNT_OF(steps); i++) {
        const double mm[3] = {steps[i], steps[i], steps[i]};
        sc_volume one =
            shape_volume((int[]){90, 91, 92}, (double[]){1, 1, 1}, 1 + (int)i % 2, 3, halves_id);
        sc_volume three =
            shape_volume((int[]){90, 91, 92}, (double[]){1, 1, 1}, 1 + (int)i % 2, 3, halves_id);
        const uint64_t before = sc_volume_hash(&one);
        double volume, off_voxels;

        assert_ok(sc_resample_votes(&quiet, &one, mm, 1));
        assert_ok(sc_resample_votes(&quiet, &three, mm, 3));
        assert_int_equal(one.size[1], (int)round(91 / steps[i]));
        assert_near(one.to_ras_mm.m[2][2], steps[i], 1e-12);
        assert_memory_equal(one.ids, three.ids, sc_volume_voxels(&one) * (size_t)one.label_bytes);
        for (int k = 0; k < 3; k++) /* the middle stays */
            assert_near(one.to_ras_mm.m[k][3] + (one.size[k] - 1) / 2.0 * steps[i], (89 + k) / 2.0,
                        1e-9);
        measure_halves(&one, &volume, &off_voxels);
        assert_near(volume / whole, 1, 0.01);
        assert_true(off_voxels < 0.15);
        assert_true(steps[i] != 1 || sc_volume_hash(&one) == before);
        sc_volume_clear(&one);
        sc_volume_clear(&three);
    }
}

/* A line along x, one along the diagonal of space, a slanted sheet, one voxel thick each, and a
 * lone voxel. */
static int thin_id(double x, double y, double z)
{
    if (y == 4 && z == 5)
        return 1;
    if (x == y && y == z - 8)
        return 2;
    if (x + y == 34)
        return 3;
    return x == 20 && y == 8 && z == 20 ? 4 : 0;
}

TEST(what_is_thin_is_not_torn_when_voxels_become_finer)
{
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((int[]){24, 24, 32}, (double[]){1, 1, 1}, 1, 5, thin_id);
    int at[3] = {0, 0, 0};

    assert_ok(sc_resample_votes(&quiet, &v, (double[]){0.5, 0.5, 0.5}, 2));
    do {
        assert_int_equal(id_at(&v, at), thin_id(at[0] / 2, at[1] / 2, at[2] / 2));
    } while (next_voxel(&v, at));
}

TEST(a_vote_without_memory_changes_nothing)
{
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((int[]){24, 24, 32}, (double[]){1, 1, 1}, 1, 5, thin_id);
    const uint64_t before = sc_volume_hash(&v);
    sc_status status = SC_ERR_MEMORY;
    long failed = 0;

    for (; status != SC_OK && failed < 64; failed++) {
        long budget = failed;
        const sc_ctx ctx = {.level = SC_LOG_ERROR, .alloc_budget = &budget};

        assert_true(sc_volume_hash(&v) == before);
        status = sc_resample_votes(&ctx, &v, (double[]){0.5, 2, 0.5}, 2);
        assert_true(status == SC_OK || status == SC_ERR_MEMORY);
    }
    assert_true(failed > 12);
    assert_int_equal(v.size[1], 12);
}

/* Thick slices become thinner, and pixels coarser, at once. */
TEST(votes_have_a_spacing_for_each_axis)
{
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((int[]){90, 91, 92}, (double[]){1, 2, 3}, 1, 3, halves_id);
    int size[3];
    sc_affine to_ras_mm;

    sc_resample_votes_grid(&v, (double[]){2, 2, 1}, size, &to_ras_mm);
    assert_ok(sc_resample_votes(&quiet, &v, (double[]){2, 2, 1}, 2));
    assert_memory_equal(size, v.size, sizeof size);
    assert_memory_equal(&to_ras_mm, &v.to_ras_mm, sizeof to_ras_mm);
    assert_int_equal(size[0], 45);
    assert_int_equal(size[1], 91);
    assert_int_equal(size[2], 276);
}

RUN_TESTS(NULL, NULL)
