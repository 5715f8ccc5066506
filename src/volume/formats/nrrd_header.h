/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the header of a NRRD file as text, in time that grows with its length. Teem
 * reads the fields, of which there are few; what there may be many of (keys and values, names of
 * data files) and what opens files is read here, because Teem searches all keys for each new one,
 * counts the names of a pattern one by one, and opens whatever a header names. */
#ifndef SC_VOLUME_NRRD_HEADER_H
#define SC_VOLUME_NRRD_HEADER_H

#include "source.h"

/* The keys of one segment as 3D Slicer writes them; NULL where the header has none. Borrowed from
 * the header. */
typedef struct sc_nrrd_segment {
    const char *id, *value, *name, *color, *layer;
} sc_nrrd_segment;

/* A header. Zero-initialise; sc_nrrd_header_clear frees. */
typedef struct sc_nrrd_header {
    char *text;     /* the header as it stands in the file, cut into lines; owned */
    sc_text fields; /* for Teem: the first line and the fields, but for comments, keys and the
                       data file, each with a newline behind it */
    sc_nrrd_segment *segments; /* [segment_capacity], the first segment_count by their number */
    size_t segment_count, segment_capacity;
    const char *label_groups; /* of MITK, in JSON, borrowed from the text; NULL: there are none */
    bool attached;            /* the voxels follow the header in the same file */
    uint64_t end_bytes;       /* if attached: where in the file the voxels begin; else 0 */
    sc_text list;     /* if not attached: the lines that name the data files, for Teem; a pattern of
                         names is written out as a list */
    char *first_file; /* path of the first data file, owned; NULL if attached */
    sc_text paths;    /* of all data files, each with a NUL byte behind it; empty if attached */
    size_t file_count;   /* number of data files; 0 if attached */
    uint64_t file_bytes; /* bytes of all data files, or of the file with header and voxels */
} sc_nrrd_header;

/* Read the header of the NRRD file @p path and find its data files. Caller owns *out:
 * sc_nrrd_header_clear. @return SC_ERR_MISSING if the file cannot be opened; SC_ERR_DATA, logged,
 * for a header that is no text or longer than 64 MiB, fields of more than 1 MiB, more than 65,536
 * data files, or a data file that sc_data_file refuses; SC_ERR_MEMORY. */
sc_status sc_nrrd_header_read(const sc_ctx *ctx, const char *path, sc_nrrd_header *out);
/* Free what the header owns and set it to zero. */
void sc_nrrd_header_clear(sc_nrrd_header *header);
/* Append the segments, from number 0 up to the first that has neither ID nor LabelValue, to the
 * table of @p source, or the labels of MITK's groups, and set its segments if there are layers.
 * @return SC_ERR_DATA, logged, for groups that are no JSON or have no labels; SC_ERR_MEMORY. */
sc_status sc_nrrd_read_segments(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                                sc_source *source);

#endif
