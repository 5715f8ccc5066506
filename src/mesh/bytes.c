/* SPDX-License-Identifier: BSD-3-Clause */
/* Numbers as the bytes of a file, the same on every machine. */
#include "internal.h"

void sc_put_u32(FILE *stream, uint32_t value)
{
    const uint8_t bytes[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16),
                              (uint8_t)(value >> 24)};

    fwrite(bytes, 1, sizeof bytes, stream);
}

void sc_put_float(FILE *stream, float value)
{
    uint32_t bits;

    memcpy(&bits, &value, sizeof bits);
    sc_put_u32(stream, bits);
}
