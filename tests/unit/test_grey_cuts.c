/* SPDX-License-Identifier: BSD-3-Clause */
/* Grey volumes on cut faces and slices: where their values are seen, and that all ways to draw give
 * the same bits. */
#include "check.h"

#include "scenes.h"

#include <math.h>

enum { SIDE = 40, VOXELS = SIDE * SIDE * SIDE };

/* A turned, sheared and unevenly spaced grid. */
static const sc_affine oblique = {
    {{0.9, -0.35, 0.1, 3}, {0.3, 1.1, -0.2, -7}, {-0.15, 0.25, 1.3, -5}}};

/* The value at a point in mm: linear, so that interpolation has no error. */
static double ramp(sc_vec3 p)
{
    return 100 + 20 * p.x - 13 * p.y + 7 * p.z;
}

/* A grey volume of the ramp. @param codes room for VOXELS. */
static sc_grey ramp_grey(const sc_affine *to_ras_mm, uint16_t *codes)
{
    sc_grey grey = {.size = {SIDE, SIDE, SIDE},
                    .to_ras_mm = *to_ras_mm,
                    .low = -3000,
                    .per_code = 0.1,
                    .codes = codes};

    for (int i = 0; i < VOXELS; i++) {
        const sc_vec3 at = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        const double value = ramp(sc_affine_point(to_ras_mm, at));

        codes[i] = (uint16_t)((value - grey.low) / grey.per_code + 0.5);
    }
    return grey;
}

/* @return a march that knows a grey volume alone, whose tones are places in the window. @param
 * from_grid grid coordinates to mm. */
static sc_march march_of(const sc_grey *grey, const sc_affine *from_grid, double black,
                         double white, sc_march_grey *g)
{
    const sc_march march = {.cut_faces.grey = g};
    sc_affine to_grey, map;

    assert_true(sc_affine_invert(&grey->to_ras_mm, &to_grey));
    map = sc_affine_compose(&to_grey, from_grid);
    *g = (sc_march_grey){.codes = grey->codes,
                         .size = {SIDE, SIDE, SIDE},
                         .black = (float)((black - grey->low) / grey->per_code),
                         .white_less = (float)(grey->per_code / (white - black))};
    for (int i = 0; i <= SC_GREY_STEPS; i++)
        g->tones[i] = (float)i / SC_GREY_STEPS;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++)
            g->from_grid[i][j] = (float)map.m[i][j];
    }
    return march;
}

TEST(a_ramp_is_found_at_its_place_in_an_oblique_grid)
{
    static uint16_t codes[VOXELS];
    const sc_affine from_grid = {{{0, 0.7, 0, -4}, {-0.8, 0, 0, 30}, {0, 0, 1.1, 2}}};
    const sc_grey grey = ramp_grey(&oblique, codes);
    sc_march_grey g;
    const sc_march march = march_of(&grey, &from_grid, -500, 1500, &g);
    sc_affine to_voxel;
    uint64_t seed = 5;
    int inside = 0;

    assert_true(sc_affine_invert(&oblique, &to_voxel));
    for (int n = 0; n < 20000; n++) {
        const float point[3] = {(float)random_real(&seed, -10, 60),
                                (float)random_real(&seed, -10, 60),
                                (float)random_real(&seed, -10, 60)};
        const sc_vec3 mm = sc_affine_point(&from_grid, (sc_vec3){point[0], point[1], point[2]});
        const sc_vec3 at = sc_affine_point(&to_voxel, mm);
        const double least = fmin(at.x, fmin(at.y, at.z)), most = fmax(at.x, fmax(at.y, at.z));
        const double place = (ramp(mm) + 500) / 2000;
        float tone[3] = {-1, -1, -1};
        const bool is_in = sc_kernel_grey(&march, point, 0, tone);

        if (least > 0 && most < SIDE - 1) {
            assert_true(is_in);
            assert_near(tone[0], place < 0 ? 0 : place > 1 ? 1 : place, 1e-3);
            inside++;
        }
        if (least < -0.501 || most > SIDE - 0.499)
            assert_false(is_in);
        if (least > -0.499 && most < SIDE - 0.501)
            assert_true(is_in);
    }
    assert_true(inside > 1000);
}

TEST(a_grey_volume_may_be_one_voxel_thick)
{
    const sc_affine from_grid = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    uint16_t codes[3] = {0, 100, 200};
    const float points[2][3] = {{0, 1.5f, 0}, {0.4f, 2.4f, -0.4f}}, beyond[3] = {0.6f, 1, 0};
    sc_march_grey g = {.codes = codes, .size = {1, 3, 1}, .white_less = 1 / 200.0f};
    const sc_march march = {.cut_faces.grey = &g};
    float tone[3];

    for (int i = 0; i <= SC_GREY_STEPS; i++)
        g.tones[i] = (float)i / SC_GREY_STEPS;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++)
            g.from_grid[i][j] = (float)from_grid.m[i][j];
    }
    assert_true(sc_kernel_grey(&march, points[0], 0, tone));
    assert_near(tone[1], 0.75, 1e-6);
    assert_true(sc_kernel_grey(&march, points[1], 0, tone));
    assert_near(tone[1], 1, 1e-6);
    assert_false(sc_kernel_grey(&march, beyond, 0, tone));
}

static int ball(double x, double y, double z)
{
    return (x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 20) * (z - 20) < 100;
}

/* A slice, on and beside the tissue, and a cut face without shading show each value where it is. */
TEST(pictures_show_values_at_their_places)
{
    static uint16_t codes[VOXELS];
    const int size[3] = {41, 41, 41};
    const double spacing[3] = {1, 1, 1};
    const sc_affine coarse = {{{1.5, 0, 0, -9}, {0, 1.5, 0, -9}, {0, 0, 1.5, -9}}};
    const sc_grey grey = ramp_grey(&coarse, codes);
    SC_OWN(free_scene) small_scene s = make_scene(shape_volume(size, spacing, 1, 2, ball), 1);
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}};

    s.settings.width_px = s.settings.height_px = 100;
    s.settings.light = (sc_lighting){.method = SC_LIGHT_FLAT};
    s.settings.grey = &grey;
    s.settings.grey_look = (sc_grey_look){{ramp((sc_vec3){20, 20, 20}), 400}, 1, 1, 0};
    scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 25);
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 20};
    for (int slice = 0; slice < 2; slice++) {
        SC_OWN(sc_image_clear) sc_image image = {0};
        int seen = 0;

        scene.slice = slice;
        image = draw_view(&s, &scene, NULL);
        for (int y = 0; y < 100; y++) {
            for (int x = 0; x < 100; x++) {
                const sc_vec3 p = sc_vec3_along(
                    sc_vec3_along((sc_vec3){20, 20, 20}, (x + 0.5 - 50) / 2, scene.camera.right),
                    (50 - y - 0.5) / 2, scene.camera.up);
                const double place = (ramp(p) - ramp((sc_vec3){20, 20, 20})) / 400 + 0.5;
                const double off = hypot(p.x - 20, p.z - 20);
                const uint8_t *rgb = image.rgb + (y * 100 + x) * 3;

                if (off > (slice ? 23 : 9)) /* of the cut face that of the ball alone */
                    continue;
                seen++;
                assert_near(rgb[0], 255 * fmax(0, fmin(place, 1)), 1.25);
                assert_int_equal(rgb[0], rgb[1]);
                assert_int_equal(rgb[0], rgb[2]);
            }
        }
        assert_true(seen > 900);
    }
}

static void expect_same(sc_image *a, sc_image *b)
{
    assert_memory_equal(a->rgb, b->rgb, sc_image_bytes(a));
}

TEST(the_share_mixes_colours_and_ends_at_the_image)
{
    static uint16_t codes[VOXELS];
    const int size[3] = {41, 41, 41};
    const double spacing[3] = {1, 1, 1};
    sc_affine beside = {{{0.5, 0, 0, 20}, {0, 0.5, 0, 10}, {0, 0, 0.5, 10}}}; /* x from 20 mm on */
    const sc_grey grey = ramp_grey(&beside, codes);
    SC_OWN(free_scene) small_scene s = make_scene(shape_volume(size, spacing, 1, 2, ball), 1);
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}};
    SC_OWN(sc_image_clear) sc_image without = {0}, none = {0}, mixed = {0};

    scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 20);
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 20.25};
    without = draw_view(&s, &scene, NULL);
    s.settings.grey = &grey;
    s.settings.grey_look = (sc_grey_look){{300, 600}, 0, 0, 0};
    none = draw_view(&s, &scene, NULL);
    expect_same(&without, &none);
    s.settings.grey_look.caps = 0.5;
    mixed = draw_view(&s, &scene, NULL);
    for (int x = 0; x < 90; x++) {
        const double right_mm = 20 + (x + 0.5 - 45) / 35 * 20 * scene.camera.right.x;
        const uint8_t *a = without.rgb + (35 * 90 + x) * 3, *b = mixed.rgb + (35 * 90 + x) * 3;

        if (right_mm < 19.5)
            assert_memory_equal(a, b, 3);
        else if (right_mm > 20 && right_mm < 29)
            assert_memory_not_equal(a, b, 3);
    }
}

/* Red, and green, each half of the volume. */
static int halves(double x, double y, double z)
{
    return x < 20 ? 1 : 2;
}

/* A line between tissues is dark on their colours, and has these on the image. */
TEST(lines_on_the_image_have_the_colours_of_tissues)
{
    static uint16_t codes[VOXELS];
    static const uint8_t colors[3][3] = {{0}, {200, 0, 0}, {0, 200, 0}};
    const int size[3] = {41, 41, 41};
    const double spacing[3] = {1, 1, 1};
    const sc_affine same = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    const sc_grey grey = ramp_grey(&same, codes);
    sc_volume volume = shape_volume(size, spacing, 1, 3, halves);
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}, .slice = true};
    small_scene s;

    for (int id = 1; id < 3; id++)
        memcpy(volume.labels[id].rgb, colors[id], 3);
    s = make_scene(volume, 1);
    s.settings.width_px = s.settings.height_px = 200;
    s.settings.cap_outline = 1;
    scene.camera = sc_camera_look((sc_vec3){19.5, 100, 20}, (sc_vec3){19.5, 20, 20},
                                  (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, 10);
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 20.25};
    for (int share = 0; share < 2; share++) {
        SC_OWN(sc_image_clear) sc_image image = {0};
        const int toward_x = scene.camera.right.x > 0 ? 1 : -1;

        s.settings.grey = share ? &grey : NULL;
        s.settings.grey_look = (sc_grey_look){{300, 600}, 0, 1, 0};
        image = draw_view(&s, &scene, NULL);
        for (int id = 1; id < 3; id++) { /* 0.15 mm from the border, which lies at 19.5 mm */
            const int x = 100 + (id == 1 ? -2 : 1) * toward_x - (toward_x < 0);
            const uint8_t *rgb = image.rgb + (100 * 200 + x) * 3;

            if (share)
                assert_near(rgb[id - 1], 200, 25);
            else
                assert_true(rgb[id - 1] < 130 && rgb[id - 1] > 60);
            assert_true(rgb[2 - id] < 40 && rgb[2] < 40);
        }
    }
    free_scene(&s);
}

/* Cut faces of translucent tissues in two clip sets, and slices; with a background and without. */
TEST(all_ways_to_draw_give_the_same_bits)
{
    static uint16_t codes[48 * 33 * 50];
    sc_grey grey = {.size = {48, 33, 50}, .codes = codes};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_grey(&quiet, phantom, 2, &grey));
    for (int n = 0; n < 8; n++) {
        SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), n % 2 ? 0.4 : 1);
        sc_scene scene = front_view(&s);
        SC_OWN(sc_image_clear) sc_image plain = {0};

        s.settings.surface = n & 2 ? SC_SURFACE_VOXEL : SC_SURFACE_SMOOTH;
        s.settings.transparent = n & 1;
        s.settings.sampling.everywhere = n & 1;
        s.settings.sampling.samples = 3;
        s.settings.cap_outline = n & 4 ? 0.8 : 0;
        s.settings.light.depth_cue = n & 1 ? 0.4 : 0;
        s.settings.grey = &grey;
        s.settings.grey_look = (sc_grey_look){{120, 700}, 0.7, 0.5, 0};
        scene.clip.count = 1;
        scene.clip.planes[0] = (sc_plane){scene.camera.forward, 0};
        scene.clip.set_count = 2;
        scene.clip.sets[0] = scene.clip.sets[1] = 1;
        s.tissues[10].clip_set = 1;
        if (n & 4) {
            scene.camera = sc_camera_look((sc_vec3){0, 200, 0}, (sc_vec3){0}, (sc_vec3){0, 0, 1},
                                          SC_ORTHOGRAPHIC, 90);
            scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 0};
            scene.slice = true;
        }
        plain = draw_by_all_kernels(&s, &scene);
    }
}

RUN_TESTS(NULL, NULL)
