/* SPDX-License-Identifier: BSD-3-Clause */
/* Tests lines and text over pictures, and the position, orientation and colours of the slices. */
#include "check.h"
#include "compare_images.h"

#include "scenes.h"
#include "segcast/views.h"

#include <math.h>

static const uint8_t black[3] = {0, 0, 0}, white[3] = {255, 255, 255};

static sc_image blank_image(int width, int height)
{
    sc_image image;

    assert_ok(sc_image_init(&quiet, width, height, &image));
    memset(image.rgb, 255, sc_image_bytes(&image));
    return image;
}

TEST(lines_and_frames_are_drawn_at_their_coordinates)
{
    SC_OWN(sc_image_clear) sc_image image = blank_image(60, 40);
    sc_overlay *overlay;

    assert_ok(sc_overlay_begin(&quiet, &image, &overlay));
    sc_overlay_line(overlay, 10, 20.5, 50, 20.5, 1, black, 1);
    sc_overlay_frame(overlay, 2.5, 2.5, 54, 34, 1, black);
    assert_memory_equal(pixel(&image, 30, 20), white,
                        3); /* nothing is drawn before sc_overlay_finish */
    assert_ok(sc_overlay_finish(&quiet, overlay));
    for (int x = 12; x < 48; x++) {
        assert_memory_equal(pixel(&image, x, 20), black, 3);
        assert_memory_equal(pixel(&image, x, 18), white, 3);
        assert_memory_equal(pixel(&image, x, 2), black, 3);
        assert_memory_equal(pixel(&image, x, 36), black, 3);
    }
}

/* Find the bounding box of the dark pixels: left, top, right, bottom. */
static void ink_box(const sc_image *image, int box[4])
{
    box[0] = box[1] = 10000;
    box[2] = box[3] = -1;
    for (int y = 0; y < image->height_px; y++) {
        for (int x = 0; x < image->width_px; x++) {
            if (pixel(image, x, y)[0] > 100)
                continue;
            box[0] = x < box[0] ? x : box[0];
            box[1] = y < box[1] ? y : box[1];
            box[2] = x > box[2] ? x : box[2];
            box[3] = y > box[3] ? y : box[3];
        }
    }
}

TEST(text_is_anchored_and_sized_as_asked_for)
{
    const sc_letters letters = {.size_px = 30, .halo = {255, 255, 255}};

    for (int anchor = -1; anchor <= 1; anchor++) {
        SC_OWN(sc_image_clear) sc_image image = blank_image(200, 100);
        sc_overlay *overlay;
        int box[4];

        assert_ok(sc_overlay_begin(&quiet, &image, &overlay));
        sc_overlay_text(overlay, 100, 50, anchor, anchor, &letters, "HL");
        assert_ok(sc_overlay_finish(&quiet, overlay));
        ink_box(&image, box);
        assert_in_range(box[3] - box[1], 17, 27); /* the height of capitals */
        assert_near(box[0] + (anchor + 1) / 2.0 * (box[2] - box[0]), 100, 3);
        assert_near(box[1] + (anchor + 1) / 2.0 * (box[3] - box[1]), 50, 3);
    }
}

/* Three rods from the middle of the volume towards right, anterior and superior: ids 1, 2 and 3. */
static int rods(double x, double y, double z)
{
    const bool mx = fabs(x - 20) < 2, my = fabs(y - 20) < 2, mz = fabs(z - 20) < 2;

    return x > 20 && my && mz ? 1 : y > 20 && mx && mz ? 2 : z > 20 && mx && my ? 3 : 0;
}

static int filled(double x, double y, double z)
{
    return x >= 0 && y >= 0 && z >= 0;
}

TEST(slices_are_in_radiological_convention)
{
    static const uint8_t colors[4][3] = {{0}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
    const int size[3] = {41, 41, 41};
    const double spacing[3] = {1, 1, 1};
    /* the two rods that lie in each slice, and where they are seen, in pixels from its middle */
    static const int rod_of[3][2] = {{1, 2}, {1, 3}, {2, 3}};
    static const int steps[3][2][2] = {
        {{-25, 0}, {0, -25}}, {{-25, 0}, {0, -25}}, {{-25, 0}, {0, -25}}};
    sc_volume volume = shape_volume(size, spacing, 1, 4, rods);
    small_scene s;
    const sc_views views = {.high_mm = {40, 40, 40}, .oriented = true};
    SC_OWN(sc_image_clear) sc_image image = blank_image(400, 400);
    sc_renderer *r;
    const sc_viewport space = {200, 200, 200, 200};
    sc_render_stats stats, alone;
    sc_scene scene;

    for (int id = 1; id < 4; id++)
        memcpy(volume.labels[id].rgb, colors[id], 3);
    s = make_scene(volume, 1);
    scene = front_view(&s);
    scene.point_mm = (sc_vec3){20, 20, 20};
    scene.dark_text = 1;
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    assert_ok(sc_views_draw(&quiet, r, &views, &scene, NULL, &image, &stats));
    for (int panel = 0; panel < 3; panel++) {
        for (int i = 0; i < 2; i++) {
            /* 3 pixels beside the line that shows where another slice crosses */
            const int x = (panel & 1) * 200 + 100 + steps[panel][i][0] + (i ? 3 : 0);
            const int y = (panel & 2) * 100 + 100 + steps[panel][i][1] + (i ? 0 : 3);

            assert_memory_equal(pixel(&image, x, y), colors[rod_of[panel][i]], 3);
        }
        assert_memory_equal(pixel(&image, (panel & 1) * 200 + 125, (panel & 2) * 100 + 103), white,
                            3);
    }
    sc_render_view(r, &scene, &space, NULL, NULL, &image, &alone);
    assert_true(alone.counters.rays > 0 && stats.counters.rays > alone.counters.rays);
    sc_renderer_free(r);
    free_scene(&s);
}

/* Each slice fills its panel: the transverse one of a long box has twice the scale of the others.
 */
TEST(each_slice_has_the_scale_of_its_panel)
{
    const int size[3] = {41, 41, 81};
    const double spacing[3] = {1, 1, 1};
    static const double px_per_mm[3] = {4, 2, 2};
    SC_OWN(free_scene) small_scene s = make_scene(shape_volume(size, spacing, 1, 2, filled), 1);
    const sc_views views = {.high_mm = {40, 40, 80}};
    SC_OWN(sc_image_clear) sc_image image = blank_image(400, 400);
    sc_scene scene = front_view(&s);
    sc_render_stats stats;
    sc_renderer *r;

    scene.point_mm = (sc_vec3){21, 21, 41};
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    assert_ok(sc_views_draw(&quiet, r, &views, &scene, NULL, &image, &stats));
    for (int panel = 0; panel < 3; panel++) {
        const uint8_t *middle = pixel(&image, (panel & 1) * 200 + 100, (panel & 2) * 100 + 110);
        const int reach = (int)(20 * px_per_mm[panel]);

        assert_memory_equal(middle + 3 * (reach - 3), middle - 3 * 20, 3);
        assert_memory_equal(middle + 3 * (reach + 4), white, 3);
    }
    sc_renderer_free(r);
}

/* What a film, a comparison or several views take is the sum of their pictures. */
TEST(work_and_times_are_added_up)
{
    sc_render_stats sum = {
        {.rays = 1, .cell_visits = 2, .brick_steps = 3, .contributions = 4}, 5, 6};
    const sc_render_stats more = {
        {.rays = 10, .cell_visits = 20, .brick_steps = 30, .contributions = 40}, 50, 60};

    sc_render_stats_add(&sum, &more);
    assert_int_equal(sum.counters.rays, 11);
    assert_int_equal(sum.counters.cell_visits, 22);
    assert_int_equal(sum.counters.brick_steps, 33);
    assert_int_equal(sum.counters.contributions, 44);
    assert_true(sum.wall_s == 55 && sum.cpu_s == 66);
}

TEST(a_failed_allocation_is_reported)
{
    SC_OWN(sc_image_clear) sc_image image = blank_image(32, 32);
    long budget = 0;
    const sc_ctx poor = {.alloc_budget = &budget};
    sc_overlay *overlay = NULL;

    assert_int_equal(sc_overlay_begin(&poor, &image, &overlay), SC_ERR_MEMORY);
    assert_null(overlay);
}

static int solid(double x, double y, double z)
{
    return x > 2 && y > 2 && z > 2;
}

/* The tiles of a frame that is given up are passed over without asking the clock for each: a frame
 * of 16K pixels has 130,000 of them. */
TEST(a_frame_that_is_given_up_is_not_measured)
{
    const int size[3] = {9, 9, 9};
    const double spacing[3] = {1, 1, 1};
    SC_OWN(free_scene) small_scene s = make_scene(shape_volume(size, spacing, 1, 2, solid), 1);
    const sc_scene scene = front_view(&s);
    atomic_int give_up = 0;
    sc_render_stats stats;
    sc_render_span span;
    sc_renderer *r;
    SC_OWN(sc_image_clear) sc_image image = blank_image(s.settings.width_px, s.settings.height_px);

    s.settings.work.threads = 1;
    s.settings.work.give_up = &give_up;
    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    sc_render_view(r, &scene, NULL, NULL, NULL, &image, &stats);
    sc_renderer_spans(r, &span);
    assert_true(stats.counters.rays > 0 && span.begin_s > 0);
    give_up = 1;
    sc_render_view(r, &scene, NULL, NULL, NULL, &image, &stats);
    sc_renderer_spans(r, &span);
    assert_int_equal(stats.counters.rays, 0);
    assert_true(span.begin_s == 0 && span.end_s == 0 && stats.cpu_s == 0);
    sc_renderer_free(r);
}

/* What is drawn over a transparent picture looks, over any colour, as if it had been drawn on it.
 */
TEST(drawing_over_a_transparent_picture_keeps_it_transparent)
{
    static const uint8_t dark[3] = {20, 30, 40}, behind[3] = {250, 120, 0};
    const sc_letters letters = {20, {20, 20, 20}, {255, 255, 255}};
    SC_OWN(sc_image_clear) sc_image clear = {0}, opaque = {0};
    sc_overlay *overlay;
    image_difference d;

    assert_ok(sc_image_init_alpha(&quiet, 60, 40, true, &clear));
    for (size_t i = 0; i < 60 * 40; i++) {
        const uint8_t half[4] = {10, 200, 100, 128}, nothing[4] = {0, 0, 0, 0};

        memcpy(clear.rgb + 4 * i, i % 60 < 30 ? half : nothing, 4);
    }
    assert_ok(sc_image_init_alpha(&quiet, 60, 40, true, &opaque));
    memcpy(opaque.rgb, clear.rgb, sc_image_bytes(&clear));
    sc_image_flatten(&opaque, behind);
    for (int i = 0; i < 2; i++) {
        assert_ok(sc_overlay_begin(&quiet, i ? &opaque : &clear, &overlay));
        sc_overlay_line(overlay, 5, 10, 55, 12, 3, dark, 0.5);
        sc_overlay_text(overlay, 30, 25, 0, 0, &letters, "RAS");
        assert_ok(sc_overlay_finish(&quiet, overlay));
    }
    assert_int_equal(clear.rgb[4 * (60 * 38 + 50) + 3], 0);
    sc_image_flatten(&clear, behind);
    assert_true(compare_images(&clear, &opaque, &d));
    assert_true(d.largest <= 2); /* rounding */
    assert_in_range(d.differing_px, 0, 400);
}

RUN_TESTS(NULL, NULL)
