/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 6: frames handed out to ranks, gathered in order on rank 0 with bounded memory; the
 *  manifest and status files that tell what is done. What a frame is, and what happens to it when
 *  it is done, are callbacks. */
#ifndef SEGCAST_FARM_H
#define SEGCAST_FARM_H

#include "segcast/comm.h"
#include "segcast/image.h"

#include <signal.h>

/** What is known of a drawn frame; travels with its pixels. */
typedef struct sc_frame_result {
    int32_t frame, rank;
    double render_wall_s, render_cpu_s;
    double wait_s; /**< the rank was idle before it began */
    uint64_t rays, samples, contributions;
    uint64_t hash; /**< sc_image_hash */
} sc_frame_result;

/* ---- hand-out: pure, no messages ---- */

/** Which unit goes out next. Units are taken in order; at most `window` units beyond the next one
 *  to be taken are out or waiting, which bounds what rank 0 has to hold. */
typedef struct sc_handout {
    int total, window;
    int next;     /**< next unit to hand out */
    int taken;    /**< units taken in order so far */
    int out;      /**< handed out and not yet back */
    bool stopped; /**< hand out no more */
} sc_handout;

enum { SC_HANDOUT_WAIT = -1, SC_HANDOUT_END = -2 };
/** The next unit, or SC_HANDOUT_WAIT (window full), or SC_HANDOUT_END. */
int sc_handout_next(sc_handout *handout);
/** A unit has come back. */
void sc_handout_back(sc_handout *handout);
/** Nothing is out, and nothing will go out. */
bool sc_handout_finished(const sc_handout *handout);
/** Units in the window for @p ranks ranks with frames of @p frame_bytes. */
int sc_handout_window(int ranks, size_t frame_bytes);

/* ---- the farm ---- */

/** Time of this rank in the farm. */
typedef struct sc_farm_times {
    double render_wall_s, render_cpu_s;
    double gather_wall_s, gather_cpu_s; /**< rank 0: receiving; others: sending */
    double take_wall_s;                 /**< rank 0: in the take callback */
    double idle_s;                      /**< waiting for work */
} sc_farm_times;

typedef struct sc_farm {
    int width_px, height_px;
    const int *frames; /**< frame numbers in rising order; the same on all ranks */
    int frame_count;
    /** Draw a frame; any rank, one call at a time per rank, from a thread of its own. */
    void (*draw)(void *user, int frame, sc_image *image, sc_frame_result *result);
    /** Take a finished frame; rank 0, main thread, in the order of `frames`. An error stops. */
    sc_status (*take)(void *user, const sc_frame_result *result, const sc_image *image);
    /** Rank 0, main thread, several times a second. NULL is allowed. */
    void (*tick)(void *user, int taken, int total);
    /** Set by signal handlers: hand out no more. On any rank. */
    const volatile sig_atomic_t *stop;
    void *user;
} sc_farm;

/** Run the farm. Collective. @return on all ranks the same: SC_OK, SC_ERR_INCOMPLETE after a stop
 *  (what was in flight has been taken), or the error of take. */
SC_MUST_USE sc_status sc_farm_run(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                                  sc_farm_times *times);

/* ---- what is done, on disk; rank 0 only ---- */

typedef struct sc_manifest sc_manifest;

/** First line of manifest.jsonl. */
typedef struct sc_manifest_head {
    const char *version;
    uint64_t job_hash, volume_hash;
    int frames, width_px, height_px;
} sc_manifest_head;

/** Begin @p directory/manifest.jsonl anew. @return SC_ERR_CREATE, SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_manifest_open(const sc_ctx *ctx, const char *directory,
                                       const sc_manifest_head *head, sc_manifest **out);
/** Add a line for a finished frame; it is on its way to the disk when this returns. */
SC_MUST_USE sc_status sc_manifest_add(const sc_ctx *ctx, sc_manifest *manifest,
                                      const sc_frame_result *result);
void sc_manifest_close(sc_manifest *manifest);

/** Rewrite @p directory/status.json by rename. */
typedef struct sc_status_report {
    const char *state; /**< "running", "complete", "incomplete", "failed" */
    int done, total;
    double elapsed_s, frames_per_s, remaining_s;
} sc_status_report;
SC_MUST_USE sc_status sc_status_write(const sc_ctx *ctx, const char *directory,
                                      const sc_status_report *report);

#endif
