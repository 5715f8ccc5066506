/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

sc_status sc_prepare(const sc_ctx *ctx, const sc_volume *volume,
                     const sc_prepare_settings *settings, sc_preparation **out)
{
    sc_preparation *p = NULL;
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *p, &block));
    p = block;
    p->volume = volume;
    p->settings = *settings;
    for (int i = 0; i < 3; i++)
        p->bricks[i] = sc_bricks_along(volume->size[i]);
    p->brick_count = sc_brick_count(p->bricks);
    p->volume_hash = sc_volume_hash(volume);
    SC_TRY(sc_zalloc(ctx, (size_t)volume->label_count, 1, &block));
    p->hidden = block;
    for (int id = 0; settings->hidden && id < volume->label_count; id++)
        p->hidden[id] = settings->hidden[id];
    p->settings.hidden = NULL; /* it was only borrowed for this call */
    SC_TRY(sc_find_boundary(ctx, p));
    SC_TRY(sc_index_boundary(ctx, p));
    SC_TRY(sc_find_fields(ctx, p));
    SC_TRY(sc_polish_fields(ctx, p));
    if (settings->surface)
        SC_TRY(sc_measure_surface(ctx, p));
    if (settings->thickness || settings->local_thickness)
        SC_TRY(sc_measure_thickness(ctx, p));
    *out = p;
    return SC_OK;
out:
    sc_preparation_free(p);
    return status;
}

void sc_preparation_free(sc_preparation *p)
{
    if (!p)
        return;
    sc_free(p->near);
    sc_free(p->near_start);
    sc_free(p->records);
    sc_free(p->thickness);
    sc_free(p->stats);
    sc_free(p->hidden);
    sc_free(p);
}

void sc_each_boundary(const sc_preparation *p, size_t begin, size_t end, sc_boundary_fn *visit,
                      void *user)
{
    const sc_volume *volume = p->volume;

    for (size_t brick = begin; brick < end; brick++) {
        uint64_t mask = p->near[brick];
        sc_boundary_voxel voxel = {.record = p->near_start[brick]};
        int low[3];

        sc_brick_low(p->bricks, brick, low);
        for (; mask; mask &= mask - 1, voxel.record++) {
            const int bit = __builtin_ctzll(mask);

            voxel.x = low[0] + sc_bit_x(bit) - 1;
            voxel.y = low[1] + sc_bit_y(bit) - 1;
            voxel.z = low[2] + sc_bit_z(bit) - 1;
            voxel.id = sc_id_or_background(volume, voxel.x, voxel.y, voxel.z);
            if (!voxel.id)
                continue;
            voxel.index = ((size_t)voxel.z * (size_t)volume->size[1] + (size_t)voxel.y) *
                              (size_t)volume->size[0] +
                          (size_t)voxel.x;
            visit(user, &voxel);
        }
    }
}
