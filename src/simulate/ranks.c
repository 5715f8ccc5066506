/* SPDX-License-Identifier: BSD-3-Clause */
/* Simulated ranks draw work units, and share their cores between drawing and encoding. */
#include "internal.h"

#include <math.h>

/* ---- the cores of a rank ---- */

/* @return the speed at which both threads of a rank run: if they could use more cores than there
 * are, each gets its share. */
static double sharing(const sim_farm *f, const sim_rank *r)
{
    const double cores = f->machine->threads;
    const double wanted = (r->drawing.busy ? cores : 0) + (r->encoding.busy ? f->encoder_cores : 0);

    return wanted > cores ? cores / wanted : 1;
}

/* Note what has been done of a load until now. */
static void advance(const sim_farm *f, sim_load *load, double speed)
{
    if (load->busy)
        load->left_s -= (f->now_s - load->since_s) * speed;
    load->left_s = load->left_s > 0 ? load->left_s : 0;
    load->since_s = f->now_s;
}

/* Begin (@p left_s seconds of work) or end (negative) one load of a rank, and forecast the ends of
 * both anew. */
static void change_load(sim_farm *f, int rank, sim_load *load, double left_s)
{
    sim_rank *r = &f->ranks[rank];
    const double before = sharing(f, r);
    double speed;

    advance(f, &r->drawing, before);
    advance(f, &r->encoding, before);
    load->busy = left_s >= 0;
    load->left_s = left_s;
    speed = sharing(f, r);
    r->drawing.generation++;
    r->encoding.generation++;
    if (r->drawing.busy)
        sc_sim_push(&f->events, (sim_event){.time_s = f->now_s + r->drawing.left_s / speed,
                                            .kind = SIM_DRAWN,
                                            .rank = rank,
                                            .generation = r->drawing.generation});
    if (r->encoding.busy)
        sc_sim_push(&f->events, (sim_event){.time_s = f->now_s + r->encoding.left_s / speed,
                                            .kind = SIM_ACCEPTED,
                                            .rank = rank,
                                            .generation = r->encoding.generation});
}

void sc_sim_begin_encoding(sim_farm *f, int rank)
{
    change_load(f, rank, &f->ranks[rank].encoding,
                f->film->encode_wall_s / sc_sim_speed(f->machine, rank));
}

bool sc_sim_end_encoding(sim_farm *f, int rank, long generation)
{
    sim_load *load = &f->ranks[rank].encoding;

    if (!load->busy || generation != load->generation)
        return false;
    change_load(f, rank, load, -1);
    return true;
}

/* ---- all ranks ---- */

/* @return the rows of a work unit, as a measure of its cost: as sc_farm_unit_rows. */
static double rows_of(const sim_farm *f, const sc_work_unit *unit)
{
    return unit->kind == SC_UNIT_GOP ? (double)f->film->height_px * f->film->gop_frames
                                     : unit->rows;
}

/* @return the number in the film of the frame of a unit that is no GOP. */
static int film_frame(const sim_farm *f, const sc_work_unit *unit)
{
    const sc_sim_film *film = f->film;

    return unit->encoder > 0
               ? film->frames + (unit->gop - film->gathered) * film->gop_frames + unit->place
               : f->whole + unit->index;
}

/* @return how long a rank of speed 1 needs for a work unit. */
static double unit_s(const sim_farm *f, const sc_work_unit *unit)
{
    const sc_sim_film *film = f->film;
    const double threads = f->machine->threads;
    double draw_s = 0, together_s, apart_s;

    if (unit->kind != SC_UNIT_GOP) {
        const double more = unit->kind == SC_UNIT_BAND ? film->band_rows : 0;

        return film->draw_cpu_s[film_frame(f, unit)] * (unit->rows + more) / film->height_px /
               threads;
    }
    for (int i = 0; i < film->gop_frames; i++)
        draw_s += film->draw_cpu_s[unit->index * film->gop_frames + i] / threads;
    /* Either all cores of the rank are busy, or they wait while it encodes. */
    together_s = draw_s + film->gop_frames * film->encode_cpu_s / threads;
    apart_s = draw_s + film->gop_frames * film->encode_wall_s;
    return together_s > apart_s ? together_s : apart_s;
}

/* Begin the first unit that the rank has. It asks for the next when this one ends soon. */
static void begin(sim_farm *f, int rank)
{
    sim_rank *r = &f->ranks[rank];
    const double seconds = unit_s(f, &r->units[0]) / sc_sim_speed(f->machine, rank);

    r->generation++;
    r->begin_s = f->now_s;
    r->ask_s = f->now_s + sc_handout_ask_age_s(rows_of(f, &r->units[0]), r->row_s);
    change_load(f, rank, &r->drawing, seconds);
    if (isfinite(r->ask_s))
        sc_sim_push(&f->events, (sim_event){.time_s = r->ask_s,
                                            .kind = SIM_ASK,
                                            .rank = rank,
                                            .generation = r->generation});
}

/* Send a message: a result or request (@p unit NULL) to rank 0; or the pixels of a unit of a
 * gathered GOP to its encoder. */
static void send(sim_farm *f, int rank, const sc_work_unit *unit, bool gathered)
{
    const int target = gathered ? unit->encoder : 0;
    const double way_s = rank == target ? 0 : f->machine->latency_s;
    sim_event e = {.time_s = f->now_s + f->machine->notice_s + way_s,
                   .kind = SIM_ARRIVED,
                   .rank = rank,
                   .gathered = gathered,
                   .seconds = unit ? f->now_s - f->ranks[rank].begin_s : 0};

    if (unit)
        e.unit = *unit;
    sc_sim_push(&f->events, e);
}

void sc_sim_receive_unit(sim_farm *f, int rank, const sc_work_unit *unit)
{
    sim_rank *r = &f->ranks[rank];

    r->asked = false;
    r->units[r->in_hand++] = *unit;
    if (r->in_hand > 1)
        return;
    if (r->window_full)
        f->out->window_wait_s += f->now_s - r->idle_since_s;
    r->window_full = false;
    begin(f, rank);
}

void sc_sim_ask(sim_farm *f, int rank, long generation)
{
    sim_rank *r = &f->ranks[rank];

    if (r->asked || r->in_hand >= SC_UNITS_PER_RANK || generation != r->generation)
        return;
    r->held_back = r->behind > SC_ENCODER_BEHIND;
    if (r->held_back)
        return;
    r->asked = true;
    send(f, rank, NULL, false);
}

void sc_sim_drawn(sim_farm *f, int rank, long generation)
{
    sim_rank *r = &f->ranks[rank];
    const sc_work_unit done = r->units[0];

    if (generation != r->drawing.generation)
        return;
    f->out->busy_s.draw += f->now_s - r->begin_s;
    r->row_s = (f->now_s - r->begin_s) / rows_of(f, &done);
    r->units[0] = r->units[1];
    r->in_hand--;
    r->idle_since_s = f->now_s;
    change_load(f, rank, &r->drawing, -1);
    if (done.encoder > 0)
        send(f, rank, &done, true);
    send(f, rank, &done, false);
    if (r->in_hand > 0)
        begin(f, rank);
    else if (rank > 0)
        sc_sim_ask(f, rank, r->generation);
}
