/* SPDX-License-Identifier: BSD-3-Clause */
/* Removes what segcast made in the directory of a job; all other files stay. */
#include "internal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/* Remove the regular file @p name from the open folder, but nothing else of that name. */
static void remove_file(int folder, const char *name)
{
    struct stat info;

    if (!fstatat(folder, name, &info, AT_SYMLINK_NOFOLLOW) && S_ISREG(info.st_mode))
        unlinkat(folder, name, 0);
}

/* @return the folder, open, or -1: not there, or a link. Caller closes it. */
static int open_folder(const char *path)
{
    return open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

/* Remove from a folder of the directory the files with names of segments, or else those of the
 * frames below @p frames; with @p all the temporary files there, too; and with @p folder_too the
 * folder itself, if nothing else is in it. Warns if the folder is there and cannot be listed. */
static void empty_folder(const sc_ctx *ctx, const char *path, bool segments, int frames,
                         bool folder_too)
{
    const int fd = open_folder(path), listed = fd < 0 ? -1 : dup(fd);
    DIR *stream = listed < 0 ? NULL : fdopendir(listed);
    const struct dirent *entry;

    if (!stream && errno != ENOENT && errno != ENOTDIR && errno != ELOOP)
        sc_warn(ctx, "%s: files of segcast that are not needed any more stay there: %s", path,
                sc_reason(errno));
    while (stream && (entry = readdir(stream))) {
        if (segments ? sc_is_segment_name(entry->d_name) : sc_is_frame_name(entry->d_name, frames))
            remove_file(fd, entry->d_name);
    }
    if (stream)
        closedir(stream);
    if (fd < 0)
        return;
    close(fd);
    sc_remove_temporaries(path, true);
    if (folder_too)
        rmdir(path); /* fails, which is intended, if anything else is in it */
}

/* Remove what @p owned names of segments/. */
static void remove_segments(const sc_ctx *ctx, const char *directory, const sc_names *owned)
{
    char path[SC_FILE_BYTES];

    sc_store_path(directory, path, "segments");
    if (sc_file_lines_has(owned, SC_OWN_SEGMENTS))
        empty_folder(ctx, path, true, 0, sc_file_lines_has(owned, "segments/"));
}

void sc_store_remove_unfinished(const sc_ctx *ctx, const sc_store *store)
{
    const sc_ctx silent = {.alloc_budget =
                               ctx->alloc_budget}; /* the job is complete all the same */
    const int fd = open(store->directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    char path[SC_FILE_BYTES];
    SC_OWN(sc_text_clear) sc_text partial = {0};

    remove_segments(ctx, store->directory, &store->data.owned);
    if (store->has_video && sc_video_partial_name(&silent, store->job.video, &partial) == SC_OK &&
        sc_file_lines_has(&store->data.owned, partial.data))
        remove_file(fd, partial.data);
    sc_store_path(store->directory, path, "frames");
    if (sc_file_lines_has(&store->data.owned, SC_OWN_PNG))
        empty_folder(ctx, path, false, 0, false);
    sc_remove_temporaries(store->directory, false);
    if (fd >= 0)
        close(fd);
}

/* For sc_each_file with the store as user. Remove a manifest, of the whole job or of a slice; a
 * file of such a name that is no manifest stays. */
static sc_status remove_manifest(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    const sc_ctx quiet = sc_quiet(ctx);
    const sc_store *store = user;
    const int fd = open(store->directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    sc_manifest_data data = {.frames = 0};
    const sc_status status = sc_manifest_read_head(&quiet, path, &data);

    if (status == SC_OK && data.head.known)
        remove_file(fd, name);
    sc_manifest_data_clear(&data);
    if (fd >= 0)
        close(fd);
    return sc_is_of_input(status) ? SC_OK : status;
}

/* Remove a manifest of a slice. */
static sc_status remove_slice(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    return strcmp(name, "manifest.jsonl") != 0 ? remove_manifest(ctx, user, path, name) : SC_OK;
}

sc_status sc_store_remove_slices(const sc_ctx *ctx, sc_store *store)
{
    return sc_each_file(ctx, store->directory, sc_is_manifest_name, store, remove_slice);
}

/* What sc_store_remove_run collects of all manifests. */
typedef struct all_owned {
    sc_manifest_data data; /* only owned and head are used */
    int frames;            /* the most that one of them has */
} all_owned;

/* For sc_each_file with an all_owned as user: add what a manifest names. */
static sc_status collect(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    const sc_ctx quiet = sc_quiet(ctx);
    all_owned *all = user;
    const sc_status status = sc_manifest_read_head(&quiet, path, &all->data);

    if (status == SC_OK && all->data.head.known && all->data.head.frames > all->frames)
        all->frames = all->data.head.frames;
    return sc_is_of_input(status) ? SC_OK : status;
}

sc_status sc_store_remove_run(const sc_ctx *ctx, sc_store *store)
{
    /* what no manifest names, but sc_store_check_place has found to be of the job */
    static const char *const late[] = {SC_OWN_SEGMENTS, "segments/"};
    all_owned all = {.frames = 0};
    const sc_names *owned = &all.data.owned;
    const int fd = open(store->directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    char path[SC_FILE_BYTES];
    sc_status status;

    SC_TRY(sc_each_file(ctx, store->directory, sc_is_manifest_name, &all, collect));
    for (size_t i = 0; i < SC_COUNT_OF(late); i++) {
        if (sc_file_lines_has(&store->data.owned, late[i]))
            SC_TRY(sc_names_add(ctx, &all.data.owned, late[i]));
    }
    SC_TRY(sc_job_texts_put_file(ctx, store->directory, &all.data.jobs));
    /* First of all a manifest of the new run, without a frame, that names all that is here: after
     * an accident the directory is that of an unfinished job. */
    sc_store_path(store->directory, path, "manifest.jsonl");
    SC_TRY(sc_manifest_create(ctx, path, &store->job, &all.data, NULL, false, NULL, NULL));
    SC_TRY(sc_store_remove_slices(ctx, store));
    for (int i = 0; i < owned->count; i++) {
        if (!strchr(owned->lines[i].name, '/') && strcmp(owned->lines[i].name, "job.yaml") != 0)
            remove_file(fd, owned->lines[i].name);
    }
    remove_segments(ctx, store->directory, owned);
    sc_store_path(store->directory, path, "frames");
    if (sc_file_lines_has(owned, SC_OWN_PNG))
        empty_folder(ctx, path, false, all.frames, sc_file_lines_has(owned, "frames/"));
out:
    sc_manifest_data_clear(&all.data);
    if (fd >= 0)
        close(fd);
    return status;
}
