/* SPDX-License-Identifier: BSD-3-Clause */
/* A volume without its copied voxels, while these are still there. */
#include "internal.h"

sc_status sc_drawn_view_make(const sc_ctx *ctx, const sc_volume *v, const sc_drawn_grid *grid,
                             drawn_view *out)
{
    size_t stride = 1;

    out->v = v;
    for (int axis = 0; axis < 3; axis++) {
        const int count =
            sc_resample_drawn_within(v->size[axis], grid->copies[axis], grid->phase[axis]);

        SC_PASS(SC_ALLOC(ctx, (size_t)count, &out->offset[axis]));
        out->size[axis] = count;
        for (int n = 0; n < count; n++)
            out->offset[axis][n] =
                stride * (size_t)sc_resample_plane_of(v->size[axis], grid->copies[axis],
                                                      grid->phase[axis], n);
        stride *= (size_t)v->size[axis];
    }
    return SC_OK;
}

void sc_drawn_view_clear(drawn_view *view)
{
    for (int i = 0; i < 3; i++)
        sc_free(view->offset[i]);
    *view = (drawn_view){0};
}
