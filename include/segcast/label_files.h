/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Writing label tables, in the formats of other programs. */
#ifndef SEGCAST_LABEL_FILES_H
#define SEGCAST_LABEL_FILES_H

#include "segcast/volume.h"

/** A format that label tables are written in. */
typedef struct sc_table_writer sc_table_writer;

/** @return the format called @p name, such as "bids"; NULL if there is none. Static. */
const sc_table_writer *sc_table_writer_find(const char *name);
/** @return the format that files named like @p path have, by the ending of the name; NULL if that
 *  does not tell. Static. */
const sc_table_writer *sc_table_writer_for(const char *path);
/** @return the name of the format number @p i, counted from 0; NULL behind the last one. Static. */
const char *sc_table_writer_name(size_t i);

/** Append a label table to @p out, with the rows in rising order of their values. Of several rows
 *  of a value the first holds, and the later ones fill in what it leaves open. One warning under
 *  @p path tells what the format cannot hold: rows of numbers that it has no room for are left out,
 *  as are colours, opacities and visibility that it does not know, and names are changed where it
 *  allows no blanks or quotation marks. In formats that need a colour, labels without one get that
 *  of the palette (sc_label_base_color).
 *  @return SC_ERR_DATA if no row can be written; SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_label_table_print(const sc_ctx *ctx, const char *path,
                                           const sc_label_table *table,
                                           const sc_table_writer *writer, sc_text *out);

#endif
