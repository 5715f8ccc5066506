/* SPDX-License-Identifier: BSD-3-Clause */
/* A rank that draws. Its frames are drawn by a thread; the main thread passes on messages
 * meanwhile, because a large one only moves while both of its ends attend to it. While one frame is
 * in work, the next unit is already here and the last frame is still on its way. */
#include "internal.h"

#include <string.h>

/* Frames waiting or in work, and two on their way. */
enum { BUFFERS = SC_UNITS_AHEAD + 2 };

typedef struct worker {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    sc_farm_times *times;
    sc_local *local;
    char *buffers[BUFFERS]; /* message and pixels; taken in turn */
    sc_image images[BUFFERS];
    int given, sent; /* frames so far; frame i stands in buffer i % BUFFERS */
    int32_t stop_words[SC_UNITS_AHEAD];
    int units[SC_UNITS_AHEAD], unit_count;
    bool sent_home;
} worker;

static sc_status send_ready(worker *w)
{
    sc_status status = SC_OK;

    for (int i = 0; i < SC_UNITS_AHEAD && status == SC_OK; i++) {
        w->stop_words[i] = *w->farm->stop;
        status = sc_comm_post(w->ctx, w->comm, 0, SC_TAG_READY, &w->stop_words[i],
                              sizeof w->stop_words[i]);
    }
    return status;
}

/* Receive what has come: units, or the order to go home. */
static bool receive(worker *w)
{
    sc_message message;
    int32_t unit;

    if (!sc_comm_poll(w->comm, &message))
        return false;
    sc_comm_receive(w->comm, &message, &unit);
    if (unit < 0)
        w->sent_home = true;
    else
        w->units[w->unit_count++] = unit;
    return true;
}

/* Hand units on to the drawing thread, as far as there are buffers. */
static bool give_units(worker *w)
{
    bool any = false;

    while (w->unit_count > 0 && sc_local_has_room(w->local) &&
           w->given - w->sent + sc_comm_pending(w->comm) < BUFFERS) {
        sc_local_give(w->local, w->units[0], &w->images[w->given++ % BUFFERS]);
        w->unit_count--;
        memmove(w->units, w->units + 1, (size_t)w->unit_count * sizeof w->units[0]);
        any = true;
    }
    return any;
}

/* Send a finished frame on its way, if there is one. */
static sc_status send_finished(worker *w, bool *any)
{
    sc_frame_message message;
    char *buffer = w->buffers[w->sent % BUFFERS];
    int unit;

    *any = sc_local_collect(w->local, &unit, &message.result);
    if (!*any)
        return SC_OK;
    message.unit = unit;
    message.stop = *w->farm->stop;
    message.result.rank = sc_comm_rank(w->comm);
    memcpy(buffer, &message, sizeof message);
    w->sent++;
    return sc_comm_post(w->ctx, w->comm, 0, SC_TAG_FRAME, buffer,
                        sizeof message + sc_image_bytes(&w->images[0]));
}

static sc_status work(worker *w)
{
    double nap_s = 50e-6;
    sc_status status;

    SC_TRY(send_ready(w));
    while (!w->sent_home) {
        const double begin_s = sc_wall_s(), begin_cpu_s = sc_thread_cpu_s();
        bool busy = false, sent;

        while (receive(w))
            busy = true;
        busy = give_units(w) || busy;
        SC_TRY(send_finished(w, &sent));
        busy = busy || sent;
        w->times->gather_wall_s += busy ? sc_wall_s() - begin_s : 0;
        w->times->gather_cpu_s += sc_thread_cpu_s() - begin_cpu_s;
        if (busy || sc_comm_pending(w->comm) > 0)
            nap_s = 50e-6; /* fragments of a frame are passing */
        else
            nap_s = nap_s < 1e-3 ? nap_s * 1.5 : nap_s;
        sc_sleep_s(nap_s);
    }
out:
    return status;
}

static sc_status open_worker(worker *w, void **block)
{
    const sc_farm *farm = w->farm;
    const size_t bytes = (size_t)farm->width_px * (size_t)farm->height_px * 3;
    const size_t each = (bytes + sizeof(sc_frame_message) + 63) / 64 * 64;
    sc_status status;

    SC_TRY(sc_alloc(w->ctx, BUFFERS, each, block));
    for (int i = 0; i < BUFFERS; i++) {
        w->buffers[i] = (char *)*block + (size_t)i * each;
        w->images[i] = (sc_image){farm->width_px, farm->height_px,
                                  (uint8_t *)w->buffers[i] + sizeof(sc_frame_message)};
    }
    status = sc_local_start(w->ctx, farm, &w->local);
out:
    return status;
}

sc_status sc_farm_work(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times)
{
    worker w = {.ctx = ctx, .comm = comm, .farm = farm, .times = times};
    void *block = NULL;
    /* agreed with the server, before anything is sent */
    sc_status status = sc_comm_agree(comm, open_worker(&w, &block));

    if (status == SC_OK) {
        status = work(&w);
        sc_comm_flush(comm);
    }
    sc_local_stop(w.local, times);
    sc_free(block);
    return status;
}
