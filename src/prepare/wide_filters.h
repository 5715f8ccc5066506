/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to prepare: the filters of strong smoothing as tables, for wide_fields.c. The window
 * around a brick has 32 vertices along each axis. A row of it are four bytes, and tables hold the
 * sums for every pattern of one byte. */
#ifndef SC_PREPARE_WIDE_FILTERS_H
#define SC_PREPARE_WIDE_FILTERS_H

#include "filters.h"

enum {
    RADIUS = 14,                    /* the largest, in vertices */
    WINDOW = SC_BRICK + 2 * RADIUS, /* 32 */
    ROWS = WINDOW * WINDOW,
    TAPS = 2 * RADIUS + 1,
    CHUNK_BITS = 8, /* of a row that index a table together */
    CHUNKS = WINDOW / CHUNK_BITS,
    PATTERNS = 1 << CHUNK_BITS,
    /* weight filters: one for each kind of strength, and one that replaces it where tissue is thin
     */
    FILTERS_MAX = 2 * SC_SMOOTH_KINDS_MAX,
    /* normal filters: narrow, standard, and one for each kind of strength */
    NARROW = 0,
    STANDARD = 1,
    NORMALS_MAX = 2 + SC_SMOOTH_KINDS_MAX
};

typedef sc_quad quad;

/* A row of the window in which a filter for weights is not 0. */
typedef struct weight_row {
    int offset; /* rows of the window before it, for the brick's vertices at y = z = 0 */
    int table;  /* which table applies to it: rows at the same distance share one */
} weight_row;

/* A filter for weights. */
typedef struct weights {
    bool crisp;                  /* no filter: all weights are equal */
    int thin;                    /* the filter that replaces it where tissue is thin; -1: none */
    float gain;                  /* what margins are multiplied by */
    int first_chunk, last_chunk; /* those in which any tap is not 0 */
    int row_count, table_count;
    weight_row rows[TAPS * TAPS];     /* [row_count] of them */
    quad (*tables)[CHUNKS][PATTERNS]; /* [table_count], owned: sums of taps of four vertices */
} weights;

/* A filter for normals. */
typedef struct normals {
    int radius;
    quad (*table)[PATTERNS][2]; /* [CHUNKS], owned: smoothed value and derivative along x */
    float value[3][TAPS];       /* [2 * radius + 1] taps of the Gaussian along each axis */
    float slope[3][TAPS];       /* those of its derivative */
    float upright[3];           /* what the gradient along each axis is multiplied by so that it is
                                   a normal: see fill_normals */
} normals;

/* What the threads share. */
typedef struct filters {
    const sc_preparation *p; /* borrowed */
    weights
        weights[FILTERS_MAX]; /* [filter_count]: those of the kinds, then those of thin tissue */
    int filter_count;
    normals normals[NORMALS_MAX]; /* narrow, standard, then by kind; without table: not used */
    int reach;                    /* the largest radius of any filter */
    float flat; /* margin beside a flat border by strength 1, and of crisp tissue */
    double to_mm[3][3];
    uint8_t *crowded; /* [brick_count], borrowed; set to 1 for bricks left to fields.c */
} filters;

/* Write the margin, of 1, of the first vertex beside a flat border across each axis to @p margins,
 * and the sum of the values of the filter to @p total. */
void sc_flat_margins(const sc_weight_filter *w, double margins[3], double *total);
/* @return the margin beside a flat border: the largest share that a layer of vertices across one of
 * the axes has in a filter for weights. @param total the sum of all values of the filter. */
double sc_flat_margin(const sc_weight_filter *w, double *total);
/* Fill all of @p f but p, which must be set, the rest being zero. Returns SC_ERR_MEMORY; the caller
 * calls sc_wide_filters_clear in any case. */
sc_status sc_wide_filters_fill(const sc_ctx *ctx, filters *f);
/* Free the tables of @p f. */
void sc_wide_filters_clear(filters *f);

#endif
