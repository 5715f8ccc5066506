/* SPDX-License-Identifier: BSD-3-Clause */
/* PNG files; the only user of libpng. */
#include "segcast/image.h"

#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <sys/stat.h>

/* What the callbacks of libpng need for messages; both are borrowed. */
typedef struct png_target {
    const sc_ctx *ctx;
    const char *name;
} png_target;

/* libpng's callback for an error in writing, on a png_target: log it and jump back to the caller of
 * setjmp. errno, if not 0, tells the reason. */
static void on_error(png_structp png, png_const_charp message)
{
    const png_target *target = png_get_error_ptr(png);

    sc_fail(target->ctx, SC_ERR_WRITE, "%s: cannot be written: %s%s%s", target->name, message,
            errno ? ": " : "", errno ? sc_reason(errno) : "");
    png_longjmp(png, 1);
}

/* Its callback for warnings, which are dropped. */
static void on_warning(png_structp png, png_const_charp message)
{
}

/* Write header and pixels. An error leaves by longjmp: the caller has called setjmp. */
static void write_pixels(png_structp png, png_infop info, const sc_image *image, FILE *stream)
{
    const size_t row_bytes = (size_t)image->width_px * sc_pixel_bytes(image->alpha);

    png_init_io(png, stream);
    png_set_IHDR(png, info, (png_uint_32)image->width_px, (png_uint_32)image->height_px, 8,
                 image->alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, 3);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP);
    png_write_info(png, info);
    for (int y = 0; y < image->height_px; y++)
        png_write_row(png, image->rgb + (size_t)y * row_bytes);
    png_write_end(png, info);
}

/* Write a PNG to an open stream, which stays open. @param name of the file, for messages. */
static sc_status write_png(const sc_ctx *ctx, const sc_image *image, FILE *stream, const char *name)
{
    png_target target = {.ctx = ctx, .name = name};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &target, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;

    if (!info) {
        png_destroy_write_struct(&png, NULL);
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", name);
    }
    errno = 0;
    if (setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return SC_ERR_WRITE;
    }
    write_pixels(png, info, image, stream);
    png_destroy_write_struct(&png, &info);
    return SC_OK;
}

sc_status sc_image_compress_png(const sc_ctx *ctx, const sc_image *image, const char *name,
                                char **data, size_t *bytes)
{
    FILE *stream;
    sc_status status = SC_ERR_MEMORY;
    bool closed;

    *data = NULL;
    *bytes = 0;
    stream = open_memstream(data, bytes);
    if (stream) {
        status = write_png(ctx, image, stream, name);
        /* Closing trims the memory. If there is none for that, the data are gone, and glibc says so
         * by NULL alone. */
        closed = fclose(stream) == 0 && *data;
        if (status == SC_OK && closed)
            return SC_OK;
        free(*data);
        *data = NULL;
    }
    if (status == SC_OK || !stream)
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", name);
    return status;
}

sc_status sc_image_save_png(const sc_ctx *ctx, const sc_image *image, const char *path,
                            bool replace)
{
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};

    SC_PASS(sc_outfile_open(ctx, path, replace, &file));
    SC_PASS(write_png(ctx, image, file.stream, path));
    return sc_outfile_commit(ctx, &file);
}

/* @return whether a file as long as the one that is open can hold the pixels that its header says:
 * deflate makes at most 1032 bytes of one, and a byte holds at most eight pixels. What no file can
 * hold is not allocated. */
static bool can_hold(FILE *stream, double pixels)
{
    struct stat info;

    return fstat(fileno(stream), &info) == 0 && pixels <= 8 * 1032.0 * (double)info.st_size;
}

/* @return whether each chunk of an open file is as long as it says; libpng would allocate what a
 * broken one promises. The file is then at its beginning again. */
static bool chunks_fit(FILE *stream)
{
    unsigned char head[8]; /* length, the highest byte first, and type */
    struct stat info;
    long at = 8; /* behind the signature */
    bool fit = fstat(fileno(stream), &info) == 0;

    while (fit && !fseek(stream, at, SEEK_SET) && fread(head, sizeof head, 1, stream) == 1) {
        const uint32_t length =
            (uint32_t)head[0] << 24 | (uint32_t)head[1] << 16 | (uint32_t)head[2] << 8 | head[3];

        at += (long)sizeof head + (long)length + 4; /* 4: the check sum */
        fit = at - 4 <= (long)info.st_size;
    }
    rewind(stream);
    return fit;
}

sc_status sc_image_load_png(const sc_ctx *ctx, const char *path, sc_image *out)
{
    SC_OWN(png_image_free) png_image png = {.version = PNG_IMAGE_VERSION};
    SC_OWN(sc_image_clear) sc_image image = {0};
    SC_OWN(sc_fclose_at) FILE *stream = fopen(path, "rb");
    bool alpha;

    if (!stream)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    if (!chunks_fit(stream))
        return sc_fail(ctx, SC_ERR_DATA, "%s: is no PNG file, or is cut off", path);
    if (!png_image_begin_read_from_stdio(&png, stream))
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, png.message);
    if (!can_hold(stream, (double)png.width * png.height))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: says that it holds %u x %u pixels, but is too short for that", path,
                       (unsigned)png.width, (unsigned)png.height);
    alpha = png.format & PNG_FORMAT_FLAG_ALPHA;
    png.format = alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    SC_PASS(sc_image_init_alpha(ctx, (int)png.width, (int)png.height, alpha, &image));
    if (!png_image_finish_read(&png, NULL, image.rgb, 0, NULL))
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, png.message);
    *out = image;
    image.rgb = NULL;
    return SC_OK;
}

/* ---- numbers ---- */

/* libpng's callback for an error in reading, as on_error. */
static void on_read_error(png_structp png, png_const_charp message)
{
    const png_target *target = png_get_error_ptr(png);

    sc_fail(target->ctx, SC_ERR_DATA, "%s: %s; the file is damaged: get it anew", target->name,
            message);
    png_longjmp(png, 1);
}

/* Read the header of an open file, and have libpng unpack pixels to whole numbers of one or two
 * bytes. An error leaves by longjmp. */
static void begin_levels(png_structp png, png_infop info, FILE *stream, sc_levels *out)
{
    png_colorp palette;
    int colors = 0;

    png_init_io(png, stream);
    png_read_info(png, info);
    out->width_px = (int)png_get_image_width(png, info);
    out->height_px = (int)png_get_image_height(png, info);
    out->bytes = png_get_bit_depth(png, info) == 16 ? 2 : 1;
    if (png_get_color_type(png, info) == PNG_COLOR_TYPE_PALETTE &&
        png_get_PLTE(png, info, &palette, &colors)) {
        out->colors = colors;
        for (int i = 0; i < colors; i++) {
            out->palette[i][0] = palette[i].red;
            out->palette[i][1] = palette[i].green;
            out->palette[i][2] = palette[i].blue;
        }
    }
    png_set_packing(png);
    png_set_strip_alpha(png);
    if (png_get_color_type(png, info) & PNG_COLOR_MASK_COLOR && !out->colors)
        png_set_rgb_to_gray(png, PNG_ERROR_ACTION_NONE, -1, -1);
    if (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)
        png_set_swap(png);
}

/* Read the pixels to out->levels, which is allocated. @return false, logged, if some have a colour.
 * An error leaves by longjmp. */
static bool read_levels(const png_target *target, png_structp png, png_infop info, sc_levels *out)
{
    const size_t row_bytes = (size_t)out->width_px * (size_t)out->bytes;
    const int passes = png_set_interlace_handling(png);

    png_read_update_info(png, info);
    for (int pass = 0; pass < passes; pass++) {
        for (int y = 0; y < out->height_px; y++)
            png_read_row(png, (png_bytep)out->levels + (size_t)y * row_bytes, NULL);
    }
    if (!png_get_rgb_to_gray_status(png))
        return true;
    sc_fail(target->ctx, SC_ERR_DATA,
            "%s: is a colour picture, expected the number of a label in each pixel; save the "
            "labels, not their colours",
            target->name);
    return false;
}

/* Read an open file, whose chunks fit. *out owns its levels also after an error. */
static sc_status load_levels(const png_target *target, FILE *stream, sc_levels *out)
{
    png_structp png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, (void *)target, on_read_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    volatile sc_status status = SC_ERR_DATA;

    if (!info) {
        png_destroy_read_struct(&png, NULL, NULL);
        return sc_fail(target->ctx, SC_ERR_MEMORY, "%s: out of memory", target->name);
    }
    if (!setjmp(png_jmpbuf(png))) {
        begin_levels(png, info, stream, out);
        if (!can_hold(stream, (double)out->width_px * out->height_px))
            sc_fail(target->ctx, SC_ERR_DATA,
                    "%s: says that it holds %d x %d pixels, but is too short for that",
                    target->name, out->width_px, out->height_px);
        else if (sc_alloc(target->ctx, (size_t)out->width_px * (size_t)out->height_px,
                          (size_t)out->bytes, &out->levels) != SC_OK)
            status = SC_ERR_MEMORY;
        else if (read_levels(target, png, info, out))
            status = SC_OK;
    }
    png_destroy_read_struct(&png, &info, NULL);
    return status;
}

sc_status sc_image_load_levels(const sc_ctx *ctx, const char *path, sc_levels *out)
{
    const png_target target = {.ctx = ctx, .name = path};
    sc_levels levels = {0};
    sc_status status;
    FILE *stream = fopen(path, "rb");

    if (!stream)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    status = chunks_fit(stream)
                 ? load_levels(&target, stream, &levels)
                 : sc_fail(ctx, SC_ERR_DATA, "%s: is no PNG file, or is cut off", path);
    fclose(stream);
    if (status == SC_OK)
        *out = levels;
    else
        sc_free(levels.levels);
    return status;
}
