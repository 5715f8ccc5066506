/* SPDX-License-Identifier: BSD-3-Clause */
/* What a study says, in words. */
#include "study_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ITEMS = 8 }; /* most items of a list of exceptions */

/* @return the number of values of an axis; 1 for none. */
static int values_of(const sc_study_view *view, int axis)
{
    return axis < 0 ? 1 : view->m->design.axes[axis].value_count;
}

/* Begin the item of a list that names at most ITEMS: the list with the first one. @return whether
 * it is to be written. */
static bool begin_item(sc_page *page, int number)
{
    if (number == 0)
        sc_page_add(page, "<ul>\n");
    if (number < ITEMS)
        sc_page_add(page, "<li>");
    return number < ITEMS;
}

/* End a list of @p count items. */
static void end_items(sc_page *page, int count)
{
    if (count > ITEMS)
        sc_page_add(page, "<li>and %d more; the tables have all.</li>\n", count - ITEMS);
    if (count > 0)
        sc_page_add(page, "</ul>\n");
}

/* ---- which value is fastest ---- */

/* The values of the series, compared in each combination of the other axes. */
typedef struct contest {
    int groups;       /* combinations in which two values or more were measured */
    int close;        /* of them, those in which the intervals of the two fastest overlap */
    int best;         /* the value that is fastest most often */
    int wins;         /* how often that is */
    double low, high; /* how many times as fast as the first value it is where it is fastest; */
    bool has_first;   /* which was measured in one of them at least */
} contest;

/* Find the fastest and the second fastest cell of a group. @param second -1: there is none. */
static void find_fastest(const sc_study_view *view, int group, int *first, int *second)
{
    *first = *second = -1;
    for (int v = 0; v < values_of(view, view->series); v++) {
        const int cell = sc_study_with(view, group, view->series, v);

        if (!sc_study_has(view, cell))
            continue;
        if (*first < 0 || sc_study_frame_s(view, cell) < sc_study_frame_s(view, *first)) {
            *second = *first;
            *first = cell;
        } else if (*second < 0 || sc_study_frame_s(view, cell) < sc_study_frame_s(view, *second)) {
            *second = cell;
        }
    }
}

/* @return whether the confidence intervals of two cells overlap, so that they cannot be told apart.
 */
static bool overlap(const sc_study_view *view, int a, int b)
{
    const sc_statistics *x = sc_study_time(view, a), *y = sc_study_time(view, b);
    const double p = view->cells[a].typical.frames, q = view->cells[b].typical.frames;

    return !x->has_interval || !y->has_interval ||
           (x->low / p <= y->high / q && y->low / q <= x->high / p);
}

/* Count which value is fastest how often. @param wins [values of the series], zeroed. */
static contest hold_contest(const sc_study_view *view, int *wins)
{
    const sc_design *design = &view->m->design;
    contest c = {.low = INFINITY};

    for (int i = 0; i < view->count; i++) {
        int first, second;

        if (!sc_study_is_first(view, i, view->series))
            continue;
        find_fastest(view, i, &first, &second);
        if (second < 0)
            continue;
        c.groups++;
        c.close += overlap(view, first, second);
        wins[sc_design_index(design, first, view->series)]++;
    }
    for (int v = 1; v < values_of(view, view->series); v++)
        c.best = wins[v] > wins[c.best] ? v : c.best;
    c.wins = wins[c.best];
    for (int i = 0; i < view->count; i++) {
        const int cell = sc_study_with(view, i, view->series, c.best);
        int first, second;
        double ratio;

        if (!sc_study_is_first(view, i, view->series) || c.best == 0 || !sc_study_has(view, i))
            continue;
        find_fastest(view, i, &first, &second);
        if (first != cell)
            continue;
        ratio = sc_study_frame_s(view, i) / sc_study_frame_s(view, cell);
        c.low = ratio < c.low ? ratio : c.low;
        c.high = ratio > c.high ? ratio : c.high;
        c.has_first = true;
    }
    return c;
}

/* Say which value of the series is fastest. */
static void add_contest(sc_page *page, const sc_study_view *view)
{
    const sc_design_axis *axis = &view->m->design.axes[view->series];
    contest c;
    void *wins;

    if (page->status == SC_OK)
        page->status = sc_zalloc(page->ctx, (size_t)axis->value_count, sizeof(int), &wins);
    if (page->status != SC_OK)
        return;
    c = hold_contest(view, wins);
    sc_free(wins);
    if (c.groups == 0)
        return;
    sc_page_add(page, "<p class=\"lead\">");
    sc_page_textf(page, "%s: %s is fastest", axis->name, axis->values[c.best]);
    if (c.groups > 1 && c.wins == c.groups)
        sc_page_add(page, " in all %d combinations of the other axes", c.groups);
    else if (c.groups > 1)
        sc_page_add(page, " in %d of %d combinations of the other axes", c.wins, c.groups);
    if (c.has_first && c.high - c.low < 0.005)
        sc_page_textf(page, ", %.2f times as fast as %s", c.low, axis->values[0]);
    else if (c.has_first)
        sc_page_textf(page, ", %.2f to %.2f times as fast as %s", c.low, c.high, axis->values[0]);
    sc_page_add(page, ".</p>\n");
    if (c.close)
        sc_page_add(
            page,
            "<p>In %d of %d the confidence intervals of the two fastest overlap: which of the "
            "two is faster remains open there.</p>\n",
            c.close, c.groups);
}

/* Where leap, the method of segcast itself, is not the fastest, say so. */
static void add_leap(sc_page *page, const sc_study_view *view)
{
    const sc_design_axis *axis = &view->m->design.axes[view->series];
    int leap = -1, behind = 0, compared = 0;

    for (int v = 0; v < axis->value_count && !strcmp(axis->name, "render.skip"); v++)
        leap = strcmp(axis->values[v], "leap") ? leap : v;
    for (int i = 0; i < view->count && leap >= 0; i++) {
        const int cell = sc_study_with(view, i, view->series, leap);
        char name[SC_CELL_NAME_BYTES];
        int first, second;

        if (!sc_study_is_first(view, i, view->series) || !sc_study_has(view, cell))
            continue;
        find_fastest(view, i, &first, &second);
        compared += second >= 0;
        if (first == cell || second < 0)
            continue;
        if (behind == 0)
            sc_page_add(page, "<p>leap is not ahead everywhere:</p>\n");
        if (begin_item(page, behind++)) {
            sc_study_name(view, i, view->series, "here", name);
            sc_page_textf(page, "%s: %s takes %.2f of its time%s", name,
                          axis->values[sc_design_index(&view->m->design, first, view->series)],
                          sc_study_frame_s(view, first) / sc_study_frame_s(view, cell),
                          overlap(view, first, cell) ? ", but the intervals overlap" : "");
            sc_page_add(page, "</li>\n");
        }
    }
    end_items(page, behind);
    if (compared && !behind)
        sc_page_add(page,
                    "<p>The median of leap is below that of every other method, wherever both were "
                    "measured.</p>\n");
}

/* ---- what limited it ---- */

typedef enum limit {
    LIMIT_DRAW,
    LIMIT_CORES,
    LIMIT_START,
    LIMIT_ENCODE,
    LIMIT_WAIT,
    LIMIT_COUNT
} limit;

/* @return what limited a cell, judged by its typical measurement. */
static limit limit_of(const sc_study_view *view, int cell)
{
    const sc_measurement *t = &view->cells[cell].typical;
    const double drawing_s = t->draw_mean_s * t->ranks * t->threads;
    const double start_s = view->m->design.whole_jobs ? t->read_s + t->prepare_s + t->share_s : 0;

    if (start_s > 0.5 * t->wall_s)
        return LIMIT_START;
    if (t->accept_s > 0.8 * t->wall_s)
        return LIMIT_ENCODE;
    if (t->idle_mean_s > 0.15 * t->wall_s)
        return LIMIT_WAIT;
    if (t->ranks * t->threads > 1 && drawing_s > 0 && t->draw_cpu_s < 0.8 * drawing_s)
        return LIMIT_CORES;
    return LIMIT_DRAW;
}

/* Say what limited the cells, and what to change. */
static void add_limits(sc_page *page, const sc_study_view *view)
{
    static const char *const words[LIMIT_COUNT] = {
        [LIMIT_DRAW] = "drawing itself: more cores, fewer pixels or a faster `render.skip` make it "
                       "faster",
        [LIMIT_CORES] =
            "cores: threads that drew had a core only a part of the time, or waited for "
            "each other at the end of a frame; give each thread a core of its own "
            "(fewer ranks or `--threads`, `mpirun --map-by slot:PE=THREADS`)",
        [LIMIT_START] = "reading and preparing the volume: `segcast prepare` does it once for all "
                        "runs, and longer films need it only once",
        [LIMIT_ENCODE] = "encoding and writing on rank 0: `farm.encode: segments` lets all ranks "
                         "encode",
        [LIMIT_WAIT] =
            "waiting: ranks had no work unit for more than 15 % of the time; more frames "
            "for each rank, or `farm.partition: tiles`, help"};
    int counts[LIMIT_COUNT] = {0};

    for (int i = 0; i < view->count; i++) {
        if (sc_study_has(view, i))
            counts[limit_of(view, i)]++;
    }
    sc_page_add(page, "<p>What limited the cells:</p>\n<ul>\n");
    for (int l = 0; l < LIMIT_COUNT; l++) {
        if (!counts[l])
            continue;
        sc_page_add(page, "<li>%s%d by ", counts[l] == view->measured ? "all " : "", counts[l]);
        sc_page_prose(page, words[l]);
        sc_page_add(page, ".</li>\n");
    }
    sc_page_add(page, "</ul>\n");
}

/* Say how the cells with the most workers do beside their bases. */
static void add_scaling(sc_page *page, const sc_study_view *view)
{
    int count = 0;

    for (int i = 0; i < view->count; i++) {
        const sc_cell_result *r = &view->cells[i], *base = &view->cells[r->base];
        bool is_largest = sc_study_has(view, i) && r->workers > base->workers;
        char name[SC_CELL_NAME_BYTES];

        for (int j = 0; j < view->count && is_largest; j++)
            is_largest = view->cells[j].base != r->base || view->cells[j].workers < r->workers ||
                         (view->cells[j].workers == r->workers && j >= i);
        if (!is_largest)
            continue;
        if (count == 0)
            sc_page_add(page, "<p>The largest numbers of workers (ranks times threads):</p>\n");
        if (begin_item(page, count++)) {
            sc_study_name(view, i, -1, "this cell", name);
            sc_page_textf(page,
                          "%s: %g workers are %.2f times as fast as %g; efficiency %.2f, serial "
                          "share %.3f, the busiest rank %.0f %% over the mean",
                          name, r->workers, r->speedup, base->workers, r->efficiency,
                          r->serial_share, 100 * r->imbalance);
            sc_page_add(page, "</li>\n");
        }
    }
    end_items(page, count);
}

/* ---- what the machine could do ---- */

/* The least and the largest of some values. */
typedef struct span {
    double low, high;
} span;

static void widen(span *s, double value)
{
    s->low = value < s->low ? value : s->low;
    s->high = value > s->high ? value : s->high;
}

/* Write the ends of a span, times @p scale, or only one number if they look the same. */
static void add_span(sc_page *page, span s, double scale, const char *unit)
{
    char low[32], high[32];

    snprintf(low, sizeof low, s.low * scale < 100 ? "%.3g" : "%.0f", s.low * scale);
    snprintf(high, sizeof high, s.high * scale < 100 ? "%.3g" : "%.0f", s.high * scale);
    sc_page_add(page, "%s%s%s%s", low, strcmp(low, high) ? " to " : "",
                strcmp(low, high) ? high : "", unit);
}

/* Say what cores can do at most, and what drawing has used of it, as far as it was counted. The
 * machine is that of the last run whose roof is known. */
static void add_roof(sc_page *page, const sc_study_view *view)
{
    span rate = {INFINITY, 0}, bytes = {INFINITY, 0}, sample_s = {INFINITY, 0};
    const sc_study_run *run = NULL;
    double core_rate, core_bytes;

    for (size_t i = 0; i < view->m->run_count; i++) {
        if (view->m->runs[i].roof.read_bytes_per_s > 0 &&
            view->m->runs[i].roof.instructions_per_s > 0)
            run = &view->m->runs[i];
    }
    if (!run)
        return;
    core_rate = run->roof.instructions_per_s / run->cores;
    core_bytes = run->roof.read_bytes_per_s / run->cores;
    for (int i = 0; i < view->count; i++) {
        const sc_measurement *t = &view->cells[i].typical;

        if (!sc_study_has(view, i) || t->cpu_s <= 0)
            continue;
        if (t->instructions > 0)
            widen(&rate, t->instructions / t->cpu_s);
        if (t->memory_bytes > 0)
            widen(&bytes, t->memory_bytes / t->cpu_s);
        if (t->samples > 0 && t->draw_cpu_s > 0)
            widen(&sample_s, t->draw_cpu_s / (double)t->samples);
    }
    sc_page_add(page,
                "<p>Roofline: when the study began, the %d core%s of rank 0 read at most %.3g GB/s "
                "from memory and executed %.3g thousand million instructions a second, together. ",
                run->cores, run->cores == 1 ? "" : "s", run->roof.read_bytes_per_s * 1e-9,
                run->roof.instructions_per_s * 1e-9);
    if (rate.high > 0) {
        sc_page_add(page, "Drawing used ");
        add_span(page, rate, 100 / core_rate, " % of a core's instructions");
        if (bytes.high > 0)
            sc_page_add(page, " and ");
        if (bytes.high > 0)
            add_span(page, bytes, 100 / core_bytes, " % of its share of the reading");
        sc_page_add(page, ", waiting included. ");
    } else {
        sc_page_add(page, "What drawing used of it was not counted: the system or the processor "
                          "does not let counters be read (perf_event_open), or whole jobs were "
                          "measured. ");
    }
    if (sample_s.high > 0) {
        sc_page_add(page, "A sample took ");
        add_span(page, sample_s, 1e9, " ns of a core, in which it could execute ");
        add_span(page, sample_s, core_rate, " such instructions or read ");
        add_span(page, sample_s, core_bytes, " bytes.");
    }
    sc_page_add(page, "</p>\n");
}

/* ---- how far it is to be trusted ---- */

/* Say how exactly the times are known. */
static void add_precision(sc_page *page, const sc_study_view *view)
{
    int without = 0, worst = -1;
    double most = 0;
    char name[SC_CELL_NAME_BYTES];

    for (int i = 0; i < view->count; i++) {
        const double precision = sc_statistics_precision(sc_study_time(view, i));

        if (!sc_study_has(view, i))
            continue;
        without += !isfinite(precision);
        if (isfinite(precision) && precision >= most) {
            most = precision;
            worst = i;
        }
    }
    if (worst >= 0) {
        sc_study_name(view, worst, -1, "the only cell", name);
        sc_page_add(page, "<p>Medians are known to %.1f %% or better", 100 * most);
        sc_page_textf(page, " (half the 95 %% confidence interval; the widest is that of %s).",
                      name);
        sc_page_add(page, "</p>\n");
    }
    if (without)
        sc_page_add(page,
                    "<p>%d cell%s fewer than %d measurements, which is too few for a confidence "
                    "interval.</p>\n",
                    without, without == 1 ? " has" : "s have", SC_INTERVAL_LEAST);
}

/* @return whether the values of an axis may not change a pixel. */
static bool keeps_pixels(const char *name)
{
    return !strcmp(name, "ranks") || !strcmp(name, "threads") || !strcmp(name, "placement") ||
           !strcmp(name, "render.skip") || !strcmp(name, "render.cpu") ||
           !strncmp(name, "farm.", strlen("farm."));
}

/* Say whether all pixels that have to be the same are. */
static void add_pixels(sc_page *page, const sc_study_view *view)
{
    const sc_design *design = &view->m->design;
    char first[SC_CELL_NAME_BYTES], second[SC_CELL_NAME_BYTES];
    uint64_t *pictures;
    void *block;
    int cell, other = 0;

    if (page->status == SC_OK)
        page->status = sc_zalloc(page->ctx, (size_t)view->count, sizeof *pictures, &block);
    if (page->status != SC_OK)
        return;
    pictures = block;
    for (int i = 0; i < view->count; i++) {
        for (int a = 0; a < design->axis_count; a++) {
            if (!keeps_pixels(design->axes[a].name))
                pictures[i] = pictures[i] * (uint64_t)design->axes[a].value_count +
                              (uint64_t)sc_design_index(design, i, a);
        }
    }
    cell = sc_measurements_mismatch(view->m, 0, pictures, &other);
    sc_free(block);
    sc_page_add(page, "<p>");
    if (cell >= 0) {
        sc_study_name(view, cell, -1, "a cell", first);
        sc_study_name(view, other, -1, "itself", second);
        sc_page_textf(page, "The pixels do not agree: those of %s are others than those of %s.",
                      first, second);
    } else {
        sc_page_add(page,
                    "All pixels agree: every measurement of a cell, and cells that differ only "
                    "in ranks, threads, placement, skip method, kernel or farm, gave the same "
                    "pictures, bit for bit.");
    }
    sc_page_add(page, "</p>\n");
}

/* Say which cells were not measured, one item for each reason. */
static void add_skipped(sc_page *page, const sc_study_view *view)
{
    int missing = 0, items = 0;

    for (int i = 0; i < view->count; i++)
        missing += !view->cells[i].skipped && !sc_study_has(view, i);
    if (missing)
        sc_page_add(page, "<p>%d cell%s not measured yet.</p>\n", missing,
                    missing == 1 ? " was" : "s were");
    for (size_t i = 0; i < view->m->skipped_count; i++) {
        const sc_skipped_cell *skipped = &view->m->skipped[i];
        bool is_new = true;
        int same = 0;

        for (size_t j = 0; j < view->m->skipped_count; j++) {
            const bool equal = !strcmp(view->m->skipped[j].reason, skipped->reason);

            is_new = is_new && !(equal && j < i);
            same += equal;
        }
        if (!is_new)
            continue;
        if (items == 0)
            sc_page_add(page, "<p>Cells that could not be measured here:</p>\n");
        if (begin_item(page, items++)) {
            sc_page_textf(page, "%d: %s", same, skipped->reason);
            sc_page_add(page, "</li>\n");
        }
    }
    end_items(page, items);
}

void sc_report_study_words(sc_page *page, const sc_study_view *view)
{
    if (view->measured && view->series >= 0)
        add_contest(page, view);
    sc_page_add(page, "<p>%zu measurements of %d of %d cells. %s</p>\n", view->m->count,
                view->measured, view->count,
                view->m->complete ? "The study is complete."
                                  : "The study is not complete: the same command with "
                                    "<code>--resume</code> goes on.");
    if (view->measured) {
        if (view->series >= 0)
            add_leap(page, view);
        add_scaling(page, view);
        add_limits(page, view);
        add_roof(page, view);
        add_precision(page, view);
        add_pixels(page, view);
    }
    add_skipped(page, view);
}
