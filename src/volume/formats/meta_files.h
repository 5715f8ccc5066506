/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: voxels of a MetaImage that are not one block of bytes in one file. */
#ifndef SC_VOLUME_META_FILES_H
#define SC_VOLUME_META_FILES_H

#include "source.h"

enum { SC_META_AT_END = -1 }; /* HeaderSize: the voxels are the last bytes of the file */

/* Where the header of a MetaImage says that the voxels stand. */
typedef struct sc_meta_series {
    char *names; /* ElementDataFile: a file, "LOCAL", or for one file for each slice "LIST" or
                    "slice%03d.raw 1 20 1"; parsing changes this text */
    char *
        list; /* what follows that line: the names of LIST, one a line; parsing changes this text */
    int64_t header_bytes; /* HeaderSize: where in each file its voxels begin; SC_META_AT_END */
    bool compressed;      /* each file is a zlib stream */
} sc_meta_series;

/* Does ElementDataFile name one file for each slice? */
bool sc_meta_is_series(const char *names);
/* Find the files of a series and check their sizes. @p source has size and type; this sets
 * encoding, data, release, read_slices, slices, file (the first) and data_files. @return
 * SC_ERR_DATA, logged, for what sc_data_file refuses, too few or too many names or slices, and a
 * file that cannot hold a slice; SC_ERR_MEMORY. */
sc_status sc_meta_open_series(const sc_ctx *ctx, const char *header, const sc_meta_series *series,
                              sc_source *source);
/* Let the voxels be read as numbers in decimal digits with blanks between them (BinaryData =
 * False, and AmiraMesh), from source->stored.offset_bytes in source->stored.file on; sets encoding,
 * type, data, release, read_slices and slices. @return SC_ERR_MEMORY. */
sc_status sc_meta_open_text(const sc_ctx *ctx, sc_source *source);

#endif
