/* SPDX-License-Identifier: BSD-3-Clause */
#include "compressed_file.h"

#include "source.h"

#include <errno.h>
#include <sys/stat.h>
#include <zlib.h>

enum {
    BUFFER_BYTES = 1 << 18,
    SKIP_BYTES = 1 << 16,
    PART_BYTES = 1 << 30 /* that are asked for at a time: zlib counts in 32 bits */
};

struct sc_compressed_file {
    const char *path; /* for messages, borrowed */
    FILE *file;       /* owned */
    sc_compression compression;
    bool inflates; /* z is in use */
    int code;      /* of inflate: Z_OK while it goes on */
    z_stream z;
    unsigned char buffer[BUFFER_BYTES];
};

sc_status sc_open_input(const sc_ctx *ctx, const char *path, FILE **out)
{
    *out = fopen(path, "rbe");
    return *out ? SC_OK : sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
}

sc_status sc_input_bytes(const sc_ctx *ctx, const char *path, uint64_t *bytes)
{
    struct stat info;

    if (stat(path, &info))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    *bytes = (uint64_t)info.st_size;
    return SC_OK;
}

bool sc_is_gzip(const char *path, uint64_t offset)
{
    static const unsigned char mark[2] = {0x1f, 0x8b};
    unsigned char begin[2] = {0};
    SC_OWN(sc_fclose_at) FILE *file = fopen(path, "rb");

    return file && !fseeko(file, (off_t)offset, SEEK_SET) &&
           fread(begin, 1, sizeof begin, file) == sizeof begin && !memcmp(begin, mark, sizeof mark);
}

/* Read more of the file behind what is left of p->buffer. */
static void fill(sc_compressed_file *p)
{
    const size_t left = p->z.avail_in;

    if (left)
        memmove(p->buffer, p->z.next_in, left);
    p->z.next_in = p->buffer;
    p->z.avail_in = (uInt)(left + fread(p->buffer + left, 1, BUFFER_BYTES - left, p->file));
}

/* Does a gzip member begin at the next byte? */
static bool has_member(sc_compressed_file *p)
{
    if (p->z.avail_in < 2)
        fill(p);
    return p->z.avail_in >= 2 && p->z.next_in[0] == 0x1f && p->z.next_in[1] == 0x8b;
}

/* Get ready to inflate, if the file is compressed. */
static sc_status begin_inflating(const sc_ctx *ctx, sc_compressed_file *p, uint64_t offset)
{
    static const int windows[] = {[SC_COMPRESSION_GZIP] = MAX_WBITS + 16,
                                  [SC_COMPRESSION_ZLIB] = MAX_WBITS + 32, /* by its header */
                                  [SC_COMPRESSION_DEFLATE] = -MAX_WBITS};

    if (p->compression == SC_COMPRESSION_GZIP && !has_member(p)) {
        (void)fseeko(p->file, (off_t)offset, SEEK_SET);
        p->compression = SC_COMPRESSION_NONE;
    }
    if (p->compression == SC_COMPRESSION_NONE)
        return SC_OK;
    if (inflateInit2(&p->z, windows[p->compression]) != Z_OK)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: no memory to decompress it", p->path);
    p->inflates = true;
    return SC_OK;
}

sc_status sc_compressed_begin(const sc_ctx *ctx, const char *path, FILE *file, uint64_t offset,
                              sc_compression compression, sc_compressed_file **out)
{
    SC_OWN(sc_compressed_close) sc_compressed_file *p = NULL;
    const sc_status status = SC_ALLOC(ctx, 1, &p);

    if (status != SC_OK) {
        fclose(file);
        return status;
    }
    *p = (sc_compressed_file){.path = path, .file = file, .compression = compression};
    (void)fseeko(file, (off_t)offset, SEEK_SET); /* an error is noticed when reading */
    SC_PASS(begin_inflating(ctx, p, offset));
    SC_HAND_OVER(p, out);
    return SC_OK;
}

sc_status sc_compressed_open(const sc_ctx *ctx, const char *path, uint64_t offset,
                             sc_compression compression, sc_compressed_file **out)
{
    FILE *file;

    SC_PASS(sc_open_input(ctx, path, &file));
    return sc_compressed_begin(ctx, path, file, offset, compression, out);
}

void sc_compressed_close(sc_compressed_file **file)
{
    sc_compressed_file *p = *file;

    if (!p)
        return;
    if (p->inflates)
        inflateEnd(&p->z);
    fclose(p->file);
    sc_free(p);
    *file = NULL;
}

bool sc_file_is_compressed(const sc_compressed_file *p)
{
    return p->inflates;
}

size_t sc_compressed_read(sc_compressed_file *p, void *out, size_t bytes)
{
    size_t left = bytes; /* that have not been asked for */

    if (!p->inflates)
        return fread(out, 1, bytes, p->file);
    p->z.next_out = out;
    p->z.avail_out = 0;
    while ((p->z.avail_out || left) && p->code == Z_OK) {
        if (p->z.avail_out == 0) {
            p->z.avail_out = left < PART_BYTES ? (uInt)left : (uInt)PART_BYTES;
            left -= p->z.avail_out;
        }
        if (p->z.avail_in == 0)
            fill(p);
        if (p->z.avail_in == 0)
            break;
        p->code = inflate(&p->z, Z_NO_FLUSH);
        if (p->code == Z_STREAM_END && p->compression == SC_COMPRESSION_GZIP && has_member(p))
            p->code = inflateReset(&p->z);
    }
    return bytes - left - p->z.avail_out;
}

uint64_t sc_compressed_skip(sc_compressed_file *p, uint64_t bytes)
{
    unsigned char room[SKIP_BYTES];
    uint64_t done = 0;

    if (!p->inflates)
        return fseeko(p->file, (off_t)bytes, SEEK_CUR) ? 0 : bytes;
    while (done < bytes) {
        const size_t part = bytes - done < sizeof room ? (size_t)(bytes - done) : sizeof room;
        const size_t got = sc_compressed_read(p, room, part);

        done += got;
        if (got < part)
            break;
    }
    return done;
}

sc_status sc_compressed_status(const sc_compressed_file *p)
{
    if (ferror(p->file))
        return SC_ERR_WRITE;
    if (!p->inflates || p->code == Z_STREAM_END)
        return SC_OK;
    if (p->code != Z_OK)
        return p->code == Z_MEM_ERROR ? SC_ERR_MEMORY : SC_ERR_DATA;
    return p->z.avail_in == 0 && feof(p->file) ? SC_ERR_DATA : SC_OK;
}

const char *sc_compressed_reason(const sc_compressed_file *p)
{
    const sc_status status = sc_compressed_status(p);

    return status == SC_OK           ? NULL
           : status == SC_ERR_MEMORY ? "out of memory"
           : status == SC_ERR_WRITE  ? "I/O error"
           : p->z.msg                ? p->z.msg
                                     : "unexpected end of file";
}

sc_status sc_compressed_check(const sc_ctx *ctx, const sc_compressed_file *p)
{
    const sc_status status = sc_compressed_status(p);

    if (status == SC_OK || status == SC_ERR_DATA)
        return SC_OK;
    return sc_fail(ctx, status, "%s: cannot be read: %s", p->path, sc_compressed_reason(p));
}

bool sc_compressed_has_ended(const sc_compressed_file *p)
{
    return p->inflates && p->code == Z_STREAM_END;
}

uint64_t sc_compressed_rest(sc_compressed_file *p)
{
    uint64_t rest = 0;

    for (; p->z.avail_in; fill(p)) {
        rest += p->z.avail_in;
        p->z.avail_in = 0;
    }
    return rest;
}
