/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the parts that stores of Zarr and N5 are read with. Sources: the Zarr
 * specifications, version 2 and 3.0 (zarr-specs.readthedocs.io), the codec sharding_indexed 1.0,
 * OME-Zarr 0.4 and 0.5 (ngff.openmicroscopy.org), the file-system specification of N5
 * (github.com/saalfeldlab/n5). */
#ifndef SC_VOLUME_ZARR_H
#define SC_VOLUME_ZARR_H

#include "chunked/chunks.h"

enum {
    SC_ZARR_RANK_MAX = 8,               /* dimensions of an array */
    SC_ZARR_CHUNK_VALUES_MAX = 1 << 30, /* so are chunks of more values */
    SC_ZARR_N5 = 5 /* sc_zarr_node.version of N5, whose version is the store's */
};

/* ---- files (zarr_store.c) ---- */

/* A directory of a store: a group or an array. Zero-initialise with fd -1; sc_zarr_node_clear
 * frees. */
typedef struct sc_zarr_node {
    int fd;             /* of the directory */
    char *path;         /* for messages, owned */
    int version;        /* 2, 3 or SC_ZARR_N5 */
    bool is_array;      /* else a group */
    json_t *meta;       /* zarr.json, .zarray, .zgroup or attributes.json, owned */
    json_t *attributes; /* those of the user; NULL: none; owned */
    const char *meta_name, *attributes_name; /* the files they are from; static */
} sc_zarr_node;

/* Is the directory @p path one of Zarr, by the metadata in it? */
bool sc_zarr_is_node(const char *path);
/* Is it one of N5, by its metadata, those of the level s0 in it, or its name? Groups of N5 need no
 * metadata. */
bool sc_n5_is_node(const char *path);
/* Open the directory @p path, which may be a link, and read its metadata. @return SC_ERR_MISSING
 * if it is none of Zarr or N5; SC_ERR_DATA for metadata that are broken; SC_ERR_MEMORY. Caller owns
 * *out: sc_zarr_node_clear. */
sc_status sc_zarr_node_open(const sc_ctx *ctx, const char *path, sc_zarr_node *out);
/* As sc_zarr_node_open for the directory @p name below @p parent, a path with "/" that comes from
 * a header: SC_ERR_DATA if it leads elsewhere. No part of it may be a link. */
sc_status sc_zarr_node_open_below(const sc_ctx *ctx, const sc_zarr_node *parent, const char *name,
                                  sc_zarr_node *out);
/* @return whether there is a directory called @p name in @p parent with metadata of the same kind.
 */
bool sc_zarr_has(const sc_zarr_node *parent, const char *name);
void sc_zarr_node_clear(sc_zarr_node *node);

/* ---- arrays (zarr_meta.c) ---- */

/* A step between stored bytes and the values of a chunk. */
typedef enum sc_zarr_codec {
    SC_ZARR_GZIP,
    SC_ZARR_ZLIB,
    SC_ZARR_ZSTD,
    SC_ZARR_LZ4,    /* of numcodecs: the size as four bytes, then one block */
    SC_ZARR_LZ4_N5, /* of N5: blocks of lz4-java; some writers store that of numcodecs */
    SC_ZARR_BLOSC,
    SC_ZARR_CRC32C
} sc_zarr_codec;
enum { SC_ZARR_CODECS_MAX = 4 };

/* How chunks become bytes. */
typedef struct sc_zarr_pipeline {
    int order[SC_ZARR_RANK_MAX]; /* the dimensions as they are stored, slowest first */
    bool big_endian;
    sc_zarr_codec codecs[SC_ZARR_CODECS_MAX]; /* in the order of writing */
    int count;
} sc_zarr_pipeline;

/* An array, by its metadata. */
typedef struct sc_zarr_array {
    int rank;
    int64_t shape[SC_ZARR_RANK_MAX];
    int64_t file_shape[SC_ZARR_RANK_MAX]; /* of what one file holds: a chunk or a shard */
    int64_t chunk[SC_ZARR_RANK_MAX];      /* of what is unpacked at a time */
    sc_voxel_type type;
    unsigned char fill[8]; /* the value of chunks that are not there, in this byte order */
    sc_zarr_pipeline pipeline;
    bool blocks; /* N5: each file begins with the size of its block, and its name has the numbers of
                    the dimensions in reverse order */
    bool sharded;
    bool index_first, index_big_endian, index_crc; /* of shards */
    const char *prefix;                            /* of the names of chunks: "" or "c" */
    char separator;                                /* between their numbers: '.' or '/' */
    char names[SC_ZARR_RANK_MAX][32]; /* of the dimensions, if the array gives some; else empty */
} sc_zarr_array;

/* Read the metadata of the array @p node, the dimensions slowest first. @return SC_ERR_DATA for
 * what cannot be read, with the key, what was found and expected; SC_ERR_MEMORY. */
sc_status sc_zarr_array_read(const sc_ctx *ctx, const sc_zarr_node *node, sc_zarr_array *out);
/* @return the values of a chunk of this shape. */
size_t sc_zarr_values(const sc_zarr_array *array, const int64_t shape[SC_ZARR_RANK_MAX]);

/* ---- codecs (zarr_codecs.c) ---- */

/* @return the package without which segcast was built and which @p codec needs; NULL: none. */
const char *sc_zarr_codec_lacks(sc_zarr_codec codec);
/* Undo the codecs of @p pipeline: packed[packed_bytes], which is changed, becomes the @p bytes
 * bytes of a chunk in *out, which is within @p packed or is @p room (of bytes + 64). @param why
 * receives the reason for false. Threads: any, on memory of their own. */
bool sc_zarr_unpack(const sc_zarr_pipeline *pipeline, unsigned char *packed, size_t packed_bytes,
                    unsigned char *room, size_t bytes, const unsigned char **out,
                    char why[SC_CHUNK_WHY_BYTES]);
/* @return the check sum of the codec crc32c (Castagnoli, RFC 3720). */
uint32_t sc_zarr_crc32c(const unsigned char *data, size_t bytes);

/* ---- OME-Zarr (ome_zarr.c) ---- */

/* Which array of a store is shown, and what its groups say of it. */
typedef struct sc_zarr_choice {
    sc_zarr_node array;
    char *coarser;        /* the path of the next level of resolution; NULL: none; owned */
    sc_label_table table; /* of the label image */
    bool named;           /* multiscales give the axes */
    int axes;             /* if so: how many */
    char names[SC_ZARR_RANK_MAX][32];
    double unit_mm[SC_ZARR_RANK_MAX]; /* of the axes; 0: not given, or not known */
    double unit_s[SC_ZARR_RANK_MAX];  /* the same for times */
    bool scaled;                      /* a scale is given */
    double scale[SC_ZARR_RANK_MAX], shift[SC_ZARR_RANK_MAX]; /* of the axes, in their units */
} sc_zarr_choice;
/* Find the array to be shown by the path that the user has given: an array, a label image, a group
 * "labels", or an image with labels, the latter in the resolution @p level, 0 the finest. @return
 * SC_ERR_DATA, logged with the names to choose from if there are several, and with the levels if
 * there is no such one; the errors of sc_zarr_node_open. Caller owns *out: sc_zarr_choice_clear. */
sc_status sc_zarr_choose(const sc_ctx *ctx, const char *path, int level, sc_zarr_choice *out);
void sc_zarr_choice_clear(sc_zarr_choice *choice);

/* ---- N5 (n5.c) ---- */

/* As sc_zarr_choose, of N5: a dataset, a group with the levels s0, s1, ..., or a group above, in
 * which there is only one such. */
sc_status sc_n5_choose(const sc_ctx *ctx, const char *path, int level, sc_zarr_choice *out);
/* Read the header of the block @p at, by its place along the dimensions, in packed[packed_bytes].
 * @param shape receives its size along the dimensions: that of a chunk, or less at an end of the
 * array. *begin receives where the values begin. @param why receives the reason for false. */
bool sc_n5_block_read(const sc_zarr_array *array, const size_t at[SC_ZARR_RANK_MAX],
                      const unsigned char *packed, size_t packed_bytes,
                      int64_t shape[SC_ZARR_RANK_MAX], size_t *begin, char why[SC_CHUNK_WHY_BYTES]);

#endif
