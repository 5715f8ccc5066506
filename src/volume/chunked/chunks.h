/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: what the formats share whose voxels lie in chunks, in many files below a
 * directory (Zarr, Neuroglancer): these files, where chunks are in files that hold several, and
 * slices that are put together from chunks by several threads. */
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

/* ---- files and their metadata (chunk_files.c) ---- */

/* Open the directory @p name, a path with "/", below the directory @p directory, without following
 * links. @return the descriptor, or -1 with errno; ELOOP or ENOTDIR: a part is a link. */
int sc_chunk_open_directory(int directory, const char *name);
/* The same for a regular file. @return as above; EINVAL: no regular file. Threads: any. */
int sc_chunk_open_file(int directory, const char *name, uint64_t *bytes);
/* Read bytes [begin, + bytes) of a file. @return false, with errno, 0 at the end of the file.
 * Threads: any. */
bool sc_chunk_read_at(int fd, uint64_t begin, size_t bytes, unsigned char *out);
/* Unpack in[in_bytes], a stream of zlib or gzip by its header, to out[most]. *bytes receives how
 * many bytes it held. @return false, with @p why, if it is damaged or holds more. Threads: any. */
bool sc_chunk_inflate(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t most,
                      size_t *bytes, char why[SC_CHUNK_WHY_BYTES]);
/* Open the directory @p name below the directory @p directory, which messages call @p path; the
 * file
 * @p from in it names it. No part of the name may be a link. @return SC_ERR_DATA for a name that
 * leads elsewhere, SC_ERR_MISSING if it is not there, SC_ERR_MEMORY. Caller owns *full, the path
 * for messages, also after an error, and *fd. */
sc_status sc_chunk_open_below(const sc_ctx *ctx, int directory, const char *path, const char *from,
                              const char *name, char **full, int *fd);
/* Read the JSON file @p name, an object, below the directory @p directory, which messages call
 * @p path. *out stays NULL if there is none. @return SC_ERR_DATA for what is too long, no JSON or
 * no object; SC_ERR_MEMORY; SC_ERR_MISSING or SC_ERR_WRITE if it cannot be read. Caller owns *out:
 * json_decref. */
sc_status sc_chunk_read_json(const sc_ctx *ctx, int directory, const char *path, const char *name,
                             json_t **out);

/* Log that the key @p key in the file @p name of the directory @p path is not as expected. @return
 * SC_ERR_DATA always. */
sc_status sc_chunk_refuse_key(const sc_ctx *ctx, const char *path, const char *name,
                              const char *key, const char *expected);
/* Read the first @p count entries of a list, finite numbers from @p least to @p most, to
 * out[count].
 * @return false if there are fewer, or others. */
bool sc_chunk_numbers(const json_t *list, int count, double least, double most, double *out);

/* Append level @p i, whose directory is called @p name (NULL: it has none), to a list of levels.
 * @param size of it, as the file has it; NULL: not known. @return SC_ERR_MEMORY. */
sc_status sc_chunk_describe_level(const sc_ctx *ctx, sc_text *levels, size_t i, const char *name,
                                  const json_t *size);
/* Log that there is no level @p level, but those in the list. @return SC_ERR_DATA always. */
sc_status sc_chunk_refuse_level(const sc_ctx *ctx, const char *path, int level, size_t count,
                                const sc_text *levels);

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
    size_t now;    /* the one that is being read, and its file */
    char key[SC_CHUNK_KEY_BYTES];
    sc_status status;
    char file[SC_CHUNK_KEY_BYTES];
    char why[SC_CHUNK_WHY_BYTES];
} sc_chunk_failure;
/* Note why the chunk that is being read cannot be; of several, the first counts. @return false
 * always. */
bool sc_chunk_note(sc_chunk_failure *failure, sc_status status, const char *why);
/* Note by errno why the file of a chunk cannot be opened. @return false always. */
bool sc_chunk_note_unopened(sc_chunk_failure *failure);

/* Memory of one thread. */
typedef struct sc_chunk_room {
    unsigned char *packed;      /* [packed_bytes]: a chunk as it is stored */
    unsigned char *unpacked[2]; /* [room_bytes[i]]; NULL if that is 0 */
} sc_chunk_room;

/* Write the name of the file that holds the chunk @p number, counted along x, y, z, to @p key. */
typedef void sc_chunk_name_fn(const void *user, const size_t number[3],
                              char key[SC_CHUNK_KEY_BYTES]);
/* Read and unpack the chunk @p number in the memory of a thread, where it stays until that thread's
 * next call. @return false if it cannot be read, noted in @p failure. */
typedef bool sc_chunk_load_fn(const void *user, const sc_chunk_room *room, const size_t number[3],
                              sc_chunk_failure *failure, sc_chunk *out);

/* Where a chunk is in its file. */
typedef struct sc_chunk_place {
    uint64_t begin, bytes; /* UINT64_MAX bytes: there is no such chunk */
} sc_chunk_place;
/* A chunk that lies in a file with others. */
typedef struct sc_chunk_wanted {
    uint64_t file, part; /* which file has it, and which part of the file: each has an index */
    uint64_t chunk;      /* its number there */
    size_t item;         /* its place among the chunks that are read */
} sc_chunk_wanted;
/* How chunks are found in such files. */
typedef struct sc_chunk_finder {
    /* Set file, part and chunk for the chunk @p number. */
    void (*want)(const void *user, const size_t number[3], sc_chunk_wanted *out);
    /* Read the index of the part of the open file that has wanted[count], sorted by their numbers,
     * and set their places, as far as it has them. @param left the bytes of the file that no index
     * has taken yet. @return the reason if it is damaged, or sc_chunk_no_memory; else NULL. */
    const char *(*find)(const void *user, int fd, const sc_chunk_wanted *wanted, size_t count,
                        uint64_t *left, sc_chunk_place *places);
} sc_chunk_finder;
extern const char sc_chunk_no_memory[];

/* An array in chunks, while slices of it are read. Zero-initialise; sc_chunked_clear frees. */
typedef struct sc_chunked {
    const char *path;       /* of the directory with the chunks, for messages, borrowed */
    int directory;          /* the same, open; borrowed */
    const char *absent;     /* what chunks hold that are not there, for messages; static */
    const char *ending;     /* that the names of files may have beside their own; NULL: none */
    size_t chunk[3];        /* voxels of a chunk along x, y, z */
    size_t low[3], part[3]; /* the first voxel that is read, and how many: sc_chunked_begin */
    size_t voxel_bytes, chunk_bytes,
        packed_bytes;     /* of a chunk: unpacked, and the most as stored */
    size_t room_bytes[2]; /* that a thread needs to unpack it */
    int threads;          /* that read side by side */
    sc_chunk_name_fn *name;
    sc_chunk_load_fn *load;
    const sc_chunk_finder *finder; /* NULL: each chunk is a file */
    const void *user;              /* of these functions */
    size_t done;                   /* chunks that were asked for so far */
    sc_chunk_place *places;        /* of all that are read, x fastest, owned; NULL: no finder */
    sc_chunk_failure *failures;    /* [threads], owned */
    sc_chunk_room *rooms;          /* [threads], owned; NULL until the first slices */
} sc_chunked;
void sc_chunked_clear(sc_chunked *chunked);
/* @return the most bytes that @p bytes bytes may have when they are stored; more is refused before
 * it is read. */
size_t sc_chunk_packed_most(size_t bytes);
/* Set how many threads may read. @param more_bytes that each needs beside the sizes in @p chunked.
 * @return SC_ERR_SYSTEM, logged, if the limit of memory does not allow one. */
sc_status sc_chunked_threads(const sc_ctx *ctx, double more_bytes, sc_chunked *chunked);
/* Make @p source, of the whole array, one of the part that @p choice wants; check that it lies in
 * no more than SC_CHUNKS_MAX chunks, and fits into memory unless @p header_only; and set how many
 * slices of it are read at a time: those of whole layers of chunks, so that each chunk is unpacked
 * once. @return the errors of sc_source_take_part and sc_volume_memory_check. */
sc_status sc_chunked_begin(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                           bool header_only, sc_chunked *chunked, sc_source *source);
/* Find the first chunk along x, y, z in which the part lies, and how many. */
void sc_chunked_box(const sc_chunked *chunked, size_t first[3], size_t count[3]);
/* sc_slices_fn of a source whose data begins with a sc_chunked: read slices of the part, in this
 * byte order. With the last of them it is told how many chunks of the part are not there, if any.
 * @return SC_ERR_MEMORY; what was noted, logged: the first that is missing, whatever the threads.
 */
sc_slices_fn sc_chunked_slices;
/* Read the bytes of the chunk @p number as they are stored to room->packed. *bytes: how many;
 * SIZE_MAX if it is not there. @return false if they cannot be read, noted. */
bool sc_chunk_read_stored(const sc_chunked *chunked, const sc_chunk_room *room,
                          const size_t number[3], sc_chunk_failure *failure, size_t *bytes);
/* Log the first failure of all threads. @return its code; SC_OK if there is none. */
sc_status sc_chunked_failed(const sc_ctx *ctx, const sc_chunked *chunked);

/* ---- places (chunk_places.c) ---- */

/* Find all chunks of the part by chunked->finder: fills chunked->places. Each index is read once.
 * @return as sc_chunked_slices. */
sc_status sc_chunked_find(const sc_ctx *ctx, sc_chunked *chunked);

#endif
