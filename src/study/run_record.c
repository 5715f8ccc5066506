/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes stats.json and frames.csv from the timing record of a run. All functions *_json return a
 * new reference that the caller owns, or NULL if there is no memory. */
#include "segcast/study.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

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

/* Append @p item, of which NULL stands for no memory. Takes ownership of it, and of @p array.
 * @return the array, or NULL, once there was no memory. */
static json_t *append(json_t *array, json_t *item)
{
    if (array && json_array_append_new(array, item) == 0)
        return array;
    if (!array)
        json_decref(item);
    json_decref(array);
    return NULL;
}

/* The object `phases`. Wall time: that of the rank that took longest; CPU time: the sum over all
 * ranks. */
static json_t *phases_json(const sc_run_record *run)
{
    json_t *phases = json_object();

    for (int phase = 0; phase < SC_PHASE_COUNT && phases; phase++) {
        double wall_s = 0, cpu_s = 0;

        for (int i = 0; i < run->ranks; i++) {
            const sc_phase_time *time = &run->rank_records[i].phases[phase];

            wall_s = time->wall_s > wall_s ? time->wall_s : wall_s;
            cpu_s += time->cpu_s;
        }
        if (json_object_set_new(phases, phase_names[phase],
                                json_pack("{s:f, s:f}", "wall_s", wall_s, "cpu_s", cpu_s))) {
            json_decref(phases);
            phases = NULL;
        }
    }
    return phases;
}

/* Write a hash as 16 hexadecimal digits into @p text. */
static void format_hash(uint64_t hash, char text[17])
{
    snprintf(text, 17, "%016llx", (unsigned long long)hash);
}

/* A position in the frames of this run and of earlier ones, in rising order; {.run = run} is the
 * beginning. */
typedef struct frame_cursor {
    const sc_run_record *run;
    int own, past; /* indices of the next ones in run->frames and in run->earlier->frames */
} frame_cursor;

/* Put the next frame into @p out, and move the cursor behind it. Of a frame that was drawn in this
 * run and before, that of this run comes alone; its run is the number of earlier ones. @return
 * false, with @p out untouched, at the end. */
static bool next_frame(frame_cursor *cursor, sc_past_frame *out)
{
    const sc_run_record *run = cursor->run;
    const sc_history *earlier = run->earlier;
    const int past_count = earlier ? earlier->frame_count : 0;
    const bool has_own = cursor->own < run->frame_count;

    while (has_own && cursor->past < past_count &&
           earlier->frames[cursor->past].result.frame == run->frames[cursor->own].frame)
        cursor->past++; /* this run drew it again */
    if (has_own && (cursor->past == past_count ||
                    run->frames[cursor->own].frame < earlier->frames[cursor->past].result.frame)) {
        *out = (sc_past_frame){run->frames[cursor->own++], earlier ? earlier->run_count : 0};
        return true;
    }
    if (cursor->past == past_count)
        return false;
    *out = earlier->frames[cursor->past++];
    return true;
}

/* The array `frames`: of this run and of earlier ones. */
static json_t *frames_json(const sc_run_record *run)
{
    json_t *frames = json_array();
    frame_cursor cursor = {.run = run};
    sc_past_frame past;

    while (frames && next_frame(&cursor, &past)) {
        const sc_frame_result *f = &past.result;
        char hash[17];

        format_hash(f->hash, hash);
        frames =
            append(frames,
                   json_pack("{s:i, s:i, s:i, s:f, s:f, s:f, s:I, s:I, s:I, s:s}", "frame",
                             f->frame, "run", past.run, "rank", f->rank, "render_wall_s",
                             f->render_wall_s, "render_cpu_s", f->render_cpu_s, "wait_s", f->wait_s,
                             "rays", (json_int_t)f->rays, "samples", (json_int_t)f->samples,
                             "contributions", (json_int_t)f->contributions, "hash", hash));
    }
    return frames;
}

/* @return the CPU seconds of all ranks together. */
static double total_cpu_s(const sc_run_record *run)
{
    double cpu_s = 0;

    for (int i = 0; i < run->ranks; i++)
        cpu_s += run->rank_records[i].cpu_s;
    return cpu_s;
}

/* @return what stats.json will say of this run to later ones; the host is cut off if too long. */
static sc_run_entry entry_of(const sc_run_record *run)
{
    const time_t begin = (time_t)run->begin_unix_s;
    sc_run_entry entry = {.ranks = run->ranks,
                          .threads = run->rank_records[0].threads,
                          .nodes = run->nodes,
                          .wall_s = run->wall_s,
                          .cpu_s = total_cpu_s(run),
                          .frames = run->frame_count};
    struct tm utc;

    snprintf(entry.host, sizeof entry.host, "%s", run->host);
    if (gmtime_r(&begin, &utc))
        strftime(entry.begin, sizeof entry.begin, "%Y-%m-%dT%H:%M:%SZ", &utc);
    return entry;
}

/* An element of the array `runs`. */
static json_t *entry_json(const sc_run_entry *run)
{
    return json_pack("{s:s, s:s, s:i, s:i, s:i, s:f, s:f, s:i}", "begin", run->begin, "host",
                     run->host, "ranks", run->ranks, "threads", run->threads, "nodes", run->nodes,
                     "wall_s", run->wall_s, "cpu_s", run->cpu_s, "frames", run->frames);
}

/* The array `runs`: the earlier ones, and at the end this one. */
static json_t *runs_json(const sc_run_record *run)
{
    const sc_run_entry this_run = entry_of(run);
    json_t *runs = json_array();

    for (int i = 0; run->earlier && i < run->earlier->run_count; i++)
        runs = append(runs, entry_json(&run->earlier->runs[i]));
    return append(runs, entry_json(&this_run));
}

/* The array `hosts`: each once, in the order of ranks. */
static json_t *hosts_json(const sc_run_record *run)
{
    json_t *hosts = json_array();

    for (int i = 0; i < run->ranks; i++) {
        const char *host = run->rank_records[i].host;
        bool known = false;

        for (size_t k = 0; k < json_array_size(hosts) && !known; k++)
            known = !strcmp(json_string_value(json_array_get(hosts, k)), host);
        if (!known)
            hosts = append(hosts, json_string(host));
    }
    return hosts;
}

/* All of stats.json. */
static json_t *run_json(const sc_run_record *run)
{
    json_t *peaks = json_array();
    char job_hash[17], volume_hash[17];
    double render_cpu_s = 0, rays = 0;
    const sc_run_entry entry = entry_of(run);

    format_hash(run->job.job, job_hash);
    format_hash(run->job.volume, volume_hash);
    for (int i = 0; i < run->ranks; i++) {
        render_cpu_s += run->rank_records[i].phases[SC_PHASE_RENDER].cpu_s;
        peaks = append(peaks, json_integer((json_int_t)run->rank_records[i].peak_rss_bytes));
    }
    for (int i = 0; i < run->frame_count; i++)
        rays += (double)run->frames[i].rays;
    return json_pack(
        "{s:s, s:s, s:s, s:s, s:s, s:i, s:i, s:i, s:f, s:f, s:o, s:o, s:o, s:{s:I, s:I, s:o}, "
        "s:{s:f, s:f}, s:f, s:s, s:s?, s:s?, s:s?, s:s?, s:s?, s:o, s:f}",
        "schema", "segcast-stats-1", "version", run->version, "job_hash", job_hash, "volume_hash",
        volume_hash, "host", run->host, "ranks", run->ranks, "threads",
        run->rank_records[0].threads, "nodes", run->nodes, "wall_s", run->wall_s, "cpu_s",
        total_cpu_s(run), "phases", phases_json(run), "runs", runs_json(run), "frames",
        frames_json(run), "memory", "volume_bytes", (json_int_t)run->volume_bytes, "prepared_bytes",
        (json_int_t)run->prepared_bytes, "peak_rss_bytes", peaks, "speed", "frames_per_s",
        run->wall_s > 0 ? run->frame_count / run->wall_s : 0, "mrays_per_cpu_s",
        render_cpu_s > 0 ? rays / render_cpu_s / 1e6 : 0, "imbalance", sc_run_imbalance(run),
        "begin", entry.begin, "commit", run->commit, "processor", run->processor, "kernel",
        run->kernel, "mpi", run->mpi, "batch_job", run->batch_job, "hosts", hosts_json(run),
        "farm_wall_s", run->farm_wall_s);
}

/* Write stats.json under @p path. */
static sc_status write_json(const sc_ctx *ctx, const sc_run_record *run, const char *path)
{
    json_t *json = run_json(run);
    char *text;
    sc_status status;

    errno = 0;
    text = json ? json_dumps(json, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) : NULL;
    if (!text || errno == ENOMEM) /* jansson leaves out what it has no memory for */
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    else
        status = sc_file_write(ctx, path, text, strlen(text));

    free(text);
    json_decref(json);
    return status;
}

/* Write frames.csv under @p path: a line of headings, and one for each frame. */
static sc_status write_csv(const sc_ctx *ctx, const sc_run_record *run, const char *path)
{
    frame_cursor cursor = {.run = run};
    sc_past_frame past;
    sc_text text = {0};
    sc_status status;

    SC_TRY(sc_text_add(ctx, &text,
                       "frame,rank,render_wall_s,render_cpu_s,wait_s,rays,samples,"
                       "contributions,hash,run\n"));
    while (next_frame(&cursor, &past)) {
        const sc_frame_result *f = &past.result;

        SC_TRY(sc_text_add(ctx, &text, "%d,%d,%.6f,%.6f,%.6f,%llu,%llu,%llu,%016llx,%d\n", f->frame,
                           f->rank, f->render_wall_s, f->render_cpu_s, f->wait_s,
                           (unsigned long long)f->rays, (unsigned long long)f->samples,
                           (unsigned long long)f->contributions, (unsigned long long)f->hash,
                           past.run));
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
