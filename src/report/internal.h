/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to report. Files call only functions of files that are named further down here: run.c,
 * study_compare.c, study.c, study_markdown.c, study_view.c (study_view.h), activity.c, frames.c,
 * heat.c, json.c. Functions that return JSON return a new reference, NULL
 * without memory, which json_pack and sc_json_set pass on. */
#ifndef SC_REPORT_INTERNAL_H
#define SC_REPORT_INTERNAL_H

#include "segcast/core_time.h"
#include "segcast/json_values.h"
#include "segcast/report.h"

#include <jansson.h>

enum { SC_REPORT_PATH_BYTES = 4096 };

/* ---- activity.c, frames.c, heat.c: what the page of a run has of them ---- */

/* Set `activity` to what each thread did when, from the trace under @p path, or to why there is
 * none. */
sc_status sc_report_activity(const sc_ctx *ctx, const char *path, const sc_run_stats *stats,
                             json_t *data);
/* Set `cost`, `dots` and `pictures`: what the frames cost along the film, and some of them. */
sc_status sc_report_frames(const sc_ctx *ctx, const sc_report_run *run, const sc_run_stats *stats,
                           json_t *data);
/* Set `heat` to the work of each pixel of a frame, if it is known. */
sc_status sc_report_heat(const sc_ctx *ctx, const sc_heat *heat, json_t *data);

/* ---- json.c ---- */

/* @return a text as sc_printable shows it. */
json_t *sc_json_text(const char *text);
/* @return a number, or null if it is not finite. */
json_t *sc_json_number(double value);

/* Set a member of @p data; @p value is the function's. @return SC_ERR_MEMORY also if one of them is
 * NULL. */
sc_status sc_json_set(const sc_ctx *ctx, json_t *data, const char *key, json_t *value);
/* @return the seconds of each cause, and of all cores. */
json_t *sc_json_core_time(const sc_core_time *time);
/* Make a PNG file of a picture, in base 64. Caller owns *out. */
sc_status sc_json_png(const sc_ctx *ctx, const sc_image *image, json_t **out);
/* Set `settings` to the text of the file @p settings in the directory, and `files` to those of
 * @p names [count] that are there. */
sc_status sc_json_sources(const sc_ctx *ctx, const char *directory, const char *settings,
                          const char *const *names, size_t count, json_t *data);
/* Make the page that draws @p data. */
sc_status sc_json_page(const sc_ctx *ctx, const json_t *data, sc_text *out);

#endif
