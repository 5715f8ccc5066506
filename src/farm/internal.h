/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to farm: the messages, and the threads of a rank. */
#ifndef SC_FARM_INTERNAL_H
#define SC_FARM_INTERNAL_H

#include "segcast/farm.h"

/* Each SC_TAG_READY is answered by one SC_TAG_UNIT; one of kind none sends home. A rank that has
 * been sent home and has all its answers says SC_TAG_BYE. */
enum {
    SC_TAG_READY = 1, /* worker -> 0: int32 stop; "I can take one more unit" */
    SC_TAG_UNIT = 2,  /* 0 -> worker: sc_unit */
    SC_TAG_DONE = 3,  /* worker -> 0: sc_done_message and what follows it */
    SC_TAG_STOP = 4,  /* worker -> 0: int32 1; a signal has come */
    SC_TAG_BYE = 5,   /* worker -> 0: int32 stop */
    SC_TAG_PIECE = 6  /* worker -> 0: of a group's payload, in order, after its SC_TAG_DONE */
};

/* Of a group, the results and the size of its payload (uint64) follow; of a frame or band, its
 * rows, unless they are in their slot already or could not be drawn. */
typedef struct sc_done_message {
    sc_unit unit;
    int32_t status; /* of draw or draw_group */
    int32_t stop;
    sc_frame_result result;
} sc_done_message;

/* The next unit is got so long before the one in work is expected to end. */
#define SC_LEAD_S 0.01

/* ---- lane.c: a thread that does jobs in order while the main thread passes on messages ---- */

typedef struct sc_lane sc_lane;
/* First member of a job; the rest is between the giver and `work`. */
typedef struct sc_lane_job {
    struct sc_lane_job *next;
    double waited_s; /* the lane was idle before it */
    double wall_s;
} sc_lane_job;
typedef void sc_lane_fn(void *user, sc_lane_job *job);

sc_status sc_lane_start(const sc_ctx *ctx, sc_lane_fn *work, void *user, sc_lane **out);
/* @p job stays with the lane until it is collected. */
void sc_lane_give(sc_lane *lane, sc_lane_job *job);
/* A finished job, or NULL. */
sc_lane_job *sc_lane_collect(sc_lane *lane);
/* Jobs given and not yet finished. */
int sc_lane_load(sc_lane *lane);
/* For how long the job in work has been so; 0 if none is. */
double sc_lane_age_s(sc_lane *lane);
/* End the thread after what it has; @return seconds it was idle. NULL is allowed. */
double sc_lane_stop(sc_lane *lane);

/* ---- draw.c: a unit in work ---- */

typedef struct sc_draw_job {
    sc_lane_job lane;
    sc_unit unit;
    sc_image *image; /* of a frame or band */
    sc_frame_result result;
    /* of a group */
    sc_frame_result *results; /* [group_frames], owned */
    sc_payload payload;
    sc_status status; /* of the callback */
} sc_draw_job;

/* For sc_lane_start, with the farm as user. */
void sc_farm_draw(void *user, sc_lane_job *lane_job);
/* Frames of the group @p index. */
int sc_farm_group_count(const sc_farm *farm, int index);
/* How many rows of pictures a unit is: a measure of its cost. */
double sc_farm_rows(const sc_farm *farm, const sc_unit *unit);

/* No message is longer. */
size_t sc_farm_message_bytes(const sc_farm *farm);

/* The frames of rank 0's window, where its node has memory to share them: ranks of that node draw
 * into them instead of sending pixels. */
typedef struct sc_slots {
    char *pixels; /* NULL: not shared */
    size_t stride;
    int window;
} sc_slots;

/* The picture in which frame @p index waits. */
static inline sc_image sc_slot_image(const sc_slots *slots, const sc_farm *farm, int index)
{
    return (sc_image){farm->width_px, farm->height_px,
                      (uint8_t *)slots->pixels + (size_t)(index % slots->window) * slots->stride};
}

/* What there is to hand out, as all ranks know it. */
sc_work sc_farm_amount(const sc_farm *farm, const sc_comm *comm);

sc_status sc_farm_serve(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                        const sc_slots *slots, sc_farm_times *times);
sc_status sc_farm_work(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, const sc_slots *slots,
                       sc_farm_times *times);

#endif
