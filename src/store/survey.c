/* SPDX-License-Identifier: BSD-3-Clause */
/* What is on the disk, as far as it proves itself. */
#include "internal.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

sc_status sc_each_file(const sc_ctx *ctx, const char *directory, void *user, sc_each_file_fn *each)
{
    struct dirent **names;
    const int count = scandir(directory, &names, NULL, alphasort);
    sc_status status = SC_OK;

    if (count < 0 && errno != ENOENT && errno != ENOTDIR)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", directory, strerror(errno));
    for (int i = 0; i < count; i++) {
        if (status == SC_OK && names[i]->d_name[0] != '.')
            status = each(ctx, user, names[i]->d_name);
        free(names[i]);
    }
    if (count >= 0)
        free(names);
    return status;
}

bool sc_is_manifest_name(const char *name)
{
    const size_t length = strlen(name);

    return !strcmp(name, "manifest.jsonl") ||
           (length > 15 && !strncmp(name, "manifest.", 9) && !strcmp(name + length - 6, ".jsonl"));
}

bool sc_file_is(const char *path, uint64_t bytes, uint64_t hash)
{
    const sc_ctx silent = {.rank = 0};
    const void *data;
    size_t size;
    bool same;

    if (sc_file_map(&silent, path, &data, &size) != SC_OK)
        return false;
    same = size == bytes && sc_hash_bytes(data, size, 0) == hash;
    sc_file_unmap(data, size);
    return same;
}

/* ---- manifests ---- */

/* Why a directory is not for this job, in words; NULL if it is. */
static const char *mismatch(const sc_head *head, const sc_store_job *job)
{
    if (head->volume_hash != job->volume_hash)
        return "another volume, or other labels shown of it";
    if (head->frames != job->frames)
        return "an animation of another length";
    if (head->size_px[0] != job->settings.width_px || head->size_px[1] != job->settings.height_px)
        return "pictures of another size";
    if (head->job_hash != job->job_hash)
        return "another job: other pictures or another encoding";
    if (strcmp(head->version, job->version) != 0)
        return "pictures of another version of segcast";
    return NULL;
}

static sc_status read_manifest(const sc_ctx *ctx, void *user, const char *name)
{
    sc_store *store = user;
    char path[2 * SC_NAME_BYTES];
    const char *why;
    sc_status status;

    if (!sc_is_manifest_name(name))
        return SC_OK;
    sc_store_path(store, path, "%s", name);
    status = sc_journal_read(ctx, path, &store->journal);
    if (status != SC_OK || !store->journal.head.known)
        return status;
    why = mismatch(&store->journal.head, &store->job);
    if (why)
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: holds %s; choose another directory with -o, or --overwrite", path, why);
    return SC_OK;
}

/* ---- segments and parts ---- */

static bool same_hashes(const sc_store *store, const sc_segment_info *info)
{
    for (int i = 0; i < info->frame_count; i++) {
        const sc_line *line = &store->journal.lines[info->first_frame + i];
        uint64_t hash;

        memcpy(&hash, (const char *)info->hashes + (size_t)i * sizeof hash, sizeof hash);
        if (line->known && line->done.hash != hash)
            return false;
    }
    return true;
}

/* A segment may be ahead of the manifest: then it tells what the frames are. */
static void note_hashes(sc_store *store, const sc_segment_info *info)
{
    for (int i = 0; i < info->frame_count; i++) {
        sc_line *line = &store->journal.lines[info->first_frame + i];

        if (line->known)
            continue;
        *line = (sc_line){true, {.frame = info->first_frame + i}};
        memcpy(&line->done.hash, (const char *)info->hashes + (size_t)i * sizeof line->done.hash,
               sizeof line->done.hash);
    }
}

static sc_status scan_segment(const sc_ctx *ctx, sc_store *store, const char *path, int group)
{
    sc_segment segment = {0};
    sc_segment_info info;
    const void *data;
    sc_status status = sc_file_map(ctx, path, &data, &segment.bytes);
    bool ok;

    if (status != SC_OK)
        return SC_OK; /* empty, or gone: not there */
    segment.data = (void *)(uintptr_t)data;
    ok = sc_segment_inspect(&segment, &info) && info.identity == store->identity &&
         info.first_frame == group * store->group &&
         info.frame_count == sc_store_group_frames(store, group) && same_hashes(store, &info);
    if (ok)
        note_hashes(store, &info);
    else
        sc_warn(ctx, "%s: is torn or of another job; its frames are drawn again", path);
    store->segment[group] = ok;
    sc_file_unmap(data, segment.bytes);
    return SC_OK;
}

static sc_status scan_file(const sc_ctx *ctx, void *user, const char *name)
{
    sc_store *store = user;
    const char *dot = strrchr(name, '.');
    char path[2 * SC_NAME_BYTES];
    char *end;
    const long group = strtol(name, &end, 10);

    sc_store_path(store, path, "segments/%s", name);
    if (end != name + 6 || *end != '.' || group < 0 || group >= store->group_count)
        return SC_OK;
    if (!strcmp(dot, ".part"))
        return sc_parts_scan(ctx, &store->parts, path);
    return strcmp(dot, ".seg") == 0 ? scan_segment(ctx, store, path, (int)group) : SC_OK;
}

/* ---- frames ---- */

typedef struct proof {
    const char *directory;
    const sc_line *lines;
    bool *out;
} proof;

static void prove_frames(void *user, size_t begin, size_t end, int thread)
{
    const sc_ctx silent = {.rank = 0};
    const proof *p = user;

    (void)thread;
    for (size_t k = begin; k < end; k++) {
        char path[2 * SC_NAME_BYTES];
        sc_image image;

        snprintf(path, sizeof path, "%s/frames/%06d.png", p->directory, (int)k);
        if (!p->lines[k].known || sc_image_load_png(&silent, path, &image) != SC_OK)
            continue;
        p->out[k] = sc_image_hash(&image) == p->lines[k].done.hash;
        sc_image_clear(&image);
    }
}

void sc_prove_frames(const char *directory, const sc_line *lines, int frames, int threads,
                     bool *out)
{
    proof p = {directory, lines, out};

    memset(out, 0, (size_t)frames * sizeof *out);
    sc_parallel_for(threads, (size_t)frames, 1, prove_frames, &p);
}

/* A part's picture belongs to the pixels that its frame's line tells of; it may be ahead of it. */
static void reconcile_parts(sc_store *store)
{
    for (int k = 0; k < store->job.frames; k++) {
        sc_part_place *place = &store->parts.places[k];
        sc_line *line = &store->journal.lines[k];

        if (place->file < 0)
            continue;
        if (!line->known)
            *line = (sc_line){true, {.frame = k, .hash = place->hash}};
        else if (line->done.hash != place->hash)
            place->file = -1;
    }
}

sc_status sc_store_survey(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_status status;

    memset(store->journal.lines, 0, (size_t)store->job.frames * sizeof *store->journal.lines);
    memset(store->segment, 0, (size_t)store->group_count * sizeof *store->segment);
    store->journal.end = (sc_end){0};
    sc_parts_forget(&store->parts);
    SC_TRY(sc_each_file(ctx, store->directory, store, read_manifest));
    if (store->has_video) {
        sc_store_path(store, path, "segments");
        SC_TRY(sc_each_file(ctx, path, store, scan_file));
        reconcile_parts(store);
    }
    if (store->job.png)
        sc_prove_frames(store->directory, store->journal.lines, store->job.frames,
                        store->job.threads, store->png);
    if (store->journal.end.known && store->has_video) {
        sc_store_path(store, path, "%s", store->job.video);
        store->complete =
            sc_file_is(path, store->journal.end.video_bytes, store->journal.end.video_hash);
        if (!store->complete)
            sc_warn(ctx, "%s: is not the video that was finished here; it is made anew", path);
    } else {
        store->complete = store->journal.end.known;
    }
    for (int k = 0; k < store->job.frames && store->complete; k++)
        store->complete = store->journal.lines[k].known && (!store->job.png || store->png[k]);
out:
    return status;
}
