/* SPDX-License-Identifier: BSD-3-Clause */
/* Everything is drawn on a transparent surface of cairo, which sc_overlay_finish blends into the
 * picture. */
#include "segcast/overlay.h"

#include <cairo.h>

/* Height of capital letters as a share of the font's ascent, for DejaVu Sans about. */
#define CAPITAL_HEIGHT 0.76

struct sc_overlay {
    sc_image *image;          /* borrowed */
    cairo_surface_t *surface; /* as large as image, transparent at first */
    cairo_t *cairo;
};

sc_status sc_overlay_begin(const sc_ctx *ctx, sc_image *image, sc_overlay **out)
{
    sc_overlay *overlay;
    void *block;
    sc_status status = sc_zalloc(ctx, 1, sizeof *overlay, &block);

    if (status != SC_OK)
        return status;
    overlay = block;
    overlay->image = image;
    overlay->surface =
        cairo_image_surface_create(CAIRO_FORMAT_ARGB32, image->width_px, image->height_px);
    overlay->cairo = cairo_create(overlay->surface);
    if (cairo_status(overlay->cairo) != CAIRO_STATUS_SUCCESS) {
        status =
            sc_fail(ctx, SC_ERR_MEMORY, "drawing over a picture of %d x %d: %s", image->width_px,
                    image->height_px, cairo_status_to_string(cairo_status(overlay->cairo)));
        cairo_destroy(overlay->cairo);
        cairo_surface_destroy(overlay->surface);
        sc_free(overlay);
        return status;
    }
    cairo_select_font_face(overlay->cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_BOLD);
    *out = overlay;
    return SC_OK;
}

/* Choose the colour of what is drawn next. @param alpha opacity in [0, 1]. */
static void set_color(sc_overlay *overlay, const uint8_t rgb[3], double alpha)
{
    cairo_set_source_rgba(overlay->cairo, rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0, alpha);
}

void sc_overlay_line(sc_overlay *overlay, double x0, double y0, double x1, double y1,
                     double width_px, const uint8_t rgb[3], double alpha)
{
    set_color(overlay, rgb, alpha);
    cairo_set_line_width(overlay->cairo, width_px);
    cairo_move_to(overlay->cairo, x0, y0);
    cairo_line_to(overlay->cairo, x1, y1);
    cairo_stroke(overlay->cairo);
}

void sc_overlay_frame(sc_overlay *overlay, double x, double y, double width, double height,
                      double width_px, const uint8_t rgb[3])
{
    set_color(overlay, rgb, 1);
    cairo_set_line_width(overlay->cairo, width_px);
    cairo_rectangle(overlay->cairo, x, y, width, height);
    cairo_stroke(overlay->cairo);
}

void sc_overlay_text(sc_overlay *overlay, double x, double y, int anchor_x, int anchor_y,
                     const sc_letters *letters, const char *text)
{
    cairo_text_extents_t extents;
    cairo_font_extents_t font;

    cairo_set_font_size(overlay->cairo, letters->size_px);
    cairo_text_extents(overlay->cairo, text, &extents);
    cairo_font_extents(overlay->cairo, &font);
    x -= extents.x_bearing + extents.width * (anchor_x + 1) / 2;
    y += font.ascent * CAPITAL_HEIGHT * (1 - anchor_y) / 2;
    cairo_move_to(overlay->cairo, x, y);
    cairo_text_path(overlay->cairo, text);
    cairo_set_line_join(overlay->cairo, CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_width(overlay->cairo, letters->size_px * 0.2);
    set_color(overlay, letters->halo, 0.85);
    cairo_stroke_preserve(overlay->cairo);
    set_color(overlay, letters->rgb, 1);
    cairo_fill(overlay->cairo);
}

/* Blend a pixel of cairo, which is premultiplied, over one with alpha, which is not. */
static void blend_over_alpha(uint32_t from, uint8_t to[4])
{
    const uint32_t over = from >> 24, left = 255 - over;
    const uint32_t alpha = 255 * over + to[3] * left; /* of both, times 255 */

    if (!from)
        return;
    for (int c = 0; c < 3; c++)
        to[c] = (uint8_t)(((from >> (16 - 8 * c) & 255) * 255 * 255 + to[c] * to[3] * left +
                           alpha / 2) /
                          alpha);
    to[3] = (uint8_t)((alpha + 127) / 255);
}

void sc_overlay_finish(sc_overlay *overlay)
{
    const sc_image *image = overlay->image;
    const size_t bytes = sc_pixel_bytes(image->alpha);
    const uint8_t *data;
    int stride;

    cairo_surface_flush(overlay->surface);
    data = cairo_image_surface_get_data(overlay->surface);
    stride = cairo_image_surface_get_stride(overlay->surface);
    for (int y = 0; data && y < image->height_px; y++) {
        const uint32_t *from = (const uint32_t *)(const void *)(data + (size_t)y * (size_t)stride);
        uint8_t *to = image->rgb + (size_t)y * (size_t)image->width_px * bytes;

        for (int x = 0; x < image->width_px && image->alpha; x++)
            blend_over_alpha(from[x], to + (size_t)x * bytes);
        for (int x = 0; x < image->width_px && !image->alpha; x++, to += bytes) {
            const uint32_t left = 255 - (from[x] >> 24); /* the pixels of cairo are premultiplied */

            for (int c = 0; c < 3 && from[x]; c++)
                to[c] = (uint8_t)((from[x] >> (16 - 8 * c) & 255) + (to[c] * left + 127) / 255);
        }
    }
    cairo_destroy(overlay->cairo);
    cairo_surface_destroy(overlay->surface);
    sc_free(overlay);
}
