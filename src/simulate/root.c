/* SPDX-License-Identifier: BSD-3-Clause */
/* The main thread of simulated rank 0: as that of the farm (see server.c there), it handles
 * messages one after the other, hands out work units, and gives full frames in order to the thread
 * that accepts them. */
#include "internal.h"

/* @return the bytes of a message that count. */
static double bytes_of(const sim_farm *f, const sim_event *e)
{
    const sc_sim_film *film = f->film;

    if (e->unit.kind == SC_UNIT_GOP)
        return film->frame_file_bytes * film->gop_frames;
    if (e->unit.kind == SC_UNIT_NONE || (e->unit.encoder > 0 && !e->gathered))
        return 0;
    return (double)sc_pixel_bytes(film->alpha) * film->width_px * e->unit.rows;
}

void sc_sim_arrive(sim_farm *f, const sim_event *e)
{
    const sc_sim_machine *m = f->machine;
    const int target = e->gathered ? e->unit.encoder : 0;
    const double bytes = bytes_of(f, e), transfer_s = sc_sim_transfer_s(m, e->rank, target, bytes);
    /* Ranks of the same node draw into the window of rank 0. From others pixels come when the main
     * thread receives them, one message at a time. */
    const bool shared = target == 0 ? e->rank < m->ranks_per_node : e->rank == target;
    const double copy_s = !shared && m->copy_bytes_per_s > 0 ? bytes / m->copy_bytes_per_s : 0;
    double *free_s = &f->ranks[target].main_free_s;
    const double begin_s = *free_s > f->now_s ? *free_s : f->now_s;
    sim_event handled = *e;

    *free_s = begin_s + (e->rank != target ? m->message_s : 0) +
              (transfer_s > copy_s ? transfer_s : copy_s);
    if (target == 0) {
        f->out->busy_s.message += *free_s - begin_s;
        f->out->busy_s.link += transfer_s;
    }
    handled.kind = SIM_HANDLED;
    handled.time_s = *free_s;
    sc_sim_push(&f->events, handled);
}

/* Let the accepting thread begin the next frame, if it has none, and the frame is full. */
static void accept_next(sim_farm *f)
{
    if (f->ranks[0].encoding.busy || f->next_to_accept == f->handout.work.frames ||
        f->rows_left[f->next_to_accept] > 0)
        return;
    f->next_to_accept++;
    f->accept_begin_s = f->now_s;
    sc_sim_begin_encoding(f, 0);
}

void sc_sim_accepted(sim_farm *f)
{
    const double took_s = f->now_s - f->accept_begin_s;

    f->accepted++;
    f->out->busy_s.accept += took_s;
    f->costs.encoded_s += took_s;
    f->costs.encoded++;
    sc_sim_push(&f->events,
                (sim_event){.time_s = f->now_s + f->machine->notice_s, .kind = SIM_NOTICED});
    accept_next(f);
}

/* @return whether rank 0 may draw one more work unit; as may_draw_here of the farm. */
static bool may_draw_here(const sim_farm *f)
{
    const sim_rank *r = &f->ranks[0];
    const int waiting = f->next_to_accept - f->handout.accepted;

    if (f->ready.count > 0 || waiting > f->handout.window / 2 || r->in_hand >= SC_UNITS_PER_RANK ||
        sc_handout_gathers_next(&f->handout))
        return false;
    return r->in_hand == 0 || f->now_s >= r->ask_s;
}

void sc_sim_hand_out(sim_farm *f)
{
    const sc_sim_film *film = f->film;
    const int ranks = f->machine->ranks;
    sc_work_unit unit;

    f->handout.encoders = sc_handout_encoders(
        ranks,
        f->costs.drawn_rows > 0 ? f->costs.drawn_s / f->costs.drawn_rows * film->height_px : 0,
        f->costs.encoded > 0 ? f->costs.encoded_s / f->costs.encoded : 0);
    while (f->ready.count > 0) {
        const int rank = f->ready.ranks[f->ready.first];
        const sc_handout_answer found = sc_handout_next(&f->handout, &unit);

        if (found == SC_HANDOUT_WAIT)
            f->ranks[rank].window_full = true;
        if (found != SC_HANDOUT_UNIT)
            return;
        f->ready.first = (f->ready.first + 1) % ranks;
        f->ready.count--;
        f->out->units++;
        if (unit.encoder > 0)
            sc_sim_note_gathered(f, &unit);
        sc_sim_push(&f->events,
                    (sim_event){.time_s = f->now_s + f->machine->latency_s + f->machine->notice_s,
                                .kind = SIM_UNIT,
                                .rank = rank,
                                .unit = unit});
    }
    while (may_draw_here(f) && sc_handout_next(&f->handout, &unit) == SC_HANDOUT_UNIT) {
        f->out->units++;
        sc_sim_receive_unit(f, 0, &unit);
    }
}

/* Count the rows of a frame for rank 0. */
static void frame_rows_done(sim_farm *f, const sc_work_unit *unit)
{
    f->rows_left[unit->index] -= unit->rows;
    if (f->rows_left[unit->index] > 0)
        return;
    f->full++;
    if (f->full - f->accepted > f->out->held)
        f->out->held = f->full - f->accepted;
    accept_next(f);
}

void sc_sim_handle(sim_farm *f, const sim_event *e)
{
    if (e->unit.kind == SC_UNIT_NONE) {
        f->ready.ranks[(f->ready.first + f->ready.count++) % f->machine->ranks] = e->rank;
        return;
    }
    if (e->gathered) {
        sc_sim_gather(f, &e->unit);
        return;
    }
    sc_handout_unit_done(&f->handout);
    if (e->unit.kind == SC_UNIT_GOP)
        return;
    f->costs.drawn_s += e->seconds;
    f->costs.drawn_rows += e->unit.rows;
    if (e->unit.encoder == 0)
        frame_rows_done(f, &e->unit);
}
