/* SPDX-License-Identifier: BSD-3-Clause */
/* Rank 0's main thread: hands out units, gathers frames into a window of slots, and passes them on
 * in order to a thread that takes them. Its own drawing runs in a thread beside it and is served
 * last. Nothing here waits for a picture to be drawn, encoded or written. */
#include "internal.h"

#include <string.h>

/* Something to be taken: a slot's frame, or a group. */
typedef struct take_job {
    sc_lane_job lane;
    bool is_group;
    sc_image image; /* of a slot */
    sc_frame_result result;
    int rows_missing;
    bool split, full;
    sc_status drawn; /* an error: rows of it could not be drawn */
    /* of a group, which is allocated for it */
    struct take_job *next;
    sc_frame_result *results;
    int count;
    sc_payload payload;
    size_t received_bytes;
    int source;
    sc_status status;
} take_job;

enum { LOCAL_JOBS = 2 };

typedef struct server {
    const sc_ctx *ctx;
    sc_comm *comm;
    const sc_farm *farm;
    const sc_slots *shared;
    sc_farm_times *times;
    sc_handout handout;
    take_job *slots;    /* [window]; frame i waits in slot i % window */
    take_job *arriving; /* groups whose payload is on its way */
    int next_to_take;   /* frames given to the taking thread so far */
    int groups_taken_frames, groups_in_hand;
    char *inbox; /* one message with its pixels */
    sc_lane *drawing, *taking;
    sc_draw_job local[LOCAL_JOBS];
    bool local_used[LOCAL_JOBS];
    double local_rows, local_row_s;   /* of the newest unit; what a row lately cost */
    sc_image local_bands[LOCAL_JOBS]; /* where drawing spoils other rows */
    int *ready;                       /* ranks that wait for a unit, oldest first */
    int ready_count, ready_capacity;
    sc_unit *answers; /* [ready_capacity] of posted messages, which must stay */
    int answer_next;
    int byes;
    double unit_s, take_s; /* what they lately cost, at most */
    sc_status take_status; /* of the taking thread alone */
    sc_status status;
} server;

static void stop_with(server *s, sc_status status)
{
    s->handout.stopped = true;
    if (s->status == SC_OK || (s->status == SC_ERR_INCOMPLETE && status != SC_OK))
        s->status = status;
}

/* ---- taking, on its own thread ---- */

static void take(void *user, sc_lane_job *lane_job)
{
    server *s = user;
    take_job *job = (take_job *)lane_job;
    const sc_farm *farm = s->farm;

    job->status = SC_OK;
    if (s->take_status != SC_OK)
        return; /* an error has ended the job; what comes now is not kept */
    if (job->drawn != SC_OK) {
        job->status = job->drawn; /* nor is what follows a frame that could not be drawn */
    } else if (job->is_group) {
        job->status = farm->take_group(farm->user, job->results, job->count, &job->payload);
    } else {
        if (job->split)
            job->result.hash = sc_image_hash(&job->image);
        job->status = farm->take(farm->user, &job->result, &job->image);
    }
    s->take_status = job->status;
}

static void free_group(take_job *job)
{
    sc_free(job->results);
    sc_free(job->payload.data);
    sc_free(job);
}

static bool collect_taken(server *s)
{
    take_job *job = (take_job *)sc_lane_collect(s->taking);

    if (!job)
        return false;
    s->times->take_wall_s += job->lane.wall_s;
    s->take_s = job->lane.wall_s > 0.95 * s->take_s ? job->lane.wall_s : 0.95 * s->take_s;
    if (job->status != SC_OK)
        stop_with(s, job->status);
    if (job->is_group) {
        s->groups_taken_frames += job->count;
        s->groups_in_hand--;
        free_group(job);
    } else {
        job->full = false;
        s->handout.taken++;
    }
    return true;
}

/* ---- what comes back ---- */

static take_job *slot_of(server *s, int index)
{
    return &s->slots[index % s->handout.window];
}

static void begin_slot(server *s, const sc_unit *unit)
{
    take_job *slot = slot_of(s, unit->index);

    if (unit->row > 0)
        return;
    slot->split = unit->kind == SC_UNIT_BAND;
    slot->rows_missing = s->farm->height_px;
    slot->drawn = SC_OK;
    slot->result = (sc_frame_result){.frame = s->farm->frames[unit->index]};
}

static void add_result(take_job *slot, const sc_frame_result *part)
{
    sc_frame_result *sum = &slot->result;

    sum->rank = part->rank;
    sum->render_wall_s += part->render_wall_s;
    sum->render_cpu_s += part->render_cpu_s;
    sum->wait_s += part->wait_s;
    sum->rays += part->rays;
    sum->samples += part->samples;
    sum->contributions += part->contributions;
    sum->hash = part->hash;
}

static void note_unit(server *s, double wall_s)
{
    s->unit_s = wall_s > 0.95 * s->unit_s ? wall_s : 0.95 * s->unit_s;
}

/* Rows of a frame are in their slot, unless @p drawn says that they could not be drawn. */
static void rows_came(server *s, const sc_unit *unit, const sc_frame_result *result,
                      sc_status drawn)
{
    take_job *slot = slot_of(s, unit->index);

    add_result(slot, result);
    if (drawn != SC_OK) {
        slot->drawn = drawn;
        stop_with(s, drawn);
    }
    slot->rows_missing -= unit->rows;
    slot->full = slot->rows_missing == 0;
    sc_handout_back(&s->handout);
    note_unit(s, result->render_wall_s);
}

/* Frames are taken in order. */
static bool give_to_taker(server *s)
{
    bool any = false;

    while (s->next_to_take < s->handout.next_frame && slot_of(s, s->next_to_take)->full &&
           s->next_to_take < s->handout.taken + s->handout.window) {
        sc_lane_give(s->taking, &slot_of(s, s->next_to_take)->lane);
        s->next_to_take++;
        any = true;
    }
    return any;
}

/* A group that is to be taken when its payload is here. */
static sc_status new_group(server *s, const sc_frame_result *results, int count, take_job **out)
{
    void *block = NULL, *copy = NULL;
    take_job *job;
    sc_status status;

    SC_TRY(sc_zalloc(s->ctx, 1, sizeof *job, &block));
    SC_TRY(sc_alloc(s->ctx, (size_t)count, sizeof *results, &copy));
    memcpy(copy, results, (size_t)count * sizeof *results);
    job = block;
    *job = (take_job){.is_group = true, .count = count, .results = copy};
    s->groups_in_hand++;
    *out = job;
    return SC_OK;
out:
    sc_free(block);
    stop_with(s, status);
    return status;
}

static void give_group(server *s, take_job *job)
{
    sc_lane_give(s->taking, &job->lane);
}

/* A group's payload is to come, unless it was given up. */
static void group_came(server *s, const sc_message *mail, const sc_done_message *message)
{
    const int count = sc_farm_group_count(s->farm, message->unit.index);
    const size_t results_bytes = (size_t)count * sizeof(sc_frame_result);
    uint64_t bytes;
    take_job *job;
    sc_status status = (sc_status)message->status;

    memcpy(&bytes, s->inbox + sizeof *message + results_bytes, sizeof bytes);
    sc_handout_back(&s->handout);
    note_unit(s, message->result.render_wall_s);
    if (status != SC_OK)
        stop_with(s, status);
    if (bytes == 0 ||
        new_group(s, (sc_frame_result *)(s->inbox + sizeof *message), count, &job) != SC_OK)
        return;
    job->source = mail->source;
    job->payload.bytes = bytes;
    job->next = s->arriving;
    s->arriving = job;
    status = sc_alloc(s->ctx, bytes, 1, &job->payload.data); /* else its pieces are dropped */
    if (status != SC_OK)
        stop_with(s, status);
}

static void piece_came(server *s, const sc_message *mail)
{
    take_job **link = &s->arriving, *job;

    while (*link && (*link)->source != mail->source)
        link = &(*link)->next;
    job = *link;
    if (!job)
        return; /* there was no memory for it, and the job ends */
    if (job->payload.data && mail->bytes <= job->payload.bytes - job->received_bytes)
        memcpy((char *)job->payload.data + job->received_bytes, s->inbox, mail->bytes);
    job->received_bytes += mail->bytes;
    if (job->received_bytes < job->payload.bytes)
        return;
    *link = job->next;
    if (job->payload.data) {
        give_group(s, job);
    } else {
        s->groups_in_hand--;
        free_group(job);
    }
}

static void work_came(server *s, const sc_message *mail)
{
    sc_done_message message;

    memcpy(&message, s->inbox, sizeof message);
    if (message.stop)
        stop_with(s, SC_ERR_INCOMPLETE);
    if (message.unit.kind == SC_UNIT_GROUP) {
        group_came(s, mail, &message);
        return;
    }
    if (mail->bytes > sizeof message)
        memcpy(slot_of(s, message.unit.index)->image.rgb +
                   (size_t)message.unit.row * (size_t)s->farm->width_px * 3,
               s->inbox + sizeof message, mail->bytes - sizeof message);
    else
        __atomic_thread_fence(__ATOMIC_SEQ_CST); /* a neighbour wrote them, before the message */
    rows_came(s, &message.unit, &message.result, (sc_status)message.status);
}

/* One message, if there is one. */
static bool read_mail(server *s)
{
    sc_message mail;
    int32_t stop = 0;

    if (!sc_comm_poll(s->comm, &mail))
        return false;
    sc_comm_receive(s->comm, &mail, s->inbox);
    if (mail.tag == SC_TAG_DONE) {
        work_came(s, &mail);
    } else if (mail.tag == SC_TAG_PIECE) {
        piece_came(s, &mail);
    } else {
        memcpy(&stop, s->inbox, sizeof stop);
        if (stop)
            stop_with(s, SC_ERR_INCOMPLETE);
        if (mail.tag == SC_TAG_READY)
            s->ready[s->ready_count++] = mail.source;
        s->byes += mail.tag == SC_TAG_BYE;
    }
    return true;
}

static void local_group_came(server *s, sc_draw_job *job)
{
    const int count = sc_farm_group_count(s->farm, job->unit.index);
    take_job *group;
    double wall_s = 0;

    for (int i = 0; i < count; i++) {
        wall_s += job->results[i].render_wall_s;
        s->times->render_cpu_s += job->results[i].render_cpu_s;
    }
    s->times->render_wall_s += wall_s;
    note_unit(s, wall_s);
    sc_handout_back(&s->handout);
    if (job->status != SC_OK)
        stop_with(s, job->status);
    if (job->payload.bytes == 0 || new_group(s, job->results, count, &group) != SC_OK) {
        sc_free(job->payload.data);
        return;
    }
    group->payload = job->payload;
    give_group(s, group);
}

static bool collect_local(server *s)
{
    sc_draw_job *job = (sc_draw_job *)sc_lane_collect(s->drawing);
    const size_t row_bytes = (size_t)s->farm->width_px * 3;

    if (!job)
        return false;
    s->local_used[job - s->local] = false;
    s->local_row_s = job->lane.wall_s / sc_farm_rows(s->farm, &job->unit);
    if (job->image && job->image == &s->local_bands[job - s->local]) {
        const size_t at = (size_t)job->unit.row * row_bytes;

        memcpy(slot_of(s, job->unit.index)->image.rgb + at, job->image->rgb + at,
               (size_t)job->unit.rows * row_bytes);
    }
    if (job->unit.kind == SC_UNIT_GROUP) {
        local_group_came(s, job);
        return true;
    }
    s->times->render_wall_s += job->result.render_wall_s;
    s->times->render_cpu_s += job->result.render_cpu_s;
    rows_came(s, &job->unit, &job->result, job->status);
    return true;
}

/* ---- hand-out ---- */

static void answer(server *s, int rank, const sc_unit *unit)
{
    sc_unit *word = &s->answers[s->answer_next++ % s->ready_capacity];

    *word = *unit;
    sc_comm_post(s->comm, rank, SC_TAG_UNIT, word, sizeof *word);
}

/* The next unit, its slot ready. */
static sc_handout_answer next_unit(server *s, sc_unit *unit)
{
    const sc_handout_answer found = sc_handout_next(&s->handout, unit);

    if (found == SC_HANDOUT_UNIT && unit->kind != SC_UNIT_GROUP)
        begin_slot(s, unit);
    return found;
}

/* Rank 0 draws when all others have work; it gives way to encoding when much waits for that. */
static bool may_draw_here(server *s)
{
    const int waiting = s->next_to_take - s->handout.taken;
    const int load = sc_lane_load(s->drawing);

    if (s->ready_count > 0 || waiting > s->handout.window / 2)
        return false;
    return load == 0 || (load < LOCAL_JOBS &&
                         s->local_rows * s->local_row_s - sc_lane_age_s(s->drawing) < SC_LEAD_S);
}

static void draw_here(server *s)
{
    sc_unit unit;

    for (int i = 0; i < LOCAL_JOBS; i++) {
        sc_draw_job *job = &s->local[i];

        if (s->local_used[i] || !may_draw_here(s))
            continue;
        if (next_unit(s, &unit) != SC_HANDOUT_UNIT)
            return;
        s->local_used[i] = true;
        *job = (sc_draw_job){.unit = unit, .results = job->results};
        job->image = unit.kind == SC_UNIT_BAND && s->farm->spoils_other_rows
                         ? &s->local_bands[i]
                         : &slot_of(s, unit.index)->image;
        s->local_rows = sc_farm_rows(s->farm, &unit);
        sc_lane_give(s->drawing, &job->lane);
    }
}

/* Give units to all who wait, first come first served; rank 0's own thread last. */
static void hand_out(server *s)
{
    int served = 0;
    sc_unit unit;

    while (served < s->ready_count && next_unit(s, &unit) == SC_HANDOUT_UNIT)
        answer(s, s->ready[served++], &unit);
    s->ready_count -= served;
    memmove(s->ready, s->ready + served, (size_t)s->ready_count * sizeof *s->ready);
    draw_here(s);
}

/* ---- the loop ---- */

/* Would a unit that begins now, behind one that is in work, still be taken in time? */
static bool is_late(const server *s)
{
    const int waiting = s->handout.next_frame - s->handout.taken;

    return s->farm->deadline_s > 0 &&
           sc_wall_s() + 2 * s->unit_s + (waiting + 1) * s->take_s > s->farm->deadline_s;
}

static bool is_done(server *s)
{
    return sc_handout_finished(&s->handout) && s->groups_in_hand == 0 && !s->arriving &&
           s->handout.taken == s->handout.next_frame;
}

static int frames_done(const server *s)
{
    return s->handout.taken + s->groups_taken_frames;
}

static int frames_in_all(const server *s)
{
    int total = s->farm->frame_count;

    for (int i = 0; i < s->farm->group_count; i++)
        total += sc_farm_group_count(s->farm, i);
    return total;
}

static void serve(server *s)
{
    const int total = frames_in_all(s);
    double nap_s = 50e-6, tick_s = 0;

    while (!is_done(s)) {
        const double begin_s = sc_wall_s(), begin_cpu_s = sc_thread_cpu_s();
        bool busy = false;

        if (*s->farm->stop || is_late(s))
            stop_with(s, SC_ERR_INCOMPLETE);
        while (read_mail(s))
            busy = true;
        busy = collect_local(s) || busy;
        busy = collect_taken(s) || busy;
        busy = give_to_taker(s) || busy;
        hand_out(s);
        s->times->gather_wall_s += busy ? sc_wall_s() - begin_s : 0;
        s->times->gather_cpu_s += sc_thread_cpu_s() - begin_cpu_s;
        if (s->farm->tick && begin_s > tick_s + 0.1) {
            s->farm->tick(s->farm->user, frames_done(s), total);
            tick_s = begin_s;
        }
        nap_s = busy ? 50e-6 : nap_s < 0.7e-3 ? nap_s * 1.5 : nap_s;
        if (!busy)
            sc_sleep_s(nap_s);
    }
}

/* Every worker that waits is sent home; each says bye when it has all its answers. */
static void dismiss(server *s)
{
    const int workers = sc_comm_size(s->comm) - 1;
    const sc_unit home = {.kind = SC_UNIT_NONE};

    while (s->byes < workers) {
        bool busy = read_mail(s);

        while (s->ready_count > 0) {
            answer(s, s->ready[--s->ready_count], &home);
            busy = true;
        }
        if (!busy)
            sc_sleep_s(50e-6);
    }
    sc_comm_flush(s->comm);
}

static sc_status open_server(server *s)
{
    const sc_farm *farm = s->farm;
    const sc_work work = sc_farm_amount(farm, s->comm);
    void *block;
    sc_status status;

    s->handout = sc_handout_begin(&work);
    s->ready_capacity = work.ranks * 8;
    SC_TRY(sc_zalloc(s->ctx, (size_t)s->handout.window, sizeof *s->slots, &block));
    s->slots = block;
    for (int i = 0; i < s->handout.window; i++) {
        if (s->shared->pixels)
            s->slots[i].image = sc_slot_image(s->shared, farm, i);
        else
            SC_TRY(sc_image_init(s->ctx, farm->width_px, farm->height_px, &s->slots[i].image));
    }
    SC_TRY(sc_alloc(s->ctx, sc_farm_message_bytes(farm), 1, &block));
    s->inbox = block;
    SC_TRY(sc_alloc(s->ctx, (size_t)s->ready_capacity, sizeof *s->ready, &block));
    s->ready = block;
    SC_TRY(sc_alloc(s->ctx, (size_t)s->ready_capacity, sizeof *s->answers, &block));
    s->answers = block;
    for (int i = 0; i < LOCAL_JOBS && farm->spoils_other_rows; i++)
        SC_TRY(sc_image_init(s->ctx, farm->width_px, farm->height_px, &s->local_bands[i]));
    for (int i = 0; i < LOCAL_JOBS; i++) {
        SC_TRY(sc_alloc(s->ctx, (size_t)farm->group_frames + 1, sizeof(sc_frame_result), &block));
        s->local[i].results = block;
    }
    SC_TRY(sc_lane_start(s->ctx, take, s, &s->taking));
    status = sc_lane_start(s->ctx, sc_farm_draw, (void *)(uintptr_t)farm, &s->drawing);
out:
    return status;
}

static void close_server(server *s)
{
    s->times->idle_s += sc_lane_stop(s->drawing);
    (void)sc_lane_stop(s->taking);
    for (int i = 0; s->slots && !s->shared->pixels && i < s->handout.window; i++)
        sc_image_clear(&s->slots[i].image);
    for (int i = 0; i < LOCAL_JOBS; i++) {
        sc_image_clear(&s->local_bands[i]);
        sc_free(s->local[i].results);
    }
    sc_free(s->slots);
    sc_free(s->inbox);
    sc_free(s->ready);
    sc_free(s->answers);
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
        if (status == SC_ERR_INCOMPLETE && frames_done(&s) == frames_in_all(&s))
            status = SC_OK; /* the stop came when all was done */
    }
    close_server(&s);
    return status;
}
