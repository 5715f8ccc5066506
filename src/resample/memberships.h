/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoothed memberships of the labels of a stack of slices. The membership of a label is 1 where
 * voxels carry it and 0 elsewhere; all labels' together are 1 everywhere, smoothed or not. */
#ifndef SEGCAST_RESAMPLE_MEMBERSHIPS_H
#define SEGCAST_RESAMPLE_MEMBERSHIPS_H

#include "segcast/volume.h"

/* How many Gaussians the filter is made of: 1 - (1 - G)^3 = 3 G - 3 G^2 + G^3, a flat-topped
 * low-pass. A single Gaussian would move curved surfaces inward. */
enum { GAUSSIANS = 4 };

/* A stack of slices. Memberships are smoothed across it on nodes, the middles of blocks of pixels,
 * which suffice as they are much finer than the filter. The ids are owned. */
typedef struct stack {
    int size[3];       /* pixels along x and y, slices */
    double step_mm[3]; /* widths of a pixel, distance of slices */
    uint16_t *ids;     /* [z][y][x] */
    int block[2];      /* pixels of a block along x and y */
    int nodes[2];      /* blocks along x and y; the last may be cut off */
    int radius[2];     /* of the taps, in nodes */
    float *taps[2];    /* [2 radius + 1] of a Gaussian across the nodes, owned */
    double width;      /* standard deviation of the Gaussian, in slices */
} stack;

/* The memberships of a label across the slices, smoothed within each by one to four Gaussians, and
 * not yet along the stack. They are 0 outside of the box. */
typedef struct memberships {
    int id;
    int low[3], high[3]; /* box: nodes along x and y, slices; inclusive */
    float *values;       /* [z][GAUSSIANS][y][x] within the box, owned */
} memberships;

/* Set up the filters of a stack whose size and steps are known. @param width standard deviation of
 * the Gaussian, in slices; the same in mm across the slices. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_stack_set_filter(const sc_ctx *ctx, stack *s, double width);
/* Free what a stack owns, and set it to zero. */
void sc_stack_clear(stack *s);

/* Smooth the memberships of all labels but the background of a stack. @param out receives one for
 * each label that occurs; caller owns it, even after an error: sc_memberships_free. @return
 * SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_memberships_find(const sc_ctx *ctx, const stack *s, int label_count,
                                          int threads, memberships **out, int *count);
/* Free @p count memberships; NULL is allowed. */
void sc_memberships_free(memberships *all, int count);

enum { SLICE_REACH = 6 }; /* how many slices on either side the filter along the stack reaches */
/* Weights of the slices around one for a plane of the stack, for each power of the Gaussian. */
typedef struct plane_taps {
    float weight[GAUSSIANS][2 * SLICE_REACH + 1];
} plane_taps;
/* @return the taps of the plane @p offset slices behind a slice, from -0.5 to 0.5. */
plane_taps sc_plane_taps_of(const stack *s, double offset);

/* Write the memberships of a label in the plane that the taps give, near slice @p z, to @p out:
 * [nodes y][nodes x] of its box. */
void sc_memberships_in_plane(const memberships *m, const stack *s, const plane_taps *taps, int z,
                             float *out);

#endif
