/* SPDX-License-Identifier: BSD-3-Clause */
/* The pictures that pages show. */
#include "desk.h"

#include "segcast/views.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A sketch may take so long, so that it and what the browser does stay below what a hand feels. */
#define SKETCH_S 0.035
/* No coarser than this: a picture that is a mosaic tells nothing. */
#define SCALE_LEAST 0.25
/* The quality of JPEG: lower, smooth surfaces show steps; higher, it takes more of the line. */
enum { JPEG_QUALITY = 80 };

/* Pixels of a slice, which are asked for side by side. */
#define SLICE_MOST_PX 4e6

/* What shines through where a picture has no background. */
static const uint8_t paper[3] = {200, 200, 200};

/* Answer with a picture, whose data are taken. @param view what it shows; taken, too. */
static void answer_picture(sc_call *call, json_t *view, const char *type, char *data, size_t bytes)
{
    char *text = view ? json_dumps(view, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;

    json_decref(view);
    sc_http_answer(call, 200, type, data, bytes, text);
    free(text);
}

/* Choose how coarse a sketch is, by what a pixel has taken lately. */
static double choose_scale(const sc_shown *shown)
{
    const double pixels = (double)shown->size_px[0] * shown->size_px[1];
    const double scale = shown->s_per_px > 0 ? sqrt(SKETCH_S / (pixels * shown->s_per_px)) : 0.5;

    return fmin(1, fmax(SCALE_LEAST, scale));
}

/* Draw a sketch to @p image. */
static sc_status draw_sketch(sc_desk *desk, sc_image *image)
{
    const bool whole = desk->now->compare != NULL;
    const double scale = whole ? 1 : choose_scale(&desk->shown);
    const int *size_px = desk->shown.size_px;
    const int width = (int)fmax(16, floor(scale * size_px[0] + 0.5));
    const int height = (int)fmax(16, floor(scale * size_px[1] + 0.5));
    sc_render_stats stats;
    sc_status status;
    double begin_s;

    SC_PASS(sc_image_init_alpha(&desk->ctx, width, height, desk->now->job.render.background.is_none,
                                image));
    sc_session_hurry(desk->now, true);
    begin_s = sc_wall_s();
    status = sc_session_sketch(&desk->app, desk->now, desk->frame, image, &stats);
    sc_session_hurry(desk->now, false);
    begin_s = (sc_wall_s() - begin_s) / ((double)width * height);
    desk->shown.s_per_px =
        desk->shown.s_per_px > 0 ? 0.6 * desk->shown.s_per_px + 0.4 * begin_s : begin_s;
    sc_image_flatten(image, paper);
    return status;
}

void sc_desk_sketch(sc_desk *desk, sc_call *call)
{
    SC_OWN(sc_image_clear) sc_image image = {0};
    char *data = NULL;
    size_t bytes = 0;

    if (draw_sketch(desk, &image) != SC_OK ||
        sc_image_compress_jpeg(&desk->ctx, &image, JPEG_QUALITY, &data, &bytes) != SC_OK)
        sc_desk_refuse(desk, call, "the picture could not be drawn");
    else
        answer_picture(call, sc_desk_view(desk), "image/jpeg", data, bytes);
}

bool sc_desk_refine(sc_desk *desk, sc_call *call)
{
    SC_OWN(sc_image_clear) sc_image image = {0};
    sc_render_stats stats;
    char *data = NULL;
    size_t bytes = 0;
    sc_status status = sc_session_image(&desk->app, desk->now, &image);
    bool gives_up;

    desk->may_interrupt = 1;
    sc_session_hurry(desk->now, false);
    gives_up = sc_http_waits(desk->http);
    if (status == SC_OK && !gives_up)
        status = sc_session_light(&desk->app, desk->now);
    if (status == SC_OK && !gives_up)
        status = sc_session_draw(&desk->app, desk->now, desk->frame, NULL, &image, &stats);
    desk->may_interrupt = 0;
    gives_up = gives_up || desk->interrupt;
    desk->interrupt = 0;
    if (gives_up)
        return false;
    if (status == SC_OK)
        status = sc_image_compress_png(&desk->ctx, &image, "the picture", &data, &bytes);
    if (status == SC_OK)
        answer_picture(call, sc_desk_view(desk), "image/png", data, bytes);
    else
        sc_desk_refuse(desk, call, "the picture could not be drawn");
    return true;
}

/* Read a point in mm from a member of what is asked. @return whether it is one. */
static bool read_point(const json_t *point, sc_vec3 *out)
{
    if (json_array_size(point) != 3)
        return false;
    *out = (sc_vec3){json_number_value(json_array_get(point, 0)),
                     json_number_value(json_array_get(point, 1)),
                     json_number_value(json_array_get(point, 2))};
    return true;
}

void sc_desk_slice(sc_desk *desk, sc_call *call)
{
    const json_t *body = sc_call_body(call);
    const json_int_t which = json_integer_value(json_object_get(body, "which"));
    SC_OWN(sc_image_clear) sc_image image = {0};
    int size_px[2], frame;
    sc_panel *panel = sc_session_panel(desk->now, desk->frame, &frame);
    sc_render_stats stats;
    sc_scene scene, slice;
    sc_views views;
    char *data = NULL;
    size_t bytes = 0;

    if (!sc_desk_size(body, size_px) || which < 0 || which > 2 || !panel->phases ||
        (double)size_px[0] * size_px[1] > SLICE_MOST_PX) {
        sc_desk_refuse(desk, call, "there is no such slice");
        return;
    }
    scene = sc_panel_scene(panel, frame);
    (void)read_point(json_object_get(body, "point"), &scene.point_mm);
    views = (sc_views){.low_mm = panel->timeline.low_mm,
                       .high_mm = panel->timeline.high_mm,
                       .oriented = panel->volume.oriented};
    slice = sc_views_slice(&views, (int)which, size_px, &scene);
    if (sc_image_init(&desk->ctx, size_px[0], size_px[1], &image) != SC_OK) {
        sc_desk_refuse(desk, call, "out of memory");
        return;
    }
    sc_render_view(panel->renderers[0], &slice, NULL, NULL, NULL, &image, &stats);
    if (sc_image_compress_png(&desk->ctx, &image, "the slice", &data, &bytes) != SC_OK)
        sc_desk_refuse(desk, call, "the slice could not be drawn");
    else
        answer_picture(call, sc_desk_view_of(desk, &slice), "image/png", data, bytes);
}

void sc_desk_pick(sc_desk *desk, sc_call *call)
{
    int size_px[2], frame;
    sc_panel *panel = sc_session_panel(desk->now, desk->frame, &frame);
    const double x = json_number_value(json_object_get(sc_call_body(call), "x"));
    const double y = json_number_value(json_object_get(sc_call_body(call), "y"));
    sc_pick pick;
    sc_scene scene;

    if (!sc_desk_size(sc_call_body(call), size_px) || !panel->phases) {
        sc_desk_refuse(desk, call, "there is nothing to point at");
        return;
    }
    scene = sc_panel_scene(panel, frame);
    pick = sc_render_pick(panel->renderers[0], &scene, size_px, x, y);
    sc_http_answer_json(call, 200,
                        json_pack("{s:i, s:[f,f,f]}", "id", pick.id, "at", pick.at_mm.x,
                                  pick.at_mm.y, pick.at_mm.z));
}
