/* SPDX-License-Identifier: BSD-3-Clause */
/* Removes what segcast wrote from the directory of a job; all other files stay. */
#include "internal.h"

#include <string.h>
#include <unistd.h>

/* The functions for sc_each_file get the store as user and the name of a file in the directory, in
 * segments/ or in frames/. They remove it if segcast writes files of such names, and never fail.
 *
 * Remove a segment or a partial GOP: at least six digits and ".seg", or these, host, process and
 * ".part". */
static sc_status remove_segment(const sc_ctx *ctx, void *user, const char *name)
{
    const sc_store *store = user;
    const size_t digits = strspn(name, "0123456789");
    const char *extension = strrchr(name, '.');
    char path[2 * SC_NAME_BYTES];

    (void)ctx;
    sc_store_path(store, path, "segments/%s", name);
    if (digits >= 6 && name[digits] == '.' &&
        (!strcmp(name + digits, ".seg") || !strcmp(extension, ".part")))
        unlink(path);
    return SC_OK;
}

/* Remove a manifest, of the whole job or of a slice. */
static sc_status remove_manifest(const sc_ctx *ctx, void *user, const char *name)
{
    const sc_store *store = user;
    char path[2 * SC_NAME_BYTES];

    (void)ctx;
    sc_store_path(store, path, "%s", name);
    if (sc_is_manifest_name(name))
        unlink(path);
    return SC_OK;
}

/* Remove a manifest of a slice. */
static sc_status remove_slice(const sc_ctx *ctx, void *user, const char *name)
{
    return strcmp(name, "manifest.jsonl") != 0 ? remove_manifest(ctx, user, name) : SC_OK;
}

/* Remove a file whose name is that of a frame: at least six digits and ".png". For sc_each_file. */
static sc_status remove_frame(const sc_ctx *ctx, void *user, const char *name)
{
    const sc_store *store = user;
    const size_t digits = strspn(name, "0123456789");
    char path[2 * SC_NAME_BYTES];

    (void)ctx;
    sc_store_path(store, path, "frames/%s", name);
    if (digits >= 6 && !strcmp(name + digits, ".png"))
        unlink(path);
    return SC_OK;
}

void sc_store_remove_segments(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];

    sc_store_path(store, path, "segments");
    sc_remove_temporaries(path, true);
    if (sc_each_file(ctx, path, store, remove_segment) == SC_OK)
        rmdir(path); /* fails, which is intended, if anything else is in it */
}

void sc_store_remove_partial_video(const sc_ctx *ctx, const sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_text partial = {0};

    sc_store_path(store, path, "%s", store->job.video);
    if (store->has_video && sc_video_partial_name(ctx, path, &partial) == SC_OK)
        unlink(partial.data);
    sc_text_clear(&partial);
}

sc_status sc_store_remove_slices(const sc_ctx *ctx, sc_store *store)
{
    return sc_each_file(ctx, store->directory, store, remove_slice);
}

sc_status sc_store_remove_run(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_status status = sc_each_file(ctx, store->directory, store, remove_manifest);

    sc_store_remove_segments(ctx, store);
    sc_store_remove_partial_video(ctx, store);
    sc_store_path(store, path, "%s", store->job.video);
    if (store->has_video)
        unlink(path);
    sc_store_path(store, path, "frames");
    return status == SC_OK ? sc_each_file(ctx, path, store, remove_frame) : status;
}
