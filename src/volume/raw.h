/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: what a format's reader hands on, before labels become dense ids. */
#ifndef SC_VOLUME_RAW_H
#define SC_VOLUME_RAW_H

#include "segcast/volume.h"

typedef enum sc_raw_type {
    SC_RAW_INT8,
    SC_RAW_UINT8,
    SC_RAW_INT16,
    SC_RAW_UINT16,
    SC_RAW_INT32,
    SC_RAW_UINT32,
    SC_RAW_INT64,
    SC_RAW_UINT64,
    SC_RAW_FLOAT,
    SC_RAW_DOUBLE
} sc_raw_type;

typedef struct sc_raw {
    int size[3];
    sc_raw_type type;
    void *data; /* native byte order, x fastest */
    void (*release)(void *data);
    double slope, intercept; /* label = slope * stored + intercept; 1 and 0 leave it alone */
    sc_affine to_ras_mm;
    bool oriented;
    sc_label_table table; /* what the file itself says about its labels */
} sc_raw;

size_t sc_raw_type_bytes(sc_raw_type type);
void sc_raw_clear(sc_raw *raw);

/* Most bytes a volume may have once read, whatever its header claims. */
#define SC_VOLUME_BYTES_MAX ((uint64_t)1 << 40)
/* A deflate stream cannot expand more than this. */
#define SC_DEFLATE_RATIO_MAX 1032.0

/* Voxels of a grid; SC_ERR_DATA (logged) for sizes below 1 or a total that overflows. */
sc_status sc_grid_voxels(const sc_ctx *ctx, const char *path, const int64_t size[3],
                         size_t bytes_per_voxel, size_t *out);
/* Check that the map is finite and invertible; SC_ERR_DATA (logged). */
sc_status sc_geometry_check(const sc_ctx *ctx, const char *path, const sc_affine *to_mm);

sc_status sc_read_nrrd(const sc_ctx *ctx, const char *path, sc_raw *out);
sc_status sc_read_nifti(const sc_ctx *ctx, const char *path, sc_raw *out);
sc_status sc_read_meta(const sc_ctx *ctx, const char *path, sc_raw *out);
/* Read exactly @p bytes from a file that may be gzip-compressed, beginning @p offset bytes into
 * what it unpacks to, and check the compressed stream to its end. */
sc_status sc_read_gz(const sc_ctx *ctx, const char *path, uint64_t offset, void *data,
                     size_t bytes);

/* Labels to dense ids; fills ids, labels, label_count, label_bytes, size of @p out. */
sc_status sc_densify(const sc_ctx *ctx, const char *path, const sc_raw *raw, sc_volume *out);

#endif
