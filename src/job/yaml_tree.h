/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: a YAML document as a tree that remembers lines. Stricter than YAML: one
 * document, no aliases, no doubled keys, bounded depth and size. */
#ifndef SC_JOB_YAML_TREE_H
#define SC_JOB_YAML_TREE_H

#include "segcast/base.h"

typedef enum sc_yaml_kind { SC_YAML_SCALAR, SC_YAML_MAP, SC_YAML_LIST } sc_yaml_kind;

typedef struct sc_yaml {
    sc_yaml_kind kind;
    int line;           /* from 1; 0: not from a file */
    const char *origin; /* file, or option: borrowed */
    char *key;          /* in a map */
    char *text;         /* scalar */
    struct sc_yaml **items;
    size_t count, capacity;
} sc_yaml;

/* Parse @p text, calling its source @p origin. Caller owns: sc_yaml_free.
 * SC_ERR_DATA with origin:line. An empty text gives an empty map. */
sc_status sc_yaml_parse(const sc_ctx *ctx, const char *origin, const char *text, size_t bytes,
                        sc_yaml **out);
void sc_yaml_free(sc_yaml *node);
/* Member of a map, or NULL. */
sc_yaml *sc_yaml_member(const sc_yaml *map, const char *key);
/* Set "key.path" to @p value in the tree, making maps on the way; takes the value over, also on
 * failure. A path element may be quoted: tissues."left atrium".opacity */
sc_status sc_yaml_set(const sc_ctx *ctx, sc_yaml *root, const char *path, sc_yaml *value);
/* Log "origin:line: text". */
sc_status sc_yaml_fail(const sc_ctx *ctx, const sc_yaml *node, const char *fmt, ...)
    SC_PRINTF(3, 4);

#endif
