/* SPDX-License-Identifier: BSD-3-Clause */
/* The logo: a picture in a corner. One process reads and scales it, so that all draw the same
 * pixels. */
#include "internal.h"

#include <math.h>

#define WIDEST 0.4 /* share of the width of the picture that a logo may take */

/* Find the mean of the part of a picture from (left, top) to (right, bottom), in pixels and parts
 * of them. What is transparent does not count for the colour. */
static void mean_of(const sc_image *image, const double from[2], const double to[2], uint8_t out[4])
{
    double sum[4] = {0}, area = 0;

    for (int y = (int)from[1]; y < image->height_px && y < to[1]; y++) {
        const double high = fmin(y + 1, to[1]) - fmax(y, from[1]);

        for (int x = (int)from[0]; x < image->width_px && x < to[0]; x++) {
            const double part = high * (fmin(x + 1, to[0]) - fmax(x, from[0]));
            const uint8_t *pixel =
                image->rgb + 4 * ((size_t)y * (size_t)image->width_px + (size_t)x);

            for (int c = 0; c < 3; c++)
                sum[c] += part * pixel[3] * pixel[c];
            sum[3] += part * pixel[3];
            area += part;
        }
    }
    for (int c = 0; c < 3; c++)
        out[c] = (uint8_t)(sum[3] > 0 ? sum[c] / sum[3] + 0.5 : 0);
    out[3] = (uint8_t)(area > 0 ? sum[3] / area + 0.5 : 0);
}

/* Give an opaque picture alpha, in place. */
static sc_status add_alpha(const sc_ctx *ctx, sc_image *image)
{
    const size_t pixels = (size_t)image->width_px * (size_t)image->height_px;
    sc_image out;

    if (image->alpha)
        return SC_OK;
    SC_PASS(sc_image_init_alpha(ctx, image->width_px, image->height_px, true, &out));
    for (size_t i = 0; i < pixels; i++) {
        for (int c = 0; c < 3; c++)
            out.rgb[4 * i + (size_t)c] = image->rgb[3 * i + (size_t)c];
        out.rgb[4 * i + 3] = 255;
    }
    sc_image_clear(image);
    *image = out;
    return SC_OK;
}

sc_status sc_annotations_logo(const sc_ctx *ctx, const sc_annotations *annotations, sc_image *out)
{
    const sc_overlays *o = annotations->overlays;
    SC_OWN(sc_image_clear) sc_image whole = {0}, small = {0};
    double scale;

    SC_PASS(sc_image_load_png(ctx, o->logo, &whole));
    SC_PASS(add_alpha(ctx, &whole));
    scale = fmin(o->logo_percent / 100 * annotations->within.height_px / whole.height_px,
                 WIDEST * annotations->within.width_px / whole.width_px);
    scale = fmin(scale, 1); /* a small one is not blown up */
    SC_PASS(sc_image_init_alpha(ctx, (int)fmax(1, floor(scale * whole.width_px + 0.5)),
                                (int)fmax(1, floor(scale * whole.height_px + 0.5)), true, &small));
    for (int y = 0; y < small.height_px; y++) {
        for (int x = 0; x < small.width_px; x++) {
            const double step[2] = {(double)whole.width_px / small.width_px,
                                    (double)whole.height_px / small.height_px};

            mean_of(&whole, (double[2]){x * step[0], y * step[1]},
                    (double[2]){(x + 1) * step[0], (y + 1) * step[1]},
                    small.rgb + 4 * ((size_t)y * (size_t)small.width_px + (size_t)x));
        }
    }
    *out = small;
    small = (sc_image){0};
    return SC_OK;
}

void sc_draw_logo(sc_drawing *d)
{
    const sc_image *logo = &d->a->logo;
    sc_viewport room;

    if (!logo->rgb)
        return;
    room = sc_take_room(d, d->a->overlays->logo_place, logo->width_px, logo->height_px);
    sc_overlay_image(d->image, logo, room.x_px, room.y_px, d->rows);
}
