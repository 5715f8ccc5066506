/* SPDX-License-Identifier: BSD-3-Clause */
/* The directions in the records of smoothed surfaces. */
#include "check.h"

#include "shapes.h"

#include <math.h>

static const double cube[3] = {1, 1, 1};

static int ellipsoid(double x, double y, double z)
{
    x = (x - 40) / 30;
    y = (y - 36.3) / 26;
    z = (z - 38) / 33;
    return x * x + y * y + z * z < 1;
}

static void normals_of_an_ellipsoid_are_right_to_about_a_degree(void **state)
{
    const int size[3] = {81, 73, 77};

    (void)state;
    for (int bytes = 1; bytes <= 2; bytes++) {
        sc_volume volume = shape_volume(size, cube, bytes, 2, ellipsoid);
        prepared_copy p = prepare_copy(&volume, 2);
        const sc_prepared *v = &p.view;
        double squares = 0;
        size_t count = 0;

        for (size_t brick = 0, n = 0; n < v->outer.count; brick++) {
            int low[3];

            sc_brick_low(v->bricks, brick, low);
            assert_int_equal(v->outer.start[brick], n);
            for (uint64_t mask = v->outer.masks[brick]; mask; mask &= mask - 1, n++) {
                const int bit = __builtin_ctzll(mask);
                const int x = low[0] + sc_bit_x(bit) - 1, y = low[1] + sc_bit_y(bit) - 1,
                          z = low[2] + sc_bit_z(bit) - 1;
                const sc_vec3 truth =
                    sc_vec3_unit((sc_vec3){(x - 40) / 900., (y - 36.3) / 676, (z - 38) / 1089.});
                float got[3];
                double angle;

                sc_record_normal(v->outer.records[n], got);
                angle = acos(
                    fmin(1, sc_vec3_dot(truth, sc_vec3_unit((sc_vec3){got[0], got[1], got[2]}))));
                squares += angle * angle;
                count++;
            }
        }
        assert_near(sqrt(squares / (double)count) * 180 / M_PI, 0, 1.2);
        sc_free(p.block);
        sc_volume_clear(&volume);
    }
}

/* A plane with steps, as in a segmentation that was drawn on coarser voxels. */
static int rippled(double x, double y, double z)
{
    (void)y;
    return z < 20 + 0.8 * sin(x * 0.55);
}

/* A sheet of three voxels with steps on both sides, whose normals are opposite. */
static int rippled_sheet(double x, double y, double z)
{
    return rippled(x, y, z) && !rippled(x, y, z + 3);
}

/* @return the RMS of the x components of the normals on a rippled plane or sheet, weighted by their
 * lengths as pictures do. @param count the number of normals. */
static double lean_of_normals(const sc_prepared *v, size_t *count)
{
    double squares = 0, lengths = 0;

    *count = 0;
    for (size_t brick = 0, n = 0; n < v->outer.count; brick++) {
        int at[3];

        sc_brick_at(v->bricks, brick, at);
        for (uint64_t mask = v->outer.masks[brick]; mask; mask &= mask - 1, n++) {
            float normal[3];

            if (at[0] < 4 || at[0] > 11 || at[1] < 4 || at[1] > 7 || at[2] < 4 || at[2] > 6)
                continue;
            sc_record_normal(v->outer.records[n], normal);
            squares += (double)(normal[0] * normal[0]);
            lengths += (double)(normal[0] * normal[0] + normal[2] * normal[2]);
            ++*count;
        }
    }
    return sqrt(squares / lengths);
}

/* Smoothing flattens the normals of a rippled shape: without it they lean by more than @p least
 * (RMS of their x components), and with it by less than that divided by @p times. */
static void smoothing_flattens(int (*inside)(double, double, double), double least, double times)
{
    const int size[3] = {64, 48, 40};
    sc_volume volume = shape_volume(size, cube, 1, 2, inside);
    double lean[2];
    size_t count = 0;

    for (int smooth = 0; smooth < 2; smooth++) {
        const sc_prepare_settings settings = {.smooth = {smooth, smooth, smooth}, .threads = 1};
        sc_preparation *p;
        sc_prepared v;
        void *block;

        assert_ok(sc_prepare(&quiet, &volume, &settings, &p));
        assert_ok(sc_alloc(&quiet, sc_preparation_bytes(p), 1, &block));
        sc_preparation_pack(p, block);
        assert_ok(sc_prepared_view(&quiet, block, sc_preparation_bytes(p), &v));
        lean[smooth] = lean_of_normals(&v, &count);
        sc_preparation_free(p);
        sc_free(block);
    }
    assert_true(count > 500);
    assert_true(lean[0] > least && lean[1] < lean[0] / times);
    sc_volume_clear(&volume);
}

static void ripples_of_a_flat_surface_leave_its_normals(void **state)
{
    (void)state;
    smoothing_flattens(rippled, 0.1, 2.5);
}

static void ripples_of_both_sides_of_a_sheet_leave_its_normals(void **state)
{
    (void)state;
    /* Thin tissue keeps its voxels, and so more of its waves. */
    smoothing_flattens(rippled_sheet, 0.1, 1.4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normals_of_an_ellipsoid_are_right_to_about_a_degree),
        cmocka_unit_test(ripples_of_a_flat_surface_leave_its_normals),
        cmocka_unit_test(ripples_of_both_sides_of_a_sheet_leave_its_normals),
    };

    return RUN(tests);
}
