/* SPDX-License-Identifier: BSD-3-Clause */
/* The metadata of an array of Zarr, version 2 (.zarray) and version 3 (zarr.json), and of N5. */
#include "bytes.h"
#include "chunked/zarr.h"

/* The metadata while they are read. */
typedef struct meta_reading {
    const sc_ctx *ctx;
    const sc_zarr_node *node;
    sc_zarr_array *array;
} meta_reading;

/* Log what is wrong with the key @p key. @return SC_ERR_DATA always. */
static sc_status refuse(const meta_reading *r, const char *key, const json_t *found,
                        const char *expected)
{
    SC_OWN(sc_free_at)
    char *text = found ? json_dumps(found, JSON_ENCODE_ANY | JSON_COMPACT) : NULL;

    return sc_fail(r->ctx, SC_ERR_DATA, "%s/%s: \"%s\" is %.120s%s, expected %s", r->node->path,
                   r->node->meta_name, key, text ? text : "missing",
                   text && strlen(text) > 120 ? "..." : "", expected);
}

size_t sc_zarr_values(const sc_zarr_array *array, const int64_t shape[SC_ZARR_RANK_MAX])
{
    size_t values = 1;

    for (int i = 0; i < array->rank; i++)
        values *= (size_t)shape[i];
    return values;
}

/* Read the list @p list of as many numbers as the array has dimensions, each at least 1. */
static sc_status read_shape(const meta_reading *r, const char *key, const json_t *list,
                            int64_t out[SC_ZARR_RANK_MAX])
{
    bool good = json_is_array(list) && json_array_size(list) == (size_t)r->array->rank;

    for (size_t i = 0; good && i < json_array_size(list); i++) {
        const json_t *number = json_array_get(list, i);

        out[i] = json_integer_value(number);
        good = json_is_integer(number) && out[i] >= 1 && out[i] <= INT32_MAX;
    }
    return good ? SC_OK : refuse(r, key, list, "a number from 1 to 2147483647 for each dimension");
}

/* Check that a chunk of this shape has a size that can be unpacked. */
static sc_status check_chunk(const meta_reading *r, const char *key, const json_t *found,
                             const int64_t shape[SC_ZARR_RANK_MAX], double most)
{
    double values = 1;

    for (int i = 0; i < r->array->rank; i++)
        values *= (double)shape[i];
    return values <= most
               ? SC_OK
               : refuse(r, key, found, "chunks of at most 2^30 values, and shards of at most 2^40");
}

/* Read the shape of the array and, from it, its rank. */
static sc_status read_array_shape(const meta_reading *r)
{
    const char *key = r->node->version == SC_ZARR_N5 ? "dimensions" : "shape";
    const json_t *shape = json_object_get(r->node->meta, key);
    const size_t rank = json_array_size(shape);

    if (rank < 2 || rank > SC_ZARR_RANK_MAX)
        return refuse(r, key, shape, "the sizes of 2 to 8 dimensions");
    r->array->rank = (int)rank;
    return read_shape(r, key, shape, r->array->shape);
}

/* Read the name of a type of values: "uint16" of version 3, or "<u2" of version 2, which gives the
 * byte order, too. */
static sc_status read_type(const meta_reading *r, const char *key)
{
    static const char *const short_names[SC_VOXEL_TYPES] = {"i1", "u1", "i2", "u2", "i4",
                                                            "u4", "i8", "u8", "f4", "f8"};
    const json_t *found = json_object_get(r->node->meta, key);
    const char *name = json_string_value(found);
    const bool v2 = r->node->version == 2;

    if (v2 && name && name[0] && strchr("<>|", name[0])) {
        r->array->pipeline.big_endian = name[0] == '>';
        name++;
    } else if (v2) {
        name = NULL;
    }
    if (name && !strcmp(name, v2 ? "b1" : "bool"))
        name = v2 ? "u1" : "uint8";
    if (sc_voxel_type_named(name, v2 ? short_names : NULL, &r->array->type))
        return SC_OK;
    return refuse(r, key, found,
                  v2 ? "integers or floats, such as \"<u2\""
                     : "integers or floats, such as \"uint16\"");
}

/* Read the value of chunks that are not there; null counts as 0. */
static sc_status read_fill(const meta_reading *r)
{
    const json_t *found = json_object_get(r->node->meta, "fill_value");
    const char *text = json_string_value(found);
    const sc_voxel_type type = r->array->type;
    const bool is_float = !sc_voxel_type_is_integer(type);
    double real = json_number_value(found);
    int64_t integer = 0;
    float narrow;

    if (found && !json_is_null(found) && !json_is_number(found) && !json_is_boolean(found) && !text)
        return refuse(r, "fill_value", found, "a number");
    if (text && strcmp(text, "NaN") && strcmp(text, "Infinity") && strcmp(text, "-Infinity"))
        return refuse(r, "fill_value", found, "a number");
    if (!is_float && (text || (json_is_real(found) && (real != floor(real) || fabs(real) > 9e15))))
        return refuse(r, "fill_value", found, "a whole number");
    if (text)
        real = (double)NAN; /* which is refused where a chunk is missing, as in any chunk */
    if (json_is_true(found))
        real = 1;
    narrow = (float)real;
    if (type == SC_VOXEL_FLOAT)
        memcpy(r->array->fill, &narrow, sizeof narrow);
    else if (type == SC_VOXEL_DOUBLE)
        memcpy(r->array->fill, &real, sizeof real);
    if (is_float)
        return SC_OK;
    integer = json_is_integer(found) ? json_integer_value(found) : (int64_t)real;
    if (!sc_voxel_type_fits(type, integer))
        return refuse(r, "fill_value", found, "a number within the range of the array's type");
    sc_number_put((uint64_t)integer, sc_voxel_type_bytes(type), r->array->fill);
    return SC_OK;
}

/* Append the codec @p name to the pipeline of a chunk: compressions and check sums. @return
 * SC_ERR_DATA, logged, for codecs that are not known, or whose library this segcast is built
 * without. */
static sc_status add_codec(const sc_ctx *ctx, const sc_zarr_node *node, const char *name,
                           sc_zarr_pipeline *pipeline)
{
    static const struct {
        const char *name;
        sc_zarr_codec codec;
    } codecs[] = {{"gzip", SC_ZARR_GZIP},           {"zlib", SC_ZARR_ZLIB},
                  {"numcodecs.zlib", SC_ZARR_ZLIB}, {"zstd", SC_ZARR_ZSTD},
                  {"numcodecs.zstd", SC_ZARR_ZSTD}, {"lz4", SC_ZARR_LZ4},
                  {"numcodecs.lz4", SC_ZARR_LZ4},   {"lz4 of N5", SC_ZARR_LZ4_N5},
                  {"blosc", SC_ZARR_BLOSC},         {"numcodecs.blosc", SC_ZARR_BLOSC},
                  {"crc32c", SC_ZARR_CRC32C}};
    const char *lacks = NULL;
    bool compressed = false;

    for (int i = 0; i < pipeline->count; i++)
        compressed = compressed || pipeline->codecs[i] != SC_ZARR_CRC32C;
    for (size_t i = 0; name && i < SC_COUNT_OF(codecs); i++) {
        if (strcmp(name, codecs[i].name) != 0)
            continue;
        lacks = sc_zarr_codec_lacks(codecs[i].codec);
        if (lacks)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s/%s: its chunks are compressed by %s, and segcast was built without "
                           "%s; install it and build again",
                           node->path, node->meta_name, name, lacks);
        if (pipeline->count == SC_ZARR_CODECS_MAX ||
            (compressed && codecs[i].codec != SC_ZARR_CRC32C))
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s/%s: its chunks are compressed more than once, expected one codec, "
                           "and check sums; write it anew with one",
                           node->path, node->meta_name);
        pipeline->codecs[pipeline->count++] = codecs[i].codec;
        return SC_OK;
    }
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s/%s: its chunks are stored by the codec \"%s\", expected blosc, zstd, lz4, "
                   "gzip, zlib or crc32c; write it anew with one of these",
                   node->path, node->meta_name, name ? name : "");
}

/* ---- version 2 ---- */

static sc_status read_v2(const meta_reading *r)
{
    const json_t *meta = r->node->meta;
    const json_t *compressor = json_object_get(meta, "compressor");
    const json_t *filters = json_object_get(meta, "filters");
    const char *order = json_string_value(json_object_get(meta, "order"));
    const json_t *separator = json_object_get(meta, "dimension_separator");
    sc_zarr_array *array = r->array;

    SC_PASS(read_type(r, "dtype"));
    SC_PASS(read_shape(r, "chunks", json_object_get(meta, "chunks"), array->chunk));
    SC_PASS(check_chunk(r, "chunks", json_object_get(meta, "chunks"), array->chunk,
                        SC_ZARR_CHUNK_VALUES_MAX));
    memcpy(array->file_shape, array->chunk, sizeof array->chunk);
    if (!order || (strcmp(order, "C") && strcmp(order, "F")))
        return refuse(r, "order", json_object_get(meta, "order"), "\"C\" or \"F\"");
    for (int i = 0; i < array->rank && *order == 'F'; i++)
        array->pipeline.order[i] = array->rank - 1 - i;
    if (json_array_size(filters) > 0)
        return refuse(r, "filters", filters, "null: write it anew without filters");
    if (compressor && !json_is_null(compressor))
        SC_PASS(add_codec(r->ctx, r->node, json_string_value(json_object_get(compressor, "id")),
                          &array->pipeline));
    array->prefix = "";
    array->separator = '.';
    if (separator) {
        const char *text = json_string_value(separator);

        if (!text || (strcmp(text, ".") && strcmp(text, "/")))
            return refuse(r, "dimension_separator", separator, "\".\" or \"/\"");
        array->separator = *text;
    }
    return read_fill(r);
}

/* ---- version 3 ---- */

static const char *codec_name(const json_t *codec)
{
    return json_is_string(codec) ? json_string_value(codec)
                                 : json_string_value(json_object_get(codec, "name"));
}

static const json_t *configuration(const json_t *object)
{
    return json_object_get(object, "configuration");
}

/* The codec "transpose": apply it to the order of the dimensions so far. */
static sc_status add_transpose(const meta_reading *r, const json_t *codec,
                               int order[SC_ZARR_RANK_MAX])
{
    const json_t *list = json_object_get(configuration(codec), "order");
    int before[SC_ZARR_RANK_MAX];
    unsigned seen = 0;

    memcpy(before, order, sizeof before);
    for (int i = 0; i < r->array->rank; i++) {
        const json_t *number = json_array_get(list, (size_t)i);
        const int64_t from = json_integer_value(number);

        if (!json_is_integer(number) || from < 0 || from >= r->array->rank || (seen >> from & 1))
            return refuse(r, "transpose", codec, "each dimension once in \"order\"");
        seen |= 1u << from;
        order[i] = before[from];
    }
    return SC_OK;
}

/* The codec "bytes": its byte order, little if it has none. */
static sc_status read_endian(const meta_reading *r, const json_t *codec, bool *big)
{
    const json_t *endian = json_object_get(configuration(codec), "endian");
    const char *text = json_string_value(endian);

    if (endian && (!text || (strcmp(text, "little") && strcmp(text, "big"))))
        return refuse(r, "endian", endian, "\"little\" or \"big\"");
    *big = text && !strcmp(text, "big");
    return SC_OK;
}

/* The codecs of the index of shards: bytes, and a check sum. */
static sc_status read_index_codecs(const meta_reading *r, const json_t *config)
{
    const json_t *codecs = json_object_get(config, "index_codecs");
    const json_t *location = json_object_get(config, "index_location");
    const char *where = location ? json_string_value(location) : "end";
    const size_t count = json_array_size(codecs);
    const char *first = codec_name(json_array_get(codecs, 0));
    const char *second = count == 2 ? codec_name(json_array_get(codecs, 1)) : "crc32c";

    if (count < 1 || count > 2 || !first || strcmp(first, "bytes") || !second ||
        strcmp(second, "crc32c"))
        return refuse(r, "index_codecs", codecs, "bytes, and maybe crc32c");
    if (!where || (strcmp(where, "start") && strcmp(where, "end")))
        return refuse(r, "index_location", location, "\"start\" or \"end\"");
    r->array->index_crc = count == 2;
    r->array->index_first = !strcmp(where, "start");
    return read_endian(r, json_array_get(codecs, 0), &r->array->index_big_endian);
}

static sc_status read_codecs(const meta_reading *r, const json_t *codecs);

/* The codec "sharding_indexed": the chunks within the files. */
static sc_status read_sharding(const meta_reading *r, const json_t *codec)
{
    const json_t *config = configuration(codec), *shape = json_object_get(config, "chunk_shape");
    sc_zarr_array *array = r->array;

    if (array->sharded || array->pipeline.count > 0)
        return refuse(r, "codecs", codec, "shards that are not within others");
    for (int i = 0; i < array->rank; i++) {
        if (array->pipeline.order[i] != i)
            return refuse(r, "codecs", codec,
                          "\"transpose\" within \"sharding_indexed\", not before it");
    }
    array->sharded = true;
    SC_PASS(read_shape(r, "chunk_shape", shape, array->chunk));
    SC_PASS(check_chunk(r, "chunk_shape", shape, array->chunk, SC_ZARR_CHUNK_VALUES_MAX));
    for (int i = 0; i < array->rank; i++) {
        if (array->file_shape[i] % array->chunk[i])
            return refuse(r, "chunk_shape", shape, "divisors of the shape of a shard");
    }
    SC_PASS(read_index_codecs(r, config));
    return read_codecs(r, json_object_get(config, "codecs"));
}

/* Read a list of codecs: transpositions, then bytes or shards, then compressions and check sums. */
static sc_status read_codecs(const meta_reading *r, const json_t *codecs)
{
    sc_zarr_pipeline *pipeline = &r->array->pipeline;
    bool bytes = false, shards = false;

    for (size_t i = 0; i < json_array_size(codecs); i++) {
        const json_t *codec = json_array_get(codecs, i);
        const char *name = codec_name(codec);

        if (shards)
            return refuse(r, "codecs", codecs, "nothing behind \"sharding_indexed\"");
        if (name && !bytes && !strcmp(name, "transpose")) {
            SC_PASS(add_transpose(r, codec, pipeline->order));
        } else if (name && !bytes && (!strcmp(name, "bytes") || !strcmp(name, "endian"))) {
            bytes = true;
            SC_PASS(read_endian(r, codec, &pipeline->big_endian));
        } else if (name && !bytes && !strcmp(name, "sharding_indexed")) {
            bytes = shards = true;
            SC_PASS(read_sharding(r, codec));
        } else if (bytes) {
            SC_PASS(add_codec(r->ctx, r->node, name, pipeline));
        } else {
            return refuse(r, "codecs", codecs,
                          "\"bytes\" or \"sharding_indexed\" before any compression");
        }
    }
    if (!bytes)
        return refuse(r, "codecs", codecs, "a list with \"bytes\"");
    return SC_OK;
}

/* The names of chunks. */
static sc_status read_keys(const meta_reading *r)
{
    const json_t *keys = json_object_get(r->node->meta, "chunk_key_encoding");
    const json_t *separator = json_object_get(configuration(keys), "separator");
    const char *name = json_string_value(json_object_get(keys, "name"));
    const char *text = json_string_value(separator);
    const bool by_default = name && !strcmp(name, "default");

    if (!name || (!by_default && strcmp(name, "v2")) ||
        (separator && (!text || (strcmp(text, "/") && strcmp(text, ".")))))
        return refuse(r, "chunk_key_encoding", keys,
                      "\"default\" or \"v2\", with the separator \"/\" or \".\"");
    r->array->prefix = by_default ? "c" : "";
    r->array->separator = text ? *text : by_default ? '/' : '.';
    return SC_OK;
}

/* Copy a name of a dimension; an empty one for what is no short text. */
static void copy_dimension(const json_t *name, char out[32])
{
    const char *text = json_string_value(name);

    snprintf(out, 32, "%s", text && strlen(text) < 32 ? text : "");
}

static sc_status read_v3(const meta_reading *r)
{
    const json_t *meta = r->node->meta;
    const json_t *grid = json_object_get(meta, "chunk_grid");
    const char *grid_name = json_string_value(json_object_get(grid, "name"));
    sc_zarr_array *array = r->array;
    const json_t *shape = json_object_get(configuration(grid), "chunk_shape");

    SC_PASS(read_type(r, "data_type"));
    if (!grid_name || strcmp(grid_name, "regular"))
        return refuse(r, "chunk_grid", grid, "\"regular\"");
    if (json_array_size(json_object_get(meta, "storage_transformers")) > 0)
        return refuse(r, "storage_transformers", json_object_get(meta, "storage_transformers"),
                      "none");
    SC_PASS(read_shape(r, "chunk_shape", shape, array->file_shape));
    memcpy(array->chunk, array->file_shape, sizeof array->chunk);
    SC_PASS(read_codecs(r, json_object_get(meta, "codecs")));
    SC_PASS(check_chunk(r, "chunk_shape", shape, array->file_shape,
                        array->sharded ? 0x1p40 : SC_ZARR_CHUNK_VALUES_MAX));
    SC_PASS(read_keys(r));
    return read_fill(r);
}

/* ---- N5 ---- */

static void reverse(int count, int64_t values[SC_ZARR_RANK_MAX])
{
    for (int i = 0; i < count / 2; i++) {
        const int64_t first = values[i];

        values[i] = values[count - 1 - i];
        values[count - 1 - i] = first;
    }
}

static sc_status read_n5(const meta_reading *r)
{
    const json_t *meta = r->node->meta, *sizes = json_object_get(meta, "blockSize");
    const json_t *compression = json_object_get(meta, "compression");
    const json_t *type = compression ? json_object_get(compression, "type")
                                     : json_object_get(meta, "compressionType"); /* before 1.1 */
    const char *name = json_string_value(type);
    sc_zarr_array *array = r->array;

    SC_PASS(read_type(r, "dataType"));
    SC_PASS(read_shape(r, "blockSize", sizes, array->chunk));
    SC_PASS(check_chunk(r, "blockSize", sizes, array->chunk, SC_ZARR_CHUNK_VALUES_MAX));
    reverse(array->rank, array->shape); /* N5 names x first */
    reverse(array->rank, array->chunk);
    memcpy(array->file_shape, array->chunk, sizeof array->chunk);
    array->pipeline.big_endian = array->blocks = true;
    array->prefix = "";
    array->separator = '/';
    if (name && !strcmp(name, "raw"))
        return SC_OK;
    return add_codec(r->ctx, r->node, name && !strcmp(name, "lz4") ? "lz4 of N5" : name,
                     &array->pipeline);
}

sc_status sc_zarr_array_read(const sc_ctx *ctx, const sc_zarr_node *node, sc_zarr_array *out)
{
    sc_zarr_array array = {0};
    const meta_reading r = {.ctx = ctx, .node = node, .array = &array};
    const json_t *names = node->version == 3
                              ? json_object_get(node->meta, "dimension_names")
                              : json_object_get(node->attributes, "_ARRAY_DIMENSIONS");

    SC_PASS(read_array_shape(&r));
    for (int i = 0; i < array.rank; i++)
        array.pipeline.order[i] = i;
    SC_PASS(node->version == SC_ZARR_N5 ? read_n5(&r)
            : node->version == 2        ? read_v2(&r)
                                        : read_v3(&r));
    for (int i = 0; i < array.rank; i++)
        copy_dimension(json_array_get(names, (size_t)i), array.names[i]);
    *out = array;
    return SC_OK;
}
