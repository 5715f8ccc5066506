/* SPDX-License-Identifier: BSD-3-Clause */
/* Ranks and time: what each thread did when, from the trace. However many events there are, the
 * picture has at most ROWS threads and PARTS parts of time. */
#include "internal.h"

enum {
    ROWS = 32,
    PARTS = 600,
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

/* @return what was done most of the time in each part, as text: the first letter of its kind, a
 * capital where something long begins, and a dot where hardly anything was done. */
static json_t *strip_json(const thread_row *row, double part_s)
{
    char text[PARTS];

    for (int i = 0; i < PARTS; i++) {
        double sum = 0;
        int most = 0;

        for (int kind = 0; kind < SC_TRACE_KIND_COUNT; kind++) {
            sum += row->part_s[i][kind];
            most = row->part_s[i][kind] > row->part_s[i][most] ? kind : most;
        }
        text[i] = sum > 0.1 * part_s ? sc_trace_kind_name(most)[0] : '.';
        if (row->begins[i] && text[i] != '.')
            text[i] = (char)(text[i] - 'a' + 'A');
    }
    return json_stringn(text, PARTS);
}

/* @return the seconds that a thread spent on each kind of event. */
static json_t *seconds_json(const thread_row *row)
{
    json_t *json = json_object();

    for (int kind = 0; kind < SC_TRACE_KIND_COUNT; kind++)
        (void)json_object_set_new(json, sc_trace_kind_name(kind), json_real(row->kind_s[kind]));
    return json;
}

/* @return the rows of all threads that are shown, but for those that encode on a rank other than 0,
 * if they have nothing to do: rank 0 encodes alone. */
static json_t *rows_json(const activity *a)
{
    json_t *rows = json_array();
    int rank = 0;

    for (size_t i = 0; i < a->shown; i++) {
        const size_t thread = thread_of_row(a, i);
        int number, encodes;

        while (thread >= a->first[rank + 1])
            rank++;
        number = (int)(thread - a->first[rank]);
        encodes = number == a->stats->ranks[rank].threads;
        if (encodes && rank > 0 && !(a->rows[i].kind_s[SC_TRACE_ENCODE] > 0))
            continue;
        rows = sc_json_with(rows, json_pack("{s:i, s:o, s:o, s:o, s:o}", "rank", rank, "host",
                                            sc_json_text(a->stats->ranks[rank].host), "thread",
                                            encodes ? json_null() : json_integer(number), "seconds",
                                            seconds_json(&a->rows[i]), "strip",
                                            strip_json(&a->rows[i], a->part_s)));
    }
    return rows;
}

/* Number the threads, and allocate the rows. */
static sc_status allocate(const sc_ctx *ctx, activity *a)
{
    const sc_run_stats *stats = a->stats;

    SC_PASS(SC_ALLOC(ctx, (size_t)stats->run.ranks + 1, &a->first));
    a->first[0] = 0;
    for (int i = 0; i < stats->run.ranks; i++) /* one more: it encodes and writes */
        a->first[i + 1] = a->first[i] + (size_t)stats->ranks[i].threads + 1;
    a->threads = a->first[stats->run.ranks];
    a->shown = a->threads < ROWS ? a->threads : ROWS;
    return SC_ZALLOC(ctx, a->shown, &a->rows);
}

sc_status sc_report_activity(const sc_ctx *ctx, const char *path, const sc_run_stats *stats,
                             json_t *data)
{
    const sc_ctx looking = sc_quiet(ctx);
    activity a = {.stats = stats, .part_s = stats->run.wall_s / PARTS};
    const char *why = "The run has not ended, so there is no trace of it.";
    json_t *json;
    sc_status status = SC_OK;

    if (stats->run.ended && stats->run.wall_s > 0) {
        SC_TRY(allocate(ctx, &a));
        status = sc_trace_read(&looking, path, add_event, &a);
        why = status == SC_OK            ? NULL
              : status == SC_ERR_MISSING ? "The trace is missing."
                                         : "The trace is damaged.";
        if (status != SC_OK && !sc_is_of_input(status))
            goto out;
    }
    json =
        why ? json_string(why)
            : json_pack("{s:o, s:I, s:I, s:I}", "rows", rows_json(&a), "shown", (json_int_t)a.shown,
                        "threads", (json_int_t)a.threads, "events", (json_int_t)a.events);
    status = sc_json_set(ctx, data, "activity", json);
out:
    sc_free(a.first);
    sc_free(a.rows);
    return status;
}
