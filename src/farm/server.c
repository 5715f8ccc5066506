/* SPDX-License-Identifier: BSD-3-Clause */
/* The main thread of rank 0: hands out work units, collects rows of frames in the slots of the
 * window, and gives finished frames in order, and GOPs as they come, to a worker thread that
 * accepts them. A second worker thread draws; it gets a work unit when no other rank waits for one.
 * The main thread itself never waits for a frame to be drawn, encoded or written, so that it
 * answers at once.
 *
 * It sends nothing but work units of a few bytes. Any message layer buffers these, so that sending
 * never waits for the receiver. */
#include "internal.h"

/* The longest sleep between two tests for messages; see SC_NAP_S. */
#define LONGEST_NAP_S 0.7e-3
/* So many frames of unfinished GOPs are held at a time. */
enum { RESCUED_MOST = 2 };
/* The shortest time between two calls of farm->on_progress. */
#define PROGRESS_INTERVAL_S 0.1

/* For the deadline, the largest costs measured lately are remembered (see recent_most). With each
 * new value they shrink by this share, so that one costly frame does not end the whole run early.
 */
#define FORGET 0.05

/* The accepting of frames by a worker thread. */
typedef struct accepting {
    sc_acceptor acceptor;
    sc_worker_thread *thread;
    int next;     /* index of the first frame that the thread does not have yet */
    int frames;   /* that were accepted, those of GOPs included */
    int gathered; /* those of them that were accepted in gathered GOPs */
    int rescued;  /* frames of unfinished gathered GOPs that are being accepted */
} accepting;

/* The drawing on this rank. */
typedef struct own_drawing {
    sc_worker_thread *thread;
    sc_draw_task tasks[SC_UNITS_PER_RANK];
    bool used[SC_UNITS_PER_RANK];      /* given to the thread and not yet collected */
    sc_image bands[SC_UNITS_PER_RANK]; /* if draw spoils other rows: bands are drawn here and
                                          copied */
    double rows;                       /* rows of the work unit that was begun last */
    double row_s;                      /* wall s of a row in the unit that was finished last */
} own_drawing;

/* The other ranks, which wait for work units. */
typedef struct waiting_ranks {
    int *ready; /* that wait for an answer, oldest first: [SC_UNITS_PER_RANK * ranks] */
    int ready_count;
    /* Buffers of answers that are being sent, [ranks][SC_UNITS_PER_RANK], used in turn. When a rank
     * asks again it has received its answer before, so that the next buffer is free. */
    sc_work_unit *answers;
    int *next_answer; /* [ranks]: number of answers so far */
    int byes;         /* ranks that have left */
} waiting_ranks;

/* Rank 0 of a farm. All members are used by its main thread alone, except what a worker thread has
 * been given (a task, with the slot or GOP around it), and acceptor, which belongs to the accepting
 * thread. */
typedef struct server {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    const sc_slots *shared; /* pixels NULL: slots have memory of their own */
    sc_farm_times *times;   /* those of this rank; what is measured is added to them */
    sc_status status;       /* the return code with which the farm will end */
    sc_handout handout;
    char *inbox; /* [sc_farm_message_bytes]: the message that was received last */

    /* frames and GOPs on their way to be accepted */
    sc_frame_slot *slots; /* [window] */
    sc_gop *arriving;     /* list of GOPs whose payload is arriving, owned */
    int gops_in_hand;     /* arriving or being accepted */
    accepting accepting;
    own_drawing own;
    waiting_ranks waiting;
    sc_encoders encoders;

    /* recent_most of drawing a work unit, and of accepting a frame or GOP, in wall seconds */
    double unit_s, accept_s;
} server;

/* Begin no more GOPs and frames, and end the farm with @p status. Of several errors the first
 * counts; SC_ERR_INCOMPLETE, which only means a stop, is replaced by an error. */
static void stop_with(server *s, sc_status status)
{
    s->handout.stopped = true;
    if (s->status == SC_OK || (s->status == SC_ERR_INCOMPLETE && status != SC_OK))
        s->status = status;
}

/* @return the largest of @p value and the values before it, older ones counting less and less.
 * @param before the last result. */
static double recent_most(double before, double value)
{
    const double kept = (1 - FORGET) * before;

    return value > kept ? value : kept;
}

/* ---- accepting ---- */

/* Give a GOP that is whole to the thread that accepts it; collect_accepted frees it afterwards. */
static void give_gop(server *s, sc_gop *gop)
{
    sc_worker_thread_give(s->accepting.thread, &gop->accept.task);
}

/* Note what it took to encode a frame here, where gathered GOPs need to know. */
static void learn_encoding(server *s, double wall_s)
{
    s->encoders.encode_s += wall_s;
    s->encoders.frames++;
}

/* Collect one frame or GOP that the accepting thread is done with, and free its slot or memory. One
 * that it could not accept stops the farm; a frame makes room in the window all the same, but only
 * what was accepted is counted as such. @return false if there is none. */
static bool collect_accepted(server *s)
{
    sc_accept_task *accept = (sc_accept_task *)sc_worker_thread_collect(s->accepting.thread);

    if (!accept)
        return false;
    s->times->accept_wall_s += accept->task.wall_s;
    s->accept_s = recent_most(s->accept_s, accept->task.wall_s);
    if (accept->status != SC_OK)
        stop_with(s, accept->status);
    if (accept->is_gop) {
        sc_gop *gop = (sc_gop *)accept;

        s->accepting.frames += accept->accepted ? gop->count : 0;
        s->gops_in_hand--;
        sc_gop_free(gop);
    } else if (((sc_frame_slot *)accept)->rescued) {
        s->accepting.frames += accept->accepted;
        s->accepting.rescued--;
        sc_rescued_free((sc_frame_slot *)accept);
    } else {
        learn_encoding(s, accept->task.wall_s);
        s->accepting.frames += accept->accepted;
        ((sc_frame_slot *)accept)->full = false;
        s->handout.accepted++;
    }
    return true;
}

/* @return the slot of the frame at @p index of farm->frames. */
static sc_frame_slot *slot_of(server *s, int index)
{
    return &s->slots[index % s->handout.window];
}

/* Give full frames to the thread that accepts them. It gets them in order, so that a full frame
 * waits until those before it are full. @return whether it gave any. */
static bool give_full_frames(server *s)
{
    bool any = false;

    while (s->accepting.next < s->handout.next_frame && slot_of(s, s->accepting.next)->full &&
           s->accepting.next < s->handout.accepted + s->handout.window) {
        sc_worker_thread_give(s->accepting.thread, &slot_of(s, s->accepting.next)->accept.task);
        s->accepting.next++;
        any = true;
    }
    return any;
}

/* ---- results of work units ---- */

/* Count a work unit that has come back. @param wall_s how long it took to draw. */
static void unit_done(server *s, double wall_s)
{
    sc_handout_unit_done(&s->handout);
    s->unit_s = recent_most(s->unit_s, wall_s);
}

/* Note what it took to draw rows, where gathered GOPs need to know. */
static void learn_drawing(server *s, const sc_work_unit *unit, const sc_frame_result *result)
{
    s->encoders.draw_s += result->render_wall_s;
    s->encoders.rows += unit->rows;
}

/* Prepare the slot of a frame when its first rows are handed out; does nothing for further ones. */
static void begin_slot(server *s, const sc_work_unit *unit)
{
    sc_frame_slot *slot = slot_of(s, unit->index);

    if (unit->row > 0)
        return;
    slot->in_bands = unit->kind == SC_UNIT_BAND;
    slot->rows_missing = s->farm->height_px;
    slot->drawn = SC_OK;
    slot->result = (sc_frame_result){.frame = s->farm->frames[unit->index]};
}

/* Count the rows of a frame or band as present, and its work unit as back. The caller has put them
 * into their slot, unless @p drawn is an error: then the farm is stopped with it, and the frame
 * will not be accepted. The slot is full when no rows are missing. */
static void rows_done(server *s, const sc_work_unit *unit, const sc_frame_result *result,
                      sc_status drawn)
{
    sc_frame_slot *slot = slot_of(s, unit->index);

    sc_frame_result_add(&slot->result, result);
    if (drawn != SC_OK) {
        slot->drawn = drawn;
        stop_with(s, drawn);
    }
    slot->rows_missing -= unit->rows;
    slot->full = slot->rows_missing == 0;
    unit_done(s, result->render_wall_s);
}

/* @return a new GOP with a copy of @p results [count] and no payload, counted in gops_in_hand,
 * which the caller owns; NULL if there is no memory, and then the farm is stopped. */
static sc_gop *begin_gop(server *s, const sc_frame_result *results, int count)
{
    sc_gop *gop = NULL;
    const sc_status status = sc_gop_new(s->ctx, results, count, &gop);

    if (status == SC_OK)
        s->gops_in_hand++;
    else
        stop_with(s, status);
    return gop;
}

/* ---- messages ---- */

/* Handle the first message of a GOP's result from rank @p source, which is in the inbox; @p message
 * is a copy of its head. The GOP is put into s->arriving, since its payload follows in pieces,
 * unless the size of that is 0: then the GOP was given up. Errors stop the farm. */
static void receive_gop(server *s, int source, const sc_result_message *message)
{
    const char *behind = s->inbox + sizeof *message;
    const int count = sc_farm_gop_frames(s->farm, message->unit.index);
    uint64_t bytes;
    sc_gop *gop;
    sc_status status = (sc_status)message->status;

    memcpy(&bytes, behind + (size_t)count * sizeof(sc_frame_result), sizeof bytes);
    if (message->unit.encoder == 0)
        unit_done(s, message->result.render_wall_s);
    else
        s->accepting.gathered += count;
    if (status != SC_OK)
        stop_with(s, status);
    if (bytes == 0 || status != SC_OK)
        return; /* the pieces of the payload of a GOP that failed are received and dropped */
    gop = begin_gop(s, (const sc_frame_result *)behind, count);
    if (!gop)
        return;
    gop->source = source;
    gop->payload.bytes = bytes;
    gop->next = s->arriving;
    s->arriving = gop;
    status = sc_alloc(s->ctx, bytes, 1, &gop->payload.data);
    if (status != SC_OK)
        stop_with(s, status);
}

/* Add the piece in the inbox to the payload of the GOP that is arriving from its rank; there is
 * only one. With the last piece, give the GOP to the thread that accepts it. */
static void receive_piece(server *s, const sc_message *mail)
{
    sc_gop **link = &s->arriving, *gop;

    while (*link && (*link)->source != mail->source)
        link = &(*link)->next;
    gop = *link;
    if (!gop)
        return; /* the GOP failed, or there was no memory for it, and the farm is ending */
    if (gop->payload.data && mail->bytes <= gop->payload.bytes - gop->received_bytes)
        memcpy((char *)gop->payload.data + gop->received_bytes, s->inbox, mail->bytes);
    gop->received_bytes += mail->bytes;
    if (gop->received_bytes < gop->payload.bytes)
        return;
    *link = gop->next;
    if (gop->payload.data) {
        give_gop(s, gop);
    } else {
        s->gops_in_hand--;
        sc_gop_free(gop);
    }
}

/* Handle the result of a work unit of a gathered GOP, whose rows are with its encoder. */
static void receive_gathered(server *s, const sc_result_message *message)
{
    unit_done(s, message->result.render_wall_s);
    if (message->status == SC_OK)
        sc_encoders_unit_done(&s->encoders, &message->unit);
    else
        stop_with(s, (sc_status)message->status);
}

/* Handle what an encoder tells of a frame. */
static void receive_taken(server *s)
{
    sc_taken_message message;

    memcpy(&message, s->inbox, sizeof message);
    if (message.status == SC_OK)
        sc_encoders_take(&s->encoders, &s->handout, &message);
    else
        stop_with(s, (sc_status)message.status);
}

/* Give a frame of a gathered GOP that could not be finished to the accepting thread. */
static void receive_rescued(server *s)
{
    sc_result_message message;
    sc_frame_slot *frame;
    sc_status status;

    memcpy(&message, s->inbox, sizeof message);
    status = sc_rescued_new(s->ctx, s->farm, &message.result, s->inbox + sizeof message, &frame);
    if (status != SC_OK) {
        stop_with(s, status);
        return;
    }
    s->accepting.rescued++;
    sc_worker_thread_give(s->accepting.thread, &frame->accept.task);
}

/* Handle the result in the inbox, described by @p mail: of a GOP, or of a frame or band, whose rows
 * are copied into their slot unless the rank has written them there itself. */
static void receive_result(server *s, const sc_message *mail)
{
    sc_result_message message;

    memcpy(&message, s->inbox, sizeof message);
    if (message.stop)
        stop_with(s, SC_ERR_INCOMPLETE);
    if (message.unit.kind == SC_UNIT_GOP) {
        receive_gop(s, mail->source, &message);
        return;
    }
    learn_drawing(s, &message.unit, &message.result);
    if (message.unit.encoder > 0) {
        receive_gathered(s, &message);
        return;
    }
    if (mail->bytes > sizeof message)
        memcpy(slot_of(s, message.unit.index)->image.rgb +
                   (size_t)message.unit.row * sc_farm_row_bytes(s->farm),
               s->inbox + sizeof message, mail->bytes - sizeof message);
    else
        /* The rank has written its rows into the slot, or failed; see send_rows in worker.c. */
        __atomic_thread_fence(__ATOMIC_SEQ_CST);
    rows_done(s, &message.unit, &message.result, (sc_status)message.status);
}

/* Handle a message of one word, which is in the inbox: in most of them it tells of a stop. */
static void receive_word(server *s, const sc_message *mail)
{
    int32_t stop = 0;

    memcpy(&stop, s->inbox, sizeof stop);
    if (stop)
        stop_with(s, SC_ERR_INCOMPLETE);
    if (mail->tag == SC_TAG_READY)
        s->waiting.ready[s->waiting.ready_count++] = mail->source;
    s->waiting.byes += mail->tag == SC_TAG_BYE;
    s->encoders.yielding -= mail->tag == SC_TAG_YIELDED;
}

/* Receive one message into the inbox and handle it, if one has arrived. A rank that asks for work
 * is put at the end of s->waiting.ready. @return false if none has arrived, or if so many rescued
 * frames wait that no more are received before one is accepted. */
static bool receive_message(server *s)
{
    sc_message mail;

    if (s->accepting.rescued >= RESCUED_MOST || !sc_comm_poll(s->comm, &mail))
        return false;
    sc_comm_receive(s->comm, &mail, s->inbox);
    if (mail.tag == SC_TAG_RESULT)
        receive_result(s, &mail);
    else if (mail.tag == SC_TAG_PIECE)
        receive_piece(s, &mail);
    else if (mail.tag == SC_TAG_TAKEN)
        receive_taken(s);
    else if (mail.tag == SC_TAG_RESCUED)
        receive_rescued(s);
    else
        receive_word(s, &mail);
    return true;
}

/* ---- hand-out ---- */

/* Send a work unit to a rank that has asked for one; returns at once. */
static void answer(server *s, int rank, const sc_work_unit *unit)
{
    const int slot = s->waiting.next_answer[rank]++ % SC_UNITS_PER_RANK;
    sc_work_unit *word = &s->waiting.answers[rank * SC_UNITS_PER_RANK + slot];

    *word = *unit;
    sc_comm_post(s->comm, rank, SC_TAG_UNIT, word, sizeof *word);
}

/* Hand out the next work unit, as sc_handout_next, and prepare the slot of a frame or band. */
static sc_handout_answer next_unit(server *s, sc_work_unit *unit)
{
    const sc_handout_answer found = sc_handout_next(&s->handout, unit);

    if (found == SC_HANDOUT_UNIT && unit->kind != SC_UNIT_GOP && unit->encoder == 0)
        begin_slot(s, unit);
    return found;
}

/* @return whether a work unit may be given to the drawing thread of this rank: only if no other
 * rank waits for work, and if the one that is drawn here ends soon. And not while half the window
 * waits to be accepted, because then encoding needs the cores more. Frames of gathered GOPs are not
 * drawn here: this rank sends no pixels, so that its main thread answers at once. */
static bool may_draw_here(server *s)
{
    const int waiting = s->accepting.next - s->handout.accepted;
    const int load = sc_worker_thread_load(s->own.thread);

    if (s->waiting.ready_count > 0 || waiting > s->handout.window / 2 ||
        sc_handout_gathers_next(&s->handout))
        return false;
    return load == 0 ||
           (load < SC_UNITS_PER_RANK && sc_worker_thread_task_age_s(s->own.thread) >=
                                            sc_handout_ask_age_s(s->own.rows, s->own.row_s));
}

/* Give work units to the worker thread that draws on this rank, as far as may_draw_here and the
 * hand-out allow. A frame is drawn into its slot, and so is a band, unless drawing would spoil rows
 * that other ranks draw: then into own.bands. */
static void draw_here(server *s)
{
    sc_work_unit unit;

    for (int i = 0; i < SC_UNITS_PER_RANK; i++) {
        sc_draw_task *task = &s->own.tasks[i];

        if (s->own.used[i] || !may_draw_here(s))
            continue;
        if (next_unit(s, &unit) != SC_HANDOUT_UNIT)
            return;
        s->own.used[i] = true;
        *task = (sc_draw_task){.unit = unit, .results = task->results};
        task->image = unit.kind == SC_UNIT_BAND && s->farm->spoils_other_rows
                          ? &s->own.bands[i]
                          : &slot_of(s, unit.index)->image;
        s->own.rows = sc_farm_unit_rows(s->farm, &unit);
        sc_worker_thread_give(s->own.thread, &task->task);
    }
}

/* Give a GOP that was drawn here to the thread that accepts it, unless it was given up; takes
 * ownership of its payload. Errors stop the farm. */
static void own_gop_done(server *s, const sc_draw_task *task)
{
    const int count = sc_farm_gop_frames(s->farm, task->unit.index);
    sc_gop *gop;
    double wall_s = 0;

    for (int i = 0; i < count; i++) {
        wall_s += task->results[i].render_wall_s;
        s->times->render_cpu_s += task->results[i].render_cpu_s;
    }
    s->times->render_wall_s += wall_s;
    unit_done(s, wall_s);
    if (task->status != SC_OK)
        stop_with(s, task->status);
    gop = task->payload.bytes > 0 && task->status == SC_OK ? begin_gop(s, task->results, count)
                                                           : NULL;
    if (!gop) {
        sc_free(task->payload.data);
        return;
    }
    gop->payload = task->payload;
    give_gop(s, gop);
}

/* Collect one work unit that was drawn on this rank: rows that are not in their slot yet are copied
 * there, a GOP is given to the accepting thread. @return false if none is finished. */
static bool collect_own(server *s)
{
    sc_draw_task *task = (sc_draw_task *)sc_worker_thread_collect(s->own.thread);
    const size_t row_bytes = sc_farm_row_bytes(s->farm);

    if (!task)
        return false;
    s->own.used[task - s->own.tasks] = false;
    s->own.row_s = task->task.wall_s / sc_farm_unit_rows(s->farm, &task->unit);
    if (task->unit.kind == SC_UNIT_GOP) {
        own_gop_done(s, task);
        return true;
    }
    if (task->image == &s->own.bands[task - s->own.tasks]) {
        const size_t at = (size_t)task->unit.row * row_bytes;

        memcpy(slot_of(s, task->unit.index)->image.rgb + at, task->image->rgb + at,
               (size_t)task->unit.rows * row_bytes);
    }
    s->times->render_wall_s += task->result.render_wall_s;
    s->times->render_cpu_s += task->result.render_cpu_s;
    learn_drawing(s, &task->unit, &task->result);
    rows_done(s, &task->unit, &task->result, task->status);
    return true;
}

/* Hand out work units to the ranks that wait, oldest first, then to this one. Ranks for which there
 * is none go on waiting. */
static void hand_out(server *s)
{
    const sc_encoders *e = &s->encoders;
    int served = 0;
    sc_work_unit unit;

    s->handout.encoders = sc_handout_encoders(
        s->handout.work.ranks, e->rows > 0 ? e->draw_s / e->rows * s->farm->height_px : 0,
        e->frames > 0 ? e->encode_s / e->frames : 0);
    while (served < s->waiting.ready_count && next_unit(s, &unit) == SC_HANDOUT_UNIT)
        answer(s, s->waiting.ready[served++], &unit);
    s->waiting.ready_count -= served;
    memmove(s->waiting.ready, s->waiting.ready + served,
            (size_t)s->waiting.ready_count * sizeof *s->waiting.ready);
    draw_here(s);
}

/* ---- the loop ---- */

/* @return whether a work unit that is begun now would be accepted after the deadline only. It may
 * have to wait until its rank has drawn another one, and until all frames before it are accepted,
 * those of gathered GOPs included, which cannot be finished then.
 */
static bool is_late(const server *s)
{
    const int waiting = s->handout.next_frame - s->handout.accepted + s->handout.next_gathered -
                        s->accepting.gathered;

    return s->farm->deadline_s > 0 &&
           sc_wall_s() + SC_UNITS_PER_RANK * s->unit_s + (waiting + 1) * s->accept_s >
               s->farm->deadline_s;
}

/* @return whether everything that was handed out is accepted and nothing more will go out. */
static bool is_done(server *s)
{
    return sc_encoders_have_yielded(&s->encoders, &s->handout) && s->accepting.rescued == 0 &&
           s->gops_in_hand == 0 && !s->arriving && s->handout.accepted == s->handout.next_frame;
}

/* @return the number of frames that the farm is to draw, those of GOPs included. */
static int frames_in_all(const server *s)
{
    int total = s->farm->frame_count;

    for (int i = 0; i < s->farm->gop_count; i++)
        total += sc_farm_gop_frames(s->farm, i);
    return total;
}

/* The loop of the main thread, until everything that was handed out is accepted; s->status is the
 * outcome. After a stop or an error no more is begun, and what is out is waited for. */
static void serve(server *s)
{
    const int total = frames_in_all(s);
    double nap_s = SC_NAP_S, told_s = 0;

    while (!is_done(s)) {
        const double begin_s = sc_wall_s(), begin_cpu_s = sc_thread_cpu_s();
        bool busy = false;

        if (*s->farm->stop || is_late(s))
            stop_with(s, SC_ERR_INCOMPLETE);
        while (receive_message(s))
            busy = true;
        busy = collect_own(s) || busy;
        busy = collect_accepted(s) || busy;
        busy = give_full_frames(s) || busy;
        hand_out(s);
        s->times->gather_wall_s += busy ? sc_wall_s() - begin_s : 0;
        s->times->gather_cpu_s += sc_thread_cpu_s() - begin_cpu_s;
        if (s->farm->calls.on_progress && begin_s > told_s + PROGRESS_INTERVAL_S) {
            s->farm->calls.on_progress(s->farm->calls.user, s->accepting.frames, total);
            told_s = begin_s;
        }
        if (busy) {
            nap_s = SC_NAP_S;
            continue;
        }
        nap_s = nap_s < LONGEST_NAP_S ? nap_s * SC_NAP_GROWTH : nap_s;
        sc_sleep_s(nap_s);
    }
}

/* Answer every rank that asks with SC_UNIT_NONE; blocks until all have sent SC_TAG_BYE. */
static void dismiss(server *s)
{
    const int workers = sc_comm_size(s->comm) - 1;
    const sc_work_unit none = {.kind = SC_UNIT_NONE};

    while (s->waiting.byes < workers) {
        bool busy = receive_message(s);

        while (s->waiting.ready_count > 0) {
            answer(s, s->waiting.ready[--s->waiting.ready_count], &none);
            busy = true;
        }
        if (!busy)
            sc_sleep_s(SC_NAP_S);
    }
    sc_comm_flush(s->comm);
}

/* Allocate s->slots, and where the window is not shared their pictures. Needs handout.window. */
static sc_status open_slots(server *s)
{
    const sc_farm *farm = s->farm;

    SC_PASS(SC_ZALLOC(s->ctx, (size_t)s->handout.window, &s->slots));
    for (int i = 0; i < s->handout.window; i++) {
        if (s->shared->pixels)
            s->slots[i].image = sc_slot_image(s->shared, farm, i);
        else
            SC_PASS(sc_image_init_alpha(s->ctx, farm->width_px, farm->height_px, farm->alpha,
                                        &s->slots[i].image));
    }
    return SC_OK;
}

/* Allocate everything and start both worker threads; the caller calls close_server, also after an
 * error. Sends nothing. @return SC_ERR_MEMORY. */
static sc_status open_server(server *s)
{
    const sc_farm *farm = s->farm;
    const sc_work work = sc_farm_work(farm, s->comm);
    const size_t ranks = (size_t)work.ranks;

    s->handout = sc_handout_begin(&work);
    s->accepting.acceptor.farm = farm;
    SC_PASS(sc_encoders_open(s->ctx, s->comm, &s->handout, &s->encoders));
    SC_PASS(open_slots(s));
    SC_PASS(sc_alloc(s->ctx, sc_farm_message_bytes(farm), 1, &s->inbox));
    SC_PASS(SC_ALLOC(s->ctx, ranks * SC_UNITS_PER_RANK, &s->waiting.ready));
    SC_PASS(SC_ALLOC(s->ctx, ranks * SC_UNITS_PER_RANK, &s->waiting.answers));
    SC_PASS(SC_ZALLOC(s->ctx, ranks, &s->waiting.next_answer));
    for (int i = 0; i < SC_UNITS_PER_RANK; i++) {
        if (farm->spoils_other_rows)
            SC_PASS(sc_image_init_alpha(s->ctx, farm->width_px, farm->height_px, farm->alpha,
                                        &s->own.bands[i]));
        SC_PASS(sc_alloc(s->ctx, (size_t)farm->gop_frames + 1, sizeof(sc_frame_result),
                         &s->own.tasks[i].results));
    }
    SC_PASS(sc_worker_thread_start(s->ctx, sc_accept_task_run, &s->accepting.acceptor,
                                   &s->accepting.thread));
    return sc_worker_thread_start(s->ctx, sc_draw_task_run, (void *)(uintptr_t)farm,
                                  &s->own.thread);
}

/* Wait for the worker threads to end, add the idle time of the drawing one to times, and free
 * everything. */
static void close_server(server *s)
{
    s->times->idle_s += sc_worker_thread_stop(s->own.thread);
    (void)sc_worker_thread_stop(s->accepting.thread);
    for (int i = 0; s->slots && !s->shared->pixels && i < s->handout.window; i++)
        sc_image_clear(&s->slots[i].image);
    for (int i = 0; i < SC_UNITS_PER_RANK; i++) {
        sc_image_clear(&s->own.bands[i]);
        sc_free(s->own.tasks[i].results);
    }
    sc_free(s->slots);
    sc_free(s->inbox);
    sc_free(s->waiting.ready);
    sc_free(s->waiting.answers);
    sc_free(s->waiting.next_answer);
    sc_encoders_clear(&s->encoders);
}

sc_status sc_farm_serve(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm,
                        const sc_slots *slots, sc_farm_times *times)
{
    server s = {.ctx = ctx, .comm = comm, .farm = farm, .shared = slots, .times = times};
    sc_status status = sc_comm_agree(comm, open_server(&s));

    if (status == SC_OK) {
        serve(&s);
        dismiss(&s);
        status = s.status;
        if (status == SC_ERR_INCOMPLETE && s.accepting.frames == frames_in_all(&s))
            status = SC_OK; /* the stop came too late to change anything */
    }
    close_server(&s);
    return status;
}
