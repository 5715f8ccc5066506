/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the parts that volumes of Neuroglancer's precomputed format are read with.
 * Sources: "Precomputed volume format", "Compressed segmentation" and "Sharded format" in the
 * documentation of Neuroglancer (github.com/google/neuroglancer, src/datasource/precomputed and
 * src/sliceview/compressed_segmentation). */
#ifndef SC_VOLUME_PRECOMPUTED_H
#define SC_VOLUME_PRECOMPUTED_H

#include "chunked/chunks.h"

/* ---- compressed segmentation (precomputed_blocks.c) ---- */

/* @return the most bytes that the values of @p count voxels may take: a chunk of blocks of @p block
 * voxels along x, y, z. */
double sc_precomputed_blocks_most(const size_t count[3], const size_t block[3]);
/* Decode a chunk of count[0] x count[1] x count[2] voxels, labels of @p voxel_bytes (4 or 8) bytes,
 * from packed[packed_bytes] to @p out, x fastest, in the order of bytes of the file, the least
 * first.
 * @param why receives the reason for false. Threads: any, on memory of their own. */
bool sc_precomputed_decode_blocks(const unsigned char *packed, size_t packed_bytes,
                                  const size_t count[3], const size_t block[3], size_t voxel_bytes,
                                  unsigned char *out, char why[SC_CHUNK_WHY_BYTES]);

/* ---- shards (precomputed_shards.c) ---- */

/* How chunks are found in shards. */
typedef struct sc_precomputed_sharding {
    int preshift_bits, minishard_bits, shard_bits;
    bool hashed;        /* by MurmurHash3_x86_128, else not */
    bool index_gzipped; /* the indices of minishards are */
    bool data_gzipped;  /* the chunks are */
} sc_precomputed_sharding;
/* Read the "sharding" of a scale. @return false if it is not as expected: *key is what. */
bool sc_precomputed_sharding_read(const json_t *json, sc_precomputed_sharding *out,
                                  const char **key);
/* @return how many bits the number of a chunk has, of a grid of grid[0] x grid[1] x grid[2] chunks:
 * at most 64 can be found in shards. */
int sc_precomputed_chunk_bits(const uint64_t grid[3]);
/* @return the number of the chunk @p at, its compressed Morton code. */
uint64_t sc_precomputed_chunk_number(const uint64_t grid[3], const size_t at[3]);

/* Write the name of the shard that holds the chunk with the number @p chunk. */
void sc_precomputed_shard_name(const sc_precomputed_sharding *sharding, uint64_t chunk,
                               char out[SC_CHUNK_KEY_BYTES]);
/* As sc_chunk_finder.want: a part is a minishard. */
void sc_precomputed_want(const sc_precomputed_sharding *sharding, const uint64_t grid[3],
                         const size_t at[3], sc_chunk_wanted *out);
/* As sc_chunk_finder.find. */
const char *sc_precomputed_find(const sc_precomputed_sharding *sharding, int fd,
                                const sc_chunk_wanted *wanted, size_t count, uint64_t *left,
                                sc_chunk_place *places);

#endif
