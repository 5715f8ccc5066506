/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads everything in the directory of a job, and keeps what can be verified. */
#include "internal.h"

#include <stdlib.h>
#include <unistd.h>

/* ---- manifests ---- */

enum { REASON_BYTES = 160 };

/* Compare a manifest with the job. @return false if it is of another one; @p reason then holds what
 * differs, as words that follow "was written", and is untouched otherwise. */
static bool belongs_to(const sc_manifest_head *head, const sc_store_job *job,
                       char reason[REASON_BYTES])
{
    const sc_video_settings *s = &job->settings;

    if (head->volume_hash != job->volume_hash)
        snprintf(reason, REASON_BYTES, "from another volume, or with other labels hidden");
    else if (head->frames != job->frames)
        snprintf(reason, REASON_BYTES, "for an animation of %d frames instead of %d", head->frames,
                 job->frames);
    else if (head->size_px[0] != s->width_px || head->size_px[1] != s->height_px)
        snprintf(reason, REASON_BYTES, "with frames of %d x %d pixels instead of %d x %d",
                 head->size_px[0], head->size_px[1], s->width_px, s->height_px);
    else if (head->job_hash != job->job_hash)
        snprintf(reason, REASON_BYTES, "by another job: its pictures or its encoding differ");
    else if (strcmp(head->version, job->version) != 0)
        snprintf(reason, REASON_BYTES, "by another version of segcast: %s instead of %s",
                 head->version, job->version);
    else
        return true;
    return false;
}

/* For sc_each_file with the store as user: read a manifest into store->data; without a head it is
 * ignored. @return SC_ERR_CREATE, with a message, if it belongs to another job. */
static sc_status scan_manifest(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    sc_store *store = user;
    char own[SC_FILE_BYTES], reason[REASON_BYTES];
    const sc_status status = sc_manifest_read(ctx, path, &store->data);

    if (status != SC_OK || !store->data.head.known || sc_head_has_no_hashes(&store->data.head))
        return status;
    if (belongs_to(&store->data.head, &store->job, reason)) {
        if (store->data.damaged_line)
            sc_warn(ctx, "%s: line %d is damaged; what it and the lines behind it say is ignored",
                    path, store->data.damaged_line);
        sc_store_manifest_path(store, own);
        if (!strcmp(name, "manifest.jsonl"))
            store->sealed = store->data.closed;
        else if (strcmp(path, own) != 0)
            store->open_slices += !store->data.closed;
        return SC_OK;
    }
    return sc_fail(ctx, SC_ERR_CREATE,
                   "%s: was written %s; choose another directory with -o, or use --overwrite", path,
                   reason);
}

/* ---- segments and partial GOPs ---- */

/* @return the hash of frame number @p i, from 0, of the segment. */
static uint64_t segment_frame_hash(const sc_segment_info *info, int i)
{
    uint64_t hash;

    memcpy(&hash, (const char *)info->hashes + (size_t)i * sizeof hash, sizeof hash);
    return hash;
}

/* @return whether the frames of the segment have the hashes that the manifest names; a frame
 * without a line may have any. */
static bool has_known_hashes(const sc_store *store, const sc_segment_info *info)
{
    for (int i = 0; i < info->frame_count; i++) {
        const sc_frame_line *line = &store->data.lines[info->first_frame + i];

        if (line->known && line->done.hash != segment_frame_hash(info, i))
            return false;
    }
    return true;
}

/* A segment may have reached the disk before the lines of its frames did: add those that are not
 * known to store->data.lines (not to the file), with rank and CPU time 0. */
static void add_lines(sc_store *store, const sc_segment_info *info)
{
    for (int i = 0; i < info->frame_count; i++) {
        const int k = info->first_frame + i;
        sc_frame_line *line = &store->data.lines[k];

        if (!line->known)
            *line = (sc_frame_line){true, {.frame = k, .hash = segment_frame_hash(info, i)}};
    }
}

/* Set has_segment[gop] to whether the file @p path is a sound segment of this GOP of this job.
 * Warns if it is not, except if it was removed meanwhile. Frames that have no line get one. */
static void scan_segment(const sc_ctx *ctx, sc_store *store, const char *path, int gop)
{
    const sc_ctx silent = {.rank = 0};
    sc_segment segment = {0};
    sc_segment_info info;
    SC_OWN(sc_free_at) char *data = NULL;
    const bool is_read =
        sc_file_read(&silent, path, SC_SEGMENT_MAX_BYTES, &data, &segment.bytes) == SC_OK;
    bool ok = false;

    if (!is_read && access(path, F_OK) != 0)
        return; /* removed meanwhile by a process that completed the job */
    if (is_read) {
        segment.data = data;
        ok = sc_segment_inspect(&segment, &info) && sc_store_is_segment_of(store, &info, gop) &&
             has_known_hashes(store, &info);
    }
    if (ok)
        add_lines(store, &info);
    else
        sc_warn(ctx, "%s: is damaged or belongs to another job; its frames are drawn again", path);
    store->outputs.has_segment[gop] = ok;
}

/* For sc_each_file with the store as user and a file of segments/: scan NNNNNN.seg or
 * NNNNNN.HOST.PID.part. Numbers beyond the last GOP are ignored. */
static sc_status scan_file(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    sc_store *store = user;
    const char *extension = strrchr(name, '.');
    const long gop = strtol(name, NULL, 10);

    if (gop < 0 || gop >= store->gop_count)
        return SC_OK;
    if (!strcmp(extension, ".part"))
        return sc_partial_scan(ctx, &store->partial, path, (int)gop * store->gop_frames,
                               sc_store_gop_frames(store, (int)gop));
    if (!strcmp(extension, ".seg"))
        scan_segment(ctx, store, path, (int)gop);
    sc_stage_add(ctx, 1);
    return SC_OK;
}

/* Remove the locations of pictures in partial GOPs whose hash is not that of their frame's line. A
 * picture may have reached the disk before the line did; then add that to store->data.lines. */
static void compare_partial_gops(sc_store *store)
{
    for (int k = 0; k < store->job.frames; k++) {
        sc_picture_location *location = &store->partial.locations[k];
        sc_frame_line *line = &store->data.lines[k];

        if (location->file < 0)
            continue;
        if (!line->known)
            *line = (sc_frame_line){true, {.frame = k, .hash = location->hash}};
        else if (line->done.hash != location->hash)
            location->file = -1;
    }
}

/* Set *out to whether the job is finished: the manifest has an end line and a line for each frame,
 * and the outputs are what it says. Warns if the video is not. Needs has_png. @return as
 * sc_verify_file. */
static sc_status is_complete(const sc_ctx *ctx, const sc_store *store, bool *out)
{
    char path[SC_FILE_BYTES];
    const sc_manifest_end *end = &store->data.end;
    bool complete = end->known;

    if (complete && store->has_video) {
        sc_store_path(store->directory, path, "%s", store->job.video);
        SC_PASS(sc_verify_file(ctx, path, end->video_bytes, end->video_hash, &complete));
        if (!complete)
            sc_warn(ctx,
                    "%s: is missing, or is not the video that the manifest names; it is made "
                    "again",
                    path);
    }
    for (int k = 0; complete && k < store->job.frames; k++)
        complete = store->data.lines[k].known && (!store->job.png || store->outputs.has_png[k]);
    *out = complete;
    return SC_OK;
}

/* Warn of a record that is not what it was. */
static void warn_of_record(const sc_ctx *ctx, const sc_store *store, const char *name)
{
    sc_warn(ctx,
            "%s/%s: is missing, or is not the file that the manifest names; the records are "
            "written again",
            store->directory, name);
}

/* Set *out to whether the records are those that the manifest names; warns of the first that is
 * not. @return as sc_verify_file. */
static sc_status has_sound_records(const sc_ctx *ctx, const sc_store *store, bool *out)
{
    char path[SC_FILE_BYTES];
    bool sound = true;

    for (int i = 0; i < store->data.files.count && sound; i++) {
        const sc_file_line *line = &store->data.files.lines[i];

        sc_store_path(store->directory, path, "%s", line->name);
        SC_PASS(sc_verify_file(ctx, path, line->bytes, line->hash, &sound));
        if (!sound)
            warn_of_record(ctx, store, line->name);
    }
    if (sound && store->data.jobs.count > 0) {
        SC_PASS(sc_job_texts_have_file(ctx, store->directory, &store->data.jobs, &sound));
        if (!sound)
            warn_of_record(ctx, store, "job.yaml");
    }
    *out = sound;
    return SC_OK;
}

sc_status sc_store_scan(const sc_ctx *ctx, sc_store *store)
{
    const int frames = store->job.frames;
    char path[SC_FILE_BYTES];

    memset(store->data.lines, 0, (size_t)frames * sizeof *store->data.lines);
    memset(store->outputs.has_segment, 0,
           (size_t)store->gop_count * sizeof *store->outputs.has_segment);
    store->data.end = (sc_manifest_end){0};
    store->sealed = false;
    store->open_slices = 0;
    sc_partial_forget(&store->partial);
    sc_stage_begin(ctx, "verifying what is there", 0,
                   (uint64_t)(store->job.png ? frames : 0) + (uint64_t)store->gop_count);
    SC_PASS(sc_each_file(ctx, store->directory, sc_is_manifest_name, store, scan_manifest));
    if (store->has_video) {
        sc_store_path(store->directory, path, "segments");
        SC_PASS(sc_each_file(ctx, path, sc_is_segment_name, store, scan_file));
        compare_partial_gops(store);
    }
    if (store->job.png)
        SC_PASS(sc_verify_png_files(ctx, store->directory, store->data.lines, frames,
                                    store->job.threads, store->outputs.has_png));
    SC_PASS(is_complete(ctx, store, &store->complete));
    if (store->sealed && store->complete)
        SC_PASS(has_sound_records(ctx, store, &store->sealed));
    store->sealed = store->sealed && store->complete;
    return SC_OK;
}
