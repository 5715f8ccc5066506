/* SPDX-License-Identifier: BSD-3-Clause */
/* The loop over the events of a simulated farm. */
#include "internal.h"

/* Let an event happen. */
static void happen(sim_farm *f, const sim_event *e)
{
    switch (e->kind) {
    case SIM_ARRIVED:
        sc_sim_arrive(f, e);
        return;
    case SIM_UNIT:
        sc_sim_receive_unit(f, e->rank, &e->unit);
        return;
    case SIM_HANDLED:
        sc_sim_handle(f, e);
        if (e->gathered)
            return;
        break;
    case SIM_ASK:
        if (e->rank > 0) {
            sc_sim_ask(f, e->rank, e->generation);
            return;
        }
        break;
    case SIM_DRAWN:
        sc_sim_drawn(f, e->rank, e->generation);
        if (e->rank > 0)
            return;
        break;
    case SIM_ACCEPTED:
        if (!sc_sim_end_encoding(f, e->rank, e->generation))
            return;
        if (e->rank == 0)
            sc_sim_accepted(f);
        else
            sc_sim_encoded(f, e->rank);
        return;
    case SIM_NOTICED:
        f->handout.accepted++;
        break;
    case SIM_TAKEN:
        sc_sim_taken(f, e);
        break;
    }
    sc_sim_hand_out(f);
}

/* Run all events until nothing is left to happen. @return SC_ERR_MEMORY, or SC_ERR_INTERNAL if
 * frames are missing then. */
static sc_status run(const sc_ctx *ctx, sim_farm *f)
{
    double end_s = 0;

    for (int rank = 1; rank < f->machine->ranks; rank++)
        sc_sim_ask(f, rank, 0);
    sc_sim_hand_out(f);
    while (f->events.count > 0 && f->events.status == SC_OK) {
        const sim_event e = sc_sim_pop(&f->events);

        f->now_s = e.time_s;
        happen(f, &e);
        if ((e.kind == SIM_HANDLED && e.unit.kind != SC_UNIT_NONE) || e.kind == SIM_NOTICED ||
            e.kind == SIM_TAKEN)
            end_s = f->now_s;
    }
    if (f->events.status != SC_OK)
        return f->events.status;
    if (!sc_handout_finished(&f->handout) || f->handout.accepted != f->handout.work.frames ||
        f->gops_left > 0)
        return sc_fail(ctx, SC_ERR_INTERNAL,
                       "the simulation ended with %d of %d frames, and %d GOPs were not gathered",
                       f->handout.accepted, f->handout.work.frames, f->gops_left);
    f->out->farm_s = end_s;
    for (int rank = 0; rank < f->machine->ranks; rank++)
        f->out->end_wait_s += end_s - f->ranks[rank].idle_since_s;
    return SC_OK;
}

/* Allocate the state of a farm; the caller frees it, also after an error. */
static sc_status open_farm(const sc_ctx *ctx, sim_farm *f)
{
    const sc_sim_film *film = f->film;
    const int ranks = f->machine->ranks;
    const sc_work work = {.ranks = ranks,
                          .gops = film->gops,
                          .frames = film->frames - (film->gops + film->gathered) * film->gop_frames,
                          .gathered = film->gathered,
                          .gop_frames = film->gop_frames,
                          .encoders_most = film->encoders_most,
                          .width_px = film->width_px,
                          .height_px = film->height_px,
                          .alpha = film->alpha,
                          .partition = film->partition};

    f->handout = sc_handout_begin(&work);
    f->out->window = f->handout.window;
    f->whole = film->gops * film->gop_frames;
    f->gops_left = film->gathered;
    f->encoder_cores = film->encode_wall_s > 0 ? film->encode_cpu_s / film->encode_wall_s : 0;
    f->events.ctx = ctx;
    SC_PASS(SC_ZALLOC(ctx, (size_t)ranks, &f->ranks));
    for (int rank = 0; rank < ranks; rank++)
        f->ranks[rank].first = -1;
    SC_PASS(SC_ZALLOC(ctx, (size_t)film->gathered * (size_t)film->gop_frames + 1, &f->gathered));
    SC_PASS(SC_ALLOC(ctx, (size_t)ranks, &f->ready.ranks));
    SC_PASS(SC_ALLOC(ctx, (size_t)work.frames + 1, &f->rows_left));
    for (int k = 0; k < work.frames; k++)
        f->rows_left[k] = film->height_px;
    return SC_OK;
}

/* @return whether everything that is divided by is above 0, and GOPs lie within the film. */
static bool is_possible(const sc_sim_film *film, const sc_sim_machine *machine)
{
    return film->frames > 0 && film->gop_frames > 0 && film->width_px > 0 && film->height_px > 0 &&
           film->gops >= 0 && film->gathered >= 0 &&
           (long)film->gops + film->gathered <= film->frames / film->gop_frames &&
           machine->ranks > (film->gathered > 0) && machine->ranks_per_node > 0 &&
           machine->threads > 0 && (machine->slow_node < 0 || machine->slow_speed > 0);
}

sc_status sc_simulate(const sc_ctx *ctx, const sc_sim_film *film, const sc_sim_machine *machine,
                      sc_sim_result *out)
{
    sc_sim_result result = {0};
    sim_farm f = {.film = film, .machine = machine, .out = &result};
    sc_status status;

    if (!is_possible(film, machine))
        return sc_fail(ctx, SC_ERR_INTERNAL, "a film or machine that cannot be simulated");
    SC_TRY(open_farm(ctx, &f));
    SC_TRY(run(ctx, &f));
    sc_sim_phases(film, machine, &result);
    sc_sim_conclude(film, machine, &result);
    *out = result;
out:
    sc_free(f.events.heap);
    sc_free(f.ranks);
    sc_free(f.ready.ranks);
    sc_free(f.rows_left);
    sc_free(f.gathered);
    return status;
}
