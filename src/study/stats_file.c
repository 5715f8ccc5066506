/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads all of a stats.json, for reports. Nothing in it is trusted, as in stats_read.c, which reads
 * the runs and frames. */
#include "heat_json.h"
#include "internal.h"
#include "rank_json.h"

/* The largest stats.json that is read; see history.c. */
#define STATS_BYTES_MAX ((size_t)1 << 30)

#define ROW(kind, member) SC_JSON_ROW(kind, sc_run_record, member)
#define MEMORY(key, member) SC_JSON_ROW_AS(COUNT, key, sc_run_record, memory.member)
#define SPEED(member) SC_JSON_ROW(SECONDS, sc_run_stats, member)

const sc_json_row sc_memory_rows[] = {MEMORY("volume_bytes", volume),
                                      MEMORY("prepared_bytes", prepared),
                                      MEMORY("derived_bytes", derived),
                                      MEMORY("renderer_bytes", renderer),
                                      {0}};
static const sc_json_row speed_rows[] = {SPEED(frames_per_s), SPEED(mrays_per_cpu_s), {0}};
static const sc_json_row how_rows[] = {ROW(BOOL, wrote_png), ROW(BOOL, from_prepared), {0}};

/* Read memory, speed, and what else is told of the last run alone. */
static bool read_figures(const json_t *root, sc_run_stats *out)
{
    const json_t *memory = json_object_get(root, "memory");
    const json_t *peaks = json_object_get(memory, "peak_rss_bytes");

    if (!sc_json_read_rows(sc_memory_rows, memory, &out->run) ||
        !sc_json_read_rows(speed_rows, json_object_get(root, "speed"), out) ||
        !sc_json_read_rows(how_rows, root, &out->run) ||
        json_array_size(peaks) != (size_t)out->run.ranks)
        return false;
    for (int i = 0; i < out->run.ranks; i++) {
        if (!sc_json_count(json_array_get(peaks, (size_t)i), &out->ranks[i].peak_rss_bytes))
            return false;
    }
    return true;
}

/* Fill in what the run and its ranks have of the last run of the history. */
static void take_last_run(const sc_run_entry *last, sc_run_stats *out)
{
    out->run.ranks = last->ranks;
    out->run.nodes = last->nodes;
    out->run.ended = last->ended;
    out->run.id = last->id;
    out->run.wall_s = last->wall_s;
    out->run.farm_wall_s = last->farm_wall_s;
    out->run.frame_count = last->frames;
    out->run.rank_records = out->ranks;
    for (int i = 0; i < last->ranks; i++) {
        const int host = last->rank_hosts ? last->rank_hosts[i] : 0;

        strcpy(out->ranks[i].host, last->hosts[host]);
    }
}

/* Read everything but the history, which has at least one run. @return SC_OK with *good set, or
 * SC_ERR_MEMORY. */
static sc_status read_last_run(const sc_ctx *ctx, const json_t *root, sc_run_stats *out, bool *good)
{
    const sc_run_entry *last = &out->history.runs[out->history.run_count - 1];
    const json_t *per_rank = json_object_get(root, "per_rank");
    const char *version = json_string_value(json_object_get(root, "version"));

    /* so that no memory is taken for ranks of which nothing is told */
    *good = json_array_size(json_object_get(per_rank, "threads")) == (size_t)last->ranks &&
            version && strlen(version) < sizeof out->version;
    if (!*good)
        return SC_OK;
    SC_PASS(SC_ZALLOC(ctx, (size_t)last->ranks, &out->ranks));
    strcpy(out->version, version);
    take_last_run(last, out);
    *good = sc_ranks_from_json(per_rank, out->ranks, last->ranks) && read_figures(root, out);
    if (*good)
        SC_PASS(sc_heat_from_json(ctx, json_object_get(root, "heat"), &out->heat, good));
    return SC_OK;
}

/* Fill the empty @p out from the content of the file. @param problem set to words that follow its
 * name (static) if it cannot be used. @return SC_ERR_MEMORY. */
static sc_status parse(const sc_ctx *ctx, const char *text, sc_run_stats *out, const char **problem)
{
    json_t *root = json_loads(text, 0, NULL);
    const char *schema = json_string_value(json_object_get(root, "schema"));
    bool good = sc_json_hash(json_object_get(root, "job_hash"), &out->run.job.job) &&
                sc_json_hash(json_object_get(root, "volume_hash"), &out->run.job.volume);
    sc_status status = SC_OK;

    *problem = !root                                        ? "is damaged: it is not JSON"
               : !schema || strcmp(schema, SC_STATS_SCHEMA) ? "is not a stats.json of this version"
               : !good ? "is damaged: it does not say which job it is of"
                       : NULL;
    if (!*problem)
        status = sc_stats_parse(ctx, text, &out->run.job, &out->history, problem);
    if (status == SC_OK && !*problem && out->history.run_count == 0)
        *problem = "is damaged: it names no run";
    if (status == SC_OK && !*problem) {
        status = read_last_run(ctx, root, out, &good);
        *problem = good ? NULL : "is damaged, or was written by another version of segcast";
    }
    json_decref(root);
    return status;
}

sc_status sc_run_stats_read(const sc_ctx *ctx, const char *path, sc_run_stats *out)
{
    const char *problem = NULL;
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;
    SC_OWN(sc_run_stats_clear) sc_run_stats found = {0};

    SC_PASS(sc_file_read(ctx, path, STATS_BYTES_MAX, &text, &bytes));
    SC_PASS(parse(ctx, text, &found, &problem));
    if (problem)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, problem);
    SC_HAND_OVER(found, out);
    return SC_OK;
}

void sc_run_stats_clear(sc_run_stats *stats)
{
    sc_history_clear(&stats->history);
    sc_free(stats->ranks);
    sc_heat_clear(&stats->heat);
    *stats = (sc_run_stats){0};
}
