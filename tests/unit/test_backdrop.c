/* SPDX-License-Identifier: BSD-3-Clause */
/* Grey volumes as a translucent backdrop: how opaque they are, what cuts and hides them, and that
 * all kernels and all ways to draw give the same bits. */
#include "check.h"

#include "scenes.h"

#include <math.h>

enum { SIDE = 40, VOXELS = SIDE * SIDE * SIDE };

static int ball(double x, double y, double z)
{
    return (x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 20) * (z - 20) < 36;
}

/* A scene of a ball in the middle of 41 mm, seen from the front without light. */
static small_scene ball_scene(double opacity)
{
    small_scene s = make_scene(cube_volume(41, 2, ball), opacity);

    s.settings.width_px = s.settings.height_px = 50;
    s.settings.light = (sc_lighting){.method = SC_LIGHT_FLAT};
    memset(s.settings.background, 0, sizeof s.settings.background);
    return s;
}

static sc_scene from_front(void)
{
    sc_scene scene = {.clip.set_count = 1};

    scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 25);
    return scene;
}

/* @return a pixel of the picture, at x and z in mm. */
static const uint8_t *pixel_at(const sc_image *image, const sc_scene *scene, double x, double z)
{
    const int column = (int)floor(25 + (x - 20) * scene->camera.right.x),
              row = (int)floor(25 - (z - 20));

    return image->rgb + (row * image->width_px + column) * (int)sc_pixel_bytes(image->alpha);
}

/* Let the grey volume have the value @p code in all voxels of @p spacing_mm, from 5 to 35 mm. */
static sc_grey even_grey(double spacing_mm, uint16_t code, uint16_t *codes)
{
    const int side = (int)(30 / spacing_mm + 0.5);
    const double first = 5 + spacing_mm / 2;
    const sc_grey grey = {.size = {side, side, side},
                          .to_ras_mm = {{{spacing_mm, 0, 0, first},
                                         {0, spacing_mm, 0, first},
                                         {0, 0, spacing_mm, first}}},
                          .per_code = 1,
                          .codes = codes};

    assert_true(side * side * side <= VOXELS);
    for (int i = 0; i < side * side * side; i++)
        codes[i] = code;
    return grey;
}

/* The tone of the backdrop through @p mm of a place in the window: the square root of linear light.
 */
static double tone_of(double place, double opacity, double mm)
{
    return sqrt(sc_srgb_to_linear(place)) * (1 - pow(1 - opacity, place * mm / 10));
}

/* The level of a pixel of this tone. */
static int level_of(double tone)
{
    sc_srgb_table table;

    sc_srgb_table_init(&table);
    return sc_srgb_level(&table, (float)(tone * tone));
}

/* Draw an even backdrop, of which white is so opaque, and compare two pixels, one beside it. */
static void expect_opacity(double spacing_mm, double place, double opacity)
{
    static uint16_t codes[VOXELS];
    const sc_grey grey = even_grey(spacing_mm, (uint16_t)(4000 * place), codes);
    SC_OWN(free_scene) small_scene s = ball_scene(1);
    const sc_scene scene = from_front();
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.settings.grey = &grey;
    s.settings.grey_look = (sc_grey_look){{2000, 4000}, 0, 0, opacity};
    image = draw_view(&s, &scene, NULL);
    assert_near(pixel_at(&image, &scene, 8, 8)[0], level_of(tone_of(place, opacity, 30)), 1);
    assert_int_equal(pixel_at(&image, &scene, 2, 20)[0], 0);
}

TEST(the_opacity_is_that_of_ten_millimetres_whatever_the_voxels)
{
    static const double spacings[] = {1, 2.5, 0.9375};

    for (size_t n = 0; n < SC_COUNT_OF(spacings); n++) {
        for (int i = 1; i <= 4; i++)
            expect_opacity(spacings[n], i / 4.0, 0.15 * (double)(n + 1));
    }
}

TEST(planes_cut_the_backdrop)
{
    static uint16_t codes[VOXELS];
    const sc_grey grey = even_grey(1, 4000, codes);

    for (int n = 0; n < 3; n++) {
        SC_OWN(free_scene) small_scene s = ball_scene(1);
        sc_scene scene = from_front();
        SC_OWN(sc_image_clear) sc_image image = {0};
        double left_mm[3] = {20, 12, 30 - 12}; /* one plane; what two keep; all but a slab */

        scene.clip.count = n ? 2 : 1;
        scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 25}; /* y below 25 mm */
        scene.clip.planes[1] = (sc_plane){{0, 1, 0}, -13}; /* y above 13 mm */
        if (n == 2) { /* what both remove: y from 13 to 25 mm */
            scene.clip.mode = SC_CLIP_CUT;
            scene.clip.planes[0] = (sc_plane){{0, 1, 0}, -25};
            scene.clip.planes[1] = (sc_plane){{0, -1, 0}, 13};
        }
        scene.clip.sets[0] = n ? 3 : 1;
        s.settings.grey = &grey;
        s.settings.grey_look = (sc_grey_look){{2000, 4000}, 0, 0, 0.2};
        image = draw_view(&s, &scene, NULL);
        assert_near(pixel_at(&image, &scene, 8, 8)[1], level_of(tone_of(1, 0.2, left_mm[n])), 1);
    }
}

/* An opaque tissue hides all of the backdrop, also what is before it; behind a translucent one it
 * shows by what that lets through. Slices do not show it, and 0 is the same as none. */
TEST(tissues_stand_before_the_backdrop)
{
    static uint16_t codes[VOXELS];
    const sc_grey grey = even_grey(1, 4000, codes);

    for (int n = 0; n < 2; n++) {
        SC_OWN(free_scene) small_scene s = ball_scene(n ? 0.3 : 1);
        sc_scene scene = from_front();
        sc_image without = draw_view(&s, &scene, NULL), with, none;
        const uint8_t *a = pixel_at(&without, &scene, 20, 20), *b;
        const double through = n ? 0.7 * 0.7 : 0; /* it is entered and left */

        s.settings.grey = &grey;
        s.settings.grey_look = (sc_grey_look){{2000, 4000}, 0, 0, 0.25};
        with = draw_view(&s, &scene, NULL);
        b = pixel_at(&with, &scene, 20, 20);
        for (int c = 0; c < 3; c++)
            assert_near(
                b[c],
                level_of(sqrt(sc_srgb_to_linear(a[c] / 255.0)) + through * tone_of(1, 0.25, 30)),
                1);
        scene.has_look = true;
        scene.look.light = s.settings.light;
        none = draw_view(&s, &scene, NULL);
        assert_memory_equal(none.rgb, without.rgb, sc_image_bytes(&none));
        sc_image_clear(&with);
        sc_image_clear(&none);
        sc_image_clear(&without);
    }
}

/* What the backdrop covers of a picture without a background, and that depth cueing thins it. */
TEST(a_transparent_picture_is_covered_by_the_backdrop)
{
    static uint16_t codes[VOXELS];
    const sc_grey grey = even_grey(1, 4000, codes);
    int covers[2];

    for (int cue = 0; cue < 2; cue++) {
        SC_OWN(free_scene) small_scene s = ball_scene(1);
        const sc_scene scene = from_front();
        SC_OWN(sc_image_clear) sc_image image = {0};

        s.settings.transparent = true;
        s.settings.light.depth_cue = cue;
        s.settings.grey = &grey;
        s.settings.grey_look = (sc_grey_look){{2000, 4000}, 0, 0, 0.2};
        image = draw_view(&s, &scene, NULL);
        assert_near(pixel_at(&image, &scene, 8, 8)[0], 255, 1);
        covers[cue] = pixel_at(&image, &scene, 8, 8)[3];
    }
    assert_near(covers[0], 255 * tone_of(1, 0.2, 30), 1);
    assert_true(covers[1] < covers[0] - 40 && covers[1] > 10);
}

/* Codes in which much is empty: noise in some blocks, less of it in others, 0 elsewhere. */
static void sparse_codes(uint64_t *seed, uint16_t *codes, const int size[3])
{
    for (int z = 0; z < size[2]; z++) {
        for (int y = 0; y < size[1]; y++) {
            for (int x = 0; x < size[0]; x++) {
                const int block = (x / 7 + 3 * (y / 5) + 5 * (z / 6)) % 11;
                const uint16_t noise = (uint16_t)(random_bits(seed) >> 48);

                *codes++ = block == 0 ? noise : block == 1 ? noise / 3 : 0;
            }
        }
    }
}

/* Cut faces, wedges, perspective and depth cue; a grid that is turned, thin ones, and values that
 * fall as codes rise; a narrow window, at whose ends sums are rounded. */
TEST(all_ways_to_draw_give_the_same_bits)
{
    static const int sizes[4][3] = {{33, 40, 29}, {2, 40, 33}, {31, 1, 1}, {1, 30, 30}};
    static uint16_t codes[VOXELS];
    uint64_t seed = 7;

    for (int n = 0; n < 16; n++) {
        SC_OWN(free_scene) small_scene s = ball_scene(n & 1 ? 0.3 : 1);
        sc_scene scene = from_front();
        sc_grey grey = {
            .to_ras_mm = {{{0.9, -0.35, 0.1, 3}, {0.3, 1.1, -0.2, -7}, {-0.15, 0.25, 1.3, -5}}},
            .per_code = n & 4 ? -1 : 1,
            .codes = codes};
        SC_OWN(sc_image_clear) sc_image plain = {0};

        memcpy(grey.size, sizes[n / 4], sizeof grey.size);
        sparse_codes(&seed, codes, grey.size);
        s.settings.surface = n & 2 ? SC_SURFACE_VOXEL : SC_SURFACE_SMOOTH;
        s.settings.transparent = n & 1;
        s.settings.light.depth_cue = n & 2 ? 0.4 : 0;
        s.settings.grey = &grey;
        s.settings.grey_look =
            (sc_grey_look){{n & 4 ? -30000 : 30000, n & 2 ? 1 : 50000}, 0.5, 0, 0.4};
        if (n & 1)
            scene.camera = sc_camera_look((sc_vec3){22, 60, 31}, (sc_vec3){20, 20, 20},
                                          (sc_vec3){0, 0, 1}, SC_PERSPECTIVE, 0.5);
        scene.clip.count = n & 2 ? 2 : 0;
        scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 25};
        scene.clip.planes[1] = (sc_plane){sc_vec3_unit((sc_vec3){1, 1, 0.2}), -25};
        scene.clip.mode = n & 1 ? SC_CLIP_CUT : SC_CLIP_KEEP;
        scene.clip.sets[0] = n & 2 ? 3 : 0;
        plain = draw_by_all_kernels(&s, &scene);
    }
}

/* Fill in a ray through or beside the box of the grey volume, often along an axis. */
static sc_backdrop_ray random_ray(uint64_t *seed, const int size[3])
{
    sc_backdrop_ray ray = {.base_mm = (float)random_real(seed, 0, 50)};
    const int axis = (int)random_real(seed, 0, 6);
    double at = 0;

    for (int i = 0; i < 3; i++) {
        ray.origin[i] = (float)random_real(seed, -0.5, size[i] - 0.5);
        ray.direction[i] = (float)random_real(seed, -1, 1);
        if (axis < 3)
            ray.direction[i] = i == axis ? -1.0f : 0;
        if (random_real(seed, 0, 1) < 0.2)
            ray.origin[i] = floorf(ray.origin[i]);
    }
    ray.stretches = (int)random_real(seed, 0, 3);
    for (int k = 0; k < ray.stretches; k++) {
        ray.begin_mm[k] = (float)(at += random_real(seed, 0, 8));
        ray.end_mm[k] = (float)(at += random_real(seed, 0, 30));
    }
    return ray;
}

/* Set what a wide kernel knows of empty bricks. @param limit codes from here on are seen. */
static void set_distances(sc_march_backdrop *b, sc_team *team, uint16_t limit)
{
    const int *size = b->grey->size;
    SC_OWN(sc_free_at) uint64_t *masks = NULL;
    uint8_t *distances;
    int framed[3];

    for (int i = 0; i < 3; i++)
        b->bricks[i] = size[i] / SC_BRICK + 1;
    sc_framed_size(b->bricks, framed);
    assert_ok(SC_ZALLOC(&quiet, sc_brick_count(framed), &masks));
    for (int i = 0; i < size[0] * size[1] * size[2]; i++) {
        const int x = i % size[0], y = i / size[0] % size[1], z = i / size[0] / size[1];

        for (int k = 0; k < 8 && b->grey->codes[i] >= limit;
             k++) { /* of all cells that it bounds */
            const int cx = x - (k & 1), cy = y - (k >> 1 & 1), cz = z - (k >> 2);

            if (cx >= 0 && cy >= 0 && cz >= 0)
                masks[sc_framed_index(sc_framed_row(b->bricks), sc_framed_layer(b->bricks),
                                      cx / SC_BRICK, cy / SC_BRICK, cz / SC_BRICK)] = 1;
        }
    }
    assert_ok(sc_brick_distances(&quiet, team, b->bricks, masks, &distances));
    b->distances = distances;
}

TEST(wide_kernels_do_as_the_plain_one)
{
    enum { RAYS = 50021, BATCH = 243 };
    static const int size[3] = {37, 30, 33};
    static uint16_t codes[37 * 30 * 33];
    static sc_march_backdrop b;
    sc_march_grey g = {
        .codes = codes, .size = {37, 30, 33}, .black = 2000, .white_less = 1 / 40000.0f};
    sc_backdrop_fn *plain = sc_backdrop_find(SC_SKIP_NONE, size, NULL);
    uint64_t seed = 11, lit = 0;
    sc_team *team;

    assert_ok(sc_team_open(&quiet, NULL, 2, NULL, &team));
    sparse_codes(&seed, codes, size);
    b = (sc_march_backdrop){
        .grey = &g, .step_mm = 0.7f, .cue = 0.3f, .cue_near_mm = 10, .cue_per_mm = 0.02f};
    for (int i = 1; i <= SC_BACKDROP_STEPS; i++) {
        b.alphas[i] = 0.2f * (float)i / SC_BACKDROP_STEPS;
        b.tones[i] = b.alphas[i] * (float)i / SC_BACKDROP_STEPS;
    }
    set_distances(&b, team, 2000);
    for (int left = RAYS; left > 0; left -= BATCH) {
        const size_t count = (size_t)(left < BATCH ? left : BATCH);
        sc_backdrop_ray rays[BATCH];
        sc_backdrop_light expected[BATCH], found[BATCH];

        for (size_t i = 0; i < count; i++)
            rays[i] = random_ray(&seed, size);
        plain(&b, rays, count, expected);
        for (size_t i = 0; i < count; i++)
            lit += expected[i].transmittance < 0.9f;
        for (int i = 1; sc_cpu_names[i]; i++) {
            if (!sc_cpu_has(sc_cpu_names[i]))
                continue;
            sc_backdrop_find(SC_SKIP_LEAP, size, sc_cpu_names[i])(&b, rays, count, found);
            assert_memory_equal(expected, found, count * sizeof *found);
        }
    }
    assert_true(lit > RAYS / 10);
    sc_team_close(team);
}

RUN_TESTS(NULL, NULL)
