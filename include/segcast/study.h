/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The study of runs: timing records of a run, of its ranks and frames, what they say about it, and
 *  the files that hold them (stats.json, frames.csv, trace.json, status.json). Records are
 * collected in memory and written once, at the end of the run. */
#ifndef SEGCAST_STUDY_H
#define SEGCAST_STUDY_H

#include "segcast/farm.h"

/** What a rank spends its time on. */
typedef enum sc_phase {
    SC_PHASE_READ,    /**< reading the volume, or mapping the prepared file */
    SC_PHASE_PREPARE, /**< preprocessing */
    SC_PHASE_SHARE,   /**< copying the prepared volume to all nodes */
    SC_PHASE_RENDER,
    SC_PHASE_GATHER, /**< sending and receiving frames */
    SC_PHASE_ENCODE,
    SC_PHASE_WRITE,
    SC_PHASE_IDLE, /**< waiting for other ranks */
    SC_PHASE_COUNT
} sc_phase;

/** @return the key of a phase in stats.json, such as "render". Static text. */
const char *sc_phase_key(sc_phase phase);

/** What one rank spent on a phase. */
typedef struct sc_phase_time {
    double wall_s, cpu_s; /**< seconds; cpu_s: of all its threads together */
} sc_phase_time;

/** The timing record of a rank. A plain value, sent as bytes. */
typedef struct sc_rank_record {
    sc_phase_time phases[SC_PHASE_COUNT];
    uint64_t peak_rss_bytes;
    double cpu_s;             /**< CPU seconds of the whole process */
    double farm_idle_s;       /**< for how long its worker thread had no task */
    double accept_wall_s;     /**< rank 0: encoding and writing, beside the drawing; else 0 */
    int32_t threads;          /**< number of threads that draw */
    char host[SC_HOST_BYTES]; /**< name of its node, NUL-terminated */
} sc_rank_record;

/* ---- runs before this one ---- */

/** The hashes that stand for a job, as in the manifest. */
typedef struct sc_job_hashes {
    uint64_t job, volume;
} sc_job_hashes;

/** Longest texts of an sc_run_entry, terminator included. */
enum { SC_RUN_TEXT_BYTES = 128 };

/** One run on the job: an element of `runs` in stats.json. Texts that are unknown are empty. */
typedef struct sc_run_entry {
    uint64_t id;               /**< tells it from all others */
    bool ended;                /**< false: it was killed, or goes on still: see wall_s */
    char begin[32];            /**< "2026-11-21T19:44:38Z" */
    char host[SC_HOST_BYTES];  /**< host of rank 0 */
    int ranks, threads, nodes; /**< threads: of rank 0 */
    double wall_s, cpu_s;      /**< seconds; cpu_s: of all ranks together; 0 until it has ended */
    double farm_wall_s;        /**< see sc_run_record; 0 until it has ended */
    int frames;                /**< how many it drew; 0 until it has ended */
    /** The processor of rank 0, the kernel variant, the MPI library, the commit of segcast, and the
     * id of the batch job. */
    char processor[SC_RUN_TEXT_BYTES], kernel[SC_RUN_TEXT_BYTES], mpi[SC_RUN_TEXT_BYTES],
        commit[SC_RUN_TEXT_BYTES], batch_job[SC_RUN_TEXT_BYTES];
    char (*hosts)[SC_HOST_BYTES]; /**< [host_count], each once, in the order of ranks; owned */
    int host_count;
    int *rank_hosts; /**< [ranks], indices into hosts; owned. NULL: unknown */
    char *made_from; /**< see sc_run_record; owned. NULL: unknown */
} sc_run_entry;

/** A frame that an earlier run drew. */
typedef struct sc_past_frame {
    sc_frame_result result;
    int run;       /**< index into the runs; -1: unknown, because it wrote no statistics */
    bool measured; /**< false: only frame, rank, render_cpu_s and hash of result are known */
    bool is_new;   /**< used by sc_history_add */
} sc_past_frame;

/** Runs in the order of time as far as it is known, and their frames in rising order, each once.
 *  Zero-initialise; owns both arrays, and what the runs own: sc_history_clear. */
typedef struct sc_history {
    sc_run_entry *runs;
    int run_count;
    sc_past_frame *frames;
    int frame_count;
} sc_history;

/** Add what the stats.json under @p path says of earlier runs on the job @p job. Nothing is
 *  added if the file cannot be read, or if it is damaged, too large or of another job; in the
 * latter three cases a warning is logged. Runs that @p history has already are not added again; of
 * a frame that several runs drew the one of the run with the highest index stays. @return
 * SC_ERR_MEMORY, @p history untouched. */
SC_MUST_USE sc_status sc_history_read(const sc_ctx *ctx, const char *path, const sc_job_hashes *job,
                                      sc_history *history);
/** Add frames that are there, but of which no run has written what it measured: those of them that
 *  @p history does not hold yet. @param frames [count], of which only frame, rank, render_cpu_s and
 * hash are used. @param run index of the run that drew them, or -1. @return SC_ERR_MEMORY, @p
 * history untouched. */
SC_MUST_USE sc_status sc_history_add(const sc_ctx *ctx, sc_history *history,
                                     const sc_frame_result *frames, int count, int run);
/** As sc_history_read, of all files stats.SLICE.json in a directory, those of slices. */
SC_MUST_USE sc_status sc_history_read_slices(const sc_ctx *ctx, const char *directory,
                                             const sc_job_hashes *job, sc_history *history);
/** Free both arrays; the history is empty then. An empty one is allowed. */
void sc_history_clear(sc_history *history);

/* ---- heat pictures ---- */

/** The longer side of heat pictures, at most. */
enum { SC_HEAT_SIDE = 200 };
/** What a heat picture counts. */
typedef enum sc_heat_kind {
    SC_HEAT_SAMPLES,       /**< sc_march_counters.cell_visits */
    SC_HEAT_CONTRIBUTIONS, /**< sc_march_counters.contributions */
    SC_HEAT_KINDS
} sc_heat_kind;
/** The work of each pixel of a small picture of a frame. Zero-initialised there is none
 *  (width_px 0). */
typedef struct sc_heat {
    int frame, width_px, height_px;
    double cpu_s;                  /**< what it took to draw it */
    uint8_t *codes[SC_HEAT_KINDS]; /**< [height_px][width_px] each: sc_heat_code of the counts;
                                      owned: sc_heat_clear */
} sc_heat;
/** @return the code of a count: 0 of nothing, else its logarithm, exact to some 2 percent up to
 *  60000, and 255 above. */
uint8_t sc_heat_code(uint64_t count);
/** @return the count that a code stands for. */
double sc_heat_count(uint8_t code);
/** Make a heat picture without any work. @param width_px, height_px 1 to SC_HEAT_SIDE. @return
 *  SC_ERR_MEMORY. Caller owns *out: sc_heat_clear. */
SC_MUST_USE sc_status sc_heat_new(const sc_ctx *ctx, int width_px, int height_px, sc_heat *out);
/** Free what a heat picture owns; there is none then. Harmless on a zeroed struct. */
void sc_heat_clear(sc_heat *heat);

/* ---- this run ---- */

/** The program and the machine of a run. All texts are borrowed. */
typedef struct sc_run_platform {
    const char *version, *host; /**< version of segcast; host of rank 0 */
    /** The commit of segcast, the processor of rank 0, the kernel variant, the MPI library with its
     *  version; NULL: unknown. */
    const char *commit, *processor, *kernel, *mpi;
    const char *batch_job; /**< id of the batch job, or NULL */
} sc_run_platform;

/** The memory of a run, in bytes. */
typedef struct sc_run_memory {
    uint64_t volume, prepared; /**< of the volume, read and prepared */
    uint64_t derived;  /**< of what was derived from it for drawing, on the node of rank 0, which
                            holds it once if its ranks can share it */
    uint64_t renderer; /**< that rank 0 had for itself to draw */
} sc_run_memory;

/** A run as written to stats.json and frames.csv. All pointers are borrowed.
 *
 *  In both files `frames` are those of this run and of @p earlier, each with the index of its run
 * in `runs`; a frame that was drawn twice stands there once, with what this run measured. All other
 * keys of stats.json describe this run, which is the last one; for totals of all runs, add up the
 * entries of `runs`. */
typedef struct sc_run_record {
    sc_run_platform platform;
    const char *settings; /**< the keys of the job with their values as JSON; NULL: unknown */
    /** A JSON object: `command`, the command line without what names persons or places, and
     * `inputs`, an array of objects, each with `use` (a text), and where they are known `bytes`
     * and `sha256`. NULL: unknown. */
    const char *made_from;
    uint64_t id; /**< another one for each run */
    bool ended;  /**< false: the run is about to draw; then nothing is measured yet */
    sc_job_hashes job;
    int64_t begin_unix_s;      /**< when the run began, in seconds since 1970 (UTC) */
    const sc_history *earlier; /**< or NULL */
    int ranks, nodes;
    double wall_s;                      /**< seconds of the whole run */
    const sc_rank_record *rank_records; /**< [ranks], at least 1 */
    const sc_frame_result *frames;      /**< [frame_count], in rising order of frames */
    int frame_count;
    sc_run_memory memory;
    double farm_wall_s;  /**< rank 0's sc_farm_times.wall_s; 0 if nothing was to be drawn */
    const sc_heat *heat; /**< of one of its frames; NULL: there is none */
    bool wrote_png;      /**< frames were written as PNG */
    bool from_prepared;  /**< the volume was mapped from a prepared file, as it was */
} sc_run_record;

/** @return the times of a phase: on the clock those of the rank that took longest, of CPUs the sum
 *  over all ranks. */
sc_phase_time sc_run_phase(const sc_run_record *run, int phase);
/** @return the largest of the ranks' render times (wall) over their mean, minus 1: 0 is perfect
 *  balance, or nothing was drawn. */
double sc_run_imbalance(const sc_run_record *run);
/** Write stats.json under @p json, and then frames.csv under @p csv; each replaces an earlier file
 *  when it is complete. After an error with the first the second is not written.
 *  @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_run_write(const sc_ctx *ctx, const sc_run_record *run, const char *json,
                                   const char *csv);

/** The bottleneck of a run: what would have to be faster for the run to be faster. */
typedef enum sc_bottleneck {
    SC_BOTTLENECK_DRAW,
    SC_BOTTLENECK_PREPARE, /**< reading and preparing took longer than all frames */
    SC_BOTTLENECK_START,   /**< the same, with a volume that was prepared already */
    SC_BOTTLENECK_ENCODE,
    SC_BOTTLENECK_WRITE,
    SC_BOTTLENECK_GATHER,
    SC_BOTTLENECK_BALANCE, /**< some ranks had work while others waited */
    SC_BOTTLENECK_CORES    /**< threads that had work waited for a core or for each other */
} sc_bottleneck;
/** @return what limited @p run, judged by the shares of time in its records. */
sc_bottleneck sc_run_bottleneck(const sc_run_record *run);
/** @return the bottleneck and what can be done about it, as words that follow "limited by";
 * commands stand between backquotes. Static text. */
const char *sc_bottleneck_advice(sc_bottleneck bottleneck);
/** @return for which share of the farm's time, 0 to 1, worker threads had no task, averaged over
 *  ranks; 0 if the farm took no time. */
double sc_run_waiting(const sc_run_record *run);
/** Log a summary with sc_info: speed, time per phase, waiting, the slowest frames and ranks, and
 * the bottleneck with what can be done about it. Of a run that drew no frame, only speed and times.
 *  @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_run_summarise(const sc_ctx *ctx, const sc_run_record *run);

/* ---- stats.json, read back ---- */

/** What a stats.json holds. Zero-initialise; owns what its members point to: sc_run_stats_clear. */
typedef struct sc_run_stats {
    sc_history history;    /**< all runs, at least one, the last of which wrote the file; and the
                              frames    of all of them */
    sc_rank_record *ranks; /**< [run.ranks], of the last run */
    char version[SC_RUN_TEXT_BYTES];
    sc_run_record run;   /**< the last run, for sc_run_bottleneck and the like: job, ranks, nodes,
                              wall_s, farm_wall_s, ended, rank_records (which is `ranks`),
                              memory, wrote_png, from_prepared, frame_count, without `frames`; texts
                              and all else are empty, see `history` */
    sc_heat heat;        /**< of one of its frames, if there is one; owned */
    double frames_per_s; /**< of the last run */
    double mrays_per_cpu_s; /**< of the last run, while it drew */
} sc_run_stats;
/** Read the stats.json under @p path. @return SC_ERR_MISSING; SC_ERR_DATA if it is damaged, too
 *  large, or not of this version; both are logged. SC_ERR_MEMORY. Caller owns *out. */
SC_MUST_USE sc_status sc_run_stats_read(const sc_ctx *ctx, const char *path, sc_run_stats *out);
/** Free what @p stats owns; it is empty then. An empty one is allowed. */
void sc_run_stats_clear(sc_run_stats *stats);

/* ---- the trace: what each thread did when ---- */

/** What a thread did; SC_TRACE_FINISH: completing the outputs after the last frame. */
typedef enum sc_trace_kind {
    SC_TRACE_READ,
    SC_TRACE_PREPARE,
    SC_TRACE_SHARE,
    SC_TRACE_DRAW,
    SC_TRACE_ENCODE,
    SC_TRACE_FINISH,
    SC_TRACE_KIND_COUNT
} sc_trace_kind;

/** What a thread did from when to when. A plain value, sent as bytes. */
typedef struct sc_trace_event {
    double begin_s, duration_s; /**< begin: counted from sc_trace_new */
    int32_t frame;              /**< number of the frame it was done for, or -1 */
    int16_t kind, thread;       /**< an sc_trace_kind; number of the thread in its rank, from 0 */
} sc_trace_event;

/** The trace of one rank. */
typedef struct sc_trace sc_trace;
/** Begin a trace with room for @p capacity events. Its time begins now: ranks that call this right
 *  after having agreed on something (sc_comm_agree) have a common time. @return SC_ERR_MEMORY.
 * Caller owns *out: sc_trace_free. */
SC_MUST_USE sc_status sc_trace_new(const sc_ctx *ctx, size_t capacity, sc_trace **out);
/** Free a trace with its events. NULL is allowed. */
void sc_trace_free(sc_trace *trace);
/** Add an event, if there is room; otherwise it is only counted. Does not wait. @param frame or -1.
 *  @param begin_s, end_s by sc_wall_s. Threads: any, at any time. */
void sc_trace_add(sc_trace *trace, sc_trace_kind kind, int thread, int frame, double begin_s,
                  double end_s);
/** @return the number of events of sc_trace_events. */
size_t sc_trace_count(const sc_trace *trace);
/** @return how many events were not added because there was no room. */
size_t sc_trace_dropped(const sc_trace *trace);
/** @return the events in the order in which they were added, borrowed from @p trace. No thread may
 *  be adding one while they are read. */
const sc_trace_event *sc_trace_events(const sc_trace *trace);
/** Write the events of all ranks as Chrome trace events into the file @p path, which appears when
 *  it is complete. Those of rank i are the counts[i] events from events[i * stride] on; of
 *  @p records [ranks] host and threads are used. The threads of a rank are numbered from 0; number
 *  records[i].threads is the one that encodes and writes. In the file rank i is pid i + 1, its
 *  thread n tid n + 1.
 *  @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_trace_write(const sc_ctx *ctx, const char *path, int ranks,
                                     const sc_rank_record *records, const sc_trace_event *events,
                                     const size_t *counts, size_t stride);

/** Receives an event of rank @p rank, borrowed for the call. */
typedef void sc_trace_fn(void *user, int rank, const sc_trace_event *event);
/** Read a trace.json that sc_trace_write wrote, line by line, and call @p each for every event, in
 *  the order of the file. @return SC_ERR_MISSING; SC_ERR_DATA if a line is not what sc_trace_write
 *  writes; both are logged, and what came before was passed on. */
SC_MUST_USE sc_status sc_trace_read(const sc_ctx *ctx, const char *path, sc_trace_fn *each,
                                    void *user);
/** @return the name of a kind of event, such as "draw". Static text. */
const char *sc_trace_kind_name(sc_trace_kind kind);

/* ---- progress: how far a run is ---- */

/** How far a run is, as status.json has it. */
typedef struct sc_progress_report {
    const char *state; /**< "running", "complete", "incomplete" or "failed"; borrowed */
    const char *run;   /**< which run has written it last: the number of its batch job, or else host
                          and process; NULL: unknown; borrowed */
    const char *phase; /**< what the run is at, such as "reading"; NULL: it has ended; borrowed */
    double phase_share;  /**< how much of the phase is done, 0 to 1; -1: unknown */
    int done, total;     /**< frames, those of earlier runs included */
    double elapsed_s;    /**< since the run began */
    double frames_per_s; /**< those that were drawn in this run alone */
    double remaining_s;  /**< estimated, of the phase; 0 if unknown, or at the end */
} sc_progress_report;
/** Write @p report to @p path, that of a status.json, of which readers never see a part: see
 *  sc_file_write. @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_progress_write(const sc_ctx *ctx, const char *path,
                                        const sc_progress_report *report);

/* ---- provenance: where a film or a study comes from ---- */

/** What is known of a directory beside what its runs have measured. All texts are borrowed. */
typedef struct sc_crate {
    const sc_history *runs;          /**< whose frames are not used */
    sc_job_hashes job;               /**< volume: 0: there are many */
    const char *version;             /**< of segcast */
    const char *name, *about, *done; /**< such as "My heart", "A film of 9 frames, drawn", and what
                                        is done behind the frames of a run: "frames drawn" */
    const char *author; /**< empty: not given. Behind the last "; " stands the licence */
    const char *video;  /**< name of the video, or "none" */
    sc_text parts; /**< names of what segcast has made in the directory, each with a NUL byte behind
                        it; directories end in "/" */
    uint64_t video_bytes; /**< size of the finished video; 0: it is not there */
} sc_crate;
/** Make the text of an RO-Crate (1.1, of the profile Process Run Crate 0.5): the film, what it was
 * made from, by which program, and an action for each run. It names no person but the author, no
 * host, and nothing outside of the directory. The same statistics give the same bytes. @return
 * SC_ERR_MEMORY. Caller owns @p out: sc_text_clear. */
SC_MUST_USE sc_status sc_crate_make(const sc_ctx *ctx, const sc_crate *crate, sc_text *out);

#endif
