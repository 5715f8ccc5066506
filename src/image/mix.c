/* SPDX-License-Identifier: BSD-3-Clause */
/* Pictures mixed with others, and with a colour, in linear light. */
#include "segcast/image.h"

void sc_mixer_init(sc_mixer *mixer)
{
    sc_srgb_table_init(&mixer->levels);
    for (int i = 0; i < 256; i++)
        mixer->linear[i] = (float)sc_srgb_to_linear(i / 255.0);
}

/* Mix @p share of a pixel with alpha with the rest of another. Colours count as much as they
 * cover. */
static void mix_clear(const sc_mixer *mixer, const uint8_t *other, float share, uint8_t *to)
{
    const float mine = share * (float)to[3], rest = (1 - share) * (float)other[3];
    const float alpha = mine + rest;
    const int level = (int)(alpha + 0.5F);

    for (int c = 0; c < 3; c++)
        to[c] = level == 0
                    ? 0
                    : sc_srgb_level(&mixer->levels,
                                    (mine * mixer->linear[to[c]] + rest * mixer->linear[other[c]]) /
                                        alpha);
    to[3] = (uint8_t)level;
}

/* Mix the pixels [count] at @p to with those at @p other, which is a single one if @p step is 0. */
static void mix_pixels(const sc_mixer *mixer, bool alpha, const uint8_t *other, size_t step,
                       float share, size_t count, uint8_t *to)
{
    const size_t bytes = sc_pixel_bytes(alpha);

    for (size_t i = 0; i < count; i++, to += bytes, other += step) {
        if (alpha) {
            mix_clear(mixer, other, share, to);
            continue;
        }
        for (int c = 0; c < 3; c++)
            to[c] = sc_srgb_level(&mixer->levels, share * mixer->linear[to[c]] +
                                                      (1 - share) * mixer->linear[other[c]]);
    }
}

void sc_image_mix(const sc_mixer *mixer, const sc_image *other, float share, int first, int end,
                  sc_image *image)
{
    const size_t width = (size_t)image->width_px, bytes = sc_pixel_bytes(image->alpha);
    const size_t at = (size_t)first * width * bytes;

    mix_pixels(mixer, image->alpha, other->rgb + at, bytes, share,
               first < end ? (size_t)(end - first) * width : 0, image->rgb + at);
}

void sc_image_fade(const sc_mixer *mixer, const uint8_t rgb[3], float share, int first, int end,
                   sc_image *image)
{
    const size_t width = (size_t)image->width_px, bytes = sc_pixel_bytes(image->alpha);
    const uint8_t background[4] = {rgb[0], rgb[1], rgb[2], 0};

    mix_pixels(mixer, image->alpha, background, 0, share,
               first < end ? (size_t)(end - first) * width : 0,
               image->rgb + (size_t)first * width * bytes);
}

void sc_image_add(const sc_mixer *mixer, const sc_image *image, int first, int end, float *sums)
{
    const size_t bytes = sc_pixel_bytes(image->alpha);
    const size_t begin = (size_t)first * (size_t)image->width_px;
    const uint8_t *from = image->rgb + begin * bytes;
    float *to = sums + begin * bytes;

    for (size_t i = (size_t)(end - first) * (size_t)image->width_px; i; i--) {
        const float share = image->alpha ? (float)from[3] : 1;

        for (int c = 0; c < 3; c++)
            to[c] += share * mixer->linear[from[c]];
        if (image->alpha)
            to[3] += share;
        from += bytes;
        to += bytes;
    }
}

void sc_image_mean(const sc_mixer *mixer, const float *sums, int count, int first, int end,
                   sc_image *image)
{
    const size_t bytes = sc_pixel_bytes(image->alpha);
    const size_t begin = (size_t)first * (size_t)image->width_px;
    const float *from = sums + begin * bytes;
    uint8_t *to = image->rgb + begin * bytes;

    for (size_t i = (size_t)(end - first) * (size_t)image->width_px; i; i--) {
        const int alpha = image->alpha ? (int)(from[3] / (float)count + 0.5F) : 255;
        const float whole = image->alpha ? from[3] : (float)count;

        for (int c = 0; c < 3; c++)
            to[c] = alpha ? sc_srgb_level(&mixer->levels, from[c] / whole) : 0;
        if (image->alpha)
            to[3] = (uint8_t)alpha;
        from += bytes;
        to += bytes;
    }
}
