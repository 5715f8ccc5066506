/* SPDX-License-Identifier: BSD-3-Clause */
/* Simulated encoders: ranks that encode the frames of gathered GOPs, in the order in which they
 * went out (see gather.c of the farm). */
#include "internal.h"

void sc_sim_note_gathered(sim_farm *f, const sc_work_unit *unit)
{
    sim_rank *r = &f->ranks[unit->encoder];

    if (unit->row > 0)
        return;
    f->gathered[unit->index] = (sim_gathered){.rows_left = f->film->height_px,
                                              .next = -1,
                                              .ends_gop = unit->place + 1 == f->film->gop_frames};
    if (f->handout.group.gops > f->out->encoders)
        f->out->encoders = f->handout.group.gops;
    if (r->first < 0)
        r->first = unit->index;
    else
        f->gathered[r->last].next = unit->index;
    r->last = unit->index;
}

/* Let an encoder begin its next frame, if it has none, and the frame is full. */
static void encode_next(sim_farm *f, int rank)
{
    const sim_rank *r = &f->ranks[rank];

    if (r->encoding.busy || r->first < 0 || f->gathered[r->first].rows_left > 0)
        return;
    f->gathered[r->first].begin_s = f->now_s;
    sc_sim_begin_encoding(f, rank);
}

void sc_sim_gather(sim_farm *f, const sc_work_unit *unit)
{
    sim_gathered *frame = &f->gathered[unit->index];

    frame->rows_left -= unit->rows;
    if (frame->rows_left > 0)
        return;
    f->ranks[unit->encoder].behind++;
    encode_next(f, unit->encoder);
}

void sc_sim_encoded(sim_farm *f, int rank)
{
    sim_rank *r = &f->ranks[rank];
    const sim_gathered *frame = &f->gathered[r->first];
    const double seconds = f->now_s - frame->begin_s;
    const double bytes = frame->ends_gop ? f->film->frame_file_bytes * f->film->gop_frames : 0;

    f->out->busy_s.gather += seconds;
    sc_sim_push(&f->events,
                (sim_event){.time_s = f->now_s + 2 * f->machine->notice_s + f->machine->latency_s +
                                      sc_sim_transfer_s(f->machine, rank, 0, bytes),
                            .kind = SIM_TAKEN,
                            .rank = rank,
                            .seconds = seconds,
                            .unit = {.index = r->first}});
    r->behind--;
    r->first = frame->next;
    encode_next(f, rank);
    if (r->held_back)
        sc_sim_ask(f, rank, r->generation);
}

void sc_sim_taken(sim_farm *f, const sim_event *e)
{
    sim_gathered *frame = &f->gathered[e->unit.index];

    frame->taken = true;
    f->gops_left -= frame->ends_gop;
    f->costs.encoded_s += e->seconds;
    f->costs.encoded++;
    while (f->handout.taken < f->handout.next_gathered && f->gathered[f->handout.taken].taken)
        f->handout.taken++;
}
