/* SPDX-License-Identifier: BSD-3-Clause */
/* What the files of this module share. */
#ifndef SEGCAST_RESAMPLE_INTERNAL_H
#define SEGCAST_RESAMPLE_INTERNAL_H

#include "segcast/resample.h"

/* Functions that take a team are collective in it, and return the same on all its ranks. */

/* Set copies and phase of those axes of @p grid along which voxels were copied. @return
 * SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_resample_find_copies(const sc_ctx *ctx, sc_team *team, const sc_volume *v,
                                              sc_drawn_grid *grid);

/* @return how many drawn voxels lie within @p size planes along an axis: see sc_drawn_grid. */
int sc_resample_drawn_within(int size, double copies, double phase);

/* @return the stored plane that drawn voxel @p n along an axis is read from. */
int sc_resample_plane_of(int size, double copies, double phase, int n);

/* Keep one of each group of copied voxels along @p axis, in place: see sc_drawn_grid. @return
 * SC_ERR_MEMORY, the volume unchanged. */
SC_MUST_USE sc_status sc_resample_remove_copies(const sc_ctx *ctx, sc_volume *v, int axis,
                                                double copies, double phase);

/* Find the boxes of all labels, in voxels; that of a label without voxels has low > high. @param
 * out receives [label_count], the caller owns it.
 * @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_resample_find_boxes(const sc_ctx *ctx, const sc_volume *v, int threads,
                                             sc_label_tally **out);

/* @return how many bytes sc_resample_split_slices takes beside the result, of a volume of which
 * only size, geometry and the number of labels are needed, and the boxes of its labels. */
double sc_resample_split_bytes(const sc_volume *v, const sc_label_tally *boxes, int axis,
                               int threads);

/* Split each slice across @p axis into @p split layers, an odd number, in place. @return
 * SC_ERR_MEMORY, the volume unchanged. */
SC_MUST_USE sc_status sc_resample_split_slices(const sc_ctx *ctx, sc_volume *v, int axis, int split,
                                               int threads);

/* A volume as it was drawn: without copied voxels. The offsets are owned. */
typedef struct drawn_view {
    const sc_volume *v; /* as it is stored */
    int size[3];        /* in drawn voxels */
    size_t *offset[3];  /* [size]: what each plane adds to the index of a voxel of v */
} drawn_view;

/* Make the view of a volume of which copies and phase are known. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_drawn_view_make(const sc_ctx *ctx, const sc_volume *v,
                                         const sc_drawn_grid *grid, drawn_view *out);
/* Free what a view owns. */
void sc_drawn_view_clear(drawn_view *view);

/* Find where the slices across @p axis were moved to: align.c tells how. @param places receives for
 * each slice by how many pixels its content lies off along the two other axes, in their order,
 * [size of the axis][2]: 0 where slices do not jump to and fro. @param moved receives how many
 * slices lie off. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_resample_find_moved(const sc_ctx *ctx, sc_team *team,
                                             const drawn_view *view, int axis, int *places,
                                             int *moved);
/* Move the slices across @p axis back by what sc_resample_find_moved finds, in place; at the edges
 * the last pixels are repeated. @return SC_ERR_MEMORY, the volume unchanged. */
SC_MUST_USE sc_status sc_resample_move_slices(const sc_ctx *ctx, sc_volume *v, int axis,
                                              int threads);

/* Set size and geometry of a volume along @p axis: @p count planes, the middle of the first of
 * which lies @p first old planes behind that of the first old one, and @p step old planes apart. */
void sc_resample_set_axis(sc_volume *v, int axis, int count, double first, double step);

/* Replace the voxels of a volume, which takes over @p ids, along @p axis; the rest as of
 * sc_resample_set_axis. */
void sc_resample_set_planes(sc_volume *v, void *ids, int axis, int count, double first,
                            double step);

#endif
