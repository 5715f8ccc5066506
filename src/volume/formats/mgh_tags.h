/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: what follows the voxels of FreeSurfer's MGH files. */
#ifndef SC_VOLUME_MGH_TAGS_H
#define SC_VOLUME_MGH_TAGS_H

#include "source.h"

/* Append the rows of the colour table behind the voxels of an MGH file to @p table: number, name,
 * colour and opacity of each label but 0. @param end where the voxels end, unpacked; what is before
 * is unpacked and left out. Tags that cannot be followed end the search silently, since they are
 * optional and FreeSurfer adds new ones; a colour table that cannot be read gives a warning.
 * @return SC_ERR_MEMORY, SC_ERR_WRITE, SC_ERR_MISSING, logged. */
sc_status sc_mgh_labels(const sc_ctx *ctx, const char *path, uint64_t end, sc_label_table *table);

#endif
