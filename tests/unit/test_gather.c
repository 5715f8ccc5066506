/* SPDX-License-Identifier: BSD-3-Clause */
/* Light that is gathered (light.method: global): against closed forms, and how it follows from a
 * scene. */
#include "check.h"

#include "scenes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 81, MIDDLE = SIDE / 2 };
#define ALBEDO 0.5

/* A scene of a shape, seen along y or z without perspective, a pixel to a voxel, lit by nothing but
 * the sky. */
static small_scene sky_scene(int shape(double, double, double), bool from_above, sc_scene *scene)
{
    const int size[3] = {SIDE, SIDE, SIDE};
    const double spacing[3] = {1, 1, 1}, middle = MIDDLE;
    small_scene s = make_scene(shape_volume(size, spacing, 1, 3, shape), 1);
    const sc_vec3 eye = {middle, from_above ? middle : 300, from_above ? 300 : middle};

    s.settings.width_px = s.settings.height_px = SIDE;
    s.settings.samples = 1;
    s.settings.light = (sc_lighting){.method = SC_LIGHT_GLOBAL, .ambient = 1};
    for (int id = 1; id < 3; id++) {
        s.tissues[id].material.specular = 0;
        for (int i = 0; i < 3; i++)
            s.tissues[id].rgb_linear[i] = ALBEDO;
    }
    *scene = (sc_scene){.clip_set_count = 1};
    scene->camera =
        sc_camera_look(eye, (sc_vec3){middle, middle, middle},
                       (sc_vec3){0, from_above, !from_above}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    return s;
}

/* The light that a pixel shows, per albedo, of component @p i. */
static double light_at(const sc_image *image, int x, int y, int i)
{
    return sc_srgb_to_linear(image->rgb[((size_t)y * SIDE + (size_t)x) * 3 + (size_t)i] / 255.0) /
           ALBEDO;
}

static int ball(double x, double y, double z)
{
    const double dx = x - MIDDLE, dy = y - MIDDLE, dz = z - MIDDLE;

    return dx * dx + dy * dy + dz * dz < 30 * 30;
}

/* Nothing hides the sky from a ball: its light is the integral over the hemisphere of each normal.
 */
TEST(a_ball_is_lit_by_half_of_the_sky)
{
    sc_scene scene;
    small_scene s = sky_scene(ball, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = draw_view(&s, &scene, NULL);

    for (int y = MIDDLE - 24; y <= MIDDLE + 24; y += 8) {
        const double up = (MIDDLE - y) / 30.0;

        assert_true(fabs(light_at(&image, MIDDLE, y, 0) - (SC_SKY_MEAN + SC_SKY_UP * 2 / 3 * up)) <
                    0.03);
    }
    free_scene(&s);
}

/* A well of radius 12 and depth 24 in a black block, with a grey floor. */
static int well(double x, double y, double z)
{
    const double square = (x - MIDDLE) * (x - MIDDLE) + (y - MIDDLE) * (y - MIDDLE);

    if (z > 60 || fmax(fabs(x - MIDDLE), fabs(y - MIDDLE)) > 35)
        return 0;
    return square > 12 * 12 ? 1 : z < 36 ? 2 : 0;
}

/* To the middle of the floor the sky is a cone, whose light has a closed form. */
TEST(the_floor_of_a_well_sees_a_cone_of_the_sky)
{
    sc_scene scene;
    small_scene s = sky_scene(well, true, &scene);
    const double cosine = 24.5 / sqrt(24.5 * 24.5 + 12 * 12);
    const double expected =
        SC_SKY_MEAN * (1 - cosine * cosine) + SC_SKY_UP * 2 / 3 * (1 - cosine * cosine * cosine);
    SC_OWN(sc_image_clear) sc_image image = {0};
    double sum = 0;

    memset(s.tissues[1].rgb_linear, 0, sizeof s.tissues[1].rgb_linear);
    image = draw_view(&s, &scene, NULL);
    for (int y = -2; y <= 2; y++) {
        for (int x = -2; x <= 2; x++)
            sum += light_at(&image, MIDDLE + x, MIDDLE + y, 0) / 25;
    }
    assert_true(fabs(sum / expected - 1) < 0.08);
    free_scene(&s);
}

/* A floor beside a wall of another tissue. */
static int corner(double x, double y, double z)
{
    (void)y;
    return z < 20 ? 1 : x < 20 && z < 70 ? 2 : 0;
}

/* Light takes the colour of a wall to the floor beside it, and no light becomes more. */
TEST(colour_goes_from_wall_to_floor)
{
    sc_scene scene;
    small_scene s = sky_scene(corner, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.tissues[2].rgb_linear[1] = s.tissues[2].rgb_linear[2] = 0;
    image = draw_view(&s, &scene, NULL);
    assert_true(light_at(&image, 24, MIDDLE, 0) > 1.1 * light_at(&image, 24, MIDDLE, 2));
    assert_true(light_at(&image, 76, MIDDLE, 0) < 1.03 * light_at(&image, 76, MIDDLE, 2));
    for (int x = 0; x < SIDE; x++)
        assert_true(light_at(&image, x, MIDDLE, 0) < SC_SKY_MEAN + SC_SKY_UP * 2 / 3 + 0.02);
    free_scene(&s);
}

/* A hollow ball with a wall of a voxel and a half, open above. */
static int shell(double x, double y, double z)
{
    const double dx = x - MIDDLE, dy = y - MIDDLE, dz = z - MIDDLE,
                 r = sqrt(dx * dx + dy * dy + dz * dz);

    return r < 30 && r > 28.5 && dz < 20;
}

/* Light does not go through a thin wall: inside it is darker than outside. */
TEST(a_thin_wall_keeps_its_sides_apart)
{
    sc_scene scene;
    small_scene s = sky_scene(shell, true, &scene);
    SC_OWN(sc_image_clear) sc_image inside = {0}, outside = {0};

    for (int i = 0; i < 3; i++)
        s.tissues[1].rgb_linear[i] = 0.1F;
    inside = draw_view(&s, &scene, NULL);
    scene.camera =
        sc_camera_look((sc_vec3){MIDDLE, MIDDLE, -300}, (sc_vec3){MIDDLE, MIDDLE, MIDDLE},
                       (sc_vec3){0, 1, 0}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    outside = draw_view(&s, &scene, NULL);
    /* from below: the lower side of the sky; from above: a part of the upper one, which is three
     * times as bright */
    assert_true(light_at(&outside, MIDDLE, MIDDLE, 0) * ALBEDO / 0.1 > 0.25);
    assert_true(light_at(&inside, MIDDLE, MIDDLE, 0) * ALBEDO / 0.1 < 0.45);
    assert_true(light_at(&inside, MIDDLE, MIDDLE, 0) * ALBEDO / 0.1 > 0.15);
    free_scene(&s);
}

/* Draw with a renderer that has drawn something else before. */
static sc_image draw_after(sc_renderer *r, const sc_scene *scene)
{
    sc_image image;
    sc_render_stats stats;

    assert_ok(sc_image_init_alpha(&quiet, SIDE, SIDE, false, &image));
    sc_render_frame(r, scene, NULL, &image, &stats);
    return image;
}

/* Light follows from the scene, not from those that were drawn before. */
TEST(light_does_not_depend_on_what_was_drawn_before)
{
    sc_scene scene, cut;
    small_scene s = sky_scene(well, true, &scene);
    const float faded[3] = {1, 0.4F, 1};
    SC_OWN(sc_image_clear) sc_image first = {0}, again = {0}, fresh = {0}, opened = {0};
    sc_renderer *r;

    s.tissues[1].fade_group = 1;
    cut = scene;
    cut.planes[0] = (sc_plane){{0.6, 0, 0.8}, -0.6 * MIDDLE - 0.8 * 50};
    cut.plane_count = 1;
    cut.cuts = cut.clip_sets[0] = 1;
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    first = draw_after(r, &scene);
    opened = draw_after(r, &cut);
    cut.fades = faded;
    sc_image_clear(&opened);
    opened = draw_after(r, &cut);
    again = draw_after(r, &scene);
    sc_renderer_free(r);
    assert_memory_equal(first.rgb, again.rgb, (size_t)SIDE * SIDE * 3);
    fresh = draw_view(&s, &cut, NULL);
    assert_memory_equal(fresh.rgb, opened.rgb, (size_t)SIDE * SIDE * 3);
    assert_true(memcmp(first.rgb, opened.rgb, (size_t)SIDE * SIDE * 3) != 0);
    free_scene(&s);
}

/* Planes that cut all alike need no new rays. They give the light of rays that are followed to the
 * planes: the same two, as a wedge, are not known to keep what is convex. */
TEST(a_cut_gives_the_light_of_rays_that_see_it)
{
    sc_scene scene;
    small_scene s = sky_scene(well, true, &scene);
    SC_OWN(sc_image_clear) sc_image kept = {0}, traced = {0};
    int differ = 0;

    scene.planes[0] = scene.planes[1] = (sc_plane){{0, 1, 0}, 0.3 - MIDDLE};
    scene.plane_count = 1;
    scene.cuts = scene.clip_sets[0] = 1;
    kept = draw_view(&s, &scene, NULL);
    scene.plane_count = 2;
    scene.cuts = scene.clip_sets[0] = 3;
    scene.clip_mode = SC_CLIP_CUT;
    traced = draw_view(&s, &scene, NULL);
    for (int i = 0; i < SIDE * SIDE * 3; i++)
        differ += abs(kept.rgb[i] - traced.rgb[i]) > 6;
    assert_true(differ < SIDE * SIDE * 3 / 200);
    free_scene(&s);
}

/* All kernels show the same light, also behind what lets some of it through. */
TEST(all_kernels_show_the_same_light)
{
    sc_scene scene;
    small_scene s = sky_scene(corner, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.tissues[2].opacity = 0.5;
    s.settings.light.key = s.settings.light.occlusion = 0.5;
    scene.camera = sc_camera_look((sc_vec3){150, 200, 120}, (sc_vec3){MIDDLE, MIDDLE, 30},
                                  (sc_vec3){0, 0, 1}, SC_PERSPECTIVE, 0.3);
    image = draw_by_all_kernels(&s, &scene);
    free_scene(&s);
}

/* Memory that is not there ends the renderer, not the program. */
TEST(want_of_memory_is_told)
{
    sc_scene scene;
    small_scene s = sky_scene(corner, false, &scene);
    sc_status status = SC_ERR_MEMORY;
    sc_renderer *r = NULL;

    for (long n = 0; status != SC_OK; n++) {
        long budget = n;
        const sc_ctx ctx = {.alloc_budget = &budget};

        status = sc_renderer_new(&ctx, &s.settings, &s.prepared.view, s.tissues, &r);
        assert_true(status == SC_OK || status == SC_ERR_MEMORY);
        assert_true(n < 200);
    }
    sc_renderer_free(r);
    free_scene(&s);
}

RUN_TESTS(NULL, NULL)
