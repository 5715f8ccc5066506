/* SPDX-License-Identifier: BSD-3-Clause */
/* Ends a run: completes the job if every frame is there, and proves its records. */
#include "internal.h"

#include <unistd.h>

/* Join the segments that are there without a gap from the first frame on to the partial video, for
 * people to look at. Does nothing if the first segment is missing, or in a job without video. */
static sc_status write_partial_video(const sc_ctx *ctx, sc_store *store)
{
    char path[SC_FILE_BYTES];
    SC_OWN(sc_text_clear) sc_text partial = {0};
    int gops = 0;

    while (gops < store->gop_count && store->outputs.has_segment[gops])
        gops++;
    if (!store->has_video || gops == 0)
        return SC_OK;
    sc_store_path(store->directory, path, "%s", store->job.video);
    SC_PASS(sc_video_partial_name(ctx, path, &partial));
    return sc_store_join(ctx, store, partial.data, gops);
}

/* Write manifest.jsonl anew from store->data, which has the lines of all frames and the end. The
 * manifest of this process is closed. @param close add the last line, too.
 * @return SC_ERR_INCOMPLETE, without a message, if another run has replaced the manifest. */
static sc_status write_whole_manifest(const sc_ctx *ctx, sc_store *store, bool close)
{
    char path[SC_FILE_BYTES];

    if (!store->role.slice && sc_store_is_replaced(store))
        return SC_ERR_INCOMPLETE;
    sc_manifest_close(store->manifest.writer);
    store->manifest.writer = NULL;
    sc_store_path(store->directory, path, "manifest.jsonl");
    return sc_manifest_create(ctx, path, &store->job, &store->data, NULL, close,
                              store->role.slice ? NULL : &store->manifest.id, NULL);
}

/* Complete a job of which every line, PNG file and segment is there: make the video and the whole
 * manifest, then remove what is not needed any more, and set store->complete. In this order, so
 * that an accident in between costs nothing. */
static sc_status complete_job(const sc_ctx *ctx, sc_store *store)
{
    sc_manifest_end end = {.known = true};
    char path[SC_FILE_BYTES];

    if (store->has_video) {
        sc_store_path(store->directory, path, "%s", store->job.video);
        SC_PASS(sc_store_join(ctx, store, path, store->gop_count));
        SC_PASS(sc_store_hash_file(ctx, path, &end.video_bytes, &end.video_hash));
        snprintf(end.video, sizeof end.video, "%s", store->job.video);
    }
    store->data.end = end;
    SC_PASS(write_whole_manifest(ctx, store, false));
    if (store->role.slice)
        SC_PASS(sc_store_remove_slices(ctx, store));
    sc_store_remove_unfinished(ctx, store);
    store->complete = true;
    return SC_OK;
}

/* @return the number of frames of the whole job that are not there (sc_store_has). */
static int count_missing(const sc_store *store)
{
    int missing = 0;

    for (int k = 0; k < store->job.frames; k++)
        missing += !sc_store_has(store, k);
    return missing;
}

/* For sc_each_file with the store as user: add the number of frame lines in a manifest to
 * store->data.count. One that is gone adds nothing. */
static sc_status count_lines(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    sc_store *store = user;
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {0};
    sc_status status = SC_OK;

    if (access(path, R_OK) == 0)
        status = sc_manifest_read(ctx, path, &data);
    store->data.count += data.count;
    return status;
}

/* Complete the job if every frame is there, and set @p missing to the number that is not. A slice
 * counts the lines of all manifests first, which is quick, and scans the directory only if this
 * process may be the last; another slice that has not ended yet will complete the job instead. */
static sc_status try_to_complete(const sc_ctx *ctx, sc_store *store, int *missing)
{
    if (store->role.slice) {
        store->data.count = 0;
        SC_PASS(sc_each_file(ctx, store->directory, sc_is_manifest_name, store, count_lines));
        if (store->data.count >= store->job.frames)
            SC_PASS(sc_store_scan(ctx, store));
    }
    *missing = store->complete ? 0 : count_missing(store);
    if (*missing > 0 || store->complete || (store->open_slices && !store->role.takes_over))
        return SC_OK;
    if (store->has_video)
        SC_PASS(sc_store_encode_partial(ctx, store));
    return complete_job(ctx, store);
}

sc_status sc_store_finish(const sc_ctx *ctx, sc_store *store, int *missing)
{
    const double begin_s = sc_wall_s();
    const sc_ctx silent = {.stage = ctx->stage};
    sc_status status;

    *missing = 0;
    if (store->complete)
        return SC_OK;
    if (!store->role.slice && sc_store_is_replaced(store))
        return SC_ERR_INCOMPLETE;
    SC_TRY(sc_partial_sync(ctx, &store->partial));
    SC_TRY(sc_manifest_sync(ctx, store->manifest.writer));
    /* If two slices end at the same time, one may remove files that the other is reading. Therefore
     * the first attempt of a slice may fail without a message; the second one finds what the other
     * has completed. */
    status = store->role.slice ? try_to_complete(&silent, store, missing) : SC_ERR_INTERNAL;
    if (status != SC_OK)
        SC_TRY(try_to_complete(ctx, store, missing));
    if (*missing > 0 && !store->role.slice)
        SC_TRY(write_partial_video(ctx, store));
out:
    store->times.encode_wall_s += sc_wall_s() - begin_s;
    return status;
}

/* ---- records ---- */

/* For prove_record. */
typedef struct record_list {
    const sc_store *store;
    sc_file_lines *files;
} record_list;

/* Add size and hash of a record, if it is there. */
static sc_status prove_file(const sc_ctx *ctx, const record_list *list, const char *name)
{
    char path[SC_FILE_BYTES];
    uint64_t bytes, hash;

    sc_store_path(list->store->directory, path, "%s", name);
    if (access(path, F_OK) != 0)
        return SC_OK;
    SC_PASS(sc_store_hash_file(ctx, path, &bytes, &hash));
    return sc_file_lines_put(ctx, list->files, name, bytes, hash);
}

/* For sc_each_record with a record_list as user: prove a record of this process. Of job.yaml there
 * are lines already, and what slices have in common is proven when the job is complete. */
static sc_status prove_record(const sc_ctx *ctx, void *user, const char *name)
{
    return !strcmp(name, "job.yaml") || !strcmp(name, SC_CRATE_NAME) ? SC_OK
                                                                     : prove_file(ctx, user, name);
}

sc_status sc_store_end_slice(const sc_ctx *ctx, sc_store *store)
{
    SC_OWN(sc_file_lines_clear) sc_file_lines files = {0};
    record_list list = {store, &files};

    if (store->manifest.writer && store->role.slice) {
        SC_PASS(sc_each_record(ctx, store->role.slice, &list, prove_record));
        sc_file_lines_sort(&files);
        SC_PASS(sc_manifest_add_close(ctx, store->manifest.writer, &files));
        SC_PASS(sc_manifest_sync(ctx, store->manifest.writer));
    }
    return SC_OK;
}

/* Warn of a record that cannot be proven. */
static void warn_of_record(const sc_ctx *ctx, const sc_store *store, const char *name)
{
    sc_warn(ctx,
            "%s/%s: is missing, or not what segcast has written; it is left out of what `segcast "
            "verify` proves",
            store->directory, name);
}

/* Remove the lines of files that are not what slices have written: they cannot be proven. The last
 * line takes the place of one that is removed, therefore backwards. @return as sc_verify_file. */
static sc_status drop_changed_records(const sc_ctx *ctx, sc_store *store)
{
    for (int i = store->data.files.count - 1; i >= 0; i--) {
        const sc_file_line *line = &store->data.files.lines[i];
        char path[SC_FILE_BYTES];
        bool same;

        sc_store_path(store->directory, path, "%s", line->name);
        SC_PASS(sc_verify_file(ctx, path, line->bytes, line->hash, &same));
        if (same)
            continue;
        warn_of_record(ctx, store, line->name);
        sc_file_lines_remove(&store->data.owned, line->name);
        sc_file_lines_remove(&store->data.files, line->name);
    }
    return SC_OK;
}

/* Leave of all texts of job.yaml the one that is there, or none: that which was given as the job is
 * its user's, whoever has written it, and so is another one that has come meanwhile. */
static sc_status prove_job(const sc_ctx *ctx, sc_store *store)
{
    sc_job_texts all = store->data.jobs;
    bool is_known = false;

    if (!store->job.keeps_job)
        SC_PASS(sc_job_texts_have_file(ctx, store->directory, &all, &is_known));
    store->data.jobs = (sc_job_texts){0};
    sc_file_lines_clear(&all);
    if (is_known)
        return sc_job_texts_put_file(ctx, store->directory, &store->data.jobs);
    else if (!store->job.keeps_job)
        warn_of_record(ctx, store, "job.yaml");
    return SC_OK;
}

/* Add the lines of this run's records. Those of other slices are there if they have ended in order.
 */
static sc_status prove_records(const sc_ctx *ctx, sc_store *store)
{
    record_list list = {store, &store->data.files};

    SC_PASS(drop_changed_records(ctx, store));
    SC_PASS(prove_job(ctx, store));
    SC_PASS(prove_file(ctx, &list, SC_CRATE_NAME));
    return store->role.joins ? SC_OK : sc_each_record(ctx, store->role.slice, &list, prove_record);
}

sc_status sc_store_seal(const sc_ctx *ctx, sc_store *store)
{
    SC_OWN(sc_text_clear) sc_text partial = {0};

    if (!store->complete || store->sealed)
        return SC_OK;
    SC_PASS(prove_records(ctx, store));
    /* What only an unfinished job has is removed; files of these names that appear later are the
     * user's. */
    sc_file_lines_remove(&store->data.owned, SC_OWN_SEGMENTS);
    sc_file_lines_remove(&store->data.owned, "segments/");
    if (store->has_video) {
        SC_PASS(sc_video_partial_name(ctx, store->job.video, &partial));
        sc_file_lines_remove(&store->data.owned, partial.data);
    }
    SC_PASS(write_whole_manifest(ctx, store, true));
    store->sealed = true;
    return SC_OK;
}
