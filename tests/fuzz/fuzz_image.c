/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a PNG file; the check sums of its chunks are made to fit. */
#include "fuzz.h"
#include "segcast/image.h"

#include <zlib.h>

/* The number in four bytes, the highest first. */
static uint32_t number_at(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* Make the check sum of each chunk fit: of length, type, contents and sum, after 8 bytes. */
static void repair(uint8_t *file, size_t bytes)
{
    for (size_t at = 8; at + 12 <= bytes;) {
        const size_t length = number_at(file + at);
        uint32_t sum;

        if (length > bytes - at - 12)
            return;
        sum = (uint32_t)crc32(0, file + at + 4, (uInt)length + 4);
        for (int i = 0; i < 4; i++)
            file[at + 8 + length + (size_t)i] = (uint8_t)(sum >> (24 - 8 * i));
        at += length + 12;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size + 1);
    SC_OWN(sc_image_clear) sc_image image = {0};
    sc_status status;

    FUZZ_CHECK(copy);
    memcpy(copy, data, size);
    repair(copy, size);
    status = sc_image_load_png(&fuzz_ctx, fuzz_write("input.png", copy, size), &image);
    FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA);
    if (status == SC_OK) {
        FUZZ_CHECK(image.width_px > 0 && image.height_px > 0);
        sc_image_hash(&image);
    }
    free(copy);
    return 0;
}
