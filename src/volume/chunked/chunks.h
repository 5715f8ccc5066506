/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: what the formats share whose voxels lie in chunks, in many files below a
 * directory (Zarr, Neuroglancer): these files, and slices that are put together from chunks by
 * several threads. */
#ifndef SC_VOLUME_CHUNKS_H
#define SC_VOLUME_CHUNKS_H

#include "source.h"

#include <jansson.h>

enum {
    SC_CHUNK_WHY_BYTES = 256,           /* room for a reason */
    SC_CHUNK_KEY_BYTES = 256,           /* room for the name of a chunk's file */
    SC_CHUNK_BYTES_MAX = 1750 << 20,    /* of values; what packed chunks then take fits the
                                           libraries' numbers */
    SC_CHUNK_JSON_BYTES_MAX = 16 << 20, /* longer metadata are refused */
    SC_CHUNKS_MAX = 1 << 20, /* that are read of a volume: each is looked for, even if none is
                                there, so that a few bytes of metadata could take hours */
};

/* ---- files (chunk_files.c) ---- */

/* Open the directory @p name, a path with "/", below the directory @p directory, without following
 * links. @return the descriptor, or -1 with errno; ELOOP or ENOTDIR: a part is a link. */
int sc_chunk_open_directory(int directory, const char *name);
/* The same for a regular file. @return as above; EINVAL: no regular file. Threads: any. */
int sc_chunk_open_file(int directory, const char *name, uint64_t *bytes);
/* Read bytes [begin, + bytes) of a file. @return false, with errno, 0 at the end of the file.
 * Threads: any. */
bool sc_chunk_read_at(int fd, uint64_t begin, size_t bytes, unsigned char *out);
/* Read the JSON file @p name, an object, below the directory @p directory, which messages call
 * @p path. *out stays NULL if there is none. @return SC_ERR_DATA for what is too long, no JSON or
 * no object; SC_ERR_MEMORY; SC_ERR_MISSING or SC_ERR_WRITE if it cannot be read. Caller owns *out:
 * json_decref. */
sc_status sc_chunk_read_json(const sc_ctx *ctx, int directory, const char *path, const char *name,
                             json_t **out);

/* ---- slices (chunks.c) ---- */

/* A chunk in memory. */
typedef struct sc_chunk {
    const unsigned char *values; /* the value of its first voxel */
    size_t strides[3]; /* from there to its neighbours along x, y, z, in values; all 0: one
                          value for the whole chunk */
    bool swapped;      /* in the byte order that this machine does not have */
    bool absent;       /* the volume has it not: values is what stands for it */
} sc_chunk;

/* What a thread could not read, and what was not there. */
typedef struct sc_chunk_failure {
    size_t absent; /* chunks so far that the volume has not */
    size_t chunk;  /* the first chunk, by its place in the slices; SIZE_MAX: none */
    size_t now;    /* the one that is being read */
    sc_status status;
    char file[SC_CHUNK_KEY_BYTES];
    char why[SC_CHUNK_WHY_BYTES];
} sc_chunk_failure;
/* Note why the chunk that is being read cannot be; of several, the first counts. @return false
 * always. */
bool sc_chunk_note(sc_chunk_failure *failure, sc_status status, const char *file, const char *why);
/* Note by errno why the file @p file of a chunk cannot be opened. @return false always. */
bool sc_chunk_note_unopened(sc_chunk_failure *failure, const char *file);

/* Read and unpack the chunk @p number, counted along x, y, z, in memory of the thread @p thread,
 * where it stays until that thread's next call. @return false if it cannot be read, noted in @p
 * failure. */
typedef bool sc_chunk_load_fn(void *user, int thread, const size_t number[3],
                              sc_chunk_failure *failure, sc_chunk *out);

/* An array in chunks, while slices of it are read. Zero-initialise; sc_chunked_clear frees. */
typedef struct sc_chunked {
    const char *path;       /* for messages, borrowed */
    const char *absent;     /* what chunks hold that are not there, for messages; static */
    size_t chunk[3];        /* voxels of a chunk along x, y, z */
    size_t low[3], part[3]; /* the first voxel that is read, and how many: sc_chunked_cut */
    size_t voxel_bytes;
    int threads; /* that read side by side */
    sc_chunk_load_fn *load;
    void *user;                 /* of load */
    size_t done;                /* chunks that were asked for so far */
    sc_chunk_failure *failures; /* [threads], owned */
} sc_chunked;
void sc_chunked_clear(sc_chunked *chunked);
/* Set how many threads may read, if each needs @p needed_bytes for chunks of @p chunk_bytes.
 * @return SC_ERR_SYSTEM, logged, if the limit of memory does not allow one. */
sc_status sc_chunked_threads(const sc_ctx *ctx, double chunk_bytes, double needed_bytes,
                             sc_chunked *chunked);
/* Make @p source, of the whole array, one of the part that @p choice wants; and set how many slices
 * of it are read at a time: those of whole layers of chunks, so that each chunk is unpacked once.
 * @return the errors of sc_source_cut and sc_geometry_check. */
sc_status sc_chunked_cut(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                         sc_chunked *chunked, sc_source *source);
/* Check that the part does not lie in more than SC_CHUNKS_MAX chunks. @return SC_ERR_DATA, logged.
 */
sc_status sc_chunked_count_check(const sc_ctx *ctx, const char *path, const sc_chunked *chunked);
/* Read slices [first, first + count) of the part to @p out, x fastest, in this byte order. With the
 * last of them it is told how many chunks of the part are not there, if any. @return
 * SC_ERR_MEMORY; what load has noted, logged: the first that is missing, whatever the threads. */
sc_status sc_chunked_read(const sc_ctx *ctx, sc_chunked *chunked, int first, int count, void *out);

#endif
