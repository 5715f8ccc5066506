/* SPDX-License-Identifier: BSD-3-Clause */
/* Neuroglancer's sharded format: a file, the shard, holds many chunks, in groups called minishards.
 * It begins with a table that tells where the index of each minishard lies. That index tells where
 * each chunk of the minishard lies. */
#include "precomputed.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

enum {
    ENTRY_BYTES = 24,           /* of an index: for each chunk number, place and bytes */
    INDEX_BYTES_MAX = 48 << 20, /* of a minishard: two million chunks */
    INDEX_BYTES_KEPT = 1 << 20  /* larger ones are not remembered beside others */
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

void sc_minishards_clear(sc_minishards *minishards)
{
    for (int i = 0; i < SC_MINISHARDS_KEPT; i++)
        sc_free(minishards->kept[i].places);
    *minishards = (sc_minishards){0};
}

static int by_chunk(const void *a, const void *b)
{
    const sc_precomputed_place *p = a, *q = b;

    return (p->chunk > q->chunk) - (p->chunk < q->chunk);
}

/* Turn the index of a minishard, numbers[3 * count], into places, sorted. Each number and place is
 * stored as the difference from the one before. @param base where places count from. */
static void read_places(const unsigned char *numbers, size_t count, uint64_t base,
                        sc_precomputed_place *out)
{
    uint64_t chunk = 0, end = base;
    bool sorted = true;

    for (size_t i = 0; i < count; i++) {
        chunk += word64(numbers + 8 * i);
        out[i].chunk = chunk;
        out[i].begin = end + word64(numbers + 8 * (count + i));
        out[i].bytes = word64(numbers + 8 * (2 * count + i));
        end = out[i].begin + out[i].bytes;
        sorted = sorted && (!i || out[i - 1].chunk < chunk);
    }
    if (!sorted)
        qsort(out, count, sizeof *out, by_chunk);
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

/* Read the index of a minishard. @return the reason if it is damaged, else NULL. */
static const char *read_minishard(const sc_precomputed_sharding *sharding, int fd,
                                  sc_minishards *minishards, sc_minishard *out)
{
    static const sc_ctx silent = {.level = SC_LOG_ERROR};
    const sc_ctx quiet = sc_quiet(&silent);
    const uint64_t base = (uint64_t)16 << sharding->minishard_bits;
    unsigned char range[16], *index = NULL;
    uint64_t begin, end;
    const char *wrong;
    void *places = NULL;
    size_t bytes = 0;

    if (!sc_chunk_read_at(fd, 16 * out->number, sizeof range, range))
        return "is shorter than the index of a shard";
    begin = word64(range);
    end = word64(range + 8);
    if (begin > end || end > (uint64_t)1 << 62)
        return "the index of the shard is damaged";
    if (begin < end) {
        wrong = load_index(sharding, fd, base + begin, end - begin, &index, &bytes);
        if (wrong)
            return wrong;
    }
    if (bytes > INDEX_BYTES_KEPT)
        sc_minishards_clear(minishards);
    out->count = bytes / ENTRY_BYTES;
    if (out->count && sc_alloc(&quiet, out->count, sizeof *out->places, &places) != SC_OK) {
        sc_free(index);
        return "out of memory";
    }
    out->places = places;
    if (out->count)
        read_places(index, out->count, base, places);
    sc_free(index);
    out->known = true;
    return NULL;
}

bool sc_precomputed_find(const sc_precomputed_sharding *sharding, int directory, uint64_t chunk,
                         sc_minishards *minishards, sc_chunk_failure *failure,
                         char key[SC_CHUNK_KEY_BYTES], sc_precomputed_place *out)
{
    const uint64_t before = shifted(chunk, sharding->preshift_bits);
    const uint64_t hash = sharding->hashed ? murmur(before) : before;
    sc_minishard wanted = {
        .number = lowest(hash, sharding->minishard_bits),
        .shard = lowest(shifted(hash, sharding->minishard_bits), sharding->shard_bits)};
    const sc_precomputed_place looked_for = {.chunk = chunk}, *found = NULL;
    const sc_minishard *known = NULL;

    *out = (sc_precomputed_place){.bytes = UINT64_MAX};
    snprintf(key, SC_CHUNK_KEY_BYTES, "%0*llx.shard", (sharding->shard_bits + 3) / 4,
             (unsigned long long)wanted.shard);
    for (int i = 0; i < SC_MINISHARDS_KEPT && !known; i++) {
        const sc_minishard *kept = &minishards->kept[i];

        known = kept->known && kept->shard == wanted.shard && kept->number == wanted.number ? kept
                                                                                            : NULL;
    }
    if (!known) {
        uint64_t file_bytes;
        const int fd = sc_chunk_open_file(directory, key, &file_bytes);
        const char *wrong = NULL;
        sc_minishard *place;

        if (fd < 0 && errno != ENOENT)
            return sc_chunk_note_unopened(failure, key);
        wanted.known = true; /* a shard that is not there has no chunk */
        if (fd >= 0) {
            wrong = read_minishard(sharding, fd, minishards, &wanted);
            close(fd);
        }
        if (wrong)
            return sc_chunk_note(
                failure, strcmp(wrong, "out of memory") ? SC_ERR_DATA : SC_ERR_MEMORY, key, wrong);
        place = &minishards->kept[minishards->next];
        minishards->next = (minishards->next + 1) % SC_MINISHARDS_KEPT;
        sc_free(place->places);
        *place = wanted;
        known = place;
    }
    if (known->count)
        found = bsearch(&looked_for, known->places, known->count, sizeof looked_for, by_chunk);
    if (found)
        *out = *found;
    return true;
}
