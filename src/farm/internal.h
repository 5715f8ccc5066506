/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to farm: the messages, and the drawing thread of a rank. */
#ifndef SC_FARM_INTERNAL_H
#define SC_FARM_INTERNAL_H

#include "segcast/farm.h"

enum {
    SC_TAG_READY = 1, /* worker -> 0: int32 stop; "I can take one more unit" */
    SC_TAG_UNIT = 2,  /* 0 -> worker: int32 index into frames, or -1: go home */
    SC_TAG_FRAME = 3  /* worker -> 0: frame_message, then pixels; also a SC_TAG_READY */
};

/* A worker has one unit in work and one waiting, so that it never waits for the mail. */
enum { SC_UNITS_AHEAD = 2 };

typedef struct sc_frame_message {
    int32_t unit, stop;
    sc_frame_result result;
} sc_frame_message;

/* Draw one unit and fill in its result. */
void sc_farm_draw(const sc_farm *farm, int unit, double wait_s, sc_image *image,
                  sc_frame_result *result);

/* The thread that draws while the main thread passes on messages. */
typedef struct sc_local sc_local;
sc_status sc_local_start(const sc_ctx *ctx, const sc_farm *farm, sc_local **out);
/* Can it take one more unit now? */
bool sc_local_has_room(sc_local *local);
/* Draw @p unit into @p image, which must stay until it comes back. */
void sc_local_give(sc_local *local, int unit, sc_image *image);
/* A finished unit, if there is one. */
bool sc_local_collect(sc_local *local, int *unit, sc_frame_result *result);
/* End the thread after what it has; adds its waiting time. NULL is allowed. */
void sc_local_stop(sc_local *local, sc_farm_times *times);

sc_status sc_farm_serve(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                        sc_farm_times *times);
sc_status sc_farm_work(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times);

#endif
