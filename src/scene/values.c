/* SPDX-License-Identifier: BSD-3-Clause */
/* The value of each tissue: from a table, whose rows are brought together with the labels by number
 * or name, or of what was measured. */
#include "segcast/color_by.h"
#include "segcast/value_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- labels by name ---- */

/* A label that has a name. */
typedef struct named {
    char words[SC_NAME_BYTES]; /* as names are compared */
    const char *name;          /* as it is written; borrowed */
    int id;
} named;

static int compare_words(const void *a, const void *b)
{
    return strcmp(((const named *)a)->words, ((const named *)b)->words);
}

static int compare_names(const void *a, const void *b)
{
    const int order = compare_words(a, b);

    return order ? order : strcmp(((const named *)a)->name, ((const named *)b)->name);
}

/* The rows of a table on their way to the labels. */
typedef struct assignment {
    const sc_ctx *ctx;
    const char *path;
    const sc_prepared *volume;
    named *names; /* [name_count], sorted by compare_names */
    size_t name_count;
    int *lines; /* [label_count]: of the row that a label got its value from; 0: none */
    double *values;
    size_t used, unknown; /* rows that belong to labels, and those that do not */
    const sc_value_row *first_unknown;
    size_t other_names; /* rows whose label, by number, has another name in the volume */
    const sc_value_row *first_other;
    int first_other_id;
} assignment;

/* List the labels that have names. */
static sc_status list_names(assignment *a)
{
    SC_PASS(SC_ALLOC(a->ctx, (size_t)a->volume->label_count, &a->names));
    for (int id = 1; id < a->volume->label_count; id++) {
        if (a->volume->labels[id].name[0]) {
            named *to = &a->names[a->name_count++];

            to->id = id;
            to->name = a->volume->labels[id].name;
            sc_words_of_name(to->name, to->words);
        }
    }
    if (a->name_count)
        qsort(a->names, a->name_count, sizeof *a->names, compare_names);
    return SC_OK;
}

/* @return the dense id of a label's number; 0 if the volume has none. */
static int find_number(const sc_prepared *volume, int64_t number)
{
    int low = 1, high = volume->label_count;

    while (low < high) {
        const int middle = low + (high - low) / 2;

        if (volume->labels[middle].value < number)
            low = middle + 1;
        else
            high = middle;
    }
    return low < volume->label_count && volume->labels[low].value == number ? low : 0;
}

/* Find the labels that compare equal to @p wanted: names[*first] and those behind it. @return how
 * many there are. */
static size_t find_range(const assignment *a, const named *wanted,
                         int (*compare)(const void *, const void *), size_t *first)
{
    const named *found =
        a->name_count ? bsearch(wanted, a->names, a->name_count, sizeof *a->names, compare) : NULL;
    size_t begin, end;

    if (!found)
        return 0;
    begin = (size_t)(found - a->names);
    for (end = begin + 1; end < a->name_count && !compare(wanted, &a->names[end]);)
        end++;
    while (begin > 0 && !compare(wanted, &a->names[begin - 1]))
        begin--;
    *first = begin;
    return end - begin;
}

/* Find the labels of a name: those that are written so, or else those with its words. @return as
 * find_range. */
static size_t find_name(const assignment *a, const char *name, size_t *first)
{
    named wanted = {.name = name};
    size_t count;

    sc_words_of_name(name, wanted.words);
    count = find_range(a, &wanted, compare_names, first);
    return count ? count : find_range(a, &wanted, compare_words, first);
}

/* Give a label the value of a row. */
static sc_status assign(assignment *a, const sc_value_row *row, int id)
{
    const sc_label *label = &a->volume->labels[id];

    if (a->lines[id])
        return sc_fail(a->ctx, SC_ERR_DATA,
                       "%s:%d: is a second row of \"%s\" (label %lld), which line %d has already; "
                       "expected one row for each tissue",
                       a->path, row->line, label->name, (long long)label->value, a->lines[id]);
    a->lines[id] = row->line;
    a->values[id] = row->value;
    return SC_OK;
}

/* Note a row if the label of its number has another name in the volume: most likely the column of
 * numbers counts rows. */
static void compare_name(assignment *a, const sc_value_row *row, int id)
{
    char one[SC_NAME_BYTES], other[SC_NAME_BYTES];

    sc_words_of_name(row->name, one);
    sc_words_of_name(a->volume->labels[id].name, other);
    if (one[0] && other[0] && strcmp(one, other) != 0 && !a->other_names++) {
        a->first_other = row;
        a->first_other_id = id;
    }
}

/* Give the value of a row to its labels. */
static sc_status assign_row(assignment *a, const sc_value_row *row)
{
    const int numbered = row->has_number ? find_number(a->volume, row->number) : 0;
    size_t first = 0, count = 0;

    if (row->has_number && row->number == 0)
        return SC_OK; /* background */
    if (numbered) {
        a->used++;
        compare_name(a, row, numbered);
        return assign(a, row, numbered);
    }
    if (!row->has_number)
        count = find_name(a, row->name, &first);
    for (size_t i = first; i < first + count; i++)
        SC_PASS(assign(a, row, a->names[i].id));
    a->used += count > 0;
    if (!count && !a->unknown++)
        a->first_unknown = row;
    return SC_OK;
}

/* Tell of the rows whose labels have other names in the volume. */
static void tell_other_names(const assignment *a)
{
    const sc_label *label = &a->volume->labels[a->first_other_id];

    if (a->other_names)
        sc_warn(
            a->ctx,
            "%s:%d: label %lld is \"%.*s\" in the table, but \"%s\" in the volume, and so for %zu "
            "row%s; the values go by the numbers: if these only count rows, remove their column",
            a->path, a->first_other->line, (long long)label->value, SC_NAME_BYTES,
            a->first_other->name, label->name, a->other_names, a->other_names == 1 ? "" : "s");
}

/* Find the label's name that is nearest to that of a row. @param out it, borrowed from the volume;
 * NULL if none is near. */
static sc_status find_nearest_name(const assignment *a, const sc_value_row *row, const char **out)
{
    const sc_prepared *volume = a->volume;
    char name[SC_NAME_BYTES + 1];
    SC_OWN(sc_free_at) const char **names = NULL;

    SC_PASS(SC_ZALLOC(a->ctx, (size_t)volume->label_count, &names));
    for (int id = 1; id < volume->label_count; id++)
        names[id] = volume->labels[id].name[0] ? volume->labels[id].name : NULL;
    snprintf(name, sizeof name, "%.*s", SC_NAME_BYTES, row->name);
    *out = sc_nearest_word(name, names, (size_t)volume->label_count);
    return SC_OK;
}

/* Tell of the rows that belong to no label. */
static sc_status tell_unknown(const assignment *a)
{
    const sc_value_row *row = a->first_unknown;
    const char *nearest = NULL;
    char what[SC_NAME_BYTES + 32];

    if (!row)
        return SC_OK;
    if (!row->has_number)
        SC_PASS(find_nearest_name(a, row, &nearest));
    if (row->has_number)
        snprintf(what, sizeof what, "label %lld", (long long)row->number);
    else
        snprintf(what, sizeof what, "\"%.*s\"", SC_NAME_BYTES, row->name);
    if (!a->used)
        return sc_fail(a->ctx, SC_ERR_DATA,
                       "%s:%d: %s is no label of the volume, nor is any other row of the table; "
                       "expected the numbers or names that `segcast info` lists%s%s%s",
                       a->path, row->line, what, nearest ? "; did you mean \"" : "",
                       nearest ? nearest : "", nearest ? "\"?" : "");
    sc_warn(a->ctx, "%s:%d: %s is no label of the volume%s%s%s %zu such row%s not used", a->path,
            row->line, what, nearest ? "; did you mean \"" : "", nearest ? nearest : "",
            nearest ? "\"?" : ";", a->unknown, a->unknown == 1 ? " is" : "s are");
    return SC_OK;
}

/* Read the table and give its values to the labels. */
static sc_status read_values(const sc_ctx *ctx, const sc_color_by *by, const sc_prepared *volume,
                             double *values, char title[SC_NAME_BYTES])
{
    assignment a = {.ctx = ctx, .path = by->table, .volume = volume, .values = values};
    SC_OWN(sc_value_table_clear) sc_value_table table = {0};
    SC_OWN(sc_free_at) void *lines = NULL;
    sc_status status;

    SC_TRY(sc_value_table_read(ctx, by->table, by->column, &table));
    SC_TRY(list_names(&a));
    SC_TRY(sc_zalloc(ctx, (size_t)volume->label_count, sizeof *a.lines, &lines));
    a.lines = lines;
    for (size_t i = 0; i < table.count; i++)
        SC_TRY(assign_row(&a, &table.rows[i]));
    SC_TRY(tell_unknown(&a));
    tell_other_names(&a);
    memcpy(title, table.column, sizeof table.column);
out:
    sc_free(a.names);
    return status;
}

/* ---- measures ---- */

/* @return the value of a measure for a label; NAN if it has no voxels. */
static double measured(const sc_prepared *volume, sc_measure measure, int id)
{
    const sc_label_stats *stats = &volume->stats[id];
    const double voxel_ml = fabs(sc_affine_determinant(&volume->to_ras_mm)) / 1000;

    if (!stats->voxels)
        return NAN;
    switch (measure) {
    case SC_MEASURE_VOLUME:
        return (double)stats->voxels * voxel_ml;
    case SC_MEASURE_THICKNESS:
        return stats->thickness_mm;
    case SC_MEASURE_SURFACE:
        return stats->surface_mm2 / 100;
    }
    return NAN;
}

sc_status sc_color_values(const sc_ctx *ctx, const sc_color_by *by, const sc_prepared *volume,
                          double *values, char title[SC_NAME_BYTES])
{
    static const char *const titles[] = {[SC_MEASURE_VOLUME] = "Volume (ml)",
                                         [SC_MEASURE_THICKNESS] = "Mean thickness (mm)",
                                         [SC_MEASURE_SURFACE] = "Surface (cm\u00b2)"};

    for (int id = 0; id < volume->label_count; id++)
        values[id] =
            by->has_measure && id > 0 ? measured(volume, (sc_measure)by->measure, id) : NAN;
    if (!by->has_measure)
        return read_values(ctx, by, volume, values, title);
    snprintf(title, SC_NAME_BYTES, "%s", titles[by->measure]);
    return SC_OK;
}
