/* SPDX-License-Identifier: BSD-3-Clause */
/* The only file that uses OpenMP: every parallel loop of segcast is a call of sc_parallel_for. And
 * how many threads can be started, because OpenMP ends the process where one cannot be. */
#include "segcast/base.h"

#include <omp.h>
#include <pthread.h>

struct sc_thread_probe {
    pthread_mutex_t gate; /* locked as long as the threads are to stay */
    int count;
    pthread_t threads[];
};

/* Of a probe's thread: wait until the gate is opened. */
static void *wait_at_gate(void *user)
{
    sc_thread_probe *probe = user;

    pthread_mutex_lock(&probe->gate);
    pthread_mutex_unlock(&probe->gate);
    return NULL;
}

sc_status sc_thread_probe_start(const sc_ctx *ctx, int wanted, sc_thread_probe **out, int *started)
{
    const size_t bytes = sizeof(sc_thread_probe) + (size_t)wanted * sizeof(pthread_t);
    sc_thread_probe *probe;

    SC_PASS(sc_zalloc(ctx, 1, bytes, &probe));
    pthread_mutex_init(&probe->gate, NULL);
    pthread_mutex_lock(&probe->gate);
    while (probe->count < wanted &&
           pthread_create(&probe->threads[probe->count], NULL, wait_at_gate, probe) == 0)
        probe->count++;
    *started = probe->count;
    *out = probe;
    return SC_OK;
}

void sc_thread_probe_end(sc_thread_probe *probe)
{
    if (!probe)
        return;
    pthread_mutex_unlock(&probe->gate);
    for (int i = 0; i < probe->count; i++)
        pthread_join(probe->threads[i], NULL);
    pthread_mutex_destroy(&probe->gate);
    sc_free(probe);
}

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
