/* SPDX-License-Identifier: BSD-3-Clause */
/* The main thread of simulated rank 0: as that of the farm (see server.c there), it handles
 * messages one after the other, hands out work units, and gives full frames in order to the thread
 * that accepts them. */
#include "internal.h"

void sc_sim_arrive(sim_farm *f, const sim_event *e)
{
    const sc_sim_machine *m = f->machine;
    const double begin_s = f->main_free_s > f->now_s ? f->main_free_s : f->now_s;
    sim_event handled = *e;
    double bytes = 0, transfer_s, copy_s;

    if (e->unit.kind == SC_UNIT_GOP)
        bytes = f->film->frame_file_bytes * f->film->gop_frames;
    else if (e->unit.kind != SC_UNIT_NONE)
        bytes = 3.0 * f->film->width_px * e->unit.rows;
    /* Ranks of the same node draw into the window of rank 0. From others pixels come when the main
     * thread receives them, one message at a time. */
    transfer_s = sc_sim_transfer_s(m, e->rank, bytes);
    copy_s =
        e->rank >= m->ranks_per_node && m->copy_bytes_per_s > 0 ? bytes / m->copy_bytes_per_s : 0;
    f->main_free_s =
        begin_s + (e->rank > 0 ? m->message_s : 0) + (transfer_s > copy_s ? transfer_s : copy_s);
    f->out->message_busy_s += f->main_free_s - begin_s;
    f->out->link_busy_s += transfer_s;
    handled.kind = SIM_HANDLED;
    handled.time_s = f->main_free_s;
    sc_sim_push(&f->events, handled);
}

/* Let the accepting thread begin the next frame, if it has none, and the frame is full. */
static void accept_next(sim_farm *f)
{
    if (f->accepting.busy || f->next_to_accept == f->handout.frames ||
        f->rows_left[f->next_to_accept] > 0)
        return;
    f->next_to_accept++;
    f->out->accept_busy_s -= f->now_s;
    sc_sim_begin_accepting(f, f->film->encode_wall_s / sc_sim_speed(f->machine, 0));
}

void sc_sim_accepted(sim_farm *f, long generation)
{
    if (!sc_sim_end_accepting(f, generation))
        return;
    f->accepted++;
    f->out->accept_busy_s += f->now_s;
    sc_sim_push(&f->events,
                (sim_event){.time_s = f->now_s + f->machine->notice_s, .kind = SIM_NOTICED});
    accept_next(f);
}

/* @return whether rank 0 may draw one more work unit; as may_draw_here of the farm. */
static bool may_draw_here(const sim_farm *f)
{
    const sim_rank *r = &f->ranks[0];
    const int waiting = f->next_to_accept - f->handout.accepted;

    if (f->ready_count > 0 || waiting > f->handout.window / 2 || r->in_hand >= SC_UNITS_PER_RANK)
        return false;
    return r->in_hand == 0 || f->now_s >= r->ask_s;
}

void sc_sim_hand_out(sim_farm *f)
{
    const int ranks = f->machine->ranks;
    sc_work_unit unit;

    while (f->ready_count > 0) {
        const int rank = f->ready[f->ready_first];
        const sc_handout_answer found = sc_handout_next(&f->handout, &unit);

        if (found == SC_HANDOUT_WAIT)
            f->ranks[rank].window_full = true;
        if (found != SC_HANDOUT_UNIT)
            return;
        f->ready_first = (f->ready_first + 1) % ranks;
        f->ready_count--;
        f->out->units++;
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

void sc_sim_handle(sim_farm *f, const sim_event *e)
{
    if (e->unit.kind == SC_UNIT_NONE) {
        f->ready[(f->ready_first + f->ready_count++) % f->machine->ranks] = e->rank;
        return;
    }
    sc_handout_unit_done(&f->handout);
    if (e->unit.kind == SC_UNIT_GOP)
        return;
    f->rows_left[e->unit.index] -= e->unit.rows;
    if (f->rows_left[e->unit.index] > 0)
        return;
    f->full++;
    if (f->full - f->accepted > f->out->held)
        f->out->held = f->full - f->accepted;
    accept_next(f);
}
