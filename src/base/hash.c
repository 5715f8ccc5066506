/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/base.h"

#define XXH_INLINE_ALL
#include <sys/random.h>
#include <xxhash.h>

uint64_t sc_hash_bytes(const void *data, size_t bytes, uint64_t seed)
{
    return XXH3_64bits_withSeed(data, bytes, seed);
}

uint64_t sc_hash_seed(void)
{
    static const char somewhere;
    uint64_t seed;

    /* Without random numbers an address has to do; the system chooses it in most programs. */
    return getrandom(&seed, sizeof seed, GRND_NONBLOCK) == (ssize_t)sizeof seed
               ? seed
               : (uint64_t)(uintptr_t)&somewhere;
}
