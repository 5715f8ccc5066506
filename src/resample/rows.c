/* SPDX-License-Identifier: BSD-3-Clause */
/* Filters over rows of bits, by tables. */
#include "rows.h"

#include <math.h>

enum {
    TAPS = 2 * ROW_REACH + 1, /* voxels of a row that a filter reaches */
    LOW_BITS = (TAPS + 1) / 2,
    HIGH_BITS = TAPS - LOW_BITS,
    LOW_PATTERNS = 1 << LOW_BITS,
    HIGH_PATTERNS = 1 << HIGH_BITS,
    ROW_PATTERNS = LOW_PATTERNS + HIGH_PATTERNS
};

/* Fill the sums of all patterns of @p bits taps. */
static void fill_half(float *sums, int bits, const double *taps)
{
    sums[0] = 0;
    for (int pattern = 1; pattern < 1 << bits; pattern++) {
        double sum = 0;

        for (int i = 0; i < bits; i++)
            sum += pattern >> i & 1 ? taps[i] : 0;
        sums[pattern] = (float)sum;
    }
}

/* @return the table of the rows at a squared distance, which is appended to @p squares [*count] if
 * it is new. */
static int table_of(double *squares, int *count, double square)
{
    for (int i = 0; i < *count; i++) {
        if (fabs(squares[i] - square) < 1e-9)
            return i;
    }
    squares[*count] = square;
    return (*count)++;
}

sc_status sc_row_filter_make(const sc_ctx *ctx, row_weight_fn *weight, double width, double reach,
                             const double steps[3], double factor, row_filter *out)
{
    double squares[TAPS * TAPS];
    void *block;
    sc_status status;

    SC_TRY(sc_alloc(ctx, TAPS * TAPS, sizeof *out->taps, &block));
    out->taps = block;
    for (int dz = -ROW_REACH; dz <= ROW_REACH; dz++) {
        for (int dy = -ROW_REACH; dy <= ROW_REACH; dy++) {
            const double y = dy * steps[1], z = dz * steps[2], square = y * y + z * z;

            if (square > reach * reach)
                continue;
            out->taps[out->tap_count++] = (struct row_tap){
                (int8_t)dy, (int8_t)dz, (uint16_t)table_of(squares, &out->table_count, square)};
        }
    }
    SC_TRY(sc_alloc(ctx, (size_t)out->table_count * ROW_PATTERNS, sizeof(float), &block));
    out->sums = block;
    for (int t = 0; t < out->table_count; t++) {
        float *sums = out->sums + (size_t)t * ROW_PATTERNS;
        double taps[TAPS];

        for (int i = 0; i < TAPS; i++) {
            const double x = (i - ROW_REACH) * steps[0], square = squares[t] + x * x;

            taps[i] = square > reach * reach ? 0 : factor * weight(square, x, width);
        }
        fill_half(sums, LOW_BITS, taps);
        fill_half(sums + LOW_PATTERNS, HIGH_BITS, taps + LOW_BITS);
    }
    status = SC_OK;
out:
    return status;
}

void sc_row_filter_clear(row_filter *f)
{
    sc_free(f->taps);
    sc_free(f->sums);
    *f = (row_filter){0};
}

/* @return the sum of one row. @param bits those of the window's row, from the first tap on. */
static inline float row_sum(const row_filter *f, const struct row_tap *tap, uint32_t bits)
{
    const float *sums = f->sums + (size_t)tap->table * ROW_PATTERNS;

    return sums[bits & (LOW_PATTERNS - 1)] +
           sums[LOW_PATTERNS + (bits >> LOW_BITS & (HIGH_PATTERNS - 1))];
}

/* @return the bits of the row of a tap, for a voxel of the block. */
static inline uint32_t row_bits(const struct row_tap *tap, const uint32_t *window, int x, int y,
                                int z)
{
    return window[(z + ROW_REACH + tap->dz) * ROW_WINDOW + y + ROW_REACH + tap->dy] >> x;
}

float sc_row_filter_sum(const row_filter *f, const uint32_t window[ROW_COUNT], int x, int y, int z)
{
    float sum = 0;

    for (int i = 0; i < f->tap_count; i++)
        sum += row_sum(f, &f->taps[i], row_bits(&f->taps[i], window, x, y, z));
    return sum;
}

void sc_row_filter_moments(const row_filter *f, const uint32_t window[ROW_COUNT], int x, int y,
                           int z, float along[2])
{
    along[0] = along[1] = 0;
    for (int i = 0; i < f->tap_count; i++) {
        const struct row_tap *tap = &f->taps[i];
        const float sum = row_sum(f, tap, row_bits(tap, window, x, y, z));

        along[0] += tap->dy * sum;
        along[1] += tap->dz * sum;
    }
}
