/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that processes of one machine map into memory in order to share it. */
#ifndef SC_SHARED_FILE_H
#define SC_SHARED_FILE_H

#include "segcast/base.h"

#include <limits.h>

/* What tells the other processes where the file is. A plain value, sent as bytes. */
typedef struct sc_shared_name {
    char path[PATH_MAX]; /* empty: the name is removed */
    int32_t unfinished;  /* for the process that has made it: see sc_unfinished_drop */
} sc_shared_name;

/* These functions log nothing: that a folder has no room is no error as long as there is another.
 * What they cannot do errno tells; that there is no room, as ENOSPC.
 *
 * Make an empty temporary file, like those of sc_outfile, of a name that nobody can guess, for this
 * user alone, if the file system of @p folder has room for @p bytes and keeps @p spare_bytes, or
 * half of its room if that is less. Those that killed processes of this host have left in @p folder
 * are removed before. @return SC_ERR_MEMORY if it has not, SC_ERR_CREATE. Caller removes the file
 * (sc_shared_file_remove) as soon as all have opened it, and closes *out. */
sc_status sc_shared_file_make(const char *folder, size_t bytes, size_t spare_bytes,
                              sc_shared_name *name, int *out);
/* @return whether the file system of @p folder has room for @p bytes and then still for @p spare,
 * or for half of what it has now if that is less; true if it does not say. */
bool sc_shared_folder_has_room(const char *folder, size_t bytes, size_t spare);
/* Open the file that another process has made. @return SC_ERR_MISSING. Caller closes *out. */
sc_status sc_shared_file_open(const sc_shared_name *name, int *out);
/* Remove the name; the file stays as long as it is open or mapped somewhere. Only in the process
 * that has made it; the second time does nothing. */
void sc_shared_file_remove(sc_shared_name *name);
/* Give the file @p bytes of room, so that no later access can find the file system full. @return
 * SC_ERR_MEMORY. */
sc_status sc_shared_file_reserve(int file, size_t bytes);
/* Map @p bytes, above 0, of the file for reading and writing. @return SC_ERR_MEMORY. Caller owns
 * *out: munmap. The file may be closed. */
sc_status sc_shared_file_map(int file, size_t bytes, void **out);

#endif
