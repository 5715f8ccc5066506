/* SPDX-License-Identifier: BSD-3-Clause */
/* Zarr, versions 2 and 3, OME-Zarr, and N5: which chunks an array has, and where they are. */
#include "bytes.h"
#include "chunked/zarr.h"

enum { SHARD_CHUNKS_MAX = 1 << 22 };

/* The array while its voxels are read: sc_voxel_reader.data. A thread unpacks chunks to the first
 * room.
 */
typedef struct zarr_reading {
    sc_chunked chunked;
    sc_zarr_node node;
    sc_zarr_array array;
    int axis[3];         /* the dimensions that are x, y, z; -1: z of a picture */
    int time_axis;       /* the dimension along which phases follow each other; -1: none */
    size_t phase;        /* that which is read */
    size_t shard_chunks; /* chunks of a file; 1 without shards */
} zarr_reading;

static void release(void *data)
{
    zarr_reading *r = data;

    if (!r)
        return;
    sc_chunked_clear(&r->chunked);
    sc_zarr_node_clear(&r->node);
    sc_free(r);
}

/* ---- where a chunk is ---- */

/* Write the place of the chunk @p number, counted along x, y, z, along the dimensions to @p at. */
static void place_of(const zarr_reading *r, const size_t number[3], size_t at[SC_ZARR_RANK_MAX])
{
    memset(at, 0, SC_ZARR_RANK_MAX * sizeof *at);
    for (int i = 0; i < 3; i++) {
        if (r->axis[i] >= 0)
            at[r->axis[i]] = number[i];
    }
    if (r->time_axis >= 0)
        at[r->time_axis] = r->phase / (size_t)r->array.chunk[r->time_axis];
}

/* @return how many chunks a file has along dimension @p i. */
static size_t chunks_along(const sc_zarr_array *a, int i)
{
    return (size_t)(a->file_shape[i] / a->chunk[i]);
}

/* The functions of a sc_chunked; @p user is a zarr_reading. */
static void name_file(const void *user, const size_t number[3], char key[SC_CHUNK_KEY_BYTES])
{
    const zarr_reading *r = user;
    const sc_zarr_array *a = &r->array;
    size_t used = (size_t)snprintf(key, SC_CHUNK_KEY_BYTES, "%s", a->prefix);
    size_t at[SC_ZARR_RANK_MAX];

    place_of(r, number, at);
    for (int k = 0; k < a->rank; k++) {
        const int i = a->blocks ? a->rank - 1 - k : k;

        if (k > 0 || *a->prefix)
            used += (size_t)snprintf(key + used, SC_CHUNK_KEY_BYTES - used, "%c", a->separator);
        used += (size_t)snprintf(key + used, SC_CHUNK_KEY_BYTES - used, "%zu",
                                 at[i] / chunks_along(a, i));
    }
}

static void want(const void *user, const size_t number[3], sc_chunk_wanted *out)
{
    const zarr_reading *r = user;
    const sc_zarr_array *a = &r->array;
    size_t at[SC_ZARR_RANK_MAX];

    place_of(r, number, at);
    *out = (sc_chunk_wanted){.file = 0};
    for (int i = 0; i < a->rank; i++) {
        const size_t along = chunks_along(a, i);

        out->file =
            out->file * (uint64_t)((a->shape[i] - 1) / a->file_shape[i] + 1) + at[i] / along;
        out->chunk = out->chunk * along + at[i] % along;
    }
}

static const char *find(const void *user, int fd, const sc_chunk_wanted *wanted, size_t count,
                        uint64_t *left, sc_chunk_place *places)
{
    static const sc_ctx silent = {.level = SC_LOG_ERROR};
    const sc_ctx quiet = sc_quiet(&silent);
    const zarr_reading *r = user;
    const sc_zarr_array *a = &r->array;
    const size_t entries = 16 * r->shard_chunks, bytes = entries + (a->index_crc ? 4 : 0);
    SC_OWN(sc_free_at) unsigned char *index = NULL;

    if (*left < bytes)
        return "is shorter than the index of a shard";
    if (sc_alloc(&quiet, bytes, 1, &index) != SC_OK)
        return sc_chunk_no_memory;
    if (!sc_chunk_read_at(fd, a->index_first ? 0 : *left - bytes, bytes, index))
        return "the index of the shard cannot be read";
    if (a->index_crc && sc_zarr_crc32c(index, entries) != sc_number_at(index + entries, 4, false))
        return "the check sum of the index of the shard is wrong";
    for (size_t i = 0; i < count; i++) {
        const unsigned char *entry = index + 16 * wanted[i].chunk;
        const sc_chunk_place place = {sc_number_at(entry, 8, a->index_big_endian),
                                      sc_number_at(entry + 8, 8, a->index_big_endian)};

        if (place.bytes == UINT64_MAX && place.begin != UINT64_MAX)
            return "the index of the shard leads behind the end of the file";
        places[wanted[i].item] = place;
    }
    return NULL;
}

/* ---- the bytes of a chunk ---- */

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

static bool load_chunk(const void *user, const sc_chunk_room *room, const size_t number[3],
                       sc_chunk_failure *failure, sc_chunk *out)
{
    const zarr_reading *r = user;
    const sc_zarr_array *a = &r->array;
    const unsigned char *values;
    size_t at[SC_ZARR_RANK_MAX], begin = 0, bytes;
    int64_t shape[SC_ZARR_RANK_MAX];
    char why[SC_CHUNK_WHY_BYTES];

    *out = (sc_chunk){.values = a->fill, .absent = true};
    if (!sc_chunk_read_stored(&r->chunked, room, number, failure, &bytes))
        return false;
    if (bytes == SIZE_MAX)
        return true;
    place_of(r, number, at);
    memcpy(shape, a->chunk, sizeof shape);
    if ((a->blocks && !sc_n5_block_read(a, at, room->packed, bytes, shape, &begin, why)) ||
        !sc_zarr_unpack(&a->pipeline, room->packed + begin, bytes - begin, room->unpacked[0],
                        sc_zarr_values(a, shape) * r->chunked.voxel_bytes, &values, why))
        return sc_chunk_note(failure, SC_ERR_DATA, why);
    describe_chunk(r, shape, values, out);
    return true;
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
    source->series.count = (int)r->array.shape[t];
    source->series.step_s = choice->scaled ? choice->scale[t] * choice->unit_s[t] : 0;
    /* sc_source_choose_phase refuses one that is not there. */
    r->phase = read->phase > 0 && read->phase <= source->series.count ? (size_t)read->phase - 1 : 0;
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
    static const sc_chunk_finder finder = {want, find};
    const sc_zarr_array *a = &r->array;
    const size_t each = sc_voxel_type_bytes(a->type), bytes = sc_zarr_values(a, a->chunk) * each;

    r->chunked = (sc_chunked){.path = r->node.path,
                              .directory = r->node.fd,
                              .absent = "full of the fill value",
                              .voxel_bytes = each,
                              .chunk_bytes = bytes,
                              .packed_bytes = sc_chunk_packed_most(bytes),
                              .room_bytes = {bytes + 64, 0},
                              .name = name_file,
                              .load = load_chunk,
                              .finder = a->sharded ? &finder : NULL,
                              .user = r};
    for (int i = 0; i < 3; i++)
        r->chunked.chunk[i] = r->axis[i] < 0 ? 1 : (size_t)a->chunk[r->axis[i]];
    r->shard_chunks = 1;
    for (int i = 0; i < a->rank; i++)
        r->shard_chunks *= chunks_along(a, i);
    if (bytes > SC_CHUNK_BYTES_MAX || r->shard_chunks > SHARD_CHUNKS_MAX)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has chunks of %zu bytes, %zu of them in a file, expected at most %d "
                       "bytes and %d in a file; write it anew with other chunks",
                       r->node.path, bytes, r->shard_chunks, SC_CHUNK_BYTES_MAX, SHARD_CHUNKS_MAX);
    return sc_chunked_threads(ctx, a->sharded ? 16.0 * (double)r->shard_chunks : 0, &r->chunked);
}

/* Fill @p source, whose data is @p r, by the array that was chosen, which @p r takes. */
static sc_status describe(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                          bool header_only, sc_zarr_choice *choice, zarr_reading *r,
                          sc_source *source)
{
    SC_PASS(sc_zarr_array_read(ctx, &choice->array, &r->array));
    SC_PASS(find_axes(ctx, choice, r));
    source->type = r->array.type;
    geometry(ctx, choice, r, source);
    r->node = choice->array;
    choice->array = (sc_zarr_node){.fd = -1};
    SC_PASS(array_size(ctx, r, source));
    SC_PASS(layout(ctx, r));
    choose_phase(choice, read, r, source);
    SC_PASS(sc_chunked_begin(ctx, path, read, header_only, &r->chunked, source));
    source->table = choice->table;
    choice->table = (sc_label_table){0};
    return sc_path_join(ctx, r->node.path, r->node.meta_name, &source->stored.file);
}

sc_status sc_open_zarr(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                       bool header_only, sc_source *out)
{
    SC_OWN(sc_source_clear)
    sc_source source = {.slope = 1,
                        .stored.encoding = SC_ENCODING_SLICES,
                        .reader = {.read_slices = sc_chunked_slices, .release = release}};
    SC_OWN(sc_zarr_choice_clear) sc_zarr_choice choice = {.array.fd = -1};
    zarr_reading *r;
    sc_status status;

    SC_PASS(SC_ZALLOC(ctx, 1, &r));
    source.reader.data = r;
    r->node.fd = -1;
    SC_PASS((sc_n5_is_node(path) ? sc_n5_choose : sc_zarr_choose)(ctx, path, read->level, &choice));
    status = describe(ctx, path, read, header_only, &choice, r, &source);
    if (status == SC_ERR_SYSTEM && choice.coarser)
        sc_info(ctx, "%s is a coarser level of the same image, and may fit", choice.coarser);
    SC_PASS(status);
    SC_HAND_OVER(source, out);
    return SC_OK;
}
