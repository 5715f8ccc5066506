/* SPDX-License-Identifier: BSD-3-Clause */
/* What can be known of a job's volume without preparing it, for checking a job on a login node. */
#include "recipe.h"

#include <limits.h>

/* Fill the volume of an input, its labels and stats from a volume without voxels. Takes ownership
 * of the labels of @p v. */
static sc_status fill(const sc_app *app, sc_volume *v, sc_input *input)
{
    const size_t count = (size_t)v->label_count;
    sc_label_stats *stats;

    SC_PASS(SC_ZALLOC(app->ctx, count, &stats));
    input->stats = stats;
    for (size_t i = 0; i < count; i++) {
        const sc_label_tally nothing = {0, {0, 0, 0}, {-1, -1, -1}};
        const sc_label_tally *tally = v->tallies ? &v->tallies[i] : &nothing;

        stats[i].voxels = tally->voxels;
        memcpy(stats[i].low, tally->low, sizeof tally->low);
        memcpy(stats[i].high, tally->high, sizeof tally->high);
    }
    SC_HAND_OVER(v->labels, &input->labels);
    input->volume = (sc_prepared){.label_count = v->label_count,
                                  .oriented = v->oriented,
                                  .to_ras_mm = v->to_ras_mm,
                                  .labels = input->labels,
                                  .stats = stats};
    memcpy(input->volume.size, v->size, sizeof v->size);
    return SC_OK;
}

/* Count the voxels of each label, and find their boxes: sets v->tallies. */
static sc_status tally(const sc_ctx *ctx, sc_volume *v)
{
    const int nx = v->size[0];

    SC_PASS(SC_ALLOC(ctx, (size_t)v->label_count, &v->tallies));
    for (int id = 0; id < v->label_count; id++)
        v->tallies[id] = (sc_label_tally){0, {INT_MAX, INT_MAX, INT_MAX}, {-1, -1, -1}};
    for (size_t row = 0; row < (size_t)v->size[1] * (size_t)v->size[2]; row++) {
        for (int x = 0, end; x < nx; x = end) {
            const uint32_t id = sc_volume_id(v, row * (size_t)nx + (size_t)x);
            const int low[3] = {x, (int)(row % (size_t)v->size[1]),
                                (int)(row / (size_t)v->size[1])};
            sc_label_tally *t = &v->tallies[id];

            for (end = x + 1; end < nx && sc_volume_id(v, row * (size_t)nx + (size_t)end) == id;
                 end++)
                ;
            t->voxels += (uint64_t)(end - x);
            for (int i = 0; i < 3; i++) {
                t->low[i] = low[i] < t->low[i] ? low[i] : t->low[i];
                t->high[i] = low[i] > t->high[i] ? low[i] : t->high[i];
            }
            t->high[0] = end - 1 > t->high[0] ? end - 1 : t->high[0];
        }
    }
    return SC_OK;
}

sc_status sc_input_look(sc_app *app, sc_job *job, sc_input *input, sc_volume *voxels)
{
    SC_OWN(sc_edited_clear) sc_edited edited = {0};
    sc_volume *v = &edited.volume;
    bool usable;

    if (sc_is_prepared_file(job->volume.path))
        return sc_input_map(app, job, input, &usable);
    SC_PASS(sc_input_read(app, job, input, NULL, &edited));
    SC_PASS(tally(app->ctx, v));
    SC_PASS(fill(app, v, input));
    input->volume.label_bytes = v->label_bytes;
    input->volume.ids = v->ids;
    *voxels = *v;
    *v = (sc_volume){0};
    return SC_OK;
}

sc_status sc_input_inspect(sc_app *app, sc_job *job, bool header_only, sc_input *input)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    bool usable;

    if (sc_is_prepared_file(job->volume.path))
        return sc_input_map(app, job, input, &usable);
    SC_PASS(sc_scan_labels(app, job, input, header_only, &volume));
    return fill(app, &volume, input);
}
