/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Tables of values: a number for each tissue, such as a measured thickness, as statistics programs
 *  and spreadsheets write them. */
#ifndef SEGCAST_VALUE_TABLE_H
#define SEGCAST_VALUE_TABLE_H

#include "segcast/volume.h"

/** A line of a table of values. */
typedef struct sc_value_row {
    const char *name; /**< of the tissue; empty: the line has none. Borrowed from the table */
    bool has_number;  /**< number is that of the label */
    int64_t number;
    double value; /**< NAN: missing */
    int line;     /**< of the file, counted from 1 */
} sc_value_row;

/** The lines of a table of values, in the order of the file. Zero-initialise; sc_value_table_clear
 *  frees. */
typedef struct sc_value_table {
    char *text;         /**< of the file, in which the names lie; owned */
    sc_value_row *rows; /**< [capacity], the first count of which are used; owned */
    size_t count, capacity;
    char column[SC_NAME_BYTES]; /**< heading of the column of the values */
} sc_value_table;
/** Free what the table owns and set it to zero. */
void sc_value_table_clear(sc_value_table *table);
/** Read the values of one column of a text of at most 64 MiB, with a line of headings, whose fields
 *  are separated by commas, semicolons or tabs, in UTF-8, UTF-16 with byte order mark, or Latin-1.
 *  The number or the name of the tissue stands in a column with a heading as those of label tables
 *  (SC_TABLE_DELIMITED). Empty fields, and "n/a", "NA", "NaN", "none", "null" and "-", are missing
 *  values. Lines without number and name are left out, with a warning.
 *  @param column heading of the values, in which ASCII case is ignored; empty: the only column that
 *  is none of a label table. @return SC_ERR_MISSING; SC_ERR_DATA, logged with the line, for a file
 *  that is no such text, a column that is not there (with those that are), a value that is no
 *  number, or too many rows; SC_ERR_MEMORY. Caller owns *out: sc_value_table_clear. */
SC_MUST_USE sc_status sc_value_table_read(const sc_ctx *ctx, const char *path, const char *column,
                                          sc_value_table *out);

#endif
