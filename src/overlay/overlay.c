/* SPDX-License-Identifier: BSD-3-Clause */
/* Everything is drawn on a transparent surface of cairo, which sc_overlay_finish blends into the
 * picture. */
#include "segcast/overlay.h"

#include "blend.h"

#include <cairo.h>

/* Height of capital letters as a share of the font's ascent, for DejaVu Sans about. */
#define CAPITAL_HEIGHT 0.76

struct sc_overlay {
    sc_image *image;          /* borrowed */
    sc_viewport within;       /* the part of the picture that the surface covers */
    sc_rows rows;             /* of the picture, that may be written to */
    cairo_surface_t *surface; /* as large as that part, transparent at first */
    cairo_t *cairo;
};

sc_status sc_overlay_begin(const sc_ctx *ctx, sc_image *image, sc_overlay **out)
{
    const sc_viewport all = {0, 0, image->width_px, image->height_px};

    return sc_overlay_begin_within(ctx, image, &all, NULL, out);
}

sc_status sc_overlay_begin_within(const sc_ctx *ctx, sc_image *image, const sc_viewport *within,
                                  const sc_rows *rows, sc_overlay **out)
{
    sc_overlay *overlay;
    sc_status status = SC_OK;

    SC_PASS(SC_ZALLOC(ctx, 1, &overlay));
    overlay->image = image;
    overlay->within = *within;
    overlay->rows = rows ? *rows : (sc_rows){0, image->height_px};
    overlay->surface =
        cairo_image_surface_create(CAIRO_FORMAT_ARGB32, within->width_px, within->height_px);
    overlay->cairo = cairo_create(overlay->surface);
    cairo_translate(overlay->cairo, -within->x_px, -within->y_px);
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

void sc_overlay_leader(sc_overlay *overlay, const double (*points)[2], int count, double width_px,
                       double radius_px, const uint8_t rgb[3], double alpha)
{
    cairo_t *cairo = overlay->cairo;

    cairo_push_group(cairo);
    set_color(overlay, rgb, 1);
    cairo_set_line_width(cairo, width_px);
    cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);
    for (int i = 0; i < count; i++)
        cairo_line_to(cairo, points[i][0], points[i][1]);
    cairo_stroke(cairo);
    cairo_arc(cairo, points[0][0], points[0][1], radius_px, 0, 2 * M_PI);
    cairo_fill(cairo);
    cairo_pop_group_to_source(cairo);
    cairo_paint_with_alpha(cairo, alpha);
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

void sc_text_colors(double dark, uint8_t rgb[3], uint8_t halo[3])
{
    memset(rgb, (int)(235 + dark * (24 - 235) + 0.5), 3);
    memset(halo, (int)(dark * 255 + 0.5), 3);
}

void sc_overlay_polygon(sc_overlay *overlay, const double (*corners)[2], int count,
                        const uint8_t rgb[3], double alpha, double outline_px,
                        const uint8_t outline[3])
{
    for (int i = 0; i < count; i++)
        cairo_line_to(overlay->cairo, corners[i][0], corners[i][1]);
    cairo_close_path(overlay->cairo);
    set_color(overlay, rgb, alpha);
    cairo_fill_preserve(overlay->cairo);
    cairo_set_line_join(overlay->cairo, CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_width(overlay->cairo, outline_px);
    set_color(overlay, outline, 1);
    cairo_stroke(overlay->cairo);
}

void sc_overlay_fill(sc_image *image, const sc_viewport *rectangle, const uint8_t rgb[3], int alpha,
                     const sc_rows *rows)
{
    const sc_viewport part = sc_blend_part(image, rectangle, rows);

    for (int y = 0; y < part.height_px; y++) {
        uint8_t *to = sc_blend_pixel(image, part.x_px, part.y_px + y);

        for (int x = 0; x < part.width_px; x++, to += sc_pixel_bytes(image->alpha))
            sc_blend(rgb, (unsigned)alpha, image->alpha, to);
    }
}

void sc_overlay_image(sc_image *image, const sc_image *from, int x, int y, const sc_rows *rows)
{
    const sc_viewport all = {x, y, from->width_px, from->height_px};
    const sc_viewport part = sc_blend_part(image, &all, rows);

    for (int row = 0; row < part.height_px; row++) {
        const uint8_t *pixel = sc_blend_pixel(from, part.x_px - x, part.y_px + row - y);
        uint8_t *to = sc_blend_pixel(image, part.x_px, part.y_px + row);

        for (int i = 0; i < part.width_px; i++, pixel += 4, to += sc_pixel_bytes(image->alpha))
            sc_blend(pixel, pixel[3], image->alpha, to);
    }
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

/* Blend a pixel of cairo over an opaque one. */
static void blend_over_opaque(uint32_t from, uint8_t to[3])
{
    const uint32_t left = 255 - (from >> 24);

    for (int c = 0; c < 3 && from; c++)
        to[c] = (uint8_t)((from >> (16 - 8 * c) & 255) + (to[c] * left + 127) / 255);
}

sc_status sc_overlay_finish(const sc_ctx *ctx, sc_overlay *overlay)
{
    sc_image *image = overlay->image;
    const sc_viewport *within = &overlay->within;
    const sc_viewport part = sc_blend_part(image, within, &overlay->rows);
    const uint8_t *data;
    int stride;
    sc_status status = SC_OK;

    cairo_surface_flush(overlay->surface);
    /* cairo remembers that something could not be drawn, for want of memory. */
    if (cairo_status(overlay->cairo) != CAIRO_STATUS_SUCCESS ||
        cairo_surface_status(overlay->surface) != CAIRO_STATUS_SUCCESS)
        status =
            sc_fail(ctx, SC_ERR_MEMORY, "drawing over a picture of %d x %d: %s", image->width_px,
                    image->height_px, cairo_status_to_string(cairo_status(overlay->cairo)));
    data = cairo_image_surface_get_data(overlay->surface);
    stride = cairo_image_surface_get_stride(overlay->surface);
    for (int y = 0; status == SC_OK && data && y < part.height_px; y++) {
        const size_t row = (size_t)(part.y_px + y - within->y_px);
        const uint32_t *from = (const uint32_t *)(const void *)(data + row * (size_t)stride) +
                               (part.x_px - within->x_px);
        uint8_t *to = sc_blend_pixel(image, part.x_px, part.y_px + y);

        for (int x = 0; x < part.width_px; x++, to += sc_pixel_bytes(image->alpha)) {
            if (image->alpha)
                blend_over_alpha(from[x], to);
            else
                blend_over_opaque(from[x], to);
        }
    }
    cairo_destroy(overlay->cairo);
    cairo_surface_destroy(overlay->surface);
    sc_free(overlay);
    return status;
}
