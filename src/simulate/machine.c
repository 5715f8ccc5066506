/* SPDX-License-Identifier: BSD-3-Clause */
/* The simulated machine: speeds, bandwidths, what comes before and after the farm, and what limits
 * a run. */
#include "internal.h"

/* A resource of rank 0 that is busy for this share of the time of the farm limits it. */
#define BUSY 0.85
/* A run whose cores are busy with drawing and encoding for this share of its time is limited by
 * them. */
#define GOOD 0.75

/* @return the time for @p bytes; a bandwidth of 0 stands for an infinite one. */
static double time_s(double bytes, double bytes_per_s)
{
    return bytes_per_s > 0 ? bytes / bytes_per_s : 0;
}

/* @return the smaller one of two bandwidths. */
static double slower(double a, double b)
{
    return a > 0 && (b <= 0 || a < b) ? a : b;
}

double sc_sim_speed(const sc_sim_machine *machine, int rank)
{
    return rank / machine->ranks_per_node == machine->slow_node ? machine->slow_speed : 1;
}

/* @return the bandwidth between two nodes: the slowest link on the way, up to the first switch that
 * has both below it and down again. */
static double path_bytes_per_s(const sc_sim_machine *machine, int node, int other)
{
    double rate = machine->link_bytes_per_s;

    for (int i = 0; i < SC_SIM_SWITCHES && machine->switches[i].nodes > 0; i++) {
        const sc_sim_switch *level = &machine->switches[i];

        if (node / level->nodes == other / level->nodes)
            break;
        rate = slower(rate, level->bytes_per_s);
    }
    return rate;
}

double sc_sim_transfer_s(const sc_sim_machine *machine, int rank, int target, double bytes)
{
    const int node = rank / machine->ranks_per_node, other = target / machine->ranks_per_node;

    return node == other ? 0 : time_s(bytes, path_bytes_per_s(machine, node, other));
}

void sc_sim_phases(const sc_sim_film *film, const sc_sim_machine *m, sc_sim_result *out)
{
    const int nodes = (m->ranks + m->ranks_per_node - 1) / m->ranks_per_node;
    const double file = slower(m->file_bytes_per_s, m->node_file_bytes_per_s);
    const bool slow = m->slow_node >= 0 && m->slow_node < nodes && m->slow_speed < 1;

    out->start_s = m->start_s + nodes * m->start_node_s;
    out->read_s = time_s(film->read_bytes, file);
    out->prepare_s = film->prepare_s / sc_sim_speed(m, 0) +
                     film->derive_s / (slow ? m->slow_speed : sc_sim_speed(m, 0));
    /* The volume passes through a chain of nodes in small pieces, each node on its way to the next:
     * that takes as long as one transfer over the slowest link, and a latency for each node. */
    out->share_s = nodes > 1 ? time_s(film->shared_bytes, path_bytes_per_s(m, nodes - 1, 0)) +
                                   (nodes - 1) * m->latency_s
                             : 0;
    out->finish_s = film->finish_s +
                    time_s(2 * film->frame_file_bytes * film->frames, file); /* read, written */
}

/* @return what limits the farm, whose cores are not busy. */
static sc_sim_limit farm_limit(const sc_sim_result *r)
{
    if (r->busy_s.accept > BUSY * r->farm_s)
        return SC_SIM_ENCODING;
    if (r->busy_s.link > BUSY * r->farm_s)
        return SC_SIM_NETWORK;
    if (r->busy_s.message > BUSY * r->farm_s)
        return SC_SIM_MESSAGES;
    if (r->encoders > 0 && r->busy_s.gather > BUSY * r->farm_s * r->encoders)
        return SC_SIM_GATHERING;
    return r->window_wait_s > r->end_wait_s ? SC_SIM_WINDOW : SC_SIM_UNITS;
}

void sc_sim_conclude(const sc_sim_film *film, const sc_sim_machine *machine, sc_sim_result *out)
{
    const double cores = (double)machine->ranks * machine->threads;
    double ideal_s, most_s;

    out->wall_s =
        out->start_s + out->read_s + out->prepare_s + out->share_s + out->farm_s + out->finish_s;
    out->work_cpu_s = film->encode_cpu_s * film->frames;
    for (int k = 0; k < film->frames; k++)
        out->work_cpu_s += film->draw_cpu_s[k];
    ideal_s = out->work_cpu_s / cores;
    out->frames_per_s = out->wall_s > 0 ? film->frames / out->wall_s : 0;
    out->efficiency = out->wall_s > 0 ? ideal_s / out->wall_s : 0;
    out->farm_efficiency = out->farm_s > 0 ? ideal_s / out->farm_s : 0;
    /* Otherwise by what costs most beside that. */
    out->limit = SC_SIM_DRAWING;
    if (ideal_s > GOOD * out->wall_s)
        return;
    most_s = out->farm_s - ideal_s;
    out->limit = farm_limit(out);
    const struct {
        double seconds;
        sc_sim_limit limit;
    } others[] = {{out->start_s, SC_SIM_STARTING},
                  {out->read_s, SC_SIM_READING},
                  {out->prepare_s, SC_SIM_PREPARING},
                  {out->share_s, SC_SIM_SHARING},
                  {out->finish_s, SC_SIM_FINISHING}};
    for (size_t i = 0; i < SC_COUNT_OF(others); i++) {
        if (others[i].seconds > most_s) {
            most_s = others[i].seconds;
            out->limit = others[i].limit;
        }
    }
}

const char *sc_sim_limit_words(sc_sim_limit limit)
{
    switch (limit) {
    case SC_SIM_DRAWING:
        return "drawing";
    case SC_SIM_STARTING:
        return "starting the ranks";
    case SC_SIM_READING:
        return "reading the volume";
    case SC_SIM_PREPARING:
        return "preparing";
    case SC_SIM_SHARING:
        return "sending the volume to all nodes";
    case SC_SIM_ENCODING:
        return "encoding on rank 0";
    case SC_SIM_GATHERING:
        return "encoding on the ranks that gather";
    case SC_SIM_MESSAGES:
        return "messages of rank 0";
    case SC_SIM_NETWORK:
        return "the network of rank 0";
    case SC_SIM_WINDOW:
        return "the window of frames";
    case SC_SIM_UNITS:
        return "too few work units";
    case SC_SIM_FINISHING:
        return "joining the video";
    }
    return "";
}
