/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a film comes from: what it is made from, noted with its statistics, and the RO-Crate that
 * is made of those. */
#include "render/run.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* For note_input. */
typedef struct input_list {
    const sc_ctx *ctx;
    json_t *inputs; /* NULL once there was no memory */
} input_list;

/* @return whether to hash a file: a prepared file has a hash of its own, and would have to be read
 * from its begin to its end, which nothing else needs. */
static bool is_to_be_hashed(const char *path, const struct stat *info)
{
    const char *ending = strrchr(path, '.');

    return S_ISREG(info->st_mode) && !(ending && !strcasecmp(ending, ".segc"));
}

/* For sc_each_input with an input_list as user: note what it is, and of a file size and SHA-256. A
 * file that cannot be read any more has none. */
static sc_status note_input(void *user, const char *use, const char *path, bool is_volume)
{
    input_list *list = user;
    sc_ctx silent = sc_quiet(list->ctx);
    json_t *input = json_pack("{s:s}", "use", use);
    char sha256[SC_SHA256_BYTES];
    struct stat info;
    uint64_t bytes;
    sc_status status = SC_ERR_MISSING;
    int failed = 0;

    silent.write = NULL; /* that a file cannot be read is told where it is needed */
    if (!stat(path, &info) && is_to_be_hashed(path, &info))
        status = sc_sha256_file(&silent, path, sha256, &bytes);
    if (status == SC_OK) {
        failed = json_object_set_new(input, "bytes", json_integer((json_int_t)bytes)) ||
                 json_object_set_new(input, "sha256", json_string(sha256));
    }
    if (json_array_append_new(list->inputs, input) || failed || status == SC_ERR_MEMORY)
        return sc_fail(list->ctx, SC_ERR_MEMORY, "out of memory for the list of inputs");
    return SC_OK;
}

sc_status sc_run_note_inputs(sc_run *run)
{
    const sc_app *app = run->app;
    const sc_command *command = sc_command_find(app->commands, app->argv[1]);
    SC_OWN(sc_text_clear) sc_text shown = {0};
    input_list list = {app->ctx, json_array()};
    const sc_input_visit visit = {note_input, &list};
    json_t *all;
    sc_status status;

    sc_stage_begin(app->ctx, "hashing inputs", 0, 0);
    status = sc_each_input(app, &run->session.job, &visit);
    sc_stage_end(app->ctx);
    if (status == SC_OK && command)
        status = sc_command_shown(app->ctx, command, app->argc, app->argv, &shown);
    errno = 0;
    all = json_pack("{s:s, s:o}", "command", shown.data ? shown.data : "segcast", "inputs",
                    list.inputs);
    run->root.made_from = all ? json_dumps(all, JSON_COMPACT) : NULL;
    json_decref(all);
    if (status == SC_OK && (!run->root.made_from || errno == ENOMEM))
        return sc_fail(app->ctx, SC_ERR_MEMORY, "out of memory for the list of inputs");
    return status;
}

/* The names of what is in a directory. */
typedef struct part_list {
    sc_text names; /* each with a NUL byte behind it */
    int count;
} part_list;

/* For sc_store_each_part with a part_list as user. The crate is no part of itself. */
static sc_status note_part(const sc_ctx *ctx, void *user, const char *name)
{
    part_list *list = user;

    if (!strcmp(name, SC_CRATE_NAME))
        return SC_OK;
    list->count++;
    return sc_text_add(ctx, &list->names, "%s%c", name, '\0');
}

sc_status sc_write_crate(const sc_ctx *ctx, const char *directory, const sc_job *job,
                         const sc_store_job *store_job, bool is_complete)
{
    SC_OWN(sc_text_clear) sc_text text = {0};
    SC_OWN(sc_free_at) char *path = NULL, *video = NULL;
    SC_OWN(sc_free_at) const char **names = NULL;
    part_list parts = {.count = 0};
    sc_crate crate = {.directory = directory,
                      .version = store_job->version,
                      .job = {store_job->job_hash, store_job->volume_hash},
                      .title = job->output.title,
                      .author = job->output.author,
                      .video = job->output.video,
                      .frames = store_job->frames};
    struct stat info;
    sc_status status = sc_store_each_part(ctx, directory, &parts, note_part);

    if (status == SC_OK)
        status = SC_ALLOC(ctx, (size_t)parts.count + 1, &names);
    for (const char *name = parts.names.data; status == SC_OK && crate.part_count < parts.count;
         name += strlen(name) + 1)
        names[crate.part_count++] = name;
    crate.parts = names;
    SC_TRY(status);
    SC_TRY(sc_path_join(ctx, directory, job->output.video, &video));
    if (is_complete && !stat(video, &info))
        crate.video_bytes = (uint64_t)info.st_size;
    SC_TRY(sc_crate_make(ctx, &crate, &text));
    SC_TRY(sc_path_join(ctx, directory, SC_CRATE_NAME, &path));
    status = sc_file_write(ctx, path, text.data, text.length_bytes);
out:
    sc_text_clear(&parts.names);
    return status;
}
