/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Values of JSON that come from a file, which may hold anything, and arrays and objects that are
 *  made. Any thread may call these functions. */
#ifndef SEGCAST_JSON_VALUES_H
#define SEGCAST_JSON_VALUES_H

#include "segcast/base.h"

#include <jansson.h>

/** The readers return false if the value is missing, of another type or out of range; @p out may be
 * written then, too. A whole number from @p low to @p high, which fit into @p out. */
bool sc_json_int(const json_t *value, json_int_t low, json_int_t high, int32_t *out);
/** A whole number that is not negative. */
bool sc_json_count(const json_t *value, uint64_t *out);
/** A number of at least @p low and below @p most. */
bool sc_json_real(const json_t *value, double low, double most, double *out);
/** 16 hexadecimal digits in lower case. */
bool sc_json_hash(const json_t *value, uint64_t *out);
/** @return a hash as these digits: JSON numbers cannot hold 64 bits exactly; NULL: no memory. */
json_t *sc_json_of_hash(uint64_t hash);

/** What a member of a struct is, and how it stands in JSON. */
typedef enum sc_json_kind {
    SC_JSON_BOOL,
    SC_JSON_INT,     /**< int32_t, not negative */
    SC_JSON_COUNT,   /**< uint64_t that JSON holds as a number */
    SC_JSON_TIME,    /**< int64_t, not negative */
    SC_JSON_SECONDS, /**< double, not negative */
    SC_JSON_REAL,    /**< double; -1: it was not measured */
    SC_JSON_HASH,    /**< uint64_t as 16 hexadecimal digits */
    SC_JSON_TEXT,    /**< char[bytes]; null: empty */
} sc_json_kind;
/** How a member of a struct is written to JSON and read from it: both use the same list. */
typedef struct sc_json_row {
    const char *key; /**< NULL ends a list */
    sc_json_kind kind;
    size_t offset, bytes;
} sc_json_row;
#define SC_JSON_ROW_AS(kind, key, type, member)                                                    \
    {                                                                                              \
        key, SC_JSON_##kind, offsetof(type, member), sizeof(((type *)NULL)->member)                \
    }
#define SC_JSON_ROW(kind, type, member) SC_JSON_ROW_AS(kind, #member, type, member)
/** @return the member of the struct at @p from, or an object of all rows; NULL: no memory. */
json_t *sc_json_of_row(const sc_json_row *row, const void *from);
json_t *sc_json_of_rows(const sc_json_row *rows, const void *from);
/** Read the member from its value, or all rows from an object. */
bool sc_json_read_row(const sc_json_row *row, const json_t *value, void *to);
bool sc_json_read_rows(const sc_json_row *rows, const json_t *object, void *to);

/** Append to an array; @p item and @p to are the function's, and NULL stands for no memory.
 *  @return @p to, or NULL once there was no memory. */
json_t *sc_json_with(json_t *to, json_t *item);
/** The same for a member of an object, which is set. */
json_t *sc_json_with_key(json_t *to, const char *key, json_t *item);

/** Append an object as text, and a line break, to @p out. @param json taken; NULL stands for no
 *  memory, as the errno ENOMEM does: jansson leaves out what it has no memory for. @param what is
 *  written, for the message. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_json_add_text(const sc_ctx *ctx, json_t *json, size_t flags,
                                       const char *what, sc_text *out);

#endif
