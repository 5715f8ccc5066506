/* SPDX-License-Identifier: BSD-3-Clause */
/* The overlays of one frame, each in its turn. */
#include "internal.h"

bool sc_annotations_any(const sc_annotations *annotations)
{
    const sc_overlays *o = annotations->overlays;

    return o->logo[0] || annotations->card || annotations->lists.caption_count || o->time ||
           o->scale_bar || o->color_bar || o->orientation || o->legend ||
           sc_annotations_names(annotations);
}

/* Draw the time at which a frame is shown. */
static void draw_time(sc_drawing *d, const sc_scene *scene)
{
    const sc_lettering *lettering = d->a->lettering;
    char text[SC_TIME_CODE_BYTES];
    sc_viewport room;

    if (!d->a->overlays->time)
        return;
    sc_time_code(d->a->first_frame + scene->frame, d->a->fps, text);
    room = sc_take_room(d, d->a->overlays->time, sc_glyphs_width(lettering, text),
                        sc_glyphs_capitals(lettering));
    sc_draw_glyphs(d, text, room.x_px, room.y_px + room.height_px);
}

sc_status sc_draw_fixed(const sc_ctx *ctx, sc_drawing *d, const sc_scene *scene)
{
    sc_status status;

    sc_draw_logo(d);
    draw_time(d, scene);
    sc_draw_scale_bar(d, scene);
    sc_draw_color_bar(d);
    status = sc_draw_orientation(ctx, d, scene);
    sc_draw_legend(d, scene);
    return status;
}

sc_status sc_annotations_draw(const sc_ctx *ctx, const sc_annotations *annotations,
                              const sc_scene *scene, sc_image *image, const sc_rows *rows)
{
    sc_drawing d;
    sc_status status;

    if (!annotations->lettering)
        return SC_OK;
    d = sc_drawing_begin(annotations, scene, image, rows);
    status = sc_draw_fixed(ctx, &d, scene);
    if (status == SC_OK)
        status = sc_draw_names(ctx, &d, scene);
    sc_draw_card(&d);
    sc_draw_captions(&d, scene->time);
    return status;
}
