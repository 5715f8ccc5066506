/* SPDX-License-Identifier: BSD-3-Clause */
/* The pictures that pages show. */
#include "desk.h"

#include "segcast/views.h"

#include <math.h>
#include <stdlib.h>

/* A sketch may take so long, so that it and what the browser does stay below what a hand feels. */
#define SKETCH_S 0.025
/* No coarser than this: a picture that is a mosaic tells nothing. */
#define SCALE_LEAST 0.25
/* The quality of JPEG: lower, smooth surfaces show steps; higher, it takes more of the line. */
enum { JPEG_QUALITY = 80 };

/* Pixels of a slice, which are asked for side by side. */
#define SLICE_MOST_PX 4e6

/* What shines through where a picture has no background. */
static const uint8_t paper[3] = {200, 200, 200};

/* How a picture is sent: one of many that follow each other; one after which the same follows in
 * better light; one that stays. */
typedef enum picture_kind { MOVES, MORE, STAYS } picture_kind;

/* Answer with a picture, if it could be drawn. @param scene what it shows; NULL: what is looked at.
 */
static void answer_picture(sc_desk *desk, sc_call *call, sc_status drawn, const sc_image *image,
                           const sc_scene *scene, picture_kind kind)
{
    char *data = NULL, *text;
    size_t bytes = 0;
    json_t *view;

    if (drawn == SC_OK)
        drawn = kind == MOVES
                    ? sc_image_compress_jpeg(&desk->ctx, image, JPEG_QUALITY, &data, &bytes)
                    : sc_image_compress_png(&desk->ctx, image, "the picture", &data, &bytes);
    if (drawn != SC_OK) {
        sc_desk_refuse(desk, call, "the picture could not be drawn");
        return;
    }
    view = scene ? sc_desk_view_of(desk, scene, false) : sc_desk_view(desk, kind == MORE);
    text = view ? json_dumps(view, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(view);
    sc_http_answer(call, 200, kind == MOVES ? "image/jpeg" : "image/png", data, bytes, text);
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
    const double scale = desk->sessions.now->compare ? 1 : choose_scale(&desk->shown);
    const int *size_px = desk->shown.size_px;
    const int width = (int)fmax(16, floor(scale * size_px[0] + 0.5));
    const int height = (int)fmax(16, floor(scale * size_px[1] + 0.5));
    sc_status status;
    double begin_s;

    SC_PASS(sc_image_init_alpha(&desk->ctx, width, height,
                                desk->sessions.now->job.render.background.is_none, image));
    begin_s = sc_wall_s();
    status = sc_desk_draw(desk, desk->frame, true, image);
    begin_s = (sc_wall_s() - begin_s) / ((double)width * height);
    desk->shown.s_per_px =
        desk->shown.s_per_px > 0 ? 0.6 * desk->shown.s_per_px + 0.4 * begin_s : begin_s;
    sc_image_flatten(image, paper);
    return status;
}

void sc_desk_sketch(sc_desk *desk, sc_call *call)
{
    SC_OWN(sc_image_clear) sc_image image = {0};

    answer_picture(desk, call, draw_sketch(desk, &image), &image, NULL, MOVES);
}

/* @return whether volumes are being replaced: light gathered for the present ones would be wasted.
 */
static bool is_outdated(const sc_desk *desk)
{
    return !desk->volumes.fit && !desk->volumes.failed;
}

/* @return whether a picture is drawn in plain light: at first, and as long as that is so. */
static bool is_plain(const sc_desk *desk, const sc_call *call)
{
    const json_t *plain = json_object_get(call->body, "plain");
    const bool is_seen = json_is_integer(plain) && json_integer_value(plain) == desk->revision;

    return !desk->sessions.is_lit && !strcmp(call->verb, "picture") &&
           !desk->sessions.now->compare && (!is_seen || is_outdated(desk));
}

bool sc_desk_refine(sc_desk *desk, sc_call *call)
{
    SC_OWN(sc_image_clear) sc_image image = {0};
    const bool plain = is_plain(desk, call);
    sc_status status = sc_session_image(&desk->app, desk->sessions.now, &image);
    bool gives_up;

    desk->may_interrupt = 1;
    gives_up = sc_http_waits(desk->http);
    if (!plain && !desk->sessions.is_lit && !desk->volumes.preparing)
        sc_stage_begin(desk->outer, "gathering light", 0, 0);
    if (!gives_up && status == SC_OK)
        status = sc_desk_draw(desk, sc_desk_frame(desk, call->body), plain, &image);
    desk->may_interrupt = 0;
    gives_up = gives_up || *desk->interrupt;
    *desk->interrupt = 0;
    if (!desk->volumes.preparing)
        sc_stage_end(desk->outer);
    if (gives_up)
        return false;
    desk->sessions.is_lit = desk->sessions.is_lit || (!plain && status == SC_OK);
    answer_picture(desk, call, status, &image, NULL, plain && !is_outdated(desk) ? MORE : STAYS);
    return true;
}

void sc_desk_slice(sc_desk *desk, sc_call *call)
{
    const json_int_t which = json_integer_value(json_object_get(call->body, "which"));
    SC_OWN(sc_image_clear) sc_image image = {0};
    int size_px[2], frame;
    sc_panel *panel = sc_session_panel(desk->sessions.now, desk->frame, &frame);
    sc_render_stats stats;
    sc_scene scene, slice;
    sc_views views;
    sc_vec3 at;
    sc_status status;

    if (!sc_desk_size(call->body, size_px) || which < 0 || which > 2 || !panel->phases ||
        (double)size_px[0] * size_px[1] > SLICE_MOST_PX) {
        sc_desk_refuse(desk, call, "there is no such slice");
        return;
    }
    scene = sc_panel_scene(panel, frame);
    if (!json_unpack(call->body, "{s:[F,F,F]}", "point", &at.x, &at.y, &at.z))
        scene.point_mm = at;
    views = (sc_views){.low_mm = panel->timeline.low_mm,
                       .high_mm = panel->timeline.high_mm,
                       .oriented = panel->volume.oriented};
    slice = sc_views_slice(&views, (int)which, size_px, &scene);
    status = sc_image_init(&desk->ctx, size_px[0], size_px[1], &image);
    if (status == SC_OK)
        sc_render_view(panel->renderers[0], &slice, NULL, NULL, NULL, &image, &stats);
    answer_picture(desk, call, status, &image, &slice, STAYS);
}

void sc_desk_pick(sc_desk *desk, sc_call *call)
{
    int size_px[2], frame;
    sc_panel *panel = sc_session_panel(desk->sessions.now, desk->frame, &frame);
    double x, y;
    sc_pick pick;
    sc_scene scene;

    if (!sc_desk_size(call->body, size_px) || !panel->phases ||
        json_unpack(call->body, "{s:F, s:F}", "x", &x, "y", &y)) {
        sc_desk_refuse(desk, call, "there is nothing to point at");
        return;
    }
    scene = sc_panel_scene(panel, frame);
    pick = sc_render_pick(panel->renderers[0], &scene, size_px, x, y);
    sc_http_answer_json(call, 200,
                        json_pack("{s:i, s:[f,f,f]}", "id", pick.id, "at", pick.at_mm.x,
                                  pick.at_mm.y, pick.at_mm.z));
}
