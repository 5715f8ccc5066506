/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoothing by strengths that differ between axes and between tissues, and stronger than fields.c
 * can. */
#include "check.h"

#include "shapes.h"

#include <math.h>
#include <string.h>

static const double cube[3] = {1, 1, 1};

static sc_vec3 same(double strength)
{
    return (sc_vec3){strength, strength, strength};
}

/* Prepare a volume. @param strengths [label_count], or NULL: all as @p smooth. */
static prepared_copy prepare_telling(const sc_ctx *ctx, const sc_volume *volume, sc_vec3 smooth,
                                     const sc_vec3 *strengths)
{
    const sc_prepare_settings settings = {
        .smooth = smooth, .tissue_smooth = strengths, .threads = 2};
    sc_preparation *p;
    prepared_copy out;
    size_t bytes;

    assert_ok(sc_prepare(ctx, volume, &settings, &p));
    bytes = sc_preparation_bytes(p);
    assert_ok(sc_zalloc(&quiet, bytes, 1, &out.block));
    sc_preparation_pack(p, out.block);
    sc_preparation_free(p);
    assert_ok(sc_prepared_view(&quiet, out.block, bytes, &out.view));
    return out;
}

static prepared_copy prepare_with(const sc_volume *volume, sc_vec3 smooth, const sc_vec3 *strengths)
{
    return prepare_telling(&quiet, volume, smooth, strengths);
}

/* The weight of a voxel, which must be near an interface. */
static int weight_at(const sc_prepared *v, int x, int y, int z)
{
    assert_true(sc_is_near(v, x + 1, y + 1, z + 1));
    return sc_record_weight(sc_record_read(v->records, sc_record_index(v, x + 1, y + 1, z + 1)));
}

/* Three slabs across x: 1, 2 and 3. */
static int slabs(double x, double y, double z)
{
    (void)y;
    (void)z;
    return x < 16 ? 1 : x < 32 ? 2 : 3;
}

/* Whatever the strengths on either side, a flat border lies midway: both sides weigh the same. */
static void a_flat_border_lies_midway_between_any_two_strengths(void **state)
{
    static const double strengths[] = {0, 0.3, 0.5, 1, 1.25, 1.7, 2.5};
    const int size[3] = {48, 12, 12};
    sc_volume volume = shape_volume(size, cube, 1, 4, slabs);

    (void)state;
    for (size_t i = 0; i < SC_COUNT_OF(strengths) * SC_COUNT_OF(strengths); i++) {
        const sc_vec3 each[4] = {same(0), same(strengths[i % SC_COUNT_OF(strengths)]),
                                 same(strengths[i / SC_COUNT_OF(strengths)]), same(1)};
        prepared_copy p = prepare_with(&volume, same(1), each);
        const int left = weight_at(&p.view, 15, 6, 6), right = weight_at(&p.view, 16, 6, 6);

        assert_in_range(1 + left - right, 0, 2); /* but for rounding */
        assert_in_range(left, 21, 23);
        assert_in_range(1 + weight_at(&p.view, 31, 6, 6) - weight_at(&p.view, 32, 6, 6), 0, 2);
        for (int id = 1; id < 4; id++)
            assert_true(sc_strength_is_same(p.view.smooth[id], each[id]));
        sc_free(p.block);
    }
    sc_volume_clear(&volume);
}

/* Two balls far from each other: 1 and 2. */
static int balls(double x, double y, double z)
{
    const double r2 = (y - 16) * (y - 16) + (z - 16) * (z - 16);

    return (x - 16) * (x - 16) + r2 < 100 ? 1 : (x - 78) * (x - 78) + r2 < 100 ? 2 : 0;
}

/* A tissue is smoothed by its own strength, whatever others far from it have. */
static void each_tissue_has_its_own_strength(void **state)
{
    static const double strengths[2] = {0.5, 1};
    const int size[3] = {96, 33, 33};
    sc_volume volume = shape_volume(size, cube, 2, 3, balls);

    (void)state;
    for (int i = 0; i < 2; i++) {
        const sc_vec3 each[3] = {same(0), same(1), same(strengths[i] + 1e-3)};
        prepared_copy mixed = prepare_with(&volume, same(0), each);
        prepared_copy alone = prepare_with(&volume, same(1), NULL);
        int differ = 0, near = 0;

        assert_int_equal(mixed.view.near_count, alone.view.near_count);
        for (int n = 0; n < 40 * 33 * 33; n++) {
            const int x = n % 40, y = n / 40 % 33, z = n / 40 / 33;

            if (!sc_is_near(&alone.view, x + 1, y + 1, z + 1))
                continue;
            near++;
            differ += weight_at(&mixed.view, x, y, z) != weight_at(&alone.view, x, y, z);
            assert_in_range(1 + weight_at(&mixed.view, x, y, z) - weight_at(&alone.view, x, y, z),
                            0, 2);
        }
        assert_true(near > 1000 && differ < near / 100); /* but for rounding */
        sc_free(mixed.block);
        sc_free(alone.block);
    }
    sc_volume_clear(&volume);
}

/* A cylinder along z for five slices; above and below them it is wider, or not there. */
static int wider(double x, double y, double z)
{
    const double radius = fabs(z - 16) <= 2 ? 8 : 11;

    return (x - 16) * (x - 16) + (y - 16) * (y - 16) < radius * radius;
}

static int short_one(double x, double y, double z)
{
    return fabs(z - 16) <= 2 && wider(x, y, z);
}

/* @return how many weights in slice 16 differ between the two volumes. */
static int differing_weights(sc_vec3 smooth)
{
    const int size[3] = {33, 33, 33};
    sc_volume volumes[2] = {shape_volume(size, cube, 1, 2, wider),
                            shape_volume(size, cube, 1, 2, short_one)};
    prepared_copy a = prepare_with(&volumes[0], smooth, NULL);
    prepared_copy b = prepare_with(&volumes[1], smooth, NULL);
    int compared = 0, differ = 0;

    for (int n = 0; n < 33 * 33; n++) {
        const int x = n % 33, y = n / 33;

        if (sc_is_near(&a.view, x + 1, y + 1, 17) && sc_is_near(&b.view, x + 1, y + 1, 17)) {
            compared++;
            differ += weight_at(&a.view, x, y, 16) != weight_at(&b.view, x, y, 16);
        }
    }
    assert_true(compared > 50);
    sc_free(a.block);
    sc_free(b.block);
    for (int i = 0; i < 2; i++)
        sc_volume_clear(&volumes[i]);
    return differ;
}

/* Along an axis of strength 0 slices know nothing of each other, by either of the two ways. */
static void nothing_is_smoothed_along_an_axis_of_strength_0(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const double s = i ? 2.5 : 1.25;

        assert_true(differing_weights(same(s)) > 20);
        assert_int_equal(differing_weights((sc_vec3){s, s, 0}), 0);
        assert_true(differing_weights((sc_vec3){0, s, s}) > 20);
    }
}

/* A half space whose border is tilted against all axes. */
static const double tilted[3] = {0.64, 0.48, 0.6};

static int half_space(double x, double y, double z)
{
    return tilted[0] * (x - 24.2) + tilted[1] * (y - 24.1) + tilted[2] * (z - 24.3) < 0;
}

/* However much more one axis is smoothed than another, normals do not lean towards it. */
static void normals_stay_upright_with_unequal_strengths(void **state)
{
    static const sc_vec3 strengths[] = {{1, 1, 2},   {1, 1, 2.5}, {2.5, 1, 1},
                                        {1, 2, 1.5}, {2, 2, 0.5}, {2, 2, 2}};
    const int size[3] = {49, 49, 49};
    sc_volume volume = shape_volume(size, cube, 1, 2, half_space);

    (void)state;
    for (size_t i = 0; i < SC_COUNT_OF(strengths); i++) {
        prepared_copy p = prepare_with(&volume, strengths[i], NULL);
        int near = 0;

        for (int n = 0; n < 17 * 17 * 17; n++) { /* far from the border of the volume */
            const int x = 17 + n % 17, y = 17 + n / 17 % 17, z = 17 + n / 17 / 17;
            float normal[3];
            double along = 0;

            if (!sc_is_near(&p.view, x, y, z))
                continue;
            sc_record_normal(sc_record_read(p.view.records, sc_record_index(&p.view, x, y, z)),
                             normal);
            for (int k = 0; k < 3; k++)
                along += tilted[k] * (double)normal[k];
            near++;
            assert_true(fabs(along) > cos(3 * 3.14159265 / 180)); /* of a unit vector */
        }
        assert_true(near > 500);
        sc_free(p.block);
    }
    sc_volume_clear(&volume);
}

/* Half spaces whose border meets the first slice across x near its middle: at 50 degrees, and
 * grazing it, at 20. */
static const double grazing[3] = {0.94, 0.2, 0.27641};

static int half_space_at_border(double x, double y, double z)
{
    return tilted[0] * (x - 1.2) + tilted[1] * (y - 24.1) + tilted[2] * (z - 24.3) < 0;
}

static int half_space_along_border(double x, double y, double z)
{
    return grazing[0] * (x - 1.2) + grazing[1] * (y - 24.1) + grazing[2] * (z - 24.3) < 0;
}

/* @return by how many degrees the normals of voxels beside the border of a half space are off, root
 * mean square, in the first slices across x. @param normal the true one. */
static double border_error_deg(int (*id_of)(double x, double y, double z), const double normal[3],
                               double strength)
{
    const int size[3] = {49, 49, 49};
    sc_volume volume = shape_volume(size, cube, 1, 2, id_of);
    prepared_copy p = prepare_with(&volume, same(strength), NULL);
    double sum = 0;
    int found = 0;

    for (int n = 0; n < 3 * 25 * 25; n++) {
        const int x = n % 3, y = 12 + n / 3 % 25, z = 12 + n / 3 / 25;
        const double depth =
            normal[0] * (x - 1.2) + normal[1] * (y - 24.1) + normal[2] * (z - 24.3);
        const int at[3] = {x + 1, y + 1, z + 1};
        float one[3];
        double along = 0, off_deg;

        if (fabs(depth) > 0.8)
            continue;
        if (!sc_is_near(&p.view, at[0], at[1], at[2]))
            continue; /* a little off the border */
        sc_record_normal(
            sc_record_read(p.view.records, sc_record_index(&p.view, at[0], at[1], at[2])), one);
        for (int k = 0; k < 3; k++)
            along += normal[k] * (double)one[k];
        off_deg = acos(fmin(fabs(along), 1)) * 180 / 3.14159265;
        sum += off_deg * off_deg;
        found++;
    }
    assert_true(found > 40);
    sc_free(p.block);
    sc_volume_clear(&volume);
    return sqrt(sum / found);
}

/* Beside the border of the volume a surface is lit as it is elsewhere, and does not seem to bend.
 */
static void normals_by_the_border_of_the_volume_are_those_of_the_surface(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const double strength = i ? 2 : 1;

        assert_true(border_error_deg(half_space_at_border, tilted, strength) < 4);
        assert_true(border_error_deg(half_space_along_border, grazing, strength) < 7);
    }
}

/* Nine slabs along x. */
static int nine_slabs(double x, double y, double z)
{
    (void)y;
    (void)z;
    return 1 + (int)x / 4;
}

static void more_strengths_than_tables_are_refused(void **state)
{
    const int size[3] = {36, 6, 6};
    sc_volume volume = shape_volume(size, cube, 1, 10, nine_slabs);
    sc_vec3 each[10] = {{0, 0, 0}};
    bool hidden[10] = {false};
    sc_prepare_settings settings = {.tissue_smooth = each, .hidden = hidden, .threads = 1};
    sc_preparation *p;

    (void)state;
    for (int id = 1; id < 10; id++)
        each[id] = same(0.2 * id);
    assert_int_equal(sc_prepare(&quiet, &volume, &settings, &p), SC_ERR_DATA);
    hidden[4] = true; /* what is hidden needs no tables */
    assert_ok(sc_prepare(&quiet, &volume, &settings, &p));
    sc_preparation_free(p);
    sc_volume_clear(&volume);
}

/* Every voxel has a label of its own, but for background far from them. */
static int dust(double x, double y, double z)
{
    return x < 10 && y < 10 && z < 10 ? 1 + (int)(x + 10 * y + 100 * z) : 0;
}

/* The same, and a ball that no window shares with them. */
static int dust_and_ball(double x, double y, double z)
{
    return balls(x, y, z) == 2 ? 1001 : dust(x, y, z);
}

/* Where a window holds more labels than strong smoothing is for, strength 1 replaces it; strong
 * smoothing would take minutes. The rest of the volume is smoothed as without them. */
static void crowds_of_labels_are_smoothed_by_strength_1(void **state)
{
    const int size[3] = {96, 33, 33};
    sc_volume volume = shape_volume(size, cube, 2, 1002, dust_and_ball);
    sc_volume ball = shape_volume(size, cube, 1, 3, balls);
    heard said;
    sc_ctx ctx = listening(&said);
    prepared_copy strong = prepare_telling(&ctx, &volume, same(2.5), NULL);
    prepared_copy plain = prepare_with(&volume, same(1), NULL);
    prepared_copy alone = prepare_with(&ball, same(2.5), NULL);
    int in_dust = 0, in_ball = 0, differ = 0;

    (void)state;
    for (int n = 0; n < 96 * 33 * 33; n++) {
        const int x = n % 96, y = n / 96 % 33, z = n / 96 / 33;

        if (dust(x, y, z) > 0) {
            in_dust++;
            assert_int_equal(weight_at(&strong.view, x, y, z), weight_at(&plain.view, x, y, z));
        } else if (x > 60 && sc_is_near(&strong.view, x + 1, y + 1, z + 1)) {
            in_ball++;
            assert_int_equal(weight_at(&strong.view, x, y, z), weight_at(&alone.view, x, y, z));
            differ += weight_at(&strong.view, x, y, z) != weight_at(&plain.view, x, y, z);
        }
    }
    assert_int_equal(in_dust, 1000);
    assert_int_equal(said.warnings, 1);
    assert_non_null(strstr(said.text, "more than 128 labels meet in"));
    assert_true(in_ball > 1000 && differ > in_ball / 10);
    sc_free(strong.block);
    sc_free(plain.block);
    sc_free(alone.block);
    sc_volume_clear(&volume);
    sc_volume_clear(&ball);
}

/* In a crowd of labels, too, nothing is smoothed more than its own strength says; and crisp tissue
 * has the same weight everywhere. */
static void crowds_of_labels_stay_crisp(void **state)
{
    const int size[3] = {16, 12, 12};
    sc_volume volume = shape_volume(size, cube, 2, 1001, dust);
    sc_vec3 each[1001];
    prepared_copy p;

    (void)state;
    for (int id = 0; id < 1001; id++)
        each[id] = same(id % 2 ? 2.5 : 0);
    p = prepare_with(&volume, same(1), each);
    for (int n = 0; n < 1000; n++)
        assert_in_range(weight_at(&p.view, n % 10, n / 10 % 10, n / 100), 21, 23);
    sc_free(p.block);
    sc_volume_clear(&volume);
}

/* A strength too small to reach the next voxel is as good as 0, by either of the two ways, and one
 * whose square is 0 does no harm. */
static void strengths_that_reach_no_voxel_count_as_0(void **state)
{
    static const double weak[] = {0.1, 1e-310};
    const int size[3] = {33, 33, 33};
    sc_volume volume = shape_volume(size, cube, 1, 2, wider);

    (void)state;
    for (int i = 0; i < 2 * 2 * 2; i++) {
        const double strong = i & 1 ? 2.5 : 1, s = weak[i >> 1 & 1];
        const bool one_axis = i & 4;
        prepared_copy a =
            prepare_with(&volume, one_axis ? (sc_vec3){strong, strong, 0} : same(0), NULL);
        prepared_copy b =
            prepare_with(&volume, one_axis ? (sc_vec3){strong, strong, s} : same(s), NULL);
        int near = 0;

        for (int n = 0; n < 33 * 33 * 33; n++) {
            const int x = n % 33, y = n / 33 % 33, z = n / 33 / 33;

            if (!sc_is_near(&a.view, x + 1, y + 1, z + 1))
                continue;
            near++;
            assert_int_equal(weight_at(&a.view, x, y, z), weight_at(&b.view, x, y, z));
        }
        assert_true(near > 1000);
        sc_free(a.block);
        sc_free(b.block);
    }
    sc_volume_clear(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flat_border_lies_midway_between_any_two_strengths),
        cmocka_unit_test(each_tissue_has_its_own_strength),
        cmocka_unit_test(nothing_is_smoothed_along_an_axis_of_strength_0),
        cmocka_unit_test(normals_stay_upright_with_unequal_strengths),
        cmocka_unit_test(normals_by_the_border_of_the_volume_are_those_of_the_surface),
        cmocka_unit_test(more_strengths_than_tables_are_refused),
        cmocka_unit_test(crowds_of_labels_are_smoothed_by_strength_1),
        cmocka_unit_test(crowds_of_labels_stay_crisp),
        cmocka_unit_test(strengths_that_reach_no_voxel_count_as_0),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
