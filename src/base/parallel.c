/* SPDX-License-Identifier: BSD-3-Clause */
/* The only file that uses OpenMP: every parallel loop of segcast is a call of sc_parallel_for. */
#include "segcast/base.h"

#include <omp.h>

void sc_parallel_for(int threads, size_t count, size_t chunk, sc_range_fn *body, void *user)
{
    const long chunks = (long)((count + chunk - 1) / chunk);

#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1)
    for (long i = 0; i < chunks; i++) {
        const size_t begin = (size_t)i * chunk;
        const size_t end = begin + chunk < count ? begin + chunk : count;

        body(user, begin, end, omp_get_thread_num());
    }
}

int sc_default_threads(void)
{
    return omp_get_max_threads();
}

int sc_usable_cores(void)
{
    return omp_get_num_procs();
}
