/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the bytes of a file, unpacked while they are read: the one place where volumes
 * are inflated as a stream. */
#ifndef SC_VOLUME_PACKED_FILE_H
#define SC_VOLUME_PACKED_FILE_H

#include "segcast/base.h"

/* How the bytes of a file are packed. */
typedef enum sc_packing {
    SC_PACKING_NONE,
    SC_PACKING_GZIP,   /* gzip members one after the other; not packed if there is none */
    SC_PACKING_ZLIB,   /* one zlib or gzip stream */
    SC_PACKING_DEFLATE /* one deflate stream without a header */
} sc_packing;

typedef struct sc_packed_file sc_packed_file;
/* Begin to read the file @p path at byte @p offset. @return SC_ERR_MISSING, SC_ERR_MEMORY, logged.
 * Caller owns *out: sc_packed_close. */
sc_status sc_packed_open(const sc_ctx *ctx, const char *path, uint64_t offset, sc_packing packing,
                         sc_packed_file **out);
/* The same of a file that is open, which is closed then, also after an error. */
sc_status sc_packed_begin(const sc_ctx *ctx, const char *path, FILE *file, uint64_t offset,
                          sc_packing packing, sc_packed_file **out);
/* For SC_OWN; NULL is allowed. */
void sc_packed_close(sc_packed_file **file);
/* @return whether it is packed indeed. */
bool sc_packed_is_packed(const sc_packed_file *p);
/* Read the next @p bytes bytes to @p out. @return how many there were: fewer at
 * the end, or where the file is damaged. */
size_t sc_packed_read(sc_packed_file *p, void *out, size_t bytes);
/* Pass over bytes. @return how many there were. */
uint64_t sc_packed_skip(sc_packed_file *p, uint64_t bytes);
/* @return SC_OK; SC_ERR_MEMORY, SC_ERR_WRITE if it could not be read further for want of memory or
 * because the system cannot read it; SC_ERR_DATA if it is damaged or ends within what is packed. */
sc_status sc_packed_status(const sc_packed_file *p);
/* @return the reason for such a code; NULL for SC_OK. */
const char *sc_packed_reason(const sc_packed_file *p);
/* Log that it could not be read, unless it is merely damaged, which who reads the voxels notices.
 * @return SC_ERR_MEMORY, SC_ERR_WRITE. */
sc_status sc_packed_check(const sc_ctx *ctx, const sc_packed_file *p);
/* Has all that is packed been read, and are its check sums right? */
bool sc_packed_has_ended(const sc_packed_file *p);
/* @return how many bytes stand behind what is packed, which has ended. */
uint64_t sc_packed_rest(sc_packed_file *p);

#endif
