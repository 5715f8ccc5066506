/* SPDX-License-Identifier: BSD-3-Clause */
/* What a film or a study is made from, as it is noted with what was measured: the command, and all
 * files that are read, with their SHA-256. */
#include "commands.h"

#include <stdlib.h>

/* For qsort of texts. */
static int by_bytes(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* @return the name of a file as it stands in the list of its input: from the directory on that is
 * the input or, as of a header, holds it. */
static const char *name_in(const char *input, const char *path)
{
    const size_t length = strlen(input);

    if (!strncmp(input, path, length) && strchr(path + length, '/'))
        return path + length + strspn(path + length, "/");
    return sc_file_name(path);
}

/* The SHA-256 of an input: that of its file, or, of several, of the list that `sha256sum` prints of
 * them in the order of their paths. @param files as of sc_volume_files, not empty. @param count how
 * many these are, each once. @return as sc_sha256_file. */
static sc_status hash_files(const sc_ctx *ctx, const char *input, const sc_text *files,
                            char sha256[SC_SHA256_BYTES], uint64_t *bytes, size_t *count)
{
    SC_OWN(sc_free_at) const char **paths = NULL;
    SC_OWN(sc_text_clear) sc_text list = {0};
    size_t listed = 0;

    *bytes = *count = 0;
    SC_PASS(SC_ALLOC(ctx, files->length_bytes, &paths));
    for (size_t at = 0; at < files->length_bytes; at += strlen(paths[listed - 1]) + 1)
        paths[listed++] = files->data + at;
    qsort(paths, listed, sizeof *paths, by_bytes);
    for (size_t i = 0; i < listed; i++) {
        uint64_t file_bytes;

        if (i && !strcmp(paths[i], paths[i - 1]))
            continue;
        SC_PASS(sc_sha256_file(ctx, paths[i], sha256, &file_bytes));
        SC_PASS(sc_text_add(ctx, &list, "%s  ./%s\n", sha256, name_in(input, paths[i])));
        *bytes += file_bytes;
        ++*count;
    }
    return *count > 1 ? sc_sha256_text(ctx, &list, sha256) : SC_OK;
}

/* Add an input to the list: what it is used for, and the size and SHA-256 of its files, as far as
 * they could be read. */
static sc_status add_input(sc_made_from *m, const char *use, const char *path, const sc_text *files)
{
    const bool is_phantom = sc_job_is_phantom(path);
    json_t *input = json_pack("{s:s++}", "use", use, is_phantom ? ", made by segcast: " : "",
                              is_phantom ? path : "");
    sc_ctx silent = sc_quiet(m->app->ctx);
    char sha256[SC_SHA256_BYTES];
    uint64_t bytes;
    size_t count;
    sc_status status = SC_ERR_MISSING;
    int failed = 0;

    silent.write = NULL; /* that a file cannot be read is told where it is needed */
    if (files->length_bytes)
        status = hash_files(&silent, path, files, sha256, &bytes, &count);
    if (status == SC_OK) {
        failed =
            json_object_set_new(input, "bytes", json_integer((json_int_t)bytes)) ||
            json_object_set_new(input, "sha256", json_string(sha256)) ||
            (count > 1 && json_object_set_new(input, "files", json_integer((json_int_t)count)));
    }
    if (json_object_set_new_nocheck(m->inputs, path, input) || failed || status == SC_ERR_MEMORY)
        return sc_fail(m->app->ctx, SC_ERR_MEMORY, "out of memory for the list of inputs");
    return SC_OK;
}

/* For sc_each_input with an sc_made_from as user. */
static sc_status note_input(void *user, const char *use, const char *path, bool is_volume)
{
    sc_made_from *m = user;
    const sc_ctx *ctx = m->app->ctx;
    SC_OWN(sc_text_clear) sc_text files = {0};

    if (json_object_get(m->inputs, path))
        return SC_OK;
    if (is_volume)
        SC_PASS(sc_volume_files(ctx, path, m->store_most_bytes, &files));
    else
        SC_PASS(sc_text_add(ctx, &files, "%s%c", path, '\0'));
    return add_input(m, use, path, &files);
}

sc_status sc_made_from_add(sc_made_from *m, const sc_job *job)
{
    const sc_input_visit visit = {note_input, m};

    if (!m->inputs)
        m->inputs = json_object();
    return sc_each_input(m->app, job, &visit);
}

sc_status sc_made_from_text(const sc_made_from *m, sc_text *out)
{
    const sc_app *app = m->app;
    const sc_command *command = sc_command_find(app->commands, app->argv[1]);
    SC_OWN(sc_text_clear) sc_text shown = {0};
    json_t *inputs = json_array(), *input;
    const char *path;

    json_object_foreach(m->inputs, path, input) inputs = sc_json_with(inputs, json_incref(input));
    if (command)
        SC_PASS(sc_command_shown(app->ctx, command, app->argc, app->argv, &shown));
    return sc_json_add_text(
        app->ctx,
        json_pack("{s:s, s:o}", "command", shown.data ? shown.data : "segcast", "inputs", inputs),
        JSON_COMPACT, "the list of inputs", out);
}

void sc_made_from_clear(sc_made_from *m)
{
    json_decref(m->inputs);
}
