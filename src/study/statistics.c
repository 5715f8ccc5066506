/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/statistics.h"

#include <math.h>
#include <stdlib.h>

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* @return the value below which the share @p share of the @p count sorted values lies: the
 * definition 7 of Hyndman and Fan (1996), which most programs use. */
static double quantile(const double *sorted, size_t count, double share)
{
    const double at = share * (double)(count - 1);
    const size_t below = (size_t)at, above = below + 1 < count ? below + 1 : below;

    return sorted[below] + (at - (double)below) * (sorted[above] - sorted[below]);
}

/* @return the largest number k for which fewer than k of @p count values lie below the median with
 * a probability of at most 2.5 %; 0: there is none. The k-th smallest and the k-th largest value
 * then enclose the median with 95 % confidence. */
static size_t interval_rank(size_t count)
{
    double term = pow(0.5, (double)count), sum = 0; /* of the binomial distribution */
    size_t k = 0;

    if (term == 0) { /* so many that its normal approximation holds */
        const double rank = ((double)count - 1.959964 * sqrt((double)count)) / 2;

        return (size_t)rank;
    }
    for (; 2 * k < count; k++) {
        sum += term;
        if (sum > 0.025)
            return k;
        term *= (double)(count - k) / (double)(k + 1);
    }
    return k;
}

sc_status sc_statistics_of(const sc_ctx *ctx, const double *values, size_t count,
                           sc_statistics *out)
{
    sc_statistics s = {.count = count};
    double *sorted = NULL;
    size_t k;

    if (count == 0) {
        *out = s;
        return SC_OK;
    }
    SC_PASS(SC_ALLOC(ctx, count, &sorted));
    memcpy(sorted, values, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, by_value);
    for (size_t i = 0; i < count; i++)
        s.mean += sorted[i] / (double)count;
    s.least = sorted[0];
    s.quartile_1 = quantile(sorted, count, 0.25);
    s.median = quantile(sorted, count, 0.5);
    s.quartile_3 = quantile(sorted, count, 0.75);
    s.most = sorted[count - 1];
    k = interval_rank(count);
    s.has_interval = k > 0;
    s.low = sorted[k > 0 ? k - 1 : 0];
    s.high = sorted[count - (k > 0 ? k : 1)];
    sc_free(sorted);
    *out = s;
    return SC_OK;
}

double sc_statistics_precision(const sc_statistics *statistics)
{
    if (!statistics->has_interval || !(statistics->median > 0))
        return INFINITY;
    return (statistics->high - statistics->low) / 2 / statistics->median;
}

double sc_karp_flatt(double speedup, double workers)
{
    return workers > 1 ? (1 / speedup - 1 / workers) / (1 - 1 / workers) : 0;
}

/* @return the next number of the generator splitmix64 (Steele, Lea and Flood 2014). */
static uint64_t next_random(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;

    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

void sc_random_order(uint64_t seed, int count, int *out)
{
    for (int i = 0; i < count; i++) { /* Fisher and Yates, from the inside out */
        const int j = (int)(next_random(&seed) % ((uint64_t)i + 1));

        out[i] = out[j];
        out[j] = i;
    }
}
