/* SPDX-License-Identifier: BSD-3-Clause */
/* What a directory holds after a run: lists it, and replaces a record of it. */
#include "internal.h"

#include <sys/stat.h>

/* For search. */
typedef struct owner_search {
    const char *name;
    bool found; /* a manifest names it */
} owner_search;

/* For sc_each_file with an owner_search as user: does a manifest name the record? */
static sc_status look_for_owner(const sc_ctx *ctx, void *user, const char *path, const char *file)
{
    const sc_ctx quiet = sc_quiet(ctx);
    owner_search *search = user;
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = 0};
    const sc_status status = sc_manifest_read_head(&quiet, path, &data);

    search->found =
        search->found || (status == SC_OK && sc_file_lines_has(&data.owned, search->name));
    return sc_is_of_input(status) ? SC_OK : status;
}

/* Read manifest.jsonl into @p data, whose lines it allocates: *lines, which the caller frees. If
 * there is none, or if it is not closed, nothing has to be changed in it: data->closed is false. */
static sc_status read_manifest(const sc_ctx *ctx, const char *path, sc_manifest_data *data,
                               void **lines)
{
    struct stat info;

    if (lstat(path, &info))
        return SC_OK;
    SC_PASS(sc_manifest_read_head(ctx, path, data));
    if (!data->head.known)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, data->head.problem);
    data->frames = data->head.frames;
    SC_PASS(sc_zalloc(ctx, (size_t)data->frames, sizeof *data->lines, lines));
    data->lines = *lines;
    SC_PASS(sc_manifest_read(ctx, path, data));
    if (data->damaged_line)
        return sc_fail(ctx, SC_ERR_DATA, "%s: line %d is damaged: it is not what segcast wrote",
                       path, data->damaged_line);
    return SC_OK;
}

/* Refuse a record that something stands in the way of which is not segcast's. */
static sc_status check_owner(const sc_ctx *ctx, const char *directory, const char *name,
                             bool has_new_owner)
{
    owner_search search = {.name = name};
    char path[SC_FILE_BYTES];
    struct stat info;

    SC_PASS(sc_each_file(ctx, directory, sc_is_manifest_name, &search, look_for_owner));
    sc_store_path(directory, path, "%s", name);
    if (lstat(path, &info)) {
        if (!search.found && !has_new_owner)
            return sc_fail(ctx, SC_ERR_CREATE,
                           "%s: no manifest in the directory names it, so it would be in the way "
                           "of a run that goes on there; run again with --resume first",
                           path);
    } else if (!search.found || !S_ISREG(info.st_mode)) {
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: was not made by segcast, and is in the way; move it away", path);
    }
    return SC_OK;
}

sc_status sc_store_replace_record(const sc_ctx *ctx, const char *directory, const char *name,
                                  const void *text, size_t bytes)
{
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = 0};
    char manifest[SC_FILE_BYTES], path[SC_FILE_BYTES];
    sc_store_job job = {0};
    SC_OWN(sc_free_at) void *lines = NULL;

    sc_store_path(directory, manifest, "manifest.jsonl");
    sc_store_path(directory, path, "%s", name);
    SC_PASS(read_manifest(ctx, manifest, &data, &lines));
    SC_PASS(check_owner(ctx, directory, name, data.closed));
    for (int i = 0; i < data.files.count; i++) {
        if (!strcmp(data.files.lines[i].name, name))
            SC_PASS(
                sc_store_set_aside(ctx, path, data.files.lines[i].bytes, data.files.lines[i].hash));
    }
    SC_PASS(sc_file_write(ctx, path, text, bytes));
    if (!data.closed) /* the run that completes the job proves what is there then */
        return SC_OK;
    job = (sc_store_job){
        .version = data.head.version,
        .job_hash = data.head.job_hash,
        .volume_hash = data.head.volume_hash,
        .frames = data.head.frames,
        .video = data.end.video[0] ? data.end.video : "none",
        .settings = {.width_px = data.head.size_px[0], .height_px = data.head.size_px[1]}};
    SC_PASS(sc_names_add(ctx, &data.owned, name));
    SC_PASS(sc_file_lines_put(ctx, &data.files, name, bytes, sc_store_hash_bytes(text, bytes)));
    return sc_manifest_create(ctx, manifest, &job, &data, NULL, true, NULL, NULL);
}

/* For sc_each_file with an sc_manifest_data as user: add the names in the head of a manifest, and
 * its own, unless it is that of a slice, which goes when the job is complete, to data->owned. */
static sc_status collect_owned(const sc_ctx *ctx, void *user, const char *path, const char *file)
{
    const sc_ctx quiet = sc_quiet(ctx);
    sc_manifest_data *data = user;
    const sc_status status = sc_manifest_read_head(&quiet, path, data);

    if (status == SC_OK && data->head.known && !strcmp(file, "manifest.jsonl"))
        return sc_names_add(ctx, &data->owned, file);
    return sc_is_of_input(status) ? SC_OK : status;
}

sc_status sc_store_parts(const sc_ctx *ctx, const char *directory, sc_text *out)
{
    sc_manifest_data data = {.frames = 0};
    sc_names *owned = &data.owned;
    sc_status status = sc_each_file(ctx, directory, sc_is_manifest_name, &data, collect_owned);

    sc_file_lines_sort(owned);
    for (int i = 0; i < owned->count && status == SC_OK; i++) {
        const char *name = owned->lines[i].name;
        const bool is_png = !strcmp(name, SC_OWN_PNG);
        char path[SC_FILE_BYTES];
        struct stat info;

        if (is_png)
            name = "frames/";
        sc_store_path(directory, path, "%s", name);
        if (!lstat(path, &info) && (is_png ? S_ISDIR(info.st_mode) : S_ISREG(info.st_mode)))
            status = sc_text_add(ctx, out, "%s%c", name, '\0');
    }
    sc_manifest_data_clear(&data);
    return status;
}
