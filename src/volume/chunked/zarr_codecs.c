/* SPDX-License-Identifier: BSD-3-Clause */
/* The codecs of Zarr: chunks are unpacked by the libraries of their formats, each of which is
 * optional but for zlib. Nothing is written beyond what the metadata promise of a chunk. */
#include "bytes.h"
#include "chunked/zarr.h"

#if SC_HAVE_BLOSC
#include <blosc.h>
#endif
#if SC_HAVE_LZ4
#include <lz4.h>
#endif
#if SC_HAVE_ZSTD
#include <zstd.h>
#endif

uint32_t sc_zarr_crc32c(const unsigned char *data, size_t bytes)
{
    /* By half bytes, of the polynomial 0x82f63b78, bits reversed. */
    static const uint32_t table[16] = {0x00000000, 0x105ec76f, 0x20bd8ede, 0x30e349b1,
                                       0x417b1dbc, 0x5125dad3, 0x61c69362, 0x7198540d,
                                       0x82f63b78, 0x92a8fc17, 0xa24bb5a6, 0xb21572c9,
                                       0xc38d26c4, 0xd3d3e1ab, 0xe330a81a, 0xf36e6f75};
    uint32_t crc = ~0u;

    for (size_t i = 0; i < bytes; i++) {
        crc ^= data[i];
        crc = table[crc & 15] ^ crc >> 4;
        crc = table[crc & 15] ^ crc >> 4;
    }
    return ~crc;
}

static uint32_t little32(const unsigned char *at)
{
    return (uint32_t)sc_number_at(at, 4, false);
}

/* Unpack in[in_bytes], a stream of zlib or gzip by its header, to out[bytes]. */
static bool inflate_all(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t bytes,
                        char *why)
{
    size_t got;

    if (!sc_chunk_inflate(in, in_bytes, out, bytes, &got, why))
        return false;
    snprintf(why, SC_CHUNK_WHY_BYTES, "gzip: unpacks to fewer bytes than the chunk has");
    return got == bytes;
}

static bool unzstd(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t bytes,
                   char *why)
{
#if SC_HAVE_ZSTD
    const size_t got = ZSTD_decompress(out, bytes, in, in_bytes);

    if (!ZSTD_isError(got) && got == bytes)
        return true;
    snprintf(why, SC_CHUNK_WHY_BYTES, "zstd: %s",
             ZSTD_isError(got) ? ZSTD_getErrorName(got)
                               : "unpacks to fewer bytes than the chunk has");
#else
    snprintf(why, SC_CHUNK_WHY_BYTES, "zstd is not built in");
#endif
    return false;
}

/* Unpack one block of LZ4. @return false if it does not unpack to just @p bytes bytes. */
static bool unlz4_block(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t bytes)
{
#if SC_HAVE_LZ4
    return LZ4_decompress_safe((const char *)in, (char *)out, (int)in_bytes, (int)bytes) ==
           (int)bytes;
#else
    return false; /* it was refused when the metadata was read */
#endif
}

static bool unlz4(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t bytes,
                  char *why)
{
    if (in_bytes >= 4 && little32(in) == bytes && unlz4_block(in + 4, in_bytes - 4, out, bytes))
        return true;
    snprintf(why, SC_CHUNK_WHY_BYTES, "lz4: is damaged, or does not unpack to the size of a chunk");
    return false;
}

/* Unpack the blocks of lz4-java's LZ4BlockOutputStream: each a mark, a byte that says how it is
 * packed, its sizes packed and unpacked, a check sum, and its bytes. */
static bool unlz4_blocks(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t bytes,
                         char *why)
{
    enum { HEADER_BYTES = 21, STORED = 0x10, PACKED = 0x20 };
    size_t at = 0, done = 0;

    if (in_bytes < 8 || memcmp(in, "LZ4Block", 8) != 0)
        return unlz4(in, in_bytes, out, bytes, why);
    while (in_bytes - at >= HEADER_BYTES && !memcmp(in + at, "LZ4Block", 8) && done < bytes) {
        const unsigned how = in[at + 8] & 0xf0u;
        const size_t packed = little32(in + at + 9), most = little32(in + at + 13);

        at += HEADER_BYTES;
        if (packed > in_bytes - at || most > bytes - done || most == 0)
            break;
        if (how == STORED && packed == most)
            memcpy(out + done, in + at, most);
        else if (how != PACKED || !unlz4_block(in + at, packed, out + done, most))
            break;
        at += packed;
        done += most;
    }
    if (done != bytes)
        snprintf(why, SC_CHUNK_WHY_BYTES,
                 "lz4: is damaged, or does not unpack to the size of a block");
    return done == bytes;
}

static bool unblosc(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t bytes,
                    char *why)
{
#if SC_HAVE_BLOSC
    size_t promised = 0;

    if (in_bytes < BLOSC_MIN_HEADER_LENGTH || blosc_cbuffer_validate(in, in_bytes, &promised) < 0)
        snprintf(why, SC_CHUNK_WHY_BYTES, "blosc: is damaged or cut short");
    else if (promised != bytes)
        snprintf(why, SC_CHUNK_WHY_BYTES, "blosc: promises %zu bytes, a chunk has %zu", promised,
                 bytes);
    else if (blosc_decompress_ctx(in, out, bytes, 1) != (int)bytes)
        snprintf(why, SC_CHUNK_WHY_BYTES, "blosc: is damaged");
    else
        return true;
#else
    snprintf(why, SC_CHUNK_WHY_BYTES, "c-blosc is not built in");
#endif
    return false;
}

/* The function that undoes each compression, and the package that it needs if segcast was built
 * without that; NULL: none is lacking. */
static const struct {
    bool (*unpack)(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t bytes,
                   char *why);
    const char *lacks;
} codecs[] = {[SC_ZARR_GZIP] = {inflate_all, NULL},
              [SC_ZARR_ZLIB] = {inflate_all, NULL},
              [SC_ZARR_ZSTD] = {unzstd, SC_HAVE_ZSTD ? NULL : "zstd (Debian: libzstd-dev)"},
              [SC_ZARR_LZ4] = {unlz4, SC_HAVE_LZ4 ? NULL : "lz4 (Debian: liblz4-dev)"},
              [SC_ZARR_LZ4_N5] = {unlz4_blocks, SC_HAVE_LZ4 ? NULL : "lz4 (Debian: liblz4-dev)"},
              [SC_ZARR_BLOSC] = {unblosc, SC_HAVE_BLOSC ? NULL : "c-blosc (Debian: libblosc-dev)"},
              [SC_ZARR_CRC32C] = {0}};

const char *sc_zarr_codec_lacks(sc_zarr_codec codec)
{
    return codecs[codec].lacks;
}

/* Check the four bytes behind data[*bytes - 4], and take them off. */
static bool check_sum(const unsigned char *data, size_t *bytes, char *why)
{
    if (*bytes < 4 || sc_zarr_crc32c(data, *bytes - 4) != little32(data + *bytes - 4)) {
        snprintf(why, SC_CHUNK_WHY_BYTES, "its check sum (crc32c) is wrong");
        return false;
    }
    *bytes -= 4;
    return true;
}

bool sc_zarr_unpack(const sc_zarr_pipeline *pipeline, unsigned char *packed, size_t packed_bytes,
                    unsigned char *room, size_t bytes, const unsigned char **out,
                    char why[SC_CHUNK_WHY_BYTES])
{
    const unsigned char *data = packed;
    size_t have = packed_bytes;

    for (int i = pipeline->count - 1; i >= 0; i--) {
        if (pipeline->codecs[i] == SC_ZARR_CRC32C) {
            if (!check_sum(data, &have, why))
                return false;
        } else { /* the only one; what is in front of it are check sums */
            const size_t unpacked = bytes + 4 * (size_t)i;

            if (!codecs[pipeline->codecs[i]].unpack(data, have, room, unpacked, why))
                return false;
            data = room;
            have = unpacked;
        }
    }
    if (have != bytes) {
        snprintf(why, SC_CHUNK_WHY_BYTES, "has %zu bytes of values, expected %zu", have, bytes);
        return false;
    }
    *out = data;
    return true;
}
