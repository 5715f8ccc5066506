/* SPDX-License-Identifier: BSD-3-Clause */
/* The light of smooth surfaces does not show the voxels. */
#include "check.h"

#include "scenes.h"

#include <math.h>

/* On an opaque ball lit from the viewer's upper left no voxels are visible: neighbouring pixels
 * differ little. */
TEST(shading_is_smooth)
{
    SC_OWN(free_scene) small_scene s = make_scene(cube_volume(41, 2, large_ball), 1);
    sc_scene scene = {.clip.set_count = 1};
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.settings.width_px = s.settings.height_px = 201;
    scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 20);
    image = draw_view(&s, &scene, NULL);
    assert_true(pixel(&image, 70, 70)[0] > pixel(&image, 130, 130)[0] + 20);
    for (int y = 60; y < 140; y++) {
        for (int x = 60; x < 140; x++)
            assert_true(abs(pixel(&image, x, y)[0] - pixel(&image, x + 1, y)[0]) < 14);
    }
}

/* The axes of bent_seam, oblique to the grid: along its seam, across it, and towards the viewer. */
static void seam_axes(sc_vec3 axes[3])
{
    axes[0] = sc_vec3_unit((sc_vec3){0.91, 0.36, 0.21});
    axes[2] = sc_vec3_unit(sc_vec3_cross((sc_vec3){-0.22, 0, 0.98}, axes[0]));
    axes[1] = sc_vec3_cross(axes[0], axes[2]);
}

/* Two tissues side by side that meet in a valley: parts of two cylinders along the seam. */
static int bent_seam(double x, double y, double z)
{
    const sc_vec3 from = {x - 24, y - 24, z - 24};
    sc_vec3 axes[3];
    double across, out;

    seam_axes(axes);
    across = sc_vec3_dot(from, axes[1]);
    out = sc_vec3_dot(from, axes[2]);
    if (hypot(across + 14, out + 40) < 44)
        return 1;
    return hypot(across - 14, out + 40) < 44 ? 2 : 0;
}

/* How much the light of row @p y of a picture varies from column @p begin to @p end: its standard
 * deviation, in levels of sRGB. */
static double variation_of_row(const sc_image *image, int y, int begin, int end)
{
    double mean = 0, squares = 0;

    for (int x = begin; x < end; x++) {
        const double level = pixel(image, x, y)[0];

        mean += level / (end - begin);
        squares += level * level / (end - begin);
    }
    return sqrt(fmax(squares - mean * mean, 0));
}

/* Two tissues of one colour lie side by side. Their light may change across the seam, but not along
 * it, where nothing changes but how the surface lies in the grid. Nearer to the seam than two
 * voxels it is a little less even. */
static void check_shading_along_a_seam(double strength)
{
    const sc_vec3 middle = {24, 24, 24};
    SC_OWN(free_scene) small_scene s = make_scene(cube_volume(49, 3, bent_seam), 1);
    sc_scene scene = {.clip.set_count = 1};
    sc_vec3 axes[3];
    SC_OWN(sc_image_clear) sc_image image = {0};

    sc_free(s.prepared.block);
    s.prepared = prepare_copy_smooth(&s.volume, 2, strength);
    seam_axes(axes);
    for (int id = 1; id < 3; id++) {
        for (int c = 0; c < 3; c++)
            s.tissues[id].rgb_linear[c] = 0.4f;
    }
    s.settings.width_px = s.settings.height_px = 201;
    scene.camera =
        sc_camera_look(sc_vec3_along(middle, 80, axes[2]), middle, axes[1], SC_ORTHOGRAPHIC, 20);
    image = draw_view(&s, &scene, NULL);
    for (int y = 50; y < 150; y++) {
        const bool near = y >= 77 && y < 98;

        assert_true(variation_of_row(&image, y, 60, 140) < (near ? 3 : 1.8));
    }
}

TEST(shading_is_even_along_a_seam)
{
    check_shading_along_a_seam(1);
    check_shading_along_a_seam(2);
}

/* A plate two and a half voxels thick before a block, aslant to the grid, and between the two a gap
 * of about a voxel, which the voxels close here and there. */
static int plate_before_block(double x, double y, double z)
{
    const double depth = y - 28 + 0.21 * (x - 20) + 0.34 * (z - 20);

    return depth > 1.1 && depth < 3.6 ? 1 : depth < 0 ? 2 : 0;
}

/* The back of a translucent tissue is lit evenly where a gap about a voxel wide parts it from what
 * is behind: the voxels of the gap tell the direction of one of its sides alone. */
TEST(the_back_of_a_tissue_is_lit_evenly_beside_a_narrow_gap)
{
    sc_volume volume = cube_volume(41, 3, plate_before_block);
    small_scene s;
    sc_scene scene = {.clip.set_count = 1};
    double sum = 0, squares = 0, variance;
    SC_OWN(sc_image_clear) sc_image image = {0};

    for (int id = 1; id < 3; id++) {
        for (int i = 0; i < 3; i++)
            volume.labels[id].rgb[i] = 120;
    }
    s = make_scene(volume, 0.5);
    s.settings.width_px = s.settings.height_px = 100;
    s.settings.light.occlusion = 0;
    scene.camera = sc_camera_look((sc_vec3){20, 300, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 10);
    image = draw_view(&s, &scene, NULL);
    for (int i = 0; i < 100 * 100; i++) {
        sum += image.rgb[3 * i];
        squares += image.rgb[3 * i] * image.rgb[3 * i];
    }
    variance = squares / 1e4 - sum * sum / 1e8;
    assert_true(variance < 4);
    free_scene(&s);
}

RUN_TESTS(NULL, NULL)
