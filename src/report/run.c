/* SPDX-License-Identifier: BSD-3-Clause */
/* The page of a run, and the page that compares several. */
#include "internal.h"

#include <unistd.h>

enum {
    RANKS_SHOWN = 24, /* most ranks in the chart of phases, at even distances */
    RUNS_SHOWN = 50   /* most runs: the last ones */
};

/* @return the last run. */
static const sc_run_entry *last_run(const sc_run_stats *stats)
{
    return &stats->history.runs[stats->history.run_count - 1];
}

/* @return a run. */
static json_t *entry_json(const sc_run_entry *run)
{
    return json_pack("{s:b, s:i, s:i, s:i, s:i, s:f, s:f, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o}",
                     "ended", run->ended, "ranks", run->ranks, "threads", run->threads, "nodes",
                     run->nodes, "frames", run->frames, "wall_s", run->wall_s, "cpu_s", run->cpu_s,
                     "hosts", run->host_count, "begin", sc_json_text(run->begin), "host",
                     sc_json_text(run->host), "processor", sc_json_text(run->processor), "kernel",
                     sc_json_text(run->kernel), "mpi", sc_json_text(run->mpi), "commit",
                     sc_json_text(run->commit), "batch_job", sc_json_text(run->batch_job));
}

/* @return the peak memory of the rank that took most. */
static uint64_t peak_bytes(const sc_run_stats *stats)
{
    uint64_t most = 0;

    for (int i = 0; i < stats->run.ranks; i++)
        most = stats->ranks[i].peak_rss_bytes > most ? stats->ranks[i].peak_rss_bytes : most;
    return most;
}

/* @return all phases of all ranks. */
static json_t *phases_json(const sc_run_stats *stats)
{
    json_t *phases = json_object();

    for (int p = 0; p < SC_PHASE_COUNT; p++) {
        const sc_phase_time time = sc_run_phase(&stats->run, p);

        (void)json_object_set_new(
            phases, sc_phase_key(p),
            json_pack("{s:f, s:f}", "wall_s", time.wall_s, "cpu_s", time.cpu_s));
    }
    return phases;
}

/* @return the wall seconds of the phases of ranks; of many, some at even distances. */
static json_t *ranks_json(const sc_run_stats *stats)
{
    const int ranks = stats->run.ranks, shown = ranks < RANKS_SHOWN ? ranks : RANKS_SHOWN;
    json_t *json = json_array();

    for (int i = 0; i < shown; i++) {
        const int rank = (int)((long)i * ranks / shown);
        json_t *wall_s = json_array();

        for (int p = 0; p < SC_PHASE_COUNT; p++)
            wall_s = sc_json_with(wall_s, json_real(stats->ranks[rank].phases[p].wall_s));
        json =
            sc_json_with(json, json_pack("{s:i, s:o, s:o}", "rank", rank, "host",
                                         sc_json_text(stats->ranks[rank].host), "wall_s", wall_s));
    }
    return json;
}

/* @return the last runs on the job. */
static json_t *runs_json(const sc_history *history)
{
    const int first = history->run_count > RUNS_SHOWN ? history->run_count - RUNS_SHOWN : 0;
    json_t *json = json_array();

    for (int i = first; i < history->run_count; i++)
        json = sc_json_with(json, entry_json(&history->runs[i]));
    return json;
}

/* @return the name of the film, if it is there and can stand in a page; else null. */
static json_t *video_json(const sc_report_run *run)
{
    char path[SC_REPORT_PATH_BYTES];
    json_t *name = NULL;

    snprintf(path, sizeof path, "%s/%s", run->directory, run->video);
    if (strcmp(run->video, "none") != 0 && access(path, R_OK) == 0)
        name = json_string(run->video);
    return name ? name : json_null();
}

/* @return what is told first, and the figures. */
static json_t *run_json(const sc_report_run *run, const sc_run_stats *stats)
{
    const sc_core_time cores = sc_run_core_time(&stats->run);
    const char *title = run->title[0]                ? run->title
                        : strcmp(run->video, "none") ? run->video
                                                     : "A film of segcast";

    return json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:i, s:i, s:i, s:o, s:i, s:f, s:f, s:f, s:f, s:s, s:o, s:o, "
        "s:o, s:o, s:{s:I, s:I, s:I, s:I}}",
        "kind", "run", "title", sc_json_text(title), "version", sc_json_text(stats->version),
        "slice", run->slice ? sc_json_text(run->slice) : json_null(), "video", video_json(run),
        "frames", run->frames, "fps", run->fps, "there", stats->history.frame_count, "run",
        entry_json(last_run(stats)), "run_count", stats->history.run_count, "frames_per_s",
        stats->frames_per_s, "mrays_per_cpu_s", stats->mrays_per_cpu_s, "imbalance",
        sc_run_imbalance(&stats->run), "waiting", sc_run_waiting(&stats->run), "limit",
        sc_bottleneck_advice(sc_run_bottleneck(&stats->run)), "phases", phases_json(stats), "ranks",
        ranks_json(stats), "core_time", sc_json_core_time(&cores), "runs",
        runs_json(&stats->history), "memory", "peak_rss_bytes", (json_int_t)peak_bytes(stats),
        "volume_bytes", (json_int_t)stats->run.memory.volume, "prepared_bytes",
        (json_int_t)stats->run.memory.prepared, "derived_bytes",
        (json_int_t)stats->run.memory.derived);
}

sc_status sc_report_make(const sc_ctx *ctx, const sc_report_run *run, sc_text *out)
{
    static const char *const records[][2] = {
        {"stats", "json"}, {"frames", "csv"}, {"trace", "json"}, {"manifest", "jsonl"}};
    enum { RECORDS = SC_COUNT_OF(records) };
    char names[RECORDS][SC_REPORT_PATH_BYTES / 2], path[SC_REPORT_PATH_BYTES];
    const char *files[RECORDS + 1] = {[RECORDS] = "job.yaml"};
    SC_OWN(sc_run_stats_clear) sc_run_stats stats = {0};
    json_auto_t *data = NULL;

    for (int i = 0; i < RECORDS; i++) {
        snprintf(names[i], sizeof names[i], "%s%s%s.%s", records[i][0], run->slice ? "." : "",
                 run->slice ? run->slice : "", records[i][1]);
        files[i] = names[i];
    }
    snprintf(path, sizeof path, "%s/%s", run->directory, names[0]);
    SC_PASS(sc_run_stats_read(ctx, path, &stats));
    data = run_json(run, &stats);
    SC_PASS(sc_report_frames(ctx, run, &stats, data));
    SC_PASS(sc_report_heat(ctx, &stats.heat, data));
    snprintf(path, sizeof path, "%s/%s", run->directory, names[2]);
    SC_PASS(sc_report_activity(ctx, path, &stats, data));
    SC_PASS(sc_json_sources(ctx, run->directory, "job.yaml", files, SC_COUNT_OF(files), data));
    return sc_json_page(ctx, data, out);
}

/* ---- several runs ---- */

/* @return the number of a frame that both have drawn, with different pixels; -1: there is none.
 * @param common counts those that both have. */
static int differing_frame(const sc_history *a, const sc_history *b, int *common)
{
    int j = 0;

    for (int i = 0; i < a->frame_count; i++) {
        const sc_frame_result *f = &a->frames[i].result;

        while (j < b->frame_count && b->frames[j].result.frame < f->frame)
            j++;
        if (j == b->frame_count || b->frames[j].result.frame != f->frame)
            continue;
        ++*common;
        if (b->frames[j].result.hash != f->hash)
            return f->frame;
    }
    return -1;
}

/* @return what is compared of a run. */
static json_t *compared_json(const char *name, const sc_run_stats *stats)
{
    const sc_run_entry *last = last_run(stats);
    const bool drew = last->ended && last->frames > 0;
    const int frames = drew ? last->frames : 1;
    json_t *wall_s = json_array();

    for (int p = 0; p < SC_PHASE_COUNT; p++)
        wall_s = sc_json_with(wall_s, json_real(sc_run_phase(&stats->run, p).wall_s));
    return json_pack(
        "{s:o, s:b, s:o, s:f, s:f, s:f, s:f, s:f, s:I, s:s, s:o}", "name", sc_json_text(name),
        "drew", drew, "run", entry_json(last), "frames_per_s", drew ? stats->frames_per_s : 0,
        "draw_cpu_s", drew ? sc_run_phase(&stats->run, SC_PHASE_RENDER).cpu_s / frames : 0,
        "encode_cpu_s", drew ? sc_run_phase(&stats->run, SC_PHASE_ENCODE).cpu_s / frames : 0,
        "mrays_per_cpu_s", stats->mrays_per_cpu_s, "imbalance", sc_run_imbalance(&stats->run),
        "peak_rss_bytes", (json_int_t)peak_bytes(stats), "limit",
        sc_bottleneck_advice(sc_run_bottleneck(&stats->run)), "wall_s", wall_s);
}

sc_status sc_report_compare(const sc_ctx *ctx, const char *const *directories, int count,
                            sc_text *out)
{
    json_auto_t *runs = json_array(), *data = NULL, *differing = NULL;
    SC_OWN(sc_run_stats_clear) sc_run_stats first = {0}, stats = {0};
    int common = 0;

    for (int i = 0; i < count; i++) {
        char path[SC_REPORT_PATH_BYTES];
        int frame = -1;

        snprintf(path, sizeof path, "%s/stats.json", directories[i]);
        SC_PASS(sc_run_stats_read(ctx, path, i ? &stats : &first));
        runs = sc_json_with(runs, compared_json(directories[i], i ? &stats : &first));
        if (i && !differing)
            frame = differing_frame(&first.history, &stats.history, &common);
        if (frame >= 0)
            differing =
                json_pack("{s:i, s:o}", "frame", frame, "name", sc_json_text(directories[i]));
        sc_run_stats_clear(&stats);
    }
    data = json_pack("{s:s, s:s, s:i, s:O*, s:O}", "kind", "runs", "title", "Comparison of runs",
                     "common", common, "differing", differing, "runs", runs);
    return sc_json_page(ctx, data, out);
}
