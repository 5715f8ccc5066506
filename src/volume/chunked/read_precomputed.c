/* SPDX-License-Identifier: BSD-3-Clause */
/* Neuroglancer's precomputed format: a directory with a file "info", which tells the scales, and a
 * directory of chunks for each of them. */
#include "chunked/precomputed.h"
#include "tables/label_table.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SCALES_SHOWN = 12, BLOCK_VOXELS_MAX = 1 << 20, FILES_LOOKED_AT = 64 };
static const double nm_in_mm = 1e-6;

/* What one thread works on. */
typedef struct precomputed_worker {
    unsigned char *packed;   /* [packed_most], owned */
    unsigned char *unpacked; /* [stored_most]: what a gzip file held, owned */
    unsigned char *chunk;    /* [chunk_bytes]: decoded blocks, owned; NULL for raw chunks */
} precomputed_worker;

/* The scale while its voxels are read: sc_source.data. */
typedef struct precomputed_reading {
    int fd;     /* of the directory with the chunks */
    char *path; /* of that, owned */
    int64_t size[3], offset[3], chunk[3];
    size_t block[3]; /* of compressed segmentation; all 0: raw chunks */
    bool sharded;
    sc_precomputed_sharding sharding;
    size_t chunk_bytes, stored_most, packed_most; /* values; encoded; and in a gzip file */
    sc_chunked chunked;
    precomputed_worker *workers;  /* [chunked.threads], owned; NULL until the first slices */
    sc_precomputed_box box;       /* sharded: the chunks that are read, */
    sc_precomputed_place *places; /* and where they are, owned; NULL until the first slices */
} precomputed_reading;

static void release(void *data)
{
    precomputed_reading *r = data;

    if (!r)
        return;
    for (int i = 0; i < r->chunked.threads && r->workers; i++) {
        sc_free(r->workers[i].packed);
        sc_free(r->workers[i].unpacked);
        sc_free(r->workers[i].chunk);
    }
    sc_free(r->workers);
    sc_free(r->places);
    sc_chunked_clear(&r->chunked);
    if (r->fd >= 0)
        close(r->fd);
    sc_free(r->path);
    sc_free(r);
}

bool sc_is_precomputed(const char *path)
{
    char file[4096], head[256] = "";
    FILE *stream;
    size_t count;

    if (snprintf(file, sizeof file, "%s/info", path) >= (int)sizeof file)
        return false;
    stream = fopen(file, "re");
    if (!stream)
        return false;
    count = fread(head, 1, sizeof head - 1, stream);
    fclose(stream);
    return count && head[strspn(head, " \t\r\n")] == '{';
}

/* ---- chunks ---- */

/* A chunk on disk. */
typedef struct chunk_file {
    int fd; /* -1: not open */
    char key[SC_CHUNK_KEY_BYTES];
    sc_precomputed_place
        place; /* in the file; its bytes are UINT64_MAX if there is no such chunk */
} chunk_file;

/* Open the file @p key of a chunk that is not in a shard, or the same name with ".gz". @return the
 * descriptor; -1 if there is none, or if it cannot be opened, which is noted: *good is false. */
static int open_chunk(const precomputed_reading *r, sc_chunk_failure *failure,
                      char key[SC_CHUNK_KEY_BYTES], uint64_t *bytes, bool *good)
{
    const size_t length = strlen(key);
    int fd = sc_chunk_open_file(r->fd, key, bytes);

    if (fd < 0 && errno == ENOENT) {
        snprintf(key + length, SC_CHUNK_KEY_BYTES - length, ".gz");
        fd = sc_chunk_open_file(r->fd, key, bytes);
    }
    *good = fd >= 0 || errno == ENOENT || sc_chunk_note_unopened(failure, key);
    return fd;
}

/* Write the name that the file of the chunk @p number has without shards to @p key. */
static void name_chunk(const precomputed_reading *r, const size_t number[3],
                       char key[SC_CHUNK_KEY_BYTES])
{
    size_t used = 0;

    for (int i = 0; i < 3; i++) {
        const int64_t begin = (int64_t)number[i] * r->chunk[i];
        const int64_t end = begin + r->chunk[i] < r->size[i] ? begin + r->chunk[i] : r->size[i];
        const long long from = begin + r->offset[i], to = end + r->offset[i];

        used += (size_t)snprintf(key + used, SC_CHUNK_KEY_BYTES - used, "%s%lld-%lld", i ? "_" : "",
                                 from, to);
    }
}

/* Find the chunk @p number, and open its file. @return false if it cannot be found, noted. */
static bool find_chunk(const precomputed_reading *r, const size_t number[3],
                       sc_chunk_failure *failure, chunk_file *out)
{
    const size_t *first = r->box.first, *count = r->box.count;
    uint64_t bytes = 0;
    bool good = true;

    *out = (chunk_file){.fd = -1, .place = {.bytes = UINT64_MAX}};
    if (!r->sharded) {
        name_chunk(r, number, out->key);
        out->fd = open_chunk(r, failure, out->key, &bytes, &good);
        out->place.bytes = out->fd >= 0 ? bytes : UINT64_MAX;
        return good;
    }
    out->place = r->places[((number[2] - first[2]) * count[1] + number[1] - first[1]) * count[0] +
                           number[0] - first[0]];
    if (out->place.bytes == UINT64_MAX)
        return true;
    sc_precomputed_shard_name(&r->sharding, sc_precomputed_chunk_number(r->box.grid, number),
                              out->key);
    out->fd = sc_chunk_open_file(r->fd, out->key, &bytes);
    if (out->fd < 0)
        return sc_chunk_note_unopened(failure, out->key);
    if (out->place.begin <= bytes && out->place.bytes <= bytes - out->place.begin)
        return true;
    close(out->fd);
    return sc_chunk_note(failure, SC_ERR_DATA, out->key,
                         "the index of a minishard leads behind the end of the file");
}

/* Read the stored bytes of a chunk to memory of the thread, unpacked if it is a gzip file. @return
 * false if that cannot be, noted. */
static bool read_stored(const precomputed_reading *r, precomputed_worker *w, const chunk_file *file,
                        size_t expected, sc_chunk_failure *failure, const unsigned char **out,
                        size_t *bytes)
{
    const sc_precomputed_place *place = &file->place;
    const char *key = file->key;
    char why[SC_CHUNK_WHY_BYTES];
    bool gzipped;

    if (place->bytes > r->packed_most) {
        snprintf(why, sizeof why, "has %llu bytes, more than a chunk of %zu bytes can take",
                 (unsigned long long)place->bytes, r->chunk_bytes);
        return sc_chunk_note(failure, SC_ERR_DATA, key, why);
    }
    if (!sc_chunk_read_at(file->fd, place->begin, (size_t)place->bytes, w->packed))
        return sc_chunk_note(failure, errno ? SC_ERR_WRITE : SC_ERR_DATA, key,
                             errno ? "cannot be read: I/O error" : "has become shorter");
    *out = w->packed;
    *bytes = (size_t)place->bytes;
    /* A server may keep packed files under the name of the chunk. */
    gzipped = r->sharded ? r->sharding.data_gzipped
                         : *bytes > 2 && w->packed[0] == 0x1f && w->packed[1] == 0x8b &&
                               *bytes != expected;
    if (!gzipped)
        return true;
    *out = w->unpacked;
    return sc_precomputed_gunzip(w->packed, (size_t)place->bytes, w->unpacked, r->stored_most,
                                 bytes, why) ||
           sc_chunk_note(failure, SC_ERR_DATA, key, why);
}

/* sc_chunk_load_fn of this format; @p user is a precomputed_reading. */
static bool load_chunk(void *user, int thread, const size_t number[3], sc_chunk_failure *failure,
                       sc_chunk *out)
{
    static const unsigned char none[8] = {0};
    const precomputed_reading *r = user;
    precomputed_worker *w = &r->workers[thread];
    const size_t each = r->chunked.voxel_bytes;
    char why[SC_CHUNK_WHY_BYTES];
    chunk_file file;
    size_t count[3], values, bytes = 0;
    bool read;

    *out = (sc_chunk){.values = none, .absent = true};
    if (!find_chunk(r, number, failure, &file))
        return false;
    if (file.fd < 0)
        return true;
    for (int i = 0; i < 3; i++) {
        const int64_t left = r->size[i] - (int64_t)number[i] * r->chunk[i];

        count[i] = (size_t)(left < r->chunk[i] ? left : r->chunk[i]);
    }
    values = count[0] * count[1] * count[2];
    read = read_stored(r, w, &file, r->block[0] ? 0 : values * each, failure, &out->values, &bytes);
    close(file.fd);
    if (!read)
        return false;
    out->absent = false;
    out->strides[0] = 1;
    out->strides[1] = count[0];
    out->strides[2] = count[0] * count[1];
    out->swapped = each > 1 && !SC_IS_LITTLE_ENDIAN;
    if (r->block[0]) {
        const unsigned char *stored = out->values;

        out->values = w->chunk;
        return sc_precomputed_decode_blocks(stored, bytes, count, r->block, each, w->chunk, why) ||
               sc_chunk_note(failure, SC_ERR_DATA, file.key, why);
    }
    if (bytes == values * each)
        return true;
    snprintf(why, sizeof why, "has %zu bytes of values, expected %zu", bytes, values * each);
    return sc_chunk_note(failure, SC_ERR_DATA, file.key, why);
}

/* Find all chunks that are read, in their shards. */
static sc_status find_chunks(const sc_ctx *ctx, precomputed_reading *r)
{
    const sc_chunked *c = &r->chunked;

    for (int i = 0; i < 3; i++) {
        r->box.grid[i] = (uint64_t)((r->size[i] - 1) / r->chunk[i] + 1);
        r->box.first[i] = c->low[i] / c->chunk[i];
        r->box.count[i] = (c->low[i] + c->part[i] - 1) / c->chunk[i] - r->box.first[i] + 1;
    }
    return sc_precomputed_find_all(ctx, &r->sharding, r->fd, r->path, &r->box, c->threads,
                                   &r->places);
}

/* Allocate what the threads work on, and find the chunks in their shards. @return SC_ERR_MEMORY,
 * the errors of sc_precomputed_find_all; what was allocated release frees. */
static sc_status begin_workers(const sc_ctx *ctx, precomputed_reading *r)
{
    void *block;

    if (r->workers)
        return SC_OK;
    SC_PASS(sc_zalloc(ctx, (size_t)r->chunked.threads, sizeof *r->workers, &block));
    r->workers = block;
    for (int i = 0; i < r->chunked.threads; i++) {
        SC_PASS(sc_alloc(ctx, r->packed_most, 1, &block));
        r->workers[i].packed = block;
        SC_PASS(sc_alloc(ctx, r->stored_most, 1, &block));
        r->workers[i].unpacked = block;
        if (r->block[0]) {
            SC_PASS(sc_alloc(ctx, r->chunk_bytes, 1, &block));
            r->workers[i].chunk = block;
        }
    }
    if (r->sharded)
        SC_PASS(find_chunks(ctx, r));
    return SC_OK;
}

/* sc_slices_fn of this format. */
static sc_status read_slices(const sc_ctx *ctx, const char *path, const sc_source *source,
                             int first, int count, void *out)
{
    precomputed_reading *r = source->data;
    const sc_status status = begin_workers(ctx, r);

    (void)path;
    return status == SC_OK ? sc_chunked_read(ctx, &r->chunked, first, count, out) : status;
}

/* ---- the file "info" ---- */

/* Log that key @p key of "info" is not as expected. @return SC_ERR_DATA always. */
static sc_status refuse(const sc_ctx *ctx, const char *path, const char *key, const char *expected)
{
    return sc_fail(ctx, SC_ERR_DATA, "%s/info: \"%s\" is not as expected: %s", path, key, expected);
}

/* Read three whole numbers from @p least to @p most. */
static bool read_integers(const json_t *list, int64_t least, int64_t most, int64_t out[3])
{
    bool good = json_array_size(list) == 3;

    for (size_t i = 0; i < 3 && good; i++) {
        const json_t *number = json_array_get(list, i);

        out[i] = json_is_real(number) ? (int64_t)fmin(fmax(json_real_value(number), -1e15), 1e15)
                                      : json_integer_value(number);
        good = json_is_number(number) && (double)out[i] == json_number_value(number) &&
               out[i] >= least && out[i] <= most;
    }
    return good;
}

/* Read what all scales share. */
static sc_status read_kind(const sc_ctx *ctx, const char *path, const json_t *info,
                           sc_voxel_type *type)
{
    static const char *const types[] = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                        "uint32", "int64", "uint64", "float32", "float64"};
    const char *kind = json_string_value(json_object_get(info, "@type"));
    const char *name = json_string_value(json_object_get(info, "data_type"));
    size_t which = 0;

    if (kind && strcmp(kind, "neuroglancer_multiscale_volume"))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s/info: is of type \"%s\", expected \"neuroglancer_multiscale_volume\": "
                       "meshes, skeletons and annotations of Neuroglancer have no voxels",
                       path, kind);
    while (which < SC_COUNT_OF(types) && (!name || strcmp(name, types[which])))
        which++;
    if (which == SC_COUNT_OF(types))
        return refuse(ctx, path, "data_type",
                      "uint8, uint16, uint32, uint64, or another type of "
                      "numbers");
    *type = (sc_voxel_type)which;
    if (json_integer_value(json_object_get(info, "num_channels")) != 1)
        return refuse(ctx, path, "num_channels", "1");
    return SC_OK;
}

/* Log that there is no scale @p level, with those that there are. @return SC_ERR_DATA;
 * SC_ERR_MEMORY. */
static sc_status refuse_level(const sc_ctx *ctx, const char *path, const json_t *scales, int level)
{
    sc_text text = {0};
    sc_status status = SC_OK;

    for (size_t i = 0; i < json_array_size(scales) && i < SCALES_SHOWN; i++) {
        const json_t *scale = json_array_get(scales, i);
        const char *key = json_string_value(json_object_get(scale, "key"));
        char *size = json_dumps(json_object_get(scale, "size"), JSON_ENCODE_ANY);

        status = sc_text_add(ctx, &text, "%s%zu (\"%.80s\" of %.60s)", i ? ", " : "", i,
                             key ? key : "", size ? size : "?");
        free(size);
        SC_TRY(status);
    }
    status = sc_fail(ctx, SC_ERR_DATA,
                     "%s: has no resolution level %d, expected one of %zu: %s; 0 is the finest",
                     path, level, json_array_size(scales), text.data ? text.data : "none");
out:
    sc_text_clear(&text);
    return status;
}

/* Read how the chunks of a scale are encoded. */
static sc_status read_encoding(const sc_ctx *ctx, const char *path, const json_t *scale,
                               sc_voxel_type type, precomputed_reading *r)
{
    const char *encoding = json_string_value(json_object_get(scale, "encoding"));
    const json_t *sharding = json_object_get(scale, "sharding");
    const char *key;
    int64_t block[3];

    if (!encoding || (strcmp(encoding, "raw") && strcmp(encoding, "compressed_segmentation")))
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s/info: its \"encoding\" is \"%.40s\", which is not read; expected \"raw\" "
            "or \"compressed_segmentation\", in which Igneous writes it: `igneous image xfer SRC "
            "DEST --encoding compressed_segmentation`",
            path, encoding ? encoding : "");
    if (strcmp(encoding, "raw")) {
        if (type != SC_VOXEL_UINT32 && type != SC_VOXEL_UINT64)
            return refuse(ctx, path, "data_type",
                          "uint32 or uint64, which compressed_segmentation holds");
        if (!read_integers(json_object_get(scale, "compressed_segmentation_block_size"), 1,
                           BLOCK_VOXELS_MAX, block) ||
            (double)block[0] * (double)block[1] * (double)block[2] > BLOCK_VOXELS_MAX)
            return refuse(ctx, path, "compressed_segmentation_block_size",
                          "three numbers of voxels, a million together at most");
        for (int i = 0; i < 3; i++)
            r->block[i] = (size_t)block[i];
    }
    r->sharded = sharding && !json_is_null(sharding);
    if (r->sharded && !sc_precomputed_sharding_read(sharding, &r->sharding, &key))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s/info: \"%s\" of \"sharding\" is not as expected: the format "
                       "neuroglancer_uint64_sharded_v1 as Neuroglancer's documentation has it",
                       path, key);
    return SC_OK;
}

/* Read a scale: its size and place, and how its chunks are stored. @param data_bytes of a voxel. */
static sc_status read_scale(const sc_ctx *ctx, const char *path, const json_t *scale,
                            precomputed_reading *r, sc_source *source)
{
    const int64_t far = (int64_t)1 << 40;
    const json_t *offset = json_object_get(scale, "voxel_offset");
    const json_t *resolution = json_object_get(scale, "resolution");

    if (!read_integers(json_object_get(scale, "size"), 1, INT32_MAX, r->size))
        return refuse(ctx, path, "size", "three numbers of voxels, from 1 to 2147483647");
    if (offset && !read_integers(offset, -far, far, r->offset))
        return refuse(ctx, path, "voxel_offset", "three whole numbers");
    if (!read_integers(json_array_get(json_object_get(scale, "chunk_sizes"), 0), 1, INT32_MAX,
                       r->chunk))
        return refuse(ctx, path, "chunk_sizes", "a list of three numbers of voxels, from 1");
    source->to_ras_mm = (sc_affine){0};
    for (size_t i = 0; i < 3; i++) {
        const double step = json_number_value(json_array_get(resolution, i)) * nm_in_mm;

        if (json_array_size(resolution) != 3 || !(step > 0) || !isfinite(step))
            return refuse(ctx, path, "resolution", "three lengths of voxels in nm, above 0");
        source->to_ras_mm.m[i][i] = step;
        source->to_ras_mm.m[i][3] = step * ((double)r->offset[i] + 0.5);
        if (r->chunk[i] > r->size[i])
            r->chunk[i] = r->size[i]; /* larger ones are cut at the end of the volume */
    }
    SC_PASS(
        sc_grid_voxels(ctx, path, r->size, sc_voxel_type_bytes(source->type), source->size, NULL));
    return read_encoding(ctx, path, scale, source->type, r);
}

/* Refuse a directory of chunks that are packed otherwise than by gzip, which would look as if they
 * were not there. The first files tell. */
static sc_status check_packing(const sc_ctx *ctx, const precomputed_reading *r)
{
    static const char *const packers[] = {".br", ".zstd", ".zst", ".xz", ".bz2", ".lz4"};
    const int copy = dup(r->fd);
    DIR *stream = copy >= 0 ? fdopendir(copy) : NULL;
    const struct dirent *entry;
    sc_status status = SC_OK;

    if (!stream) {
        if (copy >= 0)
            close(copy);
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", r->path, strerror(errno));
    }
    rewinddir(stream);
    for (int n = 0; n < FILES_LOOKED_AT && status == SC_OK && (entry = readdir(stream)); n++) {
        const char *dot = strrchr(entry->d_name, '.');

        for (size_t i = 0; i < SC_COUNT_OF(packers) && dot && status == SC_OK; i++) {
            if (!strcmp(dot, packers[i]))
                status = sc_fail(ctx, SC_ERR_DATA,
                                 "%s/%s: is packed in a way that is not read, expected chunks as "
                                 "they are, or packed by gzip (\".gz\")",
                                 r->path, entry->d_name);
        }
    }
    closedir(stream);
    return status;
}

/* Open the directory of a scale. */
static sc_status open_scale(const sc_ctx *ctx, int directory, const char *path, const json_t *scale,
                            precomputed_reading *r)
{
    const char *key = json_string_value(json_object_get(scale, "key"));
    const char *why = key ? sc_bad_name(key) : "no name";
    const sc_status status = why ? SC_OK : sc_path_join(ctx, path, key, &r->path);

    if (why)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s/info: \"key\" of a scale is \"%s\": %s; expected the "
                       "name of a directory in it",
                       path, key ? key : "", why);
    if (status != SC_OK)
        return status;
    r->fd = sc_chunk_open_directory(directory, key);
    if (r->fd >= 0)
        return check_packing(ctx, r);
    return sc_fail(ctx, errno == ENOENT ? SC_ERR_MISSING : SC_ERR_DATA,
                   "%s: %s, but %s/info names it; expected a directory, no link", r->path,
                   errno == ENOENT ? "is not there" : "is no directory", path);
}

/* Set what is needed to unpack chunks. */
static sc_status layout(const sc_ctx *ctx, const sc_source *source, precomputed_reading *r)
{
    const size_t chunk[3] = {(size_t)r->chunk[0], (size_t)r->chunk[1], (size_t)r->chunk[2]};
    const uint64_t grid[3] = {(uint64_t)((r->size[0] - 1) / r->chunk[0] + 1),
                              (uint64_t)((r->size[1] - 1) / r->chunk[1] + 1),
                              (uint64_t)((r->size[2] - 1) / r->chunk[2] + 1)};
    const double values = (double)chunk[0] * (double)chunk[1] * (double)chunk[2];
    const double bytes = values * (double)sc_voxel_type_bytes(source->type);
    const double most = r->block[0] ? sc_precomputed_blocks_most(chunk, r->block) : bytes;

    r->chunked = (sc_chunked){.path = r->path,
                              .absent = "background",
                              .voxel_bytes = sc_voxel_type_bytes(source->type),
                              .load = load_chunk,
                              .user = r,
                              .chunk = {chunk[0], chunk[1], chunk[2]}};
    if (most > SC_CHUNK_BYTES_MAX)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: has chunks of up to %.0f bytes, expected at most %d; write it anew with "
            "smaller chunks",
            r->path, most, SC_CHUNK_BYTES_MAX);
    if (r->sharded && sc_precomputed_chunk_bits(grid) > 64)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has more chunks than can be numbered in 64 bits",
                       r->path);
    r->chunk_bytes = (size_t)bytes;
    r->stored_most = (size_t)most;
    r->packed_most = r->stored_most + r->stored_most / 8 + 65536; /* as gzip adds to noise */
    return sc_chunked_threads(ctx, bytes,
                              (double)(r->packed_most + r->stored_most) + (r->block[0] ? bytes : 0),
                              &r->chunked);
}

/* Append the names that "segment_properties" lead to, if there are such. */
static sc_status read_names(const sc_ctx *ctx, int directory, const char *path, const json_t *info,
                            sc_label_table *table)
{
    const char *name = json_string_value(json_object_get(info, "segment_properties"));
    const char *why = name ? sc_bad_name(name) : NULL;
    json_auto_t *properties = NULL;
    SC_OWN(sc_free_at) char *file = NULL, *full = NULL;

    if (!name)
        return SC_OK;
    if (why)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s/info: \"segment_properties\" is \"%s\": %s; expected "
                       "the name of a directory in it",
                       path, name, why);
    SC_PASS(sc_path_join(ctx, name, "info", &file));
    SC_PASS(sc_path_join(ctx, path, file, &full));
    SC_PASS(sc_chunk_read_json(ctx, directory, path, file, &properties));
    if (properties)
        return sc_label_json_read(ctx, full, properties, table);
    else
        sc_warn(ctx, "%s: is not there, but %s/info names it; labels have no names from it", full,
                path);
    return SC_OK;
}

/* Read the file "info", and open the scale @p level. */
static sc_status read_info(const sc_ctx *ctx, int directory, const char *path, int level,
                           precomputed_reading *r, sc_source *source)
{
    json_auto_t *info = NULL;
    const json_t *scales, *scale;

    SC_PASS(sc_chunk_read_json(ctx, directory, path, "info", &info));
    if (!info)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: has no file \"info\" any more", path);
    SC_PASS(read_kind(ctx, path, info, &source->type));
    scales = json_object_get(info, "scales");
    scale = json_array_get(scales, (size_t)level);
    if (!scale)
        return json_array_size(scales)
                   ? refuse_level(ctx, path, scales, level)
                   : refuse(ctx, path, "scales", "a list of at least one scale");
    SC_PASS(read_scale(ctx, path, scale, r, source));
    SC_PASS(open_scale(ctx, directory, path, scale, r));
    SC_PASS(layout(ctx, source, r));
    return read_names(ctx, directory, path, info, &source->table);
}

sc_status sc_open_precomputed(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                              bool header_only, sc_source *out)
{
    sc_source source = {
        .slope = 1, .encoding = SC_ENCODING_SLICES, .read_slices = read_slices, .release = release};
    const int directory = open(path, O_RDONLY | O_CLOEXEC | O_DIRECTORY);
    precomputed_reading *r;
    sc_status status;

    if (directory < 0)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    SC_TRY(SC_ZALLOC(ctx, 1, &r));
    source.data = r;
    r->fd = -1;
    SC_TRY(read_info(ctx, directory, path, read->level, r, &source));
    SC_TRY(sc_chunked_cut(ctx, path, read, &r->chunked, &source));
    if (!header_only) /* a directory without any chunk may promise a tebibyte */
        SC_TRY(sc_volume_memory_check(ctx, path, source.size, 0));
    SC_TRY(sc_chunked_count_check(ctx, path, &r->chunked));
    SC_TRY(sc_path_join(ctx, path, "info", &source.file));
    *out = source;
    source = (sc_source){0};
out:
    close(directory);
    sc_source_clear(&source);
    return status;
}
