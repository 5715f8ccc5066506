/* SPDX-License-Identifier: BSD-3-Clause */
/* Light that is gathered (light.method: global), and light by paths: against closed forms, against
 * each other, and how they follow from a scene. */
#include "check.h"
#include "compare_images.h"

#include "path.h"
#include "scenes.h"

#include <math.h>

enum { SIDE = 81, MIDDLE = SIDE / 2 };
#define ALBEDO 0.5

/* How the light of a test is found. */
static sc_light_method method = SC_LIGHT_GLOBAL;

/* Test light that is gathered, light by paths, and light by paths on the surface in voxels.
 * Sanitizers find in one test what they find in the next: there each is of one of the three, in
 * turn, unless SC_TEST_ALL is set. */
static void test_by_each_method(void (*test)(void))
{
    static int turn;

    for (int i = 0; i < 3; i++) {
        if (in_brief() && i != turn % 3)
            continue;
        method = i < 2 ? SC_LIGHT_PATH : SC_LIGHT_GLOBAL;
        tested_surface = i ? SC_SURFACE_SMOOTH : SC_SURFACE_VOXEL;
        test();
    }
    turn++;
    method = SC_LIGHT_GLOBAL;
    tested_surface = SC_SURFACE_SMOOTH;
}

#define TEST_BY_EACH_METHOD(name)                                                                  \
    static void name##_once(void);                                                                 \
    TEST(name)                                                                                     \
    {                                                                                              \
        test_by_each_method(name##_once);                                                          \
    }                                                                                              \
    static void name##_once(void)

/* A scene of a shape in @p side voxels, seen along y or z without perspective, a pixel to a voxel,
 * lit by nothing but the sky. */
static small_scene sky_scene_of(int side, int shape(double, double, double), bool from_above,
                                sc_scene *scene)
{
    const double middle = MIDDLE;
    small_scene s = make_scene(cube_volume(side, 3, shape), 1);
    const sc_vec3 eye = {middle, from_above ? middle : 300, from_above ? 300 : middle};

    s.settings.width_px = s.settings.height_px = SIDE;
    s.settings.sampling.samples = 1;
    s.settings.light = (sc_lighting){.method = method, .ambient = 1};
    s.settings.sampling.lens_samples = method == SC_LIGHT_PATH ? 64 : 0;
    s.settings.skip = SC_SKIP_LEAP;
    for (int id = 1; id < 3; id++) {
        s.tissues[id].material.specular = 0;
        for (int i = 0; i < 3; i++)
            s.tissues[id].rgb_linear[i] = ALBEDO;
    }
    *scene = (sc_scene){.clip.set_count = 1};
    scene->camera =
        sc_camera_look(eye, (sc_vec3){middle, middle, middle},
                       (sc_vec3){0, from_above, !from_above}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    return s;
}

static small_scene sky_scene(int shape(double, double, double), bool from_above, sc_scene *scene)
{
    return sky_scene_of(SIDE, shape, from_above, scene);
}

/* The light that a pixel shows, per albedo, of component @p i. */
static double light_at(const sc_image *image, int x, int y, int i)
{
    return sc_srgb_to_linear(image->rgb[((size_t)y * SIDE + (size_t)x) * 3 + (size_t)i] / 255.0) /
           ALBEDO;
}

/* Draw where tests of light look: rows and columns up to @p reach_px pixels from the middle, and a
 * corner. */
static sc_image draw_cross(const small_scene *s, const sc_scene *scene, int reach_px)
{
    const sc_rows rows = {MIDDLE - reach_px, MIDDLE + reach_px + 1};
    const sc_columns_px columns = {rows.first, rows.end};
    const sc_rows top = {0, 1};
    sc_image image;
    sc_render_stats stats;
    sc_renderer *r;

    assert_ok(sc_renderer_new(&quiet, &s->settings, &s->prepared.view, s->tissues, &r));
    assert_ok(sc_renderer_gather(&quiet, r, scene, SC_LIGHT_STAYS, NULL));
    assert_ok(sc_image_init_alpha(&quiet, SIDE, SIDE, false, &image));
    sc_render_view(r, scene, NULL, NULL, &rows, &image, &stats);
    sc_render_view(r, scene, NULL, &columns, NULL, &image, &stats);
    sc_render_view(r, scene, NULL, &(sc_columns_px){0, 1}, &top, &image, &stats);
    sc_renderer_free(r);
    return image;
}

static int ball(double x, double y, double z)
{
    const double dx = x - MIDDLE, dy = y - MIDDLE, dz = z - MIDDLE;

    return dx * dx + dy * dy + dz * dz < 30 * 30;
}

/* A picture of all directions. */
enum { MAP_WIDTH = 64, MAP_HEIGHT = 32 };
static float map_pixels[MAP_HEIGHT * MAP_WIDTH][3];
static const sc_panorama map = {MAP_WIDTH, MAP_HEIGHT, map_pixels};

/* Let it show what @p light says of each direction, twice as bright: its brightness does not count.
 */
static void paint_map(double light(double right, double before, double up))
{
    for (int i = 0; i < MAP_HEIGHT * MAP_WIDTH; i++) {
        const double down = (i / MAP_WIDTH + 0.5) / MAP_HEIGHT * 3.14159265;
        const double turn = ((i % MAP_WIDTH + 0.5) / MAP_WIDTH - 0.5) * 2 * 3.14159265;

        for (int k = 0; k < 3; k++)
            map_pixels[i][k] =
                (float)(2 * light(sin(down) * sin(turn), sin(down) * cos(turn), cos(down)));
    }
}

static double sky_light(double right, double before, double up)
{
    return SC_SKY_MEAN + SC_SKY_UP * up;
}

static double even_light(double right, double before, double up)
{
    return 1;
}

static double light_from_the_right(double right, double before, double up)
{
    return right > 0.5 ? 3 : 0.3;
}

/* Light comes from where the picture shows it, and goes round with it. */
TEST_BY_EACH_METHOD(light_comes_from_a_picture)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(ball, false, &scene);

    paint_map(light_from_the_right);
    s.settings.environment = &map;
    for (int turned = 0; turned < 2; turned++) {
        SC_OWN(sc_image_clear) sc_image image = {0};
        double right, left;

        s.settings.environment_turn_deg = 180 * turned;
        image = draw_cross(&s, &scene, 0); /* seen from before: its right side is on the left */
        right = light_at(&image, MIDDLE - 26, MIDDLE, 0);
        left = light_at(&image, MIDDLE + 26, MIDDLE, 0);
        assert_true(turned ? left > 2 * right : right > 2 * left);
    }
}

/* Nothing hides the sky from a ball: its light is the integral over the hemisphere of each normal.
 * A picture of the sky gives the same light as it. */
TEST_BY_EACH_METHOD(a_ball_is_lit_by_half_of_the_sky)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(ball, false, &scene);

    paint_map(sky_light);
    for (int mapped = 0; mapped < 2; mapped++) {
        SC_OWN(sc_image_clear) sc_image image = {0};

        s.settings.environment = mapped ? &map : NULL;
        image = draw_cross(&s, &scene, 0);
        for (int y = MIDDLE - 24; y <= MIDDLE + 24; y += 8) {
            const double up = (MIDDLE - y) / 30.0;

            assert_near(light_at(&image, MIDDLE, y, 0), SC_SKY_MEAN + SC_SKY_UP * 2 / 3 * up,
                        mapped && method == SC_LIGHT_GLOBAL ? 0.06 : 0.03);
        }
    }
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
TEST_BY_EACH_METHOD(the_floor_of_a_well_sees_a_cone_of_the_sky)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(well, true, &scene);
    const double cosine = 24.5 / sqrt(24.5 * 24.5 + 12 * 12);
    const double expected =
        SC_SKY_MEAN * (1 - cosine * cosine) + SC_SKY_UP * 2 / 3 * (1 - cosine * cosine * cosine);
    SC_OWN(sc_image_clear) sc_image image = {0};
    double sum = 0;

    memset(s.tissues[1].rgb_linear, 0, sizeof s.tissues[1].rgb_linear);
    image = draw_cross(&s, &scene, 2);
    for (int y = -2; y <= 2; y++) {
        for (int x = -2; x <= 2; x++)
            sum += light_at(&image, MIDDLE + x, MIDDLE + y, 0) / 25;
    }
    assert_true(fabs(sum / expected - 1) < 0.09); /* the rim is drawn rounded, and lets more in */
}

/* The eye sees as far into a well as the lamp beside it lights, whatever of the sky is hidden. */
TEST_BY_EACH_METHOD(the_lamp_at_the_eye_lights_crevices)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(well, true, &scene);
    SC_OWN(sc_image_clear) sc_image without = draw_cross(&s, &scene, 0), with = {0};

    s.settings.light.head = 0.4;
    with = draw_cross(&s, &scene, 0);
    assert_near(light_at(&with, MIDDLE, MIDDLE, 0) - light_at(&without, MIDDLE, MIDDLE, 0), 0.4,
                0.02);
}

/* A floor beside a wall of another tissue. */
static int corner(double x, double y, double z)
{
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
TEST_BY_EACH_METHOD(colour_goes_from_wall_to_floor)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(corner, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.tissues[2].rgb_linear[1] = s.tissues[2].rgb_linear[2] = 0;
    image = draw_cross(&s, &scene, 20);
    assert_true(redness(&image, 24) > 1.1);
    assert_true(redness(&image, 76) < 1.03);
    for (int x = 0; x < SIDE; x++)
        assert_true(light_at(&image, x, MIDDLE, 0) < SC_SKY_MEAN + SC_SKY_UP * 2 / 3 + 0.02);
}

/* A floor before a wall that stands between it and the lamp. */
static int screen(double x, double y, double z)
{
    return z < 20 ? 1 : x > 64 && z < 50 ? 2 : 0;
}

/* The lamp stands to the volume, on the side of larger x: behind the wall the floor has none of its
 * light, and far from it that of a disc, nearly its cosine. */
TEST_BY_EACH_METHOD(the_lamp_casts_shadows)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(screen, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};
    const double upward = 0.707, square = 0.3 * 0.3; /* of the lamp's middle; of its radius */

    s.settings.light.ambient = 0;
    s.settings.light.key = 1;
    memset(s.tissues[2].rgb_linear, 0, sizeof s.tissues[2].rgb_linear);
    image = draw_cross(&s, &scene, 0);
    assert_true(light_at(&image, 58, MIDDLE, 0) < 0.02);
    assert_true(fabs(light_at(&image, 14, MIDDLE, 0) / (upward * (1 - square / 4)) - 1) < 0.03);
}

/* @return the light of a rectangular lamp on a plane below it, or below the camera that it follows:
 * the mean over its solid angle of the cosine to the normal, by sums over its area. */
static double lamp_on_plane(const sc_lamp *lamp)
{
    enum { STEPS = 200 };
    const double degree = 3.14159265358979 / 180, steep = lamp->follows ? 90 : lamp->elevation_deg;
    double light = 0, solid = 0;

    for (int i = 0; i < STEPS * STEPS; i++) {
        const double x = tan(lamp->width_deg / 2 * degree) * ((i % STEPS + 0.5) * 2 / STEPS - 1);
        const double y = tan(lamp->height_deg / 2 * degree) * ((i / STEPS + 0.5) * 2 / STEPS - 1);
        const double far = sqrt(1 + x * x + y * y), angle = 1 / (far * far * far);

        light += fmax(sin(steep * degree) + y * cos(steep * degree), 0) / far * angle;
        solid += angle;
    }
    return light / solid;
}

static int slab(double x, double y, double z)
{
    return z < 20;
}

/* A rectangular lamp brings a plane the mean cosine of its directions, also if half of it is below
 * the plane; and where it stands to the camera, which looks down here, so that it is above. The
 * same from the other side, because normals are kept to within a degree. */
TEST_BY_EACH_METHOD(a_rectangular_lamp_lights_a_plane)
{
    static const sc_lamp lamps[] = {
        {true, false, 90, 30, 60, 40}, {true, false, 90, 0, 30, 70}, {true, true, 0, 0, 40, 90}};

    for (int i = 0; i < 3; i++) {
        sc_scene scene;
        SC_OWN(free_scene) small_scene s = sky_scene(slab, true, &scene);
        double sum = 0;

        s.settings.light = (sc_lighting){.method = method, .key = 1, .lamp = lamps[i]};
        for (int turned = 0; turned < 2; turned++) {
            SC_OWN(sc_image_clear) sc_image image = draw_cross(&s, &scene, 0);

            for (int y = MIDDLE - 20; y <= MIDDLE + 20; y++)
                sum += light_at(&image, MIDDLE, y, 0) / 82;
            s.settings.light.lamp.angle_deg -= lamps[i].follows ? 0 : 180;
        }
        assert_near(sum, lamp_on_plane(&lamps[i]), 0.006);
    }
}

/* A highlight of the lamp ends where its light does. */
TEST(no_highlight_is_in_the_shadow_of_the_lamp)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(screen, true, &scene);
    double lit[2], dark[2];

    s.settings.light.ambient = 0.3;
    s.settings.light.key = 1;
    s.tissues[1].material.roughness = 1;
    for (int i = 0; i < 2; i++) {
        SC_OWN(sc_image_clear) sc_image image = draw_cross(&s, &scene, 0);

        lit[i] = light_at(&image, 14, MIDDLE, 0);
        dark[i] = light_at(&image, 58, MIDDLE, 0);
        s.tissues[1].material.specular = 0.2;
    }
    assert_true(fabs(dark[1] - dark[0]) < 0.01 && lit[1] > lit[0] + 0.1);
}

/* A cut face from which all of the lamp is seen gets the mean of the light of its points. */
TEST_BY_EACH_METHOD(a_cut_face_is_lit_by_the_lamp)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(ball, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.settings.light.ambient = 0;
    s.settings.light.key = 1;
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, MIDDLE};
    scene.clip.count = 1;
    scene.clip.which = scene.clip.sets[0] = 1;
    image = draw_cross(&s, &scene, 0);
    assert_near(light_at(&image, MIDDLE, MIDDLE, 0), 0.48 * 0.97846, 0.005);
}

/* Of what an even sky brings to the floor, a black ball that lies on it hides the third power of
 * its radius over the distance of its middle; where nothing is hidden, the floor is the background.
 */
TEST_BY_EACH_METHOD(a_ball_throws_its_shadow_on_the_floor)
{
    enum { RADIUS = 30 };
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(ball, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    paint_map(even_light);
    s.settings.environment = &map;
    s.settings.floor = true;
    memset(s.tissues[1].rgb_linear, 0, sizeof s.tissues[1].rgb_linear);
    memset(s.settings.background, 255, sizeof s.settings.background);
    scene.camera.half_height = 2 * SIDE;
    image = draw_cross(&s, &scene, 0);
    for (int x = RADIUS / 4 + 2; x < 18; x++) { /* farther away shadows fade */
        const double aside = 4 * (x + 0.5),
                     square = RADIUS * RADIUS / (aside * aside + RADIUS * RADIUS);
        const double seen = 1 - square * sqrt(square);
        const int at = SIDE / 2 - 1 - x, opposite = SIDE / 2 + x;
        const double sum =
            light_at(&image, at, SIDE / 2, 0) + light_at(&image, opposite, SIDE / 2, 0) +
            light_at(&image, SIDE / 2, at, 0) + light_at(&image, SIDE / 2, opposite, 0);

        assert_near(sum * ALBEDO / 4, seen, 0.02);
    }
    assert_int_equal(image.rgb[0], 255);
}

/* The wall of a cove gets of an even sky all but what the ball before it hides: the cosine times
 * the square of its radius over the distance; where nothing is hidden, it is the background. */
TEST_BY_EACH_METHOD(a_ball_throws_its_shadow_on_the_wall_of_a_cove)
{
    enum { RADIUS = 30 };
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(ball, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};
    /* behind the ball by the radius of the curve, which is a share of its height */
    const double to_wall = RADIUS + 0.35 * 2 * RADIUS;

    paint_map(even_light);
    s.settings.environment = &map;
    s.settings.floor = SC_GROUND_COVE;
    memset(s.tissues[1].rgb_linear, 0, sizeof s.tissues[1].rgb_linear);
    memset(s.settings.background, 255, sizeof s.settings.background);
    scene.camera.half_height = 2 * SIDE;
    image = draw_view(&s, &scene, NULL);
    for (int x = RADIUS / 4 + 2; x < 16; x++) {
        double more = 0;

        for (int y = -3; y <= 2; y++) { /* above the curve, and below where shadows fade */
            const double aside = 4 * (x + 0.5), above = 4 * y;
            const double square = to_wall * to_wall + aside * aside + above * above;
            const double seen = 1 - RADIUS * RADIUS * to_wall / (square * sqrt(square));
            const double sum = light_at(&image, SIDE / 2 - 1 - x, SIDE / 2 - y, 0) +
                               light_at(&image, SIDE / 2 + x, SIDE / 2 - y, 0);

            more += (sum * ALBEDO / 2 - seen) / 6;
        }
        assert_near(more, 0, 0.01);
    }
    assert_int_equal(image.rgb[0], 255);
}

/* A hollow ball with a wall of a voxel and a half, open above. */
static int shell(double x, double y, double z)
{
    const double dx = x - MIDDLE, dy = y - MIDDLE, dz = z - MIDDLE,
                 r = sqrt(dx * dx + dy * dy + dz * dz);

    return r < 30 && r > 28.5 && dz < 20;
}

/* Light does not go through a thin wall: inside it is darker than outside. */
TEST_BY_EACH_METHOD(a_thin_wall_keeps_its_sides_apart)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(shell, true, &scene);
    SC_OWN(sc_image_clear) sc_image inside = {0}, outside = {0};

    for (int i = 0; i < 3; i++)
        s.tissues[1].rgb_linear[i] = 0.1F;
    inside = draw_cross(&s, &scene, 0);
    scene.camera =
        sc_camera_look((sc_vec3){MIDDLE, MIDDLE, -300}, (sc_vec3){MIDDLE, MIDDLE, MIDDLE},
                       (sc_vec3){0, 1, 0}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    outside = draw_cross(&s, &scene, 0);
    /* from below: the lower side of the sky; from above: a part of the upper one, which is three
     * times as bright */
    assert_true(light_at(&outside, MIDDLE, MIDDLE, 0) * ALBEDO / 0.1 > 0.25);
    assert_true(light_at(&inside, MIDDLE, MIDDLE, 0) * ALBEDO / 0.1 < 0.45);
    assert_true(light_at(&inside, MIDDLE, MIDDLE, 0) * ALBEDO / 0.1 > 0.15);
}

/* Draw with a renderer that has drawn something else before. */
static sc_image draw_after(sc_renderer *r, const sc_scene *scene)
{
    sc_image image;
    sc_render_stats stats;

    assert_ok(sc_image_init_alpha(&quiet, SIDE, SIDE, false, &image));
    sc_render_view(r, scene, NULL, NULL, NULL, &image, &stats);
    return image;
}

/* Light follows from the scene, not from those that were drawn before. */
TEST(light_does_not_depend_on_what_was_drawn_before)
{
    sc_scene scene, cut;
    SC_OWN(free_scene) small_scene s = sky_scene(well, true, &scene);
    const float faded[3] = {1, 0.4F, 1};
    SC_OWN(sc_image_clear) sc_image first = {0}, again = {0}, fresh = {0}, opened = {0};
    sc_renderer *r;

    s.tissues[1].fade_group = 1;
    cut = scene;
    cut.clip.planes[0] = (sc_plane){{0.6, 0, 0.8}, -0.6 * MIDDLE - 0.8 * 50};
    cut.clip.count = 1;
    cut.clip.which = cut.clip.sets[0] = 1;
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
}

/* Few pixels differ by more than 6 levels. */
static void assert_alike(const sc_image *a, const sc_image *b)
{
    int differ = 0;

    for (int i = 0; i < SIDE * SIDE * 3; i++)
        differ += abs(a->rgb[i] - b->rgb[i]) > 6;
    assert_true(differ < SIDE * SIDE * 3 / 200);
}

/* Planes that cut all alike need no new rays. They give the light of rays that are followed to the
 * planes: the same two, as a wedge, are not known to keep what is convex. */
TEST(a_cut_gives_the_light_of_rays_that_see_it)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(well, true, &scene);
    SC_OWN(sc_image_clear) sc_image kept = {0}, traced = {0};

    scene.clip.planes[0] = scene.clip.planes[1] = (sc_plane){{0, 1, 0}, 0.3 - MIDDLE};
    scene.clip.count = 1;
    scene.clip.which = scene.clip.sets[0] = 1;
    kept = draw_view(&s, &scene, NULL);
    scene.clip.count = 2;
    scene.clip.which = scene.clip.sets[0] = 3;
    scene.clip.mode = SC_CLIP_CUT;
    traced = draw_view(&s, &scene, NULL);
    assert_alike(&kept, &traced);
}

/* Light on the floor past a plane, which cuts away what is nearest to it, is that of rays that are
 * followed to the plane, as for the same two planes as a wedge; and what was drawn before does not
 * count. */
TEST(a_cut_throws_no_shadow_on_the_floor)
{
    sc_scene scene, cut;
    SC_OWN(free_scene) small_scene s = sky_scene(ball, true, &scene);
    SC_OWN(sc_image_clear) sc_image whole = {0}, kept = {0}, again = {0}, traced = {0};
    sc_renderer *r;

    s.settings.floor = true;
    s.settings.light.key = 0.7;
    memset(s.settings.background, 255, sizeof s.settings.background);
    scene.camera.half_height = SIDE;
    cut = scene;
    cut.clip.planes[0] = cut.clip.planes[1] = (sc_plane){{-0.6, 0, 0.8}, -20};
    cut.clip.count = 1;
    cut.clip.which = cut.clip.sets[0] = 1;
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    assert_ok(sc_renderer_gather(&quiet, r, &scene, SC_LIGHT_NEW_RAYS, NULL));
    whole = draw_after(r, &scene);
    again = draw_after(r, &cut);
    sc_renderer_free(r);
    kept = draw_view(&s, &cut, NULL);
    assert_memory_equal(kept.rgb, again.rgb, (size_t)SIDE * SIDE * 3);
    cut.clip.count = 2;
    cut.clip.which = cut.clip.sets[0] = 3;
    cut.clip.mode = SC_CLIP_CUT;
    traced = draw_view(&s, &cut, NULL);
    assert_alike(&kept, &traced);
}

/* A ball in a veil of another tissue. */
static int veiled(double x, double y, double z)
{
    const double dx = x - MIDDLE, dy = y - MIDDLE, dz = z - MIDDLE,
                 square = dx * dx + dy * dy + dz * dz;

    return square < 20 * 20 ? 1 : square < 30 * 30 ? 2 : 0;
}

/* Light reaches the border between two tissues through one that lets it pass, evenly: no ray ends
 * at the vertices beside which it begins. */
TEST(what_is_behind_a_veil_is_lit_evenly)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(veiled, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.tissues[2].opacity = 0.05;
    image = draw_cross(&s, &scene, 0);
    for (int x = MIDDLE - 12; x <= MIDDLE + 12; x++)
        assert_near(light_at(&image, x, MIDDLE, 0), light_at(&image, MIDDLE, MIDDLE, 0), 0.08);
    assert_true(light_at(&image, MIDDLE, MIDDLE, 0) > 0.6);
}

/* Light reaches what a plane lays bare between two tissues, of which it cuts only one. */
TEST_BY_EACH_METHOD(what_a_cut_lays_bare_is_lit)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(corner, true, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.tissues[1].clip_set = 1;
    scene.clip.planes[0] = (sc_plane){{0, 0, 1}, -21};
    scene.clip.count = 1;
    scene.clip.set_count = 2;
    scene.clip.which = scene.clip.sets[1] = 1;
    scene.camera =
        sc_camera_look((sc_vec3){MIDDLE, MIDDLE, -300}, (sc_vec3){MIDDLE, MIDDLE, MIDDLE},
                       (sc_vec3){0, 1, 0}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    image = draw_cross(&s, &scene, 0);
    assert_true(fabs(light_at(&image, SIDE - 11, MIDDLE, 0) - (SC_SKY_MEAN - SC_SKY_UP * 2 / 3)) <
                0.08);
}

/* All kernels show the same light, also behind what lets some of it through; so do all processors
 * on the floor, whose light takes most of the time and is not found by kernels that skip. */
TEST_OF_THREADS(all_kernels_show_the_same_light)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene_of(MIDDLE, corner, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0}, floor = {0};

    s.tissues[2].opacity = 0.5;
    s.settings.light.key = s.settings.light.occlusion = 0.5;
    scene.camera = sc_camera_look((sc_vec3){150, 200, 120}, (sc_vec3){MIDDLE, MIDDLE, 30},
                                  (sc_vec3){0, 0, 1}, SC_PERSPECTIVE, 0.3);
    image = draw_by_all_kernels(&s, &scene);
    s.settings.floor = true;
    floor = draw_view(&s, &scene, NULL);
    for (int i = 1; sc_cpu_names[i]; i++) {
        SC_OWN(sc_image_clear) sc_image same = {0};

        if (!sc_cpu_has(sc_cpu_names[i]))
            continue;
        s.settings.cpu = sc_cpu_names[i];
        s.settings.work.threads = 1 + i % 3;
        same = draw_view(&s, &scene, NULL);
        assert_memory_equal(same.rgb, floor.rgb, sc_image_bytes(&floor));
    }
}

static int small_corner(double x, double y, double z)
{
    return corner(2 * x, 2 * y, 2 * z);
}

/* Memory that is not there ends the renderer, not the program. */
TEST(want_of_memory_is_told)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene_of(24, small_corner, false, &scene);
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
}

/* ---- paths ---- */

/* A surface gives back no more light than comes, however it stands and however rough it is, and
 * directions are chosen as often as is said. */
TEST(no_surface_gives_back_more_than_comes)
{
    enum { ANGLES = 4, ROUGH = 4, COUNT = 40000 };
    static const float roughness[ROUGH] = {1, 0.5F, 0.28F, 0.13F};
    uint64_t seed = 7;

    for (int i = 0; i < ANGLES * ROUGH; i++) {
        const double cosine = (i % ANGLES + 0.5) / ANGLES, white[3] = {1, 1, 1};
        const sc_march_tissue tissue = {.face = 1, .roughness = roughness[i / ANGLES]};
        const sc_reflector s =
            sc_reflector_of(&tissue, white, (double[3]){sqrt(1 - cosine * cosine), 0, cosine});
        double chosen = 0, even = 0, density = 0;

        for (int n = 0; n < COUNT; n++) {
            const double point[2] = {random_real(&seed, 0, 1), random_real(&seed, 0, 1)};
            const double z = random_real(&seed, 0, 1), a = random_real(&seed, 0, 6.283185307);
            const double r = sqrt(1 - z * z);
            double in[3], share[3];
            double d;

            sc_reflector_choose(&s, random_real(&seed, 0, 1), point, in);
            d = sc_reflector_share(&s, in, share);
            chosen += d > 0 ? share[0] / d / COUNT : 0;
            d = sc_reflector_share(&s, (double[3]){r * cos(a), r * sin(a), z}, share);
            even += share[0] * 6.283185307 / COUNT;
            density += d * 6.283185307 / COUNT;
        }
        assert_true(chosen < 1.002 && chosen > 0.5);
        assert_near(chosen, even, 0.06 * even);
        assert_true(density < 1.06); /* of what does not go below the surface */
    }
}

/* At normal incidence a full coat reflects 4 %, a partial one its share of that. With a white body
 * below no energy is lost, and the reflectance is reciprocal. */
TEST(a_coat_reflects_its_share)
{
    enum { COUNT = 20000 };
    static const float coats[3] = {0.5F, 1, 1};
    uint64_t seed = 7;

    for (int i = 0; i < 9; i++) {
        const sc_march_tissue tissue = {
            .face = i % 3 == 2 ? 0.3F : 0, .roughness = 0.25F, .coat = coats[i % 3]};
        const double cosine = i < 6 ? 1 : 0.3, out[3] = {sqrt(1 - cosine * cosine), 0, cosine};
        const double rgb[3] = {i < 3 ? 0 : 1, 0, 0};
        const sc_reflector s = sc_reflector_of(&tissue, rgb, out);
        sc_reflector back;
        double sum = 0, fro[3];

        for (int n = 0; n < COUNT; n++) {
            const double point[2] = {random_real(&seed, 0, 1), random_real(&seed, 0, 1)};
            double in[3], share[3], density;

            sc_reflector_choose(&s, random_real(&seed, 0, 1), point, in);
            density = sc_reflector_share(&s, in, share);
            sum += density > 0 ? share[0] / density / COUNT : 0;
            if (!(density > 0) || in[2] < 0.01)
                continue;
            back = sc_reflector_of(&tissue, rgb, in);
            sc_reflector_share(&back, out, fro);
            assert_near(share[0] * out[2], fro[0] * in[2], 1e-6 * (1 + share[0]));
        }
        assert_true(sum < 1.002);
        if (!(tissue.face > 0)) /* a rough face loses some energy: single scattering only */
            assert_near(sum, i < 3 ? 0.04 * coats[i] : 1, i < 3 ? 0.001 : 0.005);
    }
}

/* All kernels, threads and tiles draw the same paths, past a plane and what lets light through. */
TEST_OF_THREADS(all_kernels_follow_the_same_paths)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(corner, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};

    s.settings.light.method = SC_LIGHT_PATH;
    s.settings.sampling.lens_samples = 4;
    s.settings.light.key = 0.5;
    s.settings.floor = true;
    s.tissues[2].opacity = 0.5;
    s.tissues[1].material.specular = 0.3;
    scene.clip.planes[0] = (sc_plane){{0, 0.6, 0.8}, -40};
    scene.clip.count = 1;
    scene.clip.which = scene.clip.sets[0] = 1;
    scene.camera = sc_camera_look((sc_vec3){150, 200, 120}, (sc_vec3){MIDDLE, MIDDLE, 30},
                                  (sc_vec3){0, 0, 1}, SC_PERSPECTIVE, 0.3);
    image = draw_by_all_kernels(&s, &scene);
}

/* A bar over a floor. */
static int bar_x;
static int bar(double x, double y, double z)
{
    return z < 20 ? 1 : fabs(x - bar_x) < 8 && fabs(y - MIDDLE) < 12 && fabs(z - 52) < 8 ? 2 : 0;
}

/* Paths meet a tissue where it has moved to: they draw what they do if it lies there from the
 * beginning, but for rounding. */
TEST(paths_meet_tissues_that_have_moved)
{
    const sc_vec3 offsets[3] = {[2] = {32, 0, 0}};

    method = SC_LIGHT_PATH;
    for (int voxels = 0; voxels < 2; voxels++) {
        sc_image images[2];
        image_difference d;

        tested_surface = voxels ? SC_SURFACE_VOXEL : SC_SURFACE_SMOOTH;
        for (int i = 0; i < 2; i++) {
            sc_scene scene;
            small_scene s;

            bar_x = i ? 52 : 20;
            s = sky_scene(bar, true, &scene);
            s.settings.light.key = 0.7;
            s.settings.sampling.lens_samples = 16;
            s.tissues[2].part = 1;
            scene.offsets_mm = i ? NULL : offsets;
            images[i] = draw_view(&s, &scene, NULL);
            free_scene(&s);
        }
        assert_true(compare_images(&images[0], &images[1], &d));
        assert_in_range(d.differing_px, 0, 10);
        sc_image_clear(&images[0]);
        sc_image_clear(&images[1]);
    }
    tested_surface = SC_SURFACE_SMOOTH;
    method = SC_LIGHT_GLOBAL;
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

/* The same at half the size, where the same rays are compared, but fewer. */
static int small_balls(double x, double y, double z)
{
    return balls(2 * x, 2 * y, 2 * z);
}

/* Let the plane of step @p i cut the first of the tissues of small_balls, and fade the other one.
 */
static void set_step(int i, sc_scene *scene, float fades[3])
{
    /* on, far on, back, aslant, farther aslant, back, the same again, and fading without a cut */
    static const double steps[][5] = {{0, 0, 1, -30, 1},           {0, 0, 1, -26, 1},
                                      {0, 0, 1, -17, 1},           {0, 0, 1, -33, 0.7},
                                      {0.28, 0, 0.96, -35, 0.7},   {0.28, 0.6, 0.75, -60, 0.7},
                                      {0.28, 0.6, 0.75, -70, 0.5}, {0.28, 0.6, 0.75, -70, 0.45},
                                      {0, 0, 1, 90, 0.3},          {0, 0, 1, 90, 1}};
    const double *step = steps[i];

    scene->clip.planes[0] = (sc_plane){{-step[0], -step[1], -step[2]}, -step[3] / 2};
    fades[0] = 1;
    fades[1] = (float)step[4];
    fades[2] = 1;
    scene->fades = fades;
}

/* While a plane that spares a tissue moves, and while one fades, only rays are followed anew that
 * may meet something else: light is that of all of them. */
TEST(rays_that_stay_give_the_light_of_new_ones)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene_of(MIDDLE + 1, small_balls, true, &scene);
    float fades[3];
    sc_renderer *r;

    s.settings.light.key = 0.5;
    s.tissues[1].clip_set = 1;
    s.tissues[2].fade_group = 1;
    s.tissues[2].opacity = 0.9;
    scene.clip.count = 1;
    scene.clip.set_count = 2;
    scene.clip.which = scene.clip.sets[1] = 1;
    set_step(0, &scene, fades);
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    assert_ok(sc_renderer_gather(&quiet, r, &scene, SC_LIGHT_NEW_RAYS, NULL));
    for (int i = 0; i < 10; i++) {
        SC_OWN(sc_image_clear) sc_image after = {0}, fresh = {0};

        set_step(i, &scene, fades);
        after = draw_after(r, &scene);
        fresh = draw_view(&s, &scene, NULL);
        assert_memory_equal(fresh.rgb, after.rgb, (size_t)SIDE * SIDE * 3);
    }
    sc_renderer_free(r);
}

/* While the camera turns, and a plane moves, rays to a lamp that follows it are followed anew, and
 * those of the floor where the plane lays it bare: light is that of all of them. */
TEST(a_lamp_follows_the_camera)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene_of(MIDDLE + 1, small_balls, true, &scene);
    sc_renderer *r;

    s.settings.light.key = 0.7;
    s.settings.light.lamp = (sc_lamp){true, true, 30, 20, 40, 20};
    s.settings.floor = SC_GROUND_FLOOR;
    scene.clip.count = 1;
    scene.clip.which = scene.clip.sets[0] = 1;
    scene.clip.planes[0] = (sc_plane){{0, 0, -1}, 17};
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    assert_ok(sc_renderer_gather(&quiet, r, &scene, SC_LIGHT_NEW_RAYS, NULL));
    for (int i = 0; i < 3; i++) {
        SC_OWN(sc_image_clear) sc_image after = {0}, fresh = {0};

        scene.camera = sc_camera_look((sc_vec3){20 + 30 * i, 100, 75}, (sc_vec3){20, 20, 10},
                                      (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, SIDE / 4.0);
        scene.clip.planes[0].offset_mm = 17 - 4 * (i / 2);
        after = draw_after(r, &scene);
        fresh = draw_view(&s, &scene, NULL);
        assert_memory_equal(fresh.rgb, after.rgb, (size_t)SIDE * SIDE * 3);
    }
    sc_renderer_free(r);
}

/* @return whether a pixel shows one smooth surface from edge to edge, and no face of the volume,
 * which has no light of its own: as seen by rays through its middle and its corners. */
static bool is_smooth(sc_renderer *r, const sc_scene *scene, int x, int y)
{
    static const double at[5][2] = {{0.5, 0.5}, {0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const int size_px[2] = {SIDE, SIDE};
    sc_vec3 first = {0, 0, 0};
    int id = 0;

    for (int i = 0; i < 5; i++) {
        const sc_pick pick = sc_render_pick(r, scene, size_px, x + at[i][0], y + at[i][1]);

        if (!pick.id ||
            (i && (pick.id != id || sc_vec3_length(sc_vec3_sub(pick.at_mm, first)) > 2.5)))
            return false;
        first = i ? first : pick.at_mm;
        id = pick.id;
    }
    return fmax(first.x, first.y) < SIDE - 1;
}

/* Where light comes evenly from everywhere, and all of it is given back, nothing can be seen: paths
 * lose none of it, and make none. */
TEST(white_in_a_white_room_is_not_seen)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(balls, false, &scene);
    SC_OWN(sc_image_clear) sc_image image = {0};
    double sum = 0;
    sc_renderer *r;
    int count = 0;

    s.settings.light.method = SC_LIGHT_PATH;
    s.settings.sampling.lens_samples = 64;
    paint_map(even_light);
    s.settings.environment = &map;
    for (int i = 0; i < 6; i++)
        s.tissues[1 + i / 3].rgb_linear[i % 3] = 1;
    scene.camera = sc_camera_look((sc_vec3){120, 250, 160}, (sc_vec3){MIDDLE, MIDDLE, 24},
                                  (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    image = draw_view(&s, &scene, NULL);
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    for (int pixel = 0; pixel < SIDE * SIDE; pixel++) {
        const int x = pixel % SIDE, y = pixel / SIDE;
        const double light = light_at(&image, x, y, 0) * ALBEDO / SC_SKY_MEAN;

        if (!is_smooth(r, &scene, x, y))
            continue;
        assert_near(light, 1, 0.2);
        sum += light;
        count++;
    }
    assert_near(sum / count, 1, 0.004);
    sc_renderer_free(r);
}

/* Gathered light is that which paths bring to the smooth surface itself, but for the noise of
 * these, the rounding of pixels, and that its rays meet vertices instead. */
TEST_OF_THREADS(gathered_light_is_that_of_paths)
{
    sc_scene scene;
    SC_OWN(free_scene) small_scene s = sky_scene(balls, false, &scene);
    SC_OWN(sc_image_clear) sc_image gathered = {0}, truth = {0};
    double squares = 0, bias = 0, mean = 0;
    sc_renderer *r;
    int count = 0;

    s.tissues[1].rgb_linear[1] = 0.15F;
    scene.camera = sc_camera_look((sc_vec3){120, 250, 160}, (sc_vec3){MIDDLE, MIDDLE, 24},
                                  (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, SIDE / 2.0);
    gathered = draw_view(&s, &scene, NULL);
    s.settings.light.method = SC_LIGHT_PATH;
    s.settings.sampling.lens_samples = 256;
    s.settings.work.threads = 2;
    truth = draw_view(&s, &scene, NULL);
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    for (int pixel = 0; pixel < SIDE * SIDE; pixel++) {
        const int x = pixel % SIDE, y = pixel / SIDE;

        for (int i = 0; i < 2 && is_smooth(r, &scene, x, y); i++) {
            const double error = light_at(&gathered, x, y, i) - light_at(&truth, x, y, i);

            squares += error * error;
            bias += error;
            mean += light_at(&truth, x, y, i);
            count++;
        }
    }
    assert_true(count > 2000);
    assert_true(sqrt(squares / count) < 0.025 * mean / count);
    assert_true(fabs(bias) < 0.006 * mean);
    sc_renderer_free(r);
}

RUN_TESTS(NULL, NULL)
