/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to overlay: colours blended over the pixels of a picture, in whole numbers. */
#ifndef SC_OVERLAY_BLEND_H
#define SC_OVERLAY_BLEND_H

#include "segcast/render.h"

/* @return the part of @p rectangle that lies in the picture and in @p rows, NULL: all rows; its
 * width or height is 0 or less if there is none. */
static inline sc_viewport sc_blend_part(const sc_image *image, const sc_viewport *rectangle,
                                        const sc_rows *rows)
{
    const int first = rows && rows->first > 0 ? rows->first : 0;
    const int last = rows && rows->end < image->height_px ? rows->end : image->height_px;
    const int left = rectangle->x_px > 0 ? rectangle->x_px : 0;
    const int top = rectangle->y_px > first ? rectangle->y_px : first;
    const int right = rectangle->x_px + rectangle->width_px;
    const int bottom = rectangle->y_px + rectangle->height_px;

    return (sc_viewport){left, top, (right < image->width_px ? right : image->width_px) - left,
                         (bottom < last ? bottom : last) - top};
}

/* @return the pixel at (x, y), which lies in the picture. */
static inline uint8_t *sc_blend_pixel(const sc_image *image, int x, int y)
{
    const size_t at = (size_t)y * (size_t)image->width_px + (size_t)x;

    return image->rgb + at * sc_pixel_bytes(image->alpha);
}

/* Blend the colour @p rgb of opacity @p over, 0 to 255, over a pixel with alpha or without. */
static inline void sc_blend(const uint8_t rgb[3], unsigned over, bool has_alpha, uint8_t *to)
{
    const unsigned left = 255 - over;
    unsigned alpha; /* of both, times 255 */

    if (!over)
        return;
    if (!has_alpha) {
        for (int c = 0; c < 3; c++)
            to[c] = (uint8_t)((over * rgb[c] + to[c] * left + 127) / 255);
        return;
    }
    alpha = 255 * over + to[3] * left;
    for (int c = 0; c < 3; c++)
        to[c] = (uint8_t)((255 * over * rgb[c] + to[c] * to[3] * left + alpha / 2) / alpha);
    to[3] = (uint8_t)((alpha + 127) / 255);
}

#endif
