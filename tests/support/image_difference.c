/* SPDX-License-Identifier: BSD-3-Clause */
/* image_difference [-p] A.png B.png [MAX_LEVEL [MAX_RMS [X Y]]] prints how two pictures differ. It
 * exits with 0 if no channel differs by more than MAX_LEVEL (0) levels and their root mean square
 * is at most MAX_RMS (255), with 1 if they differ more, and with 2 if they cannot be compared. With
 * X and Y, B is compared with that part of A which is as large as B and begins there. */
#include "compare_images.h"

#include <stdlib.h>
#include <string.h>

/* Replace @p a by its part of the size of @p b that begins at (x, y). @return whether it has one.
 */
static bool crop(sc_image *a, const sc_image *b, int x, int y)
{
    const size_t bytes = sc_pixel_bytes(b->alpha), row_bytes = bytes * (size_t)b->width_px;

    if (a->alpha != b->alpha || x < 0 || y < 0 || x + b->width_px > a->width_px ||
        y + b->height_px > a->height_px)
        return false;
    for (int row = 0; row < b->height_px; row++)
        memmove(a->rgb + (size_t)row * row_bytes,
                a->rgb + bytes * ((size_t)(y + row) * (size_t)a->width_px + (size_t)x), row_bytes);
    a->width_px = b->width_px;
    a->height_px = b->height_px;
    return true;
}

/* Multiply the colours of a picture that has alpha by it. */
static void multiply_by_alpha(sc_image *image)
{
    const size_t pixels = image->alpha ? (size_t)image->width_px * (size_t)image->height_px : 0;

    for (size_t i = 0; i < pixels; i++) {
        for (int c = 0; c < 3; c++)
            image->rgb[4 * i + c] =
                (uint8_t)((image->rgb[4 * i + c] * image->rgb[4 * i + 3] + 127) / 255);
    }
}

/* Do what is asked for, without the option -p. @return the exit code. */
static int compare(int argc, char **argv, bool multiply)
{
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_log_to_stderr};
    const double level = argc > 3 ? atof(argv[3]) : 0, rms = argc > 4 ? atof(argv[4]) : 255;
    sc_image a = {0}, b = {0};
    image_difference d;
    int result = 2;

    if (argc < 3 || sc_image_load_png(&ctx, argv[1], &a) || sc_image_load_png(&ctx, argv[2], &b))
        goto out;
    if (argc > 6 && !crop(&a, &b, atoi(argv[5]), atoi(argv[6]))) {
        printf("there is no such part in %d x %d pixels\n", a.width_px, a.height_px);
        goto out;
    }
    if (multiply) {
        multiply_by_alpha(&a);
        multiply_by_alpha(&b);
    }
    if (!compare_images(&a, &b, &d)) {
        printf("sizes or kinds differ: %d x %d and %d x %d\n", a.width_px, a.height_px, b.width_px,
               b.height_px);
        goto out;
    }
    printf("largest %d, rms %.4f, pixels %zu of %d\n", d.largest, d.rms, d.differing_px,
           a.width_px * a.height_px);
    result = d.largest <= level && d.rms <= rms ? 0 : 1;
out:
    sc_image_clear(&a);
    sc_image_clear(&b);
    return result;
}

int main(int argc, char **argv)
{
    const bool multiply = argc > 1 && !strcmp(argv[1], "-p");

    return compare(argc - multiply, argv + multiply, multiply);
}
