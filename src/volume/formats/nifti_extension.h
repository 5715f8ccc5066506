/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the header extensions of NIfTI, of which nifticlib would believe the sizes. */
#ifndef SC_VOLUME_NIFTI_EXTENSION_H
#define SC_VOLUME_NIFTI_EXTENSION_H

#include "source.h"

/* Append the rows of the first label table in the header extensions of a NIfTI file to @p table:
 * XML as of sc_label_xml_parse, in an extension of any code (Connectome Workbench writes 30,
 * TotalSegmentator 0). @param begin,end the bytes of the file, unpacked, from behind the header to
 * before the voxels; what lies beyond the end of the file does not count. @param swapped the header
 * is in the byte order that this machine does not have. Extensions that are damaged or larger than
 * 64 MiB, and a table that cannot be read, give a warning. @return SC_ERR_MEMORY, SC_ERR_WRITE,
 * SC_ERR_MISSING, logged. */
sc_status sc_nifti_labels(const sc_ctx *ctx, const char *path, uint64_t begin, uint64_t end,
                          bool swapped, sc_label_table *table);

#endif
