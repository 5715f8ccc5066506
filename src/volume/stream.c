/* SPDX-License-Identifier: BSD-3-Clause */
/* The voxels of a volume file as whole numbers, block by block: unpacked, brought into the byte
 * order of this machine, scaled, and checked to be whole. */
#include "source.h"

#include <errno.h>
#include <fcntl.h>
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
    VOXEL_BYTES_MAX = 8
};

struct sc_voxel_stream {
    const sc_ctx *ctx;
    const char *path;
    const sc_source *source;
    size_t position; /* voxels delivered so far */
    FILE *plain;     /* open for SC_ENCODING_PLAIN, and for the packed bytes of SC_ENCODING_ZLIB */
    gzFile gzip;     /* open for SC_ENCODING_GZIP */
    z_stream zlib;
    bool zlib_open;        /* zlib is in use, and has to be ended */
    bool zlib_end;         /* the end was read, its check sum right */
    bool zlib_memory;      /* there was no memory to unpack */
    unsigned char *packed; /* [PACKED_BYTES], of SC_ENCODING_ZLIB */
    unsigned char *slab;   /* of SC_ENCODING_SLICES: the slices that were read last; owned */
    size_t slab_begin, slab_voxels;                       /* which voxels these are */
    unsigned char raw[SC_STREAM_BLOCK * VOXEL_BYTES_MAX]; /* one block, as stored */
};

size_t sc_voxel_type_bytes(sc_voxel_type type)
{
    static const uint8_t bytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

    return bytes[type];
}

/* ---- bytes ---- */

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
    s->plain = fopen(s->source->file, "rb");
    if (!s->plain)
        return sc_fail(s->ctx, sc_input_status(errno), "%s: %s", s->source->file, strerror(errno));
    (void)fseeko(s->plain, (off_t)s->source->offset_bytes,
                 SEEK_SET); /* an error is noticed when reading */
    return SC_OK;
}

/* SC_ENCODING_ZLIB: sets s->plain, s->packed and s->zlib. */
static sc_status open_zlib(sc_voxel_stream *s)
{
    void *packed;
    sc_status status = open_file(s);

    if (status != SC_OK)
        return status;
    status = sc_alloc(s->ctx, PACKED_BYTES, 1, &packed);
    if (status != SC_OK)
        return status;
    s->packed = packed;
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
    void *slab;
    sc_status status;

    if (s->ctx->memory_max_bytes && bytes > (double)s->ctx->memory_max_bytes)
        return sc_fail(s->ctx, SC_ERR_SYSTEM,
                       "%s: is read by %d slices of %d x %d voxels at a time, which take %.1f GiB "
                       "of memory, more than the limit of %.1f GiB; raise the limit where there is "
                       "more memory: --max-memory %.0fG",
                       s->path, source->slices, source->size[0], source->size[1], bytes / gib,
                       (double)s->ctx->memory_max_bytes / gib, ceil(bytes / gib));
    status = sc_alloc(s->ctx, (size_t)source->size[0] * (size_t)source->size[1],
                      (size_t)source->slices * each, &slab);
    if (status == SC_OK)
        s->slab = slab;
    return status;
}

/* Copy voxels [s->position, + count) to s->raw, from slices that are read when they are needed.
 * @return the errors of sc_slices_fn. */
static sc_status next_of_slices(sc_voxel_stream *s, size_t count)
{
    const sc_source *source = s->source;
    const size_t each = sc_voxel_type_bytes(source->type);
    const size_t slice = (size_t)source->size[0] * (size_t)source->size[1];

    for (size_t done = 0, part; done < count; done += part) {
        const size_t at = s->position + done;

        if (at >= s->slab_begin + s->slab_voxels) {
            const int first = (int)(at / slice);
            const int left = source->size[2] - first;
            const int slices = left < source->slices ? left : source->slices;
            const sc_status status =
                source->read_slices(s->ctx, s->path, source, first, slices, s->slab);

            if (status != SC_OK)
                return status;
            s->slab_begin = at;
            s->slab_voxels = (size_t)slices * slice;
        }
        part = s->slab_begin + s->slab_voxels - at;
        part = part < count - done ? part : count - done;
        memcpy(s->raw + done * each, s->slab + (at - s->slab_begin) * each, part * each);
    }
    return SC_OK;
}

sc_status sc_stream_open(const sc_ctx *ctx, const char *path, const sc_source *source,
                         sc_voxel_stream **out)
{
    sc_voxel_stream *s = NULL;
    void *block;
    sc_status status;

    SC_TRY(sc_alloc(ctx, 1, sizeof *s, &block));
    s = block;
    *s = (sc_voxel_stream){.ctx = ctx, .path = path, .source = source};
    if (source->encoding == SC_ENCODING_GZIP)
        SC_TRY(open_gzip(s));
    else if (source->encoding == SC_ENCODING_ZLIB)
        SC_TRY(open_zlib(s));
    else if (source->encoding == SC_ENCODING_PLAIN)
        SC_TRY(open_file(s));
    else if (source->encoding == SC_ENCODING_SLICES)
        SC_TRY(open_slices(s));
    *out = s;
    s = NULL;
out:
    sc_stream_close(s);
    return status;
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
    sc_free(s);
}

sc_status sc_gzip_status(gzFile file)
{
    int error;

    gzerror(file, &error);
    return error == Z_MEM_ERROR ? SC_ERR_MEMORY
           : error == Z_ERRNO   ? SC_ERR_WRITE
           : error < 0          ? SC_ERR_DATA
                                : SC_OK;
}

/* Unpack the next @p bytes bytes into s->raw. @return how many there were: fewer at the end of
 * the stream or where it is damaged; s->zlib.msg tells which, NULL or the reason; s->zlib_memory
 * receives whether memory was out. */
static size_t next_of_zlib(sc_voxel_stream *s, size_t bytes)
{
    z_stream *z = &s->zlib;
    int result = s->zlib_end ? Z_STREAM_END : Z_OK;

    z->next_out = s->raw;
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

/* Read the next @p bytes bytes, unpacked, into s->raw; for all encodings but
 * SC_ENCODING_LOADED. @return SC_ERR_DATA if there are fewer; SC_ERR_MEMORY, SC_ERR_WRITE if
 * unpacking or reading them failed. */
static sc_status next_bytes(sc_voxel_stream *s, size_t bytes)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);
    const char *reason = NULL;
    size_t got = 0;
    int error = 0;
    sc_status status;

    if (s->gzip) {
        const int count = gzread(s->gzip, s->raw, (unsigned)bytes);

        got = count > 0 ? (size_t)count : 0;
        reason = gzerror(s->gzip, &error);
        reason = error < 0 ? reason : NULL;
    } else if (s->zlib_open) {
        got = next_of_zlib(s, bytes);
        reason = s->zlib.msg;
    } else {
        got = fread(s->raw, 1, bytes, s->plain);
    }
    if (got == bytes)
        return SC_OK;
    status = stream_status(s);
    if (status == SC_ERR_MEMORY || status == SC_ERR_WRITE)
        return sc_fail(s->ctx, status, "%s: the voxels cannot be read: %s", s->source->file,
                       status == SC_ERR_MEMORY ? "out of memory"
                       : reason                ? reason
                                               : "I/O error");
    return sc_fail(s->ctx, SC_ERR_DATA, "%s: ends after %zu bytes of voxels, expected %zu%s%s",
                   s->source->file, s->position * each + got, sc_source_voxels(s->source) * each,
                   reason ? "; " : "", reason ? reason : "");
}

/* Read on behind the last voxel of a zlib stream, so that zlib verifies the check sum if the stream
 * ends there; what else it holds is ignored, with a warning. @return SC_ERR_DATA if the check sum
 * is wrong or missing; SC_ERR_MEMORY, SC_ERR_WRITE if that cannot be known. */
static sc_status finish_zlib(sc_voxel_stream *s)
{
    const size_t more = next_of_zlib(s, sizeof s->raw);

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

sc_status sc_stream_finish(sc_voxel_stream *s)
{
    struct stat info;
    const char *reason;
    int error;

    if (s->zlib_open)
        return finish_zlib(s);
    if (!s->gzip)
        return SC_OK;
    /* Reading beyond the last voxel makes zlib verify the check sum of a stream that ends there,
     * or, as in MGH, behind a few tags. */
    for (int i = 0; i < REST_BLOCKS && gzread(s->gzip, s->raw, sizeof s->raw) > 0; i++) {
    }
    reason = gzerror(s->gzip, &error);
    if (error < 0)
        return sc_fail(
            s->ctx, sc_gzip_status(s->gzip), "%s: the compressed data %s: %s", s->source->file,
            sc_gzip_status(s->gzip) == SC_ERR_DATA ? "are damaged" : "cannot be read", reason);
    if (gzeof(s->gzip) && !gzdirect(s->gzip) && !stat(s->source->file, &info) &&
        (int64_t)gzoffset(s->gzip) < (int64_t)info.st_size)
        sc_warn(s->ctx, "%s: bytes after the end of the compressed data are ignored",
                s->source->file);
    return SC_OK;
}

/* ---- values ---- */

/* Reverse the bytes of each of @p count numbers of @p each bytes, in place. */
static void swap_bytes(unsigned char *raw, size_t count, size_t each)
{
    for (size_t i = 0; i < count; i++, raw += each) {
        for (size_t a = 0, b = each - 1; a < b; a++, b--) {
            const unsigned char swap = raw[a];

            raw[a] = raw[b];
            raw[b] = swap;
        }
    }
}

/* Log that voxel @p i of the block that is being read holds @p value, and by @p what why that
 * is no label. @return SC_ERR_DATA always. */
static sc_status bad_voxel(const sc_voxel_stream *s, size_t i, double value, const char *what)
{
    const size_t nx = (size_t)s->source->size[0], ny = (size_t)s->source->size[1];
    const size_t index = s->position + i;

    return sc_fail(s->ctx, SC_ERR_DATA,
                   "%s: voxel (%zu, %zu, %zu) holds %.10g, %s; expected whole label numbers: use a "
                   "segmentation, not a grey-value image or a probability map",
                   s->path, index % nx, index / nx % ny, index / nx / ny, value, what);
}

/* Floats, and integers that the header scales: write slope * value + intercept to out[count].
 * Floats are read from @p raw; integers stand in @p out already. @return SC_ERR_DATA, logged with
 * the position of the voxel, if a result is not a whole number or its magnitude exceeds 2^53. */
static sc_status load_scaled(const sc_voxel_stream *s, const void *raw, size_t count, int64_t *out)
{
    const sc_source *source = s->source;

    for (size_t i = 0; i < count; i++) {
        double value = (double)out[i];

        if (source->type == SC_VOXEL_FLOAT)
            value = ((const float *)raw)[i];
        else if (source->type == SC_VOXEL_DOUBLE)
            value = ((const double *)raw)[i];
        value = source->slope * value + source->intercept;
        if (!isfinite(value))
            return bad_voxel(s, i, value, "not a number");
        if (value != floor(value))
            return bad_voxel(s, i, value, "a fraction");
        if (fabs(value) > 9007199254740992.0) /* 2^53: beyond it a double skips whole numbers */
            return bad_voxel(s, i, value, "too large for a label");
        out[i] = (int64_t)value;
    }
    return SC_OK;
}

/* Copy raw[count], of this type, to out[count]; for load_values only. */
#define WIDEN(type)                                                                                \
    do {                                                                                           \
        const type *in = raw;                                                                      \
        for (size_t i = 0; i < count; i++)                                                         \
            out[i] = (int64_t)in[i];                                                               \
    } while (0)

/* Write the label values of raw[count], stored as the source's type in this machine's byte
 * order, to out[count]. s->position is that of the first. @return SC_ERR_DATA for the first
 * value that is no whole number or too large. */
static sc_status load_values(const sc_voxel_stream *s, const void *raw, size_t count, int64_t *out)
{
    switch (s->source->type) {
    case SC_VOXEL_INT8:
        WIDEN(int8_t);
        break;
    case SC_VOXEL_UINT8:
        WIDEN(uint8_t);
        break;
    case SC_VOXEL_INT16:
        WIDEN(int16_t);
        break;
    case SC_VOXEL_UINT16:
        WIDEN(uint16_t);
        break;
    case SC_VOXEL_INT32:
        WIDEN(int32_t);
        break;
    case SC_VOXEL_UINT32:
        WIDEN(uint32_t);
        break;
    case SC_VOXEL_INT64:
        WIDEN(int64_t);
        break;
    case SC_VOXEL_UINT64:
        WIDEN(uint64_t);
        for (size_t i = 0; i < count; i++) {
            if (out[i] < 0)
                return bad_voxel(s, i, (double)(uint64_t)out[i], "too large for a label");
        }
        break;
    case SC_VOXEL_FLOAT:
    case SC_VOXEL_DOUBLE:
        return load_scaled(s, raw, count, out);
    }
    if (s->source->slope != 1 || s->source->intercept != 0)
        return load_scaled(s, raw, count, out);
    return SC_OK;
}

sc_status sc_stream_next(sc_voxel_stream *s, size_t count, int64_t *out)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);
    const void *raw = s->raw;
    sc_status status = SC_OK;

    if (s->source->encoding == SC_ENCODING_LOADED)
        raw = (const char *)s->source->data + s->position * each;
    else if (s->slab)
        status = next_of_slices(s, count);
    else
        status = next_bytes(s, count * each);
    if (status != SC_OK)
        return status;
    if (s->source->swapped)
        swap_bytes(s->raw, count, each);
    status = load_values(s, raw, count, out);
    s->position += count;
    return status;
}
