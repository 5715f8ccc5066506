/* SPDX-License-Identifier: BSD-3-Clause */
/* Ends a run: completes the job if every frame is there. */
#include "internal.h"

#include <string.h>
#include <unistd.h>

/* Join the segments that are there without a gap from the first frame on to the partial video, for
 * people to look at. Does nothing if the first segment is missing, or in a job without video. */
static sc_status write_partial_video(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_text partial = {0};
    int gops = 0;
    sc_status status = SC_OK;

    while (gops < store->gop_count && store->has_segment[gops])
        gops++;
    if (!store->has_video || gops == 0)
        return SC_OK;
    sc_store_path(store, path, "%s", store->job.video);
    SC_TRY(sc_video_partial_name(ctx, path, &partial));
    status = sc_store_join(ctx, store, partial.data, gops);
out:
    sc_text_clear(&partial);
    return status;
}

/* Set @p out to the end line of a job with the video @p path: its size and hash. */
static sc_status hash_video(const sc_ctx *ctx, const char *path, sc_manifest_end *out)
{
    const void *data;
    size_t bytes;
    sc_status status = sc_file_map(ctx, path, &data, &bytes);

    if (status != SC_OK)
        return status;
    *out = (sc_manifest_end){true, bytes, sc_hash_bytes(data, bytes, 0), {0}};
    sc_file_unmap(data, bytes);
    return SC_OK;
}

/* Write manifest.jsonl with the lines of all frames, which must be known, and @p end, and flush it
 * to disk. It becomes store->manifest; the manifest that was open before is closed. */
static sc_status write_whole_manifest(const sc_ctx *ctx, sc_store *store,
                                      const sc_manifest_end *end)
{
    char path[2 * SC_NAME_BYTES];
    void *keep = NULL;
    sc_status status;

    SC_TRY(sc_alloc(ctx, (size_t)store->job.frames, sizeof(bool), &keep));
    memset(keep, true, (size_t)store->job.frames);
    sc_manifest_close(store->manifest);
    store->manifest = NULL;
    sc_store_path(store, path, "manifest.jsonl");
    SC_TRY(sc_manifest_create(ctx, path, &store->job, store->data.lines, keep, &store->manifest));
    SC_TRY(sc_manifest_add_end(ctx, store->manifest, &store->job, end));
    SC_TRY(sc_manifest_sync(ctx, store->manifest));
out:
    sc_free(keep);
    return status;
}

/* Complete a job of which every line, PNG file and segment is there: make the video and the whole
 * manifest, then remove what is not needed any more, and set store->complete. In this order, so
 * that an accident in between costs nothing. */
static sc_status complete_job(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_manifest_end end = {.known = true};
    sc_status status = SC_OK;

    if (store->has_video) {
        sc_store_path(store, path, "%s", store->job.video);
        SC_TRY(sc_store_join(ctx, store, path, store->gop_count));
        SC_TRY(hash_video(ctx, path, &end));
    }
    SC_TRY(write_whole_manifest(ctx, store, &end));
    if (store->slice)
        SC_TRY(sc_store_remove_slices(ctx, store));
    sc_store_remove_segments(ctx, store);
    sc_store_remove_partial_video(ctx, store);
    sc_store_path(store, path, "frames");
    sc_remove_temporaries(path, true);
    sc_remove_temporaries(store->directory, false);
    store->complete = true;
out:
    return status;
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
 * store->data.count. Other files, and a manifest that is gone, add nothing. */
static sc_status count_lines(const sc_ctx *ctx, void *user, const char *name)
{
    sc_store *store = user;
    sc_manifest_data data = {0};
    char path[2 * SC_NAME_BYTES];
    sc_status status = SC_OK;

    if (!sc_is_manifest_name(name))
        return SC_OK;
    sc_store_path(store, path, "%s", name);
    if (access(path, R_OK) == 0)
        status = sc_manifest_read(ctx, path, &data);
    store->data.count += data.count;
    return status;
}

/* Complete the job if every frame is there, and set @p missing to the number that is not. A slice
 * counts the lines of all manifests first, which is quick, and scans the directory only if this
 * process may be the last. */
static sc_status try_to_complete(const sc_ctx *ctx, sc_store *store, int *missing)
{
    sc_status status = SC_OK;

    if (store->slice) {
        store->data.count = 0;
        SC_TRY(sc_each_file(ctx, store->directory, store, count_lines));
        if (store->data.count >= store->job.frames)
            SC_TRY(sc_store_scan(ctx, store));
    }
    *missing = store->complete ? 0 : count_missing(store);
    if (*missing > 0 || store->complete)
        goto out;
    if (store->has_video)
        SC_TRY(sc_store_encode_partial(ctx, store));
    SC_TRY(complete_job(ctx, store));
out:
    return status;
}

sc_status sc_store_finish(const sc_ctx *ctx, sc_store *store, int *missing)
{
    const double begin_s = sc_wall_s();
    const sc_ctx silent = {.rank = 0};
    sc_status status;

    *missing = 0;
    if (store->complete)
        return SC_OK;
    SC_TRY(sc_partial_sync(ctx, &store->partial));
    SC_TRY(sc_manifest_sync(ctx, store->manifest));
    /* If two slices end at the same time, one may remove files that the other is reading. Therefore
     * the first attempt of a slice may fail without a message; the second one finds what the other
     * has completed. */
    status = store->slice ? try_to_complete(&silent, store, missing) : SC_ERR_INTERNAL;
    if (status != SC_OK)
        SC_TRY(try_to_complete(ctx, store, missing));
    if (*missing > 0 && !store->slice)
        SC_TRY(write_partial_video(ctx, store));
out:
    store->times.encode_wall_s += sc_wall_s() - begin_s;
    return status;
}
