/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Label volumes on another grid. A volume is often stored on another grid than it was drawn on:
 * voxels were copied up to the grid of an image, or slices are thicker than their pixels are wide.
 * Surfaces are smooth if they are taken from the grid of the drawing, brought to voxels that are
 * about as long as wide.
 *
 *  All functions but sc_find_drawn_grid_together are not collective. They start threads, and the
 *  result does not depend on their number. */
#ifndef SEGCAST_RESAMPLE_H
#define SEGCAST_RESAMPLE_H

#include "segcast/team.h"
#include "segcast/volume.h"

/** The grid on which the author of a segmentation drew it, as far as its voxels tell, and the grid
 * to which sc_resample brings it. */
typedef struct sc_drawn_grid {
    double copies[3]; /**< how many voxels along x, y, z were copied from one: 1 if none were. Not
                         always a whole number: 2.5 stands for two and three in turn */
    double phase[3];  /**< where the first copied voxel begins, in voxels from the outer face of the
                           volume: at most 0 */
    double drawn_mm[3]; /**< spacing of the voxels as they were drawn */
    int split[3]; /**< into how many layers each drawn voxel is split along x, y, z: odd, 1 for none
                   */
    int moved[3]; /**< how many slices across each axis were moved against those around them, as
                     found before anything is changed */
} sc_drawn_grid;

/** Measure how a volume was drawn. Slices count as moved if they jump to and fro, all borders in
 * them together, by most of a pixel or more. Along an axis voxels count as copied if all label
 * borders lie on a regular grid of planes at least 1.5 voxels apart, most of which hold some.
 * Nothing is lost then by keeping one of each. The drawn voxels are split along axes where they are
 * over SC_THICK_RATIO times as long as along their shortest one. @param threads as of
 * sc_parallel_for. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_find_drawn_grid(const sc_ctx *ctx, const sc_volume *volume, int threads,
                                         sc_drawn_grid *out);
/** As sc_find_drawn_grid, by all ranks of a team, who pass the same volume. Collective in the team,
 *  the same result on all its ranks. */
SC_MUST_USE sc_status sc_find_drawn_grid_together(const sc_ctx *ctx, sc_team *team,
                                                  const sc_volume *volume, sc_drawn_grid *out);
/** Slices are thick if they are more than this many times as far apart as their pixels are wide. */
#define SC_THICK_RATIO 1.7

/** @return whether sc_resample has anything to do. */
bool sc_is_resampled(const sc_drawn_grid *grid);

/** Write what sc_resample changes, in words, to @p text, of @p bytes bytes, 320 of which suffice:
 * "drawn at 1.5 x 1.5 x 1.5 mm, stored at 0.3 x 0.3 x 0.3 mm". */
void sc_drawn_grid_text(const sc_drawn_grid *grid, char *text, size_t bytes);
/** Write the voxels along each axis that sc_resample makes of @p volume to @p size. */
void sc_resampled_size(const sc_volume *volume, const sc_drawn_grid *grid, int size[3]);
/** Write about how many bytes sc_resample takes beside the volume and the result to @p out: what is
 * at work of each label, within the box of its voxels, of a few slices at a time. @param threads as
 * of sc_parallel_for. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_resample_bytes(const sc_ctx *ctx, const sc_volume *volume,
                                        const sc_drawn_grid *grid, int threads, double *out);

/** Bring a volume to the grid that sc_find_drawn_grid has found, in place: copied voxels are
 * replaced by one each, slices that were moved against each other are moved back (align.c tells
 * how), and layers are put between thick slices (thick.c). Ids and labels keep their meaning, the
 * geometry its place. @return SC_ERR_MEMORY; the volume may then be resampled in part, and is to be
 * cleared. */
SC_MUST_USE sc_status sc_resample(const sc_ctx *ctx, sc_volume *volume, const sc_drawn_grid *grid,
                                  int threads);

/** Bring a volume to @p size voxels, each at least 1, in place: each new voxel gets the label of
 *  the old one nearest to its centre. The volume fills the same place; tissue thinner than the new
 *  voxels may vanish. @param threads as of sc_parallel_for. @return SC_ERR_MEMORY, the volume
 *  unchanged. */
SC_MUST_USE sc_status sc_resample_nearest(const sc_ctx *ctx, sc_volume *volume, const int size[3],
                                          int threads);

/** Write size and geometry of @p volume on voxels of @p spacing_mm along x, y, z to *size and
 *  *to_ras_mm: the spacing is kept exactly and the middle of the volume stays, so that it may end
 * up to half a voxel earlier or later. Only size and geometry of the volume are read. */
void sc_resample_votes_grid(const sc_volume *volume, const double spacing_mm[3], int size[3],
                            sc_affine *to_ras_mm);
/** Bring a volume to voxels of @p spacing_mm along x, y, z (sc_resample_votes_grid), in place: each
 *  new voxel gets the label with the largest vote (votes.c), so that no label is invented and
 * borders stay smooth. What is thin against the old voxels keeps its voxels where these become
 * finer; what is thin against the new ones may vanish. @param threads as of sc_parallel_for; the
 * result does not depend on it. @return SC_ERR_MEMORY, the volume unchanged. */
SC_MUST_USE sc_status sc_resample_votes(const sc_ctx *ctx, sc_volume *volume,
                                        const double spacing_mm[3], int threads);

/** How the borders of labels move from one phase of a series to the next (between.c). */
typedef struct sc_between sc_between;
/** Find how borders move from volume @p a to @p b, which have the same size, geometry and labels.
 * The result takes 80 bytes for each voxel whose label changes. The search takes 12 bytes more for
 * each of these, and 16 bytes for each voxel of a box: the largest of the boxes that enclose, for
 * each label, the voxels that change from or to it. @param threads as of
 *  sc_parallel_for; the result does not depend on it. @return SC_ERR_MEMORY; SC_ERR_SYSTEM, logged,
 *  if that, and a copy of a volume, is more than ctx->memory_max_bytes, or if the box has too many
 *  voxels. Caller owns *out: sc_between_free. */
SC_MUST_USE sc_status sc_between_find(const sc_ctx *ctx, const sc_volume *a, const sc_volume *b,
                                      int threads, sc_between **out);
/** Change @p volume, a copy of the first or of the second volume, to the labels at a moment between
 *  them. @param share the moment: 0 is that of the first volume, 1 that of the second. Threads:
 * any, on volumes of their own. */
void sc_between_at(const sc_between *between, double share, sc_volume *volume);
/** Free it; NULL is allowed. */
void sc_between_free(sc_between *between);
SC_CLOSE_AT(sc_between_free, sc_between)

#endif
