/* SPDX-License-Identifier: BSD-3-Clause */
/* The summary of a run: how fast it was, where its time went, and what would make the next one
 * faster. */
#include "segcast/core_time.h"
#include "segcast/study.h"

#include <stdlib.h>

/* Thresholds for finding the bottleneck of a run, as shares of the farm's time. They are rules of
 * thumb; test_study.c shows which bottleneck they find in typical runs. */
/* Worker threads had no task for more than this share of the time, averaged over ranks: something
 * other than drawing may be the bottleneck. Passing messages counts as the
 * bottleneck only above GREAT_WAITING. */
#define MUCH_WAITING 0.1
#define GREAT_WAITING 0.2
/* A single thread that spends more than this share on one thing is the bottleneck. */
#define BUSY 0.8
#define IMBALANCE 0.15 /* see sc_run_imbalance */
/* Threads that had a task did nothing for more than this share of it: other work had the cores. */
#define CROWDED 0.3

enum { SLOWEST_SHOWN = 3 }; /* number of slow frames, and of slow ranks, that are named */

/* The speed at which a rank drew. */
typedef struct rank_speed {
    int rank, frames;        /* frames: how many it drew */
    double wall_s_per_frame; /* mean; 0 if it drew none */
} rank_speed;

double sc_run_waiting(const sc_run_record *run)
{
    double idle_s = 0;

    for (int i = 0; i < run->ranks; i++)
        idle_s += run->rank_records[i].farm_idle_s;
    return run->farm_wall_s > 0 ? idle_s / run->ranks / run->farm_wall_s : 0;
}

/* @return for which share of the time in which they had something to draw threads did not draw. */
static double crowding(const sc_run_record *run)
{
    const sc_core_time time = sc_run_core_time(run);
    const double waited_s = time.causes_s[SC_CAUSE_THREADS];
    const double all_s = waited_s + time.causes_s[SC_CAUSE_DRAW];

    return all_s > 0 ? waited_s / all_s : 0;
}

sc_bottleneck sc_run_bottleneck(const sc_run_record *run)
{
    const sc_rank_record *root = &run->rank_records[0];
    const double waiting = sc_run_waiting(run);
    const double before_s =
        root->phases[SC_PHASE_READ].wall_s + root->phases[SC_PHASE_PREPARE].wall_s;

    if (run->farm_wall_s <= 0 || before_s > run->farm_wall_s)
        return run->from_prepared ? SC_BOTTLENECK_START : SC_BOTTLENECK_PREPARE;
    if (waiting > MUCH_WAITING && root->accept_wall_s > BUSY * run->farm_wall_s)
        return run->wrote_png &&
                       root->phases[SC_PHASE_WRITE].wall_s > root->phases[SC_PHASE_ENCODE].wall_s
                   ? SC_BOTTLENECK_WRITE
                   : SC_BOTTLENECK_ENCODE;
    if (waiting > GREAT_WAITING && root->phases[SC_PHASE_GATHER].wall_s > BUSY * run->farm_wall_s)
        return SC_BOTTLENECK_GATHER;
    if (sc_run_imbalance(run) > IMBALANCE && waiting > MUCH_WAITING)
        return SC_BOTTLENECK_BALANCE;
    return crowding(run) > CROWDED ? SC_BOTTLENECK_CORES : SC_BOTTLENECK_DRAW;
}

const char *sc_bottleneck_advice(sc_bottleneck bottleneck)
{
    static const char *const texts[] = {
        [SC_BOTTLENECK_DRAW] = "drawing: more ranks or threads make it faster",
        [SC_BOTTLENECK_PREPARE] =
            "reading and preparing the volume: `segcast convert` does that once for all jobs",
        [SC_BOTTLENECK_START] =
            "the start: checking the prepared file and making the renderer took longer than "
            "drawing; more frames in one run make better use of it",
        [SC_BOTTLENECK_ENCODE] = "encoding on rank 0: a faster output.preset, or farm.encode: "
                                 "segments with several ranks, makes it faster",
        [SC_BOTTLENECK_WRITE] = "writing frames on rank 0: output.frames: none, or farm.encode: "
                                "segments with several ranks, makes it faster",
        [SC_BOTTLENECK_GATHER] = "gathering on rank 0: fewer ranks with more threads each, or "
                                 "farm.encode: segments, make it faster",
        [SC_BOTTLENECK_BALANCE] =
            "ranks that waited for others: farm.partition: auto or tiles makes it faster",
        [SC_BOTTLENECK_CORES] = "shared cores: threads waited for a core for much of the time; "
                                "cores of their own, or fewer threads, make it faster"};

    return texts[bottleneck];
}

/* For qsort of sc_frame_result: the one with the most CPU time first. */
static int by_cost(const void *a, const void *b)
{
    const double x = ((const sc_frame_result *)a)->render_cpu_s;
    const double y = ((const sc_frame_result *)b)->render_cpu_s;

    return x < y ? 1 : x > y ? -1 : 0;
}

/* For qsort of rank_speed: the slowest first; of equal ones the lowest rank. */
static int by_speed(const void *a, const void *b)
{
    const rank_speed *x = a, *y = b;

    return x->wall_s_per_frame < y->wall_s_per_frame   ? 1
           : x->wall_s_per_frame > y->wall_s_per_frame ? -1
                                                       : x->rank - y->rank;
}

/* Append the SLOWEST_SHOWN frames that took most CPU time to @p text: "12 (0.310 s), 7 (0.298 s)".
 * @return SC_ERR_MEMORY. */
static sc_status slow_frames(const sc_ctx *ctx, const sc_run_record *run, sc_text *text)
{
    SC_OWN(sc_free_at) sc_frame_result *sorted = NULL;

    SC_PASS(SC_ALLOC(ctx, (size_t)run->frame_count + 1, &sorted));
    for (int i = 0; i < run->frame_count; i++)
        sorted[i] = run->frames[i];
    qsort(sorted, (size_t)run->frame_count, sizeof *sorted, by_cost);
    for (int i = 0; i < run->frame_count && i < SLOWEST_SHOWN; i++)
        SC_PASS(sc_text_add(ctx, text, "%s%d (%.3f s)", i ? ", " : "", sorted[i].frame,
                            sorted[i].render_cpu_s));
    return SC_OK;
}

/* Append the SLOWEST_SHOWN ranks that took longest for a frame to @p text: "3 on n2 (0.310 s a
 * frame)". A frame that several ranks drew counts for the last one. @return SC_ERR_MEMORY. */
static sc_status slow_ranks(const sc_ctx *ctx, const sc_run_record *run, sc_text *text)
{
    SC_OWN(sc_free_at) rank_speed *speeds = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)run->ranks, &speeds));
    for (int i = 0; i < run->ranks; i++)
        speeds[i].rank = i;
    for (int i = 0; i < run->frame_count; i++) {
        const sc_frame_result *f = &run->frames[i];

        speeds[f->rank].frames++;
        speeds[f->rank].wall_s_per_frame += f->render_wall_s;
    }
    for (int i = 0; i < run->ranks; i++)
        speeds[i].wall_s_per_frame /= speeds[i].frames ? speeds[i].frames : 1;
    qsort(speeds, (size_t)run->ranks, sizeof *speeds, by_speed);
    for (int i = 0; i < run->ranks && i < SLOWEST_SHOWN; i++)
        SC_PASS(sc_text_add(ctx, text, "%s%d on %s (%.3f s a frame)", i ? ", " : "", speeds[i].rank,
                            run->rank_records[speeds[i].rank].host, speeds[i].wall_s_per_frame));
    return SC_OK;
}

sc_status sc_run_summarise(const sc_ctx *ctx, const sc_run_record *run)
{
    const double frames = run->frame_count ? run->frame_count : 1;
    SC_OWN(sc_text_clear) sc_text slow = {0}, ranks = {0};

    sc_info(ctx, "%d frames in %.1f s (%.2f frames/s); drawing %.3f CPU s/frame, encoding %.3f",
            run->frame_count, run->wall_s, run->wall_s > 0 ? run->frame_count / run->wall_s : 0,
            sc_run_phase(run, SC_PHASE_RENDER).cpu_s / frames,
            sc_run_phase(run, SC_PHASE_ENCODE).cpu_s / frames);
    sc_info(ctx,
            "time in s: reading %.1f, preparing %.1f, sharing %.1f, drawing %.1f, gathering %.1f, "
            "encoding %.1f, writing %.1f; waiting for work %.0f %%, imbalance %.0f %%",
            sc_run_phase(run, SC_PHASE_READ).wall_s, sc_run_phase(run, SC_PHASE_PREPARE).wall_s,
            sc_run_phase(run, SC_PHASE_SHARE).wall_s, sc_run_phase(run, SC_PHASE_RENDER).wall_s,
            sc_run_phase(run, SC_PHASE_GATHER).wall_s, sc_run_phase(run, SC_PHASE_ENCODE).wall_s,
            sc_run_phase(run, SC_PHASE_WRITE).wall_s, 100 * sc_run_waiting(run),
            100 * sc_run_imbalance(run));
    if (run->frame_count == 0)
        return SC_OK;
    SC_PASS(slow_frames(ctx, run, &slow));
    sc_info(ctx, "slowest frames (CPU s): %s", slow.data);
    if (run->ranks > 1) {
        SC_PASS(slow_ranks(ctx, run, &ranks));
        sc_info(ctx, "slowest ranks: %s", ranks.data);
    }
    sc_info(ctx, "limited by %s", sc_bottleneck_advice(sc_run_bottleneck(run)));
    return SC_OK;
}
