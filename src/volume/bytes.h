/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: numbers as files store them. */
#ifndef SC_VOLUME_BYTES_H
#define SC_VOLUME_BYTES_H

#include <stdbool.h>
#include <stdint.h>

/* @return the number of @p bytes bytes, at most 8, at @p at. @param big its highest byte stands
 * first. */
static inline uint64_t sc_number_at(const unsigned char *at, int bytes, bool big)
{
    uint64_t number = 0;

    for (int i = 0; i < bytes; i++)
        number = number << 8 | at[big ? i : bytes - 1 - i];
    return number;
}

#endif
