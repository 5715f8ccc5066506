/* SPDX-License-Identifier: BSD-3-Clause */
/* The label table of a job: where it is read, and how it meets the labels of the volume, by number,
 * or by name where the volume has no numbers of its own. */
#include "recipe.h"

#include <stdlib.h>

/* @return whether a table has named a label of @p volume. */
static bool has_names(const sc_volume *volume)
{
    for (int id = 1; id < volume->label_count; id++) {
        if (volume->labels[id].name[0])
            return true;
    }
    return false;
}

sc_status sc_read_label_table(const sc_app *app, const char *path, sc_table_format format,
                              const sc_volume *volume, sc_label_table *out)
{
    const sc_read_choice header = {.phase = 1, .depth = SC_READ_HEADER};
    SC_OWN(sc_volume_clear) sc_volume other = {0};

    if (!sc_input_is_volume(path))
        return sc_label_table_read(app->ctx, path, format, out);
    SC_PASS(sc_volume_read_by(app->ctx, path, &header, &other));
    for (int id = 1; id < other.label_count; id++)
        SC_PASS(sc_label_table_add(app->ctx, out, &other.labels[id]));
    if (out->count == 0)
        return sc_fail(app->ctx, SC_ERR_DATA,
                       "%s: has no label table in its header; give a label table instead", path);
    if (other.numbered && volume && !volume->numbered)
        return sc_fail(app->ctx, SC_ERR_DATA,
                       "%s: names its tissues without numbers, so that it is not known which "
                       "labels of another volume they are; give a label table instead",
                       path);
    return SC_OK;
}

/* Read the label table of the job, if it names one, or else, if @p volume has no names, that of
 * sc_find_labels. Caller owns *out, which may be empty: sc_label_source_clear. */
static sc_status read_labels_of(const sc_app *app, const sc_job *job, const sc_volume *volume,
                                sc_label_source *out)
{
    const bool named = job->volume.labels[0];

    if (named)
        snprintf(out->path, sizeof out->path, "%s", job->volume.labels);
    else if (!has_names(volume))
        sc_find_labels(app, job->volume.path, out->path);
    if (!named && !out->path[0] && !has_names(volume))
        sc_hint_labels(app, job->volume.path, volume);
    if (!out->path[0])
        return SC_OK;
    return sc_read_label_table(app, out->path,
                               named ? (sc_table_format)job->volume.labels_format : SC_TABLE_AUTO,
                               volume, &out->table);
}

void sc_label_source_clear(sc_label_source *source)
{
    sc_label_table_clear(&source->table);
    *source = (sc_label_source){0};
}

/* Move @p source, or if it is empty the table of the file of @p volume, to app->label_source,
 * instead of what is there, if that is wanted. */
static void keep_source(const sc_app *app, const sc_job *job, sc_volume *volume,
                        sc_label_source *source)
{
    if (!app->label_source)
        return;
    if (!source->path[0] && volume->table.count) { /* the volume has a table of its own */
        snprintf(source->path, sizeof source->path, "%s", job->volume.path);
        source->table = volume->table;
        volume->table = (sc_label_table){0};
    }
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
            source->path, job->volume.path, (long long)volume->labels[1].value,
            volume->labels[1].name);
}

/* Give the labels of a volume the numbers of the rows that name them. @param label_of of
 * sc_label_table_match; set to the dense ids that they have then. */
static sc_status renumber(const sc_app *app, const sc_label_source *source, int *label_of,
                          sc_volume *volume)
{
    SC_OWN(sc_relabel_clear) sc_relabel relabel = {0};

    SC_PASS(sc_relabel_by_table(app->ctx, volume->labels, volume->label_count, &source->table,
                                label_of, &relabel));
    SC_PASS(sc_volume_relabel(app->ctx, volume, &relabel, app->threads));
    for (size_t i = 0; i < source->table.count; i++)
        label_of[i] = relabel.to[label_of[i]];
    volume->numbered = false;
    return SC_OK;
}

/* Tell how many rows name tissues, and which tissues have no row. @param label_of of
 * sc_label_table_match. */
static sc_status tell_match(const sc_app *app, const sc_job *job, const sc_label_source *source,
                            const sc_volume *volume, const int *label_of, size_t found)
{
    SC_OWN(sc_text_clear) sc_text names = {0};
    size_t without = 0;
    SC_OWN(sc_free_at) bool *has_row = NULL;

    SC_PASS(SC_ZALLOC(app->ctx, (size_t)volume->label_count, &has_row));
    for (size_t i = 0; i < source->table.count; i++)
        has_row[label_of[i]] = true;
    for (int id = 1; id < volume->label_count; id++) {
        if (!has_row[id])
            SC_PASS(sc_label_list_add(app->ctx, &names, without++, &volume->labels[id]));
    }
    sc_info(app->ctx, "%s: %zu of its %zu rows have the names of tissues of %s%s%s%s", source->path,
            found, source->table.count, job->volume.path,
            volume->numbered ? "" : ", whose labels get their numbers",
            without ? "; it has no row for " : "", without ? names.data : "");
    return SC_OK;
}

/* Bring a table and the labels of a volume that has no numbers of its own (sc_volume.numbered)
 * together by their names: the labels get the numbers of their rows. Those of a mapped file stay as
 * they are, and the rows get theirs. If no name fits, nothing changes, with a warning. */
static sc_status match_labels(const sc_recipe *r, sc_label_source *source, sc_volume *volume)
{
    const sc_app *app = r->app;
    const size_t rows = source->table.count;
    SC_OWN(sc_free_at) void *label_of = NULL;
    size_t found;

    if (!volume->numbered || rows == 0 || volume->label_count == 1)
        return SC_OK;
    SC_PASS(sc_alloc(app->ctx, rows, sizeof(int), &label_of));
    SC_PASS(sc_label_table_match(app->ctx, volume->labels, volume->label_count, &source->table,
                                 label_of, &found));
    if (found == 0) {
        warn_of_numbers(app, r->job, source, volume);
        return SC_OK;
    }
    if (!r->is_fixed)
        SC_PASS(renumber(app, source, label_of, volume));
    SC_PASS(tell_match(app, r->job, source, volume, label_of, found));
    if (volume->numbered)
        sc_label_table_number(volume->labels, label_of, &source->table);
    return SC_OK;
}

/* ---- tissues without voxels ---- */

sc_status sc_each_pattern(const sc_job *job, sc_pattern_fn *visit, void *user)
{
    const sc_tissue_options *t = &job->tissues;
    const sc_verb_options *v = &job->verbs;
    const sc_overlay_lists *l = &job->overlay_lists;
    const sc_optics *o = &job->animation.camera.optics;
    sc_status status = SC_OK;

    for (size_t i = 0; i < t->rule_count; i++)
        (void)sc_goes_on(&status, visit(user, t->rules[i].pattern, t->rules[i].where));
    if (o->focus == SC_FOCUS_TISSUE)
        (void)sc_goes_on(&status, visit(user, o->pattern, o->where));
    for (size_t i = 0; i < t->exception_count; i++)
        (void)sc_goes_on(&status, visit(user, t->exceptions[i].pattern, t->exceptions[i].where));
    for (size_t i = 0; i < v->tissue_count; i++)
        (void)sc_goes_on(&status, visit(user, v->tissues[i].pattern, v->tissues[i].where));
    for (size_t i = 0; i < l->tissue_count; i++)
        (void)sc_goes_on(&status, visit(user, l->tissues[i].pattern, l->tissues[i].where));
    for (size_t i = 0; i < job->film.shot_count; i++)
        (void)sc_goes_on(&status, sc_each_pattern(&job->film.shots[i].job, visit, user));
    return status;
}

/* Which labels of a catalog a job names, though they are not those of the volume. */
typedef struct search {
    const sc_job *job;
    const sc_volume *volume;
    const sc_volume *catalog; /* all tissues that tables name */
    bool *named;              /* [labels of the catalog] */
} search;

/* An sc_pattern_fn; @p user is a search. A pattern that means tissues with voxels means only these,
 * and one that is the name of a merged tissue means that. */
static sc_status search_pattern(void *user, const char *text, const char *where)
{
    const search *s = user;
    const sc_pattern pattern = sc_pattern_of(text);
    const sc_volume *c = s->catalog;
    const sc_match best = sc_pattern_match(c->labels, c->label_count, &pattern);

    if (pattern.is_all || best == SC_MATCH_NONE ||
        sc_pattern_match(s->volume->labels, s->volume->label_count, &pattern) != SC_MATCH_NONE)
        return SC_OK;
    for (size_t i = 0; i < s->job->volume.tissue_count; i++) {
        sc_label merged = {0};

        snprintf(merged.name, sizeof merged.name, "%s", s->job->volume.tissues[i].into);
        if (sc_label_match(&merged, &pattern) != SC_MATCH_NONE)
            return SC_OK;
    }
    for (int id = 1; id < c->label_count; id++)
        s->named[id] = s->named[id] || sc_label_match(&c->labels[id], &pattern) == best;
    return SC_OK;
}

/* List the tissues that a table of the volume or of the job names, and that are not among the
 * labels of the volume, but named by the job. Caller owns *out: sc_label_table_clear. */
static sc_status find_absent(const sc_app *app, const sc_job *job, const sc_label_source *source,
                             const sc_volume *volume, sc_label_table *out)
{
    SC_OWN(sc_volume_clear) sc_volume catalog = {.label_count = 1};
    search s = {.job = job, .volume = volume, .catalog = &catalog};
    SC_OWN(sc_free_at) bool *named = NULL;

    SC_PASS(SC_ZALLOC(app->ctx, 1, &catalog.labels));
    SC_PASS(sc_volume_add_labels(app->ctx, &catalog, &volume->outside));
    SC_PASS(sc_volume_add_labels(app->ctx, &catalog, &volume->absent));
    SC_PASS(sc_volume_add_labels(app->ctx, &catalog, &source->table));
    SC_PASS(SC_ZALLOC(app->ctx, (size_t)catalog.label_count, &named));
    s.named = named;
    for (size_t i = 0; i < job->volume.tissue_count; i++)
        SC_PASS(search_pattern(&s, job->volume.tissues[i].pattern, ""));
    SC_PASS(sc_each_pattern(job, search_pattern, &s));
    for (int id = 1; id < catalog.label_count; id++) {
        if (s.named[id] && !sc_volume_label(volume, catalog.labels[id].value))
            SC_PASS(sc_label_table_add(app->ctx, out, &catalog.labels[id]));
    }
    return SC_OK;
}

/* Warn of tissues that the job names and of which there is nothing to see. */
static sc_status warn_of_absent(const sc_app *app, const sc_job *job, const sc_label_table *absent)
{
    SC_OWN(sc_text_clear) sc_text names = {0};

    for (size_t i = 0; i < absent->count; i++)
        SC_PASS(sc_label_list_add(app->ctx, &names, i, &absent->rows[i]));
    if (absent->count)
        sc_warn(app->ctx, "%s: has no voxels of %zu tissue%s that the job names: %s",
                job->volume.path, absent->count, absent->count == 1 ? "" : "s", names.data);
    return SC_OK;
}

/* Warn of tissues that lie outside of the box of the volume that was read. @param source whose
 * numbers are those of the volume. */
static sc_status warn_of_outside(const sc_app *app, const sc_job *job,
                                 const sc_label_source *source, const sc_volume *volume)
{
    SC_OWN(sc_volume_clear) sc_volume catalog = {.label_count = 1};
    SC_OWN(sc_text_clear) sc_text names = {0};

    SC_PASS(SC_ZALLOC(app->ctx, 1, &catalog.labels));
    SC_PASS(sc_volume_add_labels(app->ctx, &catalog, &volume->outside));
    sc_volume_apply_table(&catalog, &volume->absent);
    sc_volume_apply_table(&catalog, &source->table);
    for (int id = 1; id < catalog.label_count; id++)
        SC_PASS(sc_label_list_add(app->ctx, &names, (size_t)id - 1, &catalog.labels[id]));
    if (catalog.label_count > 1)
        sc_warn(app->ctx, "%s: the box leaves nothing of %d tissue%s: %s", job->volume.path,
                catalog.label_count - 1, catalog.label_count == 2 ? "" : "s", names.data);
    return SC_OK;
}

/* Tell which tissues with a name a box of a volume in chunks has none of. Whether they are
 * elsewhere is not known, as the other chunks are not read. @param source whose numbers are those
 * of the volume. */
static sc_status tell_unread(const sc_app *app, const sc_job *job, const sc_label_source *source,
                             const sc_volume *volume)
{
    const sc_label_table *tables[] = {&source->table, &volume->absent};
    SC_OWN(sc_label_table_clear) sc_label_table unread = {0};
    SC_OWN(sc_volume_clear) sc_volume catalog = {.label_count = 1};
    SC_OWN(sc_text_clear) sc_text names = {0};

    SC_PASS(SC_ZALLOC(app->ctx, 1, &catalog.labels));
    for (size_t k = 0; k < SC_COUNT_OF(tables); k++) {
        for (size_t i = 0; i < tables[k]->count; i++) {
            const sc_label *row = &tables[k]->rows[i];

            if (row->name[0] && row->value && !sc_volume_label(volume, row->value))
                SC_PASS(sc_label_table_add(app->ctx, &unread, row));
        }
    }
    SC_PASS(sc_volume_add_labels(app->ctx, &catalog, &unread));
    sc_volume_apply_table(&catalog, &unread);
    for (int id = 1; id < catalog.label_count; id++)
        SC_PASS(sc_label_list_add(app->ctx, &names, (size_t)id - 1, &catalog.labels[id]));
    if (catalog.label_count > 1)
        sc_info(app->ctx,
                "%s: the box has no voxel of %d tissue%s with a name: %s; other chunks are not "
                "read, so that it is not known which of them the volume has",
                job->volume.path, catalog.label_count - 1, catalog.label_count == 2 ? "" : "s",
                names.data);
    return SC_OK;
}

/* Give a volume labels without voxels. */
static sc_status add_labels(const sc_app *app, const sc_label_table *more, sc_volume *volume)
{
    SC_OWN(sc_relabel_clear) sc_relabel relabel = {0};

    if (!more->count)
        return SC_OK;
    SC_PASS(sc_relabel_with(app->ctx, volume->labels, volume->label_count, more, &relabel));
    return sc_volume_relabel(app->ctx, volume, &relabel, app->threads);
}

/* Let a volume that has no numbers of its own meet the table by names, those of its tissues
 * included that have no voxels; without a table, it gets those of them only that the job names.
 * @param absent gets these. */
static sc_status meet_by_name(const sc_recipe *r, sc_label_source *source, sc_volume *volume,
                              sc_label_table *absent)
{
    const sc_label_source nothing = {0};

    SC_PASS(find_absent(r->app, r->job, &nothing, volume, absent));
    SC_PASS(add_labels(r->app, source->table.count ? &volume->absent : absent, volume));
    sc_label_table_clear(&volume->absent);
    return match_labels(r, source, volume);
}

/* Name the labels of a volume whose voxels are known, of the table @p source. */
static sc_status name_known(const sc_recipe *r, sc_volume *volume, sc_label_source *source)
{
    const sc_app *app = r->app;
    const sc_job *job = r->job;
    const sc_label_source nothing = {0};
    SC_OWN(sc_label_table_clear) sc_label_table absent = {0}, more = {0};

    SC_PASS(warn_of_outside(app, job, volume->numbered ? &nothing : source, volume));
    if (volume->is_part)
        SC_PASS(tell_unread(app, job, volume->numbered ? &nothing : source, volume));
    if (volume->numbered && !r->is_fixed)
        SC_PASS(meet_by_name(r, source, volume, &absent));
    else
        SC_PASS(match_labels(r, source, volume));
    if (!r->is_fixed)
        SC_PASS(find_absent(app, job, source, volume, &more));
    SC_PASS(add_labels(app, &more, volume));
    for (size_t i = 0; i < more.count; i++)
        SC_PASS(sc_label_table_add(app->ctx, &absent, &more.rows[i]));
    SC_PASS(warn_of_absent(app, job, &absent));
    sc_volume_apply_table(volume, &source->table);
    return SC_OK;
}

/* ---- of a header ---- */

/* The rows of labels that a job names by number. */
typedef struct numbers {
    const sc_ctx *ctx;
    sc_label_table *rows;
    bool any; /* it names some tissues, by number or by name */
} numbers;

/* An sc_pattern_fn; @p user is numbers. */
static sc_status add_number(void *user, const char *pattern, const char *where)
{
    numbers *n = user;
    char *end;
    const sc_label row = {.value = strtoll(pattern, &end, 10), .opacity = -1};

    n->any = true;
    return end == pattern || *end ? SC_OK : sc_label_table_add(n->ctx, n->rows, &row);
}

/* Find the labels of a volume whose voxels were not read, and add them to @p volume: those of its
 * own table, those of the job's table, and those that the job names by number. Names come from the
 * tables only, so that a tissue name in the job that is in no table is reported as an error. */
static sc_status name_unknown(const sc_recipe *r, sc_volume *volume, sc_label_source *source)
{
    const sc_app *app = r->app;
    const sc_job *job = r->job;
    SC_OWN(sc_label_table_clear) sc_label_table rows = {0};
    numbers n = {app->ctx, &rows, false};

    SC_PASS(match_labels(r, source, volume));
    for (size_t i = 0; i < job->volume.tissue_count; i++)
        SC_PASS(add_number(&n, job->volume.tissues[i].pattern, ""));
    SC_PASS(sc_each_pattern(job, add_number, &n));
    SC_PASS(sc_volume_add_labels(app->ctx, volume, &rows));
    SC_PASS(sc_volume_add_labels(app->ctx, volume, &source->table));
    if (n.any)
        sc_info(app->ctx,
                "%s: the voxels were not read (--fast), so that it is not known whether "
                "the tissues that the job names occur in them",
                job->volume.path);
    return SC_OK;
}

sc_status sc_name_labels(sc_recipe *r)
{
    sc_volume *volume = r->volume;
    SC_OWN(sc_label_source_clear) sc_label_source source = {0};

    SC_PASS(read_labels_of(r->app, r->job, volume, &source));
    SC_PASS((volume->ids || volume->tallies ? name_known : name_unknown)(r, volume, &source));
    keep_source(r->app, r->job, volume, &source);
    return SC_OK;
}
