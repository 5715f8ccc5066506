/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxels that belong to several tissues: which one has them, and what the user is told. */
#include "source.h"

bool sc_overlap_wins(sc_overlap overlap, uint64_t voxels, size_t place, uint64_t other_voxels,
                     size_t other_place)
{
    if (overlap == SC_OVERLAP_SMALLER && voxels != other_voxels)
        return voxels < other_voxels;
    return place > other_place;
}

void sc_overlap_warn(const sc_ctx *ctx, const char *path, const char *what, sc_overlap overlap,
                     const sc_overlap_count *count, const sc_label_table *table)
{
    sc_text pair = {0};

    if (!count->voxels)
        return;
    if (count->most && sc_text_add(ctx, &pair, ", most often as \"%s\" and not \"%s\" (%llu)",
                                   table->rows[count->winner].name, table->rows[count->loser].name,
                                   (unsigned long long)count->most) != SC_OK)
        return; /* the allocation has told so */
    sc_warn(ctx, "%s: %llu voxel%s to several %s; each is shown as the %s of them (overlap: %s)%s",
            path, (unsigned long long)count->voxels, count->voxels == 1 ? " belongs" : "s belong",
            what, overlap == SC_OVERLAP_SMALLER ? "smallest" : "last",
            overlap == SC_OVERLAP_SMALLER ? "smaller" : "order", pair.data ? pair.data : "");
    sc_text_clear(&pair);
}
