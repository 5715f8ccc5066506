/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Statistics of repeated measurements, and the measures of parallel speed that follow from them.
 *  Pure functions of the module study. */
#ifndef SEGCAST_STATISTICS_H
#define SEGCAST_STATISTICS_H

#include "segcast/base.h"

/** What repeated measurements of one quantity say; all numbers have its unit. */
typedef struct sc_statistics {
    size_t count; /**< of measurements; 0: all else is 0 */
    double least, quartile_1, median, quartile_3, most;
    double mean;
    /** The 95 % confidence interval of the median: two of the measurements, chosen by their ranks,
     *  so that nothing is assumed of the distribution (binomial; Conover, Practical Nonparametric
     *  Statistics, section 3.2). With fewer than SC_INTERVAL_LEAST measurements there is none: both
     *  are the extremes then, and has_interval is false. */
    double low, high;
    bool has_interval;
} sc_statistics;

/** The fewest measurements of which the extremes enclose the median with 95 % confidence. */
enum { SC_INTERVAL_LEAST = 6 };

/** Describe @p count finite @p values. Quartiles between two values are interpolated linearly.
 *  @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_statistics_of(const sc_ctx *ctx, const double *values, size_t count,
                                       sc_statistics *out);
/** @return half the confidence interval divided by the median: how exactly the median is known.
 *  Infinity without an interval, or if the median is 0. */
double sc_statistics_precision(const sc_statistics *statistics);

/** @return the serial share of a program that @p workers make @p speedup times as fast as one: the
 *  experimentally determined serial fraction of Karp and Flatt (CACM 33, 1990). 0 for one worker.
 */
double sc_karp_flatt(double speedup, double workers);

/** Bring the numbers 0 to @p count - 1 into a random order, the same for the same @p seed on every
 *  machine. @param out [count]. */
void sc_random_order(uint64_t seed, int count, int *out);

#endif
