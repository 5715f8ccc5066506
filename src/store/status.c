/* SPDX-License-Identifier: BSD-3-Clause */
/* Says from the manifests alone whether the job of a directory is complete. */
#include "internal.h"

#include <stdarg.h>
#include <string.h>
#include <sys/stat.h>

/* The most frames that a job may have, and a manifest may name. */
enum { FRAMES_MAX = 1000000 };

/* For the functions that sc_each_file calls. */
typedef struct manifest_reader {
    const char *directory;
    sc_manifest_data data; /* of all manifests read so far */
    int manifests;         /* how many there are */
    int unreadable;        /* how many of them have no sound first line */
} manifest_reader;

/* For sc_each_file with a manifest_reader as user: read one manifest into its data; with data.lines
 * NULL it only counts. Other files are ignored, and so is a manifest that is gone. */
static sc_status read_one(const sc_ctx *ctx, void *user, const char *name)
{
    const sc_ctx silent = {.alloc_budget = ctx->alloc_budget};
    manifest_reader *reader = user;
    char *path = NULL;
    sc_status status = SC_OK;

    if (!sc_is_manifest_name(name))
        return SC_OK;
    SC_TRY(sc_path_join(ctx, reader->directory, name, &path));
    status = sc_manifest_read(&silent, path, &reader->data);
    if (status == SC_ERR_MISSING) {
        status = SC_OK; /* the process that completed the job has removed it */
        goto out;
    }
    reader->manifests++;
    if (status == SC_ERR_DATA || (status == SC_OK && !reader->data.head.known)) {
        reader->unreadable++;
        status = SC_OK;
    }
out:
    sc_free(path);
    return status;
}

/* Set the report to damaged, for the given reason. */
SC_PRINTF(2, 3) static void damaged(sc_store_report *out, const char *fmt, ...)
{
    va_list args;

    out->condition = SC_STORE_DAMAGED;
    va_start(args, fmt);
    vsnprintf(out->reason, sizeof out->reason, fmt, args);
    va_end(args);
}

/* Set condition and video of the report of a job whose manifest has the end line @p end. Needs
 * done and frames. */
static sc_status judge_end(const sc_ctx *ctx, const char *directory, const sc_manifest_end *end,
                           sc_store_report *out)
{
    struct stat info;
    char *path = NULL;
    sc_status status = SC_OK;

    out->condition = SC_STORE_COMPLETE;
    snprintf(out->video, sizeof out->video, "%s", end->video);
    if (out->done != out->frames)
        damaged(out, "the manifest ends with lines for only %d of %d frames", out->done,
                out->frames);
    if (!end->video[0])
        return SC_OK;
    SC_TRY(sc_path_join(ctx, directory, end->video, &path));
    if (stat(path, &info))
        damaged(out, "the video %s is missing", end->video);
    else if ((uint64_t)info.st_size != end->video_bytes)
        damaged(out, "the video %s has %lld bytes, expected %llu", end->video,
                (long long)info.st_size, (unsigned long long)end->video_bytes);
out:
    sc_free(path);
    return status;
}

/* Count the frames that are done, into the report: of the whole job, or, with @p wanted [count], of
 * those frames. The slices of a job share the duty of joining its video: if all frames of the job
 * are there, no slice counts as complete without the manifest's end. */
static void count_frames(const sc_manifest_data *data, const int *wanted, int count,
                         sc_store_report *out)
{
    int all = 0, done = 0;

    for (int k = 0; k < data->frames; k++)
        all += data->lines[k].known;
    out->done = all;
    if (!wanted || data->end.known)
        return;
    for (int i = 0; i < count; i++)
        done += wanted[i] < data->frames && data->lines[wanted[i]].known;
    if (done == count && all < data->frames)
        out->condition = SC_STORE_COMPLETE;
    out->done = done;
    out->frames = count;
}

sc_status sc_store_status(const sc_ctx *ctx, const char *directory, const int *wanted, int count,
                          sc_store_report *out)
{
    manifest_reader reader = {.directory = directory};
    sc_store_report report = {.condition = SC_STORE_INCOMPLETE};
    void *lines = NULL;
    sc_status status;

    SC_TRY(sc_each_file(ctx, directory, &reader, read_one));
    if (reader.manifests == 0) {
        status =
            sc_fail(ctx, SC_ERR_MISSING, "%s: holds no run: it has no manifest.jsonl", directory);
        goto out;
    }
    report.frames = reader.data.head.frames;
    if (reader.unreadable || report.frames < 1 || report.frames > FRAMES_MAX) {
        damaged(&report, "the first line of a manifest is damaged, or of another format");
        *out = report;
        goto out;
    }
    SC_TRY(sc_zalloc(ctx, (size_t)report.frames, sizeof *reader.data.lines, &lines));
    reader = (manifest_reader){.directory = directory,
                               .data = {.lines = lines, .frames = report.frames}};
    SC_TRY(sc_each_file(ctx, directory, &reader, read_one));
    count_frames(&reader.data, wanted, count, &report);
    if (reader.data.end.known)
        SC_TRY(judge_end(ctx, directory, &reader.data.end, &report));
    *out = report;
out:
    sc_free(lines);
    return status;
}
