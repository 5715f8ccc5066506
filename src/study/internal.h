/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to study: histories and measurements. */
#ifndef SC_STUDY_INTERNAL_H
#define SC_STUDY_INTERNAL_H

#include "segcast/json_values.h"
#include "segcast/measurements.h"
#include "segcast/study.h"

#include <jansson.h>
#include <time.h>

/* The members of measurements and of runs that a study writes to its file. */
extern const sc_json_row sc_measurement_rows[], sc_study_run_rows[];
/* How runs stand in stats.json, but for their hosts and what they were made from; and frames:
 * first what is known of each, then what was measured. */
extern const sc_json_row sc_run_entry_rows[], sc_frame_rows[], sc_measured_rows[];
/* The members of sc_run_record that tell of memory. */
extern const sc_json_row sc_memory_rows[];

/* The name of the format of stats.json. */
#define SC_STATS_SCHEMA "segcast-stats-1"

/* Allocate both arrays of @p out, the runs zeroed, for so many runs and frames; the counts are left
 * as they are. After an error, too, sc_history_clear frees them. @return SC_ERR_MEMORY. */
sc_status sc_history_allocate(const sc_ctx *ctx, size_t runs, size_t frames, sc_history *out);
/* Free what a run owns, and zero it. */
void sc_run_entry_clear(sc_run_entry *run);

/* Fill the empty history @p out with the runs and frames in @p text, the content of a stats.json.
 * If it cannot be used, the return code is SC_OK, *problem is set to words that follow the name of
 * the file (static), and @p out may hold a part of it. The caller clears @p out, also after an
 * error. @return SC_ERR_MEMORY. */
sc_status sc_stats_parse(const sc_ctx *ctx, const char *text, const sc_job_hashes *job,
                         sc_history *out, const char **problem);

/* Keep the object `made_from` of a run as text, if it is one. @return SC_ERR_MEMORY. */
sc_status sc_keep_made_from(const sc_ctx *ctx, const json_t *run, char **out);
/* Read a time such as 2026-11-21T19:44:38Z. */
bool sc_parse_time(const char *text, time_t *out);

/* Append a run of segcast study; takes what it was made from. @return SC_ERR_MEMORY, @p to
 * untouched. */
sc_status sc_measurements_add_run(const sc_ctx *ctx, sc_measurements *to, const sc_study_run *run);

#endif
