/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Pictures of all directions, in linear light, from Radiance files (.hdr). */
#ifndef SEGCAST_PANORAMA_H
#define SEGCAST_PANORAMA_H

#include "segcast/base.h"

/** The widest one: a pixel is a third of a degree. Larger files are brought to less. */
enum { SC_PANORAMA_WIDTH_MOST = 1024 };

/** A picture whose columns are longitudes and whose rows are latitudes, that above the head first.
 */
typedef struct sc_panorama {
    int width_px, height_px; /**< at most SC_PANORAMA_WIDTH_MOST, and half of it, rounded up */
    float (*rgb)[3];         /**< [height_px][width_px]; owned unless a function says otherwise */
} sc_panorama;

/** Read a Radiance file of RGBE pixels, in one piece or run by run. A wide one is brought to a
 *  smaller size by means of squares of pixels. @return SC_ERR_MISSING; SC_ERR_DATA, with a message,
 *  for what is no such file, is no picture of all directions, ends too early, or is black;
 *  SC_ERR_MEMORY. Caller owns *out: sc_panorama_clear. */
SC_MUST_USE sc_status sc_panorama_load(const sc_ctx *ctx, const char *path, sc_panorama *out);
/** Free the pixels; harmless on a zeroed struct. */
void sc_panorama_clear(sc_panorama *panorama);

#endif
