/* SPDX-License-Identifier: BSD-3-Clause */
/* A volume on more or fewer voxels, each with the label of the old voxel nearest to its centre. */
#include "internal.h"

/* What the threads share. */
typedef struct nearest_work {
    const sc_volume *from;
    int size[3];     /* of the new volume */
    const int *x_of; /* [size x]: the old plane that each new one is read from */
    void *ids;       /* of the new volume */
} nearest_work;

/* @return the old plane nearest to the centre of the new plane @p n. */
static int plane_of(int n, int from, int to)
{
    return (int)((2 * (int64_t)n + 1) * from / (2 * (int64_t)to));
}

/* Fill the new rows [begin, end), counted through all slices. */
static void fill_rows(void *user, size_t begin, size_t end, int thread)
{
    const nearest_work *w = user;
    const sc_volume *from = w->from;

    for (size_t row = begin; row < end; row++) {
        const int y = plane_of((int)(row % (size_t)w->size[1]), from->size[1], w->size[1]);
        const int z = plane_of((int)(row / (size_t)w->size[1]), from->size[2], w->size[2]);
        const size_t at = ((size_t)z * (size_t)from->size[1] + (size_t)y) * (size_t)from->size[0];
        const size_t to = row * (size_t)w->size[0];

        for (int x = 0; x < w->size[0]; x++) {
            if (from->label_bytes == 1)
                ((uint8_t *)w->ids)[to + (size_t)x] =
                    ((const uint8_t *)from->ids)[at + (size_t)w->x_of[x]];
            else
                ((uint16_t *)w->ids)[to + (size_t)x] =
                    ((const uint16_t *)from->ids)[at + (size_t)w->x_of[x]];
        }
    }
}

sc_status sc_resample_nearest(const sc_ctx *ctx, sc_volume *volume, const int size[3], int threads)
{
    const size_t rows = (size_t)size[1] * (size_t)size[2];
    nearest_work w = {.from = volume, .size = {size[0], size[1], size[2]}};
    SC_OWN(sc_free_at) int *x_of = NULL;

    SC_PASS(SC_ALLOC(ctx, (size_t)size[0], &x_of));
    for (int x = 0; x < size[0]; x++)
        x_of[x] = plane_of(x, volume->size[0], size[0]);
    w.x_of = x_of;
    SC_PASS(sc_alloc(ctx, rows * (size_t)size[0], (size_t)volume->label_bytes, &w.ids));
    sc_stage_begin(ctx, "resampling", 0, rows);
    sc_stage_for(ctx, rows, threads, rows, 64, fill_rows, &w);
    sc_free(volume->ids);
    volume->ids = w.ids;
    for (int i = 0; i < 3; i++) {
        const double step = (double)volume->size[i] / size[i];

        sc_resample_set_axis(volume, i, size[i], step / 2 - 0.5, step);
    }
    return SC_OK;
}
