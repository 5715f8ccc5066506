/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 7: timing records of a run and the files that hold them. Collected in memory, written
 *  once. */
#ifndef SEGCAST_STUDY_H
#define SEGCAST_STUDY_H

#include "segcast/farm.h"

typedef enum sc_phase {
    SC_PHASE_READ,
    SC_PHASE_PREPARE,
    SC_PHASE_SHARE,
    SC_PHASE_RENDER,
    SC_PHASE_GATHER,
    SC_PHASE_ENCODE,
    SC_PHASE_WRITE,
    SC_PHASE_IDLE,
    SC_PHASE_COUNT
} sc_phase;

typedef struct sc_phase_time {
    double wall_s, cpu_s;
} sc_phase_time;

/** What one rank reports. A value, sent as bytes. */
typedef struct sc_rank_record {
    sc_phase_time phases[SC_PHASE_COUNT];
    uint64_t peak_rss_bytes;
    double cpu_s;
    double farm_idle_s;   /**< its drawing thread waited for work */
    double accept_wall_s; /**< rank 0: encoding and writing beside the drawing */
    int32_t threads;
    char host[64];
} sc_rank_record;

/* ---- runs before this one ---- */

/** What a job is told apart by: as in the manifest. */
typedef struct sc_job_hashes {
    uint64_t job, volume;
} sc_job_hashes;

/** One run on the job: an element of `runs` in stats.json. */
typedef struct sc_run_entry {
    char begin[32]; /**< "2026-11-21T19:44:38Z" */
    char host[64];  /**< of rank 0 */
    int ranks, threads, nodes;
    double wall_s, cpu_s;
    int frames; /**< that it drew */
} sc_run_entry;

/** A frame that an earlier run drew. */
typedef struct sc_past_frame {
    sc_frame_result result;
    int run; /**< index into the runs */
} sc_past_frame;

/** Runs in the order of time as far as it is known, and their frames in rising order, each once.
 *  Zero-initialise; owns both arrays: sc_history_clear. */
typedef struct sc_history {
    sc_run_entry *runs;
    int run_count;
    sc_past_frame *frames;
    int frame_count;
} sc_history;

/** Add what the stats.json under @p path says of earlier runs on the job @p job. A file that is not
 *  there adds nothing; one that is damaged or of another job adds nothing and gives a warning. Runs
 *  that @p history has already are not added again. @return SC_ERR_MEMORY, @p history untouched. */
SC_MUST_USE sc_status sc_history_read(const sc_ctx *ctx, const char *path, const sc_job_hashes *job,
                                      sc_history *history);
void sc_history_clear(sc_history *history);

/* ---- this run ---- */

/** A run as written to stats.json and frames.csv. All pointers are borrowed.
 *
 *  In both files `frames` are those of this run and of @p earlier, each with the index of its run
 * in `runs`; a frame that was drawn twice stands there once, with what this run measured. Frames of
 *  runs that were killed are missing: these wrote no file. All other keys of stats.json are of this
 *  run, the last one: sums over all runs can be had from `runs`. */
typedef struct sc_run_record {
    const char *version, *host;
    sc_job_hashes job;
    int64_t begin_unix_s;
    const sc_history *earlier; /**< or NULL */
    int ranks, nodes;
    double wall_s;
    const sc_rank_record *rank_records; /**< [ranks] */
    const sc_frame_result *frames;      /**< [frame_count], in rising order of frames */
    int frame_count;
    uint64_t volume_bytes, prepared_bytes;
    double farm_wall_s; /**< from the first unit to the last */
    bool wrote_png;
} sc_run_record;

/** Largest over mean of the ranks' render time, minus 1: 0 is perfect balance. */
double sc_run_imbalance(const sc_run_record *run);
/** Write stats.json and frames.csv under the given paths. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_run_write(const sc_ctx *ctx, const sc_run_record *run, const char *json,
                                   const char *csv);

/** What a run could have been faster but for. */
typedef enum sc_limit {
    SC_LIMIT_DRAW,
    SC_LIMIT_PREPARE,
    SC_LIMIT_ENCODE,
    SC_LIMIT_WRITE,
    SC_LIMIT_GATHER,
    SC_LIMIT_BALANCE
} sc_limit;
sc_limit sc_run_limit(const sc_run_record *run);
/** Log a summary: speed, phases, waiting, slowest frames and ranks, the limit and its remedy. */
SC_MUST_USE sc_status sc_run_summarise(const sc_ctx *ctx, const sc_run_record *run);

/* ---- what each thread did when ---- */

typedef enum sc_trace_kind {
    SC_TRACE_READ,
    SC_TRACE_PREPARE,
    SC_TRACE_SHARE,
    SC_TRACE_DRAW,
    SC_TRACE_ENCODE,
    SC_TRACE_WRITE,
    SC_TRACE_FINISH
} sc_trace_kind;

/** A value, sent as bytes. */
typedef struct sc_trace_event {
    double begin_s, duration_s; /**< since sc_trace_new */
    int32_t frame;              /**< or -1 */
    int16_t kind, thread;
} sc_trace_event;

/** Events of one rank, of which at most @p capacity are kept. Its zero is now: ranks that make it
 *  right after having agreed on something have a common time. Caller owns: sc_trace_free. */
typedef struct sc_trace sc_trace;
SC_MUST_USE sc_status sc_trace_new(const sc_ctx *ctx, size_t capacity, sc_trace **out);
void sc_trace_free(sc_trace *trace);
/** Times by sc_wall_s. Threads: any. */
void sc_trace_add(sc_trace *trace, sc_trace_kind kind, int thread, int frame, double begin_s,
                  double end_s);
size_t sc_trace_count(const sc_trace *trace);
size_t sc_trace_dropped(const sc_trace *trace);
const sc_trace_event *sc_trace_events(const sc_trace *trace);
/** Write the events of all ranks: rank i's counts[i] at events + i * stride. Threads of a rank are
 *  numbered from 0; number record->threads is rank 0's encoding. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_trace_write(const sc_ctx *ctx, const char *path, int ranks,
                                     const sc_rank_record *records, const sc_trace_event *events,
                                     const size_t *counts, size_t stride);

/* ---- how far a run is ---- */

/** Rewrite status.json under @p path by rename. */
typedef struct sc_status_report {
    const char *state; /**< "running", "complete", "incomplete", "failed" */
    int done, total;
    double elapsed_s, frames_per_s, remaining_s;
} sc_status_report;
SC_MUST_USE sc_status sc_status_write(const sc_ctx *ctx, const char *path,
                                      const sc_status_report *report);

#endif
