/* SPDX-License-Identifier: BSD-3-Clause */
/* Neuroglancer's precomputed format: a directory with a file "info", which tells the scales, and a
 * directory of chunks for each of them. */
#include "chunked/precomputed.h"
#include "tables/label_table.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

enum { SCALES_SHOWN = 12, BLOCK_VOXELS_MAX = 1 << 20, FILES_LOOKED_AT = 64 };
static const double nm_in_mm = 1e-6;

/* The scale while its voxels are read: sc_voxel_reader.data. A thread unpacks a gzip file to the
 * first room, and decodes blocks to the second. */
typedef struct precomputed_reading {
    sc_chunked chunked;
    int fd;     /* of the directory with the chunks */
    char *path; /* of that, owned */
    int64_t size[3], offset[3], chunk[3];
    uint64_t grid[3]; /* the chunks of the whole scale along x, y, z */
    size_t block[3];  /* of compressed segmentation; all 0: raw chunks */
    bool sharded;
    sc_precomputed_sharding sharding;
} precomputed_reading;

static void release(void *data)
{
    precomputed_reading *r = data;

    if (!r)
        return;
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

/* The functions of a sc_chunked; @p user is a precomputed_reading. */
static void name_chunk(const void *user, const size_t number[3], char key[SC_CHUNK_KEY_BYTES])
{
    const precomputed_reading *r = user;
    size_t used = 0;

    if (r->sharded) {
        sc_precomputed_shard_name(&r->sharding, sc_precomputed_chunk_number(r->grid, number), key);
        return;
    }
    for (int i = 0; i < 3; i++) {
        const int64_t begin = (int64_t)number[i] * r->chunk[i];
        const int64_t end = begin + r->chunk[i] < r->size[i] ? begin + r->chunk[i] : r->size[i];
        const long long from = begin + r->offset[i], to = end + r->offset[i];

        used += (size_t)snprintf(key + used, SC_CHUNK_KEY_BYTES - used, "%s%lld-%lld", i ? "_" : "",
                                 from, to);
    }
}

static void want(const void *user, const size_t number[3], sc_chunk_wanted *out)
{
    const precomputed_reading *r = user;

    sc_precomputed_want(&r->sharding, r->grid, number, out);
}

static const char *find(const void *user, int fd, const sc_chunk_wanted *wanted, size_t count,
                        uint64_t *left, sc_chunk_place *places)
{
    const precomputed_reading *r = user;

    return sc_precomputed_find(&r->sharding, fd, wanted, count, left, places);
}

/* Unpack the stored bytes room->packed[*bytes], if they are a gzip file. @param out set to where
 * they are then, and *bytes to how many. @return false with why. */
static bool unpack_stored(const precomputed_reading *r, const sc_chunk_room *room, size_t expected,
                          const unsigned char **out, size_t *bytes, char why[SC_CHUNK_WHY_BYTES])
{
    /* A server may keep packed files under the name of the chunk. */
    const bool gzipped = r->sharded ? r->sharding.data_gzipped
                                    : *bytes > 2 && room->packed[0] == 0x1f &&
                                          room->packed[1] == 0x8b && *bytes != expected;

    *out = gzipped ? room->unpacked[0] : room->packed;
    return !gzipped || sc_chunk_inflate(room->packed, *bytes, room->unpacked[0],
                                        r->chunked.room_bytes[0], bytes, why);
}

static bool load_chunk(const void *user, const sc_chunk_room *room, const size_t number[3],
                       sc_chunk_failure *failure, sc_chunk *out)
{
    static const unsigned char none[8] = {0};
    const precomputed_reading *r = user;
    const size_t each = r->chunked.voxel_bytes;
    const unsigned char *stored;
    char why[SC_CHUNK_WHY_BYTES];
    size_t count[3], expected, bytes = 0;

    *out = (sc_chunk){.values = none, .absent = true};
    if (!sc_chunk_read_stored(&r->chunked, room, number, failure, &bytes))
        return false;
    if (bytes == SIZE_MAX)
        return true;
    for (int i = 0; i < 3; i++) {
        const int64_t left = r->size[i] - (int64_t)number[i] * r->chunk[i];

        count[i] = (size_t)(left < r->chunk[i] ? left : r->chunk[i]);
    }
    expected = count[0] * count[1] * count[2] * each;
    if (!unpack_stored(r, room, r->block[0] ? 0 : expected, &stored, &bytes, why))
        return sc_chunk_note(failure, SC_ERR_DATA, why);
    *out = (sc_chunk){.values = r->block[0] ? room->unpacked[1] : stored,
                      .strides = {1, count[0], count[0] * count[1]},
                      .swapped = each > 1 && !SC_IS_LITTLE_ENDIAN};
    if (r->block[0])
        return sc_precomputed_decode_blocks(stored, bytes, count, r->block, each, room->unpacked[1],
                                            why) ||
               sc_chunk_note(failure, SC_ERR_DATA, why);
    snprintf(why, sizeof why, "has %zu bytes of values, expected %zu", bytes, expected);
    return bytes == expected || sc_chunk_note(failure, SC_ERR_DATA, why);
}

/* ---- the file "info" ---- */

/* Log that key @p key of "info" is not as expected. @return SC_ERR_DATA always. */
static sc_status refuse(const sc_ctx *ctx, const char *path, const char *key, const char *expected)
{
    return sc_chunk_refuse_key(ctx, path, "info", key, expected);
}

/* Read three whole numbers from @p least to @p most. */
static bool read_integers(const json_t *list, int64_t least, int64_t most, int64_t out[3])
{
    double numbers[3];
    bool good = json_array_size(list) == 3 &&
                sc_chunk_numbers(list, 3, (double)least, (double)most, numbers);

    for (int i = 0; i < 3 && good; i++) {
        out[i] = (int64_t)numbers[i];
        good = (double)out[i] == numbers[i];
    }
    return good;
}

/* Read what all scales share. */
static sc_status read_kind(const sc_ctx *ctx, const char *path, const json_t *info,
                           sc_voxel_type *type)
{
    const char *kind = json_string_value(json_object_get(info, "@type"));
    const char *name = json_string_value(json_object_get(info, "data_type"));

    if (kind && strcmp(kind, "neuroglancer_multiscale_volume"))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s/info: is of type \"%s\", expected \"neuroglancer_multiscale_volume\": "
                       "meshes, skeletons and annotations of Neuroglancer have no voxels",
                       path, kind);
    if (!sc_voxel_type_named(name, NULL, type))
        return refuse(ctx, path, "data_type",
                      "uint8, uint16, uint32, uint64, or another type of "
                      "numbers");
    if (json_integer_value(json_object_get(info, "num_channels")) != 1)
        return refuse(ctx, path, "num_channels", "1");
    return SC_OK;
}

/* Log that there is no scale @p level, with those that there are. @return SC_ERR_DATA;
 * SC_ERR_MEMORY. */
static sc_status refuse_level(const sc_ctx *ctx, const char *path, const json_t *scales, int level)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    for (size_t i = 0; i < json_array_size(scales) && i < SCALES_SHOWN; i++) {
        const json_t *scale = json_array_get(scales, i);
        const char *key = json_string_value(json_object_get(scale, "key"));

        SC_PASS(sc_chunk_describe_level(ctx, &text, i, key, json_object_get(scale, "size")));
    }
    return sc_chunk_refuse_level(ctx, path, level, json_array_size(scales), &text);
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

/* Set what is needed to unpack chunks. */
static sc_status layout(const sc_ctx *ctx, const sc_source *source, precomputed_reading *r)
{
    static const sc_chunk_finder finder = {want, find};
    const size_t chunk[3] = {(size_t)r->chunk[0], (size_t)r->chunk[1], (size_t)r->chunk[2]};
    const double values = (double)chunk[0] * (double)chunk[1] * (double)chunk[2];
    const double bytes = values * (double)sc_voxel_type_bytes(source->type);
    const double most = r->block[0] ? sc_precomputed_blocks_most(chunk, r->block) : bytes;

    r->chunked = (sc_chunked){.path = r->path,
                              .directory = r->fd,
                              .absent = "background",
                              .ending = ".gz",
                              .voxel_bytes = sc_voxel_type_bytes(source->type),
                              .name = name_chunk,
                              .load = load_chunk,
                              .finder = r->sharded ? &finder : NULL,
                              .user = r,
                              .chunk = {chunk[0], chunk[1], chunk[2]}};
    for (int i = 0; i < 3; i++)
        r->grid[i] = (uint64_t)((r->size[i] - 1) / r->chunk[i] + 1);
    if (most > SC_CHUNK_BYTES_MAX)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: has chunks of up to %.0f bytes, expected at most %d; write it anew with "
            "smaller chunks",
            r->path, most, SC_CHUNK_BYTES_MAX);
    if (r->sharded && sc_precomputed_chunk_bits(r->grid) > 64)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has more chunks than can be numbered in 64 bits",
                       r->path);
    r->chunked.chunk_bytes = (size_t)bytes;
    r->chunked.packed_bytes = sc_chunk_packed_most((size_t)most);
    r->chunked.room_bytes[0] = (size_t)most;
    r->chunked.room_bytes[1] = r->block[0] ? (size_t)bytes : 0;
    return sc_chunked_threads(ctx, 0, &r->chunked);
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
    SC_PASS(sc_chunk_open_below(ctx, directory, path, "info: \"key\" of a scale",
                                json_string_value(json_object_get(scale, "key")), &r->path,
                                &r->fd));
    SC_PASS(check_packing(ctx, r));
    SC_PASS(layout(ctx, source, r));
    return read_names(ctx, directory, path, info, &source->table);
}

sc_status sc_open_precomputed(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                              bool header_only, sc_source *out)
{
    SC_OWN(sc_source_clear)
    sc_source source = {.slope = 1,
                        .stored.encoding = SC_ENCODING_SLICES,
                        .reader = {.read_slices = sc_chunked_slices, .release = release}};
    const int directory = open(path, O_RDONLY | O_CLOEXEC | O_DIRECTORY);
    precomputed_reading *r = NULL;
    sc_status status;

    if (directory < 0)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    status = SC_ZALLOC(ctx, 1, &r);
    source.reader.data = r;
    if (r)
        r->fd = -1;
    if (status == SC_OK)
        status = read_info(ctx, directory, path, read->level, r, &source);
    close(directory);
    SC_PASS(status);
    SC_PASS(sc_chunked_begin(ctx, path, read, header_only, &r->chunked, &source));
    SC_PASS(sc_path_join(ctx, path, "info", &source.stored.file));
    SC_HAND_OVER(source, out);
    return SC_OK;
}
