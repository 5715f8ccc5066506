/* SPDX-License-Identifier: BSD-3-Clause */
/* Ranks and time: what each thread did when, from the trace. However many events there are, the
 * picture has at most ROWS threads and PARTS parts of time. */
#include "internal.h"

#include <string.h>

enum {
    ROWS = 32,
    PARTS = 1000,
    LONG_EVENT = 4 /* parts: where a longer one begins is shown */
};

/* A thread that is shown. */
typedef struct thread_row {
    double kind_s[SC_TRACE_KIND_COUNT];       /* what it did in all */
    float part_s[PARTS][SC_TRACE_KIND_COUNT]; /* and in each part of the time */
    bool begins[PARTS];                       /* a long event begins there */
} thread_row;

/* What is collected while the trace is read. */
typedef struct activity {
    const sc_run_stats *stats;
    size_t *first;    /* [ranks + 1]: number of the first thread of each rank; owned, as is rows */
    thread_row *rows; /* [shown] */
    size_t threads, shown; /* number of all threads, and of those that have a row */
    double part_s;         /* how long a part is */
    long events;
} activity;

/* @return the number of the thread that row @p row shows. */
static size_t thread_of_row(const activity *a, size_t row)
{
    return row * a->threads / a->shown;
}

/* @return the row of a thread, or NULL if it has none. */
static thread_row *row_of_thread(const activity *a, size_t thread)
{
    const size_t row = (thread * a->shown + a->threads - 1) / a->threads;

    return row < a->shown && thread_of_row(a, row) == thread ? &a->rows[row] : NULL;
}

/* For sc_trace_read, with an activity as user. */
static void add_event(void *user, int rank, const sc_trace_event *event)
{
    activity *a = user;
    const double begin = event->begin_s / a->part_s;
    const double end = (event->begin_s + event->duration_s) / a->part_s;
    thread_row *row;
    int first, last;

    a->events++;
    if (rank >= a->stats->run.ranks || event->thread > a->stats->ranks[rank].threads)
        return;
    row = row_of_thread(a, a->first[rank] + (size_t)event->thread);
    if (!row)
        return;
    row->kind_s[event->kind] += event->duration_s;
    first = begin < PARTS - 1 ? (int)begin : PARTS - 1;
    last = end < PARTS - 1 ? (int)end : PARTS - 1;
    if (end - begin >= LONG_EVENT)
        row->begins[first] = true;
    for (int i = first; i <= last; i++) {
        const double from = begin > i ? begin : i, to = end < i + 1 ? end : i + 1;

        row->part_s[i][event->kind] += (float)(to > from ? (to - from) * a->part_s : 0);
    }
}

/* @return the phase as which a kind of event is shown. */
static sc_phase phase_of(int kind)
{
    static const sc_phase phases[SC_TRACE_KIND_COUNT] = {
        [SC_TRACE_READ] = SC_PHASE_READ,     [SC_TRACE_PREPARE] = SC_PHASE_PREPARE,
        [SC_TRACE_SHARE] = SC_PHASE_SHARE,   [SC_TRACE_DRAW] = SC_PHASE_RENDER,
        [SC_TRACE_ENCODE] = SC_PHASE_ENCODE, [SC_TRACE_FINISH] = SC_PHASE_WRITE};

    return phases[kind];
}

/* @return what a kind of event is called. */
static const char *word_of(int kind)
{
    return kind == SC_TRACE_FINISH ? "completing" : sc_phase_word(phase_of(kind));
}

/* Choose for each part what was done most of the time, or -1 if hardly anything was. */
static void choose_kinds(const thread_row *row, double part_s, int8_t kinds[PARTS])
{
    for (int i = 0; i < PARTS; i++) {
        double sum = 0;
        int most = 0;

        for (int kind = 0; kind < SC_TRACE_KIND_COUNT; kind++) {
            sum += row->part_s[i][kind];
            most = row->part_s[i][kind] > row->part_s[i][most] ? kind : most;
        }
        kinds[i] = (int8_t)(sum > 0.1 * part_s ? sc_phase_color(phase_of(most)) : -1);
    }
}

/* Write what a thread did into @p text: "drawing 3.21 s, encoding 0.10 s". */
static void describe(const thread_row *row, char *text, size_t size)
{
    size_t used = 0;

    snprintf(text, size, "nothing");
    for (int kind = 0; kind < SC_TRACE_KIND_COUNT; kind++) {
        if (row->kind_s[kind] > 0 && used < size)
            used += (size_t)snprintf(text + used, size - used, "%s%s %.2f s", used ? ", " : "",
                                     word_of(kind), row->kind_s[kind]);
    }
}

/* Add the rows to the page. */
static void add_rows(sc_page *page, const activity *a)
{
    const sc_run_stats *stats = a->stats;
    sc_row_chart rows = sc_rows_begin(page, "What each thread did when",
                                      sc_axis_to(PARTS * a->part_s, 6, false), true);
    int rank = 0;

    for (size_t i = 0; i < a->shown; i++) {
        const size_t thread = thread_of_row(a, i);
        int8_t kinds[PARTS];
        char label[SC_HOST_BYTES + 64], what[300];
        bool encodes;

        while (thread >= a->first[rank + 1])
            rank++;
        snprintf(label, sizeof label, "rank %d%s%s", rank, stats->run.nodes > 1 ? " on " : "",
                 stats->run.nodes > 1 ? stats->ranks[rank].host : "");
        encodes = (int)(thread - a->first[rank]) == stats->ranks[rank].threads;
        if (encodes)
            snprintf(label + strlen(label), sizeof label - strlen(label), ", encoding");
        else
            snprintf(label + strlen(label), sizeof label - strlen(label), ", thread %d",
                     (int)(thread - a->first[rank]));
        describe(&a->rows[i], what, sizeof what);
        if (encodes && rank > 0 && !strcmp(what, "nothing"))
            continue; /* rank 0 encodes alone */
        choose_kinds(&a->rows[i], a->part_s, kinds);
        sc_row_begin(&rows, label, what);
        sc_row_strip(&rows, kinds, a->rows[i].begins, PARTS);
        sc_row_end(&rows, "");
    }
    sc_rows_end(&rows, "seconds since the run began");
}

/* Add rows, legend and notes. */
static void add_chart(sc_page *page, const activity *a)
{
    const char *names[SC_TRACE_KIND_COUNT];
    int colors[SC_TRACE_KIND_COUNT];

    for (int kind = 0; kind < SC_TRACE_KIND_COUNT; kind++) {
        names[kind] = word_of(kind);
        colors[kind] = sc_phase_color(phase_of(kind));
    }
    sc_legend(page, names, colors, SC_TRACE_KIND_COUNT);
    add_rows(page, a);
    if (a->shown < a->threads)
        sc_page_add(page,
                    "<p class=\"note\">%zu of %zu threads are shown, at even distances.</p>\n",
                    a->shown, a->threads);
    sc_page_add(page,
                "<p class=\"note\">Of what is shorter than a thousandth of the time, the most "
                "frequent is shown. trace.json holds all %ld events; ui.perfetto.dev and "
                "chrome://tracing show it.</p>\n",
                a->events);
}

/* Number the threads, and allocate the rows. */
static sc_status allocate(const sc_ctx *ctx, activity *a)
{
    const sc_run_stats *stats = a->stats;
    void *block;
    sc_status status;

    SC_TRY(sc_alloc(ctx, (size_t)stats->run.ranks + 1, sizeof *a->first, &block));
    a->first = block;
    a->first[0] = 0;
    for (int i = 0; i < stats->run.ranks; i++) /* one more: it encodes and writes */
        a->first[i + 1] = a->first[i] + (size_t)stats->ranks[i].threads + 1;
    a->threads = a->first[stats->run.ranks];
    a->shown = a->threads < ROWS ? a->threads : ROWS;
    SC_TRY(sc_zalloc(ctx, a->shown, sizeof *a->rows, &block));
    a->rows = block;
out:
    return status;
}

void sc_report_activity(sc_page *page, const char *path, const sc_run_stats *stats)
{
    const sc_ctx looking = sc_quiet(page->ctx);
    activity a = {.stats = stats, .part_s = stats->run.wall_s / PARTS};
    sc_status status = page->status;

    sc_page_section(page, "Ranks and time");
    if (!stats->run.ended || stats->run.wall_s <= 0) {
        sc_page_add(page, "<p>The run has not ended, so there is no trace of it.</p>\n");
        goto out;
    }
    if (status == SC_OK)
        status = allocate(page->ctx, &a);
    if (status == SC_OK)
        status = sc_trace_read(&looking, path, add_event, &a);
    if (status == SC_OK)
        add_chart(page, &a);
    else if (sc_is_of_input(status))
        sc_page_add(page, "<p>The trace is %s.</p>\n",
                    status == SC_ERR_MISSING ? "missing" : "damaged");
    else
        page->status = status;
out:
    sc_free(a.first);
    sc_free(a.rows);
    sc_page_section_end(page);
}
