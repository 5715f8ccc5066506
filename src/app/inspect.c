/* SPDX-License-Identifier: BSD-3-Clause */
/* What can be known of a job's volume without preparing it, for checking a job on a login node. */
#include "app.h"

#include "segcast/phantom.h"

#include <stdlib.h>
#include <string.h>

/* Fill in what sc_volume_scan_labels would find in a phantom of the size in the text @p volume. */
static sc_status scan_phantom(const sc_app *app, const char *volume, sc_label_scan *out)
{
    sc_phantom *phantom = NULL;
    int size[3];
    sc_status status;

    SC_TRY(sc_phantom_size(app->ctx, "volume", volume, size));
    SC_TRY(sc_phantom_new(app->ctx, &phantom));
    status = sc_phantom_scan_labels(app->ctx, phantom, size, app->threads, out);
out:
    sc_phantom_free(phantom);
    return status;
}

/* Add a row to @p table if @p pattern is the number of a label. */
static sc_status add_number(const sc_ctx *ctx, const char *pattern, sc_label_table *table)
{
    char *end;
    const sc_label row = {.value = strtoll(pattern, &end, 10), .opacity = -1};

    if (end == pattern || *end)
        return SC_OK;
    return sc_label_table_add(ctx, table, &row);
}

/* Add rows for the labels that a job, or a shot, names by number. */
static sc_status add_numbers(const sc_ctx *ctx, const sc_job *job, sc_label_table *table)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < job->rule_count; i++)
        SC_TRY(add_number(ctx, job->rules[i].pattern, table));
    for (size_t i = 0; i < job->exception_count; i++)
        SC_TRY(add_number(ctx, job->exceptions[i].pattern, table));
    for (size_t i = 0; i < job->verb_tissue_count; i++)
        SC_TRY(add_number(ctx, job->verb_tissues[i].pattern, table));
    for (size_t i = 0; i < job->volume_tissue_count; i++)
        SC_TRY(add_number(ctx, job->volume_tissues[i].pattern, table));
out:
    return status;
}

/* Find the labels of a volume whose voxels were not read, and add them to @p scan: those of its
 * own table, those of the job's table, and those that the job names by number. Names come from the
 * tables only, so that a tissue name in the job that is in no table is reported as an error. */
static sc_status name_labels(const sc_app *app, const sc_job *job, sc_label_scan *scan)
{
    sc_volume *volume = &scan->volume;
    sc_label_table numbers = {0};
    sc_label_source source;
    sc_status status;

    SC_TRY(sc_read_labels_of(app, job, volume, &source));
    SC_TRY(sc_match_labels(app, job, &source, volume, scan));
    SC_TRY(add_numbers(app->ctx, job, &numbers));
    for (size_t i = 0; i < job->shot_count; i++)
        SC_TRY(add_numbers(app->ctx, &job->shots[i].job, &numbers));
    SC_TRY(sc_volume_add_labels(app->ctx, volume, &numbers));
    SC_TRY(sc_volume_add_labels(app->ctx, volume, &source.table));
    if (job->rule_count + job->exception_count + job->verb_tissue_count + job->shot_count > 0)
        sc_info(app->ctx,
                "%s: the voxels were not read (--fast), so that it is not known whether "
                "the tissues that the job names occur in them",
                job->volume);
    sc_label_source_keep(app, job, volume, &source);
out:
    sc_label_table_clear(&numbers);
    sc_label_source_clear(&source);
    return status;
}

/* Fill session->volume, labels and stats from a scan. Takes ownership of the labels of @p scan. */
static sc_status fill_volume(const sc_app *app, sc_label_scan *scan, sc_session *session)
{
    const size_t count = (size_t)scan->volume.label_count;
    sc_label_stats *stats;
    void *block;
    sc_status status = sc_zalloc(app->ctx, count, sizeof *stats, &block);

    if (status != SC_OK)
        return status;
    session->stats = stats = block;
    for (size_t i = 0; i < count; i++) {
        const sc_label_tally nothing = {0, {0, 0, 0}, {-1, -1, -1}};
        const sc_label_tally *tally = scan->tallies ? &scan->tallies[i] : &nothing;

        stats[i].voxels = tally->voxels;
        memcpy(stats[i].low, tally->low, sizeof tally->low);
        memcpy(stats[i].high, tally->high, sizeof tally->high);
    }
    session->labels = scan->volume.labels;
    scan->volume.labels = NULL;
    session->volume = (sc_prepared){.label_count = scan->volume.label_count,
                                    .oriented = scan->volume.oriented,
                                    .to_ras_mm = scan->volume.to_ras_mm,
                                    .labels = session->labels,
                                    .stats = stats};
    memcpy(session->volume.size, scan->volume.size, sizeof scan->volume.size);
    return SC_OK;
}

sc_status sc_session_inspect(sc_app *app, bool header_only, sc_session *session)
{
    const sc_job *job = &session->job;
    sc_input_place place;
    const sc_ctx ctx = sc_ctx_of_input(app->ctx, job->volume_where, job->volume, &place);
    sc_label_scan scan = {0};
    sc_read_choice choice;
    sc_keeping keeping;
    bool usable;
    sc_status status;

    if (sc_is_prepared_file(job->volume))
        return sc_session_map(app, session, &usable);
    SC_TRY(sc_read_choice_of(app, job, &keeping, &choice));
    if (sc_job_is_phantom(job->volume))
        SC_TRY(scan_phantom(app, job->volume, &scan));
    else if (header_only)
        SC_TRY(sc_volume_read_header_by(&ctx, job->volume, &choice, &scan));
    else
        SC_TRY(sc_volume_scan_by(&ctx, job->volume, &choice, &scan));
    if (scan.tallies)
        SC_TRY(sc_apply_labels(app, job, &scan.volume, &scan));
    else
        SC_TRY(name_labels(app, job, &scan));
    SC_TRY(sc_edit_scan(app, job, &scan));
    if (scan.tallies && scan.volume.label_count == 1)
        sc_warn(app->ctx, "%s: holds background only; there is nothing to see", job->volume);
    status = fill_volume(app, &scan, session);
out:
    sc_label_scan_clear(&scan);
    return status;
}
