/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to prepare: the gradients of the smoothed membership of one label at the vertices of a
 * brick, with variants for the vector units of processors, which give the same bits. */
#ifndef SC_PREPARE_GRADIENTS_H
#define SC_PREPARE_GRADIENTS_H

#include "filters.h"

enum {
    SC_FIELD_RADIUS = 6, /* of the filters of fields.c, in vertices */
    SC_FIELD_TAPS = 2 * SC_FIELD_RADIUS + 1,
    /* edge of the block of vertices that a brick depends on, its window: 16 */
    SC_FIELD_WINDOW = SC_BRICK + 2 * SC_FIELD_RADIUS,
    SC_FIELD_ROWS = SC_FIELD_WINDOW * SC_FIELD_WINDOW,
    SC_FIELD_PATTERNS = 1 << SC_FIELD_WINDOW /* of the bits of a row */
};

/* A filter for normals: a Gaussian and its derivative, scaled so that the gradient at a flat
 * interface has length 1. */
typedef struct sc_normal_filter {
    sc_quad (*table)[2]; /* [SC_FIELD_PATTERNS], owned: a row's smoothed value and derivative along
                            x, at the brick's four vertices */
    float value[3][SC_FIELD_TAPS]; /* taps of the Gaussian along each axis, of sum 1 */
    float slope[3][SC_FIELD_TAPS]; /* taps of its derivative along each axis */
} sc_normal_filter;

/* The gradients in a brick, and what they are made from. */
typedef struct sc_gradients {
    sc_quad value[SC_FIELD_ROWS], along_x[SC_FIELD_ROWS]; /* [z][y]: rows filtered along x */
    /* [z][y]: those filtered along y, too; by y_slope, that is by the derivative */
    sc_quad flat[SC_FIELD_WINDOW][SC_BRICK], x_slope[SC_FIELD_WINDOW][SC_BRICK],
        y_slope[SC_FIELD_WINDOW][SC_BRICK];
    float along[3][SC_BRICK_VERTICES]; /* the result, by axis of the grid and by bit of the brick,
                                          per reference voxel */
} sc_gradients;

/* Find the gradients in those layers z of the brick that hold vertices of @p mask, which is not
 * empty; others are not written. @param bits which vertices of a row of the window carry the label,
 * [z][y], bit x. Thread-safe. */
typedef void sc_gradients_fn(const sc_normal_filter *f, const uint32_t bits[SC_FIELD_ROWS],
                             uint64_t mask, sc_gradients *out);

/* Is there a variant for AVX2 in this build? Others need the vectors of quads alone. */
#if defined(__x86_64__) && defined(__GNUC__)
#define SC_GRADIENTS_AVX2
#endif
sc_gradients_fn sc_find_gradients_plain, sc_find_gradients_avx2;

/* @return variant @p n of the function, which differ only in their speed, from 0, which any
 * processor can run; NULL if this one cannot, or if there are not so many. */
sc_gradients_fn *sc_gradients_variant(size_t n);
/* @return the fastest variant that this processor can run. */
sc_gradients_fn *sc_gradients_fastest(void);

#endif
