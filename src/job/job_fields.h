/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: the tables of a job's keys. */
#ifndef SC_JOB_JOB_FIELDS_H
#define SC_JOB_JOB_FIELDS_H

#include "schema.h"
#include "segcast/job.h"

/* "file:line" of a node, for later messages. */
void sc_note_where(const sc_yaml *node, char *where, size_t size);
extern const sc_field sc_job_fields[]; /* of sc_job */
extern const char *const sc_preset_names[];

/* Types for parts of the animation and for tissues; see job_types.c. */
extern const sc_field_type sc_type_place, sc_type_span, sc_type_zoom, sc_type_clip, sc_type_tissues,
    sc_type_orbit, sc_type_fixed, sc_type_slices;
extern const char *const sc_ease_names[], *const sc_projection_names[];

#endif
