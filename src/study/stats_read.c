/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads a stats.json. Nothing in it is trusted: whoever can write to the directory may have changed
 * it. The readers below return false, with @p out untouched or partly filled, if a value is
 * missing, of another type or out of range. */
#include "internal.h"
#include "segcast/json_values.h"

#include <stdlib.h>

sc_status sc_history_allocate(const sc_ctx *ctx, size_t runs, size_t frames, sc_history *out)
{
    SC_PASS(SC_ZALLOC(ctx, runs, &out->runs));
    return SC_ALLOC(ctx, frames, &out->frames);
}

/* Read seconds, and a count of rays or the like. */
static bool read_seconds(const json_t *object, const char *key, double *out)
{
    return sc_json_real(json_object_get(object, key), 0, 1e12, out);
}

static bool read_count(const json_t *object, const char *key, uint64_t *out)
{
    return sc_json_count(json_object_get(object, key), out);
}

/* Read a text into out[size]; also none if it is @p optional. */
static bool read_text(const json_t *value, bool optional, char *out, size_t size)
{
    const char *text = json_string_value(value);

    if (!text)
        return optional && (!value || json_is_null(value));
    if (strlen(text) >= size || strlen(text) != json_string_length(value))
        return false; /* segcast has not written this */
    strcpy(out, text);
    return true;
}

/* Read the names of hosts, and which of them each rank was on. Files of earlier versions have
 * neither, which stands for the host of rank 0 alone. @param out its host and ranks are read
 * already; owns what is allocated, also after an error. @return SC_OK with *good set, or
 * SC_ERR_MEMORY. */
static sc_status read_hosts(const sc_ctx *ctx, const json_t *json, sc_run_entry *out, bool *good)
{
    const json_t *hosts = json_object_get(json, "hosts");
    const json_t *places = json_object_get(json, "rank_hosts");
    const size_t count = hosts ? json_array_size(hosts) : 1;

    *good = false;
    if (count == 0 || count > INT32_MAX ||
        (places && json_array_size(places) != (size_t)out->ranks))
        return SC_OK;
    SC_PASS(sc_alloc(ctx, count, SC_HOST_BYTES, &out->hosts));
    if (!hosts)
        strcpy(out->hosts[0], out->host);
    for (size_t i = 0; hosts && i < count; i++) {
        if (!read_text(json_array_get(hosts, i), false, out->hosts[i], SC_HOST_BYTES))
            return SC_OK;
    }
    out->host_count = (int)count;
    if (places) {
        SC_PASS(sc_alloc(ctx, (size_t)out->ranks, sizeof(int), &out->rank_hosts));
    }
    for (int i = 0; places && i < out->ranks; i++) {
        if (!sc_json_int(json_array_get(places, (size_t)i), 0, INT32_MAX, &out->rank_hosts[i]) ||
            out->rank_hosts[i] >= out->host_count)
            return SC_OK;
    }
    *good = true;
    return SC_OK;
}

/* @return an id for a run of an earlier version, which wrote none. */
static uint64_t id_of(const sc_run_entry *run)
{
    uint64_t id = sc_hash_bytes(run->begin, strlen(run->begin), 0);

    id = sc_hash_bytes(run->host, strlen(run->host), id);
    id = sc_hash_bytes(&run->ranks, sizeof run->ranks, id);
    return sc_hash_bytes(&run->wall_s, sizeof run->wall_s, id);
}

sc_status sc_keep_made_from(const sc_ctx *ctx, const json_t *run, char **out)
{
    const json_t *from = json_object_get(run, "made_from");
    char *text = json_is_object(from) ? json_dumps(from, JSON_COMPACT) : NULL;
    const sc_status status = text ? sc_text_copy(ctx, text, out) : SC_OK;

    free(text);
    return status;
}

/* Read an element of `runs`. @param out zeroed; owns what is allocated, also after an error.
 * @return SC_OK with *good set, or SC_ERR_MEMORY. */
static sc_status read_run(const sc_ctx *ctx, const json_t *json, sc_run_entry *out, bool *good)
{
    const struct {
        const char *key;
        char *to;
    } texts[] = {{"processor", out->processor},
                 {"kernel", out->kernel},
                 {"mpi", out->mpi},
                 {"commit", out->commit},
                 {"batch_job", out->batch_job}};
    const json_t *ended = json_object_get(json, "ended"), *id = json_object_get(json, "id");

    *good = (!ended || json_is_boolean(ended)) &&
            read_text(json_object_get(json, "begin"), false, out->begin, sizeof out->begin) &&
            read_text(json_object_get(json, "host"), false, out->host, sizeof out->host) &&
            sc_json_int(json_object_get(json, "ranks"), 1, INT32_MAX, &out->ranks) &&
            sc_json_int(json_object_get(json, "threads"), 0, INT32_MAX, &out->threads) &&
            sc_json_int(json_object_get(json, "nodes"), 1, INT32_MAX, &out->nodes) &&
            read_seconds(json, "wall_s", &out->wall_s) &&
            read_seconds(json, "cpu_s", &out->cpu_s) &&
            (!json_object_get(json, "farm_wall_s") ||
             read_seconds(json, "farm_wall_s", &out->farm_wall_s)) &&
            sc_json_int(json_object_get(json, "frames"), 0, INT32_MAX, &out->frames) &&
            (!id || sc_json_hash(json_object_get(json, "id"), &out->id));
    for (size_t i = 0; i < SC_COUNT_OF(texts) && *good; i++)
        *good =
            read_text(json_object_get(json, texts[i].key), true, texts[i].to, SC_RUN_TEXT_BYTES);
    if (!*good)
        return SC_OK;
    out->ended = !ended || json_is_true(ended);
    if (!id)
        out->id = id_of(out);
    SC_PASS(sc_keep_made_from(ctx, json, &out->made_from));
    return read_hosts(ctx, json, out, good);
}

/* Read an element of `frames`, which one of @p runs drew. */
static bool read_frame(const json_t *json, const sc_history *runs, sc_past_frame *out)
{
    const json_t *run = json_object_get(json, "run");
    sc_past_frame past = {.run = -1, .measured = !json_is_null(json_object_get(json, "rays"))};
    sc_frame_result *f = &past.result;

    if (!sc_json_int(json_object_get(json, "frame"), 0, INT32_MAX, &f->frame) ||
        !sc_json_int(json_object_get(json, "rank"), 0, INT32_MAX, &f->rank) ||
        !read_seconds(json, "render_cpu_s", &f->render_cpu_s) ||
        !sc_json_hash(json_object_get(json, "hash"), &f->hash) ||
        (!json_is_null(run) &&
         (!sc_json_int(run, 0, INT32_MAX, &past.run) || past.run >= runs->run_count)))
        return false;
    if (past.run >= 0 && f->rank >= runs->runs[past.run].ranks)
        return false;
    if (past.measured &&
        (past.run < 0 || !read_seconds(json, "render_wall_s", &f->render_wall_s) ||
         !read_seconds(json, "wait_s", &f->wait_s) || !read_count(json, "rays", &f->rays) ||
         !read_count(json, "samples", &f->samples) ||
         !read_count(json, "contributions", &f->contributions)))
        return false;
    *out = past;
    return true;
}

/* Append all runs and frames to @p h, whose arrays are large enough. @return SC_OK with *good set,
 * or SC_ERR_MEMORY; what was read before stays appended. */
static sc_status read_arrays(const sc_ctx *ctx, const json_t *runs, const json_t *frames,
                             sc_history *h, bool *good)
{
    *good = true;
    for (size_t i = 0; i < json_array_size(runs) && *good; i++)
        SC_PASS(read_run(ctx, json_array_get(runs, i), &h->runs[h->run_count++], good));
    for (size_t i = 0; i < json_array_size(frames) && *good; i++) {
        *good = read_frame(json_array_get(frames, i), h, &h->frames[h->frame_count]);
        h->frame_count += *good;
    }
    return SC_OK;
}

sc_status sc_stats_parse(const sc_ctx *ctx, const char *text, const sc_job_hashes *job,
                         sc_history *out, const char **problem)
{
    json_t *root = json_loads(text, 0, NULL);
    const json_t *runs = json_object_get(root, "runs"), *frames = json_object_get(root, "frames");
    sc_job_hashes found;
    bool good = true;
    sc_status status = SC_OK;

    if (!root) {
        *problem = "is damaged";
    } else if (!sc_json_hash(json_object_get(root, "job_hash"), &found.job) ||
               !sc_json_hash(json_object_get(root, "volume_hash"), &found.volume) ||
               !json_is_array(runs) || !json_is_array(frames)) {
        *problem = "does not say which runs and which job it is of";
    } else if (found.job != job->job || found.volume != job->volume) {
        *problem = "is of another job";
    } else if (json_array_size(runs) > INT32_MAX / 2 || json_array_size(frames) > INT32_MAX / 2) {
        *problem = "is too large";
    } else {
        status = sc_history_allocate(ctx, json_array_size(runs), json_array_size(frames), out);
        if (status == SC_OK)
            status = read_arrays(ctx, runs, frames, out, &good);
        if (status == SC_OK && !good)
            *problem = "is damaged";
    }
    json_decref(root);
    return status;
}
