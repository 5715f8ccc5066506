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

/* How many times as much of the first component of light arrives as of the last, along the pixels
 * at @p x. */
static double redness(const sc_image *image, int x)
{
    double red = 0, blue = 0;

    for (int y = MIDDLE - 20; y <= MIDDLE + 20; y++) {
        red += light_at(image, x, y, 0);
        blue += light_at(image, x, y, 2);
    }
    return red / blue;
}

/* Light takes the colour of a wall to the floor beside it, and no light becomes more. */
TEST(colour_goes_from_wall_to_floor)
{
    sc_scene scene;
    small_scene s = sky_scene(corner, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.tissues[2].rgb_linear[1] = s.tissues[2].rgb_linear[2] = 0;
    image = draw_view(&s, &scene, NULL);
    assert_true(redness(&image, 24) > 1.1);
    assert_true(redness(&image, 76) < 1.03);
    for (int x = 0; x < SIDE; x++)
        assert_true(light_at(&image, x, MIDDLE, 0) < SC_SKY_MEAN + SC_SKY_UP * 2 / 3 + 0.02);
    free_scene(&s);
}

/* A floor before a wall that stands between it and the lamp. */
static int screen(double x, double y, double z)
{
    (void)y;
    return z < 20 ? 1 : x > 64 && z < 50 ? 2 : 0;
}

/* The lamp stands to the volume, on the side of larger x: behind the wall the floor has none of its
 * light, and far from it that of a disc, nearly its cosine. */
TEST(the_lamp_casts_shadows)
{
    sc_scene scene;
    small_scene s = sky_scene(screen, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};
    const double upward = 0.707, square = 0.3 * 0.3; /* of the lamp's middle; of its radius */

    s.settings.light.ambient = 0;
    s.settings.light.key = 1;
    memset(s.tissues[2].rgb_linear, 0, sizeof s.tissues[2].rgb_linear);
    image = draw_view(&s, &scene, NULL);
    assert_true(light_at(&image, 58, MIDDLE, 0) < 0.02);
    assert_true(fabs(light_at(&image, 14, MIDDLE, 0) / (upward * (1 - square / 4)) - 1) < 0.03);
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
    assert_ok(sc_renderer_gather(&quiet, r, &scene, SC_LIGHT_NEW_RAYS, NULL));
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

/* Light reaches what a plane lays bare between two tissues, of which it cuts only one. */
TEST(what_a_cut_lays_bare_is_lit)
{
    sc_scene scene;
    small_scene s = sky_scene(corner, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.tissues[1].clip_set = 1;
    scene.planes[0] = (sc_plane){{0, 0, 1}, -21};
    scene.plane_count = 1;
    scene.clip_set_count = 2;
    scene.cuts = scene.clip_sets[1] = 1;
    scene.camera =
        sc_camera_look((sc_vec3){MIDDLE, MIDDLE, -300}, (sc_vec3){MIDDLE, MIDDLE, MIDDLE},
                       (sc_vec3){0, 1, 0}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    image = draw_view(&s, &scene, NULL);
    assert_true(fabs(light_at(&image, SIDE - 11, MIDDLE, 0) - (SC_SKY_MEAN - SC_SKY_UP * 2 / 3)) <
                0.08);
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

    for (long n = 0; status != SC_OK; n++) {
        status = SC_OK;
        for (int change = SC_LIGHT_STAYS; status == SC_OK && change <= SC_LIGHT_NEW_RAYS;
             change++) {
            long budget = n;
            const sc_ctx ctx = {.alloc_budget = &budget};
            sc_renderer *r = NULL;

            status = sc_renderer_new(&ctx, &s.settings, &s.prepared.view, s.tissues, &r);
            if (status == SC_OK)
                status = sc_renderer_gather(&ctx, r, &scene, (sc_light_change)change, NULL);
            sc_renderer_free(r);
            assert_true(status == SC_OK || status == SC_ERR_MEMORY);
        }
        assert_true(n < 200);
    }
    free_scene(&s);
}

/* ---- the truth: paths through the smooth surface ---- */

/* What paths need of a scene whose tissues are opaque. */
typedef struct truth {
    const small_scene *s;
    const sc_kernel *kernel;
    sc_affine to_voxel;
    sc_march_tissue tissues[32];
    sc_march march;
    uint64_t seed;
} truth;

/* Set up the march of paths. @param cells of sc_visible_cells. */
static void begin_truth(truth *t, const small_scene *s, const uint64_t *cells)
{
    const sc_prepared *v = &s->prepared.view;

    *t = (truth){
        .s = s, .kernel = sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_INTERIOR, v, NULL), .seed = 5};
    assert_true(sc_affine_invert(&v->to_ras_mm, &t->to_voxel));
    t->march = (sc_march){
        .volume = v,
        .visible = cells,
        .visible_row = sc_framed_row(v->bricks),
        .visible_layer = sc_framed_layer(v->bricks),
        .box_low = {-1.5F, -1.5F, -1.5F},
        .box_high = {(float)v->size[0] + 2.5F, (float)v->size[1] + 2.5F, (float)v->size[2] + 2.5F},
        .tissues = t->tissues,
        .opaque_below = SC_OPAQUE,
        .light = {.flat = true}};
    for (int i = 0; i < 9; i++)
        t->march.grid_per_mm[i / 3][i % 3] = (float)t->to_voxel.m[i / 3][i % 3];
    for (int id = 0; id < v->label_count; id++)
        t->tissues[id] = (sc_march_tissue){.boundary_alpha = 1,
                                           .thickness_factor = 1,
                                           .show = id ? SC_SHOW_BOUNDARY : 0,
                                           .shininess = 1};
}

/* Follow a ray to the first surface. @return its label; 0 if there is none. @param at moved there,
 * RAS mm. */
static uint32_t follow(const truth *t, sc_vec3 *at, sc_vec3 d, sc_vec3 *normal)
{
    const sc_vec3 from = sc_affine_point(&t->to_voxel, *at),
                  along = sc_affine_vector(&t->to_voxel, d);
    const sc_ray ray = {.origin = {(float)from.x + 1, (float)from.y + 1, (float)from.z + 1},
                        .direction = {(float)along.x, (float)along.y, (float)along.z},
                        .toward_eye = {(float)-d.x, (float)-d.y, (float)-d.z},
                        .clip_sets = 1,
                        .part_count = {1},
                        .parts = {{{.end_mm = 1e4F, .cap_plane = -1}}}};
    sc_march_counters counters = {0};
    sc_radiance light;

    t->kernel->march(&t->march, &ray, NULL, 1, &light, &counters);
    if (!light.label)
        return 0;
    *at = sc_vec3_along(*at, light.depth_mm, d);
    *normal = (sc_vec3){light.normal[0], light.normal[1], light.normal[2]};
    return light.label;
}

/* @return a direction about a normal, with a density as its cosine: a point of the unit sphere
 * around the normal's end. */
static sc_vec3 scattered(truth *t, sc_vec3 normal)
{
    const double z = random_real(&t->seed, -1, 1),
                 angle = random_real(&t->seed, 0, 6.283185307179586);
    const double r = sqrt(1 - z * z);

    return sc_vec3_unit(sc_vec3_add(normal, (sc_vec3){r * cos(angle), r * sin(angle), z}));
}

/* Add to @p sum the light, for each component, that one path from a point of a surface brings to
 * it. */
static void add_path(truth *t, sc_vec3 at, sc_vec3 normal, double sum[3])
{
    double share[3] = {1, 1, 1};

    for (int bounce = 0; bounce < 8; bounce++) {
        const sc_vec3 d = scattered(t, normal);
        uint32_t label;

        at = sc_vec3_along(at, 0.02 * t->march.volume->to_ras_mm.m[0][0], normal);
        label = follow(t, &at, d, &normal);
        for (int i = 0; i < 3; i++) {
            if (!label)
                sum[i] += share[i] * (SC_SKY_MEAN + SC_SKY_UP * d.z);
            share[i] *= t->s->tissues[label].rgb_linear[i];
        }
        if (!label)
            return;
    }
}

/* Three balls of different colours, which nearly touch, on a plate. */
static int balls(double x, double y, double z)
{
    static const double middles[3][4] = {{26, 30, 30, 15}, {56, 34, 29, 14}, {40, 58, 27, 12}};

    for (int i = 0; i < 3; i++) {
        const double dx = x - middles[i][0], dy = y - middles[i][1], dz = z - middles[i][2];

        if (dx * dx + dy * dy + dz * dz < middles[i][3] * middles[i][3])
            return i ? i : 1;
    }
    return z < 14 ? 2 : 0;
}

/* Gathered light is that which paths bring to the smooth surface itself, but for their noise, the
 * rounding of pixels, and that its rays meet vertices instead. */
TEST(gathered_light_is_that_of_paths)
{
    enum { PATHS = 800, STEP = 11 };
    sc_scene scene;
    small_scene s = sky_scene(balls, false, &scene);
    const uint8_t show[3] = {0, SC_SHOW_BOUNDARY, SC_SHOW_BOUNDARY};
    SC_OWN(sc_image_clear) sc_image image = {0};
    double squares = 0, bias = 0, mean = 0;
    int count = 0;
    sc_team *team;
    uint64_t *cells;
    truth t;

    s.tissues[1].rgb_linear[1] = 0.15F;
    scene.camera = sc_camera_look((sc_vec3){120, 250, 160}, (sc_vec3){MIDDLE, MIDDLE, 24},
                                  (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    image = draw_view(&s, &scene, NULL);
    assert_ok(sc_team_open(&quiet, NULL, 1, NULL, &team));
    assert_ok(sc_visible_cells(&quiet, team, &s.prepared.view, show, &cells));
    begin_truth(&t, &s, cells);
    /* Crevices are darker than by paths, because vertices reach out from the surface. */
    for (int pixel = 0; pixel < SIDE * SIDE; pixel += STEP) {
        const int x = pixel % SIDE, y = pixel / SIDE;
        const sc_camera *c = &scene.camera;
        double sum[3] = {0};
        sc_vec3 at = sc_vec3_along(sc_vec3_along(c->position_mm, x + 0.5 - SIDE / 2.0, c->right),
                                   SIDE / 2.0 - y - 0.5, c->up);
        sc_vec3 normal;
        const uint32_t label = follow(&t, &at, c->forward, &normal);

        if (!label || normal.x * normal.x == 1 || normal.y * normal.y == 1)
            continue; /* faces of the volume have no light of their own */
        for (int n = 0; n < PATHS; n++)
            add_path(&t, at, normal, sum);
        for (int i = 0; i < 2; i++) {
            const double albedo = s.tissues[label].rgb_linear[i];
            const double error = light_at(&image, x, y, i) * ALBEDO / albedo - sum[i] / PATHS;

            squares += error * error;
            bias += error;
            mean += sum[i] / PATHS;
            count++;
        }
    }
    assert_true(count > 300);
    assert_true(sqrt(squares / count) < 0.04 * mean / count);
    assert_true(fabs(bias) < 0.02 * mean);
    sc_team_close(team);
    free_scene(&s);
}

RUN_TESTS(NULL, NULL)
