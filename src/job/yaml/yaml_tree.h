/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: a YAML document as a tree of nodes that know their line in the file. Stricter
 * than YAML: one document, no aliases, no key twice in a map, bounded depth and number of nodes. */
#ifndef SC_JOB_YAML_TREE_H
#define SC_JOB_YAML_TREE_H

#include "segcast/base.h"

/* The kinds of nodes. */
typedef enum sc_yaml_kind { SC_YAML_SCALAR, SC_YAML_MAP, SC_YAML_LIST } sc_yaml_kind;

/* A node of the tree. It owns its key, its text and its items. */
typedef struct sc_yaml {
    sc_yaml_kind kind;
    int line;               /* line in the file, from 1; 0: the node is not from a file */
    const char *origin;     /* name of the file or setting, for messages; borrowed */
    char *key;              /* of a node in a map; else NULL */
    char *text;             /* of a scalar; NULL only for one that was added by sc_yaml_add */
    struct sc_yaml **items; /* of a map or list: [count] */
    size_t count, capacity;
    const struct sc_clock *clock; /* by which it is read, if it is a time; borrowed */
    struct json_t *index;         /* of a map: finds the number of a member by its key; else NULL */
    bool quoted;                  /* a scalar stood in quotes, or as a block of text */
    bool key_told;                /* its key is unknown, and this was logged already */
    bool key_left_out;            /* of a root: see sc_yaml_parse */
} sc_yaml;

/* Parse @p text, which messages call @p origin. Caller owns: sc_yaml_free. An empty text gives an
 * empty map. Of a key that a map has twice the first stays; the others, and keys behind which a
 * colon is missing, are logged, and out->key_left_out is set: then the tree may be searched for
 * further mistakes, but not be used.
 * @return SC_ERR_DATA, logged as "origin:line: why" or "origin:line:column: why". */
sc_status sc_yaml_parse(const sc_ctx *ctx, const char *origin, const char *text, size_t bytes,
                        sc_yaml **out);
/* Make a scalar without a line. @p text is copied, @p origin borrowed. Caller owns: sc_yaml_free.
 */
sc_status sc_yaml_scalar(const sc_ctx *ctx, const char *origin, const char *text, sc_yaml **out);
/* Free a node and all below it; NULL is allowed. */
void sc_yaml_free(sc_yaml *node);
/* The same at the address of the pointer. For SC_OWN. */
static inline void sc_yaml_free_at(sc_yaml **node)
{
    sc_yaml_free(*node);
}
/* @return the member of that key; NULL if there is none, or @p map is no map. */
sc_yaml *sc_yaml_member(const sc_yaml *map, const char *key);
/* @return the index of that member; map->count if there is none, or @p map is no map. */
size_t sc_yaml_index(const sc_yaml *map, const char *key);
/* @return item @p i of @p list, or @p list itself if it is a scalar, which stands for a list of
 * one; with the key of the list, for messages. It owns nothing. */
static inline sc_yaml sc_yaml_item(const sc_yaml *list, size_t i)
{
    sc_yaml item = list->kind == SC_YAML_SCALAR ? *list : *list->items[i];

    item.key = list->key;
    return item;
}
/* @return how many items sc_yaml_item has. */
static inline size_t sc_yaml_length(const sc_yaml *list)
{
    return list->kind == SC_YAML_SCALAR ? 1 : list->count;
}
/* Copy a node with all below it. Its origin stays borrowed. Caller owns *out: sc_yaml_free. */
sc_status sc_yaml_copy(const sc_ctx *ctx, const sc_yaml *node, sc_yaml **out);
/* Append to a map or list; takes ownership of @p child, also after an error. */
sc_status sc_yaml_append(const sc_ctx *ctx, sc_yaml *parent, sc_yaml *child);
/* Append an empty node without a line. @p key is copied; NULL in a list. @p origin is borrowed. */
sc_status sc_yaml_add(const sc_ctx *ctx, sc_yaml *parent, sc_yaml_kind kind, const char *key,
                      const char *origin);
/* Remove and free an item of a map or list. */
void sc_yaml_remove(sc_yaml *parent, size_t index);
/* Log "origin:line: text". @return SC_ERR_DATA for a node of a file, SC_ERR_USAGE for one of a
 * setting (without a line). */
sc_status sc_yaml_fail(const sc_ctx *ctx, const sc_yaml *node, const char *fmt, ...)
    SC_PRINTF(3, 4);

#endif
