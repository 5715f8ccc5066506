/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Pictures of 8-bit sRGB pixels: buffers, hash, comparison, PNG files, and the conversion between
 *  sRGB and linear light. Only src/image/png.c uses libpng. */
#ifndef SEGCAST_IMAGE_H
#define SEGCAST_IMAGE_H

#include "segcast/base.h"

/** Opaque sRGB picture; pixels are [height_px][width_px][3], top row first, tightly packed. */
typedef struct sc_image {
    int width_px, height_px;
    uint8_t *rgb;
} sc_image;

/** @return SC_ERR_MEMORY. Caller owns: sc_image_clear. Pixels are not initialised. */
SC_MUST_USE sc_status sc_image_init(const sc_ctx *ctx, int width_px, int height_px, sc_image *out);
void sc_image_clear(sc_image *image);
size_t sc_image_bytes(const sc_image *image);

/** Hash of size and pixels (XXH3, 64 bits): equal for equal pictures on every machine. */
uint64_t sc_image_hash(const sc_image *image);

/** How two pictures of one size differ. */
typedef struct sc_image_difference {
    int largest;         /**< of all channels, in levels of 8 bits */
    double rms;          /**< over all channels, in levels */
    size_t differing_px; /**< pixels with any difference */
} sc_image_difference;
/** @return false if the sizes differ, @p out untouched. */
bool sc_image_compare(const sc_image *a, const sc_image *b, sc_image_difference *out);

/** Write a PNG to an open stream. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_image_write_png(const sc_ctx *ctx, const sc_image *image, FILE *stream,
                                         const char *name);
/** Write a PNG that appears under @p path only when complete. */
SC_MUST_USE sc_status sc_image_save_png(const sc_ctx *ctx, const sc_image *image, const char *path);
/** Read a PNG as 8-bit RGB. @return SC_ERR_MISSING or SC_ERR_DATA. Caller owns the pixels. */
SC_MUST_USE sc_status sc_image_load_png(const sc_ctx *ctx, const char *path, sc_image *out);

/** Linear light in [0, 1] of an sRGB level (IEC 61966-2-1). */
double sc_srgb_to_linear(double srgb);
/** Table that turns linear light into sRGB levels by comparison alone, so that no library's pow
 *  can move a pixel. Fill once, share between threads. */
typedef struct sc_srgb_table {
    float threshold[256]; /**< level i + 1 begins at this linear value; the last is never reached */
    uint8_t start[4097];  /**< lowest level for linear values in [i, i + 1) / 4096: parts so small
                               that no more than one level begins in each */
} sc_srgb_table;
void sc_srgb_table_init(sc_srgb_table *table);
static inline uint8_t sc_srgb_level(const sc_srgb_table *table, float linear)
{
    const float within = linear > 0 ? (linear < 1 ? linear : 1) : 0;
    const int level = table->start[(int)(within * 4096)];

    return (uint8_t)(level + (table->threshold[level] <= within));
}

#endif
