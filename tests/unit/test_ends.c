/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissue that ends at the border of its volume closes there; what the border cuts off stays cut. */
#include "check.h"

#include "scenes.h"

#include <math.h>

/* Just the box of a ball of 15 voxels. */
static const int size[3] = {30, 30, 30};
static const double cubes[3] = {1, 1, 1}, tall[3] = {1, 1, 1.5};

/* @return how far a place in voxels lies within the ball. */
static double depth_in_ball(double x, double y, double z)
{
    return 15 - sqrt((x - 14.5) * (x - 14.5) + (y - 14.5) * (y - 14.5) + (z - 14.5) * (z - 14.5));
}

static int ball(double x, double y, double z)
{
    return depth_in_ball(x, y, z) > 0;
}

/* The ball within another tissue that fills the volume, and half of it on top of such a one. */
static int ball_in_box(double x, double y, double z)
{
    return ball(x, y, z) ? 1 : 2;
}

static int half_ball_on_box(double x, double y, double z)
{
    return y < 14 ? 2 : ball(x, y, z);
}

/* A cylinder along z, and one that becomes narrower towards the end of the volume, by 1.5 voxels
 * for each. */
static int cylinder(double x, double y, double z)
{
    (void)z;
    return hypot(x - 14.5, y - 14.5) < 9.3;
}

static int cone(double x, double y, double z)
{
    return hypot(x - 14.5, y - 14.5) < 6.3 + 1.5 * (29 - z);
}

/* @return the share of the places on a face of the volume (@p axis, at its end if @p end), right
 * below it, that the tissue 1 owns. */
static double share_of_face(const sc_prepared *v, int axis, bool end)
{
    const int side = 8 * 30;
    int owned = 0;

    for (int n = 0; n < side * side; n++) {
        float at[3];

        at[axis] = end ? 30.49f : 0.51f;
        at[(axis + 1) % 3] = 0.5f + (float)(n % side + 0.5) / 8;
        at[(axis + 2) % 3] = 0.5f + (float)((double)(n / side) + 0.5) / 8;
        owned += sc_kernel_owner(v, at) == 1;
    }
    return (double)owned / (side * side);
}

/* On each face at most two voxels are left of the cut face of the ball, and the ball is its true
 * size: its surface is nowhere more than 0.4 voxels off. Also in voxels that are not cubes. */
static void a_ball_in_its_box_is_round(void **state)
{
    (void)state;
    for (int n = 0; n < 2; n++) {
        const double *spacing = n ? tall : cubes;
        sc_volume volume;
        prepared_copy p;

        volume = shape_volume(size, spacing, 1, 2, ball);
        p = prepare_copy(&volume, 2);
        for (int face = 0; face < 6; face++)
            assert_true(share_of_face(&p.view, face / 2, face % 2) < 2.0 / 900);
        for (int i = 0; i < 30 * 30 * 30 * 8; i++) {
            const double x = i % 60 * 0.5 - 0.24, y = i / 60 % 60 * 0.5 - 0.24;
            const double z = (double)(i / 3600) * 0.5 - 0.24, depth = depth_in_ball(x, y, z);
            const float at[3] = {(float)x + 1, (float)y + 1, (float)z + 1};

            if (fabs(depth) > 0.4)
                assert_int_equal(sc_kernel_owner(&p.view, at), depth > 0);
        }
        sc_free(p.block);
        sc_volume_clear(&volume);
    }
}

/* The directions at the end of the ball are those of its surface, within 3 degrees. */
static void the_end_of_a_ball_is_lit_as_a_ball(void **state)
{
    sc_volume volume;
    prepared_copy p;
    int found = 0;

    (void)state;
    volume = shape_volume(size, cubes, 1, 2, ball);
    p = prepare_copy(&volume, 2);
    for (int y = 0; y < 30; y++) {
        for (int x = 0; x < 30; x++) {
            const double from[3] = {x - 14.5, y - 14.5, -14.5};
            float normal[3];
            double along = 0, length = 0, square = 0;

            if (hypot(from[0], from[1]) > 4)
                continue;
            sc_record_normal(
                sc_record_read(p.view.records, sc_record_index(&p.view, x + 1, y + 1, 1)), normal);
            for (int k = 0; k < 3; k++) {
                along += from[k] * (double)normal[k];
                length += from[k] * from[k];
                square += (double)normal[k] * (double)normal[k];
            }
            assert_true(along / sqrt(length * square) > cos(3 * 3.14159265 / 180));
            found++;
        }
    }
    assert_in_range(found, 40, 60);
    sc_free(p.block);
    sc_volume_clear(&volume);
}

/* What the border cuts off keeps its cut face, no smaller than its last cross-section; and so does
 * tissue beside other tissue. */
static void what_is_cut_off_stays_cut_off(void **state)
{
    int (*const shapes[])(double x, double y, double z) = {cylinder, cone, ball_in_box,
                                                           half_ball_on_box};
    const double radii[] = {9.3, 6.3, 3.84, 3.84};

    (void)state;
    for (int n = 0; n < 4; n++) {
        sc_volume volume = shape_volume(size, cubes, 1, 3, shapes[n]);
        prepared_copy p = prepare_copy(&volume, 2);
        const double disc = 3.14159265 * radii[n] * radii[n] / 900;
        const double share = shapes[n] == half_ball_on_box ? disc / 2 : disc;

        assert_true(share_of_face(&p.view, 2, true) > 0.95 * share);
        sc_free(p.block);
        sc_volume_clear(&volume);
    }
}

/* Three slices through the middle of the ball. */
static int slices_of_ball(double x, double y, double z)
{
    return depth_in_ball(x, y, z + 13.5) > 0;
}

/* Three slices of a ball are cut off at two faces of their volume, and end at the others. Along the
 * edges between these faces they end as they do away from them. */
static void an_end_reaches_the_edge_of_the_volume(void **state)
{
    const int slices[3] = {30, 30, 3};
    sc_volume volume = shape_volume(slices, cubes, 1, 2, slices_of_ball);
    prepared_copy p = prepare_copy(&volume, 2);

    (void)state;
    for (int n = 0; n < 2; n++) {
        const float in_middle[3] = {0.69f, 18.5f, 2},
                    at_edge[3] = {0.69f, 18.5f, n ? 3.49f : 0.51f};
        const float inside[3] = {3, 18.5f, n ? 3.49f : 0.51f};

        assert_int_equal(sc_kernel_owner(&p.view, in_middle), 0);
        assert_int_equal(sc_kernel_owner(&p.view, at_edge), 0);
        assert_int_equal(sc_kernel_owner(&p.view, inside), 1);
    }
    sc_free(p.block);
    sc_volume_clear(&volume);
}

/* Two tissues beside each other that end at all faces of the volume. */
static int halves_of_ball(double x, double y, double z)
{
    return ball(x, y, z) ? 1 + (x + y < 29.3) : 0;
}

/* All kernels draw the same, opaque and half opaque, obliquely and along an axis. */
static void all_kernels_draw_the_same_ends(void **state)
{
    sc_scene scene = {.clip_set_count = 1};

    (void)state;
    for (int n = 0; n < 4; n++) {
        small_scene s =
            make_scene(shape_volume(size, cubes, 1 + n / 2, 3, halves_of_ball), n % 2 ? 1 : 0.5);
        sc_image image;

        s.settings.width_px = s.settings.height_px = 77;
        scene.camera =
            sc_camera_look(n < 2 ? (sc_vec3){80, -60, 90} : (sc_vec3){14.5, -100, 14.5},
                           (sc_vec3){14.5, 14.5, 14.5}, (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, 16);
        image = draw_by_all_kernels(&s, &scene);
        sc_image_clear(&image);
        free_scene(&s);
    }
}

/* Volumes of one and two layers have nothing that tells of an end, or little. */
static void thin_volumes_are_drawn(void **state)
{
    (void)state;
    for (int layers = 1; layers <= 2; layers++) {
        for (int axis = 0; axis < 3; axis++) {
            const float middle[3] = {axis == 0 ? 1 : 15.5f, axis == 1 ? 1 : 15.5f,
                                     axis == 2 ? 1 : 15.5f};
            int thin[3] = {30, 30, 30};
            sc_volume volume;
            prepared_copy p;

            thin[axis] = layers;
            volume = shape_volume(thin, cubes, 1, 2, ball);
            p = prepare_copy(&volume, 2);
            assert_int_equal(sc_kernel_owner(&p.view, middle), 1);
            sc_free(p.block);
            sc_volume_clear(&volume);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_in_its_box_is_round),
        cmocka_unit_test(the_end_of_a_ball_is_lit_as_a_ball),
        cmocka_unit_test(what_is_cut_off_stays_cut_off),
        cmocka_unit_test(an_end_reaches_the_edge_of_the_volume),
        cmocka_unit_test(all_kernels_draw_the_same_ends),
        cmocka_unit_test(thin_volumes_are_drawn),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
