/* SPDX-License-Identifier: BSD-3-Clause */
/* Rank 0's main thread: hands out units, gathers frames into a window of slots, passes them on in
 * order. Its own drawing runs in a thread beside it and is served like any other rank. */
#include "internal.h"

#include <string.h>

typedef struct slot {
    sc_image image;
    sc_frame_result result;
    bool full;
} slot;

typedef struct server {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    sc_farm_times *times;
    sc_handout handout;
    slot *slots; /* [window]; unit u waits in slot u % window */
    char *inbox; /* one message with its pixels */
    sc_local *local;
    int *ready; /* ranks that wait for a unit, oldest first, each up to SC_UNITS_AHEAD times */
    int ready_count;
    int32_t *answers; /* [ready capacity]: words of posted messages, which must stay */
    int answer_next, answer_capacity;
    sc_status status;
} server;

static sc_status open_server(server *s)
{
    const sc_farm *farm = s->farm;
    const int ranks = sc_comm_size(s->comm);
    const size_t bytes = (size_t)farm->width_px * (size_t)farm->height_px * 3;
    void *block;
    sc_status status;

    s->handout.total = farm->frame_count;
    s->handout.window = sc_handout_window(ranks, bytes);
    s->answer_capacity = ranks * (SC_UNITS_AHEAD + 1) * 2;
    SC_TRY(sc_zalloc(s->ctx, (size_t)s->handout.window, sizeof(slot), &block));
    s->slots = block;
    for (int i = 0; i < s->handout.window; i++)
        SC_TRY(sc_image_init(s->ctx, farm->width_px, farm->height_px, &s->slots[i].image));
    SC_TRY(sc_alloc(s->ctx, 1, bytes + sizeof(sc_frame_message), &block));
    s->inbox = block;
    SC_TRY(sc_alloc(s->ctx, (size_t)s->answer_capacity, sizeof(int), &block));
    s->ready = block;
    SC_TRY(sc_alloc(s->ctx, (size_t)s->answer_capacity, sizeof(int32_t), &block));
    s->answers = block;
    status = sc_local_start(s->ctx, farm, &s->local);
out:
    return status;
}

static void close_server(server *s)
{
    sc_local_stop(s->local, s->times);
    for (int i = 0; s->slots && i < s->handout.window; i++)
        sc_image_clear(&s->slots[i].image);
    sc_free(s->slots);
    sc_free(s->inbox);
    sc_free(s->ready);
    sc_free(s->answers);
}

static void stop_with(server *s, sc_status status)
{
    s->handout.stopped = true;
    if (s->status == SC_OK)
        s->status = status;
}

static void answer(server *s, int rank, int unit)
{
    int32_t *word = &s->answers[s->answer_next++ % s->answer_capacity];
    sc_status status;

    *word = unit;
    status = sc_comm_post(s->ctx, s->comm, rank, SC_TAG_UNIT, word, sizeof *word);
    if (status != SC_OK)
        stop_with(s, status);
}

static void take_frame_message(server *s, const sc_message *mail)
{
    sc_frame_message message;
    slot *to;

    sc_comm_receive(s->comm, mail, s->inbox);
    memcpy(&message, s->inbox, sizeof message);
    to = &s->slots[message.unit % s->handout.window];
    memcpy(to->image.rgb, s->inbox + sizeof message, sc_image_bytes(&to->image));
    to->result = message.result;
    to->full = true;
    sc_handout_back(&s->handout);
    s->ready[s->ready_count++] = mail->source;
    if (message.stop)
        stop_with(s, SC_ERR_INCOMPLETE);
}

/* One message, if there is one. */
static bool read_mail(server *s)
{
    sc_message mail;
    int32_t stop;

    if (!sc_comm_poll(s->comm, &mail))
        return false;
    if (mail.tag == SC_TAG_FRAME) {
        take_frame_message(s, &mail);
        return true;
    }
    sc_comm_receive(s->comm, &mail, &stop);
    s->ready[s->ready_count++] = mail.source;
    if (stop)
        stop_with(s, SC_ERR_INCOMPLETE);
    return true;
}

static bool collect_local(server *s)
{
    sc_frame_result result;
    int unit;

    if (!sc_local_collect(s->local, &unit, &result))
        return false;
    s->slots[unit % s->handout.window].result = result;
    s->slots[unit % s->handout.window].full = true;
    sc_handout_back(&s->handout);
    return true;
}

/* Give units to all who wait, first come first served; rank 0's own thread last. */
static void hand_out(server *s)
{
    int served = 0, unit;

    while (served < s->ready_count) {
        unit = sc_handout_next(&s->handout);
        if (unit < 0)
            break;
        answer(s, s->ready[served++], unit);
    }
    s->ready_count -= served;
    memmove(s->ready, s->ready + served, (size_t)s->ready_count * sizeof *s->ready);
    while (s->ready_count == 0 && sc_local_has_room(s->local)) {
        unit = sc_handout_next(&s->handout);
        if (unit < 0)
            break;
        sc_local_give(s->local, unit, &s->slots[unit % s->handout.window].image);
    }
}

/* Pass on the next frame in order, if it is here. */
static bool take_next(server *s)
{
    slot *next = &s->slots[s->handout.taken % s->handout.window];
    const double begin_s = sc_wall_s();
    sc_status status;

    if (!next->full)
        return false;
    next->full = false;
    if (s->status == SC_OK || s->status == SC_ERR_INCOMPLETE) {
        status = s->farm->take(s->farm->user, &next->result, &next->image);
        if (status != SC_OK) {
            s->handout.stopped = true;
            s->status = status;
        }
    }
    s->handout.taken++;
    s->times->take_wall_s += sc_wall_s() - begin_s;
    return true;
}

static void serve(server *s)
{
    double nap_s = 50e-6, tick_s = 0;

    while (!sc_handout_finished(&s->handout) ||
           s->slots[s->handout.taken % s->handout.window].full) {
        const double begin_s = sc_wall_s(), begin_cpu_s = sc_thread_cpu_s();
        bool busy = false;

        if (*s->farm->stop)
            stop_with(s, SC_ERR_INCOMPLETE);
        while (read_mail(s))
            busy = true;
        busy = collect_local(s) || busy;
        hand_out(s);
        s->times->gather_wall_s += busy ? sc_wall_s() - begin_s : 0;
        s->times->gather_cpu_s += sc_thread_cpu_s() - begin_cpu_s;
        busy = take_next(s) || busy;
        if (s->farm->tick && begin_s > tick_s + 0.1) {
            s->farm->tick(s->farm->user, s->handout.taken, s->handout.total);
            tick_s = begin_s;
        }
        nap_s = busy ? 50e-6 : nap_s < 2e-3 ? nap_s * 1.5 : nap_s;
        if (!busy)
            sc_sleep_s(nap_s);
    }
}

/* Every worker still waits for its promised units: send each home once, and await the rest. */
static void dismiss(server *s)
{
    const int workers = sc_comm_size(s->comm) - 1;
    int expected = workers * SC_UNITS_AHEAD - s->ready_count;
    double nap_s = 50e-6;

    while (expected > 0) {
        if (read_mail(s))
            expected--;
        else
            sc_sleep_s(nap_s);
    }
    for (int rank = 1; rank <= workers; rank++)
        answer(s, rank, -1);
    sc_comm_flush(s->comm);
}

sc_status sc_farm_serve(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times)
{
    server s = {.ctx = ctx, .comm = comm, .farm = farm, .times = times};
    sc_status status = sc_comm_agree(comm, open_server(&s));

    if (status == SC_OK) {
        serve(&s);
        dismiss(&s);
        status = s.status;
        if (status == SC_ERR_INCOMPLETE && s.handout.taken == s.handout.total)
            status = SC_OK; /* the stop came when all was done */
    }
    close_server(&s);
    return status;
}
