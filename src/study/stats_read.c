/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads a stats.json. Nothing in it is trusted: whoever can write to the directory may have changed
 * it. The readers below return false, with @p out untouched or partly filled, if a value is
 * missing, of another type or out of range. */
#include "internal.h"

#include <stdlib.h>

sc_status sc_history_allocate(const sc_ctx *ctx, size_t runs, size_t frames, sc_history *out)
{
    SC_PASS(SC_ZALLOC(ctx, runs, &out->runs));
    return SC_ALLOC(ctx, frames, &out->frames);
}

#define RUN(kind, member) SC_JSON_ROW(kind, sc_run_entry, member)
#define FRAME(kind, member) SC_JSON_ROW(kind, sc_frame_result, member)

const sc_json_row sc_run_entry_rows[] = {RUN(HASH, id),
                                         RUN(BOOL, ended),
                                         RUN(TEXT, begin),
                                         RUN(TEXT, host),
                                         RUN(INT, ranks),
                                         RUN(INT, threads),
                                         RUN(INT, nodes),
                                         RUN(SECONDS, wall_s),
                                         RUN(SECONDS, cpu_s),
                                         RUN(SECONDS, farm_wall_s),
                                         RUN(INT, frames),
                                         RUN(TEXT, processor),
                                         RUN(TEXT, kernel),
                                         RUN(TEXT, mpi),
                                         RUN(TEXT, commit),
                                         RUN(TEXT, batch_job),
                                         {0}};
const sc_json_row sc_frame_rows[] = {
    FRAME(INT, frame), FRAME(INT, rank), FRAME(SECONDS, render_cpu_s), FRAME(HASH, hash), {0}};
const sc_json_row sc_measured_rows[] = {
    FRAME(SECONDS, render_wall_s), FRAME(SECONDS, wait_s),      FRAME(COUNT, rays),
    FRAME(COUNT, samples),         FRAME(COUNT, contributions), {0}};

/* Read the names of hosts, and, where it is known, which of them each rank was on. @param out its
 * ranks are read already; owns what is allocated, also after an error. @return SC_OK with *good
 * set, or SC_ERR_MEMORY. */
static sc_status read_hosts(const sc_ctx *ctx, const json_t *json, sc_run_entry *out, bool *good)
{
    const json_t *hosts = json_object_get(json, "hosts");
    const json_t *places = json_object_get(json, "rank_hosts");
    const size_t count = json_array_size(hosts);

    *good = false;
    if (count == 0 || count > INT32_MAX ||
        (places && json_array_size(places) != (size_t)out->ranks))
        return SC_OK;
    SC_PASS(sc_alloc(ctx, count, SC_HOST_BYTES, &out->hosts));
    for (size_t i = 0; i < count; i++) {
        const sc_json_row host = {.kind = SC_JSON_TEXT, .bytes = SC_HOST_BYTES};

        if (!json_is_string(json_array_get(hosts, i)) ||
            !sc_json_read_row(&host, json_array_get(hosts, i), out->hosts[i]))
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
    *good = sc_json_read_rows(sc_run_entry_rows, json, out) && out->ranks > 0 && out->nodes > 0;
    if (!*good)
        return SC_OK;
    SC_PASS(sc_keep_made_from(ctx, json, &out->made_from));
    return read_hosts(ctx, json, out, good);
}

/* Read an element of `frames`, which one of @p runs drew. */
static bool read_frame(const json_t *json, const sc_history *runs, sc_past_frame *out)
{
    const json_t *run = json_object_get(json, "run");

    *out = (sc_past_frame){.run = -1, .measured = !json_is_null(json_object_get(json, "rays"))};
    return sc_json_read_rows(sc_frame_rows, json, &out->result) &&
           (json_is_null(run) || (sc_json_int(run, 0, runs->run_count - 1, &out->run) &&
                                  out->result.rank < runs->runs[out->run].ranks)) &&
           (!out->measured ||
            (out->run >= 0 && sc_json_read_rows(sc_measured_rows, json, &out->result)));
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
