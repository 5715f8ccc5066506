/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: walking the table of keys, and the documents made of it. */
#ifndef SC_JOB_DESCRIBE_H
#define SC_JOB_DESCRIBE_H

#include "key.h"
#include "segcast/job.h"

/* One row on a walk through the table; borrowed for the call. */
typedef struct sc_key_visit {
    const char *path; /* see sc_key_info.path */
    const sc_key *key;
    int depth; /* 0 for the keys of the file itself */
} sc_key_visit;
typedef sc_status sc_key_visitor(const sc_ctx *ctx, void *user, const sc_key_visit *visit);
/* Call @p visitor for all rows in order, a map before its keys. @return its first error, which ends
 * the walk. */
sc_status sc_keys_walk(const sc_ctx *ctx, sc_key_visitor *visitor, void *user);

/* Write the name of the environment variable of a key, such as SEGCAST_OUTPUT_SIZE. Keys of tissues
 * have none, and get an empty text. */
void sc_key_variable(const char *path, char *name, size_t size);

/* Append to @p text which values a row takes, such as "number from 0 to 1" or "leap, interior or
 * none". */
sc_status sc_key_values(const sc_ctx *ctx, const sc_key *key, sc_text *text);
/* For listings: "(required)", the default, or what happens without the key; an empty text where the
 * table says none of these, as for most maps. Keys of which one is required are "(one of these)".
 */
const char *sc_key_default(const sc_key *key);

/* ---- document.c ---- */

/* Append docs/job.md, or segcast-job(5), to @p out. @return SC_ERR_MEMORY. */
sc_status sc_keys_markdown(const sc_ctx *ctx, sc_text *out);
sc_status sc_keys_man(const sc_ctx *ctx, sc_text *out);

#endif
