/* SPDX-License-Identifier: BSD-3-Clause */
/* job.yaml in the directory of a job: which texts of it are segcast's own. */
#include "internal.h"

#include <unistd.h>

/* What job.yaml holds at a moment. */
typedef struct job_file {
    bool exists; /* as a regular file */
    uint64_t bytes, hash;
} job_file;

/* Read job.yaml, or what was renamed from that. @return SC_ERR_MEMORY, or that another part of the
 * machine failed, logged. */
static sc_status read_job(const sc_ctx *ctx, const char *path, job_file *out)
{
    const sc_ctx quiet = sc_quiet(ctx);
    job_file file = {.exists = false};
    const sc_status status = sc_store_hash_file(&quiet, path, &file.bytes, &file.hash);

    if (status != SC_OK && !sc_is_of_input(status))
        return status;
    file.exists = status == SC_OK;
    *out = file;
    return SC_OK;
}

/* @return whether the texts hold that of a file. */
static bool is_known(const sc_job_texts *jobs, const job_file *file)
{
    return sc_job_texts_have(jobs, file->bytes, file->hash);
}

sc_status sc_job_texts_put_file(const sc_ctx *ctx, const char *directory, sc_job_texts *jobs)
{
    char path[SC_FILE_BYTES];
    job_file file = {.exists = false};

    sc_store_path(directory, path, "job.yaml");
    SC_PASS(read_job(ctx, path, &file));
    return file.exists ? sc_job_texts_put(ctx, jobs, file.bytes, file.hash) : SC_OK;
}

sc_status sc_job_texts_have_file(const sc_ctx *ctx, const char *directory, const sc_job_texts *jobs,
                                 bool *out)
{
    char path[SC_FILE_BYTES];
    job_file file = {.exists = false};

    sc_store_path(directory, path, "job.yaml");
    SC_PASS(read_job(ctx, path, &file));
    *out = file.exists && is_known(jobs, &file);
    return SC_OK;
}

/* Note a text in the manifest, and wait until that is on disk, unless it stands there already. */
static sc_status note(const sc_ctx *ctx, sc_store *store, const job_file *text)
{
    char path[SC_FILE_BYTES];

    if (is_known(&store->data.jobs, text))
        return SC_OK;
    SC_PASS(sc_job_texts_put(ctx, &store->data.jobs, text->bytes, text->hash));
    if (store->manifest.writer) {
        SC_PASS(sc_manifest_add_job(ctx, store->manifest.writer, text->bytes, text->hash));
        return sc_manifest_sync(ctx, store->manifest.writer);
    }
    /* The job is complete, and its records are not: this manifest is that of all its slices. */
    sc_store_path(store->directory, path, "manifest.jsonl");
    return sc_manifest_create(ctx, path, &store->job, &store->data, NULL, false, NULL, NULL);
}

/* For sc_each_file with the store as user: read the texts that a manifest names by now. */
static sc_status read_texts(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    const sc_ctx quiet = sc_quiet(ctx);
    sc_store *store = user;
    sc_manifest_data data = {.jobs = store->data.jobs};
    const sc_status status = sc_manifest_read(&quiet, path, &data);

    store->data.jobs = data.jobs;
    data.jobs = (sc_job_texts){0};
    sc_manifest_data_clear(&data);
    return sc_is_of_input(status) ? SC_OK : status; /* a manifest may be gone meanwhile */
}

/* Set *out to whether the file, which was read before, is segcast's. Another slice may have noted
 * and written it after this one has read the manifests: then they tell now. */
static sc_status is_ours(const sc_ctx *ctx, sc_store *store, const job_file *file, bool *out)
{
    sc_status status = SC_OK;

    if (!is_known(&store->data.jobs, file))
        status = sc_each_file(ctx, store->directory, sc_is_manifest_name, store, read_texts);
    *out = is_known(&store->data.jobs, file);
    return status;
}

/* Rename job.yaml if it is not segcast's. Another slice may do the same at this moment, and have
 * written its own text instead: that needs no second name. */
static sc_status keep_changed(const sc_ctx *ctx, sc_store *store, const char *path)
{
    SC_OWN(sc_text_clear) sc_text kept = {0};
    job_file file = {.exists = false};
    bool ours = true;

    SC_PASS(read_job(ctx, path, &file));
    if (file.exists)
        SC_PASS(is_ours(ctx, store, &file, &ours));
    if (ours)
        return SC_OK;
    SC_PASS(sc_store_rename_aside(ctx, path, &kept));
    if (!kept.data)
        return SC_OK;
    SC_PASS(read_job(ctx, kept.data, &file));
    SC_PASS(is_ours(ctx, store, &file, &ours));
    if (ours)
        unlink(kept.data);
    else
        sc_store_warn_of_aside(ctx, path, kept.data);
    return SC_OK;
}

sc_status sc_store_write_job(const sc_ctx *ctx, sc_store *store, const void *text, size_t bytes)
{
    const job_file ours = {true, bytes, sc_store_hash_bytes(text, bytes)};
    char path[SC_FILE_BYTES];

    sc_store_path(store->directory, path, "job.yaml");
    SC_PASS(note(ctx, store, &ours));
    SC_PASS(keep_changed(ctx, store, path));
    return sc_file_write(ctx, path, text, bytes);
}
