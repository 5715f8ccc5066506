/* SPDX-License-Identifier: BSD-3-Clause */
/* Slices of an array that lies in chunks: the chunks that hold some slices are unpacked side by
 * side by several threads, straight into these slices. */
#include "chunked/chunks.h"

#include <errno.h>
#include <unistd.h>

/* So many bytes of slices are read at a time, or one layer of chunks. */
enum { SLICES_BYTES = 32 << 20 };

/* The slices that are being read: a box of voxels of the array. */
typedef struct chunk_slices {
    const sc_chunked *chunked;
    size_t low[3], high[3]; /* the first voxel along x, y, z, and the one behind the last */
    size_t grid[3];         /* chunks along x, y, z that hold them */
    size_t first_chunk[3];  /* the number of the first of them */
    unsigned char *out;     /* [high - low] along z, y, x */
} chunk_slices;

void sc_chunked_clear(sc_chunked *chunked)
{
    for (int i = 0; i < chunked->threads && chunked->rooms; i++) {
        sc_free(chunked->rooms[i].packed);
        sc_free(chunked->rooms[i].unpacked[0]);
        sc_free(chunked->rooms[i].unpacked[1]);
    }
    sc_free(chunked->rooms);
    sc_free(chunked->failures);
    sc_free(chunked->places);
    *chunked = (sc_chunked){0};
}

/* Copy @p count values of @p each bytes, the first at @p from and the others @p step values apart;
 * @p swap: with their bytes reversed. */
static void copy_values(const unsigned char *from, size_t step, size_t count, size_t each,
                        bool swap, unsigned char *to)
{
    if (step == 1 && !swap) {
        memcpy(to, from, count * each);
        return;
    }
    for (size_t i = 0; i < count; i++, from += step * each, to += each) {
        for (size_t k = 0; k < each; k++)
            to[k] = from[swap ? each - 1 - k : k];
    }
}

/* Copy the part of a chunk that lies in the slices to these. @param low, high the voxels of the
 * chunk along x, y, z that do. */
static void copy_chunk(const chunk_slices *s, const sc_chunk *chunk, const size_t low[3],
                       const size_t high[3])
{
    const size_t each = s->chunked->voxel_bytes, *size = s->chunked->chunk;
    const size_t nx = s->high[0] - s->low[0], ny = s->high[1] - s->low[1];

    for (size_t z = low[2]; z < high[2]; z++) {
        for (size_t y = low[1]; y < high[1]; y++) {
            unsigned char *to =
                s->out + (((z - s->low[2]) * ny + y - s->low[1]) * nx + low[0] - s->low[0]) * each;
            const unsigned char *from =
                chunk->values + (z % size[2] * chunk->strides[2] + y % size[1] * chunk->strides[1] +
                                 low[0] % size[0] * chunk->strides[0]) *
                                    each;

            copy_values(from, chunk->strides[0], high[0] - low[0], each, chunk->swapped, to);
        }
    }
}

/* sc_range_fn: read chunks of the slices; @p user is a chunk_slices. */
static void read_chunks(void *user, size_t begin, size_t end, int thread)
{
    const chunk_slices *s = user;
    const sc_chunked *chunked = s->chunked;
    sc_chunk_failure *failure = &chunked->failures[thread];

    for (size_t item = begin; item < end; item++) {
        const size_t number[3] = {item % s->grid[0] + s->first_chunk[0],
                                  item / s->grid[0] % s->grid[1] + s->first_chunk[1],
                                  item / s->grid[0] / s->grid[1] + s->first_chunk[2]};
        size_t low[3], high[3];
        sc_chunk chunk = {0};

        for (int i = 0; i < 3; i++) {
            const size_t first = number[i] * chunked->chunk[i], behind = first + chunked->chunk[i];

            low[i] = first > s->low[i] ? first : s->low[i];
            high[i] = behind < s->high[i] ? behind : s->high[i];
        }
        failure->now = item;
        if (chunked->load(chunked->user, &chunked->rooms[thread], number, failure, &chunk))
            copy_chunk(s, &chunk, low, high);
        failure->absent += chunk.absent;
    }
}

/* @return the place of a chunk among all that are read. */
static size_t item_of(const sc_chunked *chunked, const size_t number[3])
{
    size_t first[3], count[3];

    sc_chunked_box(chunked, first, count);
    return ((number[2] - first[2]) * count[1] + number[1] - first[1]) * count[0] + number[0] -
           first[0];
}

/* Open the file of the chunk that is being read, or the same name with chunked->ending. */
static int open_stored(const sc_chunked *chunked, sc_chunk_failure *failure, uint64_t *bytes)
{
    const size_t length = strlen(failure->key);
    int fd = sc_chunk_open_file(chunked->directory, failure->key, bytes);

    if (fd < 0 && errno == ENOENT && chunked->ending && !chunked->places) {
        snprintf(failure->key + length, sizeof failure->key - length, "%s", chunked->ending);
        fd = sc_chunk_open_file(chunked->directory, failure->key, bytes);
    }
    return fd;
}

bool sc_chunk_read_stored(const sc_chunked *chunked, const sc_chunk_room *room,
                          const size_t number[3], sc_chunk_failure *failure, size_t *bytes)
{
    const sc_chunk_place *found =
        chunked->places ? &chunked->places[item_of(chunked, number)] : NULL;
    char why[SC_CHUNK_WHY_BYTES] = "";
    sc_chunk_place place;
    uint64_t file_bytes = 0;
    sc_status status = SC_ERR_DATA;
    int fd;

    *bytes = SIZE_MAX;
    if (found && found->bytes == UINT64_MAX)
        return true;
    chunked->name(chunked->user, number, failure->key);
    fd = open_stored(chunked, failure, &file_bytes);
    if (fd < 0)
        return (errno == ENOENT && !found) || sc_chunk_note_unopened(failure);
    place = found ? *found : (sc_chunk_place){0, file_bytes};
    if (place.begin > file_bytes || place.bytes > file_bytes - place.begin) {
        snprintf(why, sizeof why, "the index of the shard leads behind the end of the file");
    } else if (place.bytes > chunked->packed_bytes) {
        snprintf(why, sizeof why, "has %llu bytes, more than a chunk of %zu bytes can take",
                 (unsigned long long)place.bytes, chunked->chunk_bytes);
    } else if (!sc_chunk_read_at(fd, place.begin, (size_t)place.bytes, room->packed)) {
        status = errno ? SC_ERR_WRITE : SC_ERR_DATA;
        snprintf(why, sizeof why, "%s", errno ? "cannot be read: I/O error" : "has become shorter");
    }
    close(fd);
    *bytes = (size_t)place.bytes;
    return !why[0] || sc_chunk_note(failure, status, why);
}

/* Allocate what the threads work on, and find the chunks. What was allocated sc_chunked_clear
 * frees. */
static sc_status begin_rooms(const sc_ctx *ctx, sc_chunked *chunked)
{
    if (chunked->rooms)
        return SC_OK;
    SC_PASS(SC_ZALLOC(ctx, (size_t)chunked->threads, &chunked->failures));
    SC_PASS(SC_ZALLOC(ctx, (size_t)chunked->threads, &chunked->rooms));
    for (int i = 0; i < chunked->threads; i++) {
        SC_PASS(sc_alloc(ctx, chunked->packed_bytes, 1, &chunked->rooms[i].packed));
        for (int k = 0; k < 2; k++) {
            if (chunked->room_bytes[k])
                SC_PASS(sc_alloc(ctx, chunked->room_bytes[k], 1, &chunked->rooms[i].unpacked[k]));
        }
        chunked->failures[i].chunk = SIZE_MAX;
    }
    return chunked->finder ? sc_chunked_find(ctx, chunked) : SC_OK;
}

sc_status sc_chunked_slices(const sc_ctx *ctx, const char *path, const sc_source *source, int first,
                            int count, void *out)
{
    sc_chunked *chunked = source->reader.data;
    chunk_slices s = {.chunked = chunked, .out = out};
    size_t absent = 0;

    (void)path; /* messages name the file of the chunk */
    SC_PASS(begin_rooms(ctx, chunked));
    for (int i = 0; i < 3; i++) {
        s.low[i] = chunked->low[i] + (i == 2 ? (size_t)first : 0);
        s.high[i] = s.low[i] + (i == 2 ? (size_t)count : chunked->part[i]);
        s.first_chunk[i] = s.low[i] / chunked->chunk[i];
        s.grid[i] = (s.high[i] - 1) / chunked->chunk[i] - s.first_chunk[i] + 1;
    }
    sc_parallel_for(chunked->threads, s.grid[0] * s.grid[1] * s.grid[2], 1, read_chunks, &s);
    chunked->done += s.grid[0] * s.grid[1] * s.grid[2];
    SC_PASS(sc_chunked_failed(ctx, chunked));
    for (int i = 0; i < chunked->threads; i++)
        absent += chunked->failures[i].absent;
    if (absent && (size_t)first + (size_t)count == chunked->part[2])
        sc_info(ctx, "%s: %zu of %zu chunks are not there; they count as %s", chunked->path, absent,
                chunked->done, chunked->absent);
    return SC_OK;
}

size_t sc_chunk_packed_most(size_t bytes)
{
    return bytes + bytes / 8 + 65536; /* more than any codec adds to what it cannot compress */
}

sc_status sc_chunked_threads(const sc_ctx *ctx, double more_bytes, sc_chunked *chunked)
{
    const double limit = (double)ctx->memory_max_bytes;
    const double needed_bytes = (double)chunked->packed_bytes + (double)chunked->room_bytes[0] +
                                (double)chunked->room_bytes[1] + more_bytes;

    chunked->threads = ctx->threads > 1 ? ctx->threads : 1;
    while (chunked->threads > 1 && limit > 0 && chunked->threads * needed_bytes > limit / 4)
        chunked->threads--;
    return sc_memory_check(ctx, needed_bytes, "", "%s: has chunks of %s, to read which takes",
                           chunked->path,
                           sc_size_text((double)chunked->chunk_bytes, (char[24]){0}));
}

/* Set how many slices of @p source are read at a time. */
static void choose_slices(const sc_chunked *chunked, sc_source *source)
{
    const double slice_bytes =
        (double)source->size[0] * source->size[1] * (double)chunked->voxel_bytes;
    const int64_t layer =
        (int64_t)chunked->chunk[2] < source->size[2] ? (int64_t)chunked->chunk[2] : source->size[2];
    const int64_t slices = layer * ((int64_t)(SLICES_BYTES / (slice_bytes * (double)layer)) + 1);

    source->reader.slices = (int)(slices < source->size[2] ? slices : source->size[2]);
    if (slices < source->size[2])
        source->reader.first_slices =
            (int)(slices - (int64_t)(chunked->low[2] % chunked->chunk[2]));
}

/* Check that the part does not lie in more than SC_CHUNKS_MAX chunks. */
static sc_status check_count(const sc_ctx *ctx, const char *path, const sc_chunked *chunked)
{
    size_t first[3], count[3];
    double chunks = 1;

    sc_chunked_box(chunked, first, count);
    for (int i = 0; i < 3; i++)
        chunks *= (double)count[i];
    if (chunks <= SC_CHUNKS_MAX)
        return SC_OK;
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: what is to be read lies in %.0f chunks of %zu x %zu x %zu voxels, expected "
                   "at most %d; choose a part (volume.box) or a coarser level (volume.level), or "
                   "write it anew with larger chunks",
                   path, chunks, chunked->chunk[0], chunked->chunk[1], chunked->chunk[2],
                   SC_CHUNKS_MAX);
}

sc_status sc_chunked_begin(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                           bool header_only, sc_chunked *chunked, sc_source *source)
{
    int low[3];

    SC_PASS(sc_source_take_part(ctx, path, choice, low, source));
    for (int i = 0; i < 3; i++) {
        chunked->low[i] = (size_t)low[i];
        chunked->part[i] = (size_t)source->part[i];
    }
    choose_slices(chunked, source);
    if (!header_only) /* what has no chunk at all may promise a tebibyte */
        SC_PASS(sc_volume_memory_check(ctx, path, source->size, 0));
    return check_count(ctx, path, chunked);
}
