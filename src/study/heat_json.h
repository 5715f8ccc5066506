/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to study: the object `heat` of stats.json. */
#ifndef SC_STUDY_HEAT_JSON_H
#define SC_STUDY_HEAT_JSON_H

#include "segcast/study.h"

#include <jansson.h>

/* @return a new reference to the object, or to null for none, which the caller owns; NULL: no
 * memory. */
json_t *sc_heat_to_json(const sc_heat *heat);
/* Read the object; NULL and null are none, and leave @p out as it is. @param good set to false if
 * it is damaged. @return SC_ERR_MEMORY. Caller owns *out: sc_heat_clear. */
sc_status sc_heat_from_json(const sc_ctx *ctx, const json_t *json, sc_heat *out, bool *good);

#endif
