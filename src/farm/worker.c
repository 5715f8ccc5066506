/* SPDX-License-Identifier: BSD-3-Clause */
/* A rank that draws. Its units are drawn by a thread; the main thread passes on messages
 * meanwhile, because a large one only moves while both of its ends attend to it. The next unit is
 * asked for shortly before the one in work ends: early enough to be here in time, late enough that
 * no rank sits on work that another could begin. */
#include "internal.h"

#include <string.h>

enum {
    BUFFERS = 4, /* in work, waiting, and two on their way */
    UNITS = 2    /* in work, and waiting */
};

typedef enum buffer_state {
    BUFFER_FREE,
    BUFFER_DRAWING, /* the drawing thread writes to it; nobody else looks at it */
    BUFFER_LEAVING  /* messages that were posted from it may not have left yet */
} buffer_state;

typedef struct buffer {
    sc_draw_job job; /* first: a pointer to it is one to the buffer */
    buffer_state state;
    char *message;  /* a sc_done_message, then the pixels of the image, or results */
    sc_image image; /* in the message */
    sc_image slot;  /* in rank 0's window, of a frame drawn there */
} buffer;

typedef struct worker {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    const sc_slots *slots;
    sc_farm_times *times;
    sc_lane *drawing;
    buffer buffers[BUFFERS];
    int in_hand;      /* units got and not yet sent back */
    int asked;        /* requests without an answer */
    double row_s;     /* what a row of a picture lately cost */
    double work_rows; /* of the newest unit in hand */
    bool stop_told, sent_home;
    sc_unit pending[UNITS];
    int pending_count;
} worker;

static void post(worker *w, int tag, const void *data, size_t bytes)
{
    sc_comm_post(w->comm, 0, tag, data, bytes);
}

/* Is it time to ask for one more? */
static bool should_ask(worker *w)
{
    double left_s;

    if (w->sent_home || w->asked + w->in_hand >= UNITS)
        return false;
    if (w->in_hand == 0)
        return w->asked == 0;
    left_s = w->work_rows * w->row_s - sc_lane_age_s(w->drawing);
    return w->asked == 0 && left_s < SC_LEAD_S;
}

static bool ask(worker *w)
{
    static const int32_t words[2] = {0, 1};
    const bool stop = *w->farm->stop;

    if (stop && !w->stop_told) {
        w->stop_told = true;
        post(w, SC_TAG_STOP, &words[1], sizeof words[1]);
    }
    if (!should_ask(w))
        return false;
    w->asked++;
    post(w, SC_TAG_READY, &words[stop], sizeof words[0]);
    return true;
}

/* Receive what has come: units, or the order to go home. */
static bool receive(worker *w)
{
    sc_message mail;
    sc_unit unit;

    if (!sc_comm_poll(w->comm, &mail))
        return false;
    sc_comm_receive(w->comm, &mail, &unit);
    w->asked--;
    if (unit.kind == SC_UNIT_NONE) {
        w->sent_home = true;
        return true;
    }
    w->pending[w->pending_count++] = unit;
    w->in_hand++;
    return true;
}

static buffer *find_free(worker *w)
{
    for (int i = 0; i < BUFFERS; i++) {
        if (w->buffers[i].state == BUFFER_FREE)
            return &w->buffers[i];
    }
    return NULL;
}

/* Buffers that are leaving are free again when all messages have left. */
static buffer *free_buffer(worker *w)
{
    buffer *found = find_free(w);

    if (found || sc_comm_pending(w->comm) > 0)
        return found;
    for (int i = 0; i < BUFFERS; i++) {
        buffer *b = &w->buffers[i];

        if (b->state == BUFFER_LEAVING) {
            b->state = BUFFER_FREE;
            sc_free(b->job.payload.data);
            b->job.payload = (sc_payload){0};
        }
    }
    return find_free(w);
}

/* Hand units on to the drawing thread, as far as there are buffers. */
static bool give_units(worker *w)
{
    bool any = false;
    buffer *b;

    while (w->pending_count > 0 && (b = free_buffer(w))) {
        sc_frame_result *results = b->job.results;

        b->state = BUFFER_DRAWING;
        b->job = (sc_draw_job){.unit = w->pending[0], .image = &b->image, .results = results};
        if (w->slots->pixels && b->job.unit.kind != SC_UNIT_GROUP)
            b->slot = sc_slot_image(w->slots, w->farm, b->job.unit.index);
        if (w->slots->pixels && (b->job.unit.kind == SC_UNIT_FRAME || !w->farm->spoils_other_rows))
            b->job.image = &b->slot;
        w->work_rows = sc_farm_rows(w->farm, &w->pending[0]);
        w->pending[0] = w->pending[1];
        w->pending_count--;
        sc_lane_give(w->drawing, &b->job.lane);
        any = true;
    }
    return any;
}

static void send_payload(worker *w, const sc_payload *payload)
{
    const size_t piece_bytes = sc_farm_message_bytes(w->farm);

    for (size_t at = 0; at < payload->bytes; at += piece_bytes) {
        const size_t left = payload->bytes - at;

        post(w, SC_TAG_PIECE, (const char *)payload->data + at,
             left < piece_bytes ? left : piece_bytes);
    }
}

static void send_group(worker *w, buffer *b, sc_done_message *message)
{
    const int count = sc_farm_group_count(w->farm, b->job.unit.index);
    const size_t results_bytes = (size_t)count * sizeof *b->job.results;
    const uint64_t bytes = b->job.payload.bytes;

    for (int i = 0; i < count; i++) {
        b->job.results[i].rank = sc_comm_rank(w->comm);
        w->times->render_wall_s += b->job.results[i].render_wall_s;
        w->times->render_cpu_s += b->job.results[i].render_cpu_s;
        message->result.render_wall_s += b->job.results[i].render_wall_s;
    }
    memcpy(b->message, message, sizeof *message);
    memcpy(b->message + sizeof *message, b->job.results, results_bytes);
    memcpy(b->message + sizeof *message + results_bytes, &bytes, sizeof bytes);
    post(w, SC_TAG_DONE, b->message, sizeof *message + results_bytes + sizeof bytes);
    send_payload(w, &b->job.payload);
}

static void send_rows(worker *w, buffer *b, sc_done_message *message)
{
    const size_t row_bytes = (size_t)w->farm->width_px * 3;
    const size_t at = (size_t)b->job.unit.row * row_bytes;
    size_t bytes = (size_t)b->job.unit.rows * row_bytes;

    message->result = b->job.result;
    message->result.rank = sc_comm_rank(w->comm);
    w->times->render_wall_s += b->job.result.render_wall_s;
    w->times->render_cpu_s += b->job.result.render_cpu_s;
    if (b->job.status != SC_OK) {
        bytes = 0;
    } else if (w->slots->pixels) { /* no pixels in the message */
        if (b->job.image == &b->image)
            memcpy(b->slot.rgb + at, b->image.rgb + at, bytes);
        bytes = 0;
        __atomic_thread_fence(__ATOMIC_SEQ_CST);
    } else {
        memmove(b->image.rgb, b->image.rgb + at, bytes);
    }
    memcpy(b->message, message, sizeof *message);
    post(w, SC_TAG_DONE, b->message, sizeof *message + bytes);
}

/* Send a finished unit on its way, if there is one. */
static bool send_finished(worker *w)
{
    buffer *b = (buffer *)sc_lane_collect(w->drawing);
    sc_done_message message = {0};

    if (!b)
        return false;
    message.unit = b->job.unit;
    message.status = b->job.status;
    message.stop = *w->farm->stop;
    w->in_hand--;
    w->row_s = b->job.lane.wall_s / sc_farm_rows(w->farm, &b->job.unit);
    if (b->job.unit.kind == SC_UNIT_GROUP)
        send_group(w, b, &message);
    else
        send_rows(w, b, &message);
    b->state = BUFFER_LEAVING;
    return true;
}

static void work(worker *w)
{
    static const int32_t bye = 0;
    double nap_s = 50e-6;

    while (!w->sent_home || w->asked > 0 || w->in_hand > 0) {
        const double begin_s = sc_wall_s(), begin_cpu_s = sc_thread_cpu_s();
        bool busy = false;

        while (receive(w))
            busy = true;
        busy = give_units(w) || busy;
        busy = send_finished(w) || busy;
        busy = ask(w) || busy;
        w->times->gather_wall_s += busy ? sc_wall_s() - begin_s : 0;
        w->times->gather_cpu_s += sc_thread_cpu_s() - begin_cpu_s;
        if (busy)
            nap_s = 50e-6;
        else if (sc_comm_pending(w->comm) > 0)
            nap_s = 200e-6; /* fragments of a frame are passing; drawing needs the core more */
        else
            nap_s = nap_s < 0.5e-3 ? nap_s * 1.5 : nap_s;
        sc_sleep_s(nap_s);
    }
    post(w, SC_TAG_BYE, &bye, sizeof bye);
}

static sc_status open_worker(worker *w, void **block)
{
    const sc_farm *farm = w->farm;
    const size_t each = (sc_farm_message_bytes(farm) + 63) / 64 * 64;
    void *results;
    sc_status status;

    SC_TRY(sc_alloc(w->ctx, BUFFERS, each, block));
    for (int i = 0; i < BUFFERS; i++) {
        buffer *b = &w->buffers[i];

        b->message = (char *)*block + (size_t)i * each;
        b->image = (sc_image){farm->width_px, farm->height_px,
                              (uint8_t *)b->message + sizeof(sc_done_message)};
        SC_TRY(sc_alloc(w->ctx, (size_t)farm->group_frames + 1, sizeof *b->job.results, &results));
        b->job.results = results;
    }
    status = sc_lane_start(w->ctx, sc_farm_draw, (void *)(uintptr_t)farm, &w->drawing);
out:
    return status;
}

sc_status sc_farm_work(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, const sc_slots *slots,
                       sc_farm_times *times)
{
    worker w = {.ctx = ctx, .comm = comm, .farm = farm, .slots = slots, .times = times};
    void *block = NULL;
    /* agreed with the server, before anything is sent */
    sc_status status = sc_comm_agree(comm, open_worker(&w, &block));

    if (status == SC_OK) {
        work(&w);
        sc_comm_flush(comm);
    }
    times->idle_s += sc_lane_stop(w.drawing);
    for (int i = 0; i < BUFFERS; i++) {
        sc_free(w.buffers[i].job.results);
        sc_free(w.buffers[i].job.payload.data);
    }
    sc_free(block);
    return status;
}
