/* SPDX-License-Identifier: BSD-3-Clause */
/* What segcast plan tells of other machines: runs that are simulated. */
#include "plan/plan.h"

/* Rows that a band costs beside its own: pixels at its edges are compared with neighbours that are
 * traced again. With bands of 16 rows the phantom takes 2.75 % more samples. */
#define BAND_ROWS_MORE 0.44
/* Until the ranks of an MPI program run: assumed, see docs/usage.md. */
#define START_S 1.0
#define START_NODE_S 0.002

/* Fill in what each frame costs: what was measured at some places, and straight lines between them.
 * @param factor on all of it. @param out [frames]. */
static void fill_costs(const sc_job *job, const sc_plan_probe *p, double factor, double *out)
{
    const int frames = job->animation.frames, places = p->partly_drawn;
    double sum = 0, scale;

    for (int k = 0; k < frames; k++) {
        /* place i is in the middle of the i-th part of the animation */
        const double at = (k + 0.5) * places / frames - 0.5;
        const int low = at < 0 ? 0 : (int)at, high = low + 1 < places ? low + 1 : low;
        const double share = at < low ? 0 : at - low;

        out[k] = (1 - share) * p->place_cpu_s[low] + share * p->place_cpu_s[high];
        sum += out[k];
    }
    scale = sum > 0 ? p->draw_cpu_s * frames / sum : 0;
    for (int k = 0; k < frames; k++)
        out[k] = factor * (sum > 0 ? out[k] * scale : p->draw_cpu_s);
}

/* @return the film of a job. @param costs [frames], as fill_costs. @param factor as there. */
static sc_sim_film film_of(const sc_job *job, const sc_plan_probe *p, const sc_plan_run *run,
                           const double *costs, double factor)
{
    const sc_video_settings video = sc_run_video_settings(job);
    const int frames = job->animation.frames, gop = sc_video_gop_frames(&video);
    const int gops = (frames + gop - 1) / gop;
    const double firsts = (double)gops / frames; /* the share of frames that begin a GOP */
    const sc_plan_cost *first = &p->first, *next = &p->next, *png = &p->png;

    return (sc_sim_film){
        .frames = frames,
        .gop_frames = gop,
        .width_px = job->output.size_px[0],
        .height_px = job->output.size_px[1],
        .alpha = job->render.background.is_none,
        .partition = (sc_partition)job->farm.partition,
        .gops = run->gather ? 0 : run->gops,
        .gathered = run->gather ? run->gops : 0,
        .encoders_most = run->encoders_most,
        .draw_cpu_s = costs,
        .band_rows = BAND_ROWS_MORE,
        .encode_cpu_s = factor * (firsts * first->cpu_s + (1 - firsts) * next->cpu_s + png->cpu_s),
        .encode_wall_s =
            factor * (firsts * first->wall_s + (1 - firsts) * next->wall_s + png->wall_s),
        .frame_file_bytes = firsts * first->bytes + (1 - firsts) * next->bytes + png->bytes,
        .prepare_s = run->prepare_s,
        .shared_bytes = (double)p->prepared_bytes};
}

sc_status sc_plan_simulate(const sc_ctx *ctx, const sc_job *job, const sc_plan_probe *probe,
                           const sc_unit_costs *unit_costs, int cores, sc_plan_run *run)
{
    const int ranks = run->nodes * run->ranks;
    const double wanted = (double)run->ranks * run->threads;
    const double factor = wanted > cores ? wanted / cores : 1; /* threads share cores */
    const sc_sim_machine machine = {.ranks = ranks,
                                    .ranks_per_node = run->ranks,
                                    .threads = run->threads,
                                    .latency_s = unit_costs->latency_s,
                                    .link_bytes_per_s = unit_costs->link_bytes_per_s,
                                    .message_s = unit_costs->message_s,
                                    .copy_bytes_per_s = unit_costs->copy_bytes_per_s,
                                    .notice_s = unit_costs->notice_s,
                                    .slow_node = -1,
                                    .start_s = ranks > 1 ? START_S : 0,
                                    .start_node_s = ranks > 1 ? START_NODE_S : 0,
                                    .file_bytes_per_s = unit_costs->file_bytes_per_s};
    sc_sim_film film;
    sc_sim_result result;
    SC_OWN(sc_free_at) double *costs_s = NULL;

    SC_PASS(SC_ALLOC(ctx, (size_t)job->animation.frames, &costs_s));
    fill_costs(job, probe, factor, costs_s);
    film = film_of(job, probe, run, costs_s, factor);
    SC_PASS(sc_simulate(ctx, &film, &machine, &result));
    run->wall_s = result.wall_s;
    run->efficiency = result.efficiency;
    /* Whoever encodes: if that costs more than drawing, it is what to change. */
    run->limit = result.limit == SC_SIM_DRAWING && film.encode_cpu_s > factor * probe->draw_cpu_s
                     ? "encoding"
                     : sc_sim_limit_words(result.limit);
    return SC_OK;
}

/* ---- scaling ---- */

/* What is tried for a row. */
typedef struct trial {
    const sc_ctx *ctx;
    const sc_plan_probe *probe;
    const sc_unit_costs *costs;
    const sc_plan_nodes *nodes;
} trial;

/* Simulate a run on @p count nodes, and keep it in @p best if it is clearly faster than what is
 * there. */
static sc_status try_run(const trial *t, const sc_job *job, int count, int ranks, sc_plan_row *best)
{
    const sc_plan_nodes *nodes = t->nodes;
    sc_plan_run run = sc_plan_run_on(job, t->probe, count, ranks, nodes->cores, nodes->threads);
    sc_status status;

    if (best->run.nodes > 0 && run.first_node_bytes > nodes->memory_bytes)
        return SC_OK;
    status = sc_plan_simulate(t->ctx, job, t->probe, t->costs, nodes->cores, &run);
    if (status == SC_OK && (best->run.nodes == 0 || run.wall_s < 0.99 * best->run.wall_s))
        *best = (sc_plan_row){.run = run,
                              .encode = (int)job->farm.encode,
                              .core_hours = run.wall_s * count * nodes->cores / 3600};
    return status;
}

/* Try everything that is open on @p count nodes. */
static sc_status find_best(const trial *t, const sc_job *job, int count, sc_plan_row *best)
{
    static const int encodes[] = {SC_ENCODE_AUTO, SC_ENCODE_SEGMENTS, SC_ENCODE_GATHER};
    const bool is_open = job->farm.encode == SC_ENCODE_AUTO && sc_run_has_video(job);
    const int first = t->nodes->ranks ? t->nodes->ranks : 1;
    const int last = t->nodes->ranks ? first : t->nodes->cores;
    sc_job tried = *job; /* its texts and arrays stay those of the job */

    for (size_t way = 0; way < (is_open ? SC_COUNT_OF(encodes) : 1); way++) {
        if (is_open)
            tried.farm.encode = encodes[way];
        for (int ranks = first; ranks <= last && (long)ranks * count <= SC_PLAN_RANKS_MOST;
             ranks *= 2)
            SC_PASS(try_run(t, &tried, count, ranks, best));
    }
    return SC_OK;
}

sc_status sc_plan_scale_to(const sc_ctx *ctx, const sc_job *job, const sc_plan_probe *probe,
                           const sc_unit_costs *costs, const sc_plan_nodes *nodes,
                           sc_plan_scale *out)
{
    const trial t = {ctx, probe, costs, nodes};
    const int ranks = nodes->ranks ? nodes->ranks : 1;
    sc_plan_scale scale = {0};
    bool pays = true;

    for (int count = 1; count <= nodes->most && scale.count < SC_PLAN_ROWS_MAX &&
                        (long)count * ranks <= SC_PLAN_RANKS_MOST;
         count *= 2) {
        sc_plan_row *row = &scale.rows[scale.count];

        SC_PASS(find_best(&t, job, count, row));
        pays = pays && (scale.count == 0 || row[-1].run.wall_s >= SC_PLAN_PAYS * row->run.wall_s);
        scale.pays_to = pays ? count : scale.pays_to;
        scale.count++;
    }
    *out = scale;
    return SC_OK;
}
