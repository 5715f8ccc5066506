/* SPDX-License-Identifier: BSD-3-Clause */
/* Zarr, versions 2 and 3, OME-Zarr, and N5: which chunks an array has, and where they are. */
#include "chunked/zarr.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { SHARD_CHUNKS_MAX = 1 << 22 };

/* What one thread works on. */
typedef struct zarr_worker {
    unsigned char *packed; /* [packed_bytes], owned */
    unsigned char *chunk;  /* [chunk_bytes + 64], owned */
    unsigned char *index;  /* of the shard index_of, as stored; owned; NULL without shards */
    char index_of[SC_CHUNK_KEY_BYTES];
    size_t shard;  /* the number, of those that are read, of the one that is being read */
    bool *checked; /* [shards that are read]: this thread has read their index; owned */
} zarr_worker;

/* The array while its voxels are read: sc_source.data. */
typedef struct zarr_reading {
    sc_zarr_node node;
    sc_zarr_array array;
    int axis[3];   /* the dimensions that are x, y, z; -1: z of a picture */
    int time_axis; /* the dimension along which phases follow each other; -1: none */
    size_t phase;  /* that which is read */
    size_t packed_bytes, chunk_bytes;
    size_t shard_chunks; /* chunks of a file; 1 without shards */
    sc_chunked chunked;
    zarr_worker *workers; /* [chunked.threads], owned; NULL until the first slices are read */
} zarr_reading;

static void release(void *data)
{
    zarr_reading *r = data;

    if (!r)
        return;
    for (int i = 0; i < r->chunked.threads && r->workers; i++) {
        sc_free(r->workers[i].packed);
        sc_free(r->workers[i].chunk);
        sc_free(r->workers[i].index);
        sc_free(r->workers[i].checked);
    }
    sc_free(r->workers);
    sc_chunked_clear(&r->chunked);
    sc_zarr_node_clear(&r->node);
    sc_free(r);
}

/* ---- the bytes of a chunk ---- */

static uint64_t word64(const unsigned char *at, bool big)
{
    uint64_t value = 0;

    for (int i = 0; i < 8; i++)
        value |= (uint64_t)at[i] << 8 * (big ? 7 - i : i);
    return value;
}

/* Read the index of a shard, the file @p key, to w->index. @return false, with why, if it is
 * damaged. */
static bool read_index(const zarr_reading *r, zarr_worker *w, int fd, uint64_t file_bytes,
                       const char *key, const char **why)
{
    const sc_zarr_array *a = &r->array;
    const size_t entries = 16 * r->shard_chunks, bytes = entries + (a->index_crc ? 4 : 0);
    uint32_t sum = 0;

    w->index_of[0] = '\0';
    *why = "is shorter than the index of a shard";
    if (file_bytes < bytes)
        return false;
    *why = "the index of the shard cannot be read";
    if (!sc_chunk_read_at(fd, a->index_first ? 0 : file_bytes - bytes, bytes, w->index))
        return false;
    for (int i = 0; i < 4 && a->index_crc; i++)
        sum |= (uint32_t)w->index[entries + (size_t)i] << 8 * i;
    *why = "the check sum of the index of the shard is wrong";
    if (a->index_crc && sc_zarr_crc32c(w->index, entries) != sum)
        return false;
    snprintf(w->index_of, sizeof w->index_of, "%s", key);
    w->checked[w->shard] = true;
    return true;
}

/* Find chunk @p number of a shard, the file @p key, in its index: place is where it begins and how
 * many bytes it has, UINT64_MAX if the shard has it not. A thread reads each index as a whole once,
 * and of one that it has left then single entries, so that shards which alternate along a row cost
 * no more than others. @return false, with why, if the index is damaged. */
static bool find_in_shard(const zarr_reading *r, zarr_worker *w, int fd, uint64_t file_bytes,
                          const char *key, size_t number, uint64_t place[2], const char **why)
{
    const sc_zarr_array *a = &r->array;
    const size_t bytes = 16 * r->shard_chunks + (a->index_crc ? 4 : 0);
    const unsigned char *entry = w->index + 16 * number;
    unsigned char again[16];

    if (strcmp(w->index_of, key) && w->checked[w->shard]) {
        *why = "the index of the shard cannot be read";
        if (file_bytes < bytes ||
            !sc_chunk_read_at(fd, (a->index_first ? 0 : file_bytes - bytes) + 16 * number,
                              sizeof again, again))
            return false;
        entry = again;
    } else if (strcmp(w->index_of, key) && !read_index(r, w, fd, file_bytes, key, why)) {
        return false;
    }
    for (size_t i = 0; i < 2; i++)
        place[i] = word64(entry + 8 * i, a->index_big_endian);
    if (place[0] == UINT64_MAX && place[1] == UINT64_MAX)
        return true;
    *why = "the index of the shard leads behind the end of the file";
    return place[0] <= file_bytes && place[1] <= file_bytes - place[0];
}

/* @return how many chunks a file has along x, y or z, as @p i is 0, 1 or 2. */
static size_t chunks_along(const zarr_reading *r, int i)
{
    const sc_zarr_array *a = &r->array;

    return r->axis[i] < 0 ? 1 : (size_t)(a->file_shape[r->axis[i]] / a->chunk[r->axis[i]]);
}

/* Find which files are read: the first of them along x, y, z, and how many. */
static void files_of(const zarr_reading *r, size_t first[3], size_t count[3])
{
    const sc_chunked *c = &r->chunked;

    for (int i = 0; i < 3; i++) {
        const size_t of_file = c->chunk[i] * chunks_along(r, i);

        first[i] = c->low[i] / of_file;
        count[i] = (c->low[i] + c->part[i] - 1) / of_file - first[i] + 1;
    }
}

/* @return the number, of those that are read, of the file that holds the chunk @p at_xyz. */
static size_t file_number(const zarr_reading *r, const size_t at_xyz[3])
{
    size_t first[3], count[3], number = 0;

    files_of(r, first, count);
    for (int i = 2; i >= 0; i--)
        number = number * count[i] + at_xyz[i] / chunks_along(r, i) - first[i];
    return number;
}

/* Write the name of the file that holds chunk @p at (along the dimensions) to @p key, and the
 * number of the chunk within it to *number. */
static void name_file(const zarr_reading *r, const size_t at[SC_ZARR_RANK_MAX],
                      char key[SC_CHUNK_KEY_BYTES], size_t *number)
{
    const sc_zarr_array *a = &r->array;
    size_t used = (size_t)snprintf(key, SC_CHUNK_KEY_BYTES, "%s", a->prefix);

    *number = 0;
    for (int k = 0; k < a->rank; k++) {
        const int i = a->blocks ? a->rank - 1 - k : k;
        const size_t per_file = (size_t)(a->file_shape[i] / a->chunk[i]);

        if (k > 0 || *a->prefix)
            used += (size_t)snprintf(key + used, SC_CHUNK_KEY_BYTES - used, "%c", a->separator);
        used += (size_t)snprintf(key + used, SC_CHUNK_KEY_BYTES - used, "%zu", at[i] / per_file);
        *number = *number * per_file + at[i] % per_file;
    }
}

/* Read the stored bytes of chunk @p number of the open file @p key, which has *bytes bytes, to
 * w->packed. *bytes becomes their number, UINT64_MAX if the file, a shard, has it not. @return
 * false if they cannot be read, noted. */
static bool read_packed(const zarr_reading *r, zarr_worker *w, sc_chunk_failure *failure, int fd,
                        const char *key, size_t number, uint64_t *bytes)
{
    uint64_t place[2] = {0, *bytes};
    const char *why = NULL;
    char reason[SC_CHUNK_WHY_BYTES];

    if (r->array.sharded && !find_in_shard(r, w, fd, *bytes, key, number, place, &why))
        return sc_chunk_note(failure, SC_ERR_DATA, key, why);
    *bytes = place[1];
    if (*bytes == UINT64_MAX)
        return true;
    if (*bytes > r->packed_bytes) {
        snprintf(reason, sizeof reason, "has %llu bytes, more than a chunk of %zu bytes can take",
                 (unsigned long long)*bytes, r->chunk_bytes);
        return sc_chunk_note(failure, SC_ERR_DATA, key, reason);
    }
    if (sc_chunk_read_at(fd, place[0], (size_t)*bytes, w->packed))
        return true;
    return sc_chunk_note(failure, errno ? SC_ERR_WRITE : SC_ERR_DATA, key,
                         errno ? "cannot be read: I/O error" : "has become shorter");
}

/* How far apart neighbours along each dimension lie in an unpacked chunk of this shape, in values.
 */
static void steps_of(const sc_zarr_array *a, const int64_t shape[SC_ZARR_RANK_MAX],
                     size_t out[SC_ZARR_RANK_MAX])
{
    size_t step = 1;

    for (int i = a->rank - 1; i >= 0; i--) {
        out[a->pipeline.order[i]] = step;
        step *= (size_t)shape[a->pipeline.order[i]];
    }
}

/* Describe the chunk of this shape unpacked at @p values to *out: its voxels in the phase that is
 * read. */
static void describe_chunk(const zarr_reading *r, const int64_t shape[SC_ZARR_RANK_MAX],
                           const unsigned char *values, sc_chunk *out)
{
    const sc_zarr_array *a = &r->array;
    const int t = r->time_axis;
    size_t steps[SC_ZARR_RANK_MAX];

    steps_of(a, shape, steps);
    for (int i = 0; i < 3; i++)
        out->strides[i] = r->axis[i] < 0 ? 0 : steps[r->axis[i]];
    out->values = values;
    if (t >= 0)
        out->values += r->phase % (size_t)a->chunk[t] * steps[t] * r->chunked.voxel_bytes;
    out->swapped = r->chunked.voxel_bytes > 1 && a->pipeline.big_endian == SC_IS_LITTLE_ENDIAN;
    out->absent = false;
}

/* Unpack the chunk @p at, whose stored bytes are w->packed[bytes], and describe it to *out. @return
 * false with why. */
static bool unpack_chunk(const zarr_reading *r, zarr_worker *w, const size_t at[SC_ZARR_RANK_MAX],
                         size_t bytes, sc_chunk *out, char why[SC_CHUNK_WHY_BYTES])
{
    const sc_zarr_array *a = &r->array;
    const unsigned char *values;
    int64_t shape[SC_ZARR_RANK_MAX];
    size_t begin = 0;

    memcpy(shape, a->chunk, sizeof shape);
    if (a->blocks && !sc_n5_block_read(a, at, w->packed, bytes, shape, &begin, why))
        return false;
    if (!sc_zarr_unpack(&a->pipeline, w->packed + begin, bytes - begin, w->chunk,
                        sc_zarr_values(a, shape) * r->chunked.voxel_bytes, &values, why))
        return false;
    describe_chunk(r, shape, values, out);
    return true;
}

/* sc_chunk_load_fn of this format; @p user is a zarr_reading. */
static bool load_chunk(void *user, int thread, const size_t at_xyz[3], sc_chunk_failure *failure,
                       sc_chunk *out)
{
    const zarr_reading *r = user;
    zarr_worker *w = &r->workers[thread];
    size_t at[SC_ZARR_RANK_MAX] = {0}, number;
    char key[SC_CHUNK_KEY_BYTES], reason[SC_CHUNK_WHY_BYTES];
    uint64_t bytes = 0;
    bool read;
    int fd;

    for (int i = 0; i < 3; i++) {
        if (r->axis[i] >= 0)
            at[r->axis[i]] = at_xyz[i];
    }
    if (r->time_axis >= 0)
        at[r->time_axis] = r->phase / (size_t)r->array.chunk[r->time_axis];
    *out = (sc_chunk){.values = r->array.fill, .absent = true};
    name_file(r, at, key, &number);
    w->shard = file_number(r, at_xyz);
    fd = sc_chunk_open_file(r->node.fd, key, &bytes);
    if (fd < 0)
        return errno == ENOENT || sc_chunk_note_unopened(failure, key);
    read = read_packed(r, w, failure, fd, key, number, &bytes);
    close(fd);
    if (!read || bytes == UINT64_MAX)
        return read;
    return unpack_chunk(r, w, at, (size_t)bytes, out, reason) ||
           sc_chunk_note(failure, SC_ERR_DATA, key, reason);
}

/* Allocate what the threads work on. @return SC_ERR_MEMORY; what was allocated release frees. */
static sc_status begin_workers(const sc_ctx *ctx, zarr_reading *r)
{
    size_t first[3], count[3];

    if (r->workers)
        return SC_OK;
    files_of(r, first, count);
    SC_PASS(SC_ZALLOC(ctx, (size_t)r->chunked.threads, &r->workers));
    for (int i = 0; i < r->chunked.threads; i++) {
        SC_PASS(sc_alloc(ctx, r->packed_bytes, 1, &r->workers[i].packed));
        SC_PASS(sc_alloc(ctx, r->chunk_bytes + 64, 1, &r->workers[i].chunk));
        if (r->array.sharded) {
            SC_PASS(sc_alloc(ctx, 16 * r->shard_chunks + 4, 1, &r->workers[i].index));
            SC_PASS(sc_zalloc(ctx, count[0] * count[1] * count[2], sizeof(bool),
                              &r->workers[i].checked));
        }
    }
    return SC_OK;
}

/* sc_slices_fn of this format. */
static sc_status read_slices(const sc_ctx *ctx, const char *path, const sc_source *source,
                             int first, int count, void *out)
{
    zarr_reading *r = source->data;
    const sc_status status = begin_workers(ctx, r);

    (void)path;
    return status == SC_OK ? sc_chunked_read(ctx, &r->chunked, first, count, out) : status;
}

/* ---- header ---- */

/* Is @p name, an axis, called @p wanted, whatever the case? */
static bool is_axis(const char *name, char wanted)
{
    return (name[0] | 32) == wanted && !name[1];
}

/* Find the dimensions that are x, y and z: by their names, if x and y are among them, else the last
 * three, z first; and that of time, by its name, if it has several entries. All others have the
 * size 1. */
static sc_status find_axes(const sc_ctx *ctx, const sc_zarr_choice *choice, zarr_reading *r)
{
    const sc_zarr_array *a = &r->array;
    int *axis = r->axis;
    const char(*names)[32] = choice->named ? choice->names : a->names;

    if (choice->named && choice->axes != a->rank)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has %d dimensions, but its group names %d axes (OME-Zarr); expected as "
                       "many",
                       choice->array.path, a->rank, choice->axes);
    axis[0] = axis[1] = axis[2] = r->time_axis = -1;
    for (int i = 0; i < a->rank; i++) {
        for (int k = 0; k < 3; k++)
            axis[k] = is_axis(names[i], "xyz"[k]) ? i : axis[k];
    }
    if (axis[0] < 0 || axis[1] < 0) {
        for (int k = 0; k < 3; k++)
            axis[k] = a->rank - 1 - k;
    }
    for (int i = 0; i < a->rank; i++) {
        if (i == axis[0] || i == axis[1] || i == axis[2] || a->shape[i] == 1)
            continue;
        if (r->time_axis < 0 && (is_axis(names[i], 't') || !strcmp(names[i], "time")))
            r->time_axis = i;
        else
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: has %lld entries along dimension %d%s%s%s, expected one beside x, "
                           "y, z and t; write one channel as an array of its own",
                           choice->array.path, (long long)a->shape[i], i, names[i][0] ? " (" : "",
                           names[i], names[i][0] ? ")" : "");
    }
    return SC_OK;
}

/* Set the geometry of @p source. */
static void geometry(const sc_ctx *ctx, const sc_zarr_choice *choice, const zarr_reading *r,
                     sc_source *source)
{
    const char *path = choice->array.path;
    bool unit = true;

    source->oriented = false;
    for (int i = 0; i < 3; i++) {
        const int axis = r->axis[i];
        const bool known = choice->named && choice->scaled && axis >= 0;
        const double unit_mm = known && choice->unit_mm[axis] > 0 ? choice->unit_mm[axis] : 1;

        source->to_ras_mm.m[i][i] = known ? choice->scale[axis] * unit_mm : 1;
        source->to_ras_mm.m[i][3] = known ? choice->shift[axis] * unit_mm : 0;
        unit = unit && (axis < 0 || choice->unit_mm[axis] > 0);
    }
    if (r->axis[2] < 0) /* a picture */
        source->to_ras_mm.m[2][2] = source->to_ras_mm.m[0][0];
    if (!choice->scaled)
        sc_warn(ctx, "%s: nothing gives the spacing of its voxels (%s does); taken as 1 mm", path,
                r->array.blocks ? "\"pixelResolution\" or \"resolution\" in attributes.json"
                                : "\"multiscales\" of OME-Zarr");
    else if (!unit)
        sc_warn(ctx,
                "%s: its axes have no known unit of length (\"unit\", such as \"micrometer\"); "
                "taken as mm",
                path);
}

/* Set which of several phases of @p source is read. */
static void choose_phase(const sc_zarr_choice *choice, const sc_read_choice *read, zarr_reading *r,
                         sc_source *source)
{
    const int t = r->time_axis;

    if (t < 0)
        return;
    source->phases = (int)r->array.shape[t];
    source->phase_step_s = choice->scaled ? choice->scale[t] * choice->unit_s[t] : 0;
    /* sc_source_choose_phase refuses one that is not there. */
    r->phase = read->phase > 0 && read->phase <= source->phases ? (size_t)read->phase - 1 : 0;
}

/* Set the size of @p source, that of the whole array. */
static sc_status array_size(const sc_ctx *ctx, const zarr_reading *r, sc_source *source)
{
    int64_t size[3];

    for (int i = 0; i < 3; i++)
        size[i] = r->axis[i] < 0 ? 1 : r->array.shape[r->axis[i]];
    return sc_grid_voxels(ctx, r->node.path, size, sc_voxel_type_bytes(r->array.type), source->size,
                          NULL);
}

/* Set what is needed to unpack chunks. */
static sc_status layout(const sc_ctx *ctx, zarr_reading *r)
{
    const sc_zarr_array *a = &r->array;
    const char *path = r->node.path;

    r->chunked = (sc_chunked){.path = path,
                              .absent = "full of the fill value",
                              .voxel_bytes = sc_voxel_type_bytes(a->type),
                              .load = load_chunk,
                              .user = r};
    for (int i = 0; i < 3; i++)
        r->chunked.chunk[i] = r->axis[i] < 0 ? 1 : (size_t)a->chunk[r->axis[i]];
    r->chunk_bytes = sc_zarr_values(a, a->chunk) * r->chunked.voxel_bytes;
    r->packed_bytes = (size_t)sc_zarr_packed_most(r->chunk_bytes);
    r->shard_chunks = 1;
    for (int i = 0; i < a->rank; i++)
        r->shard_chunks *= (size_t)(a->file_shape[i] / a->chunk[i]);
    if (r->chunk_bytes > SC_CHUNK_BYTES_MAX || r->shard_chunks > SHARD_CHUNKS_MAX)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has chunks of %zu bytes, %zu of them in a file, expected at most %d "
                       "bytes and %d in a file; write it anew with other chunks",
                       path, r->chunk_bytes, r->shard_chunks, SC_CHUNK_BYTES_MAX, SHARD_CHUNKS_MAX);
    return sc_chunked_threads(
        ctx, (double)r->chunk_bytes,
        (double)(r->chunk_bytes + r->packed_bytes + (a->sharded ? 16 * r->shard_chunks : 0)),
        &r->chunked);
}

sc_status sc_open_zarr(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                       bool header_only, sc_source *out)
{
    sc_source source = {
        .slope = 1, .encoding = SC_ENCODING_SLICES, .read_slices = read_slices, .release = release};
    sc_zarr_choice choice = {.array.fd = -1};
    zarr_reading *r;
    sc_status status;

    SC_TRY(SC_ZALLOC(ctx, 1, &r));
    source.data = r;
    r->node.fd = -1;
    SC_TRY((sc_n5_is_node(path) ? sc_n5_choose : sc_zarr_choose)(ctx, path, read->level, &choice));
    SC_TRY(sc_zarr_array_read(ctx, &choice.array, &r->array));
    SC_TRY(find_axes(ctx, &choice, r));
    source.type = r->array.type;
    r->node = choice.array;
    choice.array = (sc_zarr_node){.fd = -1, .path = r->node.path}; /* lent for messages */
    status = array_size(ctx, r, &source);
    if (status == SC_OK)
        status = layout(ctx, r);
    if (status == SC_OK)
        geometry(ctx, &choice, r, &source);
    choose_phase(&choice, read, r, &source);
    if (status == SC_OK)
        status = sc_chunked_cut(ctx, path, read, &r->chunked, &source);
    if (status == SC_OK && !header_only) /* a store without any chunk may promise a tebibyte */
        status = sc_volume_memory_check(ctx, path, source.size, 0);
    if (status == SC_OK)
        status = sc_chunked_count_check(ctx, path, &r->chunked);
    if (status == SC_ERR_SYSTEM && choice.coarser)
        sc_info(ctx, "%s is a coarser level of the same image, and may fit", choice.coarser);
    choice.array.path = NULL;
    SC_TRY(status);
    SC_TRY(sc_path_join(ctx, r->node.path, r->node.meta_name, &source.file));
    source.table = choice.table;
    choice.table = (sc_label_table){0};
    *out = source;
    source = (sc_source){0};
out:
    sc_zarr_choice_clear(&choice);
    sc_source_clear(&source);
    return status;
}
