/* SPDX-License-Identifier: BSD-3-Clause */
/* Neuroglancer's compressed segmentation: a chunk is cut into blocks, each of which has a table of
 * its labels and a few bits for each voxel, the place of its label in that table. */
#include "bytes.h"
#include "chunked/precomputed.h"

enum { HEADER_WORDS = 2 }; /* of a block */

static uint32_t word32(const unsigned char *at)
{
    return (uint32_t)sc_number_at(at, 4, false);
}

/* The blocks of a chunk along x, y, z. */
static void block_grid(const size_t count[3], const size_t block[3], size_t out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (count[i] + block[i] - 1) / block[i];
}

double sc_precomputed_blocks_most(const size_t count[3], const size_t block[3])
{
    size_t grid[3];
    double blocks, voxels;

    block_grid(count, block, grid);
    blocks = (double)grid[0] * (double)grid[1] * (double)grid[2];
    voxels = blocks * (double)block[0] * (double)block[1] * (double)block[2];
    return 4 + blocks * 4 * HEADER_WORDS + voxels * (4 + 8);
}

/* A chunk while it is decoded. */
typedef struct chunk_words {
    const unsigned char *words; /* those of the only channel: offsets count from here */
    size_t count;
    const size_t *size, *block; /* of the chunk and of a block, voxels along x, y, z */
    size_t voxel_bytes;
    unsigned char *out;
} chunk_words;

/* Decode the block at @p at, in blocks, whose header is the one with number @p number. @return the
 * reason if it is damaged, else NULL. */
static const char *decode_block(const chunk_words *c, const size_t at[3], size_t number)
{
    const unsigned char *header = c->words + 4 * HEADER_WORDS * number;
    const size_t table = word32(header) & 0xffffff, values = word32(header + 4);
    const unsigned bits = word32(header) >> 24, per_word = bits && bits <= 32 ? 32 / bits : 1;
    const size_t label_words = c->voxel_bytes / 4;
    const size_t positions = c->block[0] * c->block[1] * c->block[2];
    const size_t value_words = bits ? (positions + per_word - 1) / per_word : 0;
    const uint32_t mask = bits < 32 ? ((uint32_t)1 << bits) - 1 : UINT32_MAX;
    size_t begin[3], end[3];

    if (bits > 32 || (bits & (bits - 1)))
        return "a block whose bits for each voxel are not 0, 1, 2, 4, 8, 16 or 32";
    if (values > c->count || value_words > c->count - values)
        return "a block whose values lie behind its end";
    for (int i = 0; i < 3; i++) {
        begin[i] = at[i] * c->block[i];
        end[i] = begin[i] + c->block[i] < c->size[i] ? begin[i] + c->block[i] : c->size[i];
    }
    for (size_t z = begin[2]; z < end[2]; z++) {
        for (size_t y = begin[1]; y < end[1]; y++) {
            unsigned char *to =
                c->out + ((z * c->size[1] + y) * c->size[0] + begin[0]) * c->voxel_bytes;
            size_t i = ((z - begin[2]) * c->block[1] + y - begin[1]) * c->block[0];

            for (size_t x = begin[0]; x < end[0]; x++, i++, to += c->voxel_bytes) {
                const size_t place =
                    bits ? word32(c->words + 4 * (values + i / per_word)) >> i % per_word * bits &
                               mask
                         : 0;
                const size_t label = table + place * label_words;

                if (label > c->count || label_words > c->count - label)
                    return "a voxel whose label lies behind its end";
                memcpy(to, c->words + 4 * label, c->voxel_bytes);
            }
        }
    }
    return NULL;
}

bool sc_precomputed_decode_blocks(const unsigned char *packed, size_t packed_bytes,
                                  const size_t count[3], const size_t block[3], size_t voxel_bytes,
                                  unsigned char *out, char why[SC_CHUNK_WHY_BYTES])
{
    const size_t words = packed_bytes / 4, first = words ? word32(packed) : 0;
    chunk_words c = {.size = count, .block = block, .voxel_bytes = voxel_bytes, .out = out};
    const char *wrong = NULL;
    size_t grid[3], at[3], number = 0;

    block_grid(count, block, grid);
    if (words && first != 1) /* where the blocks of the only channel begin, in words */
        wrong = "another first word than 1, so that it is not packed so, or has several channels";
    else if (packed_bytes % 4 || !words ||
             (words - first) / HEADER_WORDS / grid[0] / grid[1] < grid[2])
        wrong = "fewer bytes than its blocks need";
    if (!wrong) {
        c.words = packed + 4 * first;
        c.count = words - first;
    }
    for (at[2] = 0; at[2] < grid[2] && !wrong; at[2]++) {
        for (at[1] = 0; at[1] < grid[1] && !wrong; at[1]++) {
            for (at[0] = 0; at[0] < grid[0] && !wrong; at[0]++)
                wrong = decode_block(&c, at, number++);
        }
    }
    if (wrong)
        snprintf(why, SC_CHUNK_WHY_BYTES, "compressed_segmentation: has %s", wrong);
    return !wrong;
}
