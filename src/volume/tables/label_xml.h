/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: label tables in XML. */
#ifndef SC_VOLUME_LABEL_XML_H
#define SC_VOLUME_LABEL_XML_H

#include "tables/label_table.h"

enum { SC_XML_WHY_BYTES = 256 };

/* Append the rows of the first <LabelTable> of the XML document text[bytes] to @p table: elements
 * <Label Key="4" Red="1" Green="0.5" Blue="0" Alpha="1">name</Label>, levels from 0 to 1, as GIFTI,
 * Connectome Workbench and TotalSegmentator write them. The row of label 0 is left out. Labels
 * without a whole number as key, and colours that are none, are left out with one warning under @p
 * path. Entities are not expanded: a document whose DOCTYPE has declarations of its own is refused.
 * @param why receives, for SC_ERR_DATA, which is not logged, what is wrong: the document is no XML
 * or has no label table, or segcast was built without Expat. @return also SC_ERR_MEMORY, logged.
 * After an error
 * @p table is as it was, but for its capacity. */
sc_status sc_label_xml_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                             sc_label_table *table, char why[SC_XML_WHY_BYTES]);

#endif
