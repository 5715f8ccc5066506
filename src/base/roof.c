/* SPDX-License-Identifier: BSD-3-Clause */
/* What the cores of this machine can do at most, and what a process has used of it, by the counters
 * of the processor. */
#define _GNU_SOURCE /* syscall; the sizes of caches in sysconf */
#include "segcast/roof.h"

#include <unistd.h>

#ifdef __linux__
#include <linux/perf_event.h>
#include <sys/syscall.h>
#endif

enum {
    TRIES = 8,      /* of which the fastest counts */
    CHAINS = 8,     /* additions that do not depend on each other */
    REPEATS = 8,    /* of each chain, in a turn of the loop */
    TURNS = 100000, /* of the loop, each thread and try */
    CACHES = 4,     /* times the last cache: so much is read */
    LINE_BYTES = 64 /* that a miss of the last cache brings */
};
#define LEAST_BYTES ((size_t)128 << 20)
#define MOST_BYTES ((size_t)1 << 30)

/* ---- what the cores can do ---- */

/* An array that threads read. */
typedef struct reading {
    uint64_t *words;
    _Atomic uint64_t sum; /* so that nothing is left out */
} reading;

/* Write words [begin, end), so that they are in memory; an sc_range_fn on a reading. */
static void write_words(void *user, size_t begin, size_t end, int thread)
{
    const reading *r = user;

    for (size_t i = begin; i < end; i++)
        r->words[i] = i;
}

/* Read words [begin, end); an sc_range_fn on a reading. */
static void read_words(void *user, size_t begin, size_t end, int thread)
{
    reading *r = user;
    const uint64_t *words = r->words;
    uint64_t sums[CHAINS] = {0};
    size_t at = begin;

    for (; at + CHAINS <= end; at += CHAINS) {
        for (size_t i = 0; i < CHAINS; i++)
            sums[i] += words[at + i];
    }
    for (size_t i = 1; i < CHAINS; i++)
        sums[0] += sums[i];
    r->sum += sums[0];
}

/* Add numbers in registers, TURNS times CHAINS times REPEATS of them for each item; an sc_range_fn
 * on a reading. The empty statements keep a compiler from merging additions. */
static void add_numbers(void *user, size_t begin, size_t end, int thread)
{
    reading *r = user;
    uint64_t sums[CHAINS] = {0};

    for (size_t turn = 0; turn < (end - begin) * TURNS; turn++) {
        for (int repeat = 0; repeat < REPEATS; repeat++) {
#define SC_ADD(i)                                                                                  \
    sums[i] += begin;                                                                              \
    __asm__ volatile("" : "+r"(sums[i]))
            SC_ADD(0);
            SC_ADD(1);
            SC_ADD(2);
            SC_ADD(3);
            SC_ADD(4);
            SC_ADD(5);
            SC_ADD(6);
            SC_ADD(7);
#undef SC_ADD
        }
    }
    for (size_t i = 0; i < CHAINS; i++)
        r->sum += sums[i];
}

/* @return how often @p body is done per second for @p count items, by the fastest of some tries. */
static double fastest(int threads, size_t count, size_t chunk, sc_range_fn *body, reading *r)
{
    double least_s = 1e9;

    for (int i = 0; i < TRIES; i++) {
        const double begin_s = sc_wall_s();
        double wall_s;

        sc_parallel_for(threads, count, chunk, body, r);
        wall_s = sc_wall_s() - begin_s;
        least_s = wall_s < least_s ? wall_s : least_s;
    }
    return 1 / (least_s > 1e-9 ? least_s : 1e-9);
}

/* @return how many bytes are read: more than caches hold, where the machine has the memory. */
static size_t bytes_to_read(void)
{
    const uint64_t room = sc_machine_memory() / 8;
    size_t bytes = LEAST_BYTES;

#ifdef _SC_LEVEL3_CACHE_SIZE
    const long cache = sysconf(_SC_LEVEL3_CACHE_SIZE);

    if (cache > 0 && (size_t)cache * CACHES > bytes)
        bytes = (size_t)cache * CACHES;
#endif
    bytes = bytes < MOST_BYTES ? bytes : MOST_BYTES;
    return bytes < room ? bytes : (size_t)room;
}

/* @return SC_ERR_MEMORY if so many threads cannot be started, of which OpenMP would end the
 * process. */
static sc_status try_threads(const sc_ctx *ctx, int threads)
{
    sc_thread_probe *probe = NULL;
    int started = 0;
    sc_status status = sc_thread_probe_start(ctx, threads, &probe, &started);

    sc_thread_probe_end(probe);
    if (status == SC_OK && started < threads)
        status =
            sc_fail(ctx, SC_ERR_MEMORY, "the system starts %d of %d threads", started, threads);
    return status;
}

sc_status sc_roof_measure(const sc_ctx *ctx, int threads, sc_roof *out)
{
    const size_t bytes = bytes_to_read(), words = bytes / sizeof(uint64_t);
    const size_t chunk = (words + (size_t)threads - 1) / (size_t)threads;
    const double additions = (double)threads * TURNS * CHAINS * REPEATS;
    reading r = {0};
    void *block;

    SC_PASS(try_threads(ctx, threads));
    SC_PASS(sc_alloc(ctx, words, sizeof(uint64_t), &block));
    r.words = block;
    sc_parallel_for(threads, words, chunk, write_words, &r);
    *out = (sc_roof){
        .read_bytes_per_s = (double)bytes * fastest(threads, words, chunk, read_words, &r),
        .instructions_per_s = additions * fastest(threads, (size_t)threads, 1, add_numbers, &r)};
    sc_free(block);
    return SC_OK;
}

/* ---- what a process has used ---- */

#ifdef __linux__
/* Open a counter of what this process and the threads that it starts from now on do. @return -1 if
 * the system or the processor does not allow it. */
static int open_counter(uint32_t type, uint64_t what)
{
    struct perf_event_attr attr;

    memset(&attr, 0, sizeof attr);
    attr.size = sizeof attr;
    attr.type = type;
    attr.config = what;
    attr.inherit = 1;
    attr.exclude_kernel = 1;
    attr.exclude_hv = 1;
    attr.read_format = PERF_FORMAT_TOTAL_TIME_ENABLED | PERF_FORMAT_TOTAL_TIME_RUNNING;
    return (int)syscall(SYS_perf_event_open, &attr, 0, -1, -1, PERF_FLAG_FD_CLOEXEC);
}
#endif

sc_counters sc_counters_open(void)
{
    sc_counters out = {-1, -1};

#ifdef __linux__
    out.instructions = open_counter(PERF_TYPE_HARDWARE, PERF_COUNT_HW_INSTRUCTIONS);
    out.misses = open_counter(PERF_TYPE_HARDWARE, PERF_COUNT_HW_CACHE_MISSES);
#endif
    return out;
}

/* @return the value of a counter, as if it had always been running; -1 if it cannot be read. */
static double value_of(int counter)
{
    uint64_t value[3]; /* the count, the time since it was opened, the time that it has run */

    if (counter < 0 || read(counter, value, sizeof value) != (ssize_t)sizeof value)
        return -1;
    if (value[2] == 0)
        return value[1] ? -1 : 0;
    return (double)value[0] * ((double)value[1] / (double)value[2]);
}

double sc_counters_instructions(const sc_counters *counters)
{
    return value_of(counters->instructions);
}

double sc_counters_memory_bytes(const sc_counters *counters)
{
    const double misses = value_of(counters->misses);

    return misses < 0 ? -1 : misses * LINE_BYTES;
}

void sc_counters_close(sc_counters *counters)
{
    if (counters->instructions >= 0)
        close(counters->instructions);
    if (counters->misses >= 0)
        close(counters->misses);
    *counters = (sc_counters){-1, -1};
}
