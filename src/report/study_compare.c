/* SPDX-License-Identifier: BSD-3-Clause */
/* The page that compares studies in several directories, cell by cell of the same name. */
#include "study_view.h"

#include <math.h>
#include <string.h>

enum { CELLS_SHOWN = 150, CHARTS = 24, STUDIES_IN_TABLE = SC_TABLE_COLUMNS_MAX - 2 };

/* The studies that are compared. */
typedef struct studies {
    const char *const *names; /* of their directories; borrowed */
    sc_study_view *views;     /* [count], owned */
    int count;
} studies;

/* @return the cell of a study that is named like the cell @p cell of the first one and was
 * measured, or -1. */
static int find_same(const studies *s, int study, int cell)
{
    const sc_study_view *view = &s->views[study];
    char wanted[SC_CELL_NAME_BYTES], name[SC_CELL_NAME_BYTES];

    sc_study_name(&s->views[0], cell, -1, "the only cell", wanted);
    for (int i = 0; i < view->count; i++) {
        sc_study_name(view, i, -1, "the only cell", name);
        if (sc_study_has(view, i) && !strcmp(name, wanted))
            return i;
    }
    return -1;
}

/* What one study says beside the first. */
typedef struct beside {
    int common;               /* cells of the same name that both have measured */
    int apart;                /* of them, those whose confidence intervals do not overlap */
    int other_pixels;         /* and those with other pixels */
    double log_sum, farthest; /* of the ratios of their times; the ratio farthest from 1 */
} beside;

/* @return the median of the first study's kind of time for a frame. */
static double time_s(const studies *s, int study, int cell)
{
    const sc_cell_result *r = &s->views[study].cells[cell];
    const bool wall = s->views[0].m->design.by_wall;

    return (wall ? r->wall_s.median : r->cpu_s.median) / r->typical.frames;
}

/* @return whether a measurement of @p cell has other pixels than @p pixels_hash. */
static bool has_other_pixels(const sc_measurements *m, int cell, uint64_t pixels_hash)
{
    for (size_t i = 0; i < m->count; i++) {
        if (m->items[i].cell == cell && m->items[i].pixels_hash != pixels_hash)
            return true;
    }
    return false;
}

static beside compare(const studies *s, int study)
{
    const bool wall = s->views[0].m->design.by_wall;
    beside b = {.farthest = 1};

    for (int i = 0; i < s->views[0].count; i++) {
        const int other = sc_study_has(&s->views[0], i) ? find_same(s, study, i) : -1;
        const sc_cell_result *x = &s->views[0].cells[i], *y;
        const sc_statistics *p, *q;
        double ratio;

        if (other < 0)
            continue;
        y = &s->views[study].cells[other];
        p = wall ? &x->wall_s : &x->cpu_s;
        q = wall ? &y->wall_s : &y->cpu_s;
        ratio = time_s(s, study, other) / time_s(s, 0, i);
        b.common++;
        b.log_sum += log(ratio);
        b.farthest = fabs(log(ratio)) > fabs(log(b.farthest)) ? ratio : b.farthest;
        b.apart += p->low / x->typical.frames > q->high / y->typical.frames ||
                   q->low / y->typical.frames > p->high / x->typical.frames;
        b.other_pixels += has_other_pixels(s->views[0].m, x->cell, x->typical.pixels_hash) ||
                          has_other_pixels(s->views[study].m, y->cell, x->typical.pixels_hash);
    }
    return b;
}

/* Say how each study does beside the first one. */
static void add_words(sc_page *page, const studies *s)
{
    for (int i = 1; i < s->count; i++) {
        const beside b = compare(s, i);

        sc_page_add(page, i == 1 ? "<p class=\"lead\">" : "<p>");
        if (b.common == 0) {
            sc_page_textf(page, "%s and %s have no measured cell of the same name.", s->names[0],
                          s->names[i]);
        } else {
            sc_page_textf(page,
                          "%s takes %.3f times the time of %s, in the geometric mean over %d cells "
                          "of the same name; farthest apart are cells with %.3f times. ",
                          s->names[i], exp(b.log_sum / b.common), s->names[0], b.common,
                          b.farthest);
            sc_page_add(page, "The confidence intervals of %d of them do not overlap. ", b.apart);
            if (b.other_pixels)
                sc_page_add(page, "%d of them have other pixels.", b.other_pixels);
            else
                sc_page_add(page, "All of them have the same pixels.");
        }
        sc_page_add(page, "</p>\n");
    }
}

/* Add a chart with a bar for each study. */
static void add_chart(sc_page *page, const studies *s, int cell)
{
    char name[SC_CELL_NAME_BYTES], caption[SC_CELL_NAME_BYTES + 80];
    double most = 0;
    sc_row_chart rows;

    for (int i = 0; i < s->count; i++) {
        const int same = find_same(s, i, cell);

        if (same >= 0)
            most = fmax(most, time_s(s, i, same));
    }
    sc_study_name(&s->views[0], cell, -1, "the only cell", name);
    snprintf(caption, sizeof caption, "%s: %s; less is better", name, sc_study_unit(&s->views[0]));
    rows = sc_rows_begin(page, caption, sc_axis_to(most, 6, false), false);
    for (int i = 0; i < s->count; i++) {
        const int same = find_same(s, i, cell);
        char value[32] = "not measured";

        if (same >= 0)
            snprintf(value, sizeof value, "%.4g", time_s(s, i, same));
        sc_row_begin(&rows, s->names[i], value);
        sc_row_bar(&rows, 0, same >= 0 ? time_s(s, i, same) : 0, 3);
        sc_row_end(&rows, same >= 0 ? value : "-");
    }
    sc_rows_end(&rows, sc_study_unit(&s->views[0]));
}

/* Add a row for each cell of the first study: the time of each study, and the ratio of the last to
 * the first. */
static void add_table(sc_page *page, const studies *s)
{
    const int shown = s->count < STUDIES_IN_TABLE ? s->count : STUDIES_IN_TABLE;
    const char *heads[SC_TABLE_COLUMNS_MAX] = {"Cell"};
    int rows = 0;
    sc_table table;

    for (int i = 0; i < shown; i++)
        heads[1 + i] = s->names[i];
    heads[1 + shown] = "Last over first";
    table = sc_table_begin(page, sc_study_unit(&s->views[0]), heads, shown + 2);
    for (int cell = 0; cell < s->views[0].count; cell++) {
        char name[SC_CELL_NAME_BYTES];
        double first = 0, last = 0;

        if (!sc_study_has(&s->views[0], cell) || rows++ >= CELLS_SHOWN)
            continue;
        sc_study_name(&s->views[0], cell, -1, "the only cell", name);
        sc_table_cell(&table, "%s", name);
        for (int i = 0; i < shown; i++) {
            const int same = find_same(s, i, cell);

            last = same >= 0 ? time_s(s, i, same) : 0;
            first = i == 0 ? last : first;
            sc_table_cell(&table, same >= 0 ? "%.4g" : "-", last);
        }
        sc_table_cell(&table, first > 0 && last > 0 ? "%.3f" : "-", last / first);
    }
    sc_table_end(&table);
    if (rows > CELLS_SHOWN)
        sc_page_add(page, "<p class=\"note\">The first %d of %d cells are shown.</p>\n",
                    CELLS_SHOWN, rows);
}

/* Add charts and the table of the cells of the first study. */
static void add_cells(sc_page *page, const studies *s)
{
    int charts = 0;

    if (s->views[0].measured == 0)
        return;
    sc_page_section(page, "Time of a frame");
    for (int i = 0; i < s->views[0].count && charts < CHARTS; i++) {
        if (!sc_study_has(&s->views[0], i))
            continue;
        add_chart(page, s, i);
        charts++;
    }
    if (charts < s->views[0].measured)
        sc_page_add(page, "<p class=\"note\">The first %d of %d cells are shown.</p>\n", charts,
                    s->views[0].measured);
    sc_page_section_end(page);
    sc_page_section(page, "All cells");
    add_table(page, s);
    sc_page_section_end(page);
}

/* Add where each study was measured: its last run. */
static void add_machines(sc_page *page, const studies *s)
{
    static const char *const heads[] = {
        "Directory",       "Title",  "Begin",   "Host",         "Processor", "Ranks",
        "Cores of rank 0", "Kernel", "Version", "Measurements", "State"};
    sc_table table;

    sc_page_section(page, "Where they were measured");
    table = sc_table_begin(page, "The last run of each study", heads, SC_COUNT_OF(heads));
    for (int i = 0; i < s->count; i++) {
        const sc_measurements *m = s->views[i].m;
        const sc_study_run none = {.host = "-"};
        const sc_study_run *run = m->run_count ? &m->runs[m->run_count - 1] : &none;

        sc_table_cell(&table, "%s", s->names[i]);
        sc_table_cell(&table, "%s", m->design.title);
        sc_table_cell(&table, "%s", run->begin);
        sc_table_cell(&table, "%s", run->host);
        sc_table_cell(&table, "%s", run->processor);
        sc_table_cell(&table, "%d", run->ranks);
        sc_table_cell(&table, "%d", run->cores);
        sc_table_cell(&table, "%s", run->kernel[0] ? run->kernel : "-");
        sc_table_cell(&table, "%s, commit %s", run->version, run->commit);
        sc_table_cell(&table, "%zu", m->count);
        sc_table_cell(&table, "%s", m->complete ? "complete" : "incomplete");
    }
    sc_table_end(&table);
    sc_page_section_end(page);
}

sc_status sc_report_compare_studies(const sc_ctx *ctx, const char *const *directories,
                                    const sc_measurements *measurements, int count, sc_text *out)
{
    studies s = {.names = directories};
    sc_page page = {.ctx = ctx};
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)count, sizeof *s.views, &block));
    s.views = block;
    for (; s.count < count; s.count++)
        SC_TRY(sc_study_view_open(ctx, &measurements[s.count], &s.views[s.count]));
    page = sc_page_begin(ctx, "Comparison of studies");
    add_words(&page, &s);
    add_cells(&page, &s);
    add_machines(&page, &s);
    SC_TRY(sc_page_end(&page));
    *out = page.text;
    page.text = (sc_text){0};
out:
    sc_page_clear(&page);
    for (int i = 0; i < s.count; i++)
        sc_study_view_clear(&s.views[i]);
    sc_free(s.views);
    return status;
}
