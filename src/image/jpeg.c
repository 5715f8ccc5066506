/* SPDX-License-Identifier: BSD-3-Clause */
/* JPEG files; the only user of libjpeg. */
#include "segcast/image.h"

#include <jpeglib.h>
#include <setjmp.h>
#include <stdlib.h>

/* What the library calls when it cannot go on. */
typedef struct jpeg_errors {
    struct jpeg_error_mgr manager; /* has to be the first */
    jmp_buf back;
} jpeg_errors;

/* Its callback for an error: back to the caller of setjmp. */
static void on_error(j_common_ptr jpeg)
{
    longjmp(((jpeg_errors *)jpeg->err)->back, 1);
}

/* Its callback for messages, which are dropped. */
static void on_message(j_common_ptr jpeg)
{
}

/* Compress all rows. An error leaves by longjmp. */
static void write_rows(struct jpeg_compress_struct *jpeg, const sc_image *image, int quality)
{
    jpeg->image_width = (JDIMENSION)image->width_px;
    jpeg->image_height = (JDIMENSION)image->height_px;
    jpeg->input_components = 3;
    jpeg->in_color_space = JCS_RGB;
    jpeg_set_defaults(jpeg);
    jpeg_set_quality(jpeg, quality, TRUE);
    jpeg->dct_method = JDCT_IFAST;
    jpeg_start_compress(jpeg, TRUE);
    while (jpeg->next_scanline < jpeg->image_height) {
        JSAMPROW row = image->rgb + (size_t)jpeg->next_scanline * 3 * (size_t)image->width_px;

        jpeg_write_scanlines(jpeg, &row, 1);
    }
    jpeg_finish_compress(jpeg);
}

sc_status sc_image_compress_jpeg(const sc_ctx *ctx, const sc_image *image, int quality, char **data,
                                 size_t *bytes)
{
    struct jpeg_compress_struct jpeg;
    jpeg_errors errors;
    unsigned char *volatile out = NULL; /* keeps its value when an error comes back */
    unsigned char *place = NULL;
    unsigned long size = 0;

    *data = NULL;
    *bytes = 0;
    jpeg.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = on_error;
    errors.manager.output_message = on_message;
    if (setjmp(errors.back)) {
        jpeg_destroy_compress(&jpeg);
        free(out);
        return sc_fail(ctx, SC_ERR_MEMORY, "a picture cannot be compressed: out of memory");
    }
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &place, &size);
    out = place;
    write_rows(&jpeg, image, quality);
    jpeg_destroy_compress(&jpeg);
    *data = (char *)place;
    *bytes = size;
    return SC_OK;
}
