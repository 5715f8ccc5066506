/* SPDX-License-Identifier: BSD-3-Clause */
/* The directory of a study: its measurements, and the tables that follow from them. */
#include "study/study.h"

#include "segcast/kernel.h"
#include "segcast/store.h"

#include <errno.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* The files of a study's directory. */
static const char measurements_name[] = SC_STUDY_MEASUREMENTS;
static const char *const file_names[] = {measurements_name, "cells.csv",   "extrap.jsonl",
                                         "study.yaml",      "status.json", SC_STUDY_PAGE,
                                         SC_CRATE_NAME};

/* ---- the directory ---- */

/* Write @p text under a name in the directory. */
static sc_status write_text(const sc_study_records *r, const char *name, const sc_text *text)
{
    const sc_ctx *ctx = r->state->app->ctx;
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(ctx, r->directory, name, &path));
    return sc_file_write(ctx, path, text->data, text->length_bytes);
}

/* Refuse @p path if anything has this name. */
static sc_status refuse_path(const sc_ctx *ctx, const char *path)
{
    struct stat info;

    if (lstat(path, &info))
        return SC_OK;
    return sc_fail(
        ctx, SC_ERR_CREATE,
        "%s: is in the way, and was not made by a study; choose another directory with -o", path);
}

/* Refuse a directory in which anything has one of the names that the study will write. */
static sc_status refuse_files(const sc_study_records *r)
{
    const sc_ctx *ctx = r->state->app->ctx;

    SC_PASS(refuse_path(ctx, r->state->work));
    for (size_t i = 0; i < SC_COUNT_OF(file_names); i++) {
        SC_OWN(sc_free_at) char *path = NULL;

        SC_PASS(sc_path_join(ctx, r->directory, file_names[i], &path));
        SC_PASS(refuse_path(ctx, path));
    }
    return SC_OK;
}

/* Remove the files of the study that the directory holds. */
static sc_status remove_files(const sc_study_records *r)
{
    const sc_ctx *ctx = r->state->app->ctx;

    for (size_t i = SC_COUNT_OF(file_names); i-- > 0;) { /* the one that proves it, last */
        SC_OWN(sc_free_at) char *path = NULL;

        SC_PASS(sc_path_join(ctx, r->directory, file_names[i], &path));
        if (unlink(path) && errno != ENOENT)
            return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be removed: %s", path, sc_reason(errno));
    }
    return SC_OK;
}

/* Take over what an earlier run has measured of the same study. */
static sc_status resume(sc_study_records *r, const char *path, uint64_t *whole_bytes)
{
    const sc_ctx *ctx = r->state->app->ctx;
    sc_status status = sc_measurements_read(ctx, path, &r->results, whole_bytes);

    if (status == SC_OK && r->results.design.hash != r->state->design.hash)
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: holds the measurements of another study, or of this one with other "
                       "settings; choose another directory with -o, or --overwrite to begin anew",
                       r->directory);
    return status;
}

/* Describe this run for the file of measurements. */
static sc_study_run describe_run(const sc_study_state *state)
{
    const sc_app *app = state->app;
    const time_t now = time(NULL);
    sc_study_run run = {.ranks = sc_comm_size(app->comm),
                        .nodes = sc_comm_node_count(app->comm),
                        .cores = sc_usable_cores()};
    const char *batch_job = sc_batch_job();
    char host[SC_HOST_BYTES];
    struct tm utc;

    if (gmtime_r(&now, &utc))
        strftime(run.begin, sizeof run.begin, "%Y-%m-%dT%H:%M:%SZ", &utc);
    sc_host_name(host);
    snprintf(run.host, sizeof run.host, "%s", host);
    sc_processor_name(run.processor, sizeof run.processor);
    sc_comm_library(run.mpi, sizeof run.mpi);
    snprintf(run.version, sizeof run.version, "%s", sc_version());
    snprintf(run.commit, sizeof run.commit, "%s", sc_commit());
    snprintf(run.kernel, sizeof run.kernel, "%s",
             state->cpu ? state->cpu
                        : sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_LEAP, NULL, NULL)->cpu);
    run.made_from = state->made_from;
    snprintf(run.batch_job, sizeof run.batch_job, "%s", batch_job ? batch_job : "");
    return run;
}

/* Write study.yaml: the study as read. */
static sc_status write_study(const sc_study_records *r)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_study_write(r->state->app->ctx, &r->state->study, &text));
    return write_text(r, "study.yaml", &text);
}

sc_status sc_study_open(sc_study_records *r)
{
    const sc_app *app = r->state->app;
    const sc_options *o = &app->options;
    const sc_study_run run = describe_run(r->state);
    uint64_t whole_bytes = 0;
    bool has_study = false;
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(app->ctx, r->directory, measurements_name, &path));
    SC_PASS(sc_measurements_begin(app->ctx, path, &has_study));
    if (has_study && !o->resume && !o->overwrite)
        return sc_fail(app->ctx, SC_ERR_CREATE,
                       "%s: already holds a study; use --resume to continue it, --overwrite to "
                       "begin anew, or choose another directory with -o",
                       r->directory);
    if (has_study && o->resume) {
        SC_PASS(resume(r, path, &whole_bytes));
        return sc_measurement_file_resume(app->ctx, path, whole_bytes, &run, &r->file);
    }
    SC_PASS(has_study ? remove_files(r) : refuse_files(r));
    r->made_directory = access(r->directory, F_OK) != 0;
    SC_PASS(sc_make_directory(app->ctx, r->directory));
    SC_PASS(sc_measurement_file_create(app->ctx, path, &r->state->design, &run, &r->file));
    r->is_new = true;
    SC_PASS(write_study(r));
    r->results.design = r->state->design;
    r->state->design = (sc_design){0};
    return SC_OK;
}

sc_status sc_study_write_tables(const sc_study_records *r)
{
    const sc_ctx *ctx = r->state->app->ctx;
    SC_OWN(sc_free_at) sc_cell_result *results = NULL;
    SC_OWN(sc_free_at) char *csv = NULL, *extrap = NULL;

    SC_PASS(sc_path_join(ctx, r->directory, "cells.csv", &csv));
    SC_PASS(sc_path_join(ctx, r->directory, "extrap.jsonl", &extrap));
    SC_PASS(sc_cell_results(ctx, &r->results, &results));
    SC_PASS(sc_cells_write_csv(ctx, &r->results, results, csv));
    return sc_cells_write_extrap(ctx, &r->results, extrap);
}

sc_status sc_study_add(sc_study_records *r, const sc_measurement *m)
{
    const sc_ctx *ctx = r->state->app->ctx;

    SC_PASS(sc_measurements_append(ctx, &r->results, m));
    return sc_measurement_file_add(ctx, r->file, m);
}

sc_status sc_study_skip(sc_study_records *r, int cell, const char *reason)
{
    const sc_ctx *ctx = r->state->app->ctx;
    sc_status status;

    for (size_t i = 0; i < r->results.skipped_count; i++) {
        if (r->results.skipped[i].cell == cell && !strcmp(r->results.skipped[i].reason, reason))
            return SC_OK; /* an earlier run has written it */
    }
    status = sc_measurements_skip(ctx, &r->results, cell, reason);
    return status == SC_OK ? sc_measurement_file_skip(ctx, r->file, cell, reason) : status;
}

sc_status sc_study_write_state(const sc_study_records *r, const sc_progress_report *report)
{
    const sc_ctx *ctx = r->state->app->ctx;
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(ctx, r->directory, "status.json", &path));
    return sc_progress_write(ctx, path, report);
}

sc_status sc_study_crate(const sc_ctx *ctx, const char *directory, sc_text *out)
{
    SC_OWN(sc_measurements_clear) sc_measurements all = {0};
    SC_OWN(sc_history_clear) sc_history runs = {0};
    SC_OWN(sc_text_clear) sc_text parts = {0};
    char about[64];
    sc_crate crate = {.runs = &runs,
                      .name = "Timing study",
                      .about = about,
                      .done = "measurements made",
                      .author = "",
                      .video = "none"};

    SC_PASS(sc_study_read(ctx, directory, &all));
    SC_PASS(sc_measurements_history(ctx, &all, &runs));
    for (size_t i = 0; i < SC_COUNT_OF(file_names); i++) {
        SC_OWN(sc_free_at) char *path = NULL;

        SC_PASS(sc_path_join(ctx, directory, file_names[i], &path));
        if (access(path, F_OK) == 0)
            SC_PASS(sc_text_add(ctx, &parts, "%s%c", file_names[i], '\0'));
    }
    crate.parts = parts;
    snprintf(about, sizeof about, "%d cells, measured", sc_design_cells(&all.design));
    if (all.design.title[0])
        crate.name = all.design.title;
    crate.job.job = all.design.hash;
    crate.version = all.run_count ? all.runs[all.run_count - 1].version : "";
    return sc_crate_make(ctx, &crate, out);
}

sc_status sc_study_write_crate(const sc_study_records *r)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_study_crate(r->state->app->ctx, r->directory, &text));
    return write_text(r, SC_CRATE_NAME, &text);
}

void sc_study_close(sc_study_records *r)
{
    /* A study that was refused, for its budget or its pixels, before anything was measured. */
    if (r->is_new && r->results.count == 0 && r->discard && remove_files(r) == SC_OK &&
        r->made_directory)
        (void)rmdir(r->directory); /* which stays if it holds anything else */
    sc_measurement_file_close(r->file);
    sc_measurements_clear(&r->results);
}
