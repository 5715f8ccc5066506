/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the program that reads HDF5 files, as a process that is talked to by a pipe.
 * Nothing that comes from it is trusted: it may crash, hang, or send anything. */
#ifndef SC_VOLUME_HDF5_PROCESS_H
#define SC_VOLUME_HDF5_PROCESS_H

#include "segcast/base.h"
#include "segcast/hdf5.h"

#include <sys/types.h>

/* A process that reads a file. Zero-initialise with out -1; sc_hdf5_end ends it. */
typedef struct sc_hdf5_process {
    pid_t pid;            /* 0: none, or it has ended */
    int out;              /* what it sends is read here; -1: closed */
    const char *path;     /* of the volume, for messages; borrowed */
    double silence_s;     /* it is given up if what is awaited does not come in so long */
    uint64_t block_bytes; /* left of the block of voxels that is read */
} sc_hdf5_process;

/* Start the program on a file. @param file open for reading; borrowed. @param voxels first and
 * number along x, y, z; NULL: the description alone. @return SC_ERR_SYSTEM, logged, if it cannot be
 * started. The caller ends it. Threads: by the main thread, with which it ends. */
sc_status sc_hdf5_begin(const sc_ctx *ctx, const char *path, int file, const char *inside,
                        const int (*voxels)[2], sc_hdf5_process *process);
/* Read the answer, and check it. @param text its text. @return SC_ERR_MISSING, SC_ERR_DATA or
 * SC_ERR_SYSTEM, logged, if it says that the volume cannot be read, or comes to an end, or is
 * nonsense: then the process has ended. */
sc_status sc_hdf5_read_answer(const sc_ctx *ctx, sc_hdf5_process *process, sc_hdf5_answer *answer,
                              char text[SC_HDF5_TEXT_BYTES + 1]);
/* Read the next @p bytes bytes of voxels to @p out. @return as above. */
sc_status sc_hdf5_read_voxels(const sc_ctx *ctx, sc_hdf5_process *process, size_t bytes, void *out);
/* End the process at once, if it has not ended, and close the pipe. A zeroed one with out -1 is
 * allowed. */
void sc_hdf5_end(sc_hdf5_process *process);

#endif
