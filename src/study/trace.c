/* SPDX-License-Identifier: BSD-3-Clause */
/* What each thread of each rank did when, written as Chrome trace events, which chrome://tracing,
 * Perfetto and others show. (Format: "Trace Event Format", Google, 2016; complete events, "ph":
 * "X", with times in microseconds.) */
#include "segcast/study.h"

#include <jansson.h>
#include <stdlib.h>

struct sc_trace {
    double zero_s;          /* by sc_wall_s */
    sc_trace_event *events; /* [capacity], owned */
    size_t capacity;
    atomic_size_t added; /* number of events added so far, those without room included */
};

const char *sc_trace_kind_name(sc_trace_kind kind)
{
    static const char *const names[] = {
        [SC_TRACE_READ] = "read", [SC_TRACE_PREPARE] = "prepare", [SC_TRACE_SHARE] = "share",
        [SC_TRACE_DRAW] = "draw", [SC_TRACE_ENCODE] = "encode",   [SC_TRACE_FINISH] = "finish"};

    return names[kind];
}

sc_status sc_trace_new(const sc_ctx *ctx, size_t capacity, sc_trace **out)
{
    SC_OWN(sc_free_at) sc_trace *trace = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &trace));
    SC_PASS(SC_ALLOC(ctx, capacity, &trace->events));
    trace->zero_s = sc_wall_s();
    trace->capacity = capacity;
    atomic_init(&trace->added, 0);
    SC_HAND_OVER(trace, out);
    return SC_OK;
}

void sc_trace_free(sc_trace *trace)
{
    if (!trace)
        return;
    sc_free(trace->events);
    sc_free(trace);
}

void sc_trace_add(sc_trace *trace, sc_trace_kind kind, int thread, int frame, double begin_s,
                  double end_s)
{
    const size_t at = atomic_fetch_add(&trace->added, 1);

    if (at < trace->capacity)
        trace->events[at] = (sc_trace_event){begin_s - trace->zero_s, end_s - begin_s, frame,
                                             (int16_t)kind, (int16_t)thread};
}

size_t sc_trace_count(const sc_trace *trace)
{
    const size_t added = atomic_load(&trace->added);

    return added < trace->capacity ? added : trace->capacity;
}

const sc_trace_event *sc_trace_events(const sc_trace *trace)
{
    return trace->events;
}

size_t sc_trace_dropped(const sc_trace *trace)
{
    return atomic_load(&trace->added) - sc_trace_count(trace);
}

/* Both write elements of the array of trace events to @p stream, each after the first with a comma
 * before it. Errors of the stream are found when the file is committed. Ranks and threads are
 * numbered from 0, the pid and tid that stand for them in the file from 1: viewers take 0 for the
 * idle task, and hide it.
 *
 * Write the name of a thread. @param encoder the number of the one that encodes and writes. */
static void name_thread(FILE *stream, int rank, int thread, int encoder)
{
    char name[32];

    snprintf(name, sizeof name, "thread %d", thread);
    fprintf(stream,
            ",\n{\"ph\":\"M\",\"pid\":%d,\"tid\":%d,\"name\":\"thread_name\",\"args\":{\"name\":\"%"
            "s\"}}",
            rank + 1, thread + 1, thread == encoder ? "encode, write" : name);
}

/* Write the names of a rank and of its threads, and its events. */
static void write_rank(FILE *stream, int rank, const sc_rank_record *record,
                       const sc_trace_event *events, size_t count)
{
    json_t *host = json_string(record->host);
    char *quoted = host ? json_dumps(host, JSON_ENCODE_ANY) : NULL;

    fprintf(stream,
            "%s{\"ph\":\"M\",\"pid\":%d,\"name\":\"process_name\",\"args\":{\"name\":\"rank "
            "%d\",\"host\":%s}}",
            rank ? ",\n" : "", rank + 1, rank, quoted ? quoted : "\"\"");
    for (int thread = 0; thread <= record->threads; thread++)
        name_thread(stream, rank, thread, record->threads);
    for (size_t i = 0; i < count; i++) {
        const sc_trace_event *e = &events[i];

        fprintf(stream,
                ",\n{\"ph\":\"X\",\"pid\":%d,\"tid\":%d,\"ts\":%.1f,\"dur\":%.1f,\"name\":\"%s",
                rank + 1, e->thread + 1, 1e6 * e->begin_s, 1e6 * e->duration_s,
                sc_trace_kind_name(e->kind));
        if (e->frame >= 0)
            fprintf(stream, " %d\",\"args\":{\"frame\":%d}}", e->frame, e->frame);
        else
            fprintf(stream, "\"}");
    }
    free(quoted);
    json_decref(host);
}

sc_status sc_trace_write(const sc_ctx *ctx, const char *path, int ranks,
                         const sc_rank_record *records, const sc_trace_event *events,
                         const size_t *counts, size_t stride)
{
    sc_outfile file = {0};

    SC_PASS(sc_outfile_open(ctx, path, true, &file));
    fprintf(file.stream, "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n");
    for (int rank = 0; rank < ranks; rank++)
        write_rank(file.stream, rank, &records[rank], events + (size_t)rank * stride, counts[rank]);
    fprintf(file.stream, "\n]}\n");
    return sc_outfile_commit(ctx, &file);
}
