/* SPDX-License-Identifier: BSD-3-Clause */
/* SHA-256 (FIPS 180-4) of a file, for those who compare it by other programs. Whatever segcast
 * compares by itself has the faster hash of hash.c. */
#include "segcast/base.h"

#include <errno.h>

enum { BLOCK_BYTES = 64, READ_BYTES = 1 << 16 };

/* The first 32 bits of the fractional parts of the cube roots of the first 64 primes. */
static const uint32_t round_constants[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

static uint32_t rotate(uint32_t x, int bits)
{
    return x >> bits | x << (32 - bits);
}

/* Take one block into the state. */
static void take_block(uint32_t state[8], const uint8_t *block)
{
    uint32_t w[64];
    uint32_t a = state[0], b = state[1], c = state[2], d = state[3];
    uint32_t e = state[4], f = state[5], g = state[6], h = state[7];

    for (int i = 0; i < 16; i++)
        w[i] = (uint32_t)block[4 * i] << 24 | (uint32_t)block[4 * i + 1] << 16 |
               (uint32_t)block[4 * i + 2] << 8 | block[4 * i + 3];
    for (int i = 16; i < 64; i++)
        w[i] = w[i - 16] + w[i - 7] +
               (rotate(w[i - 15], 7) ^ rotate(w[i - 15], 18) ^ w[i - 15] >> 3) +
               (rotate(w[i - 2], 17) ^ rotate(w[i - 2], 19) ^ w[i - 2] >> 10);
    for (int i = 0; i < 64; i++) {
        const uint32_t first = h + (rotate(e, 6) ^ rotate(e, 11) ^ rotate(e, 25)) +
                               ((e & f) ^ (~e & g)) + round_constants[i] + w[i];
        const uint32_t second =
            (rotate(a, 2) ^ rotate(a, 13) ^ rotate(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));

        h = g;
        g = f;
        f = e;
        e = d + first;
        d = c;
        c = b;
        b = a;
        a = first + second;
    }
    state[0] += a;
    state[1] += b;
    state[2] += c;
    state[3] += d;
    state[4] += e;
    state[5] += f;
    state[6] += g;
    state[7] += h;
}

/* Take the end of a file, data[bytes] of less than a block, with what the standard appends. */
static void take_end(uint32_t state[8], const uint8_t *data, size_t bytes, uint64_t all_bytes)
{
    uint8_t end[2 * BLOCK_BYTES] = {0};
    const size_t end_bytes = bytes < BLOCK_BYTES - 8 ? BLOCK_BYTES : sizeof end;

    memcpy(end, data, bytes);
    end[bytes] = 0x80;
    for (int i = 0; i < 8; i++)
        end[end_bytes - 1 - (size_t)i] = (uint8_t)(8 * all_bytes >> 8 * i);
    for (size_t at = 0; at < end_bytes; at += BLOCK_BYTES)
        take_block(state, end + at);
}

/* As sc_sha256_file, of what @p opened has, which is closed; NULL: it could not be opened. */
static sc_status hash_stream(const sc_ctx *ctx, FILE *opened, const char *path,
                             char out[SC_SHA256_BYTES], uint64_t *out_bytes)
{
    /* the first 32 bits of the fractional parts of the square roots of the first 8 primes */
    uint32_t state[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                         0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    SC_OWN(sc_fclose_at) FILE *stream = opened;
    SC_OWN(sc_free_at) uint8_t *data = NULL;
    uint64_t all_bytes = 0;
    size_t bytes, at;

    if (!stream)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, sc_reason(errno));
    SC_PASS(SC_ALLOC(ctx, READ_BYTES, &data));
    do {
        bytes = fread(data, 1, READ_BYTES, stream);
        all_bytes += bytes;
        for (at = 0; at + BLOCK_BYTES <= bytes; at += BLOCK_BYTES)
            take_block(state, data + at);
    } while (bytes == READ_BYTES);
    if (ferror(stream))
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be read: %s", path,
                       sc_reason(errno));
    take_end(state, data + at, bytes - at, all_bytes);
    for (int i = 0; i < 8; i++)
        snprintf(out + 8 * i, 9, "%08x", (unsigned)state[i]);
    *out_bytes = all_bytes;
    return SC_OK;
}

sc_status sc_sha256_file(const sc_ctx *ctx, const char *path, char out[SC_SHA256_BYTES],
                         uint64_t *out_bytes)
{
    return hash_stream(ctx, fopen(path, "rb"), path, out, out_bytes);
}

sc_status sc_sha256_text(const sc_ctx *ctx, const sc_text *text, char out[SC_SHA256_BYTES])
{
    uint64_t bytes;

    return hash_stream(ctx, fmemopen(text->data, text->length_bytes, "rb"), "a text in memory", out,
                       &bytes);
}
