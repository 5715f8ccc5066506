/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to stream.c, which reads the voxels of a file, and stream_values.c, which makes labels
 * and numbers of them. */
#ifndef SC_VOLUME_STREAM_H
#define SC_VOLUME_STREAM_H

#include "compressed_file.h"
#include "source.h"

/* The most bytes of a voxel. */
enum { SC_VOXEL_BYTES_MAX = 8 };

struct sc_voxel_stream {
    const sc_ctx *ctx;
    const char *path;
    const sc_source *source;
    size_t position;          /* voxels delivered so far */
    sc_compressed_file *file; /* of all encodings but SC_ENCODING_LOADED and SC_ENCODING_SLICES */
    unsigned char *slab;      /* of SC_ENCODING_SLICES: the slices that were read last; owned */
    size_t slab_begin, slab_voxels; /* which voxels these are */
    unsigned char
        *batch; /* [SC_BATCH_BYTES], of sc_stream_next_raw; NULL until it is called; owned */
    unsigned char *ahead; /* [SC_BATCH_BYTES], of sc_stream_read_ahead, NULL until then; owned */
    size_t ahead_bytes;   /* how many of the next batch were read there */
    bool is_ahead;        /* the next batch was read, as far as it could be */
    atomic_bool rounded;  /* a label was moved to a whole number */
    /* One block as stored, and the same in this machine's byte order. They are read as numbers of
     * the source's type, so they are aligned for each type. */
    _Alignas(max_align_t) unsigned char raw[SC_STREAM_BLOCK * SC_VOXEL_BYTES_MAX];
    _Alignas(max_align_t) unsigned char swapped[SC_STREAM_BLOCK * SC_VOXEL_BYTES_MAX];
};

/* Read the next @p count voxels as they are stored. @param raw where they stand then; borrowed from
 * the stream. Its position stays that of the first. @return the errors of sc_stream_next but for
 * values. */
sc_status sc_stream_stored(sc_voxel_stream *s, size_t count, const void **raw);

#endif
