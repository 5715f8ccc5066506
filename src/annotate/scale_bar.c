/* SPDX-License-Identifier: BSD-3-Clause */
/* The scale bar: a round length, at the depth of the middle of what is visible. With parallel rays
 * it holds for the whole picture. */
#include "internal.h"

#include <math.h>

#define LONGEST 0.2  /* share of the width of the picture */
#define IN_PANEL 0.5 /* ... of that of one of several pictures */

/* @return where the picture in space lies. */
static const sc_viewport *space_of(const sc_annotations *a)
{
    return a->space.width_px ? &a->space : &a->within;
}

/* @return how many millimetres a pixel is wide at the depth of the middle of what is visible; 0 if
 * that lies behind the camera. */
static double mm_per_px(const sc_annotations *a, const sc_camera *camera)
{
    const sc_timeline *t = a->timeline;
    const sc_vec3 middle = sc_vec3_scale(sc_vec3_add(t->low_mm, t->high_mm), 0.5);
    const double depth = sc_vec3_dot(sc_vec3_sub(middle, camera->position_mm), camera->forward);
    const double half =
        camera->projection == SC_PERSPECTIVE ? camera->half_height * depth : camera->half_height;

    return half > 0 ? 2 * half / space_of(a)->height_px : 0;
}

/* @return how long the bar may be. */
static double longest_px(const sc_annotations *a)
{
    return fmin(LONGEST * a->within.width_px, IN_PANEL * space_of(a)->width_px);
}

void sc_draw_scale_bar(sc_drawing *d, const sc_scene *scene)
{
    const sc_annotations *a = d->a;
    const double scale = mm_per_px(a, &scene->camera);
    const double length_mm = sc_round_length_mm(longest_px(a) * scale);
    const int capitals = sc_glyphs_capitals(a->lettering);
    const int thick = capitals / 4 > 2 ? capitals / 4 : 2, halo = thick / 3 > 1 ? thick / 3 : 1;
    const int gap = capitals / 2;
    sc_length_unit unit;
    sc_viewport room, bar;
    char text[32];
    int length_px, text_px;

    /* Inside of a vessel no depth stands for the picture, nor where all directions are seen. */
    if (!a->overlays->scale_bar || scene->inside ||
        scene->camera.projection == SC_EQUIRECTANGULAR || !(scale > 0) || !(length_mm > 0))
        return;
    unit = sc_length_unit_for(length_mm);
    snprintf(text, sizeof text, "%.6g %s", length_mm / unit.mm, unit.name);
    length_px = (int)(length_mm / scale + 0.5);
    text_px = sc_glyphs_width(a->lettering, text);
    room = sc_take_room(d, a->overlays->scale_bar, length_px > text_px ? length_px : text_px,
                        capitals + gap + thick);
    bar = (sc_viewport){room.x_px + (room.width_px - length_px) / 2, room.y_px + capitals + gap,
                        length_px, thick};
    sc_overlay_fill(
        d->image,
        &(sc_viewport){bar.x_px - halo, bar.y_px - halo, length_px + 2 * halo, thick + 2 * halo},
        d->letters.halo, 217, d->rows);
    sc_overlay_fill(d->image, &bar, d->letters.rgb, 255, d->rows);
    sc_draw_glyphs(d, text, room.x_px + (room.width_px - text_px) / 2, room.y_px + capitals);
}
