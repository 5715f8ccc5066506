/* SPDX-License-Identifier: BSD-3-Clause */
/* The heat picture of a run: one of its frames is drawn once more, small, and the work of each
 * pixel counted. */
#include "render/run.h"

#include <math.h>

/* Heat pictures may take this share of the CPU time of drawing, or at least these seconds. A ray
 * that is marched alone takes as long as so many that a wide kernel marches side by side. */
#define HEAT_SHARE 0.02
#define HEAT_LEAST_S 0.2
#define RAYS_SIDE_BY_SIDE 16

/* Choose the size of the heat picture: small enough for its cost, of which the frames that were
 * drawn tell. @param size_px written. @return false if none is small enough. */
static bool choose_heat_size(const sc_run *run, int size_px[2])
{
    enum { LEAST_SIDE = 32 };
    const int *output_px = run->session.job.output.size_px;
    const double aspect = sc_space_aspect(&run->session.job);
    const int longer = output_px[0] > output_px[1] ? output_px[0] : output_px[1];
    double cpu_s = 0, rays = 0, limit_s, pixels, side;

    for (int i = 0; i < run->root.result_count; i++) {
        cpu_s += run->root.results[i].render_cpu_s;
        rays += (double)run->root.results[i].rays;
    }
    if (!(cpu_s > 0) || !(rays > 0))
        return false;
    limit_s = HEAT_SHARE * cpu_s > HEAT_LEAST_S ? HEAT_SHARE * cpu_s : HEAT_LEAST_S;
    pixels = limit_s / (RAYS_SIDE_BY_SIDE * cpu_s / rays);
    side = sqrt(pixels * (aspect > 1 ? aspect : 1 / aspect)); /* the longer one */
    side = side < SC_HEAT_SIDE ? side : SC_HEAT_SIDE;
    side = side < longer ? side : longer;
    size_px[0] = (int)(aspect > 1 ? side : side * aspect);
    size_px[1] = (int)(aspect > 1 ? side / aspect : side);
    return side >= LEAST_SIDE && size_px[0] > 0 && size_px[1] > 0;
}

/* @return the index of the frame of this run whose number of samples is nearest to the mean. */
static int typical_frame(const sc_run *run)
{
    double mean = 0;
    int best = 0;

    for (int i = 0; i < run->root.result_count; i++)
        mean += (double)run->root.results[i].samples / run->root.result_count;
    for (int i = 1; i < run->root.result_count; i++) {
        if (fabs((double)run->root.results[i].samples - mean) <
            fabs((double)run->root.results[best].samples - mean))
            best = i;
    }
    return best;
}

/* Draw one of the frames of this run once more, small, to count the work of each pixel. There is
 * none after a stop. On rank 0. @return SC_ERR_MEMORY. */
static sc_status draw_heat(const sc_ctx *ctx, sc_run *run, sc_heat *out)
{
    int size_px[2];
    sc_render_stats stats;
    SC_OWN(sc_heat_clear) sc_heat heat = {0};
    SC_OWN(sc_free_at) sc_march_counters *counts = NULL;

    if (run->observe || run->root.result_count == 0 || *run->stop || *run->give_up ||
        !choose_heat_size(run, size_px))
        return SC_OK;
    SC_PASS(sc_heat_new(ctx, size_px[0], size_px[1], &heat));
    SC_PASS(SC_ALLOC(ctx, (size_t)size_px[0] * (size_t)size_px[1], &counts));
    heat.frame = run->root.results[typical_frame(run)].frame;
    sc_session_counts(&run->session, heat.frame, size_px, counts, &stats);
    heat.cpu_s = stats.cpu_s;
    for (int i = 0; i < size_px[0] * size_px[1]; i++) {
        heat.codes[SC_HEAT_SAMPLES][i] = sc_heat_code(counts[i].cell_visits);
        heat.codes[SC_HEAT_CONTRIBUTIONS][i] = sc_heat_code(counts[i].contributions);
    }
    if (!*run->give_up) /* otherwise it was not finished */
        SC_HAND_OVER(heat, out);
    return SC_OK;
}

/* Take over the heat picture of an earlier run on the job, if the stats.json under @p path has one.
 * @return SC_ERR_MEMORY. */
static sc_status keep_heat(const sc_ctx *ctx, const sc_run *run, const char *path, sc_heat *out)
{
    SC_OWN(sc_run_stats_clear) sc_run_stats stats = {0};
    const sc_status status = sc_run_stats_read(ctx, path, &stats);

    if (status == SC_OK && stats.run.job.job == run->root.store_job.job_hash &&
        stats.run.job.volume == run->root.store_job.volume_hash) {
        *out = stats.heat;
        stats.heat = (sc_heat){0};
    }
    return sc_is_of_input(status) ? SC_OK : status;
}

void sc_run_draw_heat(sc_run *run, const char *path, sc_heat *out)
{
    /* The film is made: if the picture cannot be, there is a warning instead of errors. */
    const sc_ctx silent = {.alloc_budget = run->app->ctx->alloc_budget};
    sc_status status = draw_heat(&silent, run, out);

    if (status == SC_OK && out->width_px == 0 && run->root.result_count == 0 &&
        run->app->options.resume)
        status = keep_heat(&silent, run, path, out);
    if (status != SC_OK)
        sc_warn(run->app->ctx, "the picture of the work of each pixel was not made: %s",
                status == SC_ERR_MEMORY ? "there is no memory" : "reading failed");
}
