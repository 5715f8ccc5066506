/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: how the label table of a job and the voxels of its volume agree. */
#ifndef SC_COMMANDS_LABEL_REPORT_H
#define SC_COMMANDS_LABEL_REPORT_H

#include "commands.h"

/* Some labels, in rising order of their values; of a table or a volume, which are borrowed. */
typedef struct sc_label_list {
    const sc_label **labels; /* [count] */
    size_t count;
} sc_label_list;

/* Numbers from @c first to @c last, of which a table has none though it has smaller and larger
 * ones. */
typedef struct sc_label_gap {
    int64_t first, last;
} sc_label_gap;

typedef struct sc_label_report {
    const sc_label_source *source;
    sc_label_list doubled; /* values that have several rows: the first of each, which holds */
    sc_label_list without_voxels; /* rows of values that no voxel has */
    sc_label_list without_row;    /* labels of voxels that no row names */
    void *owned;                  /* what the lists lie in; NULL: there is no table */
    sc_label_gap *gaps;           /* [gap_count], rising; owned */
    size_t gap_count;
} sc_label_report;

/* Compare a label table with the labels of a volume, background aside. @param source and @p volume
 * must outlive the report. @param scanned whether the voxels were counted and the labels are those
 * of the file; if not, only rows of one value and gaps are found. @return SC_ERR_MEMORY. Caller
 * owns *out: sc_label_report_clear. */
sc_status sc_label_report_make(const sc_ctx *ctx, const sc_label_source *source,
                               const sc_prepared *volume, bool scanned, sc_label_report *out);
void sc_label_report_clear(sc_label_report *report);
/* Print the name of the table and the lists that are not empty; nothing if there is no table. */
void sc_label_report_print(const sc_label_report *report, FILE *stream);
/* @return the same as an object of JSON, with whole lists; null of JSON if there is no table; NULL
 * without memory. Caller owns. */
json_t *sc_label_report_json(const sc_label_report *report);

#endif
