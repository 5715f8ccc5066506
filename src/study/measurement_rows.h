/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to study: the members of sc_measurement with the names under which they are written, so
 * that writing, reading and tables walk one list. */
#ifndef SC_STUDY_MEASUREMENT_ROWS_H
#define SC_STUDY_MEASUREMENT_ROWS_H

#include "segcast/measurements.h"

typedef enum sc_row_type {
    SC_ROW_INT,     /* int32_t */
    SC_ROW_COUNT,   /* uint64_t that JSON holds as a number */
    SC_ROW_SECONDS, /* double, not negative */
    SC_ROW_REAL,    /* double */
    SC_ROW_TIME,    /* int64_t */
    SC_ROW_HASH     /* uint64_t as 16 hexadecimal digits */
} sc_row_type;

typedef struct sc_measurement_row {
    const char *name; /* NULL ends the list */
    sc_row_type type;
    size_t offset;
} sc_measurement_row;
extern const sc_measurement_row sc_measurement_rows[];

/* The texts of sc_study_run. */
typedef struct sc_run_text {
    const char *name; /* NULL ends the list */
    size_t offset, bytes;
} sc_run_text;
extern const sc_run_text sc_run_texts[];

#endif
