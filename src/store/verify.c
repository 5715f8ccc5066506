/* SPDX-License-Identifier: BSD-3-Clause */
/* Verifies a finished directory from its files alone, without the volume. */
#include "internal.h"

#include <math.h>
#include <string.h>

/* For read_head. */
typedef struct head_search {
    const char *directory;
    sc_manifest_head head; /* the result; known is false until one is found */
} head_search;

/* For sc_each_file with a head_search as user: put the head of the first manifest that has one into
 * it. Once it is found, all further files are ignored. */
static sc_status read_head(const sc_ctx *ctx, void *user, const char *name)
{
    head_search *search = user;
    sc_manifest_data data = {0};
    char path[2 * SC_NAME_BYTES];
    sc_status status;

    if (search->head.known || !sc_is_manifest_name(name))
        return SC_OK;
    snprintf(path, sizeof path, "%s/%s", search->directory, name);
    status = sc_manifest_read(ctx, path, &data);
    if (status == SC_OK)
        search->head = data.head;
    return status;
}

sc_status sc_store_identify(const sc_ctx *ctx, const char *directory, sc_store_job *job,
                            char *version)
{
    head_search search = {.directory = directory};
    sc_status status = sc_each_file(ctx, directory, &search, read_head);

    if (status != SC_OK)
        return status;
    if (!search.head.known)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: holds no run: it has no manifest.jsonl",
                       directory);
    snprintf(version, 64, "%s", search.head.version);
    job->version = version;
    job->job_hash = search.head.job_hash;
    job->volume_hash = search.head.volume_hash;
    job->frames = search.head.frames;
    job->settings.width_px = search.head.size_px[0];
    job->settings.height_px = search.head.size_px[1];
    return SC_OK;
}

/* For check_video_frame; pointers are borrowed. */
typedef struct video_check {
    const sc_ctx *ctx;
    const char *path; /* for messages */
    const sc_store_job *job;
    int frames; /* decoded so far */
} video_check;

/* For sc_video_decode with a video_check as user: compare time (within 1 ms) and size of a frame
 * with the job, and count it. Its pixels are not compared. @return SC_ERR_DATA, with a message. */
static sc_status check_video_frame(void *user, int k, double time_s, const sc_image *image)
{
    video_check *check = user;
    const int width_px = (check->job->settings.width_px + 1) & ~1;
    const int height_px = (check->job->settings.height_px + 1) & ~1;
    const double expected_s = (double)k / check->job->settings.fps;

    check->frames = k + 1;
    if (fabs(time_s - expected_s) > 1e-3)
        return sc_fail(check->ctx, SC_ERR_DATA, "%s: frame %d is shown at %.4f s, expected %.4f",
                       check->path, k, time_s, expected_s);
    if (image->width_px != width_px || image->height_px != height_px)
        return sc_fail(check->ctx, SC_ERR_DATA, "%s: frame %d has %d x %d pixels, expected %d x %d",
                       check->path, k, image->width_px, image->height_px, width_px, height_px);
    return SC_OK;
}

/* Compare size and hash of the video with @p end, then decode it, and compare its frames and their
 * number with @p job. @return SC_ERR_DATA naming the first thing that is wrong. */
static sc_status verify_video(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                              const sc_manifest_end *end)
{
    char path[2 * SC_NAME_BYTES];
    video_check check = {.ctx = ctx, .path = path, .job = job};
    sc_status status;

    snprintf(path, sizeof path, "%s/%s", directory, job->video);
    if (!sc_verify_file(path, end->video_bytes, end->video_hash))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is missing, or is not the file of %llu bytes and hash %016llx that the "
                       "manifest names",
                       path, (unsigned long long)end->video_bytes,
                       (unsigned long long)end->video_hash);
    status = sc_video_decode(ctx, path, check_video_frame, &check);
    if (status == SC_OK && check.frames != job->frames)
        return sc_fail(ctx, SC_ERR_DATA, "%s: holds %d frames, expected %d", path, check.frames,
                       job->frames);
    return status;
}

/* Decode all PNG files, and compare their pixels with the hashes in @p lines ([job->frames], all
 * known). @return SC_ERR_DATA naming the first one that is wrong, SC_ERR_MEMORY. */
static sc_status verify_png_files(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                                  const sc_frame_line *lines)
{
    void *verified;
    sc_status status = sc_alloc(ctx, (size_t)job->frames, sizeof(bool), &verified);

    if (status != SC_OK)
        return status;
    sc_verify_png_files(directory, lines, job->frames, job->threads, verified);
    for (int k = 0; k < job->frames && status == SC_OK; k++) {
        if (!((bool *)verified)[k])
            status = sc_fail(ctx, SC_ERR_DATA,
                             "%s/frames/%06d.png: is missing, damaged, or not the picture of hash "
                             "%016llx that the manifest names",
                             directory, k, (unsigned long long)lines[k].done.hash);
    }
    sc_free(verified);
    return status;
}

sc_status sc_store_verify(const sc_ctx *ctx, const char *directory, const sc_store_job *job)
{
    char path[2 * SC_NAME_BYTES];
    sc_manifest_data data = {.frames = job->frames};
    void *lines = NULL;
    sc_status status;

    snprintf(path, sizeof path, "%s/manifest.jsonl", directory);
    SC_TRY(sc_zalloc(ctx, (size_t)job->frames, sizeof *data.lines, &lines));
    data.lines = lines;
    SC_TRY(sc_manifest_read(ctx, path, &data));
    if (!data.end.known) {
        status =
            sc_fail(ctx, SC_ERR_INCOMPLETE,
                    "%s: has no end line, so the job is not finished: %d of %d frames are done",
                    path, data.count, job->frames);
        goto out;
    }
    for (int k = 0; k < job->frames; k++) {
        if (!data.lines[k].known) {
            status = sc_fail(ctx, SC_ERR_DATA, "%s: has no line for frame %d", path, k);
            goto out;
        }
    }
    if (data.count != job->frames) {
        status = sc_fail(ctx, SC_ERR_DATA, "%s: has %d lines of frames, expected %d", path,
                         data.count, job->frames);
        goto out;
    }
    if (job->png)
        SC_TRY(verify_png_files(ctx, directory, job, data.lines));
    if (strcmp(job->video, "none") != 0)
        SC_TRY(verify_video(ctx, directory, job, &data.end));
out:
    sc_free(lines);
    return status;
}
