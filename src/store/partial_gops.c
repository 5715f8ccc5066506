/* SPDX-License-Identifier: BSD-3-Clause */
/* Files of partial GOPs. They hold converted pictures, ready for the encoder, so that after an
 * accident these frames need not be drawn again, and so that a GOP whose frames belong to two
 * slices can be put together from both. A file is a sequence of heads, each followed by its
 * picture. The hash in a head covers the rest of the head and the picture. */
#include "internal.h"

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

#define MAGIC "segpart\x01"

/* What precedes each picture in a file, in the byte order of the machine. */
typedef struct picture_head {
    char magic[8];
    uint64_t hash;       /* of what follows in the head, and of the picture */
    uint64_t identity;   /* of the job */
    uint64_t bytes;      /* of the picture */
    uint64_t pixel_hash; /* sc_image_hash of the frame */
    int64_t frame;
} picture_head;

/* @return what head->hash has to be: covers the members behind it, which must be set, and
 * head->bytes bytes of the picture. */
static uint64_t hash_of(const picture_head *head, const void *picture)
{
    const size_t from = offsetof(picture_head, identity);
    const uint64_t seed = sc_hash_bytes((const char *)head + from, sizeof *head - from, 0);

    return sc_hash_bytes(picture, head->bytes, seed);
}

sc_status sc_partial_open(const sc_ctx *ctx, const char *directory, uint64_t identity,
                          size_t picture_bytes, int frames, sc_partial_gops *out)
{
    void *locations;

    SC_PASS(sc_alloc(ctx, (size_t)frames, sizeof *out->locations, &locations));
    *out = (sc_partial_gops){.identity = identity,
                             .picture_bytes = picture_bytes,
                             .frames = frames,
                             .locations = locations,
                             .stream_gop = -1};
    if (strlen(directory) >= sizeof out->directory) {
        sc_free(locations);
        *out = (sc_partial_gops){0};
        return sc_fail(ctx, SC_ERR_CREATE, "%.60s...: the path is too long", directory);
    }
    strcpy(out->directory, directory);
    for (int k = 0; k < frames; k++)
        out->locations[k].file = -1;
    return SC_OK;
}

/* Append a copy of @p path to the list of files, and set @p index to its place in it.
 * @return SC_ERR_MEMORY. */
static sc_status add_file(const sc_ctx *ctx, sc_partial_gops *partial, const char *path, int *index)
{
    sc_text copy = {0};

    if (partial->file_count == partial->file_capacity) {
        const int capacity = partial->file_capacity ? 2 * partial->file_capacity : 16;

        SC_PASS(SC_RESIZE(ctx, (size_t)partial->file_count, (size_t)capacity, &partial->files));
        partial->file_capacity = capacity;
    }
    SC_PASS(sc_text_add(ctx, &copy, "%s", path));
    *index = partial->file_count;
    partial->files[partial->file_count++] = copy.data;
    return SC_OK;
}

/* Read the next head and its picture, of partial->picture_bytes, from the stream. @return false at
 * the end, and if they are damaged or of another job; @p head and @p picture hold anything then. */
static bool read_picture(const sc_partial_gops *partial, FILE *stream, picture_head *head,
                         void *picture)
{
    return fread(head, sizeof *head, 1, stream) == 1 &&
           !memcmp(head->magic, MAGIC, sizeof head->magic) && head->identity == partial->identity &&
           head->bytes == partial->picture_bytes && head->frame >= 0 &&
           head->frame < partial->frames && fread(picture, head->bytes, 1, stream) == 1 &&
           hash_of(head, picture) == head->hash;
}

sc_status sc_partial_scan(const sc_ctx *ctx, sc_partial_gops *partial, const char *path, int first,
                          int count)
{
    SC_OWN(sc_fclose_at) FILE *stream = fopen(path, "rb");
    SC_OWN(sc_free_at) void *picture = NULL;
    picture_head head;
    long at = 0;
    int index;

    if (!stream)
        return SC_OK; /* removed by a process that has written the segment meanwhile */
    SC_PASS(sc_alloc(ctx, partial->picture_bytes, 1, &picture));
    SC_PASS(add_file(ctx, partial, path, &index));
    partial->scanned_count = partial->file_count;
    while (read_picture(partial, stream, &head, picture) && head.frame >= first &&
           head.frame < first + count) {
        partial->locations[head.frame] =
            (sc_picture_location){index, (uint64_t)at, head.pixel_hash};
        at = ftell(stream);
    }
    return SC_OK;
}

bool sc_is_partial_of(const char *path, uint64_t identity)
{
    FILE *stream = fopen(path, "rb");
    picture_head head;
    size_t bytes;

    if (!stream)
        return false;
    bytes = fread(&head, 1, sizeof head, stream);
    fclose(stream);
    return bytes == 0 || (bytes == sizeof head && !memcmp(head.magic, MAGIC, sizeof head.magic) &&
                          head.identity == identity);
}

/* Make a new file of GOP @p gop, NNNNNN.HOST.PID.part or, if that is there already (of a process
 * that had the same number, and may have been killed while it wrote), NNNNNN.HOST.PID-N.part. Sets
 * stream and stream_file. */
static sc_status make_file(const sc_ctx *ctx, sc_partial_gops *partial, int gop)
{
    char host[SC_HOST_BYTES];
    SC_OWN(sc_text_clear) sc_text path = {0};
    int fd = -1;
    sc_status status;

    sc_host_name(host);
    for (int n = 0; fd < 0; n++) {
        char again[16] = "";

        if (n > 0)
            snprintf(again, sizeof again, "-%d", n);
        sc_text_clear(&path);
        SC_PASS(sc_text_add(ctx, &path, "%s/%06d.%s.%ld%s.part", partial->directory, gop, host,
                            (long)getpid(), again));
        fd = open(path.data, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (fd < 0 && (errno != EEXIST || n == 1000))
            return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", path.data,
                           sc_reason(errno));
    }
    status = add_file(ctx, partial, path.data, &partial->stream_file);
    if (status == SC_OK)
        partial->stream = fdopen(fd, "ab");
    if (!partial->stream) {
        close(fd);
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path.data);
    }
    return status;
}

/* Flush and close the file that is being written, if any, and open that of GOP @p gop for
 * appending: one that this process has made before, or a new one. Sets stream, stream_gop and
 * stream_file. @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
static sc_status open_stream(const sc_ctx *ctx, sc_partial_gops *partial, int gop)
{
    char prefix[32];
    sc_status status = SC_OK;

    SC_PASS(sc_partial_sync(ctx, partial));
    snprintf(prefix, sizeof prefix, "/%06d.", gop);
    for (int i = partial->scanned_count; i < partial->file_count && !partial->stream; i++) {
        const char *name = strrchr(partial->files[i], '/');

        if (!name || strncmp(name, prefix, strlen(prefix)) != 0)
            continue;
        partial->stream =
            fopen(partial->files[i], "ab"); /* its end is whole: writing did not fail */
        partial->stream_file = i;
        if (!partial->stream)
            return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be opened: %s", partial->files[i],
                           sc_reason(errno));
        fseek(partial->stream, 0, SEEK_END);
    }
    if (!partial->stream)
        status = make_file(ctx, partial, gop);
    partial->stream_gop = gop;
    return status;
}

sc_status sc_partial_add(const sc_ctx *ctx, sc_partial_gops *partial, int gop, int frame,
                         const void *picture, uint64_t hash)
{
    picture_head head = {.magic = MAGIC,
                         .identity = partial->identity,
                         .bytes = partial->picture_bytes,
                         .pixel_hash = hash,
                         .frame = frame};
    long at;

    if (partial->stream_gop != gop || !partial->stream)
        SC_PASS(open_stream(ctx, partial, gop));
    head.hash = hash_of(&head, picture);
    at = ftell(partial->stream);
    if (fwrite(&head, sizeof head, 1, partial->stream) != 1 ||
        fwrite(picture, head.bytes, 1, partial->stream) != 1 || fflush(partial->stream))
        return sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s",
                       partial->files[partial->stream_file], sc_reason(errno));
    partial->locations[frame] = (sc_picture_location){partial->stream_file, (uint64_t)at, hash};
    return SC_OK;
}

sc_status sc_partial_read(const sc_ctx *ctx, const sc_partial_gops *partial, int frame,
                          void *picture)
{
    const sc_picture_location *location = &partial->locations[frame];
    FILE *stream = fopen(partial->files[location->file], "rb");
    picture_head head;
    bool ok;

    if (!stream && errno == ENOENT)
        return sc_fail(ctx, SC_ERR_INCOMPLETE,
                       "%s: is gone: another run in this directory has made a segment of it; run "
                       "again with --resume",
                       partial->files[location->file]);
    if (!stream)
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be opened: %s",
                       partial->files[location->file], sc_reason(errno));
    ok = !fseek(stream, (long)location->offset, SEEK_SET) &&
         read_picture(partial, stream, &head, picture) && head.frame == frame;
    fclose(stream);
    return ok ? SC_OK
              : sc_fail(ctx, SC_ERR_DATA, "%s: the picture of frame %d is damaged",
                        partial->files[location->file], frame);
}

sc_status sc_partial_sync(const sc_ctx *ctx, sc_partial_gops *partial)
{
    sc_status status = SC_OK;

    if (!partial->stream)
        return SC_OK;
    if (fflush(partial->stream) || (fsync(fileno(partial->stream)) && errno != EINVAL))
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s",
                         partial->files[partial->stream_file], sc_reason(errno));
    fclose(partial->stream);
    partial->stream = NULL;
    return status;
}

void sc_partial_remove(sc_partial_gops *partial, int gop, int first, int count)
{
    char prefix[32];

    snprintf(prefix, sizeof prefix, "/%06d.", gop);
    if (partial->stream && partial->stream_gop == gop) {
        fclose(partial->stream); /* without fsync, since it is removed below */
        partial->stream = NULL;
    }
    for (int i = 0; i < partial->file_count; i++) {
        const char *name = strrchr(partial->files[i], '/');

        if (name && !strncmp(name, prefix, strlen(prefix)))
            unlink(partial->files[i]);
    }
    for (int k = first; k < first + count; k++)
        partial->locations[k].file = -1;
}

void sc_partial_forget(sc_partial_gops *partial)
{
    for (int i = 0; i < partial->file_count; i++)
        sc_free(partial->files[i]);
    partial->file_count = partial->scanned_count = 0;
    for (int k = 0; k < partial->frames; k++)
        partial->locations[k].file = -1;
}

void sc_partial_close(sc_partial_gops *partial)
{
    if (partial->stream)
        fclose(partial->stream);
    for (int i = 0; i < partial->file_count; i++)
        sc_free(partial->files[i]);
    sc_free(partial->files);
    sc_free(partial->locations);
    *partial = (sc_partial_gops){0};
}
