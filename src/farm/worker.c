/* SPDX-License-Identifier: BSD-3-Clause */
/* A worker rank: asks rank 0 for work units, draws them in a worker thread and sends the results.
 * The main thread passes messages meanwhile, because a large message only moves while both of its
 * ends call the message layer. The next unit is asked for shortly before the present one ends:
 * early enough that it arrives in time, late enough that no rank holds back work that another could
 * begin. Beside that any worker rank may be the encoder of gathered GOPs (gather.c).
 */
#include "internal.h"

/* The longest sleep between two tests for messages; see SC_NAP_S. */
#define LONGEST_NAP_S 0.5e-3
/* The sleep while fragments of a frame are being sent: the thread that draws needs the core more.
 */
#define SENDING_NAP_S 200e-6

/* Who may touch a buffer. */
typedef enum buffer_state {
    BUFFER_FREE,
    BUFFER_DRAWING, /* the worker thread alone, until the task is collected */
    BUFFER_SENDING  /* the message layer, until no posted message is pending */
} buffer_state;

/* What a work unit is drawn into and sent from. */
typedef struct buffer {
    sc_draw_task task; /* owns results; the payload, too, until it is sent */
    buffer_state state;
    char *message;  /* [sc_farm_message_bytes]: a sc_result_message, then pixels or results */
    sc_image image; /* a picture whose pixels lie within the message */
    sc_image slot;  /* the frame's slot in rank 0's window, where that is shared */
} buffer;
static_assert(offsetof(buffer, task) == 0, "a task is cast to its buffer");

/* A worker rank of a farm. All members are used by its main thread alone, except the tasks that the
 * worker thread has been given. */
typedef struct worker {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    const sc_slots *slots;
    sc_farm_times *times;
    sc_worker_thread *drawing;
    sc_gather *gather; /* NULL: nothing is gathered */
    buffer buffers[SC_WORKER_BUFFERS];
    sc_work_unit waiting[SC_UNITS_PER_RANK]; /* units that wait for a free buffer */
    int waiting_count;
    int in_hand;      /* work units that were received and whose result is not yet sent */
    int asked;        /* requests without an answer */
    double row_s;     /* wall s of a row in the unit that was finished last */
    double unit_rows; /* rows of the unit that was begun last */
    bool stop_told;   /* rank 0 was told of a stop */
    bool dismissed;   /* rank 0 has no more work for this rank */
} worker;

static void post(worker *w, int tag, const void *data, size_t bytes)
{
    sc_comm_post(w->comm, 0, tag, data, bytes);
}

/* @return whether it is time to ask for a work unit: this rank has none, or only one that is
 * expected to end soon, and no request is without an answer. */
static bool should_ask(worker *w)
{
    if (w->dismissed || w->asked > 0 || w->in_hand >= SC_UNITS_PER_RANK ||
        (w->gather && sc_gather_is_behind(w->gather)))
        return false;
    if (w->in_hand == 0)
        return true;
    return sc_worker_thread_task_age_s(w->drawing) >= sc_handout_ask_age_s(w->unit_rows, w->row_s);
}

/* Tell rank 0 once of a stop, and ask it for work when it is time. @return whether it asked. */
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

/* Receive an answer of rank 0: put the work unit in it at the end of w->waiting; SC_UNIT_NONE sets
 * w->dismissed instead. */
static void receive_answer(worker *w, const sc_message *mail)
{
    sc_work_unit unit;

    sc_comm_receive(w->comm, mail, &unit);
    w->asked--;
    if (unit.kind == SC_UNIT_NONE) {
        w->dismissed = true;
        return;
    }
    w->waiting[w->waiting_count++] = unit;
    w->in_hand++;
}

/* Receive a message, if one has arrived: an answer, or what concerns this rank as an encoder.
 * @return false if none has arrived. */
static bool receive_message(worker *w)
{
    sc_message mail;
    int32_t messages;

    if (!sc_comm_poll(w->comm, &mail))
        return false;
    if (mail.tag == SC_TAG_ROWS) {
        sc_gather_receive(w->gather, &mail);
    } else if (mail.tag == SC_TAG_YIELD) {
        sc_comm_receive(w->comm, &mail, &messages);
        sc_gather_yield(w->gather, messages);
    } else {
        receive_answer(w, &mail);
    }
    return true;
}

/* @return a buffer whose state is BUFFER_FREE, or NULL. */
static buffer *find_free(worker *w)
{
    for (int i = 0; i < SC_WORKER_BUFFERS; i++) {
        if (w->buffers[i].state == BUFFER_FREE)
            return &w->buffers[i];
    }
    return NULL;
}

/* @return a free buffer, or NULL; does not wait. When none is free and no message is pending any
 * more, all buffers that were being sent become free, and their payloads are freed. */
static buffer *free_buffer(worker *w)
{
    buffer *found = find_free(w);

    if (found || sc_comm_pending(w->comm) > 0)
        return found;
    for (int i = 0; i < SC_WORKER_BUFFERS; i++) {
        buffer *b = &w->buffers[i];

        if (b->state == BUFFER_SENDING) {
            b->state = BUFFER_FREE;
            sc_free(b->task.payload.data);
            b->task.payload = (sc_payload){0};
        }
    }
    return find_free(w);
}

/* Give a work unit to the worker thread, which draws it into the free buffer @p b. Where rank 0's
 * window is shared, a frame is drawn into its slot instead, and so is a band, unless drawing would
 * spoil rows that other ranks draw. */
static void begin_task(worker *w, buffer *b, const sc_work_unit *unit)
{
    const bool shared = w->slots->pixels && unit->kind != SC_UNIT_GOP && unit->encoder == 0;

    b->state = BUFFER_DRAWING;
    b->task = (sc_draw_task){.unit = *unit, .image = &b->image, .results = b->task.results};
    if (shared)
        b->slot = sc_slot_image(w->slots, w->farm, unit->index);
    if (shared && (unit->kind == SC_UNIT_FRAME || !w->farm->spoils_other_rows))
        b->task.image = &b->slot;
    w->unit_rows = sc_farm_unit_rows(w->farm, unit);
    sc_worker_thread_give(w->drawing, &b->task.task);
}

/* Give the work units in w->waiting to the worker thread in order, as long as a buffer is free.
 * @return whether it gave any. */
static bool begin_tasks(worker *w)
{
    bool any = false;
    buffer *b;

    while (w->waiting_count > 0 && (b = free_buffer(w))) {
        begin_task(w, b, &w->waiting[0]);
        w->waiting_count--;
        memmove(w->waiting, w->waiting + 1, (size_t)w->waiting_count * sizeof *w->waiting);
        any = true;
    }
    return any;
}

/* Post the results of a GOP's frames, the size of its payload, and then the payload. @p message has
 * unit, status and stop; its result gets the time of drawing. send_gop
 * and send_rows copy it to b->message and add to w->times. */
static void send_gop(worker *w, buffer *b, sc_result_message *message)
{
    const int count = sc_farm_gop_frames(w->farm, b->task.unit.index);
    const size_t results_bytes = (size_t)count * sizeof *b->task.results;
    const uint64_t bytes = b->task.payload.bytes;

    for (int i = 0; i < count; i++) {
        sc_frame_result *result = &b->task.results[i];

        result->rank = sc_comm_rank(w->comm);
        w->times->render_wall_s += result->render_wall_s;
        w->times->render_cpu_s += result->render_cpu_s;
        message->result.render_wall_s += result->render_wall_s;
    }
    memcpy(b->message, message, sizeof *message);
    memcpy(b->message + sizeof *message, b->task.results, results_bytes);
    memcpy(b->message + sizeof *message + results_bytes, &bytes, sizeof bytes);
    post(w, SC_TAG_RESULT, b->message, sizeof *message + results_bytes + sizeof bytes);
    sc_farm_post_payload(w->comm, w->farm, &b->task.payload);
}

/* Send the rows of a frame or band of a gathered GOP, which lie behind the message, to its encoder;
 * add them at once if it is this rank. */
static void send_to_encoder(worker *w, buffer *b, size_t rows_bytes)
{
    const int encoder = b->task.unit.encoder;
    sc_result_message message;

    memcpy(&message, b->message, sizeof message);
    if (encoder == sc_comm_rank(w->comm))
        sc_gather_add(w->gather, &message, b->message + sizeof message);
    else
        sc_comm_post(w->comm, encoder, SC_TAG_ROWS, b->message, sizeof message + rows_bytes);
}

/* Post the result of a frame or band. Its rows go into the frame's slot where that is shared, to
 * the encoder if it has one, and into the message otherwise. */
static void send_rows(worker *w, buffer *b, sc_result_message *message)
{
    const size_t row_bytes = sc_farm_row_bytes(w->farm);
    const size_t at = (size_t)b->task.unit.row * row_bytes;
    const size_t rows_bytes = (size_t)b->task.unit.rows * row_bytes;
    size_t sent_bytes = 0;

    message->result = b->task.result;
    message->result.rank = sc_comm_rank(w->comm);
    w->times->render_wall_s += b->task.result.render_wall_s;
    w->times->render_cpu_s += b->task.result.render_cpu_s;
    if (b->task.status != SC_OK) {
        /* there are no rows to send */
    } else if (w->slots->pixels && b->task.unit.encoder == 0) {
        if (b->task.image == &b->image)
            memcpy(b->slot.rgb + at, b->image.rgb + at, rows_bytes);
        /* Rank 0 reads the rows when it has the message: they must be written before it is sent. */
        __atomic_thread_fence(__ATOMIC_SEQ_CST);
    } else {
        memmove(b->image.rgb, b->image.rgb + at, rows_bytes);
        sent_bytes = rows_bytes;
    }
    memcpy(b->message, message, sizeof *message);
    if (sent_bytes > 0 && b->task.unit.encoder > 0) {
        send_to_encoder(w, b, sent_bytes);
        sent_bytes = 0;
    }
    post(w, SC_TAG_RESULT, b->message, sizeof *message + sent_bytes);
}

/* Collect one finished task, and start sending its result, also of one that failed. @return false
 * if none is finished. */
static bool send_finished(worker *w)
{
    buffer *b = (buffer *)sc_worker_thread_collect(w->drawing);
    sc_result_message message = {0};

    if (!b)
        return false;
    message.unit = b->task.unit;
    message.status = b->task.status;
    message.stop = *w->farm->stop;
    w->in_hand--;
    w->row_s = b->task.task.wall_s / sc_farm_unit_rows(w->farm, &b->task.unit);
    if (b->task.unit.kind == SC_UNIT_GOP)
        send_gop(w, b, &message);
    else
        send_rows(w, b, &message);
    b->state = BUFFER_SENDING;
    return true;
}

/* @return how many seconds to sleep now. @param busy whether anything happened since the last
 * sleep, which took @p nap_s. */
static double next_nap_s(worker *w, bool busy, double nap_s)
{
    if (busy)
        return SC_NAP_S;
    if (sc_comm_pending(w->comm) > 0)
        return SENDING_NAP_S;
    return nap_s < LONGEST_NAP_S ? nap_s * SC_NAP_GROWTH : nap_s;
}

/* The loop of the main thread, until rank 0 has dismissed this rank and all results are posted;
 * then SC_TAG_BYE is. They may not have left yet: sc_comm_flush. */
static void pass_messages(worker *w)
{
    static const int32_t bye = 0;
    double nap_s = SC_NAP_S;

    while (!w->dismissed || w->asked > 0 || w->in_hand > 0) {
        const double begin_s = sc_wall_s(), begin_cpu_s = sc_thread_cpu_s();
        bool busy = false;

        while (receive_message(w))
            busy = true;
        busy = begin_tasks(w) || busy;
        busy = send_finished(w) || busy;
        busy = (w->gather && sc_gather_step(w->gather)) || busy;
        busy = ask(w) || busy;
        w->times->gather_wall_s += busy ? sc_wall_s() - begin_s : 0;
        w->times->gather_cpu_s += sc_thread_cpu_s() - begin_cpu_s;
        nap_s = next_nap_s(w, busy, nap_s);
        sc_sleep_s(nap_s);
    }
    post(w, SC_TAG_BYE, &bye, sizeof bye);
}

/* Allocate the buffers with their results and start the worker thread; sends nothing. The caller
 * frees all of it, also after an error. @param messages receives the memory that the messages of
 * all buffers lie in. @return SC_ERR_MEMORY. */
static sc_status open_worker(worker *w, void **messages)
{
    const sc_farm *farm = w->farm;
    const size_t each = (sc_farm_message_bytes(farm) + 63) / 64 * 64; /* whole cache lines */

    SC_PASS(sc_alloc(w->ctx, SC_WORKER_BUFFERS, each, messages));
    for (int i = 0; i < SC_WORKER_BUFFERS; i++) {
        buffer *b = &w->buffers[i];

        b->message = (char *)*messages + (size_t)i * each;
        b->image = (sc_image){farm->width_px, farm->height_px,
                              (uint8_t *)b->message + sizeof(sc_result_message), farm->alpha};
        SC_PASS(SC_ALLOC(w->ctx, (size_t)farm->gop_frames + 1, &b->task.results));
    }
    if (sc_farm_gathers(farm, sc_comm_size(w->comm)))
        SC_PASS(sc_gather_open(w->ctx, w->comm, farm, &w->gather));
    return sc_worker_thread_start(w->ctx, sc_draw_task_run, (void *)(uintptr_t)farm, &w->drawing);
}

sc_status sc_farm_draw(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, const sc_slots *slots,
                       sc_farm_times *times)
{
    worker w = {.ctx = ctx, .comm = comm, .farm = farm, .slots = slots, .times = times};
    SC_OWN(sc_free_at) void *messages = NULL;
    /* Rank 0 agrees at the same point (sc_farm_serve), so that no rank sends before all can
     * receive.
     */
    sc_status status = sc_comm_agree(comm, open_worker(&w, &messages));

    if (status == SC_OK) {
        pass_messages(&w);
        sc_comm_flush(comm);
    }
    times->idle_s += sc_worker_thread_stop(w.drawing);
    sc_gather_close(w.gather);
    for (int i = 0; i < SC_WORKER_BUFFERS; i++) {
        sc_free(w.buffers[i].task.results);
        sc_free(w.buffers[i].task.payload.data);
    }
    return status;
}
