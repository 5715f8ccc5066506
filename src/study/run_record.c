/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes stats.json and frames.csv from the timing record of a run. All functions *_json return a
 * new reference that the caller owns, or NULL if there is no memory. */
#include "heat_json.h"
#include "internal.h"
#include "rank_json.h"
#include "segcast/core_time.h"
#include "segcast/json_values.h"

#include <time.h>

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

sc_phase_time sc_run_phase(const sc_run_record *run, int phase)
{
    sc_phase_time all = {0, 0};

    for (int i = 0; i < run->ranks; i++) {
        const sc_phase_time *time = &run->rank_records[i].phases[phase];

        all.wall_s = time->wall_s > all.wall_s ? time->wall_s : all.wall_s;
        all.cpu_s += time->cpu_s;
    }
    return all;
}

/* The object `phases`. */
static json_t *phases_json(const sc_run_record *run)
{
    json_t *phases = json_object();

    for (int phase = 0; phase < SC_PHASE_COUNT && phases; phase++) {
        const sc_phase_time time = sc_run_phase(run, phase);

        phases =
            sc_json_with_key(phases, sc_phase_key(phase),
                             json_pack("{s:f, s:f}", "wall_s", time.wall_s, "cpu_s", time.cpu_s));
    }
    return phases;
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
        *out = (sc_past_frame){.result = run->frames[cursor->own++],
                               .run = earlier ? earlier->run_count : 0,
                               .measured = true};
        return true;
    }
    if (cursor->past == past_count)
        return false;
    *out = earlier->frames[cursor->past++];
    return true;
}

/* An element of the array `frames`; null stands for what is unknown. */
static json_t *frame_json(const sc_past_frame *past)
{
    const sc_frame_result *f = &past->result;
    json_t *json = sc_json_of_rows(sc_frame_rows, f);

    for (const sc_json_row *row = sc_measured_rows; row->key && json; row++)
        json =
            sc_json_with_key(json, row->key, past->measured ? sc_json_of_row(row, f) : json_null());
    return sc_json_with_key(json, "run", past->run >= 0 ? json_integer(past->run) : json_null());
}

/* The array `frames`: of this run and of earlier ones. */
static json_t *frames_json(const sc_run_record *run)
{
    json_t *frames = json_array();
    frame_cursor cursor = {.run = run};
    sc_past_frame past;

    while (frames && next_frame(&cursor, &past))
        frames = sc_json_with(frames, frame_json(&past));
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

/* Find the hosts of the run, each once in the order of ranks, and which of them each rank was on.
 * @param entry its hosts and rank_hosts have room for all ranks. */
static void find_hosts(const sc_run_record *run, sc_run_entry *entry)
{
    for (int rank = 0; rank < run->ranks; rank++) {
        char host[SC_HOST_BYTES];
        int at = rank ? entry->rank_hosts[rank - 1] : 0; /* most ranks have the host of the last */

        (void)sc_copy_name(run->rank_records[rank].host, host, sizeof host);
        if (rank == 0 || strcmp(entry->hosts[at], host) != 0) {
            at = 0;
            while (at < entry->host_count && strcmp(entry->hosts[at], host) != 0)
                at++;
        }
        if (at == entry->host_count)
            strcpy(entry->hosts[entry->host_count++], host);
        entry->rank_hosts[rank] = at;
    }
}

/* Copy a text that may be NULL to @p to, which has SC_RUN_TEXT_BYTES, as JSON can hold it. */
static void copy_text(const char *from, char *to)
{
    (void)sc_copy_name(from ? from : "", to, SC_RUN_TEXT_BYTES);
}

/* Fill in what stats.json says of this run. @param entry zeroed; the caller owns what it holds,
 * also after an error: sc_run_entry_clear. @return SC_ERR_MEMORY. */
static sc_status fill_entry(const sc_ctx *ctx, const sc_run_record *run, sc_run_entry *entry)
{
    const time_t begin = (time_t)run->begin_unix_s;
    struct tm utc;

    *entry = (sc_run_entry){.id = run->id,
                            .ended = run->ended,
                            .ranks = run->ranks,
                            .threads = run->rank_records[0].threads,
                            .nodes = run->nodes,
                            .wall_s = run->wall_s,
                            .cpu_s = total_cpu_s(run),
                            .farm_wall_s = run->farm_wall_s,
                            .frames = run->frame_count};
    (void)sc_copy_name(run->platform.host, entry->host, sizeof entry->host);
    copy_text(run->platform.processor, entry->processor);
    copy_text(run->platform.kernel, entry->kernel);
    copy_text(run->platform.mpi, entry->mpi);
    copy_text(run->platform.commit, entry->commit);
    copy_text(run->platform.batch_job, entry->batch_job);
    if (gmtime_r(&begin, &utc))
        strftime(entry->begin, sizeof entry->begin, "%Y-%m-%dT%H:%M:%SZ", &utc);
    if (run->made_from)
        SC_PASS(sc_text_copy(ctx, run->made_from, &entry->made_from));
    SC_PASS(sc_alloc(ctx, (size_t)run->ranks, SC_HOST_BYTES, &entry->hosts));
    SC_PASS(sc_alloc(ctx, (size_t)run->ranks, sizeof(int), &entry->rank_hosts));
    find_hosts(run, entry);
    return SC_OK;
}

/* The array `hosts` of a run. */
static json_t *hosts_json(const sc_run_entry *run)
{
    json_t *hosts = json_array();

    for (int i = 0; i < run->host_count; i++)
        hosts = sc_json_with(hosts, json_string(run->hosts[i]));
    return hosts;
}

/* The array `rank_hosts` of a run, whose entry knows it. */
static json_t *rank_hosts_json(const sc_run_entry *run)
{
    json_t *places = json_array();

    for (int i = 0; i < run->ranks; i++)
        places = sc_json_with(places, json_integer(run->rank_hosts[i]));
    return places;
}

/* The keys of a run in `runs`; those of the last one stand at the top, too. */
static json_t *known_json(const sc_run_entry *run)
{
    return sc_json_with_key(sc_json_of_rows(sc_run_entry_rows, run), "hosts", hosts_json(run));
}

/* An element of the array `runs`. */
static json_t *entry_json(const sc_run_entry *run)
{
    json_t *json = known_json(run);

    if (run->made_from)
        json = sc_json_with_key(json, "made_from", json_loads(run->made_from, 0, NULL));
    return run->rank_hosts ? sc_json_with_key(json, "rank_hosts", rank_hosts_json(run)) : json;
}

/* The array `runs`: the earlier ones, and at the end this one. */
static json_t *runs_json(const sc_run_record *run, const sc_run_entry *this_run)
{
    json_t *runs = json_array();

    for (int i = 0; run->earlier && i < run->earlier->run_count; i++)
        runs = sc_json_with(runs, entry_json(&run->earlier->runs[i]));
    return sc_json_with(runs, entry_json(this_run));
}

/* The object `core_time`. */
static json_t *core_time_json(const sc_run_record *run)
{
    const sc_core_time time = sc_run_core_time(run);
    json_t *json = json_pack("{s:f}", "core_s", time.core_s);

    for (int i = 0; i < SC_CAUSE_COUNT && json; i++)
        json = sc_json_with_key(json, sc_cause_key(i), json_real(time.causes_s[i]));
    return json;
}

/* All of stats.json: what `runs` says of this run, and more. */
static json_t *run_json(const sc_run_record *run, const sc_run_entry *entry)
{
    json_t *peaks = json_array(), *json;
    json_auto_t *known = known_json(entry);
    const double render_cpu_s = sc_run_phase(run, SC_PHASE_RENDER).cpu_s;
    double rays = 0;

    for (int i = 0; i < run->ranks; i++)
        peaks = sc_json_with(peaks, json_integer((json_int_t)run->rank_records[i].peak_rss_bytes));
    for (int i = 0; i < run->frame_count; i++)
        rays += (double)run->frames[i].rays;
    json = json_pack(
        "{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:{s:f, s:f}, s:f, s:b, s:b, s:o, s:o, s:o, s:o}",
        "schema", SC_STATS_SCHEMA, "version", run->platform.version, "job_hash",
        sc_json_of_hash(run->job.job), "volume_hash", sc_json_of_hash(run->job.volume), "phases",
        phases_json(run), "runs", runs_json(run, entry), "frames", frames_json(run), "memory",
        sc_json_with_key(sc_json_of_rows(sc_memory_rows, run), "peak_rss_bytes", peaks), "speed",
        "frames_per_s", run->wall_s > 0 ? run->frame_count / run->wall_s : 0, "mrays_per_cpu_s",
        render_cpu_s > 0 ? rays / render_cpu_s / 1e6 : 0, "imbalance", sc_run_imbalance(run),
        "wrote_png", run->wrote_png, "from_prepared", run->from_prepared, "core_time",
        core_time_json(run), "heat", sc_heat_to_json(run->heat), "per_rank",
        sc_ranks_to_json(run->rank_records, run->ranks), "settings",
        run->settings ? json_loads(run->settings, 0, NULL) : json_null());
    if (json && (!known || json_object_update_missing(json, known))) {
        json_decref(json);
        json = NULL;
    }
    return json;
}

/* Write stats.json under @p path. */
static sc_status write_json(const sc_ctx *ctx, const sc_run_record *run, const sc_run_entry *entry,
                            const char *path)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_json_add_text(ctx, run_json(run, entry), JSON_INDENT(1) | JSON_REAL_PRECISION(9),
                             path, &text));
    return sc_file_write(ctx, path, text.data, text.length_bytes);
}

/* Append the host on which a frame was drawn to a line of frames.csv, in quotes if it needs them;
 * nothing if it is unknown. @param run the one that drew it, or NULL. */
static sc_status add_host(const sc_ctx *ctx, const sc_run_entry *run, int rank, sc_text *text)
{
    const char *host = !run                   ? ""
                       : run->rank_hosts      ? run->hosts[run->rank_hosts[rank]]
                       : run->host_count == 1 ? run->hosts[0]
                                              : "";

    return sc_text_add_field(ctx, text, host, ",\"\r\n");
}

/* Append the line of a frame to @p text; what is unknown stays empty. */
static sc_status add_row(const sc_ctx *ctx, const sc_past_frame *past, const sc_run_entry *run,
                         sc_text *text)
{
    const sc_frame_result *f = &past->result;

    SC_PASS(sc_text_add(ctx, text, "%d,%d,", f->frame, f->rank));
    if (past->measured)
        SC_PASS(sc_text_add(ctx, text, "%.6f,%.6f,%.6f,%llu,%llu,%llu,", f->render_wall_s,
                            f->render_cpu_s, f->wait_s, (unsigned long long)f->rays,
                            (unsigned long long)f->samples, (unsigned long long)f->contributions));
    else
        SC_PASS(sc_text_add(ctx, text, ",%.6f,,,,,", f->render_cpu_s));
    SC_PASS(sc_text_add(ctx, text, "%016llx,", (unsigned long long)f->hash));
    if (past->run >= 0)
        SC_PASS(sc_text_add(ctx, text, "%d", past->run));
    SC_PASS(sc_text_add(ctx, text, ","));
    SC_PASS(add_host(ctx, run, f->rank, text));
    return sc_text_add(ctx, text, "\n");
}

/* Write frames.csv under @p path: a line of headings, and one for each frame. */
static sc_status write_csv(const sc_ctx *ctx, const sc_run_record *run, const sc_run_entry *entry,
                           const char *path)
{
    const int earlier = run->earlier ? run->earlier->run_count : 0;
    frame_cursor cursor = {.run = run};
    sc_past_frame past;
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_text_add(
        ctx, &text,
        "frame,rank,render_wall_s,render_cpu_s,wait_s,rays,samples,contributions,hash,run,host\n"));
    while (next_frame(&cursor, &past))
        SC_PASS(add_row(ctx, &past,
                        past.run < 0          ? NULL
                        : past.run == earlier ? entry
                                              : &run->earlier->runs[past.run],
                        &text));
    return sc_file_write(ctx, path, text.data, text.length_bytes);
}

sc_status sc_run_write(const sc_ctx *ctx, const sc_run_record *run, const char *json,
                       const char *csv)
{
    SC_OWN(sc_run_entry_clear) sc_run_entry entry = {0};

    SC_PASS(fill_entry(ctx, run, &entry));
    SC_PASS(write_json(ctx, run, &entry, json));
    return write_csv(ctx, run, &entry, csv);
}
