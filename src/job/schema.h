/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: tables that say what keys a map may hold, of what type, and where they go. One
 * table reads a job file, checks it, and writes it as resolved. */
#ifndef SC_JOB_SCHEMA_H
#define SC_JOB_SCHEMA_H

#include "yaml_tree.h"

typedef struct sc_field sc_field;

typedef struct sc_field_type {
    const char *expected; /* for messages */
    sc_status (*parse)(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to);
    /* Write the value (not the key) as YAML in one line; for nested maps indent is used. */
    sc_status (*write)(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                       sc_text *text);
    /* NULL, or: is there nothing to write? */
    bool (*absent)(const sc_field *field, const void *from);
} sc_field_type;

struct sc_field {
    const char *name; /* NULL ends a table */
    const sc_field_type *type;
    size_t offset;              /* into the struct of the table */
    double low, high;           /* numbers: range; text: high = size of the buffer */
    const char *const *choices; /* NULL-terminated */
    const sc_field *fields;     /* nested map */
    bool aside;                 /* does not change the pictures: left out of the job's hash */
};

extern const sc_field_type sc_type_bool, sc_type_int, sc_type_real, sc_type_text, sc_type_choice,
    sc_type_color, sc_type_size, sc_type_point, sc_type_direction, sc_type_map;

/* Read all keys of @p node into @p to; unknown keys are errors with the nearest name. Values are
 * written as they are read: on failure @p to is half filled. */
sc_status sc_fields_parse(const sc_ctx *ctx, const sc_field *fields, const sc_yaml *node, void *to);
/* Write "key: value" lines. @p identity: only what changes the pictures. */
sc_status sc_fields_write(const sc_ctx *ctx, const sc_field *fields, const void *from, int indent,
                          bool identity, sc_text *text);

/* Write "{key: value, ...}" in one line. */
sc_status sc_fields_write_flow(const sc_ctx *ctx, const sc_field *fields, const void *from,
                               sc_text *text);

/* Building blocks for further types. */
sc_status sc_parse_real(const sc_ctx *ctx, const sc_yaml *node, double low, double high,
                        double *out);
sc_status sc_wrong_type(const sc_ctx *ctx, const sc_yaml *node, const char *expected);
sc_status sc_unknown_word(const sc_ctx *ctx, const sc_yaml *node, const char *word,
                          const char *const *words, size_t count);

#endif
