/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours of tissues by values: the labels of a panel as they are drawn. */
#include "panels.h"

#include <math.h>

/* Tell how many tissues lack a value, in any of the columns. */
static void tell_missing(const sc_ctx *ctx, const sc_prepared *volume, const double *values,
                         int columns)
{
    int missing = 0, all = 0;

    for (int id = 1; id < volume->label_count; id++) {
        bool lacks = false;

        for (int c = 0; c < columns; c++)
            lacks = lacks || isnan(values[c * volume->label_count + id]);
        if (volume->stats[id].voxels) {
            all++;
            missing += lacks;
        }
    }
    if (missing)
        sc_info(ctx, "%d of %d tissues have no value%s and get the colour color_by.missing",
                missing, all, columns > 1 ? " in one of the columns" : "");
}

/* Find the values of all labels in one key frame after the other. @param values
 * [columns][label_count]. @param title where to write what the values are. */
static sc_status find_values(const sc_ctx *ctx, const sc_job *job, const sc_prepared *volume,
                             double *values, char title[SC_NAME_BYTES])
{
    const int columns = job->color_columns.steps.count;
    sc_color_by by = job->color_by;
    sc_ctx again = *ctx; /* the rows of all columns are the same, and warnings tell of rows */
    char last[SC_NAME_BYTES];

    if (!columns)
        return sc_color_values(ctx, &by, volume, values, title);
    again.level = again.level < SC_LOG_ERROR ? again.level : SC_LOG_ERROR;
    for (int c = 0; c < columns; c++) {
        memcpy(by.column, job->color_columns.columns[c], sizeof by.column);
        SC_PASS(sc_color_values(c ? &again : ctx, &by, volume, values + c * volume->label_count,
                                c ? last : title));
    }
    if (columns > 1 && strcmp(title, last) != 0)
        snprintf(title + strlen(title), SC_NAME_BYTES - strlen(title), " to %s", last);
    return SC_OK;
}

sc_status sc_color_labels(const sc_ctx *ctx, sc_panel *panel, sc_label **out)
{
    const sc_job *job = &panel->job;
    const sc_prepared *volume = &panel->volume;
    const size_t count = (size_t)volume->label_count;
    const int key_frames = job->color_columns.steps.count, columns = key_frames ? key_frames : 1;
    sc_label *labels;
    char title[SC_NAME_BYTES];
    SC_OWN(sc_free_at) double *values = NULL;

    *out = NULL;
    if (!sc_color_by_any(&job->color_by))
        return SC_OK;
    SC_PASS(SC_ALLOC(ctx, count * (size_t)columns, &values));
    SC_PASS(find_values(ctx, job, volume, values, title));
    SC_PASS(SC_ALLOC(ctx, count, &labels));
    memcpy(labels, volume->labels, count * sizeof *labels);
    sc_color_scale_find(&job->color_by, volume, values, columns, title, &panel->looks.scale);
    for (size_t id = 1; id < count; id++) {
        sc_color_scale_at(&panel->looks.scale, values[id], labels[id].rgb);
        labels[id].has_color = true;
    }
    if (!job->color_by.has_measure) /* a check measures nothing */
        tell_missing(ctx, volume, values, columns);
    if (key_frames)
        SC_HAND_OVER(values, &panel->looks.column_values);
    *out = labels;
    return SC_OK;
}

sc_status sc_share_column_values(sc_app *app, sc_panel *panel)
{
    const size_t count = (size_t)panel->job.color_columns.steps.count;

    if (!count)
        return SC_OK;
    if (sc_comm_rank(app->comm) == 0) {
        for (int level = 0; level < 256; level++)
            panel->looks.level_linear[level] = (float)sc_srgb_to_linear(level / 255.0);
    }
    sc_comm_broadcast(app->comm, panel->looks.level_linear, sizeof panel->looks.level_linear);
    return SC_BROADCAST(app, count * (size_t)panel->volume.label_count,
                        &panel->looks.column_values);
}
