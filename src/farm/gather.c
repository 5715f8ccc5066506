/* SPDX-License-Identifier: BSD-3-Clause */
/* A rank as an encoder: it gathers the frames of GOPs that other ranks draw, encodes them in order
 * in a worker thread, and sends each finished GOP to rank 0. Frames stay in memory until their GOP
 * is finished: if the farm is stopped before, they are sent to rank 0 as they are, so that they are
 * not lost. */
#include "internal.h"

/* A frame of a gathered GOP. The main thread uses it, except while it is being encoded. */
typedef struct gathered_frame {
    sc_task task;
    struct gathered_gop *gop;
    char *message;          /* owned, NULL: no rows have come, or the GOP is finished. An
                             * sc_result_message, then the pixels */
    sc_image image;         /* whose pixels are those */
    int index;              /* as in its work units */
    int rows_missing;       /* pixel rows that have not come yet */
    bool in_bands;          /* so that it has to be hashed here */
    sc_status status;       /* result of encoding */
    sc_taken_message taken; /* what rank 0 is told of that */
} gathered_frame;
static_assert(offsetof(gathered_frame, task) == 0, "a task is cast to its frame");

/* A GOP of which at least one row has come. */
typedef struct gathered_gop {
    struct gathered_gop *next;
    int index, first, count;  /* in farm->gops; number of its first frame; of frames */
    int given, encoded;       /* frames given to the worker thread so far; and collected */
    gathered_frame *frames;   /* [count] */
    sc_frame_result *results; /* [count] */
    sc_payload payload;       /* of the last frame */
    char *message;            /* of the finished GOP */
} gathered_gop;

struct sc_gather {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    char *inbox;                /* [sc_farm_message_bytes] */
    sc_worker_thread *encoding; /* does gathered_frames */
    gathered_gop *gops;         /* that are not finished, in the order of their indices */
    gathered_gop *sending;      /* that are finished, until no message is pending */
    int behind;                 /* frames with all rows that are not encoded */
    int messages;               /* parts of frames that have come */
    int expected;               /* that will have come in all; -1: not known yet */
    bool yielded;               /* rank 0 knows that nothing more follows */
    sc_status status;           /* the first error: nothing is encoded after it */
    sc_status encoded;          /* the first error of encoding; the worker thread's own */
    sc_taken_message failed;    /* what rank 0 is told of it */
};

/* Free a GOP with its frames and payload. */
static void free_gop(gathered_gop *gop)
{
    for (int i = 0; gop->frames && i < gop->count; i++)
        sc_free(gop->frames[i].message);
    sc_free(gop->frames);
    sc_free(gop->results);
    sc_free(gop->payload.data);
    sc_free(gop->message);
    sc_free(gop);
}

/* Free a list of GOPs. */
static void free_gops(gathered_gop *gop)
{
    while (gop) {
        gathered_gop *next = gop->next;

        free_gop(gop);
        gop = next;
    }
}

/* Encode no more after an error, and tell rank 0 of the first one. */
static void fail(sc_gather *g, sc_status status)
{
    if (g->status != SC_OK)
        return;
    g->status = status;
    g->failed = (sc_taken_message){.index = -1, .status = status};
    sc_comm_post(g->comm, 0, SC_TAG_TAKEN, &g->failed, sizeof g->failed);
}

/* On the worker thread: encode a frame. */
static void encode(void *user, sc_task *task)
{
    sc_gather *g = user;
    gathered_frame *frame = (gathered_frame *)task;
    gathered_gop *gop = frame->gop;
    sc_frame_result *result = &gop->results[frame - gop->frames];

    if (frame->in_bands)
        result->hash = sc_image_hash(&frame->image);
    if (g->encoded == SC_OK)
        g->encoded = g->farm->calls.encode_frame(g->farm->calls.user, gop->first, gop->count,
                                                 result, &frame->image, &gop->payload);
    frame->status = g->encoded;
}

/* ---- rows that come ---- */

/* Make a GOP without frames, and put it into g->gops, of which *link is to be the next one. */
static sc_status add_gop(sc_gather *g, int index, gathered_gop **link)
{
    const int count = g->farm->gop_frames;
    const size_t message_bytes =
        sizeof(sc_result_message) + (size_t)count * sizeof(sc_frame_result) + sizeof(uint64_t);
    gathered_gop *gop = NULL;
    sc_status status;

    SC_PASS(SC_ZALLOC(g->ctx, 1, &gop));
    gop->index = index;
    gop->first = g->farm->gops[index];
    gop->count = count;
    status = SC_ZALLOC(g->ctx, (size_t)count, &gop->frames);
    if (status == SC_OK)
        status = SC_ZALLOC(g->ctx, (size_t)count, &gop->results);
    if (status == SC_OK)
        status = sc_alloc(g->ctx, message_bytes, 1, &gop->message);
    if (status != SC_OK) {
        free_gop(gop);
        return status;
    }
    gop->next = *link;
    *link = gop;
    return SC_OK;
}

/* Find the GOP of a work unit, or make it. */
static sc_status find_gop(sc_gather *g, const sc_work_unit *unit, gathered_gop **out)
{
    gathered_gop **link = &g->gops;

    while (*link && (*link)->index < unit->gop)
        link = &(*link)->next;
    if (!*link || (*link)->index != unit->gop)
        SC_PASS(add_gop(g, unit->gop, link));
    *out = *link;
    return SC_OK;
}

/* Make room for the pixels of a frame. */
static sc_status begin_frame(sc_gather *g, const sc_work_unit *unit, gathered_gop *gop)
{
    gathered_frame *frame = &gop->frames[unit->place];
    const sc_farm *farm = g->farm;
    char *message;

    if (frame->message)
        return SC_OK;
    SC_PASS(SC_ALLOC(g->ctx, sizeof(sc_result_message) + sc_farm_frame_bytes(farm), &message));
    *frame =
        (gathered_frame){.gop = gop,
                         .message = message,
                         .image = {farm->width_px, farm->height_px,
                                   (uint8_t *)message + sizeof(sc_result_message), farm->alpha},
                         .index = unit->index,
                         .rows_missing = farm->height_px,
                         .in_bands = unit->kind == SC_UNIT_BAND};
    gop->results[unit->place].frame = gop->first + unit->place;
    return SC_OK;
}

void sc_gather_add(sc_gather *g, const sc_result_message *message, const void *rows)
{
    const sc_work_unit *unit = &message->unit;
    const size_t row_bytes = sc_farm_row_bytes(g->farm);
    gathered_gop *gop = NULL;
    gathered_frame *frame;
    sc_status status = g->status;

    g->messages++;
    if (status != SC_OK)
        return; /* the farm is ending */
    SC_TRY(find_gop(g, unit, &gop));
    SC_TRY(begin_frame(g, unit, gop));
    frame = &gop->frames[unit->place];
    memcpy(frame->image.rgb + (size_t)unit->row * row_bytes, rows, (size_t)unit->rows * row_bytes);
    sc_frame_result_add(&gop->results[unit->place], &message->result);
    frame->rows_missing -= unit->rows;
    g->behind += frame->rows_missing == 0;
    return;
out:
    fail(g, status);
}

void sc_gather_receive(sc_gather *g, const sc_message *mail)
{
    sc_result_message message;

    sc_comm_receive(g->comm, mail, g->inbox);
    memcpy(&message, g->inbox, sizeof message);
    sc_gather_add(g, &message, g->inbox + sizeof message);
}

/* ---- encoding ---- */

/* Give the worker thread the frames of the first GOP as far as they are whole, in order. @return
 * whether it gave any. */
static bool give_frames(sc_gather *g)
{
    gathered_gop *gop = g->gops;
    bool any = false;

    if (g->status != SC_OK)
        return false;
    while (gop && gop->given < gop->count) {
        gathered_frame *frame = &gop->frames[gop->given];

        if (!frame->message || frame->rows_missing > 0)
            break;
        sc_worker_thread_give(g->encoding, &frame->task);
        gop->given++;
        any = true;
    }
    return any;
}

/* The first GOP is encoded: free its frames, and send it. */
static void send_gop(sc_gather *g)
{
    gathered_gop *gop = g->gops;
    const size_t results_bytes = (size_t)gop->count * sizeof *gop->results;
    const uint64_t bytes = gop->payload.bytes;
    const sc_result_message message = {.unit = {.kind = SC_UNIT_GOP,
                                                .index = gop->index,
                                                .encoder = sc_comm_rank(g->comm),
                                                .gop = gop->index},
                                       .stop = *g->farm->stop != 0};

    for (int i = 0; i < gop->count; i++) {
        sc_free(gop->frames[i].message);
        gop->frames[i].message = NULL;
    }
    memcpy(gop->message, &message, sizeof message);
    memcpy(gop->message + sizeof message, gop->results, results_bytes);
    memcpy(gop->message + sizeof message + results_bytes, &bytes, sizeof bytes);
    sc_comm_post(g->comm, 0, SC_TAG_RESULT, gop->message,
                 sizeof message + results_bytes + sizeof bytes);
    sc_farm_post_payload(g->comm, g->farm, &gop->payload);
    g->gops = gop->next;
    gop->next = g->sending;
    g->sending = gop;
}

/* Collect a frame that was encoded, and tell rank 0. @return false if there is none. */
static bool collect_frame(sc_gather *g)
{
    gathered_frame *frame = (gathered_frame *)sc_worker_thread_collect(g->encoding);

    if (!frame)
        return false;
    g->behind--;
    frame->gop->encoded++;
    if (frame->status != SC_OK) {
        fail(g, frame->status);
        return true;
    }
    frame->taken = (sc_taken_message){.index = frame->index, .encode_s = frame->task.wall_s};
    sc_comm_post(g->comm, 0, SC_TAG_TAKEN, &frame->taken, sizeof frame->taken);
    if (frame->gop->encoded == frame->gop->count && g->status == SC_OK)
        send_gop(g);
    return true;
}

/* ---- the end ---- */

/* Send the whole frames of all GOPs that are not finished, and that nothing more follows. */
static void yield_frames(sc_gather *g)
{
    static const int32_t nothing = 0;
    const size_t pixels = sc_farm_frame_bytes(g->farm);

    for (gathered_gop *gop = g->status == SC_OK ? g->gops : NULL; gop; gop = gop->next) {
        for (int i = 0; i < gop->count; i++) {
            gathered_frame *frame = &gop->frames[i];
            sc_result_message message = {0};

            if (!frame->message || frame->rows_missing > 0)
                continue;
            if (frame->in_bands)
                gop->results[i].hash = sc_image_hash(&frame->image);
            message.result = gop->results[i];
            memcpy(frame->message, &message, sizeof message);
            sc_comm_post(g->comm, 0, SC_TAG_RESCUED, frame->message, sizeof message + pixels);
        }
    }
    sc_comm_post(g->comm, 0, SC_TAG_YIELDED, &nothing, sizeof nothing);
    g->yielded = true;
}

void sc_gather_yield(sc_gather *g, int messages)
{
    g->expected = messages;
}

bool sc_gather_step(sc_gather *g)
{
    bool busy = false;

    busy = give_frames(g) || busy;
    while (collect_frame(g))
        busy = true;
    if (g->sending && sc_comm_pending(g->comm) == 0) {
        free_gops(g->sending);
        g->sending = NULL;
    }
    if (!g->yielded && g->messages == g->expected && !busy &&
        sc_worker_thread_load(g->encoding) == 0) {
        /* a task may have ended after the last look */
        busy = collect_frame(g);
        if (!busy)
            yield_frames(g);
    }
    return busy;
}

bool sc_gather_is_behind(const sc_gather *g)
{
    /* After an error, and at the end, frames stay that are never encoded. A rank that waited for
     * them would never ask for work again, so that rank 0 could not dismiss it. */
    return g->status == SC_OK && !g->yielded && g->behind > SC_ENCODER_BEHIND;
}

sc_status sc_gather_open(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_gather **out)
{
    SC_OWN(sc_gather_close_at) sc_gather *g = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &g));
    g->ctx = ctx;
    g->comm = comm;
    g->farm = farm;
    g->expected = -1;
    SC_PASS(sc_alloc(ctx, sc_farm_message_bytes(farm), 1, &g->inbox));
    SC_PASS(sc_worker_thread_start(ctx, encode, g, &g->encoding));
    SC_HAND_OVER(g, out);
    return SC_OK;
}

void sc_gather_close(sc_gather *g)
{
    if (!g)
        return;
    (void)sc_worker_thread_stop(g->encoding);
    free_gops(g->gops);
    free_gops(g->sending);
    sc_free(g->inbox);
    sc_free(g);
}
