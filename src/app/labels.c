/* SPDX-License-Identifier: BSD-3-Clause */
/* The label table of a job: where it is read, and how it meets the labels of the volume, by number,
 * or by name where the volume has no numbers of its own. */
#include "app.h"

#include <string.h>

/* @return whether a table has named a label of @p volume. */
static bool has_names(const sc_volume *volume)
{
    for (int id = 1; id < volume->label_count; id++) {
        if (volume->labels[id].name[0])
            return true;
    }
    return false;
}

sc_status sc_read_labels_of(const sc_app *app, const sc_job *job, const sc_volume *volume,
                            sc_label_source *out)
{
    const bool named = job->labels[0];

    *out = (sc_label_source){0};
    if (named)
        snprintf(out->path, sizeof out->path, "%s", job->labels);
    else if (!has_names(volume))
        sc_find_labels(app, job->volume, out->path);
    if (!out->path[0])
        return SC_OK;
    return sc_label_table_read(app->ctx, out->path,
                               named ? (sc_table_format)job->labels_format : SC_TABLE_AUTO,
                               &out->table);
}

void sc_label_source_clear(sc_label_source *source)
{
    sc_label_table_clear(&source->table);
    *source = (sc_label_source){0};
}

void sc_label_source_keep(const sc_app *app, sc_label_source *source)
{
    if (!app->label_source)
        return;
    sc_label_source_clear(app->label_source); /* a prepared file may be read twice */
    *app->label_source = *source;
    *source = (sc_label_source){0};
}

/* ---- by name ---- */

/* Warn that the numbers of a table are all there is to go by. */
static void warn_of_numbers(const sc_app *app, const sc_job *job, const sc_label_source *source,
                            const sc_volume *volume)
{
    sc_warn(app->ctx,
            "%s: names none of the tissues of %s, which have no numbers but those that segcast has "
            "given them, such as %lld to \"%s\"; the table is used by these numbers: is that what "
            "is meant? Else write the names of the tissues into the table",
            source->path, job->volume, (long long)volume->labels[1].value, volume->labels[1].name);
}

/* Give the labels of a volume the numbers of the rows that name them. @param label_of of
 * sc_label_table_match; set to the dense ids that they have then. */
static sc_status renumber(const sc_app *app, const sc_label_source *source, int *label_of,
                          sc_volume *volume, sc_label_scan *scan)
{
    sc_relabel relabel = {0};
    sc_status status;

    SC_TRY(sc_relabel_by_table(app->ctx, volume->labels, volume->label_count, &source->table,
                               label_of, &relabel));
    if (scan)
        SC_TRY(sc_label_scan_relabel(app->ctx, scan, &relabel));
    else
        sc_volume_relabel(volume, &relabel, app->threads);
    for (size_t i = 0; i < source->table.count; i++)
        label_of[i] = relabel.to[label_of[i]];
    volume->numbered = false;
out:
    sc_relabel_clear(&relabel);
    return status;
}

/* Tell how many rows name tissues, and which tissues have no row. @param label_of of
 * sc_label_table_match. */
static sc_status tell_match(const sc_app *app, const sc_job *job, const sc_label_source *source,
                            const sc_volume *volume, const int *label_of, size_t found)
{
    sc_text names = {0};
    size_t without = 0;
    void *block = NULL;
    bool *has_row;
    sc_status status;

    SC_TRY(sc_zalloc(app->ctx, (size_t)volume->label_count, sizeof *has_row, &block));
    has_row = block;
    for (size_t i = 0; i < source->table.count; i++)
        has_row[label_of[i]] = true;
    for (int id = 1; id < volume->label_count; id++) {
        if (!has_row[id])
            SC_TRY(sc_label_list_add(app->ctx, &names, without++, &volume->labels[id]));
    }
    sc_info(app->ctx, "%s: %zu of its %zu rows have the names of tissues of %s%s%s%s", source->path,
            found, source->table.count, job->volume, volume->numbered ? "" : ", whose labels get their numbers",
            without ? "; it has no row for " : "", without ? names.data : "");
out:
    sc_text_clear(&names);
    sc_free(block);
    return status;
}

sc_status sc_match_labels(const sc_app *app, const sc_job *job, sc_label_source *source,
                          sc_volume *volume, sc_label_scan *scan)
{
    const size_t rows = source->table.count;
    void *label_of = NULL;
    size_t found;
    sc_status status;

    if (!volume->numbered || rows == 0 || volume->label_count == 1)
        return SC_OK;
    SC_TRY(sc_alloc(app->ctx, rows, sizeof(int), &label_of));
    SC_TRY(sc_label_table_match(app->ctx, volume->labels, volume->label_count, &source->table,
                                label_of, &found));
    if (found == 0) {
        warn_of_numbers(app, job, source, volume);
        goto out;
    }
    if (volume->ids || scan)
        SC_TRY(renumber(app, source, label_of, volume, scan));
    SC_TRY(tell_match(app, job, source, volume, label_of, found));
    if (volume->numbered)
        sc_label_table_number(volume->labels, label_of, &source->table);
out:
    sc_free(label_of);
    return status;
}

sc_status sc_apply_labels(const sc_app *app, const sc_job *job, sc_volume *volume,
                          sc_label_scan *scan)
{
    sc_label_source source;
    sc_status status;

    SC_TRY(sc_read_labels_of(app, job, volume, &source));
    SC_TRY(sc_match_labels(app, job, &source, volume, scan));
    sc_volume_apply_table(volume, &source.table);
    sc_label_source_keep(app, &source);
out:
    sc_label_source_clear(&source);
    return status;
}
