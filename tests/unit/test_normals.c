/* SPDX-License-Identifier: BSD-3-Clause */
/* The directions in the records of smoothed surfaces. */
#include "check.h"

#include "shapes.h"

#include <math.h>

static const double cube[3] = {1, 1, 1};

typedef struct ellipsoid {
    double middle[3], radii[3]; /* voxels */
    double degrees;             /* largest RMS of its normals */
} ellipsoid;

static const ellipsoid large = {{40, 36.3, 38}, {30, 26, 33}, 1.2};
/* Bends too much for the gradients of the wide field, by which they would be 3 degrees off. */
static const ellipsoid small = {{40, 36.3, 38}, {9, 11, 10}, 2};

static int is_within(const ellipsoid *e, double x, double y, double z)
{
    x = (x - e->middle[0]) / e->radii[0];
    y = (y - e->middle[1]) / e->radii[1];
    z = (z - e->middle[2]) / e->radii[2];
    return x * x + y * y + z * z < 1;
}

static int is_within_large(double x, double y, double z)
{
    return is_within(&large, x, y, z);
}

static int is_within_small(double x, double y, double z)
{
    return is_within(&small, x, y, z);
}

/* @return the RMS of the errors of the normals of an ellipsoid, in degrees. */
static double error_of_normals(const sc_prepared *v, const ellipsoid *e)
{
    double squares = 0;
    size_t n = 0;

    for (size_t brick = 0; n < v->outer.count; brick++) {
        int low[3];

        sc_brick_low(v->bricks, brick, low);
        assert_int_equal(v->outer.start[brick], n);
        for (uint64_t mask = v->outer.masks[brick]; mask; mask &= mask - 1, n++) {
            const int bit = __builtin_ctzll(mask);
            const int at[3] = {low[0] + sc_bit_x(bit) - 1, low[1] + sc_bit_y(bit) - 1,
                               low[2] + sc_bit_z(bit) - 1};
            double truth[3], angle;
            float got[3];

            for (int i = 0; i < 3; i++)
                truth[i] = (at[i] - e->middle[i]) / (e->radii[i] * e->radii[i]);
            sc_record_normal(v->outer.records[n], got);
            angle = acos(fmin(1, sc_vec3_dot(sc_vec3_unit((sc_vec3){truth[0], truth[1], truth[2]}),
                                             sc_vec3_unit((sc_vec3){got[0], got[1], got[2]}))));
            squares += angle * angle;
        }
    }
    return sqrt(squares / (double)n) * 180 / M_PI;
}

/* Check the normals of an ellipsoid in a volume of @p bytes a voxel. */
static void check_normals(const ellipsoid *e, int (*inside)(double, double, double), int bytes)
{
    const int size[3] = {81, 73, 77};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, bytes, 2, inside);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&volume, 2);

    assert_near(error_of_normals(&p.view, e), 0, e->degrees);
}

TEST(normals_of_ellipsoids_are_right_to_a_degree_or_two)
{
    for (int bytes = 1; bytes <= 2; bytes++) {
        check_normals(&large, is_within_large, bytes);
        check_normals(&small, is_within_small, bytes);
    }
}

/* A plane with steps, as in a segmentation that was drawn on coarser voxels. */
static int rippled(double x, double y, double z)
{
    return z < 20 + 0.8 * sin(x * 0.55);
}

/* Folds higher than voxels, as those of a brain. */
static int folded(double x, double y, double z)
{
    return z < 20 + 2.5 * sin(x * 0.35);
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

/* Write how much the normals of a shape lean, as the RMS of their x components, without and with
 * smoothing. */
static void find_leans(int (*inside)(double, double, double), double lean[2])
{
    const int size[3] = {64, 48, 40};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 2, inside);
    size_t count = 0;

    for (int smooth = 0; smooth < 2; smooth++) {
        const sc_prepare_settings settings = {.smooth = {smooth, smooth, smooth}, .threads = 1};
        const prepared_copy p = prepare_as(&volume, &settings);

        lean[smooth] = lean_of_normals(&p.view, &count);
        sc_free(p.block);
    }
    assert_true(count > 500);
}

/* Smoothing flattens the normals of a rippled shape: without it they lean by more than @p least,
 * and with it by less than that divided by @p times. */
static void smoothing_flattens(int (*inside)(double, double, double), double least, double times)
{
    double lean[2];

    find_leans(inside, lean);
    assert_true(lean[0] > least && lean[1] < lean[0] / times);
}

TEST(ripples_of_a_flat_surface_leave_its_normals)
{
    /* 39 times; 3 times without the gradients of the wide field */
    smoothing_flattens(rippled, 0.1, 20);
}

TEST(folds_keep_their_normals)
{
    double lean[2];

    find_leans(folded, lean);
    assert_near(lean[1] / lean[0], 1, 0.1);
}

TEST(ripples_of_both_sides_of_a_sheet_leave_its_normals)
{
    /* Thin tissue keeps its voxels, and so most of its waves. */
    smoothing_flattens(rippled_sheet, 0.1, 1.2);
}

RUN_TESTS(NULL, NULL)
