/* SPDX-License-Identifier: BSD-3-Clause */
/* Keeps what somebody has put in the place of a finished output: before segcast makes that output
 * again, the file gets another name. */
#include "internal.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/* The most files of one name that are kept. */
enum { KEPT_MAX = 1000 };

/* Make an empty file of the first name of PATH.changed, PATH.changed-2 and so on that is free.
 * @return SC_ERR_CREATE. Caller owns @p out. */
static sc_status reserve_name(const sc_ctx *ctx, const char *path, sc_text *out)
{
    int fd = -1;

    for (int i = 1; i <= KEPT_MAX && fd < 0; i++) {
        sc_text_clear(out);
        SC_PASS(sc_text_add(ctx, out, "%s.changed", path));
        if (i > 1)
            SC_PASS(sc_text_add(ctx, out, "-%d", i));
        fd = open(out->data, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
        if (fd < 0 && errno != EEXIST)
            break;
    }
    if (fd < 0)
        return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", out->data,
                       sc_reason(errno));
    else
        close(fd);
    return SC_OK;
}

sc_status sc_store_rename_aside(const sc_ctx *ctx, const char *path, sc_text *kept)
{
    sc_status status = reserve_name(ctx, path, kept);
    int error;

    if (status != SC_OK || !rename(path, kept->data))
        return status;
    error = errno;
    unlink(kept->data);
    if (error != ENOENT)
        status = sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be renamed to %s: %s", path, kept->data,
                         sc_reason(error));
    sc_text_clear(kept);
    return status;
}

void sc_store_warn_of_aside(const sc_ctx *ctx, const char *path, const char *kept)
{
    sc_warn(ctx, "%s: was changed after segcast had made it; that file is now %s", path, kept);
}

sc_status sc_store_set_aside(const sc_ctx *ctx, const char *path, uint64_t bytes, uint64_t hash)
{
    struct stat info;
    SC_OWN(sc_text_clear) sc_text kept = {0};
    bool same = true;

    if (lstat(path, &info) || !S_ISREG(info.st_mode))
        return SC_OK;
    SC_PASS(sc_verify_file(ctx, path, bytes, hash, &same));
    if (same)
        return SC_OK;
    SC_PASS(sc_store_rename_aside(ctx, path, &kept));
    if (kept.data)
        sc_store_warn_of_aside(ctx, path, kept.data);
    return SC_OK;
}

/* @return whether the file is a picture: one that was cut off or damaged is nobody's work. */
static bool is_picture(const char *path)
{
    const sc_ctx silent = {.rank = 0};
    SC_OWN(sc_image_clear) sc_image image = {0};
    const sc_status status = sc_image_load_png(&silent, path, &image);

    return status == SC_OK;
}

/* Set aside the PNG files of a job that was complete which are not those of its manifest. */
static sc_status set_frames_aside(const sc_ctx *ctx, const sc_store *store)
{
    for (int k = 0; store->job.png && k < store->job.frames; k++) {
        const sc_frame_line *line = &store->data.lines[k];
        char path[SC_FILE_BYTES];

        if (store->outputs.has_png[k] || !line->known || !line->done.png_bytes)
            continue;
        sc_store_path(store->directory, path, "frames/%06d.png", k);
        if (is_picture(path))
            SC_PASS(sc_store_set_aside(ctx, path, line->done.png_bytes, line->done.png_hash));
    }
    return SC_OK;
}

sc_status sc_store_set_all_aside(const sc_ctx *ctx, const sc_store *store)
{
    const sc_manifest_end *end = &store->data.end;
    char path[SC_FILE_BYTES];

    if (store->sealed)
        return SC_OK;
    for (int i = 0; i < store->data.files.count; i++) {
        const sc_file_line *line = &store->data.files.lines[i];

        sc_store_path(store->directory, path, "%s", line->name);
        SC_PASS(sc_store_set_aside(ctx, path, line->bytes, line->hash));
    }
    if (!end->known || store->complete)
        return SC_OK;
    SC_PASS(set_frames_aside(ctx, store));
    if (end->video[0]) {
        sc_store_path(store->directory, path, "%s", end->video);
        return sc_store_set_aside(ctx, path, end->video_bytes, end->video_hash);
    }
    return SC_OK;
}
