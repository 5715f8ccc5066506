/* SPDX-License-Identifier: BSD-3-Clause */
/* Neuroglancer's sharded format: a file, the shard, holds many chunks, in groups called minishards.
 * It begins with a table that tells where the index of each minishard lies. That index tells where
 * each chunk of the minishard lies. */
#include "chunked/precomputed.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

enum {
    ENTRY_BYTES = 24,          /* of an index: for each chunk number, place and bytes */
    INDEX_BYTES_MAX = 48 << 20 /* of a minishard: two million chunks */
};

/* ---- metadata ---- */

/* Read one of the words @p words[2] at @p key, the first if it is not there, as whether it is the
 * second. */
static bool read_word(const json_t *json, const char *key, const char *const words[2], bool *out)
{
    const json_t *value = json_object_get(json, key);
    const char *text = value ? json_string_value(value) : words[0];

    *out = text && !strcmp(text, words[1]);
    return text && (*out || !strcmp(text, words[0]));
}

/* Read a number of bits from 0 to @p most. */
static bool read_bits(const json_t *json, const char *key, int most, int *out)
{
    const json_t *value = json_object_get(json, key);
    const json_int_t bits = json_integer_value(value);

    *out = (int)bits;
    return json_is_integer(value) && bits >= 0 && bits <= most;
}

bool sc_precomputed_sharding_read(const json_t *json, sc_precomputed_sharding *out,
                                  const char **key)
{
    static const char *const hashes[] = {"identity", "murmurhash3_x86_128"};
    static const char *const encodings[] = {"raw", "gzip"};
    const char *type = json_string_value(json_object_get(json, "@type"));

    *key = "@type";
    if (!type || strcmp(type, "neuroglancer_uint64_sharded_v1"))
        return false;
    *key = "hash";
    if (!json_object_get(json, "hash") || !read_word(json, "hash", hashes, &out->hashed))
        return false;
    *key = "minishard_index_encoding";
    if (!read_word(json, *key, encodings, &out->index_gzipped))
        return false;
    *key = "data_encoding";
    if (!read_word(json, *key, encodings, &out->data_gzipped))
        return false;
    *key = "preshift_bits";
    if (!read_bits(json, *key, 64, &out->preshift_bits))
        return false;
    *key = "minishard_bits";
    if (!read_bits(json, *key, 32, &out->minishard_bits))
        return false;
    *key = "shard_bits";
    return read_bits(json, *key, 64 - out->minishard_bits, &out->shard_bits);
}

/* ---- numbers ---- */

int sc_precomputed_chunk_bits(const uint64_t grid[3])
{
    int bits = 0;

    for (int i = 0; i < 3; i++) {
        for (uint64_t most = grid[i] - 1; most; most >>= 1)
            bits++;
    }
    return bits;
}

uint64_t sc_precomputed_chunk_number(const uint64_t grid[3], const size_t at[3])
{
    uint64_t number = 0;
    int bit = 0;

    for (int i = 0; i < 32; i++) {
        for (int k = 0; k < 3; k++) {
            if ((grid[k] - 1) >> i)
                number |= ((uint64_t)at[k] >> i & 1) << bit++;
        }
    }
    return number;
}

static uint32_t rotated(uint32_t value, int bits)
{
    return value << bits | value >> (32 - bits);
}

static uint32_t mixed(uint32_t h)
{
    h = (h ^ h >> 16) * 0x85ebca6b;
    h = (h ^ h >> 13) * 0xc2b2ae35;
    return h ^ h >> 16;
}

/* @return the low half of MurmurHash3_x86_128 (Austin Appleby, public domain) of the eight bytes of
 * a number, the least first, with the seed 0. */
static uint64_t murmur(uint64_t number)
{
    const uint32_t low = (uint32_t)number, high = (uint32_t)(number >> 32);
    uint32_t h[4] = {0, 0, 0, 0};

    h[1] ^= rotated(high * 0xab0e9789, 16) * 0x38b34ae5;
    h[0] ^= rotated(low * 0x239b961b, 15) * 0xab0e9789;
    for (int i = 0; i < 4; i++)
        h[i] ^= 8; /* bytes */
    for (int round = 0; round < 2; round++) {
        h[0] += h[1] + h[2] + h[3];
        for (int i = 1; i < 4; i++)
            h[i] += h[0];
        for (int i = 0; i < 4 && !round; i++)
            h[i] = mixed(h[i]);
    }
    return h[0] | (uint64_t)h[1] << 32;
}

/* @return the lowest @p bits bits of a number. */
static uint64_t lowest(uint64_t number, int bits)
{
    return bits < 64 ? number & (((uint64_t)1 << bits) - 1) : number;
}

static uint64_t shifted(uint64_t number, int bits)
{
    return bits < 64 ? number >> bits : 0;
}

static uint64_t word64(const unsigned char *at)
{
    uint64_t value = 0;

    for (int i = 0; i < 8; i++)
        value |= (uint64_t)at[i] << 8 * i;
    return value;
}

/* @return the hash of a chunk's number: its lowest bits are the number of its minishard, the bits
 * above them that of its shard. */
static uint64_t hash_of(const sc_precomputed_sharding *sharding, uint64_t chunk)
{
    const uint64_t before = shifted(chunk, sharding->preshift_bits);

    return sharding->hashed ? murmur(before) : before;
}

static uint64_t shard_of(const sc_precomputed_sharding *sharding, uint64_t hash)
{
    return lowest(shifted(hash, sharding->minishard_bits), sharding->shard_bits);
}

void sc_precomputed_shard_name(const sc_precomputed_sharding *sharding, uint64_t chunk,
                               char out[SC_CHUNK_KEY_BYTES])
{
    snprintf(out, SC_CHUNK_KEY_BYTES, "%0*llx.shard", (sharding->shard_bits + 3) / 4,
             (unsigned long long)shard_of(sharding, hash_of(sharding, chunk)));
}

/* ---- bytes ---- */

bool sc_precomputed_gunzip(const unsigned char *packed, size_t packed_bytes, unsigned char *out,
                           size_t most, size_t *bytes, char why[SC_CHUNK_WHY_BYTES])
{
    z_stream z = {.next_in = (unsigned char *)(uintptr_t)packed,
                  .avail_in = (uInt)packed_bytes,
                  .next_out = out,
                  .avail_out = (uInt)most};
    int result =
        packed_bytes > UINT_MAX || most > UINT_MAX ? Z_BUF_ERROR : inflateInit2(&z, MAX_WBITS + 16);

    if (result != Z_OK) {
        snprintf(why, SC_CHUNK_WHY_BYTES, "gzip: out of memory");
        return false;
    }
    result = inflate(&z, Z_FINISH);
    *bytes = most - z.avail_out;
    if (result != Z_STREAM_END)
        snprintf(why, SC_CHUNK_WHY_BYTES, "gzip: %s",
                 z.msg             ? z.msg
                 : z.avail_in == 0 ? "ends too early"
                                   : "unpacks to more bytes than are expected");
    inflateEnd(&z);
    return result == Z_STREAM_END;
}

/* ---- indices ---- */

/* A chunk that is to be read. */
typedef struct wanted_chunk {
    uint64_t shard, minishard, chunk;
    size_t item; /* its number in the box that is read */
} wanted_chunk;

/* Compare two of them for qsort and bsearch: by shard, then by minishard, then by number. */
static int by_place(const void *a, const void *b)
{
    const wanted_chunk *p = a, *q = b;

    if (p->shard != q->shard)
        return p->shard < q->shard ? -1 : 1;
    if (p->minishard != q->minishard)
        return p->minishard < q->minishard ? -1 : 1;
    return (p->chunk > q->chunk) - (p->chunk < q->chunk);
}

/* Read the bytes of an index, which may be packed, to *out, which the caller owns. @return the
 * reason if they cannot be read, else NULL. */
static const char *load_index(const sc_precomputed_sharding *sharding, int fd, uint64_t begin,
                              uint64_t bytes, unsigned char **out, size_t *out_bytes)
{
    static const sc_ctx silent = {.level = SC_LOG_ERROR};
    const sc_ctx quiet = sc_quiet(&silent);
    char why[SC_CHUNK_WHY_BYTES];
    const char *wrong = NULL;
    void *packed = NULL, *unpacked = NULL;

    *out = NULL;
    if (bytes > INDEX_BYTES_MAX)
        return "has a minishard whose index is longer than 48 MiB";
    if (sc_alloc(&quiet, (size_t)bytes + 1, 1, &packed) != SC_OK)
        return "out of memory";
    if (!sc_chunk_read_at(fd, begin, (size_t)bytes, packed))
        wrong = "the index of a minishard leads behind the end of the file";
    *out_bytes = (size_t)bytes;
    if (!wrong && sharding->index_gzipped) {
        /* Most indices are small, but some bytes may promise much. */
        const double most = (double)bytes * SC_DEFLATE_RATIO_MAX;
        const size_t room = most < INDEX_BYTES_MAX ? (size_t)most : INDEX_BYTES_MAX;

        if (sc_alloc(&quiet, room + 1, 1, &unpacked) != SC_OK)
            wrong = "out of memory";
        else if (!sc_precomputed_gunzip(packed, (size_t)bytes, unpacked, room, out_bytes, why))
            wrong = "the index of a minishard is damaged (gzip)";
        sc_free(packed);
        packed = unpacked;
    }
    if (!wrong && *out_bytes % ENTRY_BYTES)
        wrong = "the index of a minishard has no whole number of entries";
    if (wrong)
        sc_free(packed);
    else
        *out = packed;
    return wrong;
}

/* Where the chunks are that are to be read, while the indices of their minishards are. */
typedef struct places_reading {
    const sc_precomputed_sharding *sharding;
    int directory;
    const wanted_chunk *wanted; /* by shards and minishards */
    const size_t *shards;       /* the first chunk of each shard, and the end of the last */
    sc_chunk_failure *failures; /* [threads] */
    sc_precomputed_place *places;
} places_reading;

/* Note where those of the chunks wanted[count] of a minishard are that its index names. Numbers and
 * places stand in it as differences from those before. @param index [3 * entries] numbers
 * @param base where places count from. */
static void read_places(const places_reading *r, const wanted_chunk *wanted, size_t count,
                        const unsigned char *index, size_t entries, uint64_t base)
{
    wanted_chunk entry = *wanted;
    uint64_t end = base;

    entry.chunk = 0;
    for (size_t i = 0; i < entries; i++) {
        const uint64_t begin = end + word64(index + 8 * (entries + i));
        const uint64_t bytes = word64(index + 8 * (2 * entries + i));
        const wanted_chunk *found;

        entry.chunk += word64(index + 8 * i);
        found = bsearch(&entry, wanted, count, sizeof entry, by_place);
        if (found)
            r->places[found->item] = (sc_precomputed_place){.begin = begin, .bytes = bytes};
        end = begin + bytes;
    }
}

/* Read the index of the minishard that holds wanted[count]. @param left the bytes of the shard that
 * no other index has taken yet: were these to overlap, a small shard could take hours.
 * @return the reason if it is damaged, else NULL. */
static const char *read_minishard(const places_reading *r, int fd, const wanted_chunk *wanted,
                                  size_t count, uint64_t *left)
{
    const uint64_t base = (uint64_t)16 << r->sharding->minishard_bits;
    unsigned char range[16], *index = NULL;
    uint64_t begin, end;
    const char *wrong;
    size_t bytes = 0;

    if (!sc_chunk_read_at(fd, 16 * wanted->minishard, sizeof range, range))
        return "is shorter than the index of a shard";
    begin = word64(range);
    end = word64(range + 8);
    if (begin > end || end > (uint64_t)1 << 62)
        return "the index of the shard is damaged";
    if (begin == end)
        return NULL;
    if (end - begin <= INDEX_BYTES_MAX && end - begin > *left)
        return "the indices of its minishards have more bytes than it has";
    wrong = load_index(r->sharding, fd, base + begin, end - begin, &index, &bytes);
    if (!wrong) {
        *left -= end - begin;
        read_places(r, wanted, count, index, bytes / ENTRY_BYTES, base);
    }
    sc_free(index);
    return wrong;
}

/* Find the chunks wanted[first, end), which are in one shard. @return false if they cannot be
 * found, noted. */
static bool read_shard(const places_reading *r, size_t first, size_t end, sc_chunk_failure *failure)
{
    const wanted_chunk *wanted = r->wanted;
    char key[SC_CHUNK_KEY_BYTES];
    const char *wrong = NULL;
    uint64_t left;
    int fd;

    sc_precomputed_shard_name(r->sharding, wanted[first].chunk, key);
    fd = sc_chunk_open_file(r->directory, key, &left);
    if (fd < 0) /* a shard that is not there has no chunk */
        return errno == ENOENT || sc_chunk_note_unopened(failure, key);
    while (first < end && !wrong) {
        size_t behind = first + 1;

        while (behind < end && wanted[behind].minishard == wanted[first].minishard)
            behind++;
        wrong = read_minishard(r, fd, wanted + first, behind - first, &left);
        first = behind;
    }
    close(fd);
    return !wrong ||
           sc_chunk_note(failure, strcmp(wrong, "out of memory") ? SC_ERR_DATA : SC_ERR_MEMORY, key,
                         wrong);
}

/* sc_range_fn: read the indices of shards; @p user is a places_reading. */
static void read_shards(void *user, size_t begin, size_t end, int thread)
{
    const places_reading *r = user;

    for (size_t shard = begin; shard < end; shard++) {
        r->failures[thread].now = shard;
        (void)read_shard(r, r->shards[shard], r->shards[shard + 1], &r->failures[thread]);
    }
}

/* List the chunks of a box by the shards and minishards in which they are. Caller owns *out, [the
 * chunks of the box]: sc_free. */
static sc_status list_wanted(const sc_ctx *ctx, const sc_precomputed_sharding *sharding,
                             const sc_precomputed_box *box, wanted_chunk **out)
{
    const size_t *n = box->count, count = n[0] * n[1] * n[2];
    wanted_chunk *wanted;

    SC_PASS(SC_ALLOC(ctx, count, &wanted));
    for (size_t i = 0; i < count; i++) {
        const size_t at[3] = {box->first[0] + i % n[0], box->first[1] + i / n[0] % n[1],
                              box->first[2] + i / n[0] / n[1]};
        const uint64_t chunk = sc_precomputed_chunk_number(box->grid, at);
        const uint64_t hash = hash_of(sharding, chunk);

        wanted[i] = (wanted_chunk){.shard = shard_of(sharding, hash),
                                   .minishard = lowest(hash, sharding->minishard_bits),
                                   .chunk = chunk,
                                   .item = i};
    }
    qsort(wanted, count, sizeof *wanted, by_place);
    *out = wanted;
    return SC_OK;
}

sc_status sc_precomputed_find_all(const sc_ctx *ctx, const sc_precomputed_sharding *sharding,
                                  int directory, const char *path, const sc_precomputed_box *box,
                                  int threads, sc_precomputed_place **out)
{
    const size_t count = box->count[0] * box->count[1] * box->count[2];
    places_reading r = {.sharding = sharding, .directory = directory};
    const sc_chunk_failure *worst;
    wanted_chunk *wanted = NULL;
    void *places = NULL, *shards = NULL, *failures = NULL;
    size_t shard_count = 0;
    sc_status status;

    SC_TRY(list_wanted(ctx, sharding, box, &wanted));
    SC_TRY(sc_alloc(ctx, count, sizeof(sc_precomputed_place), &places));
    SC_TRY(sc_alloc(ctx, count + 1, sizeof(size_t), &shards));
    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof(sc_chunk_failure), &failures));
    r.wanted = wanted;
    r.places = places;
    r.shards = shards;
    r.failures = failures;
    for (size_t i = 0; i < count; i++) {
        r.places[i] = (sc_precomputed_place){.bytes = UINT64_MAX};
        if (i == 0 || wanted[i - 1].shard != wanted[i].shard)
            ((size_t *)shards)[shard_count++] = i;
    }
    ((size_t *)shards)[shard_count] = count;
    for (int i = 0; i < threads; i++)
        r.failures[i].chunk = SIZE_MAX;
    sc_parallel_for(threads, shard_count, 1, read_shards, &r);
    worst = r.failures;
    for (int i = 1; i < threads; i++)
        worst = r.failures[i].chunk < worst->chunk ? &r.failures[i] : worst;
    if (worst->chunk != SIZE_MAX) {
        status = sc_fail(ctx, worst->status, "%s/%s: %s", path, worst->file, worst->why);
        goto out;
    }
    *out = places;
    places = NULL;
out:
    sc_free(failures);
    sc_free(shards);
    sc_free(places);
    sc_free(wanted);
    return status;
}
