/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 6: work handed out to ranks and gathered on rank 0 with bounded memory. What a frame is,
 *  and what happens to it when it is done, are callbacks.
 *
 *  Units are whole groups of frames, which a rank also encodes, frames, or bands of a frame; those
 *  come in that order, so that ranks end together. */
#ifndef SEGCAST_FARM_H
#define SEGCAST_FARM_H

#include "segcast/comm.h"
#include "segcast/image.h"

#include <signal.h>

/** What is known of a drawn frame; travels with its pixels. */
typedef struct sc_frame_result {
    int32_t frame, rank; /**< the rank that drew it, or the last part of it */
    double render_wall_s, render_cpu_s;
    double wait_s; /**< the rank was idle before it began */
    uint64_t rays, samples, contributions;
    uint64_t hash; /**< sc_image_hash */
} sc_frame_result;

/** How frames are shared out. */
typedef enum sc_partition {
    SC_PARTITION_AUTO, /**< frames; the last ones, or all that are too large, in bands */
    SC_PARTITION_FRAMES,
    SC_PARTITION_TILES /**< every frame over all ranks */
} sc_partition;

/* ---- hand-out: pure, no messages ---- */

typedef enum sc_unit_kind {
    SC_UNIT_NONE,  /**< nothing, now or ever: see sc_handout_next */
    SC_UNIT_GROUP, /**< `index`: of the group */
    SC_UNIT_FRAME, /**< `index`: into the frames */
    SC_UNIT_BAND   /**< the same, only rows [row, row + rows) */
} sc_unit_kind;

/** A piece of work. A value, sent as bytes. */
typedef struct sc_unit {
    int32_t kind, index, row, rows;
} sc_unit;

/** What there is to do. */
typedef struct sc_work {
    int ranks, groups, frames;
    int width_px, height_px;
    sc_partition partition;
} sc_work;

/** Which unit goes out next: groups, then frames in order, of which at most `window` beyond the
 *  next one to be taken are out or waiting, which bounds what rank 0 has to hold. */
typedef struct sc_handout {
    int groups, frames, height_px;
    int window;     /**< frames */
    int split_from; /**< frames from this one on go out in bands */
    int band_rows;
    int next_group, next_frame, next_row;
    int taken;    /**< frames taken in order so far */
    int out;      /**< units handed out and not yet back */
    bool stopped; /**< begin no more groups and frames */
} sc_handout;

/** @return the plan for @p work, nothing handed out. */
sc_handout sc_handout_begin(const sc_work *work);
typedef enum sc_handout_answer {
    SC_HANDOUT_UNIT,
    SC_HANDOUT_WAIT, /**< the window is full */
    SC_HANDOUT_END
} sc_handout_answer;
/** The next unit, into @p out. A frame that has been begun goes out whole, stopped or not. */
sc_handout_answer sc_handout_next(sc_handout *handout, sc_unit *out);
/** A unit has come back. */
void sc_handout_back(sc_handout *handout);
/** Nothing is out, and nothing will go out. */
bool sc_handout_finished(const sc_handout *handout);
/** Of @p groups groups that ranks could encode, how many they are to: all but the last few, which
 *  go out as frames so that ranks end together; none, unless @p always, if there are few ranks or
 *  few groups for each. */
int sc_handout_groups(int groups, int ranks, bool always);

/* ---- the farm ---- */

/** Time of this rank in the farm. */
typedef struct sc_farm_times {
    double render_wall_s, render_cpu_s;
    double gather_wall_s, gather_cpu_s; /**< rank 0: receiving; others: sending */
    double take_wall_s; /**< rank 0: in the take callbacks, on a thread of its own */
    double idle_s;      /**< waiting for work */
    double wall_s;      /**< of the whole farm */
} sc_farm_times;

/** A finished group as bytes: what they mean is between the callbacks. */
typedef struct sc_payload {
    void *data; /**< of sc_alloc */
    size_t bytes;
} sc_payload;

typedef struct sc_farm {
    int width_px, height_px;
    sc_partition partition;
    const int *frames; /**< frame numbers in rising order; the same on all ranks */
    int frame_count;
    const int *groups; /**< first frames of the groups that ranks do whole */
    int group_count;
    int group_frames; /**< of a group; the last one of `total` frames may be shorter */
    int total;
    /** Draw rows [row, row + rows) of a frame; any rank, one call at a time per rank, from a thread
     *  of its own. After an error the frame is neither hashed nor taken, and the farm ends. */
    sc_status (*draw)(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result);
    bool share_frames;      /**< ranks on rank 0's node draw into its memory, if there is room */
    bool spoils_other_rows; /**< draw may write to rows that it was not asked for */
    /** Draw @p count frames from @p first on, and make of them what rank 0 is to take; threads as
     *  draw. An empty payload gives the group up, because of a stop. */
    sc_status (*draw_group)(void *user, int first, int count, sc_frame_result *results,
                            sc_payload *out);
    /** Take a finished frame; rank 0, on a thread of its own, in the order of `frames`, never at
     *  the same time as take_group. An error stops. */
    sc_status (*take)(void *user, const sc_frame_result *result, const sc_image *image);
    /** Take a finished group, in any order. */
    sc_status (*take_group)(void *user, const sc_frame_result *results, int count,
                            const sc_payload *payload);
    /** Rank 0, main thread, several times a second. NULL is allowed. */
    void (*tick)(void *user, int done, int total);
    /** Set by signal handlers: hand out no more. On any rank. */
    const volatile sig_atomic_t *stop;
    /** Rank 0: be done at this time of sc_wall_s, by the measured cost of units; 0: whenever. */
    double deadline_s;
    void *user;
} sc_farm;

/** Run the farm. Collective. @return on all ranks the same: SC_OK, SC_ERR_INCOMPLETE after a stop
 *  (what was in flight has been taken), or the error of a callback. */
SC_MUST_USE sc_status sc_farm_run(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                                  sc_farm_times *times);

#endif
