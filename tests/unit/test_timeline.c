/* SPDX-License-Identifier: BSD-3-Clause */
#include "check.h"

#include "segcast/image.h"
#include "segcast/timeline.h"

enum { CORNERS = 8 };

static const sc_vec3 corners[CORNERS] = {{-20, -35, 10}, {40, -35, 10},  {-20, 25, 10},
                                         {40, 25, 10},   {-20, -35, 90}, {40, -35, 90},
                                         {-20, 25, 90},  {40, 25, 90}};

static sc_animation animation(int frames)
{
    return (sc_animation){
        .frames = frames,
        .camera = {.axis = {0, 0, 1}, .turns = 1, .elevation_deg = 20, .fov_deg = 30, .zoom = 1}};
}

TEST(an_orbit_begins_in_front_and_closes_without_repeating_a_frame)
{
    enum { FRAMES = 12 };
    const sc_animation a = animation(FRAMES);
    sc_vec3 away;
    sc_timeline t;

    sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
    for (int k = 0; k < FRAMES; k++) {
        const sc_camera c = sc_timeline_scene(&t, k, NULL).camera;
        const sc_camera next = sc_timeline_scene(&t, (k + 1) % FRAMES, NULL).camera;

        away = sc_vec3_sub(c.position_mm, t.animation.camera.target_mm);
        assert_near(sc_vec3_length(away), t.animation.camera.distance_mm, 1e-9);
        assert_near(sc_vec3_length(sc_vec3_sub(next.position_mm, c.position_mm)),
                    2 * t.animation.camera.distance_mm * cos(20 * M_PI / 180) * sin(M_PI / FRAMES),
                    1e-9);
        assert_near(sc_vec3_dot(c.right, c.up), 0, 1e-12);
    }
    away = sc_vec3_sub(sc_timeline_scene(&t, 0, NULL).camera.position_mm,
                       t.animation.camera.target_mm);
    assert_true(away.y > 0);
    assert_near(away.x, 0, 1e-9);
    /* seen from the front, the patient's left is on the right */
    assert_near(sc_timeline_scene(&t, 0, NULL).camera.right.x, -1, 1e-9);
    away = sc_vec3_sub(sc_timeline_scene(&t, 3, NULL).camera.position_mm,
                       t.animation.camera.target_mm);
    assert_true(away.x < 0); /* after a quarter turn, seen from the left */
}

static void expect_in_view(const sc_camera *c, double aspect, const sc_vec3 *points, double *fill)
{
    for (int i = 0; i < CORNERS; i++) {
        const sc_vec3 d = sc_vec3_sub(points[i], c->position_mm);
        const double depth = c->projection == SC_PERSPECTIVE ? sc_vec3_dot(d, c->forward) : 1;
        const double x = sc_vec3_dot(d, c->right) / (depth * c->half_height * aspect);
        const double y = sc_vec3_dot(d, c->up) / (depth * c->half_height);

        assert_true(fabs(x) < 1 && fabs(y) < 1);
        *fill = fmax(*fill, fmax(fabs(x), fabs(y)));
    }
}

/* No corner leaves the picture in any frame, and some come near its edge. */
TEST(framing_keeps_all_corners_in_the_picture)
{
    for (int n = 0; n < 24; n++) {
        const double aspect = n % 3 == 0 ? 0.5 : n % 3 == 1 ? 1 : 2.4;
        sc_animation a = animation(36);
        double fill = 0;
        sc_timeline t;

        a.camera.projection = n & 1 ? SC_ORTHOGRAPHIC : SC_PERSPECTIVE;
        a.camera.axis = sc_vec3_unit((sc_vec3){n % 4 == 0, n % 5 == 0, 1 - n % 2});
        if (sc_vec3_length(a.camera.axis) == 0)
            a.camera.axis = (sc_vec3){0, 1, 0};
        sc_timeline_resolve(&a, corners, CORNERS, aspect, &t);
        for (int k = 0; k < 36; k++) {
            const sc_camera c = sc_timeline_scene(&t, k, NULL).camera;

            expect_in_view(&c, aspect, corners, &fill);
        }
        assert_true(fill > 0.945); /* the margin is 1.05, and 36 frames need not meet the worst */
    }
}

/* Fill low and high of what a picture sees of the points, in x and y: -1 and 1 are its edges. */
static void see(const sc_camera *c, double aspect, const sc_vec3 *points, size_t count,
                double low[2], double high[2])
{
    for (size_t i = 0; i < count; i++) {
        const sc_vec3 d = sc_vec3_sub(points[i], c->position_mm);
        const double depth = c->projection == SC_PERSPECTIVE ? sc_vec3_dot(d, c->forward) : 1;
        const double at[2] = {sc_vec3_dot(d, c->right) / (depth * c->half_height * aspect),
                              sc_vec3_dot(d, c->up) / (depth * c->half_height)};

        for (int axis = 0; axis < 2; axis++) {
            low[axis] = fmin(low[axis], at[axis]);
            high[axis] = fmax(high[axis], at[axis]);
        }
    }
}

enum { BALL = 5000 };

/* Points of an ellipsoid; the box around it has other corners. @param lumps one lump far out. */
static void ellipsoid_points(double rx, double ry, double rz, bool lump, sc_vec3 out[BALL])
{
    for (int i = 0; i < BALL; i++) {
        const double z = 2 * (i + 0.5) / BALL - 1, r = sqrt(1 - z * z), turn = 2.39996 * i;

        out[i] = (sc_vec3){30 + rx * r * cos(turn), -70 + ry * r * sin(turn), 400 + rz * z};
    }
    if (lump)
        out[BALL / 3] = (sc_vec3){30 + 1.6 * rx, -70, 400 + 0.3 * rz};
}

/* Over a whole turn, a body fills the height of the picture, or its width, from edge to edge, less
 * the margin, in the middle of it; also one that is not round, with a lump on one side. */
TEST(framing_is_tight_and_centred)
{
    static const double radii[][3] = {{50, 50, 50}, {20, 12, 90}, {60, 45, 70}, {90, 70, 10}};
    static sc_vec3 points[BALL];

    for (size_t n = 0; n < 4 * SC_COUNT_OF(radii); n++) {
        const double *r = radii[n / 4], aspect = 16.0 / 9;
        sc_animation a = animation(90);
        double low[2] = {2, 2}, high[2] = {-2, -2};
        sc_timeline t;

        a.camera.projection = n & 1 ? SC_ORTHOGRAPHIC : SC_PERSPECTIVE;
        ellipsoid_points(r[0], r[1], r[2], n & 2, points);
        sc_timeline_resolve(&a, points, BALL, aspect, &t);
        for (int k = 0; k < 90; k++) {
            const sc_camera c = sc_timeline_scene(&t, k, NULL).camera;

            see(&c, aspect, points, BALL, low, high);
        }
        for (int axis = 0; axis < 2; axis++) {
            assert_true(low[axis] > -1 && high[axis] < 1);
            assert_near(low[axis] + high[axis], 0, 0.02);
        }
        assert_true(fmax(high[0] - low[0], high[1] - low[1]) > 2 * 0.945);
    }
}

/* What is never turned is framed as it stands; a given target stays. */
TEST(framing_heeds_what_the_job_says)
{
    static sc_vec3 points[BALL];
    sc_animation a = animation(20);
    sc_timeline whole, still, given;

    ellipsoid_points(20, 90, 30, false, points);
    sc_timeline_resolve(&a, points, BALL, 1, &whole);
    a.camera.turns = 0;
    sc_timeline_resolve(&a, points, BALL, 1, &still);
    assert_true(still.animation.camera.distance_mm < 0.8 * whole.animation.camera.distance_mm);
    a.camera.turns = 1;
    a.camera.has_target = true;
    a.camera.target_mm = (sc_vec3){30, -60, 400};
    sc_timeline_resolve(&a, points, BALL, 1, &given);
    assert_near(given.animation.camera.target_mm.y, -60, 0);
    assert_true(given.animation.camera.distance_mm > whole.animation.camera.distance_mm + 5);
}

TEST(a_sweep_is_monotone_and_reaches_both_ends)
{
    sc_animation a = animation(50);
    sc_timeline t;

    a.sweep_count = 2;
    a.sweeps[0] =
        (sc_sweep){.normal = {0, -1, 0},
                   .at_track = {2,
                                {{.at = 0.2, .value = {0, 1, 0}},
                                 {.at = 0.8, .value = {60, 1, 0}, .ease.kind = SC_EASE_SMOOTH}}}};
    a.sweeps[1] = (sc_sweep){
        .normal = {1, 0, 0},
        .at_track = {2, {{.at = 0, .value = {-5, 0, 0}}, {.at = 1, .value = {5, 0, 0}}}}};
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    assert_near(sc_timeline_scene(&t, 0, NULL).clip.planes[0].offset_mm, 25,
                1e-9); /* the anterior face of the box, y = 25 */
    assert_near(sc_timeline_scene(&t, 49, NULL).clip.planes[0].offset_mm, 25 - 36, 1e-9);
    assert_near(sc_timeline_scene(&t, 0, NULL).clip.planes[1].offset_mm, 5, 1e-9);
    assert_near(sc_timeline_scene(&t, 49, NULL).clip.planes[1].offset_mm, -5, 1e-9);
    for (int k = 1; k < 50; k++)
        assert_true(sc_timeline_scene(&t, k, NULL).clip.planes[0].offset_mm <=
                    sc_timeline_scene(&t, k - 1, NULL).clip.planes[0].offset_mm);
    assert_near(sc_timeline_scene(&t, 9, NULL).clip.planes[0].offset_mm, 25, 1e-9);
    assert_near(sc_timeline_scene(&t, 40, NULL).clip.planes[0].offset_mm, 25 - 36, 1e-9);
}

/* A plane cuts from a key frame that is true until one that is false. */
TEST(a_plane_cuts_while_it_is_active)
{
    sc_animation a = animation(11);
    sc_timeline t;

    a.sweep_count = 2;
    a.sweeps[1] = (sc_sweep){.normal = {0, 0, 1}};
    a.sweeps[0] =
        (sc_sweep){.normal = {0, 1, 0},
                   .has_active = true,
                   .active_track = {3, {{.at = 0}, {.at = 0.25, .value = {1, 0, 0}}, {.at = 0.7}}}};
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    t.clip_sets[1].spares[1] = 1;
    t.clip_set_count = 2;
    for (int k = 0; k <= 10; k++) {
        const sc_scene scene = sc_timeline_scene(&t, k, NULL);
        const bool cuts = k >= 3 && k <= 6;

        assert_int_equal(scene.clip.count, cuts ? 2 : 1);
        assert_near(scene.clip.planes[scene.clip.count - 1].normal.z, 1, 0);
        assert_int_equal(scene.clip.sets[0], cuts ? 3 : 1);
        assert_int_equal(scene.clip.sets[1], cuts ? 1 : 0);
    }
    /* The first key frame holds from the beginning. */
    a.sweeps[0].active_track = (sc_track){
        3, {{.at = 0.2, .value = {1, 0, 0}}, {.at = 0.4}, {.at = 0.7, .value = {1, 0, 0}}}};
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    for (int k = 0; k <= 10; k++)
        assert_int_equal(sc_timeline_scene(&t, k, NULL).clip.which, k < 4 || k >= 7 ? 3 : 2);
}

/* Tissues are excepted from a plane from one key frame of its exceptions to the next. */
TEST(exceptions_of_a_plane_change_at_their_key_frames)
{
    sc_animation a = animation(11);
    sc_timeline t;

    a.sweep_count = 2;
    a.sweeps[0] = (sc_sweep){.normal = {0, 0, 1}};
    a.sweeps[1] = (sc_sweep){.normal = {0, 1, 0}, .except_count = 3, .except_at = {0.2, 0.4, 0.8}};
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    t.clip_sets[1].spares[1] = 1u << 0 | 1u << 2;
    t.clip_set_count = 2;
    for (int k = 0; k <= 10; k++) {
        assert_int_equal(sc_timeline_scene(&t, k, NULL).clip.sets[0], 3);
        assert_int_equal(sc_timeline_scene(&t, k, NULL).clip.sets[1], k >= 4 && k < 8 ? 3 : 1);
    }
}

TEST(a_plane_turns_about_its_line)
{
    enum { FRAMES = 11 };
    const sc_vec3 line_mm = {10, -5, 50}; /* the middle of the box: no point is given */
    sc_animation a = animation(FRAMES);
    sc_move moves[2] = {{.verb = {.kind = SC_VERB_TURN,
                                  .begin = 0,
                                  .end = 0.5,
                                  .plane = 2,
                                  .angle_deg = 90,
                                  .line.has_axis = true,
                                  .line.axis = {0, 0, 1}}},
                        {.verb = {.kind = SC_VERB_TURN,
                                  .begin = 0.5,
                                  .end = 1,
                                  .plane = 2,
                                  .angle_deg = -90,
                                  .line.has_axis = true,
                                  .line.axis = {0, 0, 1},
                                  .line.has_point = true,
                                  .line.point_mm = line_mm}}};
    sc_timeline t;
    sc_plane plane;

    a.sweep_count = 2;
    for (int i = 0; i < 2; i++)
        a.sweeps[i] = (sc_sweep){.normal = {0, -1, 0}, .at = {.value = 75, .percent = true}};
    a.moves = moves;
    a.move_count = 2;
    sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
    for (int k = 0; k < FRAMES; k++) {
        const double turned = (k <= 5 ? k : 10 - k) * 18 * M_PI / 180;

        plane = sc_timeline_scene(&t, k, NULL).clip.planes[1];
        assert_near(plane.normal.x, sin(turned), 1e-12);
        assert_near(plane.normal.y, -cos(turned), 1e-12);
        /* the line stays where it is: 15 mm on the side that is removed */
        assert_near(sc_vec3_dot(plane.normal, line_mm) + plane.offset_mm, -15, 1e-12);
        assert_near(sc_timeline_scene(&t, k, NULL).clip.planes[0].normal.y, -1,
                    0); /* the other stays */
    }
    moves[0].verb.line.has_axis = moves[1].verb.line.has_axis =
        false; /* upwards, unless it is across */
    sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
    assert_near(sc_timeline_scene(&t, 5, NULL).clip.planes[1].normal.x, 1, 1e-12);
    a.sweeps[1].normal = (sc_vec3){0, 0, 1};
    sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
    assert_near(sc_timeline_scene(&t, 5, NULL).clip.planes[1].normal.x, 1, 1e-12);
}

TEST(easing_begins_at_0_and_ends_at_1)
{
    for (int e = SC_EASE_LINEAR; e <= SC_EASE_BEZIER; e++) {
        const sc_ease ease = {.kind = (sc_ease_kind)e, .bezier = {0.42, 0, 0.58, 1}};

        assert_near(sc_ease_value(ease, 0), 0, 0);
        assert_near(sc_ease_value(ease, 1), 1, 0);
        for (int i = 1; i <= 100; i++)
            assert_true(sc_ease_value(ease, i / 100.0) > sc_ease_value(ease, (i - 1) / 100.0));
    }
}

TEST(a_bezier_curve_is_solved_for_the_time)
{
    /* x, y of the curve at s = 1/2 follow from its points without solving anything. */
    static const double curves[][4] = {
        {0.25, 0.1, 0.25, 1}, {0.42, 0, 0.58, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {1, 0, 1, 0}};

    for (size_t i = 0; i < SC_COUNT_OF(curves); i++) {
        const double *b = curves[i];
        const sc_ease ease = {SC_EASE_BEZIER, {b[0], b[1], b[2], b[3]}};
        double before = 0;

        /* Where the third stands upright, a rounding error of x is a cubic root of one in y. */
        assert_near(sc_ease_value(ease, (3 * b[0] + 3 * b[2] + 1) / 8),
                    (3 * b[1] + 3 * b[3] + 1) / 8, i == 2 ? cbrt(0x1p-52) : 1e-9);
        for (int k = 0; k <= 1000; k++) {
            const double value = sc_ease_value(ease, k / 1000.0);

            assert_true(value >= before && value <= 1);
            before = value;
        }
    }
    for (int k = 0; k <= 10; k++)
        assert_near(sc_ease_value((sc_ease){SC_EASE_BEZIER, {1 / 3.0, 1 / 3.0, 2 / 3.0, 2 / 3.0}},
                                  k / 10.0),
                    k / 10.0, 1e-12);
}

TEST(a_track_meets_its_key_frames_and_is_constant_outside)
{
    const sc_track track = {3,
                            {{0.25, {.kind = SC_EASE_OUT}, {4, 0, 0}},
                             {0.5, {.kind = SC_EASE_SMOOTH}, {8, -2, 0}},
                             {0.75, {.kind = SC_EASE_LINEAR}, {0, 0, 6}}}};

    assert_near(sc_track_value(&track, 0).x, 4, 0);
    assert_near(sc_track_value(&track, 0.25).x, 4, 0);
    assert_near(sc_track_value(&track, 0.3125).x, 4 + 4 * 0.15625, 1e-12); /* smooth at a quarter */
    assert_near(sc_track_value(&track, 0.5).x, 8, 0);
    assert_near(sc_track_value(&track, 0.625).y, -1, 1e-12);
    assert_near(sc_track_value(&track, 0.625).z, 3, 1e-12);
    assert_near(sc_track_value(&track, 0.75).z, 6, 0);
    assert_near(sc_track_value(&track, 1).z, 6, 0);
}

/* The camera rises from the front over the head and comes down at the back: it never turns faster
 * than it rises, and everything stays in the picture, which is tight. */
TEST(a_camera_goes_over_the_pole_without_a_flip)
{
    enum { FRAMES = 181 };

    for (int n = 0; n < 4; n++) {
        sc_animation a = animation(FRAMES);
        sc_timeline t;
        double fill = 0;

        a.camera.turns = 0;
        a.camera.projection = n & 1 ? SC_ORTHOGRAPHIC : SC_PERSPECTIVE;
        a.camera.tracks.elevation =
            (sc_track){2, {{0, {0}, {0, 0, 0}}, {1, {0}, {n & 2 ? -180 : 180, 0, 0}}}};
        sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
        for (int k = 0; k < FRAMES; k++) {
            const sc_camera c = sc_timeline_scene(&t, k, NULL).camera;

            expect_in_view(&c, 1.5, corners, &fill);
            assert_near(c.right.x, -1, 1e-9);
            if (k > 0) {
                const sc_camera before = sc_timeline_scene(&t, k - 1, NULL).camera;

                assert_near(acos(sc_vec3_dot(c.up, before.up)) * 180 / M_PI, 1, 1e-4);
            }
        }
        assert_near(sc_timeline_scene(&t, FRAMES - 1, NULL).camera.up.z, -1, 1e-9);
        assert_true(fill > 0.945);
    }
}

TEST(light_follows_its_key_frames)
{
    const sc_lighting light = {.key = 0.5, .head = 0.1, .occlusion = 1};
    const sc_light_tracks tracks = {
        .key = {2, {{0.25, {0}, {1, 0, 0}}, {0.75, {0}, {0, 0, 0}}}},
        .occlusion = {2, {{0, {0}, {0.25, 0, 0}}, {1, {0}, {0.75, 0, 0}}}},
        .shadows = {2, {{0, {0}, {1, 0, 0}}, {1, {0}, {0.5, 0, 0}}}}};
    const sc_light_tracks none = {0};

    assert_near(sc_light_at(&light, &tracks, 0).key, 1, 0);
    assert_near(sc_light_at(&light, &tracks, 0.5).key, 0.5, 1e-12);
    assert_near(sc_light_at(&light, &tracks, 1).key, 0, 0);
    assert_near(sc_light_at(&light, &tracks, 0.5).occlusion, 0.5, 1e-12);
    assert_near(sc_light_at(&light, &tracks, 0.5).head, 0.1, 0);
    assert_near(sc_light_at(&light, &none, 0.5).key, 0.5, 0);
    /* What is made once has to do for all frames. */
    assert_near(sc_light_of_all(&light, &tracks).occlusion, 0.75, 0);
    assert_near(sc_light_at(&light, &tracks, 0.5).shadows, 0.75, 1e-12);
    assert_near(sc_light_of_all(&light, &tracks).shadows, 1, 0);
    assert_near(sc_light_of_all(&light, &none).occlusion, 1, 0);
}

enum { TEXT_FRAMES = 101, TEXT_FPS = 20 };

/* @return sc_scene.dark_text of a film of TEXT_FRAMES frames. */
static double dark_text_at(const sc_background *background, int k)
{
    static const sc_lighting light;
    static const sc_light_tracks light_tracks;
    static const sc_grey_tracks grey;
    const sc_timeline t = {.animation = {.frames = TEXT_FRAMES},
                           .looks = {.light = &light,
                                     .light_tracks = &light_tracks,
                                     .background = background,
                                     .grey = &grey,
                                     .fps = TEXT_FPS}};

    return sc_timeline_scene(&t, k, NULL).dark_text;
}

/* Text changes by degrees where the background becomes dark, and at once where it jumps. */
TEST(text_follows_the_background)
{
    enum { REACH = TEXT_FPS / 4 };
    const sc_background slow = {
        .track = {2, {{0, {0}, {255, 255, 255}}, {1, {.kind = SC_EASE_LINEAR}, {0, 0, 0}}}}};
    const sc_background jumps = {
        .track = {2, {{0.495, {0}, {255, 255, 255}}, {0.5, {.kind = SC_EASE_LINEAR}, {0, 0, 0}}}}};
    const sc_background constant = {.rgb = {0, 0, 0}};
    int changes = 0;

    assert_near(dark_text_at(&slow, 0), 1, 0);
    assert_near(dark_text_at(&slow, TEXT_FRAMES - 1), 0, 0);
    for (int k = 1; k < TEXT_FRAMES; k++) {
        const double step = dark_text_at(&slow, k - 1) - dark_text_at(&slow, k);

        assert_true(step == 0 || fabs(step - 1.0 / (2 * REACH + 1)) < 1e-12);
        changes += step > 0;
        assert_near(dark_text_at(&jumps, k), k < 50, 0);
    }
    assert_int_equal(changes, 2 * REACH + 1);
    assert_near(dark_text_at(&constant, 3), 0, 0);
}

TEST(colours_are_mixed_by_their_tones)
{
    const sc_track levels = {
        3, {{0, {0}, {0, 255, 10}}, {0.5, {0}, {255, 255, 10}}, {1, {0}, {255, 0, 20}}}};
    sc_srgb_table table;
    sc_track tones;
    float at[3];

    sc_srgb_table_init(&table);
    sc_track_tones(&levels, &tones);
    for (int k = 0; k < 3; k++) { /* key frames are met to the level */
        const sc_vec3 value = levels.keys[k].value;

        sc_track_color(&tones, levels.keys[k].at, at);
        assert_int_equal(sc_srgb_level(&table, at[0]), (int)value.x);
        assert_int_equal(sc_srgb_level(&table, at[1]), (int)value.y);
        assert_int_equal(sc_srgb_level(&table, at[2]), (int)value.z);
    }
    sc_track_color(&tones, 0.25, at);
    assert_near(at[0], 0.25, 1e-6); /* halfway from black to white the square root is a half */
    assert_near(at[1], 1, 0);
}

/* A plane meets its key frames, and goes steadily between them, also where its normal turns far
 * from the origin. */
TEST(planes_follow_their_key_frames)
{
    enum { FRAMES = 101 };
    const sc_vec3 ends[] = {{100, 200, -300}, {140, 260, -280}}; /* middle: 120, 230, -290 */
    sc_animation a = {.frames = FRAMES, .sweep_count = 3, .camera = {.axis = {0, 0, 1}}};
    sc_timeline t;

    a.camera.fov_deg = 30;
    a.sweeps[0] = (sc_sweep){.normal = {1, 0, 0}};
    a.sweeps[0].at_track =
        (sc_track){3, {{0, {0}, {25, 1, 0}}, {0.5, {0}, {130, 0, 0}}, {1, {0}, {100, 1, 0}}}};
    a.sweeps[1] = (sc_sweep){.normal = {1, 0, 0}, .at = {50, true}};
    a.sweeps[1].normal_track = (sc_track){2, {{0.25, {0}, {1, 0, 0}}, {0.75, {0}, {0, 1, 0}}}};
    a.sweeps[2] = a.sweeps[1];
    a.sweeps[2].has_point = true;
    a.sweeps[2].point_mm = (sc_vec3){7, 8, 9};
    sc_timeline_resolve(&a, ends, SC_COUNT_OF(ends), 1, &t);
    assert_near(sc_timeline_scene(&t, 0, NULL).clip.planes[0].offset_mm, -110, 1e-9);
    assert_near(sc_timeline_scene(&t, 25, NULL).clip.planes[0].offset_mm, -120, 1e-9);
    assert_near(sc_timeline_scene(&t, 50, NULL).clip.planes[0].offset_mm, -130, 1e-9);
    assert_near(sc_timeline_scene(&t, 100, NULL).clip.planes[0].offset_mm, -140, 1e-9);
    for (int k = 0; k < FRAMES; k++) {
        const double turned = k < 25 ? 0 : k > 75 ? 1 : (k - 25) / 50.0;
        const sc_plane plane = sc_timeline_scene(&t, k, NULL).clip.planes[1],
                       about = sc_timeline_scene(&t, k, NULL).clip.planes[2];

        assert_near(plane.normal.x, cos(turned * M_PI / 2), 1e-12);
        assert_near(plane.normal.y, sin(turned * M_PI / 2), 1e-12);
        /* halfway through a box is through its middle, in any direction */
        assert_near(sc_vec3_dot(plane.normal, (sc_vec3){120, 230, -290}) + plane.offset_mm, 0,
                    1e-9);
        assert_near(sc_vec3_dot(about.normal, (sc_vec3){7, 8, 9}) + about.offset_mm, 0, 1e-9);
    }
}

TEST(a_camera_without_an_orbit_goes_by_key_frames)
{
    sc_animation a = {.frames = 11, .camera = {.fixed = true, .up = {0, 0, 1}, .fov_deg = 30}};
    sc_timeline t;

    a.camera.tracks.position = (sc_track){2, {{0, {0}, {0, 100, 0}}, {1, {0}, {100, 100, 0}}}};
    a.camera.tracks.target = (sc_track){2, {{0, {0}, {0, 0, 0}}, {0.5, {0}, {50, 0, 0}}}};
    a.camera.tracks.up = (sc_track){2, {{0.5, {0}, {0, 0, 1}}, {1, {0}, {1, 0, 0}}}};
    a.camera.zoom = 1;
    for (int moves = 0; moves < 2; moves++) { /* verbs start from there, too */
        const sc_move zoom = {.verb = {.kind = SC_VERB_ZOOM, .to = 1, .end = 1}};
        sc_camera c;

        a.moves = &zoom;
        a.move_count = moves;
        sc_timeline_resolve(&a, NULL, 0, 1, &t);
        c = sc_timeline_scene(&t, 5, NULL).camera;
        assert_near(c.position_mm.x, 50, 1e-9);
        assert_near(c.position_mm.y, 100, 1e-9);
        assert_near(c.forward.y, -1, 1e-12);
        assert_near(c.up.z, 1, 1e-12);
        c = sc_timeline_scene(&t, 10, NULL).camera;
        assert_near(c.position_mm.x, 100, 1e-9);
        assert_near(c.forward.x / c.forward.y, 0.5, 1e-9);
        assert_near(c.up.z, 0, 1e-9);
        assert_true(c.up.x > 0.5);
    }
}

/* Over the head of a body, and under its feet, a camera turns little from frame to frame, stands
 * upright at the key frames that are not there, and gives other ways the picture that they had. */
TEST(a_camera_passes_the_pole_without_a_flip)
{
    enum { FRAMES = 401, WAYS = 7 };
    static const struct {
        sc_track track;
        bool starts_near, ends_near;
    } ways[WAYS] = {
        {{2, {{0, {0}, {0, -100, 80}}, {1, {0}, {0, 100, 80}}}}, false, false},
        {{2, {{0, {0}, {1, -100, -80}}, {1, {0}, {1, 100, -80}}}}, false, false},
        {{3, {{0, {0}, {0, -100, 0}}, {0.4, {0}, {0, 0, 100}}, {1, {0}, {0, 100, 0}}}},
         false,
         false},
        {{3, {{0, {0}, {0, -100, 0}}, {0.5, {0}, {0, 0, 100}}, {1, {0}, {0, -100, 0}}}},
         false,
         false},
        {{3, {{0, {0}, {0, 0, 100}}, {0.5, {0}, {30, 0, 100}}, {1, {0}, {100, 100, 0}}}},
         true,
         false},
        {{3, {{0, {0}, {90, -9, 50}}, {0.5, {0}, {2, 3, 100}}, {1, {0}, {0, 0, 100}}}},
         false,
         true},
        {{3, {{0, {0}, {0, 0, 100}}, {0.5, {0}, {2, 3, 100}}, {1, {0}, {0, 0, 100}}}}, true, true}};

    for (int way = 0; way < WAYS; way++) {
        sc_animation a = {.frames = FRAMES,
                          .camera = {.fixed = true, .up = {0, 0, 1}, .fov_deg = 30}};
        sc_camera before = {0}, c = {0};
        sc_timeline t;

        a.camera.tracks.position = ways[way].track;
        a.camera.zoom = 1;
        sc_timeline_resolve(&a, NULL, 0, 1, &t);
        for (int k = 0; k < FRAMES; k++, before = c) {
            double along, turn_deg;

            c = sc_timeline_scene(&t, k, NULL).camera;
            if (k == 0 && !ways[way].starts_near)
                assert_near(c.right.z, 0, 1e-12);
            if (k == 0)
                continue;
            along = sc_vec3_dot(c.forward, before.forward);
            turn_deg = acos(fmin(1, sc_vec3_dot(c.up, before.up))) * 180 / M_PI;
            if (turn_deg > acos(fmin(1, along)) * 180 / M_PI + 1.5)
                fail_msg("way %d, frame %d: up turns by %g degrees", way, k, turn_deg);
        }
        if (!ways[way].ends_near)
            assert_near(c.right.z, 0, 1e-9);
        if (!ways[way].ends_near)
            assert_true(c.up.z > 0);
    }
}

TEST(slices_follow_their_key_frames)
{
    sc_animation a = {.frames = 11, .camera = {.axis = {0, 0, 1}, .fov_deg = 30}};
    sc_timeline t;

    a.slices.has_point = true;
    a.slices.point_track = (sc_track){2, {{0, {0}, {1, 2, 3}}, {1, {0}, {11, 2, -7}}}};
    sc_timeline_resolve(&a, NULL, 0, 1, &t);
    assert_near(sc_timeline_scene(&t, 0, NULL).point_mm.x, 1, 0);
    assert_near(sc_timeline_scene(&t, 5, NULL).point_mm.x, 6, 1e-12);
    assert_near(sc_timeline_scene(&t, 10, NULL).point_mm.z, -7, 0);
}

/* What moves by key frames is framed in all frames, and shows what the key frames say. */
TEST(key_frames_move_the_camera)
{
    sc_animation a = animation(11);
    sc_timeline t;
    double fill = 0;

    a.camera.has_target = true;
    a.camera.turns = 0;
    a.camera.tracks.angle = (sc_track){2, {{0, {0}, {0, 0, 0}}, {1, {0}, {90, 0, 0}}}};
    a.camera.tracks.target = (sc_track){2, {{0, {0}, {10, -5, 50}}, {1, {0}, {30, 20, 80}}}};
    a.camera.tracks.fov = (sc_track){2, {{0, {0}, {60, 0, 0}}, {0.5, {0}, {20, 0, 0}}}};
    sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
    for (int k = 0; k <= 10; k++) {
        const sc_camera c = sc_timeline_scene(&t, k, NULL).camera;
        const sc_vec3 target = {10 + 2.0 * k, -5 + 2.5 * k, 50 + 3.0 * k};
        const double fov_deg = k < 5 ? 60 - 8.0 * k : 20;

        expect_in_view(&c, 1.5, corners, &fill);
        assert_near(sc_vec3_length(sc_vec3_sub(target, c.position_mm)),
                    t.animation.camera.distance_mm, 1e-9);
        assert_near(sc_vec3_dot(c.forward, sc_vec3_unit(sc_vec3_sub(target, c.position_mm))), 1,
                    1e-12);
        assert_near(c.half_height, tan(fov_deg * M_PI / 360), 1e-12);
        assert_near(c.right.x, -cos(k * M_PI / 20), 1e-9);
    }
    assert_true(fill > 0.945);
    a.camera.tracks.zoom = (sc_track){2, {{0, {0}, {2, 0, 0}}, {1, {0}, {4, 0, 0}}}};
    a.camera.has_distance = true;
    a.camera.tracks.distance = (sc_track){2, {{0, {0}, {100, 0, 0}}, {1, {0}, {200, 0, 0}}}};
    for (int n = 0; n < 2; n++) {
        a.camera.projection = n ? SC_ORTHOGRAPHIC : SC_PERSPECTIVE;
        sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
        /* An orthographic camera shows what the field of view holds at the target. */
        assert_near(sc_timeline_scene(&t, 5, NULL).camera.half_height,
                    tan(M_PI / 18) / 3 * (n ? 150 : 1), 1e-9);
    }
}

/* @return a verb of the camera during a part of the animation, of even speed. */
static sc_move move_of(sc_verb_kind kind, double begin, double end)
{
    return (sc_move){.verb = {.kind = kind, .begin = begin, .end = end, .times = 1, .to = 1}};
}

/* @return the angle between what two cameras look at, up and ahead, in degrees. */
static double turned_deg(const sc_camera *a, const sc_camera *b)
{
    const double up = sc_vec3_length(sc_vec3_sub(a->up, b->up));
    const double ahead = sc_vec3_length(sc_vec3_sub(a->forward, b->forward));

    return 2 * asin(0.5 * fmax(up, ahead)) * 180 / M_PI;
}

TEST(a_camera_rocks_and_comes_back)
{
    enum { FRAMES = 101 };

    for (int fixed = 0; fixed < 2; fixed++) {
        sc_animation a = animation(FRAMES);
        sc_move rock = move_of(SC_VERB_ROCK, 0.2, 0.6);
        sc_camera first, quarter, last;
        sc_timeline t;

        a.camera.turns = 0;
        a.camera.elevation_deg = 0;
        a.camera.fixed = fixed;
        a.camera.position_mm = (sc_vec3){0, 300, 0};
        a.camera.up = (sc_vec3){0, 0, 2};
        rock.verb.angle_deg = 30;
        a.moves = &rock;
        a.move_count = 1;
        sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
        first = sc_timeline_scene(&t, 0, NULL).camera;
        quarter = sc_timeline_scene(&t, 30, NULL).camera;
        last = sc_timeline_scene(&t, 100, NULL).camera;
        assert_near(turned_deg(&first, &last), 0, 1e-6);
        assert_near(turned_deg(&first, &quarter), 30, 1e-6);
        assert_true(quarter.position_mm.x < -10); /* as an orbit: first to the patient's left */
        quarter = sc_timeline_scene(&t, 50, NULL).camera;
        assert_near(turned_deg(&first, &quarter), 30, 1e-6);
        assert_true(quarter.position_mm.x > 10);
        rock.verb.angle_deg = 0;
        rock.verb.elevation_deg = 120; /* over the pole, and under the other one */
        sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
        for (int k = 1; k < FRAMES; k++) {
            const sc_camera before = sc_timeline_scene(&t, k - 1, NULL).camera;
            const sc_camera now = sc_timeline_scene(&t, k, NULL).camera;

            assert_true(turned_deg(&before, &now) <= 120 * 2 * M_PI / 40);
        }
        quarter = sc_timeline_scene(&t, 30, NULL).camera;
        assert_near(quarter.forward.z, -sin(M_PI * 120 / 180), 1e-9); /* from above, behind */
        assert_true(quarter.forward.y > 0);
    }
}

/* A way that rises upright and turns over: evenly spaced, and what is up never jumps. */
TEST(a_camera_flies_evenly_and_without_flips)
{
    enum { POINTS = 5, FRAMES = 301 };
    static const sc_vec3 through[POINTS] = {
        {0, 0, 0}, {40, 0, 10}, {50, 0, 50}, {20, 0, 70}, {0, 0, 40}};
    sc_vec3 curve[(POINTS - 1) * SC_WAY_STEPS + 1];
    static sc_way_point way[SC_WAY_POINTS];
    sc_animation a = animation(FRAMES);
    sc_move fly = move_of(SC_VERB_FLY, 0.2, 1);
    const size_t count = sc_way_curve(through, POINTS, curve);
    double least = HUGE_VAL, most = 0;
    sc_timeline t;

    assert_int_equal(count, (POINTS - 1) * SC_WAY_STEPS + 1);
    for (int i = 0; i < POINTS; i++)
        assert_near(sc_vec3_length(sc_vec3_sub(curve[i * SC_WAY_STEPS], through[i])), 0, 1e-9);
    sc_way_make(curve, NULL, count, 0.1, way);
    for (int i = 1; i < SC_WAY_POINTS; i++) {
        const double step = sc_vec3_length(sc_vec3_sub(way[i].at_mm, way[i - 1].at_mm));

        least = fmin(least, step);
        most = fmax(most, step);
        assert_near(sc_vec3_dot(way[i].forward, way[i].up), 0, 1e-12);
        assert_true(sc_vec3_dot(way[i].up, way[i - 1].up) > 0.999);
        assert_true(sc_vec3_dot(way[i].forward, way[i - 1].forward) > 0.999);
    }
    assert_true(most < 1.01 * least);
    fly.verb.fly.fov_deg = 90;
    a.moves = &fly;
    a.move_count = 1;
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    t.ways = way;
    assert_false(sc_timeline_scene(&t, 59, NULL).inside);
    assert_true(sc_timeline_scene(&t, 60, NULL).inside);
    for (int end = 0; end < 2; end++) {
        const sc_camera c = sc_timeline_scene(&t, end ? FRAMES - 1 : 60, NULL).camera;

        assert_near(sc_vec3_length(sc_vec3_sub(c.position_mm, through[end ? POINTS - 1 : 0])), 0,
                    1e-9);
        assert_near(c.half_height, 1, 1e-12);
    }
    /* With an open shutter the frame in which the flight begins is not mixed with what was before.
     */
    t.animation.camera.optics.shutter = 0.5;
    assert_int_equal(sc_timeline_moments(&t, 60, corners, CORNERS, 720), 1);
    assert_in_range(sc_timeline_moments(&t, 150, corners, CORNERS, 720), 2, SC_MOMENTS_MAX);
}

/* The radius around a camera that flies is that of the line, but changes smoothly where that jumps,
 * as from a vessel into a chamber, so that the light that follows it does not blink. */
TEST(the_space_around_a_flight_changes_smoothly)
{
    enum { POINTS = 201, FRAMES = 101 };
    static sc_way_point way[SC_WAY_POINTS];
    sc_vec3 line[POINTS];
    double around_mm[POINTS];
    sc_animation a = animation(FRAMES);
    sc_move fly = move_of(SC_VERB_FLY, 0, 1);
    sc_timeline t;

    for (int i = 0; i < POINTS; i++) {
        line[i] = (sc_vec3){i, 0, 0};
        around_mm[i] = i < POINTS / 2 ? 5 : 15;
    }
    sc_way_make(line, around_mm, POINTS, 0.1, way);
    fly.verb.fly.fov_deg = 90;
    a.moves = &fly;
    a.move_count = 1;
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    t.ways = way;
    assert_near(sc_timeline_scene(&t, 0, NULL).around_mm, 5, 1e-9);
    assert_near(sc_timeline_scene(&t, FRAMES - 1, NULL).around_mm, 15, 1e-9);
    for (int k = 1; k < FRAMES; k++) { /* 2 mm from frame to frame */
        const double more =
            sc_timeline_scene(&t, k, NULL).around_mm - sc_timeline_scene(&t, k - 1, NULL).around_mm;

        assert_true(more > -1e-9 && more < 0.8);
    }
    sc_way_make(line, NULL, POINTS, 0.1, way);
    assert_near(sc_timeline_scene(&t, 50, NULL).around_mm, 0, 0);
}

/* A hold brings the camera to rest without a jolt; the orbit gets as far as without. */
TEST(an_orbit_pauses_and_turns_as_far)
{
    enum { FRAMES = 201 };
    sc_animation a = animation(FRAMES);
    sc_move holds[] = {move_of(SC_VERB_HOLD, 0.6, 0.7), move_of(SC_VERB_HOLD, 0.2, 0.5)};
    sc_timeline t, plain;
    double step_before = -1;

    sc_timeline_resolve(&a, corners, CORNERS, 1, &plain);
    holds[1].verb.soft = 0.25;
    holds[0].verb.soft = 0.5;
    a.moves = holds;
    a.move_count = 2;
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    assert_near(t.animation.camera.distance_mm, plain.animation.camera.distance_mm, 0);
    for (int k = 0; k < FRAMES - 1; k++) {
        const sc_camera now = sc_timeline_scene(&t, k, NULL).camera;
        const sc_camera next = sc_timeline_scene(&t, k + 1, NULL).camera;
        const double step = sc_vec3_length(sc_vec3_sub(next.position_mm, now.position_mm)) /
                            plain.animation.camera.distance_mm;

        if (k >= 40 + 15 && k < 100 - 15)
            assert_near(step, 0, 1e-9);
        else if (k < 40 || (k >= 100 && k < 120) || k >= 140)
            assert_near(step,
                        2 * M_PI / FRAMES / (1 - 0.3 * 0.75 - 0.1 * 0.5) * cos(20 * M_PI / 180),
                        1e-4);
        if (step_before >= 0)
            assert_true(fabs(step - step_before) < 0.007);
        step_before = step;
    }
    for (int k = 0; k < FRAMES; k += FRAMES - 1) {
        const sc_camera now = sc_timeline_scene(&t, k, NULL).camera;
        const sc_camera without = sc_timeline_scene(&plain, k, NULL).camera;

        assert_near(turned_deg(&now, &without), 0, 1e-6);
    }
}

/* A zoom scales the picture; a dolly moves the camera; both go on from where they find it. */
TEST(zooms_and_dollies_follow_one_another)
{
    sc_animation a = animation(101);
    sc_move moves[] = {move_of(SC_VERB_ZOOM, 0.5, 0.7), move_of(SC_VERB_DOLLY, 0.1, 0.3),
                       move_of(SC_VERB_ZOOM, 0.2, 0.4), move_of(SC_VERB_DOLLY, 0.8, 0.8)};
    static const double zooms[] = {1, 1, 1, 2, 4, 4, 2, 1, 1, 1, 1};
    static const double distances[] = {1, 1, M_SQRT1_2, 0.5, 0.5, 0.5, 0.5, 0.5, 1.5, 1.5, 1.5};
    sc_timeline t;

    moves[0].verb.to = 1;
    moves[1].verb.to = 0.5;
    moves[2].verb.to = 4;
    moves[3].verb.to = 3;
    a.moves = moves;
    a.move_count = 4;
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    for (int i = 0; i <= 10; i++) {
        const sc_camera c = sc_timeline_scene(&t, 10 * i, NULL).camera;

        assert_near(t.half_height / c.half_height, zooms[i], 1e-9);
        assert_near(sc_vec3_length(sc_vec3_sub(c.position_mm, t.animation.camera.target_mm)),
                    distances[i] * t.animation.camera.distance_mm, 1e-9);
    }
}

/* @return the most of half the picture by which @p target moves from one frame to the next. */
static double most_jump(const sc_timeline *t, sc_vec3 target)
{
    double most = 0, before[2] = {0, 0};

    for (int k = 0; k < t->animation.frames; k++) {
        const sc_camera c = sc_timeline_scene(t, k, NULL).camera;
        const sc_vec3 d = sc_vec3_sub(target, c.position_mm);
        const double depth = c.projection == SC_PERSPECTIVE ? sc_vec3_dot(d, c.forward) : 1;
        const double at[2] = {sc_vec3_dot(d, c.right) / (depth * c.half_height),
                              sc_vec3_dot(d, c.up) / (depth * c.half_height)};

        if (k > 0)
            most = fmax(most, hypot(at[0] - before[0], at[1] - before[1]));
        memcpy(before, at, sizeof before);
    }
    return most;
}

/* After a frame its tissues fill the picture from all directions, also if there was a zoom before
 * and the camera turns, and the way there is smooth. */
TEST(tissues_come_to_fill_the_picture)
{
    enum { FRAMES = 121 };

    for (int n = 0; n < 8; n++) {
        sc_animation a = animation(FRAMES);
        sc_vec3 small[CORNERS];
        sc_move moves[] = {move_of(SC_VERB_FRAME, 0.3, 0.5), move_of(SC_VERB_ZOOM, 0, 0.2)};
        double fill = 0;
        sc_timeline t;

        for (int i = 0; i < CORNERS; i++) /* a long box, which is wide from the front only */
            small[i] = (sc_vec3){corners[i].x * 0.6, corners[i].y * 0.1 - 10, corners[i].z * 0.1};
        a.camera.projection = n & 1 ? SC_ORTHOGRAPHIC : SC_PERSPECTIVE;
        a.camera.fixed = n & 2;
        a.camera.position_mm = (sc_vec3){100, 300, 50};
        a.camera.up = (sc_vec3){0, 0, 1};
        a.camera.turns = n & 4 ? 0.4 : 2;
        if (n == 4)
            a.camera.tracks.fov = (sc_track){2, {{0, {0}, {30, 0, 0}}, {1, {0}, {50, 0, 0}}}};
        moves[0].points = small;
        moves[0].point_count = CORNERS;
        moves[0].verb.ease.kind = SC_EASE_SMOOTH;
        moves[1].verb.to = 1.5;
        a.moves = moves;
        a.move_count = 2;
        sc_timeline_resolve(&a, corners, CORNERS, 1.5, &t);
        for (int k = FRAMES / 2; k < FRAMES; k++) {
            const sc_camera c = sc_timeline_scene(&t, k, NULL).camera;

            expect_in_view(&c, 1.5, small, &fill);
        }
        assert_true(fill > 0.9); /* the framing also heeds the directions on the way */
        assert_true(most_jump(&t, t.moves[1].target_mm) < 0.2);
        assert_true(t.moves[1].distance_mm >=
                    (a.camera.fixed ? 0 : t.animation.camera.distance_mm) * (1 - 1e-12));
    }
}

TEST(zoom_scales_the_picture)
{
    sc_animation a = animation(11);
    sc_timeline t;
    double first;

    a.camera.tracks.zoom =
        (sc_track){2, {{.at = 0, .value = {1, 0, 0}}, {.at = 1, .value = {2, 0, 0}}}};
    sc_timeline_resolve(&a, corners, CORNERS, 1, &t);
    first = sc_timeline_scene(&t, 0, NULL).camera.half_height;
    assert_near(sc_timeline_scene(&t, 10, NULL).camera.half_height, first / 2, 1e-12);
    assert_near(sc_timeline_scene(&t, 5, NULL).camera.half_height, first / 1.5, 1e-12);
}

TEST(without_visible_points_there_is_still_a_camera)
{
    const sc_animation a = animation(3);
    sc_timeline t;

    sc_timeline_resolve(&a, NULL, 0, 1, &t);
    assert_true(isfinite(sc_timeline_scene(&t, 1, NULL).camera.position_mm.x));
    assert_true(t.animation.camera.distance_mm > 0);
}

/* A timeline of 101 frames in which verbs do the given things to four tissues. */
static sc_timeline fading(const sc_change *fades, size_t count, const sc_tissue tissues[4],
                          const sc_track *tracks)
{
    return (sc_timeline){.animation = {.frames = 101},
                         .looks = {.tissues = tissues,
                                   .label_count = 4,
                                   .tissue_tracks = tracks,
                                   .fades = fades,
                                   .fade_count = count}};
}

static void expect_factor(const sc_timeline *t, int k, int id, double factor)
{
    SC_OWN(sc_scene_room_clear) sc_scene_room room = {0};
    sc_scene scene;

    assert_ok(sc_scene_room_init(&quiet, t->looks.label_count, &room));
    scene = sc_timeline_scene(t, k, &room);
    assert_near(scene.fades[0], 1, 0);
    assert_near(scene.fades[id], factor, 1e-6);
}

/* Fades follow one another, pulses multiply, and a tissue is not seen before it appears. */
TEST(verbs_of_one_tissue_combine)
{
    static const sc_change fades[] = {
        {1, SC_VERB_FADE, 0.1, 0.2, {.kind = SC_EASE_LINEAR}, {0.5, 0, 0}, 0, false},
        {1, SC_VERB_PULSE, 0.1, 0.5, {.kind = SC_EASE_LINEAR}, {0.2, 0, 0}, 2, false},
        {1, SC_VERB_FADE, 0.6, 0.8, {.kind = SC_EASE_LINEAR}, {2, 0, 0}, 0, false},
        {2, SC_VERB_APPEAR, 0.5, 0.5, {.kind = SC_EASE_LINEAR}, {1, 0, 0}, 0, false},
        {2, SC_VERB_FADE, 0.6, 0.7, {.kind = SC_EASE_SMOOTH}, {0, 0, 0}, 0, false},
        {3, SC_VERB_FADE, 0.1, 0.2, {.kind = SC_EASE_LINEAR}, {0, 0, 0}, 0, false},
        {3, SC_VERB_APPEAR, 0.4, 0.6, {.kind = SC_EASE_LINEAR}, {1, 0, 0}, 0, false}};
    static const sc_tissue tissues[4] = {{0}, {.fade_group = 1}, {.fade_group = 2}, {0}};
    const sc_timeline t = fading(fades, SC_COUNT_OF(fades), tissues, NULL);

    expect_factor(&t, 0, 1, 1);
    expect_factor(&t, 20, 1, 0.5 * 0.2); /* the turning point of the first beat */
    expect_factor(&t, 30, 1, 0.5);
    expect_factor(&t, 35, 1, 0.5 * 0.6);
    expect_factor(&t, 55, 1, 0.5);
    expect_factor(&t, 70, 1, 1.25);
    expect_factor(&t, 100, 1, 2);
    expect_factor(&t, 0, 2, 0);
    expect_factor(&t, 49, 2, 0);
    expect_factor(&t, 50, 2, 1);
    expect_factor(&t, 65, 2, 0.5);
    expect_factor(&t, 70, 2, 0);
    expect_factor(&t, 0, 3, 1); /* it is seen, and fades, before it appears again */
    expect_factor(&t, 30, 3, 0);
    expect_factor(&t, 50, 3, 0.5);
}

/* Key frames give the opacity, on which verbs work: as with a constant of the same value, so that a
 * fade to an opacity leads there, and one to a share to this share of the key frames. */
TEST(verbs_change_what_key_frames_of_an_opacity_give)
{
    static const sc_change fades[] = {
        {2, SC_VERB_FADE, 0.2, 0.4, {.kind = SC_EASE_LINEAR}, {0.5, 0, 0}, 0, false},
        {2, SC_VERB_FADE, 0.6, 0.8, {.kind = SC_EASE_LINEAR}, {0.25, 0, 0}, 0, true},
        {3, SC_VERB_PULSE, 0.2, 0.4, {.kind = SC_EASE_LINEAR}, {0.5, 0, 0}, 1, true}};
    static const sc_track tracks[] = {
        {3, {{0.2, {0}, {0.8, 0, 0}}, {0.4, {0}, {0.4, 0, 0}}, {0.8, {0}, {0, 0, 0}}}}};
    static const sc_tissue tissues[4] = {
        {0},
        {.visible = true, .opacity = 0.8, .opacity_track = 1, .fade_group = 1},
        {.visible = true, .opacity = 0.8, .opacity_track = 1},
        {.visible = true, .opacity = 0.8, .opacity_track = 1}};
    const sc_timeline t = fading(fades, SC_COUNT_OF(fades), tissues, tracks);

    expect_factor(&t, 0, 1, 1);
    expect_factor(&t, 30, 1, 0.6 / 0.8);
    expect_factor(&t, 60, 1, 0.2 / 0.8);
    expect_factor(&t, 80, 1, 0);
    expect_factor(&t, 100, 1, 0);
    expect_factor(&t, 30, 2, 0.75 * 0.6 / 0.8); /* on the way to half of it */
    expect_factor(&t, 50, 2, 0.5 * 0.3 / 0.8);
    expect_factor(&t, 70, 2, 0.5 * 0.5 * 0.1 / 0.8 + 0.5 * 0.25);
    expect_factor(&t, 100, 2, 0.25); /* it has come to an opacity, and stays there */
    expect_factor(&t, 30, 3, 0.5);   /* the turning point of a pulse to an opacity */
    expect_factor(&t, 25, 3, (0.5 * 0.7 + 0.5 * 0.4) / 0.8);
    expect_factor(&t, 50, 3, 0.3 / 0.8);
}

/* A tissue is there from a key frame that says so to one that says otherwise, whatever verbs do. */
TEST(tissues_come_and_go_at_their_key_frames)
{
    static const sc_change fades[] = {
        {2, SC_VERB_FADE, 0.5, 0.5, {.kind = SC_EASE_LINEAR}, {0.5, 0, 0}, 0, false}};
    static const sc_track tracks[] = {
        {3, {{0.2, {0}, {1, 0, 0}}, {0.4, {0}, {0, 0, 0}}, {0.6, {0}, {1, 0, 0}}}}};
    static const sc_tissue tissues[4] = {
        {0},
        {.visible = true, .opacity = 1, .visible_track = 1, .fade_group = 1},
        {.visible = true, .opacity = 1, .visible_track = 1}};
    const sc_timeline t = fading(fades, SC_COUNT_OF(fades), tissues, tracks);

    expect_factor(&t, 0, 1, 1);
    expect_factor(&t, 39, 1, 1);
    expect_factor(&t, 40, 1, 0);
    expect_factor(&t, 59, 2, 0);
    expect_factor(&t, 60, 2, 0.5);
    expect_factor(&t, 100, 1, 1);
}

/* Three tissues in a row along x, of 10, 4 and 7 voxels' length. */
static sc_prepared three_tissues(sc_label labels[4], sc_label_stats stats[4])
{
    static const char *const names[] = {"", "middle", "left", "right"};
    static const int lows[] = {0, 10, 0, 30}, highs[] = {0, 19, 3, 36};

    for (int id = 0; id < 4; id++) {
        labels[id] = (sc_label){.value = id};
        snprintf(labels[id].name, sizeof labels[id].name, "%s", names[id]);
        stats[id] = (sc_label_stats){.voxels = (uint64_t)(highs[id] - lows[id] + 1),
                                     .low = {lows[id], 0, 0},
                                     .high = {highs[id], 0, 0}};
    }
    return (sc_prepared){.label_count = 4,
                         .labels = labels,
                         .stats = stats,
                         .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
}

/* Tissues appear in the order that is asked for, and as much one after the other. */
TEST(tissues_appear_in_their_order)
{
    static const struct {
        sc_verb_order order;
        double stagger;
        double begins[3]; /* of middle, left, right, in 36ths */
        double takes;
    } cases[] = {{SC_ORDER_LIST, 1, {24, 12, 0}, 12},     {SC_ORDER_LARGEST, 1, {0, 24, 12}, 12},
                 {SC_ORDER_SMALLEST, 1, {24, 0, 12}, 12}, {SC_ORDER_RIGHT, 1, {12, 0, 24}, 12},
                 {SC_ORDER_LEFT, 0.5, {9, 18, 0}, 18},    {SC_ORDER_SUPERIOR, 0, {0, 0, 0}, 36}};
    sc_named_tissue list[3] = {{0, "right", ""}, {0, "left", ""}, {0, "*", ""}};
    sc_label labels[4];
    sc_label_stats stats[4];
    const sc_prepared volume = three_tissues(labels, stats);

    for (size_t c = 0; c < SC_COUNT_OF(cases); c++) {
        const sc_verb verb = {
            .kind = SC_VERB_APPEAR, .end = 1, .order = cases[c].order, .stagger = cases[c].stagger};
        sc_tissue tissues[4] = {{0},
                                {.visible = true, .opacity = 1},
                                {.visible = true, .opacity = 1},
                                {.visible = true, .opacity = 1}};
        const sc_verbs all = {&verb, 1, list, SC_COUNT_OF(list), NULL};
        SC_OWN(sc_free_at) sc_change *fades = NULL;
        size_t count;

        assert_ok(sc_verbs_resolve(&quiet, &volume, tissues, &all, &fades, &count));
        assert_int_equal(count, 3);
        for (int i = 0; i < 3; i++) {
            assert_int_equal(fades[i].id, i + 1);
            assert_near(fades[i].begin, cases[c].begins[i] / 36, 1e-12);
            assert_near(fades[i].end, (cases[c].begins[i] + cases[c].takes) / 36, 1e-12);
            assert_true(tissues[i + 1].fade_group > 0);
        }
        assert_true((tissues[1].fade_group == tissues[2].fade_group) == (cases[c].stagger == 0));
    }
}

/* Tissues move from the middle, from a point, or along a direction, each by itself or as one; what
 * several verbs do adds up, and the opposite brings them back exactly. */
TEST(tissues_move_apart_and_come_together)
{
    enum { FRAMES = 101 };
    const sc_named_tissue list[] = {
        {0, "*", ""}, {1, "left", ""}, {1, "right", ""}, {2, "*", ""}, {3, "middle", ""}};
    const sc_verb verbs[] = {{.kind = SC_VERB_EXPLODE, .end = 0.2, .by = {50, true}},
                             {.kind = SC_VERB_EXPLODE,
                              .begin = 0.4,
                              .end = 0.6,
                              .by = {7, false},
                              .together = true,
                              .line.has_point = true,
                              .line.point_mm = {18, -5, 0}},
                             {.kind = SC_VERB_EXPLODE, .begin = 0.8, .end = 1, .by = {-50, true}},
                             {.kind = SC_VERB_EXPLODE,
                              .begin = 0.8,
                              .end = 1,
                              .by = {3, false},
                              .line.has_axis = true,
                              .line.axis = {0, 0, 1}}};
    const sc_verbs all = {verbs, SC_COUNT_OF(verbs), list, SC_COUNT_OF(list), NULL};
    sc_label labels[4];
    sc_label_stats stats[4];
    const sc_prepared volume = three_tissues(labels, stats);
    sc_tissue tissues[4] = {{0},
                            {.visible = true, .opacity = 1},
                            {.visible = true, .opacity = 1},
                            {.visible = true, .opacity = 1}};
    sc_timeline t = {.animation = {.frames = FRAMES},
                     .looks = {.tissues = tissues, .label_count = 4}};
    sc_looks *looks = &t.looks;
    sc_vec3 reach[8 * 9];
    SC_OWN(sc_scene_room_clear) sc_scene_room room = {0};
    const sc_vec3 *offsets;
    sc_change *shifts;

    assert_ok(sc_scene_room_init(&quiet, 4, &room));
    assert_ok(sc_explodes_resolve(&quiet, &volume, tissues, &all, &shifts, &looks->shift_count));
    looks->shifts = shifts;
    assert_int_equal(looks->shift_count, 9);
    assert_true(tissues[1].part && tissues[2].part && tissues[3].part);
    assert_true(tissues[1].part != tissues[2].part && tissues[2].part != tissues[3].part);
    assert_null(sc_timeline_scene(&t, 0, &room).offsets_mm);
    offsets = sc_timeline_scene(&t, 30, &room).offsets_mm;
    assert_non_null(offsets);
    assert_near(offsets[1].x, 0.5 * (14.5 - 18), 1e-12); /* 18 is the middle of all */
    assert_near(offsets[2].x, 0.5 * (1.5 - 18), 1e-12);
    assert_near(offsets[3].x, 0.5 * (33 - 18), 1e-12);
    assert_near(offsets[3].y, 0, 0);
    offsets = sc_timeline_scene(&t, 50, &room).offsets_mm;
    assert_non_null(offsets);
    assert_near(offsets[2].y, 3.5, 1e-12); /* the common middle lies at 18, 0, 0 */
    assert_near(offsets[3].y, 3.5, 1e-12);
    assert_near(offsets[1].y, 0, 0);
    offsets = sc_timeline_scene(&t, 100, &room).offsets_mm;
    assert_non_null(offsets);
    assert_near(offsets[1].x, 0, 0);
    assert_near(offsets[1].z, 3, 0);
    assert_near(offsets[2].x, 0, 0);
    assert_near(offsets[2].y, 7, 0);
    sc_shifts_reach(&volume, shifts, looks->shift_count, reach);
    assert_near(reach[0].x, 9.5 + 0.5 * (14.5 - 18), 1e-12); /* when the first explode ends */
    sc_free(shifts);
    /* Tissues that do the same move as one part. */
    assert_ok(
        sc_explodes_resolve(&quiet, &volume, tissues,
                            &(sc_verbs){verbs + 1, 1, &(sc_named_tissue){0, "*", ""}, 1, NULL},
                            &shifts, &looks->shift_count));
    assert_int_equal(looks->shift_count, 3);
    for (int id = 1; id < 4; id++)
        assert_int_equal(tissues[id].part, 1);
    sc_free(shifts);
}

/* Offsets, constant or by key frames, add to what explodes do. */
TEST(tissues_have_offsets)
{
    static const sc_verb verb = {.kind = SC_VERB_EXPLODE,
                                 .begin = 0.5,
                                 .end = 1,
                                 .line.has_axis = true,
                                 .line.axis = {0, 0, 1},
                                 .by = {8, false}};
    static const sc_named_tissue list[] = {{0, "right", ""}};
    static const sc_track tracks[] = {
        {2, {{0.2, {0}, {2, 0, 0}}, {0.4, {.kind = SC_EASE_LINEAR}, {2, 6, 0}}}}};
    const sc_verbs all = {&verb, 1, list, 1, tracks};
    sc_label labels[4];
    sc_label_stats stats[4];
    const sc_prepared volume = three_tissues(labels, stats);
    sc_tissue tissues[4] = {{0},
                            {.visible = true, .opacity = 1, .offset_mm = {0, 3, 4}},
                            {.visible = false, .opacity = 1, .offset_mm = {1, 0, 0}},
                            {.visible = true, .opacity = 1, .offset_track = 1}};
    sc_timeline t = {.animation = {.frames = 101}, .looks = {.tissues = tissues, .label_count = 4}};
    SC_OWN(sc_scene_room_clear) sc_scene_room room = {0};
    const sc_vec3 *offsets;
    SC_OWN(sc_free_at) sc_change *shifts = NULL;

    assert_ok(sc_scene_room_init(&quiet, 4, &room));
    assert_ok(sc_explodes_resolve(&quiet, &volume, tissues, &all, &shifts, &t.looks.shift_count));
    t.looks.shifts = shifts;
    assert_true(tissues[1].part && tissues[3].part && tissues[1].part != tissues[3].part);
    assert_int_equal(tissues[2].part, 0);
    offsets = sc_timeline_scene(&t, 0, &room).offsets_mm;
    assert_non_null(offsets);
    assert_near(offsets[1].y, 3, 0);
    assert_near(offsets[1].z, 4, 0);
    assert_near(offsets[3].x, 2, 0);
    assert_near(offsets[3].y, 0, 0);
    offsets = sc_timeline_scene(&t, 30, &room).offsets_mm;
    assert_non_null(offsets);
    assert_near(offsets[3].y, 3, 1e-12);
    offsets = sc_timeline_scene(&t, 75, &room).offsets_mm;
    assert_non_null(offsets);
    assert_near(offsets[3].x, 2, 0);
    assert_near(offsets[3].y, 6, 1e-12);
    assert_near(offsets[3].z, 4, 1e-12);
}

/* A verb on what nobody sees is a mistake; a fade to an opacity depends on the tissue's own. */
TEST(verbs_need_tissues_that_are_shown)
{
    const sc_named_tissue list[] = {{0, "left", "job:1"}, {1, "mid*", "job:2"}};
    const sc_verb verbs[] = {{.kind = SC_VERB_FADE, .end = 1, .to = 0.2, .where = "job:1"},
                             {.kind = SC_VERB_FADE, .end = 1, .to = 0.2, .to_factor = true}};
    sc_tissue tissues[4] = {
        {0}, {.visible = true, .opacity = 0.5}, {.visible = false, .opacity = 1}};
    sc_label labels[4];
    sc_label_stats stats[4];
    const sc_prepared volume = three_tissues(labels, stats);
    const sc_verbs all = {verbs, SC_COUNT_OF(verbs), list, SC_COUNT_OF(list), NULL};
    SC_OWN(sc_free_at) sc_change *fades = NULL;
    size_t count;

    assert_int_equal(sc_verbs_resolve(&listening, &volume, tissues, &all, &fades, &count),
                     SC_ERR_DATA);
    assert_null(fades);
    assert_non_null(strstr(said.text, "job:1: no tissue of this verb is shown"));
    tissues[2] = (sc_tissue){.visible = true, .opacity = 0.4};
    assert_ok(sc_verbs_resolve(&listening, &volume, tissues, &all, &fades, &count));
    assert_int_equal(count, 2);
    assert_near(fades[0].to.x, 0.2, 1e-12);
    assert_near(fades[1].to.x, 0.5, 1e-12);
    assert_int_equal(tissues[3].fade_group, 0);
}

/* What frame k of a film shows, found in another way: each shot lists its own frames. */
TEST(every_frame_of_a_film_shows_its_shot)
{
    enum { SHOTS = 5, FRAMES_MAX = 100 };
    sc_shot_span shots[SHOTS] = {{.frames = 10, SC_TRANSITION_FADE, 3},
                                 {.frames = 7, SC_TRANSITION_CROSS_FADE, 4},
                                 {.frames = 5, SC_TRANSITION_CUT, .fade_out_frames = 2},
                                 {.frames = 1, SC_TRANSITION_CUT},
                                 {.frames = 9, SC_TRANSITION_FADE, 2}};
    static const int firsts[SHOTS] = {0, 6, 13, 18, 19}, used[SHOTS] = {6, 4, 2, 1, 1};
    int seen[FRAMES_MAX] = {0};

    assert_int_equal(sc_shots_place(shots, SHOTS), 28);
    for (int i = 0; i < SHOTS; i++) {
        assert_int_equal(shots[i].first, firsts[i]);
        assert_int_equal(sc_shot_transitions(shots, SHOTS, i), used[i]);
        for (int f = 0; f < shots[i].frames; f++)
            seen[shots[i].first + f] |= 1 << i;
    }
    for (int k = 0; k < 28; k++) {
        const sc_film_frame at = sc_film_frame_at(shots, SHOTS, k);

        assert_int_equal(1 << at.shot | (at.before >= 0 ? 1 << at.before : 0), seen[k]);
        assert_int_equal(shots[at.shot].first + at.frame, k);
        assert_true(at.frame < shots[at.shot].frames);
        if (at.before >= 0)
            assert_int_equal(shots[at.before].first + at.before_frame, k);
    }
}

/* Transitions begin and end evenly: their shares run through the middles of equal parts. */
TEST(transitions_are_even)
{
    sc_shot_span shots[3] = {{.frames = 10, SC_TRANSITION_CUT},
                             {.frames = 10, SC_TRANSITION_CROSS_FADE, 4},
                             {.frames = 10, SC_TRANSITION_FADE, 4, .fade_out_frames = 4}};

    assert_int_equal(sc_shots_place(shots, 3), 26);
    for (int k = 0; k < 26; k++) {
        const sc_film_frame at = sc_film_frame_at(shots, 3, k);
        const float expected = k >= 6 && k < 10     ? ((float)(k - 6) + 0.5F) / 4
                               : k == 14 || k == 17 ? 0.75F
                               : k == 15 || k == 16 ? 0.25F
                               : k >= 22            ? ((float)(25 - k) + 0.5F) / 4
                                                    : 1;

        assert_true(at.share == expected);
        assert_int_equal(at.before, k >= 6 && k < 10 ? 0 : -1);
    }
}

/* A picture alone has equal margins at opposite sides, and at two of them that of the framing. */
TEST(a_picture_alone_stands_in_the_middle)
{
    static const double elevations[] = {0, 35, 90, -90};

    for (int i = 0; i < 32; i++) {
        const double aspect = i & 1 ? 1.8 : 0.5;
        sc_animation a = animation(12);
        sc_vec3 lumpy[CORNERS];
        double low[2] = {1, 1}, high[2] = {-1, -1};
        sc_timeline t;
        sc_camera c;

        a.camera.alone = true;
        a.camera.elevation_deg = elevations[i / 2 % 4];
        a.camera.angle_deg = i & 8 ? 50 : 180;
        a.camera.projection = i & 16 ? SC_ORTHOGRAPHIC : SC_PERSPECTIVE;
        memcpy(lumpy, corners, sizeof lumpy);
        lumpy[5].x += 70; /* not symmetric, so that nothing is centred by chance */
        sc_timeline_resolve(&a, lumpy, CORNERS, aspect, &t);
        c = sc_timeline_scene(&t, 0, NULL).camera;
        for (int k = 0; k < CORNERS; k++) {
            const sc_vec3 d = sc_vec3_sub(lumpy[k], c.position_mm);
            const double scale =
                c.half_height * (c.projection == SC_PERSPECTIVE ? sc_vec3_dot(d, c.forward) : 1);
            const double at[2] = {sc_vec3_dot(d, c.right) / scale / aspect,
                                  sc_vec3_dot(d, c.up) / scale};

            for (int axis = 0; axis < 2; axis++) {
                low[axis] = fmin(low[axis], at[axis]);
                high[axis] = fmax(high[axis], at[axis]);
            }
        }
        assert_near(low[0], -high[0], 1e-4);
        assert_near(low[1], -high[1], 1e-4);
        assert_near(fmax(high[0], high[1]), 1 / 1.05, 1e-4);
    }
}

/* Each word for a direction, in any case, and no other word. */
TEST(directions_have_the_words_of_anatomists)
{
    static const struct {
        const char *words[8];
        sc_vec3 direction;
    } expected[] = {{{"right", "x", "RIGHT"}, {1, 0, 0}},
                    {{"left", "-x"}, {-1, 0, 0}},
                    {{"anterior", "ventral", "front", "y", "Ventral"}, {0, 1, 0}},
                    {{"posterior", "dorsal", "back", "-y"}, {0, -1, 0}},
                    {{"superior", "cranial", "head", "top", "z"}, {0, 0, 1}},
                    {{"inferior", "caudal", "feet", "bottom", "-z"}, {0, 0, -1}}};
    sc_vec3 found;

    for (size_t i = 0; i < SC_COUNT_OF(expected); i++) {
        for (int k = 0; k < 8 && expected[i].words[k]; k++) {
            assert_true(sc_anatomical_direction(expected[i].words[k], &found));
            assert_near(sc_vec3_length(sc_vec3_sub(found, expected[i].direction)), 0, 0);
        }
    }
    assert_false(sc_anatomical_direction("cranium", &found));
}

RUN_TESTS(NULL, NULL)
