/* SPDX-License-Identifier: BSD-3-Clause */
/* Comparing two pictures. */
#ifndef SC_TEST_COMPARE_IMAGES_H
#define SC_TEST_COMPARE_IMAGES_H

#include "segcast/image.h"

#include <math.h>
#include <stdlib.h>

/* How two pictures of the same size differ. */
typedef struct image_difference {
    int largest;         /* largest difference of a channel, in levels of 8 bits */
    double rms;          /* root mean square over all channels, in levels */
    size_t differing_px; /* pixels with any difference */
} image_difference;

/* Compare two pictures and write how they differ to @p out. @return false, with
 * @p out zero, if their sizes differ, or only one has alpha. */
static inline bool compare_images(const sc_image *a, const sc_image *b, image_difference *out)
{
    const size_t pixels = (size_t)a->width_px * (size_t)a->height_px;
    const size_t channels = sc_pixel_bytes(a->alpha);
    double squares = 0;

    *out = (image_difference){0};
    if (a->width_px != b->width_px || a->height_px != b->height_px || a->alpha != b->alpha)
        return false;
    for (size_t i = 0; i < pixels; i++) {
        bool same = true;

        for (size_t c = channels * i; c < channels * (i + 1); c++) {
            const int step = abs(a->rgb[c] - b->rgb[c]);

            same = same && step == 0;
            squares += (double)step * step;
            out->largest = step > out->largest ? step : out->largest;
        }
        out->differing_px += !same;
    }
    out->rms = pixels ? sqrt(squares / ((double)channels * (double)pixels)) : 0;
    return true;
}

#endif
