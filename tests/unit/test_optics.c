/* SPDX-License-Identifier: BSD-3-Clause */
/* What a lens, a shutter and a picture of all directions do, against closed forms. */
#include "check.h"
#include "compare_images.h"

#include "scenes.h"

#include <math.h>

enum { SIDE = 61, MIDDLE = 30, PX = 160 };

/* A scene of a black shape on white, without shades: a pixel shows, in linear light, which share of
 * it is free. */
static small_scene black_scene(int (*shape)(double, double, double))
{
    small_scene s = make_scene(cube_volume(SIDE, 2, shape), 1);

    s.settings.width_px = s.settings.height_px = PX;
    s.settings.sampling.everywhere = false;
    s.settings.skip = SC_SKIP_LEAP;
    s.settings.sampling.samples = 5;
    s.settings.sampling.lens_samples = 128;
    s.settings.light = (sc_lighting){.method = SC_LIGHT_FLAT, .ambient = 1};
    s.tissues[1].material = (sc_material){0, 0, 1};
    for (int i = 0; i < 3; i++)
        s.tissues[1].rgb_linear[i] = 0;
    return s;
}

/* A camera in front that looks at the middle from @p distance mm, which shows @p height_mm there.
 */
static sc_scene scene_from(double distance, double height_mm)
{
    const sc_vec3 middle = {MIDDLE, MIDDLE, MIDDLE};

    return (sc_scene){.clip.set_count = 1,
                      .camera = sc_camera_look((sc_vec3){MIDDLE, MIDDLE + distance, MIDDLE}, middle,
                                               (sc_vec3){0, 0, 1}, SC_PERSPECTIVE,
                                               height_mm / distance / 2)};
}

static double free_at(const sc_image *image, int x, int y)
{
    return sc_srgb_to_linear(image->rgb[((size_t)y * (size_t)image->width_px + (size_t)x) * 3] /
                             255.0);
}

/* ---- aperture ---- */

static int left_half(double x, double y, double z)
{
    return x < 30 && fabs(y - 30) < 2 ? 1 : 0;
}

/* The share of a disc of radius 1 on one side of a line at distance @p u from its middle. */
static double share_of_disc(double u)
{
    const double v = fmax(-1, fmin(1, u));

    return 0.5 + (v * sqrt(1 - v * v) + asin(v)) / M_PI;
}

/* A straight edge out of focus is as wide as the circle of confusion, and has its profile: at
 * distance d, with the lens of diameter a focused on f, it is a |d - f| / f wide there. */
TEST(an_edge_out_of_focus_has_the_profile_of_the_circle_of_confusion)
{
    static const struct {
        double focus_mm, aperture_mm;
    } cases[] = {{200, 20}, {80, 20}, {150, 40}, {100, 20}};
    enum { DISTANCE = 100, HEIGHT_MM = 40, ROWS = 16 /* which are all alike */ };

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        small_scene s = black_scene(left_half);
        sc_scene scene = scene_from(DISTANCE, (double)HEIGHT_MM * ROWS / PX);
        SC_OWN(sc_image_clear) sc_image image = {0};
        /* the edge in perspective: that of the near face */
        const double d = DISTANCE - 1.5, px_per_mm = (double)PX / HEIGHT_MM * DISTANCE / d;
        const double radius_px =
            cases[i].aperture_mm / 2 * fabs(d - cases[i].focus_mm) / cases[i].focus_mm * px_per_mm;
        double worst = 0, squares = 0;
        int count = 0;

        s.settings.height_px = ROWS;
        scene.camera.aperture_mm = cases[i].aperture_mm;
        scene.camera.focus_mm = cases[i].focus_mm;
        image = draw_view(&s, &scene, NULL);
        /* Patient's left is right in the picture: the shape is left of the edge at x = 29.5. The
         * camera looks from the front, so that x grows to the left. */
        for (int y = 0; y < ROWS; y++) {
            for (int x = PX / 2 - 30; x < PX / 2 + 30; x++) {
                const double edge_px = PX / 2.0 + 0.5 * px_per_mm;
                const double off = (edge_px - (x + 0.5)) / fmax(radius_px, 0.5);
                const double error = free_at(&image, x, y) - share_of_disc(off);

                worst = fmax(worst, fabs(error));
                squares += error * error;
                count++;
            }
        }
        if (worst > (radius_px < 1 ? 0.4 : 0.06) || sqrt(squares / count) > 0.03)
            fail_msg("case %zu, radius %.1f px: off by %.3f, RMS %.4f", i, radius_px, worst,
                     sqrt(squares / count));
        free_scene(&s);
    }
}

/* Depth of field is the same for every kernel, number of threads and size of tiles. */
TEST(depth_of_field_has_the_same_bits_however_it_is_drawn)
{
    SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 0.7);
    sc_scene scene = front_view(&s);
    sc_image image;

    s.settings.sampling.everywhere = false;
    s.settings.sampling.lens_samples = 32;
    scene.camera.aperture_mm = 20;
    scene.camera.focus_mm = sc_vec3_length(scene.camera.position_mm);
    image = draw_by_all_kernels(&s, &scene);
    sc_image_clear(&image);
}

static int grains(double x, double y, double z)
{
    return (int)x % 6 < 3 && (int)z % 6 < 3 && fabs(y - 30) < 4;
}

/* The noise that is left, where much detail is far out of focus: against 512 rays a pixel. */
TEST(blur_is_smooth)
{
    SC_OWN(free_scene) small_scene s = black_scene(grains);
    sc_scene scene = scene_from(100, 25);
    SC_OWN(sc_image_clear) sc_image few = {0}, many = {0};
    image_difference d;

    s.settings.width_px = s.settings.height_px = PX / 2;
    scene.camera.aperture_mm = 16;
    scene.camera.focus_mm = 70;
    few = draw_view(&s, &scene, NULL);
    s.settings.sampling.lens_samples = 512;
    s.settings.sampling.everywhere = true;
    many = draw_view(&s, &scene, NULL);
    assert_true(compare_images(&few, &many, &d));
    if (d.rms > 2.6 || d.largest > 14)
        fail_msg("noise: RMS %.2f of 255, at most %d", d.rms, d.largest);
}

/* ---- all directions ---- */

/* Six balls around the middle, the first to the patient's right, of radius 9 at a distance of 20.
 */
static const sc_vec3 places[] = {{20, 0, 0},  {-20, 0, 0}, {0, 20, 0},
                                 {0, -20, 0}, {0, 0, 20},  {0, 0, -20}};

static int balls(double x, double y, double z)
{
    for (size_t i = 0; i < SC_COUNT_OF(places); i++) {
        const double dx = x - MIDDLE - places[i].x, dy = y - MIDDLE - places[i].y;
        const double dz = z - MIDDLE - places[i].z;

        if (dx * dx + dy * dy + dz * dz < 81)
            return (int)i + 1;
    }
    return 0;
}

/* From the middle each ball is seen in its direction, as large as its angle, and nothing else. */
TEST(balls_on_all_sides_are_seen_in_their_directions)
{
    small_scene s = make_scene(cube_volume(SIDE, 7, balls), 1);
    sc_scene scene = {.clip.set_count = 1};
    SC_OWN(sc_image_clear) sc_image image = {0};
    double covered = 0, voxels = 0, angle = asin(9.0 / 20);
    int wrong = 0;

    s.settings.width_px = 240;
    s.settings.height_px = 120;
    s.settings.light = (sc_lighting){.method = SC_LIGHT_FLAT, .ambient = 1};
    for (int id = 1; id < 7; id++) {
        s.tissues[id].material = (sc_material){1, 0, 1};
        for (int c = 0; c < 3; c++)
            s.tissues[id].rgb_linear[c] = (float)(((id * 11) >> c & 1) / 2.0);
    }
    scene.camera =
        sc_camera_look((sc_vec3){MIDDLE, MIDDLE, MIDDLE}, (sc_vec3){MIDDLE, MIDDLE + 1, MIDDLE},
                       (sc_vec3){0, 0, 1}, SC_EQUIRECTANGULAR, M_PI / 2);
    image = draw_by_all_kernels(&s, &scene);
    for (int y = 0; y < 120; y++) {
        const double latitude = (59.5 - y) * M_PI / 120;

        for (int x = 0; x < 240; x++) {
            /* forward is the front, right is the patient's right (x grows to the right) */
            const double longitude = (x - 119.5) * M_PI / 120;
            const sc_vec3 d = {cos(latitude) * sin(longitude), cos(latitude) * cos(longitude),
                               sin(latitude)};
            const uint8_t *p = image.rgb + 3 * ((size_t)y * 240 + (size_t)x);
            const bool seen = p[0] != 255 || p[1] != 255 || p[2] != 255;
            double nearest = M_PI;

            covered += seen ? cos(latitude) * pow(M_PI / 120, 2) : 0;
            for (size_t i = 0; i < SC_COUNT_OF(places); i++) {
                const double off = acos(sc_vec3_dot(d, sc_vec3_scale(places[i], 1 / 20.0)));
                bool same = true;

                for (int c = 0; c < 3; c++)
                    same = same && (p[c] > 100) == ((((int)i + 1) * 11) >> c & 1);
                wrong += off < angle - 0.04 && !(seen && same);
                nearest = fmin(nearest, off);
            }
            wrong += nearest > angle + 0.03 && seen;
        }
    }
    assert_int_equal(wrong, 0);
    for (int z = 0; z < SIDE; z++) {
        for (int i = 0; i < SIDE * SIDE; i++) {
            const int y = i / SIDE;

            voxels += balls(i % SIDE, y, z) != 0;
        }
    }
    angle = asin(cbrt(voxels / 6 * 3 / (4 * M_PI)) / 20); /* surfaces keep the volume */
    assert_near(covered / (6 * 2 * M_PI * (1 - cos(angle))), 1, 0.03);
    free_scene(&s);
}

/* ---- inside ---- */

enum { TUBE_MM = 20 };

static int tube(double x, double y, double z)
{
    const double dx = x - MIDDLE, dz = z - MIDDLE;

    return dx * dx + dz * dz > TUBE_MM * TUBE_MM;
}

/* In a tube the light of the lamp at the eye falls off as that of a real one: to a half at twice
 * the radius, where it has the strength of the other lamps and a little more. */
TEST(light_falls_off_along_a_tube)
{
    enum { ROWS = 8 };
    SC_OWN(free_scene) small_scene s = black_scene(tube);
    /* within its end, with a field of view of 90 degrees across */
    sc_scene scene = scene_from(28, 56.0 * ROWS / PX);
    SC_OWN(sc_image_clear) sc_image image = {0};
    const double lamp_mm = 2 * TUBE_MM, gain = 1.3, head = 0.7;

    s.settings.light = (sc_lighting){.method = SC_LIGHT_PLAIN, .head = head};
    s.settings.height_px = ROWS;
    s.settings.background[0] = s.settings.background[1] = s.settings.background[2] = 0;
    s.settings.sampling.lens_samples = 0;
    s.tissues[1].material = (sc_material){1, 0, 1};
    for (int i = 0; i < 3; i++)
        s.tissues[1].rgb_linear[i] = 1;
    scene.inside = true;
    scene.around_mm = TUBE_MM;
    image = draw_by_all_kernels(&s, &scene);
    for (int x = 8; x < PX / 2 - 40; x += 4) {
        const double across = (PX / 2.0 - (x + 0.5)) / (PX / 2.0);
        const double sine = across / sqrt(1 + across * across), far_mm = TUBE_MM / sine;
        const double expected =
            gain * head * sine * lamp_mm * lamp_mm / (lamp_mm * lamp_mm + far_mm * far_mm);

        if (fabs(free_at(&image, x, ROWS / 2) / expected - 1) > 0.06)
            fail_msg("pixel %d, %.1f mm away: %.3f instead of %.3f", x, far_mm,
                     free_at(&image, x, ROWS / 2), expected);
    }
}

/* ---- shutter ---- */

enum { FRAMES = 5 };

static int block(double x, double y, double z)
{
    return x > 1 && x < 59 && z > 1 && z < 59 && fabs(y - 30) < 8;
}

/* Draw frame 2 of an animation, as of the moments of its shutter. The caller frees it. */
static sc_image draw_open(const small_scene *s, const sc_animation *animation, int *moments)
{
    sc_image mean, one;
    sc_mixer mixer;
    sc_renderer *r;
    sc_render_stats stats;
    sc_timeline t;
    size_t count;
    const sc_vec3 *hull;
    SC_OWN(sc_free_at) float *sums = NULL;

    sc_mixer_init(&mixer);
    assert_ok(sc_renderer_new(&quiet, &s->settings, &s->prepared.view, s->tissues, &r));
    hull = sc_renderer_hull(r, &count);
    sc_timeline_resolve(animation, hull, count, 1, &t);
    *moments = sc_timeline_moments(&t, 2, hull, count, PX);
    assert_ok(sc_image_init(&quiet, PX, PX, &one));
    assert_ok(sc_image_init(&quiet, PX, PX, &mean));
    assert_ok(SC_ZALLOC(&quiet, (size_t)PX * PX * 3, &sums));
    for (int i = 0; i < *moments; i++) {
        const sc_scene scene = sc_timeline_scene(&t, sc_timeline_moment(&t, 2, i, *moments), NULL);

        sc_render_view(r, &scene, NULL, NULL, NULL, &one, &stats);
        sc_image_add(&mixer, &one, 0, PX, sums);
    }
    sc_image_mean(&mixer, sums, *moments, 0, PX, &mean);
    sc_image_clear(&one);
    sc_renderer_free(r);
    return mean;
}

/* An orthographic camera, which shows 80 mm, and a plane that sweeps by @p mm from frame to frame,
 * through the middle of the picture in frame 2. */
static sc_animation sweep_of(double mm, double shutter)
{
    const sc_vec3 middle = {MIDDLE, MIDDLE, MIDDLE};
    sc_animation a = {.frames = FRAMES,
                      .camera = {.fixed = true,
                                 .position_mm = {MIDDLE, 300, MIDDLE},
                                 .target_mm = middle,
                                 .up = {0, 0, 1},
                                 .fov_deg = 15,
                                 .projection = SC_ORTHOGRAPHIC,
                                 .zoom = 1,
                                 .optics = {.shutter = shutter}},
                      .sweep_count = 1,
                      .sweeps = {{.normal = {1, 0, 0}, .at = {MIDDLE - 2 * mm, false}}}};
    sc_track *track = &a.sweeps[0].at_track;

    track->count = 2;
    track->keys[0] = (sc_key_frame){.at = 0, .value = {MIDDLE - 2 * mm, 0, 0}};
    track->keys[1] = (sc_key_frame){.at = 1, .value = {MIDDLE + 2 * mm, 0, 0}};
    return a;
}

/* The edge of what a plane has left is blurred by as much as it moves while the shutter is open,
 * evenly in linear light. */
TEST(an_edge_that_moves_is_blurred_by_how_far_it_moves)
{
    static const double shutters[] = {0.5, 1};
    SC_OWN(free_scene) small_scene s = black_scene(block);

    s.settings.caps = false;
    s.settings.sampling.everywhere = true;
    s.settings.sampling.lens_samples = 0;
    for (size_t i = 0; i < SC_COUNT_OF(shutters); i++) {
        const sc_animation still = sweep_of(4, 0), open = sweep_of(4, shutters[i]);
        int moments;
        SC_OWN(sc_image_clear) sc_image sharp = draw_open(&s, &still, &moments);
        SC_OWN(sc_image_clear) sc_image blurred = {0};
        double left = 0, length_px;

        assert_int_equal(moments, 1);
        /* The camera looks from the front, so that x grows to the left: the block is left of the
         * edge, 28.5 mm wide. */
        for (int x = 0; x < PX; x++)
            left += 1 - free_at(&sharp, x, PX / 2);
        length_px = 4 * shutters[i] * left / 28.5;
        assert_true(length_px > 2);
        blurred = draw_open(&s, &open, &moments);
        assert_in_range(moments, length_px, length_px * 1.5 + 1);
        for (int x = PX / 2 - 20; x < PX / 2 + 20; x++) {
            const double expected = fmax(0, fmin(1, (x + 0.5 - PX / 2.0) / length_px + 0.5));

            if (fabs(free_at(&blurred, x, PX / 2) - expected) > 0.06)
                fail_msg("shutter %g, %.1f px, pixel %d: %.3f instead of %.3f", shutters[i],
                         length_px, x, free_at(&blurred, x, PX / 2), expected);
        }
    }
}

/* What does not move, or only changes its light, is drawn once. */
TEST(a_frame_at_rest_is_drawn_once)
{
    SC_OWN(free_scene) small_scene s = black_scene(block);
    sc_animation a = sweep_of(0, 1);
    int moments;

    s.settings.sampling.lens_samples = 0;
    sc_image_clear(&(sc_image){.rgb = draw_open(&s, &a, &moments).rgb});
    assert_int_equal(moments, 1);
    a.camera.fixed = false;
    a.camera.axis = (sc_vec3){0, 0, 1};
    a.camera.turns = 0.01;
    sc_image_clear(&(sc_image){.rgb = draw_open(&s, &a, &moments).rgb});
    assert_in_range(moments, 1, 2);
    a.camera.turns = 0.1;
    sc_image_clear(&(sc_image){.rgb = draw_open(&s, &a, &moments).rgb});
    assert_in_range(moments, 4, 12);
}

RUN_TESTS(NULL, NULL)
