/* SPDX-License-Identifier: BSD-3-Clause */
/* A volume with other planes along one axis. */
#include "internal.h"

void sc_resample_set_axis(sc_volume *v, int axis, int count, double first, double step)
{
    const sc_vec3 column = sc_affine_column(&v->to_ras_mm, axis);
    const double along[3] = {column.x, column.y, column.z};

    v->size[axis] = count;
    for (int i = 0; i < 3; i++) {
        v->to_ras_mm.m[i][3] += first * along[i];
        v->to_ras_mm.m[i][axis] = step * along[i];
    }
}

void sc_resample_set_planes(sc_volume *v, void *ids, int axis, int count, double first, double step)
{
    sc_free(v->ids);
    v->ids = ids;
    sc_resample_set_axis(v, axis, count, first, step);
}
