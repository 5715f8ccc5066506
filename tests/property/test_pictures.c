/* SPDX-License-Identifier: BSD-3-Clause */
/* Properties that pictures of any volume must have: above all, they depend on the anatomy, and not
 * on how it is stored. */
#include "check.h"
#include "compare_images.h"

#include "scenes.h"

#include <math.h>

static sc_image front_picture(sc_volume volume)
{
    SC_OWN(free_scene) small_scene s = make_scene(volume, 0.7);
    sc_scene scene;
    sc_image image;

    s.settings.sampling.samples = 2;
    scene = front_view(&s);
    image = draw_view(&s, &scene, NULL);
    return image;
}

static void expect_alike(const sc_image *a, const sc_image *b, double rms)
{
    image_difference d;

    assert_true(compare_images(a, b, &d));
    if (d.rms > rms)
        fail_msg("pictures differ: rms %.3f, largest %d, %zu pixels", d.rms, d.largest,
                 d.differing_px);
}

/* Draw a small heart without a background and with one of colour @p behind, lay the former over
 * that colour, and compare. @param change its samples, everywhere and depth cue are set. */
static void expect_over(sc_render_settings change, const uint8_t behind[3], int largest, double rms)
{
    SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 0.5);
    sc_scene scene;
    SC_OWN(sc_image_clear) sc_image clear = {0}, opaque = {0};
    image_difference d;
    size_t empty = 0, full = 0;

    s.settings.sampling.samples = change.sampling.samples;
    s.settings.sampling.everywhere = change.sampling.everywhere;
    s.settings.light.depth_cue = change.light.depth_cue;
    memcpy(s.settings.background, behind, 3);
    scene = front_view(&s);
    opaque = draw_view(&s, &scene, NULL);
    s.settings.transparent = true;
    clear = draw_view(&s, &scene, NULL);
    for (int i = 0; i < clear.width_px * clear.height_px; i++) {
        const uint8_t *p = clear.rgb + 4 * (size_t)i;

        empty += p[3] == 0;
        full += p[3] > 250;
        if (p[3] == 0)
            assert_true(p[0] == 0 && p[1] == 0 && p[2] == 0);
    }
    assert_in_range(empty, 1000, 6000);
    if (change.light.depth_cue == 0)
        assert_in_range(full, 200, 6000);
    sc_image_flatten(&clear, behind);
    assert_true(compare_images(&clear, &opaque, &d));
    if (d.largest > largest || d.rms > rms)
        fail_msg("laid over a colour it differs: rms %.3f, largest %d", d.rms, d.largest);
}

/* A transparent picture shows any background as if it had been drawn with it, without a rim of
 * another colour. What is left is the difference between square roots, which are blended in
 * drawing, and levels of sRGB, which are blended by what lays pictures over each other. */
TEST(transparent_pictures_fit_any_background)
{
    static const uint8_t colours[][3] = {{0, 0, 0}, {255, 0, 0}, {0, 255, 0}, {255, 255, 255}};

    for (size_t i = 0; i < SC_COUNT_OF(colours); i++) {
        expect_over((sc_render_settings){.sampling.samples = 1}, colours[i], 16, 4);
        expect_over((sc_render_settings){.sampling.samples = 5}, colours[i], 16, 4);
        expect_over((sc_render_settings){.sampling.samples = 4, .sampling.everywhere = true},
                    colours[i], 16, 4);
        /* What fades has another colour in each channel, but one alpha. */
        expect_over((sc_render_settings){.sampling.samples = 1, .light = {.depth_cue = 0.8}},
                    colours[i], 64, 12);
    }
}

/* @return a copy of a volume that is stored along other axes, while every voxel keeps its position
 * in RAS. Axis i of the copy runs along axis order[i] of the original, and backwards if bit i of @p
 * flip is set. */
static sc_volume stored_along(const sc_volume *v, const int order[3], int flip)
{
    sc_volume out = *v;
    const size_t stride[3] = {1, (size_t)v->size[0], (size_t)v->size[0] * (size_t)v->size[1]};
    void *block;
    size_t n = 0;

    assert_ok(sc_alloc(&quiet, sc_volume_voxels(v), 1, &out.ids));
    assert_ok(sc_alloc(&quiet, (size_t)v->label_count, sizeof(sc_label), &block));
    memcpy(block, v->labels, (size_t)v->label_count * sizeof(sc_label));
    out.labels = block;
    for (int i = 0; i < 3; i++) {
        out.size[i] = v->size[order[i]];
        for (int row = 0; row < 3; row++) {
            const double column = v->to_ras_mm.m[row][order[i]];

            out.to_ras_mm.m[row][i] = flip >> i & 1 ? -column : column;
            out.to_ras_mm.m[row][3] += flip >> i & 1 ? column * (out.size[i] - 1) : 0;
        }
    }
    for (int z = 0; z < out.size[2]; z++) {
        for (int y = 0; y < out.size[1]; y++) {
            for (int x = 0; x < out.size[0]; x++, n++) {
                const int at[3] = {x, y, z};
                size_t from = 0;

                for (int i = 0; i < 3; i++)
                    from += stride[order[i]] *
                            (size_t)(flip >> i & 1 ? out.size[i] - 1 - at[i] : at[i]);
                ((uint8_t *)out.ids)[n] = ((const uint8_t *)v->ids)[from];
            }
        }
    }
    return out;
}

/* Of the 48 ways to store a volume every order of the axes and every set of axes that run
 * backwards. */
TEST(all_orders_of_the_axes_give_the_same_picture)
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                     {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    SC_OWN(sc_volume_clear) sc_volume original = small_phantom();
    SC_OWN(sc_image_clear) sc_image first = front_picture(stored_along(&original, orders[0], 0));

    for (int i = 1; i < 48; i += 5) {
        SC_OWN(sc_image_clear)
        sc_image other = front_picture(stored_along(&original, orders[i / 8], i % 8));

        expect_alike(&first, &other, 0.6); /* rounding may move a sample into the next voxel */
    }
}

TEST(mirrored_anatomy_gives_another_picture)
{
    sc_volume original = small_phantom(), mirrored;
    SC_OWN(sc_image_clear) sc_image a = {0}, b = {0};
    image_difference d;

    mirrored = stored_along(&original, (const int[]){0, 1, 2}, 0);
    mirrored.to_ras_mm.m[0][0] *= -1;
    mirrored.to_ras_mm.m[0][3] *= -1;
    b = front_picture(mirrored);
    a = front_picture(original);
    assert_true(compare_images(&a, &b, &d));
    assert_true(d.rms > 20);
}

/* The picture stays the same if tissues get other label numbers, and the label table as well. On
 * smooth surfaces a point where two labels have the same vote may change its owner. */
TEST(relabelling_volume_and_table_together_changes_nothing)
{
    sc_volume original = small_phantom(), renamed;
    SC_OWN(sc_image_clear) sc_image a = {0}, b = {0};

    renamed = stored_along(&original, (const int[]){0, 1, 2}, 0);
    for (int id = 1; id < renamed.label_count; id++) { /* reverses the order of the ids */
        renamed.labels[renamed.label_count - id] = original.labels[id];
        renamed.labels[renamed.label_count - id].value = 1000 - 3 * id;
    }
    for (size_t i = 0; i < sc_volume_voxels(&renamed); i++) {
        uint8_t *id = (uint8_t *)renamed.ids + i;

        *id = *id ? (uint8_t)(renamed.label_count - *id) : 0;
    }
    a = front_picture(original);
    b = front_picture(renamed);
    expect_alike(&a, &b, tested_surface == SC_SURFACE_SMOOTH ? 0.05 : 0);
}

static double difference_rms(const sc_image *a, const sc_image *b)
{
    image_difference d;

    assert_true(compare_images(a, b, &d));
    return d.rms;
}

/* Spacing matters: a volume with slices twice as thick gives a picture more like that of the fine
 * volume than one with voxels twice as large along all axes, and much more than the thick slices
 * would if their voxels were treated as cubes. */
TEST(thick_slices_look_like_the_fine_volume)
{
    static const int sizes[3][3] = {{120, 84, 124}, {120, 84, 62}, {60, 42, 62}};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    sc_volume flat;
    sc_image images[3], squashed;

    assert_ok(sc_phantom_new(&quiet, &phantom));
    for (int i = 0; i < 3; i++) {
        sc_volume v;

        assert_ok(sc_phantom_volume(&quiet, phantom, sizes[i], 2, &v));
        images[i] = front_picture(v);
    }
    assert_ok(sc_phantom_volume(&quiet, phantom, sizes[1], 2, &flat));
    flat.to_ras_mm.m[2][2] /= 2;
    squashed = front_picture(flat);
    assert_true(difference_rms(&images[1], &images[0]) < difference_rms(&images[2], &images[0]));
    assert_true(3 * difference_rms(&images[1], &images[0]) < difference_rms(&squashed, &images[0]));
    for (int i = 0; i < 3; i++)
        sc_image_clear(&images[i]);
    sc_image_clear(&squashed);
}

static size_t covered(const sc_image *image)
{
    size_t count = 0;

    for (size_t i = 0; i < sc_image_bytes(image); i += 3)
        count += memcmp(image->rgb + i, "\xff\xff\xff", 3) != 0;
    return count;
}

/* A clip plane that moves through the heart removes more with every frame. */
TEST(a_sweep_removes_more_with_every_frame)
{
    SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 1);
    sc_animation a = {0};
    sc_renderer *r;
    sc_timeline t;
    size_t last = SIZE_MAX;

    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    (void)orbit_of(r, 9.0 / 7, 12, &a);
    a.camera.turns = 0;
    a.sweep_count = 1;
    a.sweeps[0] = (sc_sweep){
        .normal = {0, 0, -1},
        .at_track = {2, {{.at = 0, .value = {0, 1, 0}}, {.at = 1, .value = {100, 1, 0}}}}};
    t = orbit_of(r, 9.0 / 7, 12, &a);
    sc_renderer_free(r);
    for (int k = 0; k < 12; k++) {
        const sc_scene scene = sc_timeline_scene(&t, k, NULL);
        SC_OWN(sc_image_clear) sc_image image = draw_view(&s, &scene, NULL);
        const size_t now = covered(&image);

        assert_true(now <= last);
        assert_true(k == 0 ? now > 1000 : true);
        last = now;
    }
    assert_true(last < 60);
}

/* A quarter turn of the camera gives the same picture as a quarter turn of the patient. */
TEST(a_quarter_turn_equals_permuted_axes)
{
    /* Borders are computed in cubes of 16 voxels, which begin at ends of the patient. */
    sc_volume original = phantom_of((const int[3]){64, 48, 64}), turned;
    small_scene a, b;
    sc_animation animation = {0};
    sc_renderer *r;
    sc_timeline t;
    sc_scene scene;
    SC_OWN(sc_image_clear) sc_image first = {0}, second = {0};

    turned = stored_along(&original, (const int[]){0, 1, 2}, 0);
    for (int i = 0; i < 4; i++) { /* the patient turns by -90 degrees about z: (x, y) -> (y, -x) */
        turned.to_ras_mm.m[0][i] = original.to_ras_mm.m[1][i];
        turned.to_ras_mm.m[1][i] = -original.to_ras_mm.m[0][i];
    }
    a = make_scene(original, 0.7);
    b = make_scene(turned, 0.7);
    assert_ok(sc_renderer_new(&quiet, &a.settings, &a.prepared.view, a.tissues, &r));
    t = orbit_of(r, 9.0 / 7, 8, &animation);
    sc_renderer_free(r);
    scene = sc_timeline_scene(&t, 2, NULL);
    first = draw_view(&a, &scene, NULL);
    animation = (sc_animation){0};
    assert_ok(sc_renderer_new(&quiet, &b.settings, &b.prepared.view, b.tissues, &r));
    t = orbit_of(r, 9.0 / 7, 8, &animation);
    sc_renderer_free(r);
    scene = sc_timeline_scene(&t, 0, NULL);
    second = draw_view(&b, &scene, NULL);
    expect_alike(&first, &second, 1);
    free_scene(&a);
    free_scene(&b);
}

/* What is counted pixel by pixel adds up to what a frame with one ray in each pixel took, with
 * every skip method. */
TEST(counts_of_pixels_add_up_to_the_frame)
{
    SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 0.7);
    const sc_scene scene = front_view(&s);
    const size_t pixels = (size_t)s.settings.width_px * (size_t)s.settings.height_px;
    SC_OWN(sc_free_at) sc_march_counters *counts = NULL;
    void *block;

    s.settings.sampling.samples = 1;
    assert_ok(sc_alloc(&quiet, pixels, sizeof *counts, &block));
    counts = block;
    for (int skip = SC_SKIP_NONE; skip <= SC_SKIP_LEAP; skip++) {
        sc_render_stats frame, stats;
        sc_renderer *r;
        SC_OWN(sc_image_clear) sc_image image = {0};
        uint64_t samples = 0;

        s.settings.skip = (sc_skip)skip;
        image = draw_view(&s, &scene, &frame);
        assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
        sc_render_counts(r, &scene, s.settings.width_px, s.settings.height_px, counts, &stats);
        for (size_t i = 0; i < pixels; i++) {
            samples += counts[i].cell_visits;
            assert_true(counts[i].rays <= 1);
        }
        assert_true(samples > pixels / 10);
        assert_int_equal(samples, frame.counters.cell_visits);
        assert_int_equal(stats.counters.cell_visits, samples);
        assert_int_equal(stats.counters.rays, frame.counters.rays);
        assert_int_equal(stats.counters.contributions, frame.counters.contributions);
        sc_renderer_free(r);
    }
}

/* A frame with a clip plane in which tissues have faded to different degrees, two of them to
 * nothing. @param factors room for those of all tissues. */
static sc_scene faded_view(small_scene *s, float *factors)
{
    sc_scene scene = front_view(s);

    for (int id = 0; id < s->prepared.view.label_count; id++) {
        s->tissues[id].fade_group = id % 4 ? (uint8_t)(1 + id % 3) : 0;
        factors[id] = id % 4 ? 0.7f * (float)(id % 3) : 1;
    }
    scene.clip.count = 1;
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 0};
    scene.clip.set_count = 1;
    scene.clip.sets[0] = 1;
    scene.fades = factors;
    return scene;
}

/* Draw a scene by all skip methods, with variants of the kernels, tiles, threads, and with and
 * without early ray termination: the picture must be @p first. */
static void expect_same_by_all_ways(small_scene *s, const sc_scene *scene, const sc_image *first)
{
    for (int i = 0; i < 2 * (SC_SKIP_LEAP + 1); i++) {
        SC_OWN(sc_image_clear) sc_image other = {0};

        s->settings.skip = (sc_skip)(i / 2);
        s->settings.cpu = i % 2 ? "c" : "auto";
        s->settings.work.tile_px = 8 + 11 * i;
        s->settings.work.threads = 1 + i % 3;
        s->settings.sampling.to_the_end = i % 5 == 0;
        other = draw_view(s, scene, NULL);
        expect_alike(first, &other, 0);
    }
}

/* Tissues that fade look the same whatever way a frame is drawn. */
TEST(faded_pictures_do_not_depend_on_the_way_they_are_drawn)
{
    float factors[64];

    for (int local = 0; local < 2; local++) {
        SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 0.8);
        sc_scene scene = faded_view(&s, factors);
        SC_OWN(sc_image_clear) sc_image first = {0};

        s.settings.local_thickness = local;
        s.settings.light.shadows = local;
        for (int id = 1; id < s.prepared.view.label_count; id++)
            s.tissues[id].opacity_auto = local;
        s.settings.skip = SC_SKIP_NONE;
        first = draw_view(&s, &scene, NULL);
        expect_same_by_all_ways(&s, &scene, &first);
    }
}

/* Let tissues of a scene move, each third in another direction. @param offsets_mm room for those of
 * all tissues. */
static void move_apart(small_scene *s, sc_scene *scene, double by_mm, sc_vec3 *offsets_mm)
{
    static const sc_vec3 ways[4] = {{0, 0, 0}, {1, 0.2, 0}, {-0.5, 1, 0.3}, {0, 0.5, 1}};

    for (int id = 0; id < s->prepared.view.label_count; id++) {
        s->tissues[id].part = (uint8_t)(id % 4);
        offsets_mm[id] = sc_vec3_scale(ways[id % 4], by_mm);
    }
    scene->offsets_mm = offsets_mm;
}

/* Tissues that have moved look the same whatever way a frame is drawn. Without a way to go, the
 * picture is the ordinary one. */
TEST(moved_pictures_do_not_depend_on_the_way_they_are_drawn)
{
    float factors[64];
    sc_vec3 offsets_mm[64];

    for (int fades = 0; fades < 2; fades++) {
        SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), fades ? 0.5 : 1);
        sc_scene scene = fades ? faded_view(&s, factors) : front_view(&s);
        sc_image still = draw_view(&s, &scene, NULL), first;
        image_difference d;

        move_apart(&s, &scene, 0, offsets_mm);
        first = draw_view(&s, &scene, NULL);
        expect_alike(&still, &first, 0);
        sc_image_clear(&first);
        move_apart(&s, &scene, 9, offsets_mm);
        s.settings.sampling.everywhere = false;
        s.settings.sampling.samples = 3;
        s.settings.skip = SC_SKIP_NONE;
        first = draw_view(&s, &scene, NULL);
        assert_true(compare_images(&still, &first, &d));
        assert_true(d.rms > 5);
        expect_same_by_all_ways(&s, &scene, &first);
        sc_image_clear(&still);
        sc_image_clear(&first);
    }
}

/* @return a volume of empty voxels of 1 mm with balls: two of label 1, one behind the other along
 * y, and one of each of the labels 2 and 3, moved by whole voxels along x. */
static sc_volume four_balls(const int moved[4])
{
    const int size[3] = {64, 80, 40};
    static const int balls[4][4] = {
        {1, 36, 12, 20}, {1, 36, 68, 20}, {2, 52, 40, 21}, {3, 9, 40, 19}};
    sc_volume v = {.size = {size[0], size[1], size[2]},
                   .label_bytes = 1,
                   .label_count = 4,
                   .oriented = true,
                   .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};

    assert_ok(sc_zalloc(&quiet, (size_t)size[0] * (size_t)size[1] * (size_t)size[2], 1, &v.ids));
    assert_ok(SC_ZALLOC(&quiet, 4, &v.labels));
    for (int id = 0; id < 4; id++) {
        v.labels[id].value = id;
        v.labels[id].rgb[0] = (uint8_t)(80 * id);
        v.labels[id].rgb[2] = 200;
    }
    for (int i = 0; i < size[0] * size[1] * size[2]; i++) {
        for (int b = 0; b < 4; b++) {
            const int *ball = balls[b];
            const int dx = i % size[0] - moved[ball[0]] - ball[1];
            const int dy = i / size[0] % size[1] - ball[2], dz = i / size[0] / size[1] - ball[3];

            if (dx * dx + dy * dy + dz * dz < 26)
                ((uint8_t *)v.ids)[i] = (uint8_t)ball[0];
        }
    }
    return v;
}

/* A picture of tissues that were moved is that of a volume in which they stand there, also where
 * a translucent one lies between the layers of another. */
TEST(moved_tissues_look_as_if_they_stood_there)
{
    /* Borders are computed in cubes of 16 voxels. */
    static const int moved[4] = {0, 0, -16, 0}, nowhere[4] = {0};

    for (int c = 0; c < 4; c++) {
        SC_OWN(free_scene) small_scene there = make_scene(four_balls(moved), c & 1 ? 0.4 : 1);
        SC_OWN(free_scene) small_scene here = make_scene(four_balls(nowhere), c & 1 ? 0.4 : 1);
        sc_scene scene = front_view(&there);
        sc_vec3 offsets_mm[4] = {{0, 0, 0}};
        SC_OWN(sc_image_clear) sc_image expected = {0}, drawn = {0};

        scene.camera =
            sc_camera_look(c & 2 ? (sc_vec3){200, 56, 30} : (sc_vec3){32, 216, 30},
                           (sc_vec3){32, 40, 20}, (sc_vec3){0, 0, 1}, SC_PERSPECTIVE, 0.14);
        there.settings.light.occlusion = here.settings.light.occlusion = 0;
        for (int id = 1; id < 4; id++) {
            here.tissues[id].part = (uint8_t)(id - 1);
            offsets_mm[id].x = moved[id];
        }
        expected = draw_view(&there, &scene, NULL);
        scene.offsets_mm = offsets_mm;
        drawn = draw_view(&here, &scene, NULL);
        expect_alike(&expected, &drawn, 0.6);
    }
}

/* What has faded to nothing leaves no trace: the picture is that of a volume in which these tissues
 * are not shown, but for the rounding of the occlusion. Factors of 1 change nothing at all. */
TEST(what_has_faded_leaves_no_trace)
{
    SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 0.8);
    float factors[64];
    sc_scene scene = faded_view(&s, factors);
    sc_renderer *r;
    SC_OWN(sc_image_clear) sc_image full = {0}, again = {0}, faded = {0}, hidden = {0};
    sc_render_stats stats, of_faded, of_hidden;

    for (int id = 1; id < s.prepared.view.label_count; id++)
        factors[id] = s.tissues[id].fade_group ? 0 : 1;
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    assert_ok(sc_image_init(&quiet, s.settings.width_px, s.settings.height_px, &faded));
    assert_ok(sc_image_init(&quiet, s.settings.width_px, s.settings.height_px, &again));
    sc_render_view(r, &scene, NULL, NULL, NULL, &faded, &of_faded);
    for (int id = 1; id < s.prepared.view.label_count; id++)
        factors[id] = 1;
    sc_render_view(r, &scene, NULL, NULL, NULL, &again, &stats);
    scene.fades = NULL;
    full = draw_view(&s, &scene, NULL);
    expect_alike(&full, &again, 0);
    for (int id = 1; id < s.prepared.view.label_count; id++)
        s.tissues[id].visible = !s.tissues[id].fade_group;
    hidden = draw_view(&s, &scene, &of_hidden);
    expect_alike(&hidden, &faded, 0.2);
    if (tested_surface == SC_SURFACE_SMOOTH) /* voxels go by the masks, and add what is clear */
        assert_int_equal(of_faded.counters.contributions, of_hidden.counters.contributions);
    assert_true(difference_rms(&full, &faded) > 10);
    sc_renderer_free(r);
}

/* Two balls that meet in a groove, which a layer fills; it is thin along its rims, and can be left
 * out. */
static bool has_layer;
static int balls_under_a_layer(double x, double y, double z)
{
    const double left = sqrt((x - 15) * (x - 15) + (y - 20) * (y - 20) + (z - 17) * (z - 17)),
                 right = sqrt((x - 28) * (x - 28) + (y - 20) * (y - 20) + (z - 22) * (z - 22));

    if (left < 11)
        return 1;
    if (right < 9)
        return 2;
    return has_layer && left < 13.5 && right < 11.5 ? 3 : 0;
}

/* Draw the balls in one colour, with the layer faded to @p factor, or without the layer if that is
 * negative. */
static sc_image draw_balls(float factor)
{
    const int size[3] = {42, 41, 40};
    const double spacing[3] = {1, 1, 1};
    float factors[4] = {1, 1, 1, factor};
    small_scene s;
    sc_scene scene;
    sc_image image;

    has_layer = factor >= 0;
    s = make_scene(shape_volume(size, spacing, 1, 4, balls_under_a_layer), 1);
    for (int id = 1; id < 3; id++) {
        for (int c = 0; c < 3; c++)
            s.tissues[id].rgb_linear[c] = 0.5f;
    }
    s.tissues[3].fade_group = has_layer;
    s.settings.width_px = s.settings.height_px = 160;
    scene = front_view(&s);
    scene.camera = sc_camera_look((sc_vec3){30, 100, 40}, (sc_vec3){20.5, 20, 19.5},
                                  (sc_vec3){0, 0, 1}, SC_ORTHOGRAPHIC, 17);
    scene.fades = has_layer ? factors : NULL;
    image = draw_view(&s, &scene, NULL);
    free_scene(&s);
    return image;
}

/* @return the share of the pixels that are not white in either picture whose light differs by more
 * than 30 levels. */
static double differently_lit(const sc_image *a, const sc_image *b)
{
    int both = 0, different = 0;

    for (size_t i = 0; i < sc_image_bytes(a); i += 3) {
        both += a->rgb[i] < 255 && b->rgb[i] < 255;
        different += a->rgb[i] < 255 && b->rgb[i] < 255 && abs(a->rgb[i] - b->rgb[i]) > 30;
    }
    return (double)different / both;
}

/* Once a thin layer has faded away, what it lay on is lit as if it had never been there: its
 * gradients, which tell nothing of its neighbours, leave neither spots nor creases. And it goes
 * little by little. */
TEST(a_thin_layer_that_has_faded_does_not_bend_the_light)
{
    enum { STEPS = 20 };
    sc_image bare, gone, last;
    double whole, most = 0;

    if (tested_surface != SC_SURFACE_SMOOTH)
        return;
    bare = draw_balls(-1);
    gone = draw_balls(0);
    assert_true(differently_lit(&bare, &gone) < 0.04);
    last = draw_balls(1);
    whole = difference_rms(&last, &gone);
    for (int i = STEPS - 1; i >= 0; i--) {
        sc_image next = draw_balls((float)i / STEPS);

        most = fmax(most, difference_rms(&last, &next));
        sc_image_clear(&last);
        last = next;
    }
    /* Rays pass the layer twice, so that its last steps change more than others. */
    assert_true(most < 4 * whole / STEPS);
    sc_image_clear(&last);
    sc_image_clear(&gone);
    sc_image_clear(&bare);
}

int main(void)
{
    int failed = 0;

    for (int surface = SC_SURFACE_VOXEL; surface <= SC_SURFACE_SMOOTH; surface++) {
        tested_surface = (sc_surface)surface;
        failed += run_all_tests(NULL, NULL);
    }
    return failed;
}
