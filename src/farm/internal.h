/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to farm: messages, worker threads, drawing tasks, and the two roles of a rank. */
#ifndef SC_FARM_INTERNAL_H
#define SC_FARM_INTERNAL_H

#include "segcast/farm.h"

#include <assert.h>

/* ---- messages ---- */

/* A worker rank asks with SC_TAG_READY for each work unit and gets one SC_TAG_UNIT in answer. A
 * unit of kind SC_UNIT_NONE tells it to leave; when it has all answers and has sent all results, it
 * says SC_TAG_BYE. */
enum {
    SC_TAG_READY = 1,  /* worker -> 0: int32 stop; the rank can be given one more work unit */
    SC_TAG_UNIT = 2,   /* 0 -> worker: sc_work_unit */
    SC_TAG_RESULT = 3, /* worker -> 0: sc_result_message and what follows it */
    SC_TAG_STOP = 4,   /* worker -> 0: int32 1; a signal has come */
    SC_TAG_BYE = 5,    /* worker -> 0: int32 0 */
    SC_TAG_PIECE = 6   /* worker -> 0: the next piece of a GOP's payload, after its SC_TAG_RESULT */
};

/* Head of the result of a work unit. Behind it in the same message stand: for a GOP, the results of
 * its frames and the size of its payload (uint64); for a frame or band, its rows, unless they are
 * in their slot already or could not be drawn. */
typedef struct sc_result_message {
    sc_work_unit unit;
    int32_t status; /* of draw or draw_gop */
    int32_t stop;   /* a signal has come */
    sc_frame_result result;
} sc_result_message;

/* A worker rank has at most so many work units or open requests: one that is drawn and one that
 * follows it without a gap. */
enum { SC_UNITS_PER_RANK = 2 };

/* Results that a worker rank can hold: one is drawn into, one waits for the thread, and two are
 * sent. */
enum { SC_WORKER_BUFFERS = 4 };

/* A rank asks for its next work unit when the one that it draws is expected to end within this
 * time: many times what a message takes, and short beside a work unit, so that no rank keeps work
 * that another could begin. */
#define SC_ASK_AHEAD_S 0.01

/* Between two looks for messages the main threads sleep, so that they leave the cores to those that
 * draw: first this long, then longer by a half each time as long as nothing happens. */
#define SC_NAP_S 50e-6
#define SC_NAP_GROWTH 1.5

/* No message of the farm is longer. */
size_t sc_farm_message_bytes(const sc_farm *farm);

/* ---- units.c: what a work unit amounts to ---- */

/* Everything there is to hand out, the same on all ranks. */
sc_work sc_farm_work(const sc_farm *farm, const sc_comm *comm);
/* Frames of the GOP @p index. */
int sc_farm_gop_frames(const sc_farm *farm, int index);
/* Rows of pictures in a work unit: a measure of its cost. */
double sc_farm_unit_rows(const sc_farm *farm, const sc_work_unit *unit);

/* ---- worker_thread.c: a thread that does tasks in order while the main thread passes messages --
 */

typedef struct sc_worker_thread sc_worker_thread;
/* First member of every task; what follows it is known to the giver and to the thread's function.
 */
typedef struct sc_task {
    struct sc_task *next;
    double waited_s; /* for how long the thread had no task before this one */
    double wall_s;   /* that it took */
} sc_task;
typedef void sc_task_fn(void *user, sc_task *task);

/* Start a thread that calls @p run for each task. Caller owns *out: sc_worker_thread_stop. */
sc_status sc_worker_thread_start(const sc_ctx *ctx, sc_task_fn *run, void *user,
                                 sc_worker_thread **out);
/* @p task belongs to the thread until sc_worker_thread_collect returns it. */
void sc_worker_thread_give(sc_worker_thread *thread, sc_task *task);
/* A finished task, in the order in which they were given, or NULL. */
sc_task *sc_worker_thread_collect(sc_worker_thread *thread);
/* Tasks that were given and are not finished. */
int sc_worker_thread_load(sc_worker_thread *thread);
/* For how long the thread has been doing its present task; 0 if it has none. */
double sc_worker_thread_task_age_s(sc_worker_thread *thread);
/* End the thread after the tasks that it has. @return the seconds it had no task. NULL is allowed.
 */
double sc_worker_thread_stop(sc_worker_thread *thread);

/* ---- draw_task.c: a work unit that is drawn ---- */

typedef struct sc_draw_task {
    sc_task task;
    sc_work_unit unit;
    sc_status status; /* of the callback */
    sc_image *image;  /* frame or band: where to draw it */
    sc_frame_result result;
    sc_frame_result *results; /* GOP: [gop_frames], owned */
    sc_payload payload;       /* GOP: owned */
} sc_draw_task;
static_assert(offsetof(sc_draw_task, task) == 0, "a task is cast to what it is the start of");

/* For sc_worker_thread_start, with the farm as user. */
void sc_draw_task_run(void *user, sc_task *task);

/* ---- accept.c: finished frames and GOPs, on a worker thread of rank 0 ---- */

/* First member of what is accepted. */
typedef struct sc_accept_task {
    sc_task task;
    bool is_gop;
    sc_status status; /* of the callback */
} sc_accept_task;

/* A place of rank 0's window: frame i is collected and waits in slot i % window. */
typedef struct sc_frame_slot {
    sc_accept_task accept;
    sc_image image;
    sc_frame_result result;
    int rows_missing;
    bool in_bands;   /* nobody has hashed the whole frame yet */
    bool full;       /* no rows are missing, and the frame is not yet accepted */
    sc_status drawn; /* an error: some of its rows could not be drawn */
} sc_frame_slot;
static_assert(offsetof(sc_frame_slot, accept.task) == 0, "a task is cast to its slot");

/* A GOP that is accepted when its payload has arrived. Allocated for it. */
typedef struct sc_gop {
    sc_accept_task accept;
    struct sc_gop *next;      /* in the list of those whose payload is arriving */
    int source;               /* rank that sends it */
    sc_frame_result *results; /* [count], owned */
    int count;
    sc_payload payload; /* owned; data NULL: there was no memory, what arrives is dropped */
    size_t received_bytes;
} sc_gop;
static_assert(offsetof(sc_gop, accept.task) == 0, "a task is cast to its GOP");

/* What the accepting thread knows. */
typedef struct sc_acceptor {
    const sc_farm *farm;
    sc_status status; /* the first error, after which nothing more is accepted */
} sc_acceptor;

/* For sc_worker_thread_start, with the acceptor as user. */
void sc_accept_task_run(void *user, sc_task *task);
/* A GOP with a copy of @p results and no payload. Caller owns *out: sc_gop_free. */
sc_status sc_gop_new(const sc_ctx *ctx, const sc_frame_result *results, int count, sc_gop **out);
void sc_gop_free(sc_gop *gop);

/* ---- slots that ranks share ---- */

/* The frame buffers of rank 0's window, in memory that the ranks of its node share: they draw into
 * it instead of sending pixels. */
typedef struct sc_slots {
    char *pixels; /* NULL: not shared */
    size_t stride;
    int window;
} sc_slots;

/* The picture of frame @p index. */
static inline sc_image sc_slot_image(const sc_slots *slots, const sc_farm *farm, int index)
{
    return (sc_image){farm->width_px, farm->height_px,
                      (uint8_t *)slots->pixels + (size_t)(index % slots->window) * slots->stride};
}

/* ---- the two roles of a rank; collective ---- */

sc_status sc_farm_serve(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                        const sc_slots *slots, sc_farm_times *times);
sc_status sc_farm_draw(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, const sc_slots *slots,
                       sc_farm_times *times);

#endif
