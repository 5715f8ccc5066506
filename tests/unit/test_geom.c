/* SPDX-License-Identifier: BSD-3-Clause */
/* Affine maps, rotations, lines clipped to boxes, and distances. */
#include "check.h"

#include "segcast/geom.h"

TEST(the_inverse_of_an_oblique_map_undoes_it)
{
    const sc_affine a = {{{1.5, 0.2, 0, 10}, {-0.1, 0.9, 0.3, -20}, {0, 0.4, -2, 5}}};
    sc_affine inverse;
    const sc_vec3 p = {3, -4, 5};
    sc_vec3 q;

    assert_true(sc_affine_invert(&a, &inverse));
    q = sc_affine_point(&inverse, sc_affine_point(&a, p));
    assert_near(q.x, p.x, 1e-12);
    assert_near(q.y, p.y, 1e-12);
    assert_near(q.z, p.z, 1e-12);
    assert_near(sc_affine_determinant(&a) * sc_affine_determinant(&inverse), 1, 1e-12);
}

TEST(composed_maps_are_applied_one_after_the_other)
{
    const sc_affine a = {{{1.5, 0.2, 0, 10}, {-0.1, 0.9, 0.3, -20}, {0, 0.4, -2, 5}}};
    const sc_affine b = {{{0, 2, 0, 1}, {-1, 0, 0.5, 2}, {0.25, 0, 3, -7}}};
    const sc_affine both = sc_affine_compose(&b, &a);
    const sc_vec3 p = {3, -4, 5};
    const sc_vec3 once = sc_affine_point(&both, p);
    const sc_vec3 twice = sc_affine_point(&b, sc_affine_point(&a, p));

    assert_near(once.x, twice.x, 1e-12);
    assert_near(once.y, twice.y, 1e-12);
    assert_near(once.z, twice.z, 1e-12);
}

TEST(singular_maps_are_refused_at_any_scale)
{
    const sc_affine flat = {{{1, 0, 1, 0}, {0, 1, 0, 0}, {1, 0, 1, 0}}};
    const sc_affine tiny = {{{1e-6, 0, 0, 0}, {0, 1e-6, 0, 0}, {0, 0, 1e-6, 0}}};
    const sc_affine bad = {{{NAN, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    sc_affine out;

    assert_false(sc_affine_invert(&flat, &out));
    assert_false(sc_affine_invert(&bad, &out));
    assert_true(sc_affine_invert(&tiny, &out));
}

TEST(rotations_are_right_handed)
{
    const sc_vec3 front = {0, 1, 0}, up = {0, 0, 1};
    const sc_vec3 turned = sc_vec3_rotate(front, up, M_PI / 2);

    assert_near(turned.x, -1, 1e-12); /* from the front to the patient's left */
    assert_near(turned.y, 0, 1e-12);
}

TEST(lines_are_clipped_to_boxes)
{
    const sc_box3 box = {{0, 0, 0}, {10, 10, 10}};
    double begin = 0, end = 100;

    assert_true(sc_box3_clip_line(&box, (sc_vec3){-5, 5, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
    assert_near(begin, 5, 0);
    assert_near(end, 15, 0);
    begin = 0, end = 100;
    assert_false(sc_box3_clip_line(&box, (sc_vec3){-5, 11, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
    begin = 0, end = 100; /* the line lies in a face of the box */
    assert_true(sc_box3_clip_line(&box, (sc_vec3){-5, 10, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
    begin = 0, end = 100; /* the box is behind the origin */
    assert_false(sc_box3_clip_line(&box, (sc_vec3){15, 5, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
}

/* ---- distances ---- */

enum { NX = 9, NY = 7, NZ = 8 };

/* A fixed shape with holes, so that runs along every axis are cut. */
static bool is_inside(int x, int y, int z)
{
    return x >= 0 && y >= 0 && z >= 0 && x < NX && y < NY && z < NZ &&
           (x * 7 + y * 5 + z * 3 + x * y * z) % 11 != 0;
}

/* Transform @p square [NZ][NY][NX] along one axis, run by run. */
static void pass_along(double *square, int axis, double step)
{
    static const int size[3] = {NX, NY, NZ}, stride[3] = {1, NX, NX * NY};
    double run[NX + NY + NZ], work[SC_DISTANCE_WORK(NX + NY + NZ)];
    int at[3];

    for (int n = 0; n < NX * NY * NZ; n++) {
        int count = 0;

        at[0] = n % NX, at[1] = n / NX % NY, at[2] = n / NX / NY;
        if (!is_inside(at[0], at[1], at[2]))
            continue;
        at[axis]--;
        if (is_inside(at[0], at[1], at[2]))
            continue; /* not the first of its run */
        at[axis]++;
        for (; at[axis] < size[axis] && is_inside(at[0], at[1], at[2]); at[axis]++)
            run[count] = square[n + count * stride[axis]], count++;
        sc_distance_pass(run, count, step, work);
        for (int i = 0; i < count; i++)
            square[n + i * stride[axis]] = run[i];
    }
}

/* By trying all voxels, and those around the grid, which are outside. */
static double nearest_outside(int x, int y, int z, const double step[3])
{
    double least = HUGE_VAL;

    for (int k = -1; k <= NZ; k++) {
        for (int j = -1; j <= NY; j++) {
            for (int i = -1; i <= NX; i++) {
                const double dx = (i - x) * step[0], dy = (j - y) * step[1], dz = (k - z) * step[2];

                if (!is_inside(i, j, k))
                    least = fmin(least, dx * dx + dy * dy + dz * dz);
            }
        }
    }
    return least;
}

TEST(distances_are_those_that_trying_all_voxels_gives)
{
    static const double steps[][3] = {{1, 1, 1}, {0.7, 1.3, 3}, {2.5, 0.4, 1}};
    double square[NX * NY * NZ];

    for (size_t s = 0; s < sizeof steps / sizeof *steps; s++) {
        for (int n = 0; n < NX * NY * NZ; n++)
            square[n] = HUGE_VAL;
        for (int axis = 0; axis < 3; axis++)
            pass_along(square, axis, steps[s][axis]);
        for (int n = 0; n < NX * NY * NZ; n++) {
            const int x = n % NX, y = n / NX % NY, z = n / NX / NY;

            if (is_inside(x, y, z))
                assert_near(square[n], nearest_outside(x, y, z, steps[s]), 1e-12);
        }
    }
}

RUN_TESTS(NULL, NULL)
