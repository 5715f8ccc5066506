/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The farm: work units are handed out to ranks, and what they draw is gathered on rank 0 with
 *  bounded memory. How a frame is drawn, and what becomes of a finished one, are callbacks.
 *
 *  A work unit is a whole GOP, which the rank also encodes, a frame, or a band of a frame. They go
 *  out in this order, from the coarsest to the finest, so that all ranks end at the same time.
 *
 *  With so many ranks that there is no GOP for each, and rank 0 alone cannot encode what they draw,
 *  GOPs are gathered: their frames are drawn anywhere and sent to one rank for each GOP, an
 *  encoder, which encodes it and sends the result to rank 0. */
#ifndef SEGCAST_FARM_H
#define SEGCAST_FARM_H

#include "segcast/comm.h"
#include "segcast/image.h"

/** The timing record of a frame, which travels with its pixels. */
typedef struct sc_frame_result {
    int32_t frame;
    int32_t rank;                       /**< the rank that drew it; of several the last one */
    double render_wall_s, render_cpu_s; /**< seconds of drawing it: of bands, their sum */
    double wait_s; /**< seconds that the worker thread had no task before it; of bands, their sum */
    uint64_t rays, samples, contributions; /**< numbers of them: of bands, their sums */
    uint64_t hash;                         /**< sc_image_hash of the whole frame */
} sc_frame_result;

/** How frames are shared out. */
typedef enum sc_partition {
    SC_PARTITION_AUTO,   /**< whole frames; the last ones, or all that are too large, in bands */
    SC_PARTITION_FRAMES, /**< whole frames only */
    SC_PARTITION_TILES   /**< each frame in bands, over all ranks */
} sc_partition;

/* ---- the hand-out: a pure state machine, without messages ---- */

/** The kinds of work units. */
typedef enum sc_work_unit_kind {
    SC_UNIT_NONE,  /**< there is no more work: the rank leaves the farm */
    SC_UNIT_GOP,   /**< a whole GOP; `index` counts in sc_farm.gops */
    SC_UNIT_FRAME, /**< a frame; `index` counts in sc_farm.frames */
    SC_UNIT_BAND   /**< rows [row, row + rows) of the frame at `index` in sc_farm.frames */
} sc_work_unit_kind;

/** A work unit: what a rank is given to draw. A plain value, sent as bytes. For a whole frame row
 * is 0 and rows the height; a GOP has neither.
 *
 *  A frame or band with an encoder belongs to a gathered GOP, and its pixels go to that rank: then
 *  `index` counts all frames of gathered GOPs in the order in which they go out. */
typedef struct sc_work_unit {
    int32_t kind, index, row, rows;
    int32_t encoder; /**< 0: there is none, and the frame goes to rank 0 */
    int32_t gop;     /**< with an encoder: index in sc_farm.gops */
    int32_t place;   /**< with an encoder: which frame of the GOP it is, from 0 */
} sc_work_unit;

/** What there is to do: numbers of ranks, of whole GOPs, and of frames to be drawn one by one. */
typedef struct sc_work {
    int ranks, gops, frames;
    int gathered;      /**< number of GOPs that are gathered; not counted in gops and frames */
    int gop_frames;    /**< of a gathered GOP; all have the same number */
    int encoders_most; /**< so many GOPs are gathered at a time at most; 0: there is no limit */
    int width_px, height_px;
    bool alpha; /**< pixels have four bytes */
    sc_partition partition;
} sc_work;

/** Gathered GOPs of which an encoder each has one at a time. */
typedef struct sc_gop_group {
    int first, gops; /**< its first GOP (from 0) and number of GOPs */
    int first_frame; /**< index of it */
    bool is_odd;     /**< it is the first, third, fifth and so on */
} sc_gop_group;

/** State of the hand-out. Frames go out in order. Rank 0 accepts them in order, so it has to hold
 *  those that are finished too early; that memory is bounded by the window: only the first
 *  `window` frames that are not yet accepted may be out or waiting. GOPs do not count, because they
 *  are accepted in any order.
 *
 *  Gathered GOPs go out in groups, each with an encoder of its own for every GOP: the first frames
 *  of all, then the second ones, and so on. So the encoders work side by side, each at its own
 * pace, and end soon after the last frame. They take frames in order, too, with a window of their
 * own. */
typedef struct sc_handout {
    sc_work work;
    int window;     /**< size of the window in frames */
    int split_from; /**< frames from this index on go out in bands */
    int band_rows;  /**< height of all bands but a frame's last one, which may be lower */
    int next_gop, next_frame, next_row; /**< what goes out next; next_row: row of next_frame */
    int accepted; /**< frames accepted so far, in order; the caller counts it up */
    int out;      /**< work units handed out and not yet back */
    bool stopped; /**< the caller sets it to end: no more GOPs and frames are begun */
    /* gathered GOPs */
    int encoders; /**< wanted for the next group; the caller may change it as it learns of costs */
    sc_gop_group group; /**< whose frames are being handed out */
    /** The largest window of gathered frames, and the smallest, if there are few encoders. */
    int gather_window, gather_window_least;
    int gather_split_from;                /**< gathered frames from this index on go out in bands */
    int next_gathered, next_gathered_row; /**< first gathered frame, and its first row, that are
                                               not handed out yet */
    int taken; /**< frames that encoders have taken so far, in order; the caller counts it up */
} sc_handout;

/** @return the state in which nothing of @p work has been handed out. */
sc_handout sc_handout_begin(const sc_work *work);
/** What sc_handout_next answers. */
typedef enum sc_handout_answer {
    SC_HANDOUT_UNIT, /**< a work unit went out */
    SC_HANDOUT_WAIT, /**< the window is full: ask again when another frame has been accepted */
    SC_HANDOUT_END   /**< nothing more will go out */
} sc_handout_answer;
/** Hand out the next work unit; @p out is written only with SC_HANDOUT_UNIT. After a stop the
 *  remaining bands of a frame of which some went out still follow, so that it becomes whole. */
sc_handout_answer sc_handout_next(sc_handout *handout, sc_work_unit *out);
/** Count a work unit that has come back, whichever it was, also one that could not be drawn. Frames
 *  count as accepted only when the caller adds them to handout->accepted. */
void sc_handout_unit_done(sc_handout *handout);
/** @return whether no work unit is out and nothing more will go out. */
bool sc_handout_finished(const sc_handout *handout);
/** @return whether the next work unit is of a gathered GOP, if one goes out at all. */
bool sc_handout_gathers_next(const sc_handout *handout);
/** How many encoders are wanted of @p ranks ranks: some more than could just keep up with what is
 *  drawn. @param draw_s wall seconds of a rank for drawing a frame in the mean. @param encode_s of
 *  an encoder for encoding one. Either is 0 if it is not known yet. @return at least 1. */
int sc_handout_encoders(int ranks, double draw_s, double encode_s);
/** @return how many of @p gops whole GOPs are to be gathered, counted from the last: none if
 *  sc_handout_gops finds enough of them for all ranks, or with few ranks, unless @p always; and all
 *  but the first otherwise: that one is encoded by rank 0, which learns the cost of a frame so. */
int sc_handout_gathered(int gops, int ranks, bool always);
/** The most work units that a rank has at a time, requested ones included: one that is drawn, and
 *  one that follows it without a gap. */
enum { SC_UNITS_PER_RANK = 2 };
/** With more frames that wait to be encoded than this, an encoder asks for no work. */
enum { SC_ENCODER_BEHIND = 2 };
/** When a rank asks for the work unit that is to follow the one that it draws: shortly before that
 *  ends, judged by the unit before it. @param rows of the unit that is drawn, as a measure of its
 *  cost. @param row_s wall seconds of a row of the unit before; 0: there was none, so that nothing
 *  is known. @return how long the unit has to be drawn before: at least 0, or infinity if the next
 *  one should be asked for only when this one has ended. */
double sc_handout_ask_age_s(double rows, double row_s);
/** How many of @p gops whole GOPs are to be drawn and encoded by one rank each. The last few go out
 *  as frames instead, so that all ranks end at the same time. With few ranks, or few GOPs for each,
 *  none are (rank 0 alone can encode fast enough), unless @p always. */
int sc_handout_gops(int gops, int ranks, bool always);

/* ---- the farm ---- */

/** Where the time of this rank went, in seconds. */
typedef struct sc_farm_times {
    double render_wall_s, render_cpu_s; /**< what draw and draw_gop have put into their results */
    /** Of the main thread, which passes messages: wall time of the turns in which there was
     *  something to do, CPU time of all turns. */
    double gather_wall_s, gather_cpu_s;
    double accept_wall_s; /**< rank 0: time spent in accept_frame and accept_gop */
    double idle_s;        /**< how long the worker thread that draws had no task */
    double wall_s;        /**< time from the beginning to the end of sc_farm_run */
} sc_farm_times;

/** A finished GOP as bytes. The farm carries them unread from draw_gop to accept_gop, which agree
 * on their layout. */
typedef struct sc_payload {
    void *data; /**< from sc_alloc */
    size_t bytes;
} sc_payload;

/** The callbacks of a farm. */
typedef struct sc_farm_calls {
    /** Draw rows [row, row + rows) of frame @p frame into @p image, which is that of the whole
     *  frame and whose other rows hold anything. @p result has frame and wait_s and is zero
     *  otherwise; times and numbers are for draw to fill, rank and hash for the farm. After an
     *  error the frame is neither hashed nor accepted, and the farm ends with that
     *  error on all ranks. Threads: a worker thread of any rank, one call at a time on each. */
    sc_status (*draw)(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result);
    /** Draw @p count frames from number @p first on and encode them. Fills @p results [count],
     *  frames and hashes included; they are zero before, but for the first one's wait_s. Puts bytes
     *  into @p out, whose memory the farm takes ownership of, or leaves it empty if it fails or
     *  gives up, which it may do after a stop. Errors and threads as with draw. */
    sc_status (*draw_gop)(void *user, int first, int count, sc_frame_result *results,
                          sc_payload *out);
    /** Encode the next frame of a gathered GOP of @p count frames from number @p first on. They
     * come in order; the first one begins the GOP, in place of one that was not finished. With the
     * last one, puts bytes into @p out as draw_gop does. After an error no more is encoded on this
     * rank, and the farm ends with it. Threads: a worker thread of any rank but 0, beside that of
     * draw, one call at a time on each. NULL if nothing is gathered. */
    sc_status (*encode_frame)(void *user, int first, int count, const sc_frame_result *result,
                              const sc_image *image, sc_payload *out);
    /** Accept a finished frame, in the order of sc_farm.frames; after a stop also frames of
     * gathered GOPs that could not be finished, in any order. After an error nothing more is
     * accepted, and the farm ends with it. Threads: on rank 0, a worker thread of its own, never at
     * the same time as accept_gop. */
    sc_status (*accept_frame)(void *user, const sc_frame_result *result, const sc_image *image);
    /** Accept a finished GOP, in any order; otherwise as accept_frame. */
    sc_status (*accept_gop)(void *user, const sc_frame_result *results, int count,
                            const sc_payload *payload);
    /** Called on rank 0's main thread several times a second, with the numbers of frames that are
     *  accepted and that this farm has, those of GOPs included. NULL is allowed. */
    void (*on_progress)(void *user, int done, int total);
    void *user; /**< the first argument of all */
} sc_farm_calls;

/** What to draw, and what to call. The same on all ranks, pointers apart. */
typedef struct sc_farm {
    int width_px, height_px;
    bool alpha; /**< frames are pictures with alpha: see sc_image */
    sc_partition partition;
    const int *frames; /**< numbers of the frames to draw one by one, rising */
    int frame_count;
    const int *gops; /**< numbers of the first frames of the GOPs to draw whole, rising */
    int gop_count;
    bool gather; /**< GOPs are gathered (all have gop_frames frames); not with a single rank */
    int encoders_most; /**< so many GOPs are gathered at a time at most; 0: there is no limit */
    int gop_frames;    /**< length of a GOP; the last one of the animation may be shorter */
    int total_frames;  /**< length of the animation */
    bool share_frames; /**< ranks on rank 0's node draw into its memory, if there is room */
    bool spoils_other_rows; /**< draw may write to rows that it was not asked for */
    /** Not NULL. Once it is not 0 on any rank, no more is handed out. Signal handlers and any
     *  thread may set it; it stays borrowed. */
    const atomic_int *stop;
    /** Rank 0: end before this time of sc_wall_s, judged by the measured cost of work units; 0: no
     *  limit. */
    double deadline_s;
    sc_farm_calls calls;
} sc_farm;

/** Memory that a farm holds for frames and messages, in bytes. */
typedef struct sc_farm_memory {
    size_t window; /**< the window of rank 0, in memory that its node shares or its own */
    size_t root;   /**< what rank 0 holds beside the window */
    size_t worker; /**< what every other rank holds */
    /** What each encoder of gathered GOPs holds beside that, if there are as many as the hand-out
     *  begins with. All together they hold a GOP each, and the frames of one more window. */
    size_t encoder;
} sc_farm_memory;
/** @return what sc_farm_run will hold at most with @p ranks ranks, finished GOPs left out. Of
 *  @p farm no callback is called and no array read. */
sc_farm_memory sc_farm_memory_of(const sc_farm *farm, int ranks);

/** Draw everything; blocks until all is accepted or the farm has stopped. Collective. @param times
 *  receives those of this rank. @return the same on all ranks: SC_OK, SC_ERR_INCOMPLETE after a
 *  stop (what was out has been accepted), SC_ERR_MEMORY, or the error of a callback. */
SC_MUST_USE sc_status sc_farm_run(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                                  sc_farm_times *times);

#endif
