/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/study.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static const char *const phase_names[SC_PHASE_COUNT] = {"read",   "prepare", "share", "render",
                                                        "gather", "encode",  "write", "idle"};

double sc_run_imbalance(const sc_run_record *run)
{
    double most = 0, sum = 0;

    for (int i = 0; i < run->ranks; i++) {
        const double wall_s = run->rank_records[i].phases[SC_PHASE_RENDER].wall_s;

        most = wall_s > most ? wall_s : most;
        sum += wall_s;
    }
    return sum > 0 ? most * run->ranks / sum - 1 : 0;
}

/* Wall: the longest of all ranks; CPU: the sum over all ranks. */
static json_t *phases_json(const sc_run_record *run)
{
    json_t *phases = json_object();

    for (int phase = 0; phase < SC_PHASE_COUNT; phase++) {
        double wall_s = 0, cpu_s = 0;

        for (int i = 0; i < run->ranks; i++) {
            const sc_phase_time *time = &run->rank_records[i].phases[phase];

            wall_s = time->wall_s > wall_s ? time->wall_s : wall_s;
            cpu_s += time->cpu_s;
        }
        json_object_set_new(phases, phase_names[phase],
                            json_pack("{s:f, s:f}", "wall_s", wall_s, "cpu_s", cpu_s));
    }
    return phases;
}

static json_t *frames_json(const sc_run_record *run)
{
    json_t *frames = json_array();

    for (int i = 0; i < run->frame_count; i++) {
        const sc_frame_result *f = &run->frames[i];
        char hash[17];

        snprintf(hash, sizeof hash, "%016llx", (unsigned long long)f->hash);
        json_array_append_new(frames, json_pack("{s:i, s:i, s:f, s:f, s:f, s:I, s:I, s:I, s:s}",
                                                "frame", f->frame, "rank", f->rank, "render_wall_s",
                                                f->render_wall_s, "render_cpu_s", f->render_cpu_s,
                                                "wait_s", f->wait_s, "rays", (json_int_t)f->rays,
                                                "samples", (json_int_t)f->samples, "contributions",
                                                (json_int_t)f->contributions, "hash", hash));
    }
    return frames;
}

static json_t *run_json(const sc_run_record *run)
{
    json_t *peaks = json_array();
    double cpu_s = 0, render_cpu_s = 0, rays = 0;

    for (int i = 0; i < run->ranks; i++) {
        cpu_s += run->rank_records[i].cpu_s;
        render_cpu_s += run->rank_records[i].phases[SC_PHASE_RENDER].cpu_s;
        json_array_append_new(peaks, json_integer((json_int_t)run->rank_records[i].peak_rss_bytes));
    }
    for (int i = 0; i < run->frame_count; i++)
        rays += (double)run->frames[i].rays;
    return json_pack(
        "{s:s, s:s, s:s, s:i, s:i, s:i, s:f, s:f, s:o, s:o, s:{s:I, s:I, s:o}, s:{s:f, s:f}, s:f}",
        "schema", "segcast-stats-1", "version", run->version, "host", run->host, "ranks",
        run->ranks, "threads", run->rank_records[0].threads, "nodes", run->nodes, "wall_s",
        run->wall_s, "cpu_s", cpu_s, "phases", phases_json(run), "frames", frames_json(run),
        "memory", "volume_bytes", (json_int_t)run->volume_bytes, "prepared_bytes",
        (json_int_t)run->prepared_bytes, "peak_rss_bytes", peaks, "speed", "frames_per_s",
        run->wall_s > 0 ? run->frame_count / run->wall_s : 0, "mrays_per_cpu_s",
        render_cpu_s > 0 ? rays / render_cpu_s / 1e6 : 0, "imbalance", sc_run_imbalance(run));
}

static sc_status write_json(const sc_ctx *ctx, const sc_run_record *run, const char *path)
{
    json_t *json = run_json(run);
    char *text = json ? json_dumps(json, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) : NULL;
    sc_status status = text ? sc_file_write(ctx, path, text, strlen(text))
                            : sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);

    free(text);
    json_decref(json);
    return status;
}

static sc_status write_csv(const sc_ctx *ctx, const sc_run_record *run, const char *path)
{
    sc_text text = {0};
    sc_status status;

    SC_TRY(sc_text_add(ctx, &text,
                       "frame,rank,render_wall_s,render_cpu_s,wait_s,rays,samples,"
                       "contributions,hash\n"));
    for (int i = 0; i < run->frame_count; i++) {
        const sc_frame_result *f = &run->frames[i];

        SC_TRY(sc_text_add(ctx, &text, "%d,%d,%.6f,%.6f,%.6f,%llu,%llu,%llu,%016llx\n", f->frame,
                           f->rank, f->render_wall_s, f->render_cpu_s, f->wait_s,
                           (unsigned long long)f->rays, (unsigned long long)f->samples,
                           (unsigned long long)f->contributions, (unsigned long long)f->hash));
    }
    status = sc_file_write(ctx, path, text.data, text.length_bytes);
out:
    sc_text_clear(&text);
    return status;
}

sc_status sc_run_write(const sc_ctx *ctx, const sc_run_record *run, const char *json,
                       const char *csv)
{
    sc_status status = write_json(ctx, run, json);

    return status == SC_OK ? write_csv(ctx, run, csv) : status;
}
