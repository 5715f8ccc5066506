/* SPDX-License-Identifier: BSD-3-Clause */
/* The voxels of a volume file, block by block, as they are stored, but unpacked. stream_values.c
 * makes labels and numbers of them. */
#include "bytes.h"
#include "stream.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

enum {
    GZIP_BUFFER_BYTES = 1 << 18, /* zlib's default of 8 KiB costs a call of read(2) each */
    PACKED_BYTES = 1 << 18,
    REST_BLOCKS =
        128, /* of sc_voxel_stream.raw: so much is unpacked behind the last voxel, 16 MiB */
    BATCH_VOXELS = 8 << 20 /* most that sc_stream_next_raw delivers of voxels in memory */
};

size_t sc_voxel_type_bytes(sc_voxel_type type)
{
    static const uint8_t bytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

    return bytes[type];
}

/* Open the file of one encoding at its first voxel: s->gzip here, s->plain in open_file, and
 * s->plain with s->zlib and s->packed in open_zlib. What was opened before an error
 * sc_stream_close closes. @return SC_ERR_MISSING, SC_ERR_DATA, SC_ERR_MEMORY. */
static sc_status open_gzip(sc_voxel_stream *s)
{
    const int file = open(s->source->file, O_RDONLY | O_CLOEXEC);

    if (file < 0)
        return sc_fail(s->ctx, sc_input_status(errno), "%s: %s", s->source->file, strerror(errno));
    if (lseek(file, (off_t)s->source->offset_bytes, SEEK_SET) < 0) {
        close(file);
        return sc_fail(s->ctx, SC_ERR_DATA, "%s: the voxels at byte %llu cannot be read",
                       s->source->file, (unsigned long long)s->source->offset_bytes);
    }
    s->gzip = gzdopen(file, "rb");
    if (!s->gzip) { /* the only reason: the descriptor and the mode are right */
        close(file);
        return sc_fail(s->ctx, SC_ERR_MEMORY, "%s: no memory to unpack the voxels",
                       s->source->file);
    }
    gzbuffer(s->gzip, GZIP_BUFFER_BYTES);
    gzseek(s->gzip, (z_off_t)s->source->skip_bytes,
           SEEK_SET); /* an error is noticed when reading */
    return SC_OK;
}

/* SC_ENCODING_PLAIN: sets s->plain. */
static sc_status open_file(sc_voxel_stream *s)
{
    const int copy = s->source->unpacked ? dup(fileno(s->source->unpacked)) : -1;

    s->plain = copy >= 0 ? fdopen(copy, "rb") : fopen(s->source->file, "rb");
    if (!s->plain && copy >= 0)
        close(copy);
    if (!s->plain)
        return sc_fail(s->ctx, sc_input_status(errno), "%s: %s", s->source->file, strerror(errno));
    (void)fseeko(s->plain, (off_t)s->source->offset_bytes,
                 SEEK_SET); /* an error is noticed when reading */
    return SC_OK;
}

/* SC_ENCODING_ZLIB: sets s->plain, s->packed and s->zlib. */
static sc_status open_zlib(sc_voxel_stream *s)
{
    SC_PASS(open_file(s));
    SC_PASS(sc_alloc(s->ctx, PACKED_BYTES, 1, &s->packed));
    if (inflateInit2(&s->zlib, MAX_WBITS + 32) != Z_OK) /* + 32: zlib or gzip, by its header */
        return sc_fail(s->ctx, SC_ERR_MEMORY, "%s: out of memory", s->source->file);
    s->zlib_open = true;
    return SC_OK;
}

/* SC_ENCODING_SLICES: sets s->slab. @return SC_ERR_SYSTEM if so many slices at a time take more
 * memory than a volume may. */
static sc_status open_slices(sc_voxel_stream *s)
{
    static const double gib = 1024.0 * 1024 * 1024;
    const sc_source *source = s->source;
    const size_t each = sc_voxel_type_bytes(source->type);
    const double bytes = (double)source->size[0] * source->size[1] * source->slices * (double)each;

    if (s->ctx->memory_max_bytes && bytes > (double)s->ctx->memory_max_bytes)
        return sc_fail(s->ctx, SC_ERR_SYSTEM,
                       "%s: is read by %d slices of %d x %d voxels at a time, which take %s "
                       "of memory, more than the limit of %s; raise the limit where there is "
                       "more memory: --max-memory %.0fG",
                       s->path, source->slices, source->size[0], source->size[1],
                       sc_size_text(bytes, (char[24]){0}),
                       sc_size_text((double)s->ctx->memory_max_bytes, (char[24]){0}),
                       ceil(bytes / gib));
    return sc_alloc(s->ctx, (size_t)source->size[0] * (size_t)source->size[1],
                    (size_t)source->slices * each, &s->slab);
}

/* Read the slices from voxel @p at on, which is the first of one, into s->slab. @return the errors
 * of sc_slices_fn. */
static sc_status read_slab(sc_voxel_stream *s, size_t at)
{
    const sc_source *source = s->source;
    const size_t slice = (size_t)source->size[0] * (size_t)source->size[1];
    const int first = (int)(at / slice);
    const int left = source->size[2] - first;
    const int most = first == 0 && source->first_slices ? source->first_slices : source->slices;
    const int slices = left < most ? left : most;

    SC_PASS(source->read_slices(s->ctx, s->path, source, first, slices, s->slab));
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
    if (source->encoding == SC_ENCODING_GZIP)
        SC_PASS(open_gzip(s));
    else if (source->encoding == SC_ENCODING_ZLIB)
        SC_PASS(open_zlib(s));
    else if (source->encoding == SC_ENCODING_PLAIN)
        SC_PASS(open_file(s));
    else if (source->encoding == SC_ENCODING_SLICES)
        SC_PASS(open_slices(s));
    *out = s;
    s = NULL;
    return SC_OK;
}

void sc_stream_close(sc_voxel_stream *s)
{
    if (!s)
        return;
    if (s->zlib_open)
        inflateEnd(&s->zlib);
    if (s->gzip)
        gzclose_r(s->gzip);
    if (s->plain)
        fclose(s->plain);
    sc_free(s->packed);
    sc_free(s->slab);
    sc_free(s->batch);
    sc_free(s->ahead);
    sc_free(s);
}

/* Unpack the next @p bytes bytes to @p to. @return how many there were: fewer at the end of
 * the stream or where it is damaged; s->zlib.msg tells which, NULL or the reason; s->zlib_memory
 * receives whether memory was out. */
static size_t next_of_zlib(sc_voxel_stream *s, unsigned char *to, size_t bytes)
{
    z_stream *z = &s->zlib;
    int result = s->zlib_end ? Z_STREAM_END : Z_OK;

    z->next_out = to;
    z->avail_out = (uInt)bytes;
    while (z->avail_out && result == Z_OK) {
        if (z->avail_in == 0) {
            z->next_in = s->packed;
            z->avail_in = (uInt)fread(s->packed, 1, PACKED_BYTES, s->plain);
            if (z->avail_in == 0)
                break;
        }
        result = inflate(z, Z_NO_FLUSH);
    }
    s->zlib_end = s->zlib_end || result == Z_STREAM_END;
    s->zlib_memory = s->zlib_memory || result == Z_MEM_ERROR;
    return bytes - z->avail_out;
}

/* @return as sc_gzip_status for a stream of any encoding. */
static sc_status stream_status(const sc_voxel_stream *s)
{
    if (s->gzip)
        return sc_gzip_status(s->gzip);
    if (s->zlib_memory)
        return SC_ERR_MEMORY;
    return ferror(s->plain) ? SC_ERR_WRITE : SC_OK;
}

/* Write to @p text where in a file of several phases it ends, after @p bytes bytes of the voxels
 * that were asked for; "" for other files. */
static void phase_note(const sc_source *source, size_t bytes, char *text, size_t text_bytes)
{
    const size_t all = sc_source_voxels(source) * sc_voxel_type_bytes(source->type);

    text[0] = '\0';
    if (source->phases <= 1)
        return;
    if (source->phase)
        snprintf(text, text_bytes, " of phase %d", source->phase - 1);
    else if (!source->side_by_side)
        snprintf(text, text_bytes, ", in phase %zu of %d, counted from 0",
                 bytes / (all / (size_t)source->phases), source->phases);
}

/* Read the next @p bytes bytes, unpacked, to @p to; for all encodings but SC_ENCODING_LOADED and
 * SC_ENCODING_SLICES. @return how many there were, of which check_bytes is to be told. */
static size_t pull_bytes(sc_voxel_stream *s, unsigned char *to, size_t bytes)
{
    int count;

    if (s->zlib_open)
        return next_of_zlib(s, to, bytes);
    if (!s->gzip)
        return fread(to, 1, bytes, s->plain);
    count = gzread(s->gzip, to, (unsigned)bytes);
    return count > 0 ? (size_t)count : 0;
}

/* @return what zlib says of the last error, without the number of the file that it was given in
 * place of a name; NULL if there is none. */
static const char *gzip_reason(const sc_voxel_stream *s)
{
    int error;
    const char *text = gzerror(s->gzip, &error), *behind = strstr(text, ">: ");

    return error >= 0 ? NULL : behind && !strncmp(text, "<fd:", 4) ? behind + 3 : text;
}

/* Log why there were only @p got of @p bytes bytes from s->position on. @return SC_ERR_DATA if
 * there are fewer; SC_ERR_MEMORY, SC_ERR_WRITE if unpacking or reading them failed; SC_OK if none
 * is missing. */
static sc_status check_bytes(const sc_voxel_stream *s, size_t got, size_t bytes)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);
    const char *reason = NULL;
    char phases[64];
    sc_status status;

    if (got == bytes)
        return SC_OK;
    if (s->gzip)
        reason = gzip_reason(s);
    else if (s->zlib_open)
        reason = s->zlib.msg;
    status = stream_status(s);
    if (status == SC_ERR_MEMORY || status == SC_ERR_WRITE)
        return sc_fail(s->ctx, status, "%s: the voxels cannot be read: %s", s->source->file,
                       status == SC_ERR_MEMORY ? "out of memory"
                       : reason                ? reason
                                               : "I/O error");
    phase_note(s->source, s->position * each + got, phases, sizeof phases);
    return sc_fail(s->ctx, SC_ERR_DATA, "%s: ends after %zu bytes of voxels%s, expected %zu%s%s",
                   s->source->file, s->position * each + got, phases,
                   sc_source_voxels(s->source) * each, reason ? "; " : "", reason ? reason : "");
}

/* pull_bytes and check_bytes together. */
static sc_status next_bytes(sc_voxel_stream *s, unsigned char *to, size_t bytes)
{
    return check_bytes(s, pull_bytes(s, to, bytes), bytes);
}

/* Read on behind the last voxel of a zlib stream, so that zlib verifies the check sum if the stream
 * ends there; what else it holds is ignored, with a warning. @return SC_ERR_DATA if the check sum
 * is wrong or missing; SC_ERR_MEMORY, SC_ERR_WRITE if that cannot be known. */
static sc_status finish_zlib(sc_voxel_stream *s)
{
    const size_t more = next_of_zlib(s, s->raw, sizeof s->raw);

    if (!s->zlib_end && more < sizeof s->raw)
        return sc_fail(s->ctx, stream_status(s) == SC_OK ? SC_ERR_DATA : stream_status(s),
                       "%s: the compressed data are damaged: %s", s->source->file,
                       s->zlib_memory ? "out of memory"
                       : s->zlib.msg  ? s->zlib.msg
                                      : "they end without check sum");
    if (more)
        sc_warn(s->ctx, "%s: bytes behind the last voxel are ignored", s->source->file);
    return SC_OK;
}

/* @return whether the length of the last gzip member, in the last bytes of a file, is that of all
 * that was unpacked: then nothing follows it, and there is one member. */
static bool ends_with_length(FILE *file, uint64_t unpacked)
{
    unsigned char last[4];

    if (fseeko(file, -(off_t)sizeof last, SEEK_END) || fread(last, 1, sizeof last, file) != 4)
        return false;
    return sc_number_at(last, 4, false) == (uint32_t)unpacked;
}

/* Go through the gzip members of a file from its place on. @return how many bytes stand behind the
 * last of them; 0 also if that cannot be found out. */
static uint64_t count_behind_gzip(FILE *file, unsigned char *in, unsigned char *out, size_t room)
{
    z_stream z = {0};
    uint64_t rest = 0;
    int code = inflateInit2(&z, MAX_WBITS + 16); /* + 16: gzip */

    if (code != Z_OK)
        return 0;
    for (;;) {
        if (!z.avail_in) {
            z.next_in = in;
            z.avail_in = (uInt)fread(in, 1, room, file);
        }
        if (!z.avail_in)
            break;
        if (code == Z_STREAM_END && z.next_in[0] != 0x1f) {
            for (rest = z.avail_in; (z.avail_in = (uInt)fread(in, 1, room, file)) != 0;)
                rest += z.avail_in;
            break;
        }
        if (code == Z_STREAM_END)
            (void)inflateReset(&z);
        z.next_out = out;
        z.avail_out = (uInt)room;
        code = inflate(&z, Z_NO_FLUSH);
        if (code != Z_OK && code != Z_STREAM_END)
            break;
    }
    inflateEnd(&z);
    return rest;
}

/* Warn of bytes behind the end of the gzip members, which zlib skips without a word. Only a file
 * whose last bytes are not the length of its data is gone through once more. */
static void warn_of_rest(const sc_voxel_stream *s)
{
    const off_t begin = (off_t)s->source->offset_bytes;
    FILE *file = fopen(s->source->file, "rb");
    unsigned char *room = file ? malloc((size_t)2 * GZIP_BUFFER_BYTES) : NULL;
    uint64_t rest = 0;

    if (room && !ends_with_length(file, (uint64_t)gztell(s->gzip)) &&
        !fseeko(file, begin, SEEK_SET))
        rest = count_behind_gzip(file, room, room + GZIP_BUFFER_BYTES, GZIP_BUFFER_BYTES);
    if (rest)
        sc_warn(s->ctx, "%s: %llu bytes behind the end of the compressed data are ignored",
                s->source->file, (unsigned long long)rest);
    free(room);
    if (file)
        fclose(file);
}

sc_status sc_stream_finish(sc_voxel_stream *s)
{
    const char *reason;

    if (atomic_load(&s->rounded))
        sc_warn(s->ctx,
                "%s: labels were rounded to whole numbers, which the header's slope of %g had "
                "moved by at most half a step",
                s->path, s->source->slope);
    if (s->zlib_open)
        return finish_zlib(s);
    if (!s->gzip)
        return SC_OK;
    /* Reading beyond the last voxel makes zlib verify the check sum of a stream that ends there,
     * or, as in MGH, behind a few tags. */
    for (int i = 0; i < REST_BLOCKS && gzread(s->gzip, s->raw, sizeof s->raw) > 0; i++) {
    }
    reason = gzip_reason(s);
    if (reason)
        return sc_fail(
            s->ctx, sc_gzip_status(s->gzip), "%s: the compressed data %s: %s", s->source->file,
            sc_gzip_status(s->gzip) == SC_ERR_DATA ? "are damaged" : "cannot be read", reason);
    if (gzeof(s->gzip) && !gzdirect(s->gzip))
        warn_of_rest(s);
    return SC_OK;
}

sc_status sc_stream_stored(sc_voxel_stream *s, size_t count, const void **raw)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);

    *raw = s->raw;
    if (s->source->encoding == SC_ENCODING_LOADED) {
        *raw = (const unsigned char *)s->source->data + s->position * each;
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
    s->ahead_bytes = pull_bytes(s, s->ahead, bytes);
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
        got = pull_bytes(s, s->batch, bytes);
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

    if (s->source->encoding == SC_ENCODING_LOADED) {
        *raw = (const unsigned char *)s->source->data + s->position * each;
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
