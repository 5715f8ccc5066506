/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the segments of a .seg.nrrd, and the labels of MITK. */
#ifndef SC_VOLUME_NRRD_SEGMENTS_H
#define SC_VOLUME_NRRD_SEGMENTS_H

#include "formats/nrrd_header.h"

/* Append the segments, from number 0 up to the first that has neither ID nor LabelValue, to the
 * table of @p source, or the labels of MITK's groups, and set its segments if there are layers.
 * @return SC_ERR_DATA, logged, for groups that are no JSON or have no labels; SC_ERR_MEMORY. */
sc_status sc_nrrd_read_segments(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                                sc_source *source);

#endif
