/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads what earlier runs on the same job wrote to stats.json, so that the next one can write it
 * again. */
#include "segcast/study.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

/* The largest stats.json that is read: that of about 4 million frames. */
#define STATS_BYTES_MAX ((size_t)1 << 30)

/* The three readers below set @p out from JSON. They return false, with @p out untouched, if a
 * value is missing, of another type, or out of range.
 *
 * Read the 16 hexadecimal digits at @p key of an object. */
static bool read_hash(const json_t *object, const char *key, uint64_t *out)
{
    const char *text = json_string_value(json_object_get(object, key));
    char *end;

    if (!text || strlen(text) != 16)
        return false;
    *out = strtoull(text, &end, 16);
    return !*end;
}

/* Read an element of `runs`. @return false if it is none, also for names that are too long. */
static bool read_run(json_t *json, sc_run_entry *out)
{
    const char *begin, *host;
    sc_run_entry run = {.ranks = 0};

    if (json_unpack(json, "{s:s, s:s, s:i, s:i, s:i, s:F, s:F, s:i}", "begin", &begin, "host",
                    &host, "ranks", &run.ranks, "threads", &run.threads, "nodes", &run.nodes,
                    "wall_s", &run.wall_s, "cpu_s", &run.cpu_s, "frames", &run.frames))
        return false;
    if (strlen(begin) >= sizeof run.begin || strlen(host) >= sizeof run.host)
        return false; /* segcast has not written this */
    strcpy(run.begin, begin);
    strcpy(run.host, host);
    *out = run;
    return true;
}

/* Read an element of `frames`, whose run is one of @p run_count. */
static bool read_frame(json_t *json, int run_count, sc_past_frame *out)
{
    sc_past_frame past = {.run = 0};
    sc_frame_result *f = &past.result;
    json_int_t rays, samples, contributions;

    if (json_unpack(json, "{s:i, s:i, s:i, s:F, s:F, s:F, s:I, s:I, s:I}", "frame", &f->frame,
                    "run", &past.run, "rank", &f->rank, "render_wall_s", &f->render_wall_s,
                    "render_cpu_s", &f->render_cpu_s, "wait_s", &f->wait_s, "rays", &rays,
                    "samples", &samples, "contributions", &contributions) ||
        !read_hash(json, "hash", &f->hash) || f->frame < 0 || past.run < 0 || past.run >= run_count)
        return false;
    f->rays = (uint64_t)rays;
    f->samples = (uint64_t)samples;
    f->contributions = (uint64_t)contributions;
    *out = past;
    return true;
}

/* Append all runs and frames to @p h, whose arrays the caller has made large enough. @return false
 * if one is damaged; those before it stay appended. */
static bool read_arrays(const json_t *runs, const json_t *frames, sc_history *h)
{
    for (size_t i = 0; i < json_array_size(runs); i++) {
        if (!read_run(json_array_get(runs, i), &h->runs[h->run_count]))
            return false;
        h->run_count++;
    }
    for (size_t i = 0; i < json_array_size(frames); i++) {
        if (!read_frame(json_array_get(frames, i), h->run_count, &h->frames[h->frame_count]))
            return false;
        h->frame_count++;
    }
    return true;
}

/* Allocate both arrays of @p out, for so many runs and frames; the counts are left as they are.
 * After an error, too, sc_history_clear frees them. */
static sc_status allocate(const sc_ctx *ctx, size_t runs, size_t frames, sc_history *out)
{
    void *block;
    sc_status status;

    SC_TRY(sc_alloc(ctx, runs, sizeof *out->runs, &block));
    out->runs = block;
    SC_TRY(sc_alloc(ctx, frames, sizeof *out->frames, &block));
    out->frames = block;
out:
    return status;
}

/* Fill the empty history @p out with the runs and frames in @p text, the content of a stats.json.
 * If it cannot be used, the return code is SC_OK, *problem is set to words that follow the name of
 * the file (static), and @p out may hold a part of it. The caller clears @p out, also after an
 * error. @return SC_ERR_MEMORY. */
static sc_status parse(const sc_ctx *ctx, const char *text, const sc_job_hashes *job,
                       sc_history *out, const char **problem)
{
    json_t *root = json_loads(text, 0, NULL);
    const json_t *runs = json_object_get(root, "runs"), *frames = json_object_get(root, "frames");
    sc_job_hashes found;
    sc_status status = SC_OK;

    if (!root) {
        *problem = "is damaged";
    } else if (!read_hash(root, "job_hash", &found.job) ||
               !read_hash(root, "volume_hash", &found.volume) || !json_is_array(runs) ||
               !json_is_array(frames)) {
        *problem = "does not say which runs and which job it is of";
    } else if (found.job != job->job || found.volume != job->volume) {
        *problem = "is of another job";
    } else {
        status = allocate(ctx, json_array_size(runs), json_array_size(frames), out);
        if (status == SC_OK && !read_arrays(runs, frames, out))
            *problem = "is damaged";
    }
    json_decref(root);
    return status;
}

/* @return whether both are entries of the same run. */
static bool same_run(const sc_run_entry *a, const sc_run_entry *b)
{
    return !strcmp(a->begin, b->begin) && !strcmp(a->host, b->host) && a->ranks == b->ranks &&
           a->frames == b->frames && a->wall_s == b->wall_s;
}

/* For qsort of sc_past_frame: by number of the frame, and of the same frame the latest run first.
 */
static int by_frame_and_age(const void *a, const void *b)
{
    const sc_past_frame *x = a, *y = b;

    return x->result.frame != y->result.frame ? (x->result.frame < y->result.frame ? -1 : 1)
                                              : y->run - x->run;
}

/* Add a copy of what @p more holds to @p to: runs that are not there yet, at the end, and of each
 * frame the record of its latest run. The runs of the added frames get their index in @p to.
 * @return SC_ERR_MEMORY, @p to untouched. */
static sc_status merge(const sc_ctx *ctx, sc_history *to, const sc_history *more)
{
    sc_history all = {0};
    int kept = 0;
    sc_status status;

    SC_TRY(allocate(ctx, (size_t)to->run_count + (size_t)more->run_count,
                    (size_t)to->frame_count + (size_t)more->frame_count, &all));
    for (int i = 0; i < to->run_count; i++)
        all.runs[all.run_count++] = to->runs[i];
    for (int i = 0; i < to->frame_count; i++)
        all.frames[all.frame_count++] = to->frames[i];
    for (int i = 0; i < more->frame_count; i++)
        all.frames[all.frame_count++] = more->frames[i];
    for (int i = 0; i < more->run_count; i++) {
        int at = 0;

        while (at < all.run_count && !same_run(&all.runs[at], &more->runs[i]))
            at++;
        if (at == all.run_count)
            all.runs[all.run_count++] = more->runs[i];
        for (int k = 0; k < more->frame_count; k++) {
            if (more->frames[k].run == i)
                all.frames[to->frame_count + k].run = at;
        }
    }
    qsort(all.frames, (size_t)all.frame_count, sizeof *all.frames, by_frame_and_age);
    for (int i = 0; i < all.frame_count; i++) {
        if (kept == 0 || all.frames[kept - 1].result.frame != all.frames[i].result.frame)
            all.frames[kept++] = all.frames[i];
    }
    all.frame_count = kept;
    sc_history_clear(to);
    *to = all;
    return SC_OK;
out:
    sc_history_clear(&all);
    return status;
}

sc_status sc_history_read(const sc_ctx *ctx, const char *path, const sc_job_hashes *job,
                          sc_history *history)
{
    const sc_ctx silent = {.alloc_budget = ctx->alloc_budget};
    const char *problem = NULL;
    char *text = NULL;
    size_t bytes;
    sc_history found = {0};
    sc_status status = sc_file_read(&silent, path, STATS_BYTES_MAX, &text, &bytes);

    if (status == SC_ERR_MISSING)
        return SC_OK;
    if (status == SC_ERR_DATA) {
        problem = "is too large";
        status = SC_OK;
    } else if (status == SC_OK) {
        status = parse(ctx, text, job, &found, &problem);
    }
    if (status == SC_OK && problem)
        sc_warn(ctx, "%s: %s; what it says of earlier runs is left out", path, problem);
    else if (status == SC_OK)
        status = merge(ctx, history, &found);
    sc_history_clear(&found);
    sc_free(text);
    return status;
}

void sc_history_clear(sc_history *history)
{
    sc_free(history->runs);
    sc_free(history->frames);
    *history = (sc_history){0};
}
