/* SPDX-License-Identifier: BSD-3-Clause */
/* Filters over a window of voxels of which each either carries a label or does not. A row of the
 * window is a word whose bits tell which of its voxels do. Tables hold the weighted sum for every
 * pattern of bits of half a row, so that a sum over a ball takes two look-ups a row. */
#ifndef SEGCAST_RESAMPLE_ROWS_H
#define SEGCAST_RESAMPLE_ROWS_H

#include "segcast/base.h"

enum {
    ROW_REACH = 9,                          /* voxels that filters reach to either side */
    ROW_BLOCK = 8,                          /* edge of the block of voxels that a window serves */
    ROW_WINDOW = ROW_BLOCK + 2 * ROW_REACH, /* edge of the window: at most 32 */
    ROW_COUNT = ROW_WINDOW * ROW_WINDOW     /* words of a window, [z][y] */
};

/* A filter. Lengths are in steps of the finest axis. The arrays are owned. */
typedef struct row_filter {
    struct row_tap {
        int8_t dy, dz;  /* of the row, from the voxel that is filtered for */
        uint16_t table; /* rows at the same distance share a table */
    } * taps;
    int tap_count, table_count;
    float *sums; /* [table_count][ROW_PATTERNS]: for the two halves of a row one after the other */
} row_filter;

/* The weight of a voxel at a squared distance, and with the distance @p x along the rows. */
typedef double row_weight_fn(double square, double x, double width);

/* Make the filter of a weight function, which gets @p width. @param reach beyond it weights are 0,
 * at most ROW_REACH. @param steps lengths of a voxel along the axes, at least 1. @param factor what
 * all weights are multiplied with. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_row_filter_make(const sc_ctx *ctx, row_weight_fn *weight, double width,
                                         double reach, const double steps[3], double factor,
                                         row_filter *out);
/* Free what a filter owns. */
void sc_row_filter_clear(row_filter *f);

/* @return the weighted sum of the voxels around (x, y, z) of the block whose bits are set in
 * @p window. */
float sc_row_filter_sum(const row_filter *f, const uint32_t window[ROW_COUNT], int x, int y, int z);
/* Write the sums with weights further multiplied by the row's dy and by its dz to @p along. */
void sc_row_filter_moments(const row_filter *f, const uint32_t window[ROW_COUNT], int x, int y,
                           int z, float along[2]);

#endif
