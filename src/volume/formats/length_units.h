/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: units of length, as headers write them. */
#ifndef SC_VOLUME_LENGTH_UNITS_H
#define SC_VOLUME_LENGTH_UNITS_H

#include "segcast/base.h"

/* @return how many mm a unit of length has that a header calls @p name: "mm", "microns", "um" or
 * "micrometer"; the Greek letter may also be written as \u00B5, as ImageJ does; 0 for what is no
 * known unit. */
double sc_length_unit_mm(const char *name);
/* The same of a unit of time, in seconds. */
double sc_time_unit_s(const char *name);
/* Warn that a file does not say how large its voxels are. @param key that would tell it. */
void sc_warn_without_spacing(const sc_ctx *ctx, const char *path, const char *key);

#endif
