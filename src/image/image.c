/* SPDX-License-Identifier: BSD-3-Clause */
/* Buffers of pixels, their hash and comparison, and the conversion between sRGB and linear light.
 */
#include "segcast/image.h"

#include <math.h>

sc_status sc_image_init_alpha(const sc_ctx *ctx, int width_px, int height_px, bool alpha,
                              sc_image *out)
{
    sc_image image = {.width_px = width_px, .height_px = height_px, .alpha = alpha};

    SC_PASS(sc_alloc(ctx, (size_t)width_px * sc_pixel_bytes(alpha), (size_t)height_px, &image.rgb));
    *out = image;
    return SC_OK;
}

sc_status sc_image_init(const sc_ctx *ctx, int width_px, int height_px, sc_image *out)
{
    return sc_image_init_alpha(ctx, width_px, height_px, false, out);
}

void sc_image_clear(sc_image *image)
{
    sc_free(image->rgb);
    *image = (sc_image){0};
}

size_t sc_image_bytes(const sc_image *image)
{
    return (size_t)image->width_px * (size_t)image->height_px * sc_pixel_bytes(image->alpha);
}

void sc_image_flatten(sc_image *image, const uint8_t rgb[3])
{
    const size_t pixels = (size_t)image->width_px * (size_t)image->height_px;
    const uint8_t *from = image->rgb;
    uint8_t *to = image->rgb;

    for (size_t i = 0; i < pixels && image->alpha; i++, from += 4, to += 3) {
        const int alpha = from[3];

        for (int c = 0; c < 3; c++)
            to[c] = (uint8_t)((from[c] * alpha + rgb[c] * (255 - alpha) + 127) / 255);
    }
    image->alpha = false;
}

uint64_t sc_image_hash(const sc_image *image)
{
    const uint64_t seed = ((uint64_t)(uint32_t)image->width_px << 32) | (uint32_t)image->height_px;

    return sc_hash_bytes(image->rgb, sc_image_bytes(image), seed);
}

double sc_srgb_to_linear(double srgb)
{
    return srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4);
}

void sc_srgb_table_init(sc_srgb_table *table)
{
    int level = 0;

    for (int i = 0; i < 255; i++)
        table->threshold[i] = (float)sc_srgb_to_linear((i + 0.5) / 255);
    table->threshold[255] = 2;
    for (int i = 0; i <= 4096; i++) {
        while (level < 255 && table->threshold[level] <= (float)i / 4096)
            level++;
        table->start[i] = (uint8_t)level;
    }
}
