/* SPDX-License-Identifier: BSD-3-Clause */
/* The orientation cube: how the patient lies to the camera, with the letter of each side on the
 * face that looks there. It is drawn with parallel rays, also in perspective. */
#include "internal.h"

#include <math.h>

#define SIDE 2.6   /* of the cube, in font sizes */
#define TURNED 0.1 /* cosine at which the letter of a face begins to be seen, and ... */
#define FULL 0.3   /* ... at which it is seen fully */

/* The faces, whose letters are those of patient coordinates, RAS+. */
static const struct face {
    char letter;
    sc_vec3 normal, across, along;
} faces[] = {{'R', {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {'L', {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
             {'A', {0, 1, 0}, {1, 0, 0}, {0, 0, 1}}, {'P', {0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
             {'S', {0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {'I', {0, 0, -1}, {1, 0, 0}, {0, 1, 0}}};

/* Find where a point of the cube, whose half side is 1, lies in the picture. */
static void project(const sc_camera *camera, const double middle[2], double half_px, sc_vec3 point,
                    double out[2])
{
    out[0] = middle[0] + half_px * sc_vec3_dot(point, camera->right);
    out[1] = middle[1] - half_px * sc_vec3_dot(point, camera->up);
}

/* Draw the faces that look towards the camera; none of them covers another. */
static void draw_faces(sc_overlay *overlay, const sc_drawing *d, const sc_camera *camera,
                       const double middle[2], double half_px)
{
    for (size_t i = 0; i < SC_COUNT_OF(faces); i++) {
        const double facing = -sc_vec3_dot(faces[i].normal, camera->forward);
        const uint8_t level = (uint8_t)(150 + 90 * fmax(0, facing));
        const uint8_t rgb[3] = {level, level, level};
        double corners[4][2];

        if (facing <= 1e-6)
            continue;
        for (int c = 0; c < 4; c++) {
            const sc_vec3 at =
                sc_vec3_along(faces[i].normal, c == 1 || c == 2 ? 1 : -1, faces[i].across);

            project(camera, middle, half_px, sc_vec3_along(at, c > 1 ? 1 : -1, faces[i].along),
                    corners[c]);
        }
        sc_overlay_polygon(overlay, corners, 4, rgb, 0.9, fmax(1, half_px / 14), d->letters.rgb);
    }
}

/* Draw the letters of the faces, each in the middle of its face and upright. */
static void draw_letters(const sc_drawing *d, const sc_camera *camera, const double middle[2],
                         double half_px)
{
    const sc_letters letters = {.rgb = {24, 24, 24}, .halo = {255, 255, 255}};

    for (size_t i = 0; i < SC_COUNT_OF(faces); i++) {
        const sc_word *word =
            sc_lettering_find(d->a->lettering, SC_WORD_ORIENTATION, faces[i].letter);
        const double facing = -sc_vec3_dot(faces[i].normal, camera->forward);
        const double seen = fmin(1, (facing - TURNED) / (FULL - TURNED));
        double at[2];

        if (!word || seen <= 0)
            continue;
        project(camera, middle, half_px, faces[i].normal, at);
        sc_lettering_draw(d->a->lettering, word, (int)floor(at[0] - word->advance_px / 2.0 + 0.5),
                          (int)floor(at[1] + word->capitals_px / 2.0 + 0.5), &letters,
                          (int)(255 * seen + 0.5), d->image, d->rows);
    }
}

sc_status sc_add_orientation(const sc_ctx *ctx, const sc_annotations *a, sc_line_list *list)
{
    static const char text[] = "RLAPSI";

    if (!a->volume->oriented)
        sc_warn(ctx,
                "overlays.orientation is not drawn: the volume does not say which side is left");
    for (size_t i = 0; a->volume->oriented && text[i]; i++)
        SC_PASS(sc_add_line(ctx, list,
                            &(sc_text_line){.kind = SC_WORD_ORIENTATION,
                                            .number = text[i],
                                            .text = &text[i],
                                            .bytes = 1,
                                            .size_px = sc_text_px(a)}));
    return SC_OK;
}

sc_status sc_draw_orientation(const sc_ctx *ctx, sc_drawing *d, const sc_scene *scene)
{
    const double half_px = SIDE / 2 * sc_text_px(d->a);
    const int size = (int)ceil(2 * sqrt(3) * half_px) + 2; /* whichever way the cube is turned */
    sc_overlay *overlay;
    sc_viewport room;
    double middle[2];
    sc_status status;

    if (!d->a->overlays->orientation || !d->a->volume->oriented)
        return SC_OK;
    room = sc_take_room(d, d->a->overlays->orientation, size, size);
    middle[0] = room.x_px + size / 2.0;
    middle[1] = room.y_px + size / 2.0;
    SC_PASS(sc_overlay_begin_within(ctx, d->image, &room, d->rows, &overlay));
    draw_faces(overlay, d, &scene->camera, middle, half_px);
    status = sc_overlay_finish(ctx, overlay);
    if (status == SC_OK)
        draw_letters(d, &scene->camera, middle, half_px);
    return status;
}
