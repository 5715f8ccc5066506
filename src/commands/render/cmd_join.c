/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast join, verify and status: commands that need only the directory of a job, not its volume.
 */
#include "render/run.h"
#include "study/study.h"

#include <sys/stat.h>

sc_status sc_cmd_join(sc_app *app)
{
    const char *directory = app->options.input;
    char version[64];
    SC_OWN(sc_job_clear) sc_job job = {0};
    sc_store_job store_job;
    SC_OWN(sc_store_close_at) sc_store *store = NULL;
    int missing = 0;

    SC_PASS(sc_read_directory(app, app->options.input, &job, &store_job, version));
    SC_PASS(
        sc_store_open(app->ctx, directory, &store_job, NULL, 0, "join", SC_STORE_RESUME, &store));
    SC_PASS(sc_store_finish(app->ctx, store, &missing));
    if (missing == 0 && !sc_store_is_sealed(store))
        SC_PASS(sc_write_crate(app->ctx, directory, &job, &store_job, true));
    SC_PASS(sc_store_seal(app->ctx, store));
    sc_display_end_stage(app);
    if (missing > 0)
        return sc_fail(app->ctx, SC_ERR_INCOMPLETE,
                       "%s: %d of %d frames are not there; run the slices that hold them, or the "
                       "whole job, with --resume",
                       directory, missing, store_job.frames);
    sc_print_path(stdout, directory);
    fputs(sc_run_has_video(&job) ? "/" : "", stdout);
    sc_print_path(stdout, sc_run_has_video(&job) ? job.output.video : "");
    printf("\n");
    return SC_OK;
}

/* Verify the directory of a study: its measurements can be read, and its crate is what follows from
 * them. */
static sc_status verify_study(const sc_app *app, const char *directory)
{
    SC_OWN(sc_text_clear) sc_text text = {0};
    SC_OWN(sc_free_at) char *path = NULL, *there = NULL;
    size_t bytes = 0;

    SC_PASS(sc_study_crate(app->ctx, directory, &text));
    SC_PASS(sc_path_join(app->ctx, directory, SC_CRATE_NAME, &path));
    SC_PASS(sc_file_read(app->ctx, path, SIZE_MAX, &there, &bytes));
    if (bytes != text.length_bytes || memcmp(there, text.data, bytes))
        return sc_fail(app->ctx, SC_ERR_DATA,
                       "%s: is not what segcast %s writes for these measurements; the study with "
                       "--resume writes it again",
                       path, sc_version());
    sc_print_path(stdout, directory);
    printf(": a study, verified: " SC_STUDY_MEASUREMENTS ", " SC_CRATE_NAME "\n");
    return SC_OK;
}

sc_status sc_cmd_verify(sc_app *app)
{
    char version[64];
    SC_OWN(sc_job_clear) sc_job job = {0};
    sc_store_job store_job = {.threads = 1};
    SC_OWN(sc_text_clear) sc_text names = {0};
    bool is_study = false;

    SC_PASS(sc_study_is_in(app->ctx, app->options.input, &is_study));
    if (is_study)
        return verify_study(app, app->options.input);
    SC_PASS(sc_store_identify(app->ctx, app->options.input, &store_job, version));
    SC_PASS(sc_store_verify_records(app->ctx, app->options.input, &names));
    SC_PASS(sc_read_directory(app, app->options.input, &job, &store_job, version));
    SC_PASS(sc_store_verify(app->ctx, app->options.input, &store_job));
    sc_display_end_stage(app);
    sc_print_path(stdout, app->options.input);
    printf(": %d frames, all verified: manifest.jsonl", store_job.frames);
    sc_print(stdout, names.data ? names.data : "");
    if (store_job.png)
        printf(", %d PNG files", store_job.frames);
    if (sc_run_has_video(&job)) {
        printf(", ");
        sc_print(stdout, job.output.video);
    }
    printf("\n");
    return SC_OK;
}

/* Print the report as one line for people. */
static void print_status(const char *directory, const sc_store_report *report)
{
    sc_print_path(stdout, directory);
    if (report->condition == SC_STORE_COMPLETE) {
        printf(": complete, %d frames%s", report->frames, report->video[0] ? ", " : "");
        sc_print(stdout, report->video);
        printf("\n");
    } else if (report->condition == SC_STORE_INCOMPLETE) {
        printf(": incomplete, %d of %d frames are done; run again with --resume for the rest\n",
               report->done, report->frames);
    } else {
        printf(": damaged: ");
        sc_print(stdout, report->reason);
        printf("; %s\n", report->frames == 0
                             ? "no run can continue there: choose another directory with -o"
                             : "`segcast verify` says more, and a run with --resume makes again "
                               "what is damaged");
    }
}

/* Print the report as one line of JSON. @return SC_ERR_MEMORY. */
static sc_status print_status_json(const sc_ctx *ctx, const char *directory,
                                   const sc_store_report *report)
{
    static const char *const conditions[] = {[SC_STORE_COMPLETE] = "complete",
                                             [SC_STORE_INCOMPLETE] = "incomplete",
                                             [SC_STORE_DAMAGED] = "damaged"};
    json_t *json =
        json_pack("{s:s, s:s, s:i, s:i}", "schema", "segcast-directory-1", "condition",
                  conditions[report->condition], "done", report->done, "frames", report->frames);

    /* Names that are not UTF-8 cannot stand in JSON; they are left out. */
    if (json)
        (void)json_object_set_new(json, "directory", json_string(directory));
    if (json && report->video[0])
        (void)json_object_set_new(json, "video", json_string(report->video));
    if (json && report->reason[0])
        (void)json_object_set_new(json, "reason", json_string(report->reason));
    return sc_print_json(ctx, json, JSON_COMPACT, "status");
}

/* Compare the keys of a job on which the pictures depend with those of the job in a directory.
 * @return SC_ERR_CREATE, as for a run that would not continue there, if they differ. */
static sc_status compare_jobs(const sc_ctx *ctx, const sc_job *job, const char *directory)
{
    SC_OWN(sc_free_at) char *path = NULL;
    sc_job_sources sources = {0};
    SC_OWN(sc_job_clear) sc_job there = {0};
    SC_OWN(sc_text_clear) sc_text ours = {0}, theirs = {0};

    SC_PASS(sc_path_join(ctx, directory, "job.yaml", &path));
    sources.path = path;
    SC_PASS(sc_job_load(ctx, &sources, &there));
    SC_PASS(sc_job_write(ctx, job, true, &ours));
    SC_PASS(sc_job_write(ctx, &there, true, &theirs));
    if (strcmp(ours.data, theirs.data))
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: holds another job than the one asked for; compare %s", directory, path);
    return SC_OK;
}

/* Fill the report for the job file that the command line names, as `segcast render` would run it.
 * @param directory receives where it would write: borrowed from the options or from @p job. @param
 * job the caller owns it, also after an error: sc_job_clear. */
static sc_status report_job(const sc_app *app, sc_job *job, const char **directory,
                            sc_store_report *out)
{
    const sc_options *o = &app->options;
    const sc_job_sources sources = {.path = o->input,
                                    .settings = o->settings.all,
                                    .setting_count = o->settings.count,
                                    .environment = app->environment};
    sc_video_settings settings;
    SC_OWN(sc_free_at) int *wanted = NULL;
    int count = 0;

    SC_PASS(sc_job_load(app->ctx, &sources, job));
    *directory = o->output ? o->output : job->output.directory;
    settings = sc_run_video_settings(job);
    if (o->part.slices)
        SC_PASS(sc_frames_slice(app->ctx, o->part.slice, o->part.slices,
                                sc_video_gop_frames(&settings), job->animation.frames, &wanted,
                                &count));
    else if (o->part.frames)
        SC_PASS(sc_frames_parse(app->ctx, o->part.frames, job->animation.frames, &wanted, &count));
    if (o->part.slices &&
        count == 0) { /* more slices than GOPs: there is nothing to do for this one */
        *out = (sc_store_report){.condition = SC_STORE_COMPLETE};
        return SC_OK;
    }
    SC_PASS(sc_store_status(app->ctx, *directory, wanted, count, out));
    if (out->condition != SC_STORE_DAMAGED)
        return compare_jobs(app->ctx, job, *directory);
    return SC_OK;
}

/* Say how far the study in a directory is. @param found whether the directory holds one; if not,
 * nothing is said. @return SC_ERR_INCOMPLETE, or SC_ERR_DATA with the damage logged. */
static sc_status report_study(const sc_app *app, const char *directory, bool *found)
{
    SC_OWN(sc_measurements_clear) sc_measurements all = {0};

    SC_PASS(sc_study_is_in(app->ctx, directory, found));
    if (!*found)
        return SC_OK;
    SC_PASS(sc_study_read(app->ctx, directory, &all));
    if (app->options.json) {
        printf("{\"schema\":\"segcast-directory-1\",\"condition\":\"%s\",\"done\":%zu,\"cells\":%d,"
               "\"skipped\":%zu}\n",
               all.complete ? "complete" : "incomplete", all.count, sc_design_cells(&all.design),
               all.skipped_count);
    } else {
        sc_print(stdout, directory);
        printf(": a study, %s, %zu measurements of %d cells, %zu of which cannot run here%s\n",
               all.complete ? "complete" : "incomplete", all.count, sc_design_cells(&all.design),
               all.skipped_count, all.complete ? "" : "; run again with --resume for the rest");
    }
    return all.complete ? SC_OK : SC_ERR_INCOMPLETE;
}

sc_status sc_cmd_status(sc_app *app)
{
    static const sc_status codes[] = {[SC_STORE_COMPLETE] = SC_OK,
                                      [SC_STORE_INCOMPLETE] = SC_ERR_INCOMPLETE,
                                      [SC_STORE_DAMAGED] = SC_ERR_DATA};
    const char *directory = app->options.input;
    sc_store_report report;
    struct stat info;
    SC_OWN(sc_job_clear) sc_job job = {0};
    bool is_study = false;

    SC_PASS(report_study(app, directory, &is_study));
    if (is_study)
        return SC_OK;
    if (!stat(directory, &info) && !S_ISDIR(info.st_mode))
        SC_PASS(report_job(app, &job, &directory, &report));
    else
        SC_PASS(sc_store_status(app->ctx, directory, NULL, 0, &report));
    if (app->options.json)
        SC_PASS(print_status_json(app->ctx, directory, &report));
    else
        print_status(directory, &report);
    return codes[report.condition];
}
