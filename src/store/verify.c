/* SPDX-License-Identifier: BSD-3-Clause */
/* Verifies a finished directory from its files alone, without the volume. */
#include "internal.h"

#include <math.h>
#include <unistd.h>

/* For sc_each_file with an sc_manifest_data as user: read the head of a manifest of a slice, until
 * one is known. */
static sc_status read_slice(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    sc_manifest_data *data = user;

    return data->head.known ? SC_OK : sc_manifest_read_head(ctx, path, data);
}

/* Find the head of manifest.jsonl or, if there is none, of a slice. */
static sc_status find_head(const sc_ctx *ctx, const char *directory, sc_manifest_data *out)
{
    char path[SC_FILE_BYTES];
    sc_status status;

    if (strlen(directory) > SC_DIRECTORY_MAX)
        return sc_fail(ctx, SC_ERR_MISSING,
                       "%.60s...: the path of the directory has %zu bytes, expected at most %d",
                       directory, strlen(directory), SC_DIRECTORY_MAX);
    sc_store_path(directory, path, "manifest.jsonl");
    if (access(path, F_OK) != 0)
        return sc_each_file(ctx, directory, sc_is_manifest_name, out, read_slice);
    status = sc_manifest_read_head(ctx, path, out);
    if (status == SC_OK && !out->head.known)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, out->head.problem);
    return status;
}

sc_status sc_store_identify(const sc_ctx *ctx, const char *directory, sc_store_job *job,
                            char *version)
{
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = 0};
    const sc_manifest_head *head = &data.head;

    SC_PASS(find_head(ctx, directory, &data));
    if (!head->known)
        return sc_fail_no_run(ctx, directory);
    snprintf(version, 64, "%s", head->version);
    job->version = version;
    job->job_hash = head->job_hash;
    job->volume_hash = head->volume_hash;
    job->frames = head->frames;
    job->settings.width_px = head->size_px[0];
    job->settings.height_px = head->size_px[1];
    return SC_OK;
}

/* For check_video_frame; pointers are borrowed. */
typedef struct video_check {
    const sc_ctx *ctx;
    const char *path; /* for messages */
    const sc_store_job *job;
    int frames; /* decoded so far */
} video_check;

/* For sc_video_decode with a video_check as user: compare time (within the unit of its format) and
 * size of a frame with the job, and count it. Its pixels are not compared. @return SC_ERR_DATA,
 * with a message. */
static sc_status check_video_frame(void *user, int k, double time_s, const sc_image *image)
{
    video_check *check = user;
    const int width_px = (check->job->settings.width_px + 1) & ~1;
    const int height_px = (check->job->settings.height_px + 1) & ~1;
    const double expected_s = (double)k / check->job->settings.fps;

    check->frames = k + 1;
    sc_stage_add(check->ctx, 1);
    if (fabs(time_s - expected_s) > sc_video_time_error_s(check->path))
        return sc_fail(check->ctx, SC_ERR_DATA, "%s: frame %d is shown at %.4f s, expected %.4f",
                       check->path, k, time_s, expected_s);
    if (image->width_px != width_px || image->height_px != height_px)
        return sc_fail(check->ctx, SC_ERR_DATA, "%s: frame %d has %d x %d pixels, expected %d x %d",
                       check->path, k, image->width_px, image->height_px, width_px, height_px);
    return SC_OK;
}

/* Compare a file with what its manifest names. @return SC_ERR_DATA if it is another one. */
static sc_status verify_named(const sc_ctx *ctx, const char *path, uint64_t bytes, uint64_t hash)
{
    bool same;

    SC_PASS(sc_verify_file(ctx, path, bytes, hash, &same));
    return same ? SC_OK
                : sc_fail(ctx, SC_ERR_DATA,
                          "%s: is missing, or is not the file of %llu bytes and hash %016llx that "
                          "the manifest names",
                          path, (unsigned long long)bytes, (unsigned long long)hash);
}

/* Compare name, size and hash of the video with @p end, then decode it, and compare its frames and
 * their number with @p job. @return SC_ERR_DATA naming the first thing that is wrong. */
static sc_status verify_video(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                              const sc_manifest_end *end)
{
    char path[SC_FILE_BYTES];
    video_check check = {.ctx = ctx, .path = path, .job = job};

    sc_store_path(directory, path, "%s", job->video);
    if (strcmp(end->video, job->video) != 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: the manifest names another video: \"%s\"", path,
                       end->video);
    SC_PASS(verify_named(ctx, path, end->video_bytes, end->video_hash));
    sc_stage_begin(ctx, "verifying the video", 0, (uint64_t)job->frames);
    SC_PASS(sc_video_decode(ctx, path, check_video_frame, &check));
    if (check.frames != job->frames)
        return sc_fail(ctx, SC_ERR_DATA, "%s: holds %d frames, expected %d", path, check.frames,
                       job->frames);
    return SC_OK;
}

/* Decode all PNG files, and compare their bytes and pixels with the hashes in @p lines
 * ([job->frames], all known). @return SC_ERR_DATA naming the first one that is wrong,
 * SC_ERR_MEMORY. */
static sc_status verify_png_files(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                                  sc_frame_line *lines)
{
    SC_OWN(sc_free_at) bool *verified = NULL;

    SC_PASS(SC_ALLOC(ctx, (size_t)job->frames, &verified));
    sc_stage_begin(ctx, "verifying frames", 0, (uint64_t)job->frames);
    SC_PASS(sc_verify_png_files(ctx, directory, lines, job->frames, job->threads, verified));
    for (int k = 0; k < job->frames; k++) {
        if (!verified[k])
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s/frames/%06d.png: is missing, damaged, or not the picture of hash "
                           "%016llx that the manifest names",
                           directory, k, (unsigned long long)lines[k].done.hash);
    }
    return SC_OK;
}

/* Read the manifest of a finished job. @return SC_ERR_DATA if it is damaged, SC_ERR_INCOMPLETE if
 * it is not closed. @p data has lines or not; the caller clears it. */
static sc_status read_closed(const sc_ctx *ctx, const char *directory, sc_manifest_data *data)
{
    char path[SC_FILE_BYTES];

    sc_store_path(directory, path, "manifest.jsonl");
    if (access(path, F_OK) != 0)
        return sc_fail(ctx, SC_ERR_INCOMPLETE,
                       "%s: is not there, so the job, which was drawn in slices, is not finished; "
                       "when all slices have ended, `segcast join %s` completes it",
                       path, directory);
    SC_PASS(sc_manifest_read(ctx, path, data));
    if (data->damaged_line)
        return sc_fail(ctx, SC_ERR_DATA, "%s: line %d is damaged: it is not what segcast wrote",
                       path, data->damaged_line);
    if (!data->end.known)
        return sc_fail(ctx, SC_ERR_INCOMPLETE,
                       "%s: has no end line, so the job is not finished: %d of %d frames are done; "
                       "run again with --resume",
                       path, data->count, data->head.frames);
    if (!data->closed)
        return sc_fail(ctx, SC_ERR_INCOMPLETE,
                       "%s: has no end line: the pictures are complete, the statistics are not; "
                       "run again with --resume",
                       path);
    return SC_OK;
}

/* Compare a record with its line, and append its name to @p names. @return SC_ERR_DATA if it is not
 * the file of that line. */
static sc_status verify_record(const sc_ctx *ctx, const char *directory, const char *name,
                               const sc_file_line *line, sc_text *names)
{
    char path[SC_FILE_BYTES];

    sc_store_path(directory, path, "%s", name);
    SC_PASS(verify_named(ctx, path, line->bytes, line->hash));
    return sc_text_add(ctx, names, ", %s", name);
}

sc_status sc_store_verify_records(const sc_ctx *ctx, const char *directory, sc_text *names)
{
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = 0};

    SC_PASS(read_closed(ctx, directory, &data));
    for (int i = 0; i < data.files.count; i++)
        SC_PASS(
            verify_record(ctx, directory, data.files.lines[i].name, &data.files.lines[i], names));
    for (int i = 0; i < data.jobs.count; i++)
        SC_PASS(verify_record(ctx, directory, "job.yaml", &data.jobs.lines[i], names));
    return SC_OK;
}

sc_status sc_store_verify(const sc_ctx *ctx, const char *directory, const sc_store_job *job)
{
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = job->frames};
    SC_OWN(sc_free_at) sc_frame_line *lines = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)job->frames, &lines));
    data.lines = lines;
    SC_PASS(read_closed(ctx, directory, &data));
    for (int k = 0; k < job->frames; k++) {
        if (!data.lines[k].known || (job->png && !data.lines[k].done.png_bytes))
            return sc_fail(ctx, SC_ERR_DATA, "%s/manifest.jsonl: has no line for frame %d%s",
                           directory, k, data.lines[k].known ? " with its PNG file" : "");
    }
    if (data.count != job->frames)
        return sc_fail(ctx, SC_ERR_DATA, "%s/manifest.jsonl: has %d lines of frames, expected %d",
                       directory, data.count, job->frames);
    if (job->png)
        SC_PASS(verify_png_files(ctx, directory, job, data.lines));
    if (strcmp(job->video, "none") != 0)
        SC_PASS(verify_video(ctx, directory, job, &data.end));
    return SC_OK;
}
