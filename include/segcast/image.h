/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Pictures of 8-bit sRGB pixels: buffers, hash, comparison, PNG files, the conversion between
 *  sRGB and linear light, and how different colours look. Only src/image/png.c uses libpng. */
#ifndef SEGCAST_IMAGE_H
#define SEGCAST_IMAGE_H

#include "segcast/base.h"

/** A picture of 8-bit sRGB pixels, top row first, without padding: [height_px][width_px][3],
 * opaque, or [height_px][width_px][4] with alpha behind the colour. The colour is not multiplied by
 * alpha (PNG calls that straight); where alpha is 0, all four are. */
typedef struct sc_image {
    int width_px, height_px;
    uint8_t *rgb; /**< owned unless a function says otherwise; NULL if empty */
    bool alpha;   /**< pixels have four channels */
} sc_image;

/** Allocate the pixels, not initialised. @return SC_ERR_MEMORY. Caller owns: sc_image_clear. */
SC_MUST_USE sc_status sc_image_init(const sc_ctx *ctx, int width_px, int height_px, sc_image *out);
/** As sc_image_init, of a picture that has alpha or not. */
SC_MUST_USE sc_status sc_image_init_alpha(const sc_ctx *ctx, int width_px, int height_px,
                                          bool alpha, sc_image *out);
/** Free the pixels; the image is empty then (all zero). An empty image is allowed. */
void sc_image_clear(sc_image *image);
/** @return how many bytes a pixel has, of pictures with alpha or without. */
static inline size_t sc_pixel_bytes(bool alpha)
{
    return alpha ? 4 : 3;
}
/** @return the size of the pixels in bytes: sc_pixel_bytes width_px height_px. */
size_t sc_image_bytes(const sc_image *image);
/** Put the opaque colour @p rgb, of sRGB, behind a picture with alpha, in place: it has none then.
 * Levels are blended as they are, as browsers and players blend them. An opaque picture stays as
 * it is. */
void sc_image_flatten(sc_image *image, const uint8_t rgb[3]);

/** @return a 64-bit hash (XXH3) of size and pixels, the same on every machine. */
uint64_t sc_image_hash(const sc_image *image);

/** Compress a picture as a PNG file in memory: *data [*bytes], which the caller frees with free().
 *  @param name of the picture, for messages. @return SC_ERR_WRITE, SC_ERR_MEMORY; *data is NULL
 * then. */
SC_MUST_USE sc_status sc_image_compress_png(const sc_ctx *ctx, const sc_image *image,
                                            const char *name, char **data, size_t *bytes);
/** Compress a picture as a JPEG file in memory, as sc_image_compress_png. @param quality 1 to 100.
 *  @param image without alpha. @return SC_ERR_MEMORY; SC_ERR_INTERNAL, logged. */
SC_MUST_USE sc_status sc_image_compress_jpeg(const sc_ctx *ctx, const sc_image *image, int quality,
                                             char **data, size_t *bytes);
/** Write a PNG file that appears under @p path only when it is complete. @param replace as of
 *  sc_outfile_open.
 *  @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_image_save_png(const sc_ctx *ctx, const sc_image *image, const char *path,
                                        bool replace);
/** Read a PNG file of any kind as 8-bit RGB; one that has alpha gives a picture with alpha.
 *  @return SC_ERR_MISSING if it cannot be opened,
 *  SC_ERR_DATA if it is damaged, SC_ERR_MEMORY. Caller owns: sc_image_clear. */
SC_MUST_USE sc_status sc_image_load_png(const sc_ctx *ctx, const char *path, sc_image *out);

/** A picture whose pixels are numbers, as they stand in the file: grey levels, or the places of a
 * palette. */
typedef struct sc_levels {
    int width_px, height_px;
    int bytes;               /**< of each number: 1, or 2 in the byte order of this machine */
    void *levels;            /**< [height_px][width_px], top row first; owned: sc_free */
    int colors;              /**< of the palette; 0: the file has none */
    uint8_t palette[256][3]; /**< [colors], sRGB */
} sc_levels;
/** Read a PNG file as numbers. @return SC_ERR_MISSING if it cannot be opened, SC_ERR_DATA if it is
 * damaged or has a colour that is in no palette, SC_ERR_MEMORY. Caller owns out->levels. */
SC_MUST_USE sc_status sc_image_load_levels(const sc_ctx *ctx, const char *path, sc_levels *out);

/** Kinds of colour vision: with all three kinds of cones, or without those for long, middle or
 * short waves. */
typedef enum sc_vision {
    SC_VISION_FULL,
    SC_VISION_PROTANOPIA,
    SC_VISION_DEUTERANOPIA,
    SC_VISION_TRITANOPIA,
    SC_VISION_COUNT
} sc_vision;
/** Find where a colour that is seen with @p vision lies in OKLab, in which equal distances look
 *  about equally large: lab[0] is the lightness, from 0 (black) to 1 (white), and lab[1] and lab[2]
 *  are 0 for greys. @param rgb sRGB. */
void sc_oklab(const uint8_t rgb[3], sc_vision vision, double lab[3]);
/** A colour in OKLab, for each kind of vision. */
typedef struct sc_seen_color {
    double lab[SC_VISION_COUNT][3];
} sc_seen_color;
/** @return sc_oklab of a colour for all kinds of vision. @param rgb sRGB. */
sc_seen_color sc_see_color(const uint8_t rgb[3]);
/** @return how far apart two colours look: their distance in OKLab. Black and white are 1 apart;
 *  0.02 is about the least that can be seen side by side. */
double sc_color_distance(const sc_seen_color *a, const sc_seen_color *b, sc_vision vision);
/** Two colours whose contrast is at least this look different beside each other, also in shade. */
#define SC_CONTRAST 0.12
/** @return how well two colours can be told apart by everybody: their distance as the eye sees
 * them, and for the colour-blind, who have fewer colours to tell apart, 1.5 times that. */
double sc_color_contrast(const sc_seen_color *a, const sc_seen_color *b);

enum {
    SC_COLOR_NAMES = 148,    /**< colours that have a name in CSS */
    SC_COLOR_NAME_BYTES = 32 /**< more than the longest of them has */
};
/** Find a colour by its name, in which case, blanks, "-" and "_" do not matter. @param plain gets
 * the name as CSS writes it, cut off if it is longer. @return false if no colour has it. */
bool sc_color_by_name(const char *text, char plain[SC_COLOR_NAME_BYTES], uint8_t rgb[3]);
/** Fill @p words with all names, as CSS writes them; static texts. */
void sc_color_names(const char *words[SC_COLOR_NAMES]);

/** @return the linear light in [0, 1] of the sRGB value @p srgb in [0, 1] (IEC 61966-2-1). */
double sc_srgb_to_linear(double srgb);
/** Table that converts linear light to the nearest sRGB level by comparisons alone: the pow() of
 * the C library differs between machines, which would change pixels. Fill it once; threads may
 * share it. */
typedef struct sc_srgb_table {
    float threshold[256]; /**< [i]: linear value at which level i + 1 begins; [255] is above 1 */
    uint8_t start[4097];  /**< [i]: level of the linear value i / 4096; at most one level begins
                               between i / 4096 and (i + 1) / 4096 */
} sc_srgb_table;
/** Fill all of @p table. */
void sc_srgb_table_init(sc_srgb_table *table);
/** @return the sRGB level of @p linear, clamped to [0, 1]; a NaN counts as 0. */
static inline uint8_t sc_srgb_level(const sc_srgb_table *table, float linear)
{
    const float within = linear > 0 ? (linear < 1 ? linear : 1) : 0;
    const int level = table->start[(int)(within * 4096)];

    return (uint8_t)(level + (table->threshold[level] <= within));
}

/** What pictures are mixed by: 6 KB without pointers, which may be copied to other machines as
 * bytes, so that they mix to the same bits (see sc_srgb_table). */
typedef struct sc_mixer {
    sc_srgb_table levels;
    float linear[256]; /**< linear light of each level of sRGB */
} sc_mixer;
/** Fill all of @p mixer; threads may share it then. */
void sc_mixer_init(sc_mixer *mixer);
/** Keep @p share, 0 to 1, of a picture, and put as much of @p other, of the same size and kind, in
 *  its place as is missing, in linear light; colours of pixels with alpha count as much as they
 *  cover. @param first, end the rows [first, end) of both, the only ones that are read or written.
 */
void sc_image_mix(const sc_mixer *mixer, const sc_image *other, float share, int first, int end,
                  sc_image *image);
/** The same with the colour @p rgb, sRGB, everywhere; with nothing at all in a picture with alpha.
 */
void sc_image_fade(const sc_mixer *mixer, const uint8_t rgb[3], float share, int first, int end,
                   sc_image *image);
/** Add the linear light of rows [first, end) of a picture to @p sums, [height_px][width_px][3], or
 *  [4] of one with alpha, whose colours count as much as they cover. */
void sc_image_add(const sc_mixer *mixer, const sc_image *image, int first, int end, float *sums);
/** Set these rows of a picture to the mean of @p count that have been added. */
void sc_image_mean(const sc_mixer *mixer, const float *sums, int count, int first, int end,
                   sc_image *image);

#endif
