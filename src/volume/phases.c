/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that hold the volumes of several phases (4-D): which of them is read, and from where.
 * Such a file holds the phases one after the other, or the values of all phases of a voxel next to
 * each other. To read one phase of a compressed file, or of one of the second kind, the file would
 * have to be read from its beginning. An sc_phase_store therefore unpacks such a file once into an
 * unlinked temporary file, in which the phases follow one another. */
#include "source.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

struct sc_phase_store {
    char *folder; /* where the file is made; owned */
    char *path;   /* the volume that it holds; NULL: none yet; owned */
    FILE *file;   /* its voxels as stored, [phase][z][y][x]; NULL: none */
    bool failed;  /* it could not be made, which has been told */
};

SC_CLOSE_AT(sc_phase_store_free, sc_phase_store)

sc_status sc_phase_store_new(const sc_ctx *ctx, const char *folder, sc_phase_store **out)
{
    SC_OWN(sc_phase_store_free_at) sc_phase_store *store = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &store));
    SC_PASS(sc_text_copy(ctx, folder, &store->folder));
    SC_HAND_OVER(store, out);
    return SC_OK;
}

void sc_phase_store_free(sc_phase_store *store)
{
    if (!store)
        return;
    if (store->file)
        fclose(store->file);
    sc_free(store->folder);
    sc_free(store->path);
    sc_free(store);
}

/* ---- all phases, once ---- */

/* Make a file without a name in a folder. @return NULL, with errno set, if that cannot be. */
static FILE *open_unnamed(const sc_ctx *ctx, const char *folder)
{
    sc_text name = {0};
    FILE *file = NULL;
    uint64_t random;
    int fd = -1, error = ENOMEM;

    if (getentropy(&random, sizeof random))
        return NULL;
    if (sc_text_add(ctx, &name, "%s/.segcast-phases.%ld.%016llx", folder, (long)getpid(),
                    (unsigned long long)random) == SC_OK) {
        fd = open(name.data, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
        error = errno;
    }
    if (fd >= 0) {
        unlink(name.data);
        file = fdopen(fd, "w+b");
        error = errno;
        if (!file)
            close(fd);
    }
    sc_text_clear(&name);
    errno = error;
    return file;
}

/* Write @p bytes bytes to byte @p at of a file. @return false with errno set. */
static bool write_at(int fd, const unsigned char *from, size_t bytes, uint64_t at)
{
    while (bytes) {
        const ssize_t wrote = pwrite(fd, from, bytes, (off_t)at);

        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote <= 0)
            return false;
        from += wrote;
        bytes -= (size_t)wrote;
        at += (uint64_t)wrote;
    }
    return true;
}

/* The values of all phases, which stand side by side in the file, on their way to one after the
 * other. */
typedef struct sorting {
    size_t each, phases, phase_voxels;
    unsigned char *values; /* scratch, of a batch */
} sorting;

/* Write the @p count values from @p first on, at @p raw, to their phases. @return false with errno
 * set. */
static bool write_sorted(int fd, const sorting *s, const unsigned char *raw, size_t first,
                         size_t count)
{
    for (size_t phase = 0; phase < s->phases; phase++) {
        size_t at = (phase + s->phases - first % s->phases) % s->phases, found = 0;
        const size_t voxel = (first + at) / s->phases;

        for (; at < count; at += s->phases)
            memcpy(s->values + found++ * s->each, raw + at * s->each, s->each);
        if (!write_at(fd, s->values, found * s->each,
                      ((uint64_t)phase * s->phase_voxels + voxel) * s->each))
            return false;
    }
    return true;
}

/* @return a source of all values of a file with several phases. It borrows from @p source. */
static sc_source all_values(const sc_source *source)
{
    sc_source all = *source;

    all.size[source->series.side_by_side ? 0 : 2] *= source->series.count;
    all.series.phase = 0;
    return all;
}

/* Unpack all phases to an open file. *write_error receives the errno if that cannot be written,
 * else 0. @return the errors of reading; SC_ERR_MEMORY; SC_ERR_WRITE, without a message, with
 * *write_error. */
static sc_status unpack(const sc_ctx *ctx, const char *path, const sc_source *source, int fd,
                        int *write_error)
{
    const sc_source all = all_values(source);
    const size_t total = sc_source_voxels(&all), each = sc_voxel_type_bytes(source->type);
    sorting s = {each, (size_t)source->series.count, sc_source_voxels(source), NULL};
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;
    SC_OWN(sc_free_at) void *block = NULL;

    *write_error = 0;
    SC_PASS(sc_alloc(ctx, SC_BATCH_BYTES, 1, &block));
    s.values = block;
    sc_stage_begin(ctx, "unpacking the phases", 0, total);
    SC_PASS(sc_stream_open(ctx, path, &all, &stream));
    for (size_t at = 0, count; at < total; at += count) {
        const void *raw;
        bool written;

        SC_PASS(sc_stream_next_raw(stream, &raw, &count));
        written = source->series.side_by_side
                      ? write_sorted(fd, &s, raw, at, count)
                      : write_at(fd, raw, count * each, (uint64_t)at * each);
        if (!written) {
            *write_error = errno;
            return SC_ERR_WRITE;
        }
        sc_stage_add(ctx, count);
    }
    return sc_stream_finish(stream);
}

/* Fill the store with the phases of a file, unless it holds them or has failed before. Without room
 * for them it has failed, which is told. @return the errors of reading, and SC_ERR_MEMORY. */
static sc_status fill_store(const sc_ctx *ctx, const char *path, const sc_source *source,
                            sc_phase_store *store)
{
    const double bytes = (double)sc_source_voxels(source) * source->series.count *
                         (double)sc_voxel_type_bytes(source->type);
    char size[24];
    int error = 0;
    sc_status status = SC_OK;

    if (store->failed || (store->path && !strcmp(store->path, path)))
        return SC_OK;
    sc_free(store->path);
    store->path = NULL;
    if (store->file)
        fclose(store->file);
    store->file = open_unnamed(ctx, store->folder);
    if (!store->file)
        error = errno;
    else
        status = unpack(ctx, path, source, fileno(store->file), &error);
    if (error) {
        sc_size_text(bytes, size);
        sc_warn(ctx,
                "%s: its %d phases cannot be unpacked to %s, where they take %s: %s; each is read "
                "from the beginning of the file instead, which takes longer; name a directory "
                "that has room: TMPDIR=DIRECTORY",
                path, source->series.count, store->folder, size, strerror(error));
        store->failed = true;
        return SC_OK;
    }
    return status == SC_OK ? sc_text_copy(ctx, path, &store->path) : status;
}

/* ---- one phase ---- */

/* Let @p source, which is in memory, keep one phase alone. */
static void keep_loaded(sc_source *source, size_t phase)
{
    const size_t each = sc_voxel_type_bytes(source->type), voxels = sc_source_voxels(source);
    unsigned char *data = source->reader.data;

    if (!source->series.side_by_side) {
        memmove(data, data + phase * voxels * each, voxels * each);
        return;
    }
    for (size_t i = 0; i < voxels; i++)
        memmove(data + i * each, data + (i * (size_t)source->series.count + phase) * each, each);
}

/* Read all values of a file where those of a voxel stand side by side, and keep those of one phase
 * in memory. */
static sc_status pick(const sc_ctx *ctx, const char *path, size_t phase, sc_source *source)
{
    const sc_source all = all_values(source);
    const size_t total = sc_source_voxels(&all), each = sc_voxel_type_bytes(source->type);
    const size_t phases = (size_t)source->series.count;
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;
    SC_OWN(sc_free_at) void *values = NULL;
    unsigned char *to;

    SC_PASS(sc_volume_memory_check(ctx, path, source->size,
                                   (double)sc_source_voxels(source) * (double)each));
    SC_PASS(sc_alloc(ctx, sc_source_voxels(source), each, &values));
    to = values;
    SC_PASS(sc_stream_open(ctx, path, &all, &stream));
    for (size_t at = 0, count; at < total; at += count) {
        const void *raw;

        SC_PASS(sc_stream_next_raw(stream, &raw, &count));
        for (size_t i = (phase + phases - at % phases) % phases; i < count; i += phases) {
            memcpy(to, (const unsigned char *)raw + i * each, each);
            to += each;
        }
    }
    SC_PASS(sc_stream_finish(stream)); /* and nothing reads the data any more */
    if (source->reader.release)
        source->reader.release(source->reader.data);
    source->stored.encoding = SC_ENCODING_LOADED;
    source->reader.data = values;
    source->reader.release = sc_free;
    values = NULL;
    return SC_OK;
}

/* Log that a file holds several phases, of which none was chosen. @return SC_ERR_DATA. */
static sc_status refuse_several(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                                const sc_source *source)
{
    if (choice->is_image)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: holds %d images, one for each time (4-D), expected one, which is shown "
                       "with all phases of the volume; write the one that fits into a file of its "
                       "own, for example by fslroi FILE OUT N 1 or in 3D Slicer",
                       path, source->series.count);
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: holds %d volumes, one for each time (4-D), expected one; cine: {} in the "
                   "job shows them as the phases of a beat, and volume: {path: FILE, phase: N} "
                   "shows one, from 0 to %d",
                   path, source->series.count, source->series.count - 1);
}

sc_status sc_source_choose_phase(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                                 bool header_only, sc_source *source)
{
    const size_t phase = choice->phase > 0 ? (size_t)choice->phase - 1 : 0;
    const uint64_t before =
        phase * (uint64_t)sc_source_voxels(source) * sc_voxel_type_bytes(source->type);
    sc_phase_store *store = choice->store;

    if (source->series.count > 1 && !choice->phase)
        return refuse_several(ctx, path, choice, source);
    if (choice->phase > 1 && choice->phase > source->series.count)
        return sc_fail(ctx, SC_ERR_DATA, "%s: phase: %zu, but %s holds %d, expected 0 to %d",
                       sc_read_where(choice, path), phase, path,
                       source->series.count > 1 ? source->series.count : 1,
                       source->series.count > 1 ? source->series.count - 1 : 0);
    if (source->series.count <= 1 || header_only || source->stored.encoding == SC_ENCODING_SLICES)
        return SC_OK;
    source->series.phase = choice->phase;
    if (source->stored.encoding == SC_ENCODING_LOADED) {
        keep_loaded(source, phase);
        return SC_OK;
    }
    if (store && (source->series.side_by_side || source->stored.encoding != SC_ENCODING_PLAIN)) {
        SC_PASS(fill_store(ctx, path, source, store));
        if (!store->failed) {
            source->stored.encoding = SC_ENCODING_PLAIN;
            source->stored.unpacked = store->file;
            source->stored.offset_bytes = before;
            return SC_OK;
        }
    }
    if (source->series.side_by_side)
        return pick(ctx, path, phase, source);
    *(source->stored.encoding == SC_ENCODING_PLAIN ? &source->stored.offset_bytes
                                                   : &source->stored.skip_bytes) += before;
    return SC_OK;
}
