/* SPDX-License-Identifier: BSD-3-Clause */
/* The results of a study as tables in Markdown, for documents: the values of one axis side by side,
 * or a row for each cell of a study over ranks or threads. */
#include "study_view.h"

#include <math.h>

/* Text that is being written; the first error ends it. */
typedef struct writer {
    const sc_ctx *ctx;
    sc_text text;
    sc_status status;
} writer;

/* Add a formatted text. */
#define ADD(w, ...)                                                                                \
    ((w)->status =                                                                                 \
         (w)->status == SC_OK ? sc_text_add((w)->ctx, &(w)->text, __VA_ARGS__) : (w)->status)

/* Add any text so that it stays within its cell and is shown as it is. */
static void add_text(writer *w, const char *text)
{
    for (; *text; text++) {
        if (strchr("|\\`*_<[&", *text))
            ADD(w, "\\");
        ADD(w, "%c", *text == '\n' || *text == '\r' ? ' ' : *text);
    }
}

/* @return the number of values that stand side by side. */
static int columns_of(const sc_study_view *view)
{
    return view->series < 0 ? 1 : view->m->design.axes[view->series].value_count;
}

/* @return the cell of a group in a column. */
static int cell_at(const sc_study_view *view, int group, int column)
{
    return view->series < 0 ? group : sc_study_with(view, group, view->series, column);
}

/* Add the head of a table: @p first, and the values of the series. */
static void add_head(writer *w, const sc_study_view *view, const char *first)
{
    ADD(w, "| %s |", first);
    for (int c = 0; c < columns_of(view); c++) {
        ADD(w, " ");
        add_text(w, view->series < 0 ? "time" : view->m->design.axes[view->series].values[c]);
        ADD(w, " |");
    }
    ADD(w, "\n|---|");
    for (int c = 0; c < columns_of(view); c++)
        ADD(w, "---|");
    ADD(w, "\n");
}

/* Add the row of the paper, if the study compares its two methods. */
static void add_paper(writer *w, const sc_study_view *view)
{
    const sc_design_axis *axis;

    if (!sc_study_has_paper(view))
        return;
    axis = &view->m->design.axes[view->series];
    ADD(w, "| the paper, its heart and computer |");
    for (int c = 0; c < axis->value_count; c++) {
        if (!strcmp(axis->values[c], "none"))
            ADD(w, " %.1f |", SC_PAPER_PLAIN_S);
        else if (!strcmp(axis->values[c], "interior"))
            ADD(w, " %.1f (%.2f) |", SC_PAPER_ACCELERATED_S,
                SC_PAPER_PLAIN_S / SC_PAPER_ACCELERATED_S);
        else
            ADD(w, " |");
    }
    ADD(w, "\n");
}

/* Begin the row of a group. @param what stands behind its name; "": nothing. */
static void begin_row(writer *w, const sc_study_view *view, int group, const char *what)
{
    char name[SC_CELL_NAME_BYTES];

    sc_study_name(view, group, view->series, what[0] ? "" : "the study", name);
    ADD(w, "| ");
    add_text(w, name);
    ADD(w, "%s%s |", what[0] && name[0] ? ": " : "", what);
}

/* Add the table of times: in brackets, how many times as fast as the first column. */
static void add_times(writer *w, const sc_study_view *view)
{
    ADD(w, "Median of the %s; in brackets, how many times as fast as the first column.\n\n",
        sc_study_unit(view));
    add_head(w, view, "");
    add_paper(w, view);
    for (int i = 0; i < view->count; i++) {
        const int first = cell_at(view, i, 0);

        if (!sc_study_is_first(view, i, view->series))
            continue;
        begin_row(w, view, i, "");
        for (int c = 0; c < columns_of(view); c++) {
            const int cell = cell_at(view, i, c);

            if (!sc_study_has(view, cell))
                ADD(w, " |");
            else if (c == 0 || !sc_study_has(view, first))
                ADD(w, " %.4g |", sc_study_frame_s(view, cell));
            else
                ADD(w, " %.4g (%.2f) |", sc_study_frame_s(view, cell),
                    sc_study_frame_s(view, first) / sc_study_frame_s(view, cell));
        }
        ADD(w, "\n");
    }
    ADD(w, "\n");
}

/* What the second table holds of a cell. */
typedef struct quantity {
    const char *name;
    int decimals;
} quantity;
static const quantity quantities[] = {{"samples per ray", 1},
                                      {"preparation, s", 2},
                                      {"of that for the method alone, s", 2},
                                      {"peak memory of all ranks, MB", 0}};

static double quantity_of(const sc_cell_result *r, size_t which)
{
    const double values[] = {r->samples_per_ray, r->typical.start.prepare_s,
                             r->typical.start.derive_s,
                             (double)r->typical.memory.peak_sum_bytes / 1e6};

    return values[which];
}

/* Add the table of work, preparation and memory. */
static void add_work(writer *w, const sc_study_view *view)
{
    add_head(w, view, "");
    for (int i = 0; i < view->count; i++) {
        if (!sc_study_is_first(view, i, view->series))
            continue;
        for (size_t q = 0; q < SC_COUNT_OF(quantities); q++) {
            begin_row(w, view, i, quantities[q].name);
            for (int c = 0; c < columns_of(view); c++) {
                const int cell = cell_at(view, i, c);

                if (sc_study_has(view, cell))
                    ADD(w, " %.*f |", quantities[q].decimals, quantity_of(&view->cells[cell], q));
                else
                    ADD(w, " |");
            }
            ADD(w, "\n");
        }
    }
    ADD(w, "\n");
}

/* Add the table of a study over ranks or threads. */
static void add_scaling(writer *w, const sc_study_view *view)
{
    ADD(w, "| | seconds a frame | CPU seconds a frame | speed-up | efficiency | serial share | "
           "imbalance |\n|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < view->count; i++) {
        const sc_cell_result *r = &view->cells[i];
        char name[SC_CELL_NAME_BYTES];

        if (!sc_study_has(view, i))
            continue;
        sc_study_name(view, i, -1, "the study", name);
        ADD(w, "| ");
        add_text(w, name);
        ADD(w, " | %.4g | %.4g | %.2f | %.3f | ", r->wall_s.median / r->typical.frames,
            r->cpu_s.median / r->typical.frames, r->speedup, r->efficiency);
        if (r->base != i)
            ADD(w, "%.4f", r->serial_share);
        ADD(w, " | %.1f %% |\n", 100 * r->imbalance);
    }
    ADD(w, "\n");
}

/* Say where and how exactly it was measured. */
static void add_source(writer *w, const sc_study_view *view)
{
    const sc_measurements *m = view->m;
    size_t least = 0, most = 0;
    double precision = 0;

    for (int i = 0; i < view->count; i++) {
        const size_t count = view->cells[i].cpu_s.count;
        const double half = sc_statistics_precision(sc_study_time(view, i));

        if (count == 0)
            continue;
        least = least == 0 || count < least ? count : least;
        most = count > most ? count : most;
        precision = half > precision ? half : precision;
    }
    ADD(w, "Medians of %zu", least);
    if (most > least)
        ADD(w, " to %zu", most);
    ADD(w, " measurements");
    if (isfinite(precision))
        ADD(w, ", known to %.1f %% or better (half the 95 %% confidence interval)",
            100 * precision);
    if (m->run_count) {
        const sc_study_run *run = &m->runs[m->run_count - 1];

        ADD(w, ". Measured on ");
        add_text(w, run->processor[0] ? run->processor : run->host);
        ADD(w, ", %d core%s, %d rank%s, kernels ", run->cores, run->cores == 1 ? "" : "s",
            run->ranks, run->ranks == 1 ? "" : "s");
        add_text(w, run->kernel[0] ? run->kernel : "unknown");
        ADD(w, ", segcast ");
        add_text(w, run->version);
        ADD(w, " (commit ");
        add_text(w, run->commit);
        ADD(w, "), %.10s", run->begin);
    }
    ADD(w, ".%s\n", m->complete ? "" : " The study is not complete.");
}

sc_status sc_report_study_markdown(const sc_ctx *ctx, const sc_measurements *measurements,
                                   sc_text *out)
{
    SC_OWN(sc_study_view_clear) sc_study_view view = {0};
    writer w = {.ctx = ctx};

    SC_PASS(sc_study_view_open(ctx, measurements, &view));
    if (measurements->design.title[0]) {
        ADD(&w, "**");
        add_text(&w, measurements->design.title);
        ADD(&w, "**\n\n");
    }
    if (view.measured == 0)
        ADD(&w, "Nothing was measured yet.\n");
    else if (view.scale >= 0)
        add_scaling(&w, &view);
    else
        add_times(&w, &view);
    if (view.measured && view.scale < 0)
        add_work(&w, &view);
    if (view.measured)
        add_source(&w, &view);
    if (w.status == SC_OK)
        *out = w.text;
    else
        sc_text_clear(&w.text);
    return w.status;
}
