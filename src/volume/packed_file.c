/* SPDX-License-Identifier: BSD-3-Clause */
#include "packed_file.h"

#include "source.h"

#include <errno.h>
#include <sys/stat.h>
#include <zlib.h>

enum {
    PACKED_BYTES = 1 << 18,
    SKIP_BYTES = 1 << 16,
    PART_BYTES = 1 << 30 /* that are asked for at a time: zlib counts in 32 bits */
};

struct sc_packed_file {
    const char *path; /* for messages, borrowed */
    FILE *file;       /* owned */
    sc_packing packing;
    bool inflates; /* z is in use */
    int code;      /* of inflate: Z_OK while it goes on */
    z_stream z;
    unsigned char packed[PACKED_BYTES];
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

/* Read more of the file behind what is left of p->packed. */
static void fill(sc_packed_file *p)
{
    const size_t left = p->z.avail_in;

    if (left)
        memmove(p->packed, p->z.next_in, left);
    p->z.next_in = p->packed;
    p->z.avail_in = (uInt)(left + fread(p->packed + left, 1, PACKED_BYTES - left, p->file));
}

/* Does a gzip member begin at the next byte? */
static bool has_member(sc_packed_file *p)
{
    if (p->z.avail_in < 2)
        fill(p);
    return p->z.avail_in >= 2 && p->z.next_in[0] == 0x1f && p->z.next_in[1] == 0x8b;
}

/* Get ready to inflate, if the file is packed. */
static sc_status begin_inflating(const sc_ctx *ctx, sc_packed_file *p, uint64_t offset)
{
    static const int windows[] = {[SC_PACKING_GZIP] = MAX_WBITS + 16,
                                  [SC_PACKING_ZLIB] = MAX_WBITS + 32, /* by its header */
                                  [SC_PACKING_DEFLATE] = -MAX_WBITS};

    if (p->packing == SC_PACKING_GZIP && !has_member(p)) {
        (void)fseeko(p->file, (off_t)offset, SEEK_SET);
        p->packing = SC_PACKING_NONE;
    }
    if (p->packing == SC_PACKING_NONE)
        return SC_OK;
    if (inflateInit2(&p->z, windows[p->packing]) != Z_OK)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: no memory to unpack it", p->path);
    p->inflates = true;
    return SC_OK;
}

sc_status sc_packed_begin(const sc_ctx *ctx, const char *path, FILE *file, uint64_t offset,
                          sc_packing packing, sc_packed_file **out)
{
    SC_OWN(sc_packed_close) sc_packed_file *p = NULL;
    const sc_status status = SC_ALLOC(ctx, 1, &p);

    if (status != SC_OK) {
        fclose(file);
        return status;
    }
    *p = (sc_packed_file){.path = path, .file = file, .packing = packing};
    (void)fseeko(file, (off_t)offset, SEEK_SET); /* an error is noticed when reading */
    SC_PASS(begin_inflating(ctx, p, offset));
    SC_HAND_OVER(p, out);
    return SC_OK;
}

sc_status sc_packed_open(const sc_ctx *ctx, const char *path, uint64_t offset, sc_packing packing,
                         sc_packed_file **out)
{
    FILE *file;

    SC_PASS(sc_open_input(ctx, path, &file));
    return sc_packed_begin(ctx, path, file, offset, packing, out);
}

void sc_packed_close(sc_packed_file **file)
{
    sc_packed_file *p = *file;

    if (!p)
        return;
    if (p->inflates)
        inflateEnd(&p->z);
    fclose(p->file);
    sc_free(p);
    *file = NULL;
}

bool sc_packed_is_packed(const sc_packed_file *p)
{
    return p->inflates;
}

size_t sc_packed_read(sc_packed_file *p, void *out, size_t bytes)
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
        if (p->code == Z_STREAM_END && p->packing == SC_PACKING_GZIP && has_member(p))
            p->code = inflateReset(&p->z);
    }
    return bytes - left - p->z.avail_out;
}

uint64_t sc_packed_skip(sc_packed_file *p, uint64_t bytes)
{
    unsigned char room[SKIP_BYTES];
    uint64_t done = 0;

    if (!p->inflates)
        return fseeko(p->file, (off_t)bytes, SEEK_CUR) ? 0 : bytes;
    while (done < bytes) {
        const size_t part = bytes - done < sizeof room ? (size_t)(bytes - done) : sizeof room;
        const size_t got = sc_packed_read(p, room, part);

        done += got;
        if (got < part)
            break;
    }
    return done;
}

sc_status sc_packed_status(const sc_packed_file *p)
{
    if (ferror(p->file))
        return SC_ERR_WRITE;
    if (!p->inflates || p->code == Z_STREAM_END)
        return SC_OK;
    if (p->code != Z_OK)
        return p->code == Z_MEM_ERROR ? SC_ERR_MEMORY : SC_ERR_DATA;
    return p->z.avail_in == 0 && feof(p->file) ? SC_ERR_DATA : SC_OK;
}

const char *sc_packed_reason(const sc_packed_file *p)
{
    const sc_status status = sc_packed_status(p);

    return status == SC_OK           ? NULL
           : status == SC_ERR_MEMORY ? "out of memory"
           : status == SC_ERR_WRITE  ? "I/O error"
           : p->z.msg                ? p->z.msg
                                     : "unexpected end of file";
}

sc_status sc_packed_check(const sc_ctx *ctx, const sc_packed_file *p)
{
    const sc_status status = sc_packed_status(p);

    if (status == SC_OK || status == SC_ERR_DATA)
        return SC_OK;
    return sc_fail(ctx, status, "%s: cannot be read: %s", p->path, sc_packed_reason(p));
}

bool sc_packed_has_ended(const sc_packed_file *p)
{
    return p->inflates && p->code == Z_STREAM_END;
}

uint64_t sc_packed_rest(sc_packed_file *p)
{
    uint64_t rest = 0;

    for (; p->z.avail_in; fill(p)) {
        rest += p->z.avail_in;
        p->z.avail_in = 0;
    }
    return rest;
}
