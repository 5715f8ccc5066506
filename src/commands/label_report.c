/* SPDX-License-Identifier: BSD-3-Clause */
/* How a label table and the voxels of a volume agree, for segcast info and check: values that
 * several rows name, rows of values that no voxel has, voxels whose value no row names, and numbers
 * that the table leaves out. */
#include "label_report.h"

#include <stdlib.h>

enum { LISTED_MAX = 12 /* labels that are printed of each list; JSON has all */ };

/* For qsort of pointers to sc_label: rising by value; of one value in the order of the table. */
static int by_value(const void *a, const void *b)
{
    const sc_label *x = *(const sc_label *const *)a, *y = *(const sc_label *const *)b;

    return x->value != y->value ? (x->value > y->value) - (x->value < y->value) : (x > y) - (x < y);
}

/* @return the voxels of the label @p value; 0 if there are none. */
static uint64_t voxels_of(const sc_prepared *volume, int64_t value)
{
    int low = 0, high = volume->label_count - 1;

    while (low <= high) {
        const int middle = low + (high - low) / 2;

        if (volume->labels[middle].value == value)
            return volume->stats[middle].voxels;
        if (volume->labels[middle].value < value)
            low = middle + 1;
        else
            high = middle - 1;
    }
    return 0;
}

/* Append a label to a list, which has room. */
static void append(sc_label_list *list, const sc_label *label)
{
    list->labels[list->count++] = label;
}

/* Fill the lists and the gaps of @p out from @p rows, sorted by value. */
static void compare(const sc_label *const *rows, size_t row_count, const sc_prepared *volume,
                    bool scanned, sc_label_report *out)
{
    size_t at = 0;

    for (size_t i = 0; i < row_count; i++) {
        const bool again = i > 0 && rows[i]->value == rows[i - 1]->value;

        if (i > 0 && !again && rows[i]->value - 1 > rows[i - 1]->value)
            out->gaps[out->gap_count++] =
                (sc_label_gap){rows[i - 1]->value + 1, rows[i]->value - 1};
        if (again && (i == 1 || rows[i]->value != rows[i - 2]->value))
            append(&out->doubled, rows[i - 1]);
        if (scanned && !again && !voxels_of(volume, rows[i]->value))
            append(&out->without_voxels, rows[i]);
    }
    for (int id = 1; id < volume->label_count && scanned; id++) {
        while (at < row_count && rows[at]->value < volume->labels[id].value)
            at++;
        if (volume->stats[id].voxels &&
            (at == row_count || rows[at]->value != volume->labels[id].value))
            append(&out->without_row, &volume->labels[id]);
    }
}

sc_status sc_label_report_make(const sc_ctx *ctx, const sc_label_source *source,
                               const sc_prepared *volume, bool scanned, sc_label_report *out)
{
    const size_t count = source->table.count;
    size_t row_count = 0;
    SC_OWN(sc_free_at) const sc_label **rows = NULL, **lists = NULL;

    *out = (sc_label_report){.source = source};
    if (!source->path[0])
        return SC_OK;
    SC_PASS(SC_ALLOC(ctx, count + 1, &rows));
    SC_PASS(SC_ALLOC(ctx, 2 * count + (size_t)volume->label_count, &lists));
    SC_PASS(SC_ALLOC(ctx, count + 1, &out->gaps));
    for (size_t i = 0; i < count; i++) {
        if (source->table.rows[i].value) /* not that of background */
            rows[row_count++] = &source->table.rows[i];
    }
    qsort(rows, row_count, sizeof *rows, by_value);
    SC_HAND_OVER(lists, &out->owned);
    out->doubled.labels = out->owned;
    out->without_voxels.labels = out->doubled.labels + count;
    out->without_row.labels = out->without_voxels.labels + count;
    compare(rows, row_count, volume, scanned, out);
    return SC_OK;
}

void sc_label_report_clear(sc_label_report *report)
{
    sc_free(report->gaps);
    sc_free(report->owned);
    *report = (sc_label_report){0};
}

/* Print one list in a line, if it holds anything. */
static void print_list(FILE *stream, const char *what, const sc_label_list *list)
{
    if (!list->count)
        return;
    fprintf(stream, "  %-22s", what);
    for (size_t i = 0; i < list->count && i < LISTED_MAX; i++) {
        fprintf(stream, "%s%lld", i ? ", " : "", (long long)list->labels[i]->value);
        if (list->labels[i]->name[0]) {
            fputc(' ', stream);
            sc_print(stream, list->labels[i]->name);
        }
    }
    if (list->count > LISTED_MAX)
        fprintf(stream, ", and %zu more", list->count - LISTED_MAX);
    fputc('\n', stream);
}

/* Print the gaps in a line, if there are any. */
static void print_gaps(FILE *stream, const sc_label_report *report)
{
    if (!report->gap_count)
        return;
    fprintf(stream, "  %-22s", "numbers left out");
    for (size_t i = 0; i < report->gap_count && i < LISTED_MAX; i++) {
        const sc_label_gap gap = report->gaps[i];

        fprintf(stream, "%s%lld", i ? ", " : "", (long long)gap.first);
        if (gap.last > gap.first)
            fprintf(stream, " to %lld", (long long)gap.last);
    }
    if (report->gap_count > LISTED_MAX)
        fprintf(stream, ", and %zu more gaps", report->gap_count - LISTED_MAX);
    fputc('\n', stream);
}

void sc_label_report_print(const sc_label_report *report, FILE *stream)
{
    if (!report->owned)
        return;
    fputs("label table ", stream);
    sc_print(stream, report->source->path);
    fprintf(stream, ": %zu rows\n", report->source->table.count);
    print_list(stream, "several rows", &report->doubled);
    print_list(stream, "rows without voxels", &report->without_voxels);
    print_list(stream, "voxels without a row", &report->without_row);
    print_gaps(stream, report);
}

/* @return the values of a list as an array of JSON, or NULL without memory. */
static json_t *values(const sc_label_list *list)
{
    json_t *array = json_array();

    for (size_t i = 0; i < list->count; i++)
        array = sc_json_with(array, json_integer((json_int_t)list->labels[i]->value));
    return array;
}

/* @return the gaps as an array of pairs, first and last number, or NULL without memory. */
static json_t *gaps(const sc_label_report *report)
{
    json_t *array = json_array();

    for (size_t i = 0; i < report->gap_count; i++)
        array = sc_json_with(array, json_pack("[I, I]", (json_int_t)report->gaps[i].first,
                                              (json_int_t)report->gaps[i].last));
    return array;
}

json_t *sc_label_report_json(const sc_label_report *report)
{
    if (!report->owned)
        return json_null();
    return json_pack("{s:s, s:I, s:o, s:o, s:o, s:o}", "path", report->source->path, "rows",
                     (json_int_t)report->source->table.count, "several_rows",
                     values(&report->doubled), "rows_without_voxels",
                     values(&report->without_voxels), "voxels_without_row",
                     values(&report->without_row), "numbers_left_out", gaps(report));
}
