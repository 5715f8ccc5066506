/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours of tissues by values: the labels of a session as they are drawn. */
#include "app.h"

#include <math.h>
#include <string.h>

/* Tell how many tissues have no value. */
static void tell_missing(const sc_ctx *ctx, const sc_prepared *volume, const double *values)
{
    int missing = 0, all = 0;

    for (int id = 1; id < volume->label_count; id++) {
        if (volume->stats[id].voxels) {
            all++;
            missing += isnan(values[id]);
        }
    }
    if (missing)
        sc_info(ctx, "%d of %d tissues have no value and get the colour color_by.missing", missing,
                all);
}

sc_status sc_color_labels(const sc_ctx *ctx, sc_session *session, sc_label **out)
{
    const sc_color_by *by = &session->job.color_by;
    const sc_prepared *volume = &session->volume;
    const size_t count = (size_t)volume->label_count;
    sc_label *labels = NULL;
    char title[SC_NAME_BYTES];
    void *values = NULL, *block = NULL;
    sc_status status;

    *out = NULL;
    if (!sc_color_by_any(by))
        return SC_OK;
    SC_TRY(sc_alloc(ctx, count, sizeof(double), &values));
    SC_TRY(sc_color_values(ctx, by, volume, values, title));
    SC_TRY(sc_alloc(ctx, count, sizeof *labels, &block));
    labels = block;
    memcpy(labels, volume->labels, count * sizeof *labels);
    sc_color_scale_find(by, volume, values, title, &session->scale);
    for (size_t id = 1; id < count; id++) {
        sc_color_scale_at(&session->scale, ((double *)values)[id], labels[id].rgb);
        labels[id].has_color = true;
    }
    if (!by->has_measure) /* a check measures nothing */
        tell_missing(ctx, volume, values);
    *out = labels;
out:
    sc_free(values);
    return status;
}
