/* SPDX-License-Identifier: BSD-3-Clause */
/* Layers that taper below a voxel fade out; closed skins, vessels and thick tissue do not. */
#include "check.h"

#include "scenes.h"

#include <math.h>
#include <string.h>

static const int size[3] = {61, 61, 61};
static const double cubes[3] = {1, 1, 1};

static double tilt; /* of the vessel against the grid */

/* How many parts of SC_RECORD_FADES are missing at a voxel; 0 far from interfaces. */
static int missing_at(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick =
        sc_brick_index(v->bricks, sc_brick_of(x + 1), sc_brick_of(y + 1), sc_brick_of(z + 1));
    const int bit = sc_brick_bit(x + 1, y + 1, z + 1);

    if (!(v->near[brick] >> bit & 1))
        return 0;
    return sc_record_missing(
        sc_record_read(v->records, v->near_start[brick] + sc_brick_rank(v->near[brick], bit)));
}

/* @return how many voxels of a volume fade. */
static int count_faded(sc_volume volume)
{
    prepared_copy p = prepare_copy(&volume, 2);
    int count = 0;

    for (int i = 0; i < size[0] * size[1] * size[2]; i++)
        count += missing_at(&p.view, i % size[0], i / size[0] % size[1], i / size[0] / size[1]) > 0;
    sc_free(p.block);
    sc_volume_clear(&volume);
    return count;
}

static double slope; /* of the layer below: how fast its thickness grows */

/* The thickness, in voxels along z, of a layer that ends in a tilted line. */
static double thickness_at(double x, double y)
{
    return slope * (x - 30.3 + 0.37 * (y - 30));
}

/* Tissue 2 below a tilted plane, and on it tissue 1, which tapers to nothing. */
static int wedge(double x, double y, double z)
{
    const double height = z - 28.4 - 0.23 * (x - 30) + 0.31 * (y - 30);

    return height < 0 ? 2 : height < thickness_at(x, y) ? 1 : 0;
}

/* Away from the border of the volume, two thirds or more are missing where the layer is thinner
 * than 0.4 voxels, and nothing where it is thicker than 1.5. */
static void the_thin_end_of_a_layer_fades(void **state)
{
    static const double slopes[] = {0.25, 0.15, 0.1};

    (void)state;
    for (size_t n = 0; n < sizeof slopes / sizeof *slopes; n++) {
        sc_volume volume;
        prepared_copy p;
        int thin = 0;

        slope = slopes[n];
        volume = shape_volume(size, cubes, 1, 3, wedge);
        p = prepare_copy(&volume, 2);

        for (int i = 0; i < size[0] * size[1] * size[2]; i++) {
            const int x = i % size[0], y = i / size[0] % size[1], z = i / size[0] / size[1];

            if (x < 10 || y < 10 || x > 50 || y > 50)
                continue;
            if (wedge(x, y, z) != 1 || thickness_at(x, y) > 1.5) {
                assert_int_equal(missing_at(&p.view, x, y, z), 0);
            } else if (thickness_at(x, y) < 0.4) {
                assert_in_range(missing_at(&p.view, x, y, z), 2, SC_RECORD_FADES);
                thin++;
            }
        }
        assert_true(thin > 5);
        sc_free(p.block);
        sc_volume_clear(&volume);
    }
}

static double radius;

/* A ball of two tissues under a skin one voxel thick, that no path by faces crosses. */
static int ball_in_skin(double x, double y, double z)
{
    static const int beside[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                     {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    const double c = 30.2;

    if ((x - c) * (x - c) + (y - c) * (y - c) + (z - c) * (z - c) < radius * radius)
        return x + 0.7 * y > 1.7 * c ? 2 : 3;
    for (int i = 0; i < 6; i++) {
        const double dx = x - c + beside[i][0], dy = y - c + beside[i][1],
                     dz = z - c + beside[i][2];

        if (dx * dx + dy * dy + dz * dz < radius * radius)
            return 1;
    }
    return 0;
}

static void closed_skins_do_not_fade(void **state)
{
    (void)state;
    radius = 2.3;
    for (int n = 0; n < 6; n++, radius *= 1.6)
        assert_int_equal(count_faded(shape_volume(size, cubes, 1, 4, ball_in_skin)), 0);
}

/* A vessel that lies on tissue, gets thinner from radius 4 to a line of single voxels, and has a
 * twig as thin. */
static int vessel(double x, double y, double z)
{
    const double across = y - 30 - tilt * (x - 30), r = 4 * (1 - x / 50), up = z - 29.5 - 0.8 * r;

    if (z < 29.5)
        return 2;
    if (r > 0.6 ? across * across + up * up < r * r : fabs(across) < 0.5 && z < 30.5)
        return 1;
    return z < 30.5 && fabs(x - 15 - 0.4 * fabs(y - 30)) < 0.5;
}

static void vessels_on_a_wall_do_not_fade(void **state)
{
    (void)state;
    tilt = 0;
    for (int n = 0; n < 3; n++, tilt += 0.17)
        assert_int_equal(count_faded(shape_volume(size, cubes, 1, 3, vessel)), 0);
}

/* Seen from above, without light, there is a soft passage from one tissue to the other: many pixels
 * have neither colour. All kernels draw the same. */
static void all_kernels_draw_the_soft_rim(void **state)
{
    sc_scene scene = {.clip_set_count = 1};
    small_scene s;
    sc_image image;
    int between = 0;

    (void)state;
    slope = 0.2;
    s = make_scene(shape_volume(size, cubes, 1, 3, wedge), 1);
    s.settings.light = (sc_lighting){.flat = true};
    s.settings.width_px = s.settings.height_px = 122;
    scene.camera = sc_camera_look((sc_vec3){30, 30, 200}, (sc_vec3){30, 30, 30}, (sc_vec3){0, 1, 0},
                                  SC_ORTHOGRAPHIC, 30.5);
    image = draw_by_all_kernels(&s, &scene);
    for (int i = 0; i < 122 * 122; i++)
        between += memcmp(image.rgb + 3 * i, s.volume.labels[1].rgb, 3) &&
                   memcmp(image.rgb + 3 * i, s.volume.labels[2].rgb, 3);
    assert_in_range(between, 122 * 3, 122 * 12);
    sc_image_clear(&image);
    free_scene(&s);
}

/* Where a layer on a plane fades out, both of one colour, the light hardly changes: what is seen
 * below it is lit by its own gradients. */
static void what_a_faded_layer_lies_on_is_lit_evenly(void **state)
{
    sc_scene scene = {.clip_set_count = 1};
    small_scene s;
    sc_image image;
    double sum = 0;
    int darkest = 255;

    (void)state;
    slope = 0.1;
    s = make_scene(shape_volume(size, cubes, 1, 3, wedge), 1);
    for (int id = 1; id < 3; id++) {
        for (int c = 0; c < 3; c++)
            s.tissues[id].rgb_linear[c] = 0.4f;
    }
    s.settings.width_px = s.settings.height_px = 201;
    scene.camera = sc_camera_look((sc_vec3){30 - 0.23 * 60, 30 + 0.31 * 60, 90},
                                  (sc_vec3){30, 30, 29}, (sc_vec3){0, 1, 0}, SC_ORTHOGRAPHIC, 12);
    image = draw_view(&s, &scene, NULL);
    for (int n = 0; n < 201 * 201; n++) {
        const int here = image.rgb[3 * n];

        darkest = here < darkest ? here : darkest;
        sum += here;
    }
    assert_true(darkest > sum / (201 * 201) - 6);
    sc_image_clear(&image);
    free_scene(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_thin_end_of_a_layer_fades),
        cmocka_unit_test(closed_skins_do_not_fade),
        cmocka_unit_test(vessels_on_a_wall_do_not_fade),
        cmocka_unit_test(all_kernels_draw_the_soft_rim),
        cmocka_unit_test(what_a_faded_layer_lies_on_is_lit_evenly),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
