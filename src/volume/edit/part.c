/* SPDX-License-Identifier: BSD-3-Clause */
/* Which voxels of a file are wanted. */
#include "segcast/grey.h"
#include "source.h"

/* Log that the volume has no voxel in the box in mm of @p choice. @return SC_ERR_DATA always. */
static sc_status refuse_box_mm(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                               const sc_source *source)
{
    const sc_box3 all = sc_grid_box_mm(source->size, &source->to_ras_mm);
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: box: the volume has no voxel in the box; it reaches from [%.4g, %.4g, "
                   "%.4g] to [%.4g, %.4g, %.4g] in RAS mm",
                   sc_read_where(choice, path), all.low.x, all.low.y, all.low.z, all.high.x,
                   all.high.y, all.high.z);
}

sc_status sc_source_cut(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                        sc_source *source)
{
    const int *size = source->size;
    sc_voxel_box box = {{0, 0, 0}, {size[0] - 1, size[1] - 1, size[2] - 1}};

    SC_PASS(sc_header_apply(ctx, path, choice, source));
    if (choice->box == SC_READ_MM)
        box = sc_voxels_between(size, &source->to_ras_mm, choice->corners);
    for (int i = 0; i < 3; i++) {
        if (choice->box == SC_READ_VOXELS) {
            if (choice->voxels[i][1] > size[i])
                return sc_fail(ctx, SC_ERR_DATA,
                               "%s: box: [%d, %d] along %c reaches beyond the volume of %d x %d x "
                               "%d voxels, expected at most [0, %d]",
                               sc_read_where(choice, path), choice->voxels[i][0],
                               choice->voxels[i][1], "xyz"[i], size[0], size[1], size[2], size[i]);
            box.low[i] = choice->voxels[i][0];
            box.high[i] = choice->voxels[i][1] - 1;
        }
        if (box.low[i] > box.high[i])
            return refuse_box_mm(ctx, path, choice, source);
        source->low[i] = box.low[i];
        source->part[i] = box.high[i] - box.low[i] + 1;
    }
    return SC_OK;
}

sc_affine sc_source_part_to_ras(const sc_source *source)
{
    sc_affine map = source->to_ras_mm;

    for (int row = 0; row < 3; row++) {
        for (int i = 0; i < 3; i++)
            map.m[row][3] += map.m[row][i] * source->low[i];
    }
    return map;
}

/* From now on the source has only the part that was wanted. */
static void keep_part(sc_source *source)
{
    source->to_ras_mm = sc_source_part_to_ras(source);
    for (int i = 0; i < 3; i++) {
        source->size[i] = source->part[i];
        source->low[i] = 0;
    }
}

sc_status sc_source_take_part(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                              int low[3], sc_source *source)
{
    SC_PASS(sc_geometry_check(ctx, path, source->size, &source->to_ras_mm));
    SC_PASS(sc_source_cut(ctx, path, choice, source));
    for (int i = 0; i < 3; i++) {
        low[i] = source->low[i];
        source->is_part = source->is_part || source->part[i] < source->size[i];
    }
    keep_part(source);
    return SC_OK;
}

void sc_source_set_labels(sc_source *source, sc_voxel_type type, void *labels)
{
    keep_part(source);
    if (source->reader.release && source->reader.data)
        source->reader.release(source->reader.data);
    source->stored.encoding = SC_ENCODING_LOADED;
    source->type = type;
    source->stored.swapped = false;
    source->reader.data = labels;
    source->reader.release = sc_free;
    source->layers = 1;
}
