/* SPDX-License-Identifier: BSD-3-Clause */
/* What can be known of a job's volume without preparing it, for checking a job on a login node. */
#include "recipe.h"

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

sc_status sc_input_inspect(sc_app *app, sc_job *job, bool header_only, sc_input *input)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    bool usable;

    if (sc_is_prepared_file(job->volume))
        return sc_input_map(app, job, input, &usable);
    SC_PASS(sc_scan_labels(app, job, input, header_only, &volume));
    return fill(app, &volume, input);
}
