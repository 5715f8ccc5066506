/* SPDX-License-Identifier: BSD-3-Clause */
/* Pictures of a group of pictures that is not whole yet, as the encoder takes them: after an
 * accident they need not be drawn again, and the group of two slices is put together from both. A
 * file is a list of records, each of which proves itself. */
#include "internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAGIC "segpart\x01"

typedef struct record {
    char magic[8];
    uint64_t hash; /* of what follows, and of the picture */
    uint64_t identity, bytes, pixel_hash;
    int64_t frame;
} record;

static uint64_t hash_of(const record *r, const void *picture)
{
    const size_t from = offsetof(record, identity);
    const uint64_t seed = sc_hash_bytes((const char *)r + from, sizeof *r - from, 0);

    return sc_hash_bytes(picture, r->bytes, seed);
}

sc_status sc_parts_open(const sc_ctx *ctx, const char *directory, uint64_t identity,
                        size_t picture_bytes, int frames, sc_parts *out)
{
    void *places;
    sc_status status = sc_alloc(ctx, (size_t)frames, sizeof *out->places, &places);

    if (status != SC_OK)
        return status;
    *out = (sc_parts){.identity = identity,
                      .picture_bytes = picture_bytes,
                      .frames = frames,
                      .places = places,
                      .stream_group = -1};
    snprintf(out->directory, sizeof out->directory, "%s", directory);
    for (int k = 0; k < frames; k++)
        out->places[k].file = -1;
    return SC_OK;
}

static sc_status note_file(const sc_ctx *ctx, sc_parts *parts, const char *path, int *index)
{
    sc_text copy = {0};
    sc_status status;

    if (parts->file_count == parts->file_capacity) {
        const int capacity = parts->file_capacity ? 2 * parts->file_capacity : 16;
        void *grown;

        SC_TRY(sc_alloc(ctx, (size_t)capacity, sizeof *parts->files, &grown));
        if (parts->file_count)
            memcpy(grown, parts->files, (size_t)parts->file_count * sizeof *parts->files);
        sc_free(parts->files);
        parts->files = grown;
        parts->file_capacity = capacity;
    }
    SC_TRY(sc_text_add(ctx, &copy, "%s", path));
    *index = parts->file_count;
    parts->files[parts->file_count++] = copy.data;
out:
    return status;
}

/* Read the record at the stream's place, and its picture. @return false if it proves nothing. */
static bool read_record(const sc_parts *parts, FILE *stream, record *r, void *picture)
{
    return fread(r, sizeof *r, 1, stream) == 1 && !memcmp(r->magic, MAGIC, sizeof r->magic) &&
           r->identity == parts->identity && r->bytes == parts->picture_bytes && r->frame >= 0 &&
           r->frame < parts->frames && fread(picture, r->bytes, 1, stream) == 1 &&
           hash_of(r, picture) == r->hash;
}

sc_status sc_parts_scan(const sc_ctx *ctx, sc_parts *parts, const char *path)
{
    FILE *stream = fopen(path, "rb");
    void *picture = NULL;
    record r;
    long at = 0;
    int index;
    sc_status status = SC_OK;

    if (!stream)
        return SC_OK; /* another process has made its segment meanwhile */
    SC_TRY(sc_alloc(ctx, parts->picture_bytes, 1, &picture));
    SC_TRY(note_file(ctx, parts, path, &index));
    while (read_record(parts, stream, &r, picture)) {
        parts->places[r.frame] = (sc_part_place){index, (uint64_t)at, r.pixel_hash};
        at = ftell(stream);
    }
out:
    fclose(stream);
    sc_free(picture);
    return status;
}

static sc_status open_stream(const sc_ctx *ctx, sc_parts *parts, int group)
{
    char path[2 * SC_NAME_BYTES], host[64] = "host";
    sc_status status = sc_parts_sync(ctx, parts);

    if (status != SC_OK)
        return status;
    gethostname(host, sizeof host - 1);
    snprintf(path, sizeof path, "%s/%06d.%s.%ld.part", parts->directory, group, host,
             (long)getpid());
    parts->stream = fopen(path, "ab");
    if (!parts->stream)
        return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", path, strerror(errno));
    fseek(parts->stream, 0, SEEK_END);
    parts->stream_group = group;
    return note_file(ctx, parts, path, &parts->stream_file);
}

sc_status sc_parts_add(const sc_ctx *ctx, sc_parts *parts, int group, int frame,
                       const void *picture, uint64_t hash)
{
    record r = {.magic = MAGIC,
                .identity = parts->identity,
                .bytes = parts->picture_bytes,
                .pixel_hash = hash,
                .frame = frame};
    long at;
    sc_status status;

    if (parts->stream_group != group || !parts->stream)
        SC_TRY(open_stream(ctx, parts, group));
    r.hash = hash_of(&r, picture);
    at = ftell(parts->stream);
    if (fwrite(&r, sizeof r, 1, parts->stream) != 1 ||
        fwrite(picture, r.bytes, 1, parts->stream) != 1 || fflush(parts->stream)) {
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s",
                         parts->files[parts->stream_file], strerror(errno));
        goto out;
    }
    parts->places[frame] = (sc_part_place){parts->stream_file, (uint64_t)at, hash};
    status = SC_OK;
out:
    return status;
}

sc_status sc_parts_read(const sc_ctx *ctx, sc_parts *parts, int frame, void *picture)
{
    const sc_part_place *place = &parts->places[frame];
    FILE *stream = fopen(parts->files[place->file], "rb");
    record r;
    bool ok;

    if (!stream)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s", parts->files[place->file], strerror(errno));
    ok = !fseek(stream, (long)place->offset, SEEK_SET) && read_record(parts, stream, &r, picture) &&
         r.frame == frame;
    fclose(stream);
    return ok ? SC_OK
              : sc_fail(ctx, SC_ERR_DATA, "%s: the picture of frame %d is torn",
                        parts->files[place->file], frame);
}

sc_status sc_parts_sync(const sc_ctx *ctx, sc_parts *parts)
{
    sc_status status = SC_OK;

    if (!parts->stream)
        return SC_OK;
    if (fflush(parts->stream) || (fsync(fileno(parts->stream)) && errno != EINVAL))
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s",
                         parts->files[parts->stream_file], strerror(errno));
    fclose(parts->stream);
    parts->stream = NULL;
    return status;
}

void sc_parts_remove(sc_parts *parts, int group, int first, int count)
{
    char prefix[32];

    snprintf(prefix, sizeof prefix, "/%06d.", group);
    if (parts->stream && parts->stream_group == group) {
        fclose(parts->stream); /* to be removed: need not reach the disk */
        parts->stream = NULL;
    }
    for (int i = 0; i < parts->file_count; i++) {
        const char *name = strrchr(parts->files[i], '/');

        if (name && !strncmp(name, prefix, strlen(prefix)))
            unlink(parts->files[i]);
    }
    for (int k = first; k < first + count; k++)
        parts->places[k].file = -1;
}

void sc_parts_forget(sc_parts *parts)
{
    for (int i = 0; i < parts->file_count; i++)
        sc_free(parts->files[i]);
    parts->file_count = 0;
    for (int k = 0; k < parts->frames; k++)
        parts->places[k].file = -1;
}

void sc_parts_close(sc_parts *parts)
{
    if (parts->stream)
        fclose(parts->stream);
    for (int i = 0; i < parts->file_count; i++)
        sc_free(parts->files[i]);
    sc_free(parts->files);
    sc_free(parts->places);
    *parts = (sc_parts){0};
}
