/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 2: label volumes: voxels as dense ids, their geometry in patient space, their label
 *  table; readers for NRRD, NIfTI and MetaImage. */
#ifndef SEGCAST_VOLUME_H
#define SEGCAST_VOLUME_H

#include "segcast/base.h"
#include "segcast/geom.h"

enum {
    SC_LABELS_MAX = 65536, /**< distinct labels, background included */
    SC_NAME_BYTES = 128    /**< longest name of a label, terminator included */
};

/** One distinct label of a volume, or one row of a label table. */
typedef struct sc_label {
    int64_t value;            /**< as stored in the file */
    char name[SC_NAME_BYTES]; /**< UTF-8; empty: none given */
    uint8_t rgb[3];           /**< sRGB */
    bool has_color;
    bool hidden;   /**< a table says that it is not shown */
    float opacity; /**< of a boundary, 0 to 1; negative: not given */
} sc_label;

/** A segmented volume. Zero-initialise; sc_volume_clear frees. */
typedef struct sc_volume {
    int size[3];      /**< voxels along x (fastest), y, z */
    int label_bytes;  /**< 1 or 2: width of a dense id */
    void *ids;        /**< dense ids, [size z][size y][size x]; id 0 is the label 0, background */
    int label_count;  /**< 1 to SC_LABELS_MAX; 1 up to 256 use one byte */
    sc_label *labels; /**< by dense id: background, then the other values in rising order */
    sc_affine to_ras_mm; /**< voxel index (centres at whole numbers) -> patient mm, RAS+ */
    bool oriented;       /**< false: the file does not say where left is; RAS was taken */
} sc_volume;

void sc_volume_clear(sc_volume *volume);
size_t sc_volume_voxels(const sc_volume *volume);
/** Hash of ids, label values, size and geometry; independent of names, colours and file format. */
uint64_t sc_volume_hash(const sc_volume *volume);

/** Read a label volume. The format is told by content, not by name. Names and colours come from
 *  the file where it has some, else colours are distinct and depend on the label value alone.
 *  @return SC_ERR_MISSING, SC_ERR_DATA (logged with what was found and expected), SC_ERR_MEMORY.
 *  Threads: the libraries behind it keep global state: one call at a time. */
SC_MUST_USE sc_status sc_volume_read(const sc_ctx *ctx, const char *path, sc_volume *out);

typedef enum sc_table_format {
    SC_TABLE_AUTO,
    SC_TABLE_SLICER,     /**< id name R G B A, A = opacity */
    SC_TABLE_FREESURFER, /**< id name R G B T, T = transparency */
    SC_TABLE_ITKSNAP     /**< id R G B A VIS MSH "name" */
} sc_table_format;

/** Rows of a label table, in the order of the file. Caller owns: sc_label_table_clear. */
typedef struct sc_label_table {
    sc_label *rows;
    size_t count, capacity;
} sc_label_table;
void sc_label_table_clear(sc_label_table *table);
SC_MUST_USE sc_status sc_label_table_add(const sc_ctx *ctx, sc_label_table *table,
                                         const sc_label *row);
/** Read a label table. SC_TABLE_AUTO guesses and says which. Of doubled ids the first wins.
 *  @return SC_ERR_MISSING, SC_ERR_DATA with the line. */
SC_MUST_USE sc_status sc_label_table_read(const sc_ctx *ctx, const char *path,
                                          sc_table_format format, sc_label_table *out);
/** Give the labels of @p volume the names and colours of the rows with their values. */
void sc_volume_apply_table(sc_volume *volume, const sc_label_table *table);
/** Turn the voxels of some labels into background; the labels themselves stay in the table.
 *  @param hidden [label_count] by dense id. @param threads as of sc_parallel_for. */
void sc_volume_hide(sc_volume *volume, const bool *hidden, int threads);
/** A distinct, stable colour for a label value, by integer hash. */
void sc_label_hash_color(int64_t value, uint8_t rgb[3]);

#endif
