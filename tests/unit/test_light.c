/* SPDX-License-Identifier: BSD-3-Clause */
/* The effect of light, of opaque edges and of more rays per pixel on a picture. */
#include "check.h"
#include "compare_images.h"

#include "scenes.h"

#include <math.h>

static int brightness(const sc_image *image, int x, int y)
{
    const uint8_t *p = pixel(image, x, y);

    return p[0] + p[1] + p[2];
}

/* A plate with a deep hole in its middle, seen from the front; a pillar stands on its left. */
static int plate(double x, double y, double z)
{
    const double dx = x - 40, dz = z - 40;

    if (y > 20 && y < 44 && fabs(x - 14) < 4 && fabs(z - 40) < 12)
        return 1;
    return y < 20 && (y < 6 || dx * dx + dz * dz > 64);
}

static small_scene plate_scene(double opacity, sc_scene *scene)
{
    const int size[3] = {81, 60, 81};
    const double spacing[3] = {1, 1, 1};
    sc_volume volume = shape_volume(size, spacing, 1, 2, plate);
    small_scene s;

    for (int i = 0; i < 3; i++)
        volume.labels[1].rgb[i] = 200;
    s = make_scene(volume, opacity);
    s.settings.width_px = s.settings.height_px = 81;
    *scene = (sc_scene){.clip.set_count = 1};
    scene->camera = sc_camera_look((sc_vec3){40, 300, 40}, (sc_vec3){40, 20, 40},
                                   (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, 40.5);
    return s;
}

TEST(holes_are_darker_than_open_surfaces)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = plate_scene(1, &scene);
    SC_OWN(sc_image_clear) sc_image with = {0}, without = {0};

    with = draw_view(&s, &scene, NULL);
    s.settings.light.occlusion = 0;
    without = draw_view(&s, &scene, NULL);
    /* a point of the open plate, then the bottom of the hole */
    assert_true(brightness(&with, 20, 10) > brightness(&without, 20, 10) - 30);
    assert_true(brightness(&with, 40, 40) < brightness(&without, 40, 40) - 60);
}

TEST(the_pillar_casts_a_shadow_away_from_the_key_light)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = plate_scene(1, &scene);
    SC_OWN(sc_image_clear) sc_image with = {0}, without = {0};
    int darker_right = 0, darker_left = 0;

    s.settings.light.occlusion = 0;
    without = draw_view(&s, &scene, NULL);
    s.settings.light.shadows = true;
    with = draw_view(&s, &scene, NULL);
    /* seen from the front the pillar stands right of the middle, at 66; light comes from the left
     */
    for (int y = 30; y < 60; y++) {
        for (int x = 0; x < 81; x++) {
            const int less = brightness(&without, x, y) - brightness(&with, x, y);

            darker_right += x > 66 && less > 60;
            darker_left += x < 28 && less > 60;
        }
    }
    assert_true(darker_right > 80 && darker_left < 10);
}

/* The shadow begins at the foot of the pillar, not some way from it. */
TEST(the_shadow_of_the_pillar_begins_at_its_foot)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = plate_scene(1, &scene);
    SC_OWN(sc_image_clear) sc_image with = {0}, without = {0};
    int darker = 0;

    s.settings.light.occlusion = 0;
    without = draw_view(&s, &scene, NULL);
    s.settings.light.shadows = true;
    with = draw_view(&s, &scene, NULL);
    for (int y = 40; y < 50; y++) {
        for (int x = 72; x < 76; x++)
            darker += brightness(&without, x, y) - brightness(&with, x, y) > 100;
    }
    assert_true(darker > 35);
}

TEST(distance_fades_into_the_background)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = plate_scene(1, &scene);
    SC_OWN(sc_image_clear) sc_image with = {0}, without = {0};

    s.settings.background[0] = s.settings.background[1] = s.settings.background[2] = 255;
    without = draw_view(&s, &scene, NULL);
    s.settings.light.depth_cue = 0.8;
    with = draw_view(&s, &scene, NULL);
    /* the plate is far, the top of the pillar near: it changes less */
    assert_true(brightness(&with, 20, 10) > brightness(&without, 20, 10) + 20);
    assert_true(brightness(&with, 20, 10) - brightness(&without, 20, 10) >
                brightness(&with, 66, 40) - brightness(&without, 66, 40) + 10);
}

static small_scene ball_scene(double opacity, sc_scene *scene)
{
    small_scene s = make_scene(cube_volume(41, 2, large_ball), opacity);

    s.settings.width_px = s.settings.height_px = 101;
    *scene = (sc_scene){.clip.set_count = 1};
    scene->camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20},
                                   (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, 20);
    return s;
}

/* A translucent ball is most opaque at its rim, and more so with a larger sc_lighting.edges. */
TEST(translucent_edges_stand_out)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = ball_scene(0.2, &scene);
    SC_OWN(sc_image_clear) sc_image with = {0}, without = {0};

    s.settings.light.method = SC_LIGHT_FLAT;
    s.settings.light.edges = 0;
    without = draw_view(&s, &scene, NULL);
    s.settings.light.edges = 1;
    with = draw_view(&s, &scene, NULL);
    assert_int_equal(brightness(&with, 50, 50), brightness(&without, 50, 50));
    assert_true(brightness(&with, 50 + 36, 50) < brightness(&without, 50 + 36, 50) - 40);
}

TEST(flat_light_shows_plain_colours)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = ball_scene(1, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.settings.light.method = SC_LIGHT_FLAT;
    image = draw_view(&s, &scene, NULL);
    for (int x = 18; x < 84; x++)
        assert_memory_equal(pixel(&image, x, 50), s.volume.labels[1].rgb, 3);
}

/* More rays at edges alone give nearly the same picture as more rays everywhere, with a third of
 * the rays. */
TEST(more_rays_on_edges_alone_are_nearly_as_good_as_everywhere)
{
    SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 1);
    const sc_scene scene = front_view(&s);
    sc_render_stats full, adaptive, single;
    SC_OWN(sc_image_clear) sc_image a = {0}, b = {0}, c = {0};
    image_difference close = {0}, far = {0};

    s.settings.width_px = 360;
    s.settings.height_px = 280;
    s.settings.sampling.samples = 8;
    a = draw_view(&s, &scene, &full);
    s.settings.sampling.everywhere = false;
    b = draw_view(&s, &scene, &adaptive);
    s.settings.sampling.samples = 1;
    c = draw_view(&s, &scene, &single);
    assert_true(compare_images(&a, &b, &close) && compare_images(&a, &c, &far));
    assert_true(close.rms < far.rms / 4);
    assert_true(3 * adaptive.counters.rays < full.counters.rays);
    assert_true(single.counters.rays < adaptive.counters.rays);
}

static int solid(double x, double y, double z)
{
    return 1;
}

/* The shades along an edge of black on white are evenly spaced, as the eye sees them, and more rays
 * on edges alone give the same pixels as more rays everywhere, although the ray through the middle
 * is marched only once. */
TEST(edges_have_even_shades_from_rays_that_are_marched_once)
{
    sc_volume volume = cube_volume(41, 2, solid);
    small_scene s;
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}};
    sc_render_stats full, adaptive, single;
    sc_image a, b;
    int seen[6] = {0};

    for (int i = 0; i < 3; i++)
        volume.labels[1].rgb[i] = 0;
    s = make_scene(volume, 1);
    s.settings.light.method = SC_LIGHT_FLAT;
    s.settings.width_px = s.settings.height_px = 81;
    scene.camera = sc_camera_look((sc_vec3){20, 300, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 12);
    scene.clip.planes[0].normal = sc_vec3_unit((sc_vec3){0.2371, 0, -1});
    scene.clip.planes[0].offset_mm =
        -sc_vec3_dot(scene.clip.planes[0].normal, (sc_vec3){20, 20, 20.1});
    s.settings.sampling.samples = 5;
    a = draw_view(&s, &scene, &full);
    s.settings.sampling.everywhere = false;
    b = draw_view(&s, &scene, &adaptive);
    s.settings.sampling.samples = 1;
    for (int i = 0; i < 81 * 81; i++) {
        const int level = a.rgb[3 * i], k = (level + 25) / 51;

        assert_in_range(level, 51 * k - (k == 0 ? 0 : 10), 51 * k + (k == 5 ? 0 : 10));
        assert_int_equal(b.rgb[3 * i], level);
        seen[k]++;
    }
    for (int k = 0; k < 6; k++)
        assert_true(seen[k] > 0);
    sc_image_clear(&b);
    b = draw_view(&s, &scene, &single);
    assert_int_equal((adaptive.counters.rays - single.counters.rays) % 4, 0);
    assert_true(adaptive.counters.rays < full.counters.rays / 2);
    sc_image_clear(&a);
    sc_image_clear(&b);
    free_scene(&s);
}

static int halves(double x, double y, double z)
{
    return large_ball(x, y, z) ? 1 + (z > 20.2) : 0;
}

/* On a cut face there is a line between two tissues, as wide as set, and no other line. */
TEST(cut_faces_have_outlines_where_tissues_meet)
{
    sc_volume volume = cube_volume(41, 3, halves);
    small_scene s;
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}};
    SC_OWN(sc_image_clear) sc_image image = {0};
    int dark = 0;

    for (int id = 1; id < 3; id++) {
        for (int i = 0; i < 3; i++)
            volume.labels[id].rgb[i] = 200;
    }
    s = make_scene(volume, 1);
    s.settings.width_px = s.settings.height_px = 400; /* ten pixels a voxel */
    s.settings.cap_outline = 0.8;
    scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 20);
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 20.25};
    image = draw_view(&s, &scene, NULL);
    for (int y = 150; y < 250; y++)
        dark += brightness(&image, 200, y) < 450;
    assert_in_range(dark, 5, 11);
    assert_int_equal(brightness(&image, 200, 120), brightness(&image, 200, 280));
    free_scene(&s);
}

/* A cut face is lit by the lamps, and is darker along its rim, unless the frame is unlit. */
TEST(cut_faces_are_lit_and_have_a_rim)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = ball_scene(1, &scene);
    SC_OWN(sc_image_clear) sc_image lit = {0}, dim = {0}, flat = {0};

    scene.clip.count = 1;
    scene.clip.sets[0] = 1;
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 20.25};
    lit = draw_view(&s, &scene, NULL);
    s.settings.light.key = 0.2;
    dim = draw_view(&s, &scene, NULL);
    s.settings.light.method = SC_LIGHT_FLAT;
    flat = draw_view(&s, &scene, NULL);
    assert_true(brightness(&lit, 50, 50) > brightness(&dim, 50, 50) + 60);
    assert_true(brightness(&lit, 50, 50) > brightness(&lit, 50 + 35, 50) + 20);
    assert_int_equal(brightness(&flat, 50, 50), brightness(&flat, 50 + 35, 50));
}

/* A thick block on the left, a wall four voxels thick on the right. */
static int block_and_wall(double x, double y, double z)
{
    return y > 4 && y < 56 && z > 4 && z < 56 && ((x > 4 && x < 34.5) || (x > 45.5 && x < 49.5));
}

/* On a cut face a thin wall keeps its colour: it is as bright in its middle as thick tissue is far
 * from its border, while that has a rim. */
TEST(thin_walls_keep_their_colour_on_cut_faces)
{
    SC_OWN(free_scene)
    small_scene s = make_scene(cube_volume(61, 2, block_and_wall), 1);
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}};
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.settings.width_px = s.settings.height_px = 122; /* two pixels a voxel */
    scene.camera = sc_camera_look((sc_vec3){30, 30, 200}, (sc_vec3){30, 30, 30}, (sc_vec3){0, 1, 0},
                                  SC_ORTHOGRAPHIC, 30.5);
    scene.clip.planes[0] = (sc_plane){{0, 0, -1}, 30.25};
    image = draw_view(&s, &scene, NULL);
    for (int x = 94; x < 98; x++)
        assert_true(brightness(&image, x, 60) > brightness(&image, 40, 60) - 6);
    assert_true(brightness(&image, 69, 60) < brightness(&image, 40, 60) - 20);
}

/* A block with a flat border across x, of which a picture shows 17 voxels. */
static int coarse_block(double x, double y, double z)
{
    return x < 20.2 && x > 1 && y > 1 && y < 31 && z > 1 && z < 31;
}

/* @return how many pixels of a cut through the coarse block are darker than its middle, on the way
 * from that to the border across x, in a picture of so many pixels. */
static int rim_px(int picture_px)
{
    SC_OWN(free_scene)
    small_scene s = make_scene(cube_volume(33, 2, coarse_block), 1);
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}};
    SC_OWN(sc_image_clear) sc_image image = {0};
    int middle, begin = picture_px / 10, end = begin, dark = 0;

    s.settings.width_px = s.settings.height_px = picture_px;
    scene.camera = sc_camera_look((sc_vec3){16, 16, 100}, (sc_vec3){16, 16, 16}, (sc_vec3){0, 1, 0},
                                  SC_ORTHOGRAPHIC, 8.5);
    scene.clip.planes[0] = (sc_plane){{0, 0, -1}, 16.25};
    image = draw_view(&s, &scene, NULL);
    middle = brightness(&image, begin, picture_px / 2);
    while (end < picture_px && brightness(&image, end, picture_px / 2) > 340 &&
           brightness(&image, end, picture_px / 2) < 3 * 255)
        end++; /* the wall below, which may be seen in a pixel, is darker than the rim */
    assert_in_range(end, picture_px * 7 / 10, picture_px * 8 / 10);
    for (int x = begin; x < end; x++)
        dark += brightness(&image, x, picture_px / 2) < middle - 8;
    return dark;
}

/* Where voxels are large in the picture, the rim of a cut is as wide as the picture asks, and not
 * as voxels are: the same share of a small picture and of a large one. */
TEST(rims_follow_the_picture_where_voxels_are_large)
{
    assert_in_range(rim_px(400), 2, 5);
    assert_in_range(rim_px(1000), 6, 13);
}

static int bar(double x, double y, double z)
{
    return (x - 20) * (x - 20) + (z - 20) * (z - 20) < 144;
}

/* Where tissue is cut off by the border of the volume there is a flat face with a sharp rim, for
 * both surfaces. */
TEST(tissue_at_the_border_of_the_volume_ends_in_a_flat_face)
{
    const float inside[3] = {21, 41.45f, 32.3f}, outside[3] = {21, 41.55f, 21};
    const sc_surface surfaces[2] = {SC_SURFACE_SMOOTH, SC_SURFACE_VOXEL};

    for (int i = 0; i < 2; i++) {
        SC_OWN(free_scene) small_scene s = make_scene(cube_volume(41, 2, bar), 1);
        sc_scene scene = {.clip.set_count = 1};
        SC_OWN(sc_image_clear) sc_image image = {0};

        s.settings.width_px = s.settings.height_px = 101;
        s.settings.surface = surfaces[i];
        s.settings.light.occlusion = 0;
        scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20},
                                      (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, 20);
        image = draw_view(&s, &scene, NULL);
        for (int x = 50; x < 50 + 28 - 9 * i; x++)
            assert_in_range(brightness(&image, x, 50), brightness(&image, 50, 50) - 3,
                            brightness(&image, 50, 50) + 3);
        assert_int_equal(sc_kernel_owner(&s.prepared.view, inside), 1);
        assert_int_equal(sc_kernel_owner(&s.prepared.view, outside), 0);
    }
}

/* A large ball whose surface meets the border of the volume at 22 degrees. */
static int dome(double x, double y, double z)
{
    return (x - 20) * (x - 20) + (y - 14) * (y - 14) + (z - 20) * (z - 20) < 28.6 * 28.6;
}

/* A face at the border of the volume is darker along its rim, at which a flat surface begins, and
 * nowhere else, as far as there is occlusion. */
TEST(faces_at_the_border_of_the_volume_have_a_rim)
{

    for (int occlusion = 0; occlusion < 2; occlusion++) {
        SC_OWN(free_scene) small_scene s = make_scene(cube_volume(41, 2, dome), 1);
        sc_scene scene = {.clip.set_count = 1};
        SC_OWN(sc_image_clear) sc_image image = {0};
        int middle;

        s.settings.width_px = s.settings.height_px = 101;
        s.settings.light.occlusion = occlusion;
        scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20},
                                      (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, 20);
        image = draw_view(&s, &scene, NULL);
        middle = brightness(&image, 50, 50);
        for (int direction = 0; direction < 4; direction++) {
            const int x = direction == 0 ? 1 : direction == 1 ? -1 : 0;
            const int y = direction == 2 ? 1 : direction == 3 ? -1 : 0;
            int darkest = middle;

            for (int r = 0; r < 28; r++) {
                const int here = brightness(&image, 50 + r * x, 50 + r * y);

                /* The face ends 27 pixels from its middle, and its edge is round by a voxel. */
                darkest = here < darkest && (occlusion || r < 25) ? here : darkest;
                if (r < 18)
                    assert_in_range(here, middle - 3, middle + 3);
            }
            if (occlusion)
                assert_true(darkest < middle - 60);
            else
                assert_true(darkest >= middle - 3);
        }
    }
}

/* A camera inside an opaque tissue sees its walls from within: without a clip plane there is no cut
 * face. */
TEST(a_camera_inside_a_tissue_sees_its_walls)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = ball_scene(1, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    scene.camera = sc_camera_look((sc_vec3){20, 20, 20}, (sc_vec3){20, 0, 20}, (sc_vec3){0, 0, 1},
                                  SC_PERSPECTIVE, 0.5);
    image = draw_view(&s, &scene, NULL);
    for (int y = 0; y < 101; y += 10) {
        for (int x = 0; x < 101; x += 10)
            assert_true(brightness(&image, x, y) < 740);
    }
}

/* Two half-opaque black surfaces on white are about as dark as where levels of pixels are blended,
 * 64, and not the 137 of linear light; with one kernel as with another, and with more rays. */
TEST(half_opaque_tissues_are_not_washed_out)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = plate_scene(0.5, &scene);

    s.settings.light = (sc_lighting){.method = SC_LIGHT_FLAT};
    memset(s.tissues[1].rgb_linear, 0, sizeof s.tissues[1].rgb_linear);
    for (int n = 0; n < 4; n++) {
        SC_OWN(sc_image_clear) sc_image image = {0};

        s.settings.skip = n & 1 ? SC_SKIP_LEAP : SC_SKIP_NONE;
        s.settings.sampling.samples = n & 2 ? 4 : 1;
        image = draw_view(&s, &scene, NULL);
        assert_true(abs(pixel(&image, 20, 10)[0] - 71) <= 1);
    }
}

RUN_TESTS(NULL, NULL)
