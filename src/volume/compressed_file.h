/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the bytes of a file, decompressed while they are read: the one place where
 * volumes are inflated as a stream. */
#ifndef SC_VOLUME_COMPRESSED_FILE_H
#define SC_VOLUME_COMPRESSED_FILE_H

#include "segcast/base.h"

/* How the bytes of a file are compressed. */
typedef enum sc_compression {
    SC_COMPRESSION_NONE,
    SC_COMPRESSION_GZIP,   /* gzip members one after the other; not compressed if there is none */
    SC_COMPRESSION_ZLIB,   /* one zlib or gzip stream */
    SC_COMPRESSION_DEFLATE /* one deflate stream without a header */
} sc_compression;

typedef struct sc_compressed_file sc_compressed_file;
/* Begin to read the file @p path at byte @p offset. @return SC_ERR_MISSING, SC_ERR_MEMORY, logged.
 * Caller owns *out: sc_compressed_close. */
sc_status sc_compressed_open(const sc_ctx *ctx, const char *path, uint64_t offset,
                             sc_compression compression, sc_compressed_file **out);
/* The same of a file that is open, which is closed then, also after an error. */
sc_status sc_compressed_begin(const sc_ctx *ctx, const char *path, FILE *file, uint64_t offset,
                              sc_compression compression, sc_compressed_file **out);
/* For SC_OWN; NULL is allowed. */
void sc_compressed_close(sc_compressed_file **file);
/* @return whether it is compressed: a file said to be may not be. */
bool sc_file_is_compressed(const sc_compressed_file *p);
/* Read the next @p bytes bytes to @p out. @return how many there were: fewer at
 * the end, or where the file is damaged. */
size_t sc_compressed_read(sc_compressed_file *p, void *out, size_t bytes);
/* Pass over bytes. @return how many there were. */
uint64_t sc_compressed_skip(sc_compressed_file *p, uint64_t bytes);
/* @return SC_OK; SC_ERR_MEMORY, SC_ERR_WRITE if it could not be read further for want of memory or
 * because the system cannot read it; SC_ERR_DATA if it is damaged or ends within what is
 * compressed. */
sc_status sc_compressed_status(const sc_compressed_file *p);
/* @return the reason for such a code; NULL for SC_OK. */
const char *sc_compressed_reason(const sc_compressed_file *p);
/* Log that it could not be read, unless it is merely damaged, which who reads the voxels notices.
 * @return SC_ERR_MEMORY, SC_ERR_WRITE. */
sc_status sc_compressed_check(const sc_ctx *ctx, const sc_compressed_file *p);
/* Has all that is compressed been read, and are its check sums right? */
bool sc_compressed_has_ended(const sc_compressed_file *p);
/* @return how many bytes stand behind what is compressed, which has ended. */
uint64_t sc_compressed_rest(sc_compressed_file *p);

#endif
