/* SPDX-License-Identifier: BSD-3-Clause */
/* Neuroglancer's sharded format: a file, the shard, holds many chunks, in groups called minishards.
 * It begins with a table that tells where the index of each minishard lies. That index tells where
 * each chunk of the minishard lies. */
#include "bytes.h"
#include "chunked/precomputed.h"

#include <stdlib.h>

enum {
    ENTRY_BYTES = 24,          /* of an index: for each chunk number, place and bytes */
    INDEX_BYTES_MAX = 48 << 20 /* of a minishard: two million chunks */
};

/* ---- metadata ---- */

/* Read whether the second of two words stands at @p name; without any it is the first. @param key
 * receives @p name, for messages. @return false for another word. */
static bool read_word(const json_t *json, const char *name, const char *const words[2], bool *out,
                      const char **key)
{
    const json_t *value = json_object_get(json, name);
    const char *text = value ? json_string_value(value) : words[0];

    *key = name;
    *out = text && !strcmp(text, words[1]);
    return text && (*out || !strcmp(text, words[0]));
}

/* Read a number of bits from 0 to @p most. */
static bool read_bits(const json_t *json, const char *name, int most, int *out, const char **key)
{
    const json_t *value = json_object_get(json, name);
    const json_int_t bits = json_integer_value(value);

    *key = name;
    *out = (int)bits;
    return json_is_integer(value) && bits >= 0 && bits <= most;
}

bool sc_precomputed_sharding_read(const json_t *json, sc_precomputed_sharding *out,
                                  const char **key)
{
    static const char *const types[] = {"", "neuroglancer_uint64_sharded_v1"};
    static const char *const hashes[] = {"identity", "murmurhash3_x86_128"};
    static const char *const encodings[] = {"raw", "gzip"};
    bool is_known = false;

    return read_word(json, "@type", types, &is_known, key) && is_known &&
           read_word(json, "hash", hashes, &out->hashed, key) && json_object_get(json, "hash") &&
           read_word(json, "minishard_index_encoding", encodings, &out->index_gzipped, key) &&
           read_word(json, "data_encoding", encodings, &out->data_gzipped, key) &&
           read_bits(json, "preshift_bits", 64, &out->preshift_bits, key) &&
           read_bits(json, "minishard_bits", 32, &out->minishard_bits, key) &&
           read_bits(json, "shard_bits", 64 - out->minishard_bits, &out->shard_bits, key);
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

/* ---- indices ---- */

static uint64_t word64(const unsigned char *at)
{
    return sc_number_at(at, 8, false);
}

/* Read the bytes of an index, which may be packed, to *out, which the caller owns, also after an
 * error. @return the reason if they cannot be read, else NULL. */
static const char *load_index(const sc_precomputed_sharding *sharding, int fd, uint64_t begin,
                              uint64_t bytes, unsigned char **out, size_t *out_bytes)
{
    static const sc_ctx silent = {.level = SC_LOG_ERROR};
    const sc_ctx quiet = sc_quiet(&silent);
    /* Most indices are small, but some bytes may promise much. */
    const double most = (double)bytes * (sharding->index_gzipped ? SC_DEFLATE_RATIO_MAX : 1);
    const size_t room = most < INDEX_BYTES_MAX ? (size_t)most : INDEX_BYTES_MAX;
    char why[SC_CHUNK_WHY_BYTES];
    SC_OWN(sc_free_at) unsigned char *packed = NULL;

    if (bytes > INDEX_BYTES_MAX)
        return "has a minishard whose index is longer than 48 MiB";
    *out_bytes = (size_t)bytes;
    if (sc_alloc(&quiet, (size_t)bytes + 1, 1, &packed) != SC_OK ||
        (sharding->index_gzipped && sc_alloc(&quiet, room + 1, 1, out) != SC_OK))
        return sc_chunk_no_memory;
    if (!sc_chunk_read_at(fd, begin, (size_t)bytes, packed))
        return "the index of a minishard leads behind the end of the file";
    if (!sharding->index_gzipped)
        SC_HAND_OVER(packed, out);
    else if (!sc_chunk_inflate(packed, (size_t)bytes, *out, room, out_bytes, why))
        return "the index of a minishard is damaged (gzip)";
    return *out_bytes % ENTRY_BYTES ? "the index of a minishard has no whole number of entries"
                                    : NULL;
}

/* For bsearch: by number. */
static int by_chunk(const void *a, const void *b)
{
    const uint64_t x = ((const sc_chunk_wanted *)a)->chunk, y = ((const sc_chunk_wanted *)b)->chunk;

    return (x > y) - (x < y);
}

/* Note where those of the chunks wanted[count] of a minishard are that its index names. Numbers and
 * places stand in it as differences from those before. @param index [3 * entries] numbers
 * @param base where places count from. */
static void read_places(const sc_chunk_wanted *wanted, size_t count, const unsigned char *index,
                        size_t entries, uint64_t base, sc_chunk_place *places)
{
    sc_chunk_wanted entry = {.chunk = 0};
    uint64_t end = base;

    for (size_t i = 0; i < entries; i++) {
        const uint64_t begin = end + word64(index + 8 * (entries + i));
        const uint64_t bytes = word64(index + 8 * (2 * entries + i));
        const sc_chunk_wanted *found;

        entry.chunk += word64(index + 8 * i);
        found = bsearch(&entry, wanted, count, sizeof entry, by_chunk);
        if (found)
            places[found->item] = (sc_chunk_place){.begin = begin, .bytes = bytes};
        end = begin + bytes;
    }
}

void sc_precomputed_want(const sc_precomputed_sharding *sharding, const uint64_t grid[3],
                         const size_t at[3], sc_chunk_wanted *out)
{
    const uint64_t chunk = sc_precomputed_chunk_number(grid, at), hash = hash_of(sharding, chunk);

    *out = (sc_chunk_wanted){.file = shard_of(sharding, hash),
                             .part = lowest(hash, sharding->minishard_bits),
                             .chunk = chunk};
}

/* *left counts what no other index has taken yet: were indices to overlap, a small shard could take
 * hours. */
const char *sc_precomputed_find(const sc_precomputed_sharding *sharding, int fd,
                                const sc_chunk_wanted *wanted, size_t count, uint64_t *left,
                                sc_chunk_place *places)
{
    const uint64_t base = (uint64_t)16 << sharding->minishard_bits;
    SC_OWN(sc_free_at) unsigned char *index = NULL;
    unsigned char range[16];
    uint64_t begin, end;
    const char *wrong;
    size_t bytes = 0;

    if (!sc_chunk_read_at(fd, 16 * wanted->part, sizeof range, range))
        return "is shorter than the index of a shard";
    begin = word64(range);
    end = word64(range + 8);
    if (begin > end || end > (uint64_t)1 << 62)
        return "the index of the shard is damaged";
    if (begin == end)
        return NULL;
    if (end - begin <= INDEX_BYTES_MAX && end - begin > *left)
        return "the indices of its minishards have more bytes than it has";
    wrong = load_index(sharding, fd, base + begin, end - begin, &index, &bytes);
    if (wrong)
        return wrong;
    *left -= end - begin;
    read_places(wanted, count, index, bytes / ENTRY_BYTES, base, places);
    return NULL;
}
