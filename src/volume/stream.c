/* SPDX-License-Identifier: BSD-3-Clause */
/* The voxels of a volume file, block by block, as they are stored, but unpacked. stream_values.c
 * makes labels and numbers of them. */
#include "stream.h"

#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

enum {
    REST_BLOCKS =
        128, /* of sc_voxel_stream.raw: so much is unpacked behind the last voxel, 16 MiB */
    BATCH_VOXELS = 8 << 20 /* most that sc_stream_next_raw delivers of voxels in memory */
};

size_t sc_voxel_type_bytes(sc_voxel_type type)
{
    static const uint8_t bytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

    return bytes[type];
}

/* Open the file of an encoding that is streamed at its first voxel. @return SC_ERR_MISSING,
 * SC_ERR_MEMORY. */
static sc_status open_file(sc_voxel_stream *s)
{
    const sc_source *source = s->source;
    const sc_compression packing = source->stored.encoding == SC_ENCODING_GZIP ? SC_COMPRESSION_GZIP
                                   : source->stored.encoding == SC_ENCODING_ZLIB
                                       ? SC_COMPRESSION_ZLIB
                                       : SC_COMPRESSION_NONE;
    const int copy = source->stored.unpacked ? dup(fileno(source->stored.unpacked)) : -1;
    FILE *file = copy >= 0 ? fdopen(copy, "rb") : NULL;

    if (file)
        SC_PASS(sc_compressed_begin(s->ctx, source->stored.file, file, source->stored.offset_bytes,
                                    packing, &s->file));
    else if (copy >= 0)
        close(copy);
    if (!file)
        SC_PASS(sc_compressed_open(s->ctx, source->stored.file, source->stored.offset_bytes,
                                   packing, &s->file));
    if (packing != SC_COMPRESSION_NONE)
        (void)sc_compressed_skip(s->file, source->stored.skip_bytes); /* reading notices an error */
    return SC_OK;
}

/* SC_ENCODING_SLICES: sets s->slab. @return SC_ERR_SYSTEM if so many slices at a time take more
 * memory than a volume may. */
static sc_status open_slices(sc_voxel_stream *s)
{
    const sc_source *source = s->source;
    const size_t each = sc_voxel_type_bytes(source->type);
    const double bytes =
        (double)source->size[0] * source->size[1] * source->reader.slices * (double)each;

    SC_PASS(sc_memory_check(s->ctx, bytes, "",
                            "%s: is read by %d slices of %d x %d voxels at a time, which take",
                            s->path, source->reader.slices, source->size[0], source->size[1]));
    return sc_alloc(s->ctx, (size_t)source->size[0] * (size_t)source->size[1],
                    (size_t)source->reader.slices * each, &s->slab);
}

/* Read the slices from voxel @p at on, which is the first of one, into s->slab. @return the errors
 * of sc_slices_fn. */
static sc_status read_slab(sc_voxel_stream *s, size_t at)
{
    const sc_source *source = s->source;
    const size_t slice = (size_t)source->size[0] * (size_t)source->size[1];
    const int first = (int)(at / slice);
    const int left = source->size[2] - first;
    const int most = first == 0 && source->reader.first_slices ? source->reader.first_slices
                                                               : source->reader.slices;
    const int slices = left < most ? left : most;

    SC_PASS(source->reader.read_slices(s->ctx, s->path, source, first, slices, s->slab));
    s->slab_begin = at;
    s->slab_voxels = (size_t)slices * slice;
    return SC_OK;
}

/* Copy voxels [s->position, + count) to s->raw, from slices that are read when they are needed.
 * @return the errors of sc_slices_fn. */
static sc_status next_of_slices(sc_voxel_stream *s, size_t count)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);

    for (size_t done = 0, part; done < count; done += part) {
        const size_t at = s->position + done;

        if (at >= s->slab_begin + s->slab_voxels)
            SC_PASS(read_slab(s, at));
        part = s->slab_begin + s->slab_voxels - at;
        part = part < count - done ? part : count - done;
        memcpy(s->raw + done * each, s->slab + (at - s->slab_begin) * each, part * each);
    }
    return SC_OK;
}

sc_status sc_stream_open(const sc_ctx *ctx, const char *path, const sc_source *source,
                         sc_voxel_stream **out)
{
    SC_OWN(sc_stream_close_at) sc_voxel_stream *s = NULL;

    SC_PASS(SC_ALLOC(ctx, 1, &s));
    *s = (sc_voxel_stream){.ctx = ctx, .path = path, .source = source};
    if (source->stored.encoding == SC_ENCODING_SLICES)
        SC_PASS(open_slices(s));
    else if (source->stored.encoding != SC_ENCODING_LOADED)
        SC_PASS(open_file(s));
    *out = s;
    s = NULL;
    return SC_OK;
}

void sc_stream_close(sc_voxel_stream *s)
{
    if (!s)
        return;
    sc_compressed_close(&s->file);
    sc_free(s->slab);
    sc_free(s->batch);
    sc_free(s->ahead);
    sc_free(s);
}

/* Write to @p text where in a file of several phases it ends, after @p bytes bytes of the voxels
 * that were asked for; "" for other files. */
static void phase_note(const sc_source *source, size_t bytes, char *text, size_t text_bytes)
{
    const size_t all = sc_source_voxels(source) * sc_voxel_type_bytes(source->type);

    text[0] = '\0';
    if (source->series.count <= 1)
        return;
    if (source->series.phase)
        snprintf(text, text_bytes, " of phase %d", source->series.phase - 1);
    else if (!source->series.side_by_side)
        snprintf(text, text_bytes, ", in phase %zu of %d, counted from 0",
                 bytes / (all / (size_t)source->series.count), source->series.count);
}

/* Log why there were only @p got of @p bytes bytes from s->position on. @return SC_ERR_DATA if
 * there are fewer; SC_ERR_MEMORY, SC_ERR_WRITE if unpacking or reading them failed; SC_OK if none
 * is missing. */
static sc_status check_bytes(const sc_voxel_stream *s, size_t got, size_t bytes)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);
    const char *reason = sc_compressed_reason(s->file);
    char phases[64];

    if (got == bytes)
        return SC_OK;
    SC_PASS(sc_compressed_check(s->ctx, s->file));
    phase_note(s->source, s->position * each + got, phases, sizeof phases);
    return sc_fail(s->ctx, SC_ERR_DATA, "%s: ends after %zu bytes of voxels%s, expected %zu%s%s",
                   s->source->stored.file, s->position * each + got, phases,
                   sc_source_voxels(s->source) * each, reason ? "; " : "", reason ? reason : "");
}

/* Read the next @p bytes bytes, unpacked, to @p to. */
static sc_status next_bytes(sc_voxel_stream *s, unsigned char *to, size_t bytes)
{
    return check_bytes(s, sc_compressed_read(s->file, to, bytes), bytes);
}

/* Read on behind the last voxel of a file that is packed, so that the check sum is verified if the
 * stream ends there, or, as in MGH, behind a few tags. What else it holds is ignored, with a
 * warning. */
static sc_status read_rest(sc_voxel_stream *s)
{
    const bool is_gzip = s->source->stored.encoding == SC_ENCODING_GZIP;
    size_t more = 0, got = 1;
    uint64_t rest;

    for (int i = 0; i < REST_BLOCKS && got; i++) {
        got = sc_compressed_read(s->file, s->raw, sizeof s->raw);
        more += got;
    }
    SC_PASS(sc_compressed_check(s->ctx, s->file));
    if (sc_compressed_reason(s->file))
        return sc_fail(s->ctx, SC_ERR_DATA, "%s: the compressed data are damaged: %s",
                       s->source->stored.file, sc_compressed_reason(s->file));
    if (more && !is_gzip)
        sc_warn(s->ctx, "%s: bytes behind the last voxel are ignored", s->source->stored.file);
    rest = is_gzip && sc_compressed_has_ended(s->file) ? sc_compressed_rest(s->file) : 0;
    if (rest)
        sc_warn(s->ctx, "%s: %llu bytes behind the end of the compressed data are ignored",
                s->source->stored.file, (unsigned long long)rest);
    return SC_OK;
}

sc_status sc_stream_finish(sc_voxel_stream *s)
{
    if (atomic_load(&s->rounded))
        sc_warn(s->ctx,
                "%s: labels were rounded to whole numbers, which the header's slope of %g had "
                "moved by at most half a step",
                s->path, s->source->slope);
    return s->file && sc_file_is_compressed(s->file) ? read_rest(s) : SC_OK;
}

sc_status sc_stream_stored(sc_voxel_stream *s, size_t count, const void **raw)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);

    *raw = s->raw;
    if (s->source->stored.encoding == SC_ENCODING_LOADED) {
        *raw = (const unsigned char *)s->source->reader.data + s->position * each;
        return SC_OK;
    }
    return s->slab ? next_of_slices(s, count) : next_bytes(s, s->raw, count * each);
}

/* @return how many voxels the next batch has. */
static size_t batch_voxels(const sc_voxel_stream *s)
{
    const size_t left = sc_source_voxels(s->source) - s->position;
    const size_t most = SC_BATCH_BYTES / sc_voxel_type_bytes(s->source->type);

    return left < most ? left : most;
}

void sc_stream_read_ahead(sc_voxel_stream *s)
{
    const sc_ctx quiet = sc_quiet(s->ctx);
    const size_t bytes = batch_voxels(s) * sc_voxel_type_bytes(s->source->type);

    if (!s->batch || s->is_ahead || bytes == 0) /* sc_stream_next_raw works in another way */
        return;
    if (!s->ahead && sc_alloc(&quiet, SC_BATCH_BYTES, 1, &s->ahead) != SC_OK)
        return; /* it is read when it is needed */
    s->ahead_bytes = sc_compressed_read(s->file, s->ahead, bytes);
    s->is_ahead = true;
}

/* As sc_stream_next_raw for voxels that are read from a file. */
static sc_status next_batch(sc_voxel_stream *s, const void **raw, size_t *count)
{
    const size_t voxels = batch_voxels(s), bytes = voxels * sc_voxel_type_bytes(s->source->type);
    size_t got = s->ahead_bytes;

    if (!s->batch)
        SC_PASS(sc_alloc(s->ctx, SC_BATCH_BYTES, 1, &s->batch));
    if (s->is_ahead) {
        unsigned char *done = s->batch;

        s->batch = s->ahead;
        s->ahead = done;
        s->is_ahead = false;
    } else {
        got = sc_compressed_read(s->file, s->batch, bytes);
    }
    SC_PASS(check_bytes(s, got, bytes));
    *raw = s->batch;
    *count = voxels;
    return SC_OK;
}

sc_status sc_stream_next_raw(sc_voxel_stream *s, const void **raw, size_t *count)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);
    const size_t left = sc_source_voxels(s->source) - s->position;

    if (s->source->stored.encoding == SC_ENCODING_LOADED) {
        *raw = (const unsigned char *)s->source->reader.data + s->position * each;
        *count = left < BATCH_VOXELS ? left : BATCH_VOXELS;
    } else if (s->slab) {
        SC_PASS(read_slab(s, s->position));
        *raw = s->slab;
        *count = s->slab_voxels;
    } else {
        SC_PASS(next_batch(s, raw, count));
    }
    s->position += *count;
    return SC_OK;
}
