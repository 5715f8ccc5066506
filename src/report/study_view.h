/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to report: a study as its pages see it. */
#ifndef SC_REPORT_STUDY_VIEW_H
#define SC_REPORT_STUDY_VIEW_H

#include "internal.h"
#include "segcast/measurements.h"

/* Longest name of a cell, terminator included; what does not fit is cut off. */
enum { SC_CELL_NAME_BYTES = 300 };

/* A study with the results of its cells. Zero-initialise; sc_study_view_clear. */
typedef struct sc_study_view {
    const sc_measurements *m; /* borrowed */
    sc_cell_result *cells;    /* [count], owned */
    int count, measured;      /* cells, and those of them that have measurements */
    int series; /* the axis whose values are compared, such as render.skip; -1: none has several */
    int scale;  /* the axis ranks or threads, if it has several values; -1 */
} sc_study_view;

/* Work out the results. @return SC_ERR_MEMORY. Caller owns *out. */
sc_status sc_study_view_open(const sc_ctx *ctx, const sc_measurements *m, sc_study_view *out);
void sc_study_view_clear(sc_study_view *view);

/* @return whether the cell has measurements. */
bool sc_study_has(const sc_study_view *view, int cell);
/* @return the cell that differs from @p cell at most in that it has the value @p value of an axis.
 */
int sc_study_with(const sc_study_view *view, int cell, int axis, int value);
/* @return whether @p cell is the first one of those that differ only in the values of an axis.
 * @param axis -1: each cell is. */
bool sc_study_is_first(const sc_study_view *view, int cell, int axis);
/* @return the time that has to be known exactly in this study, of a pass over all frames. */
const sc_statistics *sc_study_time(const sc_study_view *view, int cell);
/* @return its median for a frame, in seconds. */
double sc_study_frame_s(const sc_study_view *view, int cell);
/* @return what that time is, such as "CPU seconds a frame"; static. */
const char *sc_study_unit(const sc_study_view *view);

/* Write what tells a cell from others: its values of all axes with several values, with the name of
 * the axis before a number. @param without an axis that is left out; -1: none. Without any such
 * axis: @p alone. */
void sc_study_name(const sc_study_view *view, int cell, int without, const char *alone,
                   char text[SC_CELL_NAME_BYTES]);

/* Times of the paper for its heart of 469 x 325 x 487 voxels (table 1), in seconds. */
#define SC_PAPER_PLAIN_S 3.3
#define SC_PAPER_ACCELERATED_S 2.1
/* @return whether the study compares the two methods of the paper. */
bool sc_study_has_paper(const sc_study_view *view);

#endif
