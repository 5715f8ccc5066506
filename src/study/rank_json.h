/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to study: the object `per_rank` of stats.json, what each rank has measured. It holds one
 * array for each measure and not one object for each rank, so that it stays small with many ranks.
 */
#ifndef SC_STUDY_RANK_JSON_H
#define SC_STUDY_RANK_JSON_H

#include "segcast/study.h"

#include <jansson.h>

/* @return a new reference to the object, which the caller owns; NULL: no memory. */
json_t *sc_ranks_to_json(const sc_rank_record *ranks, int count);
/* Read the object into @p ranks [count], but for hosts and peak_rss_bytes. @return false, with some
 * of them read, if a value is missing, of another type or out of range. */
bool sc_ranks_from_json(const json_t *json, sc_rank_record *ranks, int count);

#endif
