/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: numbers as files store them. */
#ifndef SC_VOLUME_BYTES_H
#define SC_VOLUME_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Numbers of this machine have the lowest byte first. */
#define SC_IS_LITTLE_ENDIAN (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)

/* @return the number of @p bytes bytes, at most 8, at @p at. @param big its highest byte stands
 * first. */
static inline uint64_t sc_number_at(const unsigned char *at, int bytes, bool big)
{
    uint64_t number = 0;

    for (int i = 0; i < bytes; i++)
        number = number << 8 | at[big ? i : bytes - 1 - i];
    return number;
}

/* Write the lowest @p bytes bytes of a number, at most 8, to @p out, in the order of this machine.
 */
static inline void sc_number_put(uint64_t number, size_t bytes, void *out)
{
    for (size_t i = 0; i < bytes; i++)
        ((unsigned char *)out)[SC_IS_LITTLE_ENDIAN ? i : bytes - 1 - i] =
            (unsigned char)(number >> 8 * i);
}

#endif
