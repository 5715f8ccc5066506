/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Grey volumes: one number for each voxel, such as a CT or MR image. The readers are those of
 * label volumes; values may be fractions. They are held in 16 bits: values of 8 and 16 bits
 * exactly, those of wider types in 65,536 steps over their range. */
#ifndef SEGCAST_GREY_H
#define SEGCAST_GREY_H

#include "segcast/volume.h"

/** The range of values that is shown from black to white, as medical viewers count it. */
typedef struct sc_grey_window {
    double level; /**< the value in the middle */
    double width; /**< white minus black, above 0 */
} sc_grey_window;

/** A grey volume. It owns nothing: the caller allocates the codes, so that the ranks of a node can
 *  share them. Zero-initialise. */
typedef struct sc_grey {
    int size[3];         /**< voxels along x (fastest), y, z */
    sc_affine to_ras_mm; /**< voxel index (centres at whole numbers) -> patient mm, RAS+ */
    double low;          /**< the value of code 0 */
    double per_code;     /**< value = low + per_code * code; below 0 if the file says so */
    uint16_t *codes;     /**< [size z][size y][size x] */
} sc_grey;

/** @return bytes of the codes, from the size alone. */
size_t sc_grey_bytes(const sc_grey *grey);
/** Read the header of a file with a grey volume, in the formats of sc_volume_read: fills size and
 *  to_ras_mm of *out, and leaves the rest 0. A file that does not say where left is gets a warning.
 *  @return SC_ERR_MISSING; SC_ERR_DATA for a file that cannot be used, for one with several values
 *  for a voxel (colours, series, layers), and for a directory that is no Zarr store; SC_ERR_SYSTEM
 *  if the codes take more than ctx->memory_max_bytes; SC_ERR_MEMORY; all logged. Threads: as
 *  sc_volume_read. */
SC_MUST_USE sc_status sc_grey_read_header(const sc_ctx *ctx, const char *path, sc_grey *out);
/** Read the voxels of the file whose header is in @p grey: fills its codes, which the caller has
 *  allocated, low and per_code. Voxels that are no number become the lowest value, with a warning;
 *  infinite ones the lowest or highest. Of wide types, the codes are spread over what lies near the
 *  window, or else over what most voxels hold, so that a few extreme values cost no precision; what
 *  lies beyond becomes the end of the range. @param window that will be shown; NULL: not known yet.
 *  @return as sc_grey_read_header; SC_ERR_DATA also if the file has changed its size; after an
 * error the codes are unspecified. */
SC_MUST_USE sc_status sc_grey_read(const sc_ctx *ctx, const char *path,
                                   const sc_grey_window *window, sc_grey *grey);

/** Choose a window by what the tissues of a label volume hold: from the 1st to the 99th percentile
 *  of the values nearest to the centres of their voxels, of about a million of these. It is made
 *  wider if it is narrower than a thousandth of the range. @param labels with ids and geometry;
 *  background is left out. @param found whether a voxel of a tissue lies within the grey volume; if
 *  none does, the window is all that codes can stand for. One thread. @return SC_ERR_MEMORY;
 * SC_ERR_DATA if the geometry of the grey volume is singular. */
SC_MUST_USE sc_status sc_grey_auto_window(const sc_ctx *ctx, const sc_grey *grey,
                                          const sc_volume *labels, sc_grey_window *out,
                                          bool *found);
/** Write a grey volume as NRRD, gzip-compressed, with its values as whole numbers of 16 bits.
 *  @param replace as of sc_outfile_open. @return as sc_volume_save_nrrd. */
SC_MUST_USE sc_status sc_grey_save_nrrd(const sc_ctx *ctx, const sc_grey *grey, const char *path,
                                        bool replace);
/** @return the box in RAS mm around the voxels of a grid, to their outer faces. */
sc_box3 sc_grid_box_mm(const int size[3], const sc_affine *to_ras_mm);

#endif
