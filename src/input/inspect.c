/* SPDX-License-Identifier: BSD-3-Clause */
/* What can be known of a job's volume without preparing it, for checking a job on a login node. */
#include "recipe.h"

#include <string.h>

/* Fill the volume of an input, its labels and stats from a scan. Takes ownership of the labels of
 * @p scan. */
static sc_status fill(const sc_app *app, sc_label_scan *scan, sc_input *input)
{
    const size_t count = (size_t)scan->volume.label_count;
    sc_label_stats *stats;

    SC_PASS(SC_ZALLOC(app->ctx, count, &stats));
    input->stats = stats;
    for (size_t i = 0; i < count; i++) {
        const sc_label_tally nothing = {0, {0, 0, 0}, {-1, -1, -1}};
        const sc_label_tally *tally = scan->tallies ? &scan->tallies[i] : &nothing;

        stats[i].voxels = tally->voxels;
        memcpy(stats[i].low, tally->low, sizeof tally->low);
        memcpy(stats[i].high, tally->high, sizeof tally->high);
    }
    input->labels = scan->volume.labels;
    scan->volume.labels = NULL;
    input->volume = (sc_prepared){.label_count = scan->volume.label_count,
                                  .oriented = scan->volume.oriented,
                                  .to_ras_mm = scan->volume.to_ras_mm,
                                  .labels = input->labels,
                                  .stats = stats};
    memcpy(input->volume.size, scan->volume.size, sizeof scan->volume.size);
    return SC_OK;
}

sc_status sc_input_inspect(sc_app *app, sc_job *job, bool header_only, sc_input *input)
{
    SC_OWN(sc_label_scan_clear) sc_label_scan scan = {0};
    bool usable;

    if (sc_is_prepared_file(job->volume))
        return sc_input_map(app, job, input, &usable);
    SC_PASS(sc_scan_labels(app, job, input, header_only, &scan));
    return fill(app, &scan, input);
}
