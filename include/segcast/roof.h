/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What the cores of this machine can do at most, and what a process has used of it by the counters
 *  of the processor: the two sides of a roofline. */
#ifndef SEGCAST_ROOF_H
#define SEGCAST_ROOF_H

#include "segcast/base.h"

/** What some cores of this machine do at most, together. */
typedef struct sc_roof {
    double read_bytes_per_s;   /**< read from memory, one word after the other */
    double instructions_per_s; /**< executed: additions in registers */
} sc_roof;
/** Measure the roof in some tenths of a second: the fastest of several tries of @p threads threads.
 *  @return SC_ERR_MEMORY: it takes four times the last cache, 128 MiB to 1 GiB; or not so many
 *  threads can be started. */
SC_MUST_USE sc_status sc_roof_measure(const sc_ctx *ctx, int threads, sc_roof *out);
/** Counters of the processor for this process and the threads that it starts later: file
 *  descriptors, -1 where the system or the processor does not allow them. */
typedef struct sc_counters {
    int instructions, misses;
} sc_counters;
/** Open the counters, before the threads are started that are to be counted. They are closed by
 *  sc_counters_close. */
sc_counters sc_counters_open(void);
/** @return the instructions that were executed since the counters were opened, outside of the
 *  kernel; -1 where they are not counted. Any thread. */
double sc_counters_instructions(const sc_counters *counters);
/** As sc_counters_instructions: the bytes that came from memory, as the misses of the last cache
 *  tell. */
double sc_counters_memory_bytes(const sc_counters *counters);
/** Close the counters. */
void sc_counters_close(sc_counters *counters);

#endif
