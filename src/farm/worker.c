/* SPDX-License-Identifier: BSD-3-Clause */
/* A rank that draws. While one frame is in work, the next unit is already here and the last
 * frame is still on its way. */
#include "internal.h"

#include <string.h>

typedef struct worker {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    sc_farm_times *times;
    char *buffers[2]; /* message and pixels; one is filled while the other is sent */
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

/* Wait for a unit. @return how long it took. */
static double wait_for_unit(worker *w)
{
    const double begin_s = sc_wall_s();
    double nap_s = 20e-6;

    while (receive(w)) {
    }
    while (w->unit_count == 0 && !w->sent_home) {
        sc_sleep_s(nap_s);
        nap_s = nap_s < 1e-3 ? nap_s * 1.5 : nap_s;
        while (receive(w)) {
        }
    }
    return sc_wall_s() - begin_s;
}

static sc_status draw_and_send(worker *w, double wait_s, int turn)
{
    const sc_farm *farm = w->farm;
    char *buffer = w->buffers[turn % 2];
    sc_frame_message message = {.unit = w->units[0]};
    sc_image image = {farm->width_px, farm->height_px, (uint8_t *)buffer + sizeof message};
    double begin_s, begin_cpu_s;
    sc_status status;

    memmove(w->units, w->units + 1, (size_t)--w->unit_count * sizeof w->units[0]);
    sc_farm_draw(farm, message.unit, sc_comm_rank(w->comm), wait_s, &image, &message.result);
    w->times->render_wall_s += message.result.render_wall_s;
    w->times->render_cpu_s += message.result.render_cpu_s;
    message.stop = *farm->stop;
    memcpy(buffer, &message, sizeof message);
    begin_s = sc_wall_s();
    begin_cpu_s = sc_thread_cpu_s();
    sc_comm_flush(w->comm); /* the frame before this one, whose buffer is needed next */
    status = sc_comm_post(w->ctx, w->comm, 0, SC_TAG_FRAME, buffer,
                          sizeof message + sc_image_bytes(&image));
    w->times->gather_wall_s += sc_wall_s() - begin_s;
    w->times->gather_cpu_s += sc_thread_cpu_s() - begin_cpu_s;
    return status;
}

sc_status sc_farm_work(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times)
{
    const size_t bytes = (size_t)farm->width_px * (size_t)farm->height_px * 3;
    worker w = {.ctx = ctx, .comm = comm, .farm = farm, .times = times};
    void *block = NULL;
    sc_status status;

    status = sc_alloc(ctx, 2, bytes + sizeof(sc_frame_message) + 64, &block);
    status = sc_comm_agree(comm, status); /* with the server, before anything is sent */
    if (status != SC_OK) {
        sc_free(block);
        return status;
    }
    w.buffers[0] = block;
    w.buffers[1] = w.buffers[0] + (bytes + sizeof(sc_frame_message) + 63) / 64 * 64;
    SC_TRY(send_ready(&w));
    for (int turn = 0;; turn++) {
        const double wait_s = wait_for_unit(&w);

        times->idle_s += wait_s;
        if (w.unit_count == 0)
            break;
        SC_TRY(draw_and_send(&w, wait_s, turn));
    }
out:
    sc_comm_flush(comm);
    sc_free(block);
    return status;
}
