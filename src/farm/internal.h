/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to farm: messages, worker threads, drawing tasks, and the roles of a rank. */
#ifndef SC_FARM_INTERNAL_H
#define SC_FARM_INTERNAL_H

#include "segcast/farm.h"

#include <assert.h>

/* ---- messages ---- */

/* The messages of the farm. A worker rank asks with SC_TAG_READY for each work unit and gets one
 * SC_TAG_UNIT in answer. A unit of kind SC_UNIT_NONE tells it to leave; when it has all answers and
 * has sent all results, it sends SC_TAG_BYE.
 *
 * The rows of a gathered GOP go to its encoder (SC_TAG_ROWS), while rank 0 gets the result without
 * them. The encoder tells rank 0 of each frame that it has encoded (SC_TAG_TAKEN), and sends the
 * finished GOP as a rank does that has drawn all of it. When all work units have come back, rank 0
 * tells each encoder how many messages with rows it gets in all (SC_TAG_YIELD). With the last of
 * them it sends the whole frames of GOPs that are not finished, which happens only after a stop
 * (SC_TAG_RESCUED), and then SC_TAG_YIELDED. */
enum {
    SC_TAG_READY = 1,  /* worker -> 0: int32 stop; the rank can be given one more work unit */
    SC_TAG_UNIT = 2,   /* 0 -> worker: sc_work_unit */
    SC_TAG_RESULT = 3, /* worker -> 0: sc_result_message and what follows it */
    SC_TAG_STOP = 4,   /* worker -> 0: int32 1; a signal has come */
    SC_TAG_BYE = 5,    /* worker -> 0: int32 0 */
    SC_TAG_PIECE = 6,  /* worker -> 0: the next piece of a GOP's payload, after its SC_TAG_RESULT */
    SC_TAG_ROWS = 7,   /* any worker -> encoder: sc_result_message and the rows */
    SC_TAG_TAKEN = 8,  /* encoder -> 0: sc_taken_message */
    SC_TAG_YIELD = 9,  /* 0 -> encoder: int32, the number of SC_TAG_ROWS that it gets */
    SC_TAG_RESCUED = 10, /* encoder -> 0: sc_result_message and a whole frame */
    SC_TAG_YIELDED = 11  /* encoder -> 0: int32 0; it sends nothing more */
};

/* Head of the result of a work unit. Behind it in the same message stand: for a GOP, the results of
 * its frames and the size of its payload (uint64); for a frame or band, its rows, unless they are
 * in their slot already or could not be drawn. */
typedef struct sc_result_message {
    sc_work_unit unit;
    int32_t status; /* the return code of draw or draw_gop */
    int32_t stop;   /* 1: a signal has come */
    sc_frame_result result;
} sc_result_message;

/* What an encoder tells rank 0 of a frame, or of an error. */
typedef struct sc_taken_message {
    int32_t index;   /* of the frame, as in its work units; -1: an error of no certain frame */
    int32_t status;  /* SC_OK, or the error with which the farm ends */
    double encode_s; /* how long it took */
} sc_taken_message;

/* Buffers for results on a worker rank: one is drawn into, one waits for the worker thread, and two
 * are being sent. */
enum { SC_WORKER_BUFFERS = 4 };

/* Between two tests for messages the main threads sleep, so that the cores are free for threads
 * that draw: first this long, and SC_NAP_GROWTH times as long each time as long as nothing happens.
 */
#define SC_NAP_S 50e-6
#define SC_NAP_GROWTH 1.5

/* @return the size of a row of pixels, in bytes. */
static inline size_t sc_farm_row_bytes(const sc_farm *farm)
{
    return (size_t)farm->width_px * sc_pixel_bytes(farm->alpha);
}
/* @return the size of a frame, in bytes. */
static inline size_t sc_farm_frame_bytes(const sc_farm *farm)
{
    return sc_farm_row_bytes(farm) * (size_t)farm->height_px;
}
/* @return the length of the longest message of the farm, in bytes: a whole frame, or the results of
 * a GOP. The payload of a GOP is sent in pieces of this length. */
size_t sc_farm_message_bytes(const sc_farm *farm);

/* ---- units.c: what a work unit amounts to ---- */

/* @return everything that is to be handed out, the same on all ranks. */
sc_work sc_farm_work(const sc_farm *farm, const sc_comm *comm);
/* @return whether GOPs are gathered with @p ranks ranks: a single rank draws them itself. */
bool sc_farm_gathers(const sc_farm *farm, int ranks);
/* @return the number of the frame of a work unit that is no GOP. */
int sc_farm_frame(const sc_farm *farm, const sc_work_unit *unit);
/* Add the timing record of a frame or band to @p sum; rank and hash are replaced. */
void sc_frame_result_add(sc_frame_result *sum, const sc_frame_result *part);
/* Post a payload to rank 0 in pieces of sc_farm_message_bytes, which stay borrowed from it until
 * they have left. An empty one has none. */
void sc_farm_post_payload(sc_comm *comm, const sc_farm *farm, const sc_payload *payload);
/* @return the number of frames of the GOP at @p index of farm->gops. */
int sc_farm_gop_frames(const sc_farm *farm, int index);
/* @return the number of rows of pixels in a work unit, above 0, as a measure of its cost. */
double sc_farm_unit_rows(const sc_farm *farm, const sc_work_unit *unit);

/* ---- worker_thread.c: a thread that does tasks in order while the main thread passes messages --
 */

/* A thread with a queue of tasks to do and one of finished tasks. Its functions are called by the
 * thread that has started it; only sc_worker_thread_stop waits for a task. */
typedef struct sc_worker_thread sc_worker_thread;
/* The first member of every task, by which the thread handles it. The rest of the task is known
 * only to the code that gives it and to the function that does it. */
typedef struct sc_task {
    struct sc_task *next; /* used by the thread: the task behind this one in a queue */
    double waited_s;      /* set before the task is begun: how long the thread had no task */
    double wall_s;        /* set after it: how long it took */
} sc_task;
/* Does one task, on the worker thread; it leaves the outcome in the task. */
typedef void sc_task_fn(void *user, sc_task *task);

/* Start a thread that calls @p run with @p user, which stays borrowed, for each task. @return
 * SC_ERR_MEMORY, or SC_ERR_SYSTEM if the system starts no more threads. Caller owns *out:
 * sc_worker_thread_stop. */
sc_status sc_worker_thread_start(const sc_ctx *ctx, sc_task_fn *run, void *user,
                                 sc_worker_thread **out);
/* Give the thread a task; returns at once. @p task belongs to the thread until
 * sc_worker_thread_collect returns it. */
void sc_worker_thread_give(sc_worker_thread *thread, sc_task *task);
/* @return the next finished task, in the order in which they were given, or NULL if none is
 * finished. Does not wait. */
sc_task *sc_worker_thread_collect(sc_worker_thread *thread);
/* @return the number of tasks that were given and are not finished. */
int sc_worker_thread_load(sc_worker_thread *thread);
/* @return for how long the thread has been doing its present task; 0 if it has none. */
double sc_worker_thread_task_age_s(sc_worker_thread *thread);
/* Block until the thread has done all its tasks, then end and free it. @return for how many seconds
 * it had no task. NULL is allowed. */
double sc_worker_thread_stop(sc_worker_thread *thread);

/* ---- draw_task.c: drawing a work unit ---- */

/* A work unit that is to be drawn: unit, image and results are set by who gives the task. */
typedef struct sc_draw_task {
    sc_task task;
    sc_work_unit unit;
    sc_status status;         /* result: the return code of the callback */
    sc_image *image;          /* frame or band: the frame to draw it in, borrowed */
    sc_frame_result result;   /* frame or band: result; the hash only of a whole frame */
    sc_frame_result *results; /* GOP: result, room for [gop_frames], owned by who gives the task */
    sc_payload payload;       /* GOP: result, empty if it was given up; whoever collects owns it */
} sc_draw_task;
static_assert(offsetof(sc_draw_task, task) == 0, "a task is cast to what it is the start of");

/* Draw the work unit of a task (an sc_draw_task), and store the outcome in it. For
 * sc_worker_thread_start, with the farm as user. */
void sc_draw_task_run(void *user, sc_task *task);

/* ---- gather.c: a rank as an encoder of gathered GOPs ---- */

/* What a rank gathers. Its functions are called by the main thread, and do not wait. Errors are
 * told to rank 0, which ends the farm. */
typedef struct sc_gather sc_gather;
/* Begin to gather, and start the worker thread that encodes. @return SC_ERR_MEMORY, SC_ERR_SYSTEM.
 * Caller owns *out: sc_gather_close. */
sc_status sc_gather_open(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_gather **out);
/* Wait until the worker thread has ended, and free everything; no message may be pending that was
 * posted. NULL is allowed. */
void sc_gather_close(sc_gather *gather);
SC_CLOSE_AT(sc_gather_close, sc_gather)
/* Add the rows of a work unit that were drawn here. @param message of which unit and result count.
 */
void sc_gather_add(sc_gather *gather, const sc_result_message *message, const void *rows);
/* Receive a message SC_TAG_ROWS and add its rows. */
void sc_gather_receive(sc_gather *gather, const sc_message *mail);
/* Note that no more will come than so many parts of frames, those drawn here included. */
void sc_gather_yield(sc_gather *gather, int messages);
/* Do what can be done now: encode whole frames in order, and send what is finished. @return whether
 * there was anything to do. */
bool sc_gather_step(sc_gather *gather);
/* @return whether it is so far behind that this rank should not draw. */
bool sc_gather_is_behind(const sc_gather *gather);

/* ---- encoder_states.c: what rank 0 knows of the encoders of gathered GOPs ---- */

typedef struct sc_encoders {
    sc_comm *comm;
    bool *taken;    /* [handout->gather_window], a ring: frames that were taken out of order */
    int32_t *parts; /* [ranks]: work units that have gone to each encoder */
    int yielding;   /* encoders that have not sent SC_TAG_YIELDED */
    bool told;      /* they were told to */
    /* costs so far: seconds of drawing rows, and of encoding frames */
    double draw_s, rows, encode_s, frames;
} sc_encoders;

/* @return SC_ERR_MEMORY. The caller calls sc_encoders_clear, also after an error. */
sc_status sc_encoders_open(const sc_ctx *ctx, sc_comm *comm, const sc_handout *handout,
                           sc_encoders *out);
void sc_encoders_clear(sc_encoders *encoders);
/* Note that a work unit of a gathered GOP was drawn and goes to its encoder. */
void sc_encoders_unit_done(sc_encoders *encoders, const sc_work_unit *unit);
/* Note that an encoder has taken a frame, and count up handout->taken. */
void sc_encoders_take(sc_encoders *encoders, sc_handout *handout, const sc_taken_message *message);
/* When all work units have come back: tell all encoders once to yield. @return whether none has
 * anything more to send. */
bool sc_encoders_have_yielded(sc_encoders *encoders, const sc_handout *handout);

/* ---- accept.c: finished frames and GOPs, on a worker thread of rank 0 ---- */

/* The first member of a frame slot and of a GOP: the task that accepts it. */
typedef struct sc_accept_task {
    sc_task task;
    bool is_gop;
    bool accepted;    /* result: the callback was called and has succeeded */
    sc_status status; /* result: the return code of the callback; SC_OK if it was not called */
} sc_accept_task;

/* A slot of rank 0's window: the frame at index i of farm->frames is collected in slot i % window,
 * and waits there to be accepted. */
typedef struct sc_frame_slot {
    sc_accept_task accept;
    sc_image image;
    sc_frame_result result; /* sums over the rows that are there */
    int rows_missing;       /* pixel rows that have not come back yet */
    bool in_bands;          /* drawn in bands, so that rank 0 has to hash the whole frame */
    bool full;              /* no rows are missing, and the frame is not yet accepted */
    bool rescued;           /* it is no slot of the window: see sc_rescued_new */
    sc_status drawn;        /* SC_OK, or the error by which some of its rows could not be drawn */
} sc_frame_slot;
static_assert(offsetof(sc_frame_slot, accept.task) == 0, "a task is cast to its slot");

/* A GOP that is accepted when its payload has arrived. Made by sc_gop_new. */
typedef struct sc_gop {
    sc_accept_task accept;
    struct sc_gop *next;      /* next one in the list of GOPs whose payload is arriving */
    int source;               /* the rank that sends it; not used for rank 0's own */
    sc_frame_result *results; /* [count], owned */
    int count;                /* of its frames */
    sc_payload payload; /* owned; data NULL: there was no memory, and what arrives is dropped */
    size_t received_bytes;
} sc_gop;
static_assert(offsetof(sc_gop, accept.task) == 0, "a task is cast to its GOP");

/* What the thread that accepts frames and GOPs works with. */
typedef struct sc_acceptor {
    const sc_farm *farm;
    sc_status status; /* the first error; after one nothing more is accepted */
} sc_acceptor;

/* Accept a frame or GOP (its sc_accept_task), and store the outcome in the task; after an error of
 * an earlier one do nothing. For sc_worker_thread_start, with the acceptor as user. */
void sc_accept_task_run(void *user, sc_task *task);
/* Make a GOP with a copy of @p results and no payload. Caller owns *out: sc_gop_free. */
sc_status sc_gop_new(const sc_ctx *ctx, const sc_frame_result *results, int count, sc_gop **out);
/* Make a frame of a gathered GOP that could not be finished, out of a message with @p rows. Caller
 * owns *out: sc_rescued_free. */
sc_status sc_rescued_new(const sc_ctx *ctx, const sc_farm *farm, const sc_frame_result *result,
                         const void *rows, sc_frame_slot **out);
/* Free such a frame. Not NULL. */
void sc_rescued_free(sc_frame_slot *frame);
/* Free a GOP with its results and payload. Not NULL. */
void sc_gop_free(sc_gop *gop);

/* ---- slots that ranks share ---- */

/* The frame buffers of rank 0's window, in memory that the ranks of its node share: they draw into
 * it instead of sending pixels. */
typedef struct sc_slots {
    char *pixels;  /* NULL: this rank does not share them, and its pixels are sent */
    size_t stride; /* bytes from one slot to the next */
    int window;    /* number of slots */
} sc_slots;

/* @return the picture of the slot of the frame at @p index of farm->frames; its pixels stay owned
 * by the slots. Only if they are shared. */
static inline sc_image sc_slot_image(const sc_slots *slots, const sc_farm *farm, int index)
{
    return (sc_image){farm->width_px, farm->height_px,
                      (uint8_t *)slots->pixels + (size_t)(index % slots->window) * slots->stride,
                      farm->alpha};
}

/* ---- the two roles of a rank: rank 0 serves, all others draw. Both block until the farm ends and
 * add to @p times, except wall_s. Collective. ---- */

/* Rank 0: hand out, draw and accept everything. @return as sc_farm_run, which agrees with the other
 * ranks on it afterwards. */
sc_status sc_farm_serve(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                        const sc_slots *slots, sc_farm_times *times);
/* Other ranks: draw what rank 0 hands out, until it dismisses this rank and all results have left.
 * Errors of drawing are sent to rank 0. @return SC_OK, or an error if the farm cannot begin
 * (SC_ERR_MEMORY), which is the same on all ranks. */
sc_status sc_farm_draw(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, const sc_slots *slots,
                       sc_farm_times *times);

#endif
