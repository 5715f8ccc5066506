/* SPDX-License-Identifier: BSD-3-Clause */
/* Signed distances of the pixels of slices from the borders of labels: how far a pixel is, within
 * its slice, from where the label begins (positive) or, if it carries the label, ends (negative).
 */
#ifndef SEGCAST_RESAMPLE_DISTANCES_H
#define SEGCAST_RESAMPLE_DISTANCES_H

#include "segcast/volume.h"

/* A stack of slices. The ids are owned. */
typedef struct stack {
    int size[3];   /* pixels along x and y, slices */
    float step[2]; /* widths of a pixel along x and y, in distances of slices */
    uint16_t *ids; /* [z][y][x] */
} stack;

/* Where distances from the border of a label are measured: the smallest box of pixels that holds
 * all voxels of it, and a margin beyond which it does not matter. */
typedef struct label_box {
    int id;
    int low[3], high[3]; /* pixels along x and y with the margin, slices without; inclusive */
    size_t at;           /* where its values begin in those of a slice */
} label_box;

/* The distances in several successive slices, in distances of slices. */
typedef struct distances {
    const stack *s;   /* borrowed */
    label_box *boxes; /* [count], those labels that occur, rising; owned */
    int count;
    int slots;      /* how many slices are held: slice z in slot z modulo this */
    int end;        /* slices before this one have been measured */
    size_t room;    /* values of a slice */
    float *values;  /* [slots][room], of each label [y][x] within its box; owned */
    float *scratch; /* [threads][3][size x], owned */
    int threads;
} distances;

/* Stands for "there is no border in the slice". */
#define NO_BORDER 1e9f

/* Set up distances, none of them measured yet, of all labels of a stack. @param s is borrowed until
 * the end. @param voxels [label_count] the boxes of the labels in the stack. @param slots how many
 * slices are to be held. @return SC_ERR_MEMORY; call sc_distances_clear even then. */
SC_MUST_USE sc_status sc_distances_open(const sc_ctx *ctx, const stack *s,
                                        const sc_label_tally *voxels, int label_count, int slots,
                                        int threads, distances *d);
/* @return how many bytes distances take. Of the stack only size and steps are needed. */
double sc_distances_bytes(const stack *s, const sc_label_tally *voxels, int label_count, int slots,
                          int threads);
/* Free what distances own, and set them to zero. */
void sc_distances_clear(distances *d);

/* Measure the distances in the slices that follow the last measured, up to but without @p end. They
 * take the place of the oldest. */
void sc_distances_measure(distances *d, int end);

/* @return the distances from the border of a label in row @p y, within its box, of slice @p z,
 * which is held: [high x - low x + 1]. A slice that does not hold the label has NO_BORDER. */
const float *sc_distances_row(const distances *d, const label_box *box, int z, int y);

#endif
