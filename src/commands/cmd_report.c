/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast report: the page of a run or of a study made anew from its directory, or a page that
 * compares several. */
#include "render/run.h"
#include "segcast/report.h"
#include "study/study.h"

#include <dirent.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* @return whether DIR/NAME is there. */
static sc_status is_there(const sc_ctx *ctx, const char *directory, const char *name, bool *out)
{
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(ctx, directory, name, &path));
    *out = access(path, F_OK) == 0;
    return SC_OK;
}

/* Make the page of a run, and put it into its directory. @param slice NULL: of the whole job. */
static sc_status make_page(const sc_ctx *ctx, const char *directory, const sc_job *job,
                           const char *slice)
{
    const sc_report_run run = {.directory = directory,
                               .slice = slice,
                               .title = job->output.title,
                               .video = job->output.video,
                               .png = job->output.frames == SC_FRAMES_PNG,
                               .frames = job->animation.frames,
                               .fps = job->output.fps};
    SC_OWN(sc_text_clear) sc_text name = {0}, text = {0};
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_text_add(ctx, &name, "report%s%s.html", slice ? "." : "", slice ? slice : ""));
    SC_PASS(sc_path_join(ctx, directory, name.data, &path));
    SC_PASS(sc_report_make(ctx, &run, &text));
    SC_PASS(sc_store_replace_record(ctx, directory, name.data, text.data, text.length_bytes));
    sc_print_made(path);
    return SC_OK;
}

/* Is it the name of the statistics of a slice, "stats.SLICE.json"? For scandir. */
static int is_slice(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name);

    return length > strlen("stats..json") && !strncmp(entry->d_name, "stats.", strlen("stats.")) &&
           !strcmp(entry->d_name + length - strlen(".json"), ".json");
}

/* Make the pages of all slices that have statistics. @param count their number. */
static sc_status make_slices(const sc_ctx *ctx, const char *directory, const sc_job *job,
                             int *count)
{
    struct dirent **entries;
    sc_status status = SC_OK;

    *count = scandir(directory, &entries, is_slice, alphasort);
    for (int i = 0; i < *count; i++) {
        char *slice = entries[i]->d_name + strlen("stats.");

        slice[strlen(slice) - strlen(".json")] = '\0';
        if (status == SC_OK)
            status = make_page(ctx, directory, job, slice);
        free(entries[i]);
    }
    if (*count >= 0)
        free(entries);
    return status;
}

/* Make the page of the study in a directory. */
static sc_status report_study(const sc_app *app, const char *directory)
{
    const sc_ctx *ctx = app->ctx;
    SC_OWN(sc_measurements_clear) sc_measurements all = {0};
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_study_read(ctx, directory, &all));
    SC_PASS(sc_path_join(ctx, directory, SC_STUDY_PAGE, &path));
    SC_PASS(sc_study_write_page(ctx, directory, &all));
    sc_print_made(path);
    return SC_OK;
}

/* Make the page of a directory, or of all slices if it was drawn in slices. */
static sc_status report_one(sc_app *app)
{
    const char *directory = app->options.input;
    const sc_ctx *ctx = app->ctx;
    char version[64];
    SC_OWN(sc_job_clear) sc_job job = {0};
    sc_store_job store_job;
    bool whole, is_study = false;
    int slices = 0;

    if (app->options.output)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "-o names the page that compares several directories; that of one is "
                       "report.html in it, because it shows the film beside it");
    SC_PASS(sc_study_is_in(ctx, directory, &is_study));
    if (is_study)
        return report_study(app, directory);
    SC_PASS(sc_read_directory(app, directory, &job, &store_job, version));
    SC_PASS(is_there(ctx, directory, "stats.json", &whole));
    sc_stage_begin(ctx, "reporting", 0, 0);
    if (whole)
        return make_page(ctx, directory, &job, NULL);
    SC_PASS(make_slices(ctx, directory, &job, &slices));
    if (slices <= 0)
        return sc_fail(
            ctx, SC_ERR_INCOMPLETE,
            "%s: has no stats.json: no run has begun to draw there yet; run again with --resume",
            directory);
    return SC_OK;
}

/* Refuse directories of runs that cannot be compared, and compare the others. */
static sc_status compare_runs(const sc_app *app, sc_text *out)
{
    const sc_options *o = &app->options;
    const sc_ctx *ctx = app->ctx;
    char version[64];

    for (int i = 0; i < o->input_count; i++) {
        sc_store_job job = {0};
        bool there = false;

        SC_PASS(sc_store_identify(ctx, o->inputs[i], &job, version));
        SC_PASS(is_there(ctx, o->inputs[i], "stats.json", &there));
        if (!there)
            return sc_fail(ctx, SC_ERR_INCOMPLETE,
                           "%s: has no stats.json to compare: it was drawn in slices, or no run "
                           "has begun to draw there yet",
                           o->inputs[i]);
    }
    sc_stage_begin(ctx, "reporting", 0, 0);
    return sc_report_compare(ctx, o->inputs, o->input_count, out);
}

/* Compare the studies in all directories. */
static sc_status compare_studies(const sc_app *app, sc_text *out)
{
    const sc_options *o = &app->options;
    SC_OWN(sc_free_at) sc_measurements *all = NULL;
    int read = 0;
    sc_status status;

    SC_TRY(SC_ZALLOC(app->ctx, (size_t)o->input_count, &all));
    for (; read < o->input_count; read++)
        SC_TRY(sc_study_read(app->ctx, o->inputs[read], &all[read]));
    sc_stage_begin(app->ctx, "reporting", 0, 0);
    status = sc_report_compare_studies(app->ctx, o->inputs, all, read, out);
out:
    for (int i = 0; i < read; i++)
        sc_measurements_clear(&all[i]);
    return status;
}

/* Find out whether the directories hold studies. @return SC_ERR_USAGE if only some of them do. */
static sc_status are_studies(const sc_app *app, bool *out)
{
    const sc_options *o = &app->options;
    int study = -1, other = -1;

    for (int i = 0; i < o->input_count; i++) {
        bool is_study = false;

        SC_PASS(sc_study_is_in(app->ctx, o->inputs[i], &is_study));
        if (is_study)
            study = i;
        else
            other = i;
    }
    if (study >= 0 && other >= 0)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "%s holds a timing study, and %s does not: a page compares either studies "
                       "or runs; name directories of one kind",
                       o->inputs[study], o->inputs[other]);
    *out = study >= 0;
    return SC_OK;
}

/* Make the page that compares all directories of the command line. */
static sc_status report_several(sc_app *app)
{
    const sc_options *o = &app->options;
    const sc_ctx *ctx = app->ctx;
    const char *output = o->output ? o->output : "comparison.html";
    bool studies = false;
    sc_outfile file = {0};
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_check_ending(ctx, output, ".html", "a page"));
    SC_PASS(sc_outfile_check(ctx, output, o->overwrite, ", or --overwrite to replace it"));
    SC_PASS(are_studies(app, &studies));
    SC_PASS(studies ? compare_studies(app, &text) : compare_runs(app, &text));
    SC_PASS(sc_outfile_open(ctx, output, o->overwrite, &file));
    fwrite(text.data, 1, text.length_bytes, file.stream);
    SC_PASS(sc_outfile_commit(ctx, &file));
    sc_display_end_stage(app);
    sc_print_made(output);
    return SC_OK;
}

/* Print the tables of the studies in all directories. */
static sc_status print_tables(const sc_app *app)
{
    const sc_options *o = &app->options;

    if (o->output)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--markdown prints tables and makes no page; give either it or -o");
    for (int i = 0; i < o->input_count; i++) {
        SC_OWN(sc_measurements_clear) sc_measurements all = {0};
        SC_OWN(sc_text_clear) sc_text text = {0};
        bool is_study = false;

        SC_PASS(sc_study_is_in(app->ctx, o->inputs[i], &is_study));
        if (!is_study)
            return sc_fail(app->ctx, SC_ERR_MISSING,
                           "%s: holds no timing study, of which alone there are tables; give the "
                           "directory of a segcast study, or leave --markdown out",
                           o->inputs[i]);
        SC_PASS(sc_study_read(app->ctx, o->inputs[i], &all));
        SC_PASS(sc_report_study_markdown(app->ctx, &all, &text));
        printf("%s%s", i ? "\n" : "", text.data);
    }
    return SC_OK;
}

sc_status sc_cmd_report(sc_app *app)
{
    if (app->options.help.markdown)
        return print_tables(app);
    return app->options.input_count > 1 ? report_several(app) : report_one(app);
}
