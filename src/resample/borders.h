/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxels at the borders between labels, block by block, and other labels for them. */
#ifndef SEGCAST_RESAMPLE_BORDERS_H
#define SEGCAST_RESAMPLE_BORDERS_H

#include "internal.h"

enum { BORDER_LABELS = 32 }; /* of a block; where more meet nothing is flat, and it is left alone */

/* A voxel that has a neighbour with another label by one of its faces. */
typedef struct border_voxel {
    uint8_t at[3];     /* in its block */
    uint8_t own;       /* entry of the label that it carries, in the labels of its block */
    uint8_t others[6]; /* entries of its neighbours */
    uint8_t chosen;    /* entry of the label that it gets */
    bool is_flat;      /* is the border flat there? For sc_borders_measure alone */
} border_voxel;

/* A block of voxels at work. The arrays are owned. */
typedef struct border_block {
    size_t low[3]; /* its first voxel */
    uint16_t labels[BORDER_LABELS];
    int label_count, voxel_count;
    border_voxel *voxels; /* [edge[0] * edge[1] * edge[2]], of which voxel_count are set */
    uint16_t *ids;        /* of the block and the voxels beside it, x fastest */
} border_block;

/* A way to choose labels. Its functions are called by several threads, of different blocks. */
typedef struct border_method {
    int edge[3];       /* of its blocks, in voxels: at most 64 */
    int sample_blocks; /* that sc_borders_measure looks at, all of which hold borders */
    int looked_at;     /* among how many blocks these are searched for */
    const void *self;  /* what both functions get */
    /* May the block whose first voxel is @p low hold borders? NULL: every one may. */
    bool (*may_hold)(const void *self, const size_t low[3]);
    /* May this block be one of the sample? NULL: every one that holds borders. */
    bool (*is_sampled)(const void *self, const border_block *b, int thread);
    /* Set what each voxel gets. */
    void (*choose)(const void *self, border_block *b, int thread);
} border_method;

/* What sc_borders_measure finds, as shares of all voxels at borders that it looks at. */
typedef struct border_shares {
    double changed, flat;
} border_shares;

/* Measure which share of the voxels at borders would get another label, and which lies in flat
 * borders, in a sample. Collective in the team, the same result on all its ranks. @return
 * SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_borders_measure(const sc_ctx *ctx, sc_team *team, const drawn_view *view,
                                         const border_method *method, border_shares *out);
/* Give all voxels at the borders of a volume without copied voxels the labels that are chosen, all
 * by what the volume is before. @return SC_ERR_MEMORY, the volume unchanged. */
SC_MUST_USE sc_status sc_borders_relabel(const sc_ctx *ctx, sc_volume *v, const drawn_view *view,
                                         const border_method *method, int threads);

/* @return what plane @p at along an axis adds to a voxel's index; the next plane's within. */
static inline size_t border_offset(const drawn_view *view, int axis, ptrdiff_t at)
{
    const ptrdiff_t last = view->size[axis] - 1;

    return view->offset[axis][at < 0 ? 0 : at > last ? last : at];
}

/* Does the label of an entry contend for a voxel? */
static inline bool border_contends(const border_voxel *voxel, int entry)
{
    bool found = voxel->own == entry;

    for (int i = 0; i < 6; i++)
        found = found || voxel->others[i] == entry;
    return found;
}

#endif
