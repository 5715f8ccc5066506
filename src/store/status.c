/* SPDX-License-Identifier: BSD-3-Clause */
/* Says from the manifests alone whether the job of a directory is complete. */
#include "internal.h"

#include <stdarg.h>
#include <sys/stat.h>

/* For the functions that sc_each_file calls. */
typedef struct manifest_reader {
    sc_manifest_data data; /* of all manifests read so far */
    int manifests;         /* how many there are */
    bool closed;           /* that of the whole job has its last line */
    char problem[160];     /* what is wrong with one of them; empty: nothing */
} manifest_reader;

/* For sc_each_file with a manifest_reader as user: read one manifest into its data; with data.lines
 * NULL it only counts. One that is gone is ignored. */
static sc_status read_one(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    const sc_ctx quiet = sc_quiet(ctx);
    manifest_reader *reader = user;
    const sc_status status = sc_manifest_read(&quiet, path, &reader->data);

    if (status == SC_ERR_MISSING)
        return SC_OK; /* the process that completed the job has removed it */
    if (!reader->data.head.known && strcmp(name, "manifest.jsonl") != 0)
        return status; /* not of segcast */
    reader->manifests++;
    if (!reader->data.head.known)
        snprintf(reader->problem, sizeof reader->problem, "%.40s: %.100s", name,
                 reader->data.head.problem);
    else if (reader->data.damaged_line)
        snprintf(reader->problem, sizeof reader->problem,
                 "line %d of %.100s is not what was written", reader->data.damaged_line, name);
    if (!strcmp(name, "manifest.jsonl"))
        reader->closed = reader->data.closed;
    return status;
}

/* For SC_OWN. */
static void clear_reader(manifest_reader *reader)
{
    sc_free(reader->data.lines);
    sc_manifest_data_clear(&reader->data);
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

/* Set the report to damaged unless the file has this size. */
static void compare_size(const char *directory, const char *name, uint64_t bytes,
                         sc_store_report *out)
{
    char path[SC_FILE_BYTES];
    struct stat info;

    sc_store_path(directory, path, "%s", name);
    if (lstat(path, &info))
        damaged(out, "%.100s is missing", name);
    else if ((uint64_t)info.st_size != bytes)
        damaged(out, "%.100s has %lld bytes, expected %llu", name, (long long)info.st_size,
                (unsigned long long)bytes);
}

/* Set condition and video of the report of a job whose manifest @p data is closed. Needs done and
 * frames. */
static void judge_closed(const char *directory, const sc_manifest_data *data, sc_store_report *out)
{
    out->condition = SC_STORE_COMPLETE;
    snprintf(out->video, sizeof out->video, "%s", data->end.video);
    for (int i = 0; i < data->files.count; i++)
        compare_size(directory, data->files.lines[i].name, data->files.lines[i].bytes, out);
    if (out->video[0])
        compare_size(directory, out->video, data->end.video_bytes, out);
    if (out->done != out->frames)
        damaged(out, "the manifest ends with lines for only %d of %d frames", out->done,
                out->frames);
}

/* Count the frames that are done, into the report: of the whole job, or, with @p wanted [count], of
 * those frames. The slices of a job share the duty of joining its video: if all frames of the job
 * are there, no slice counts as complete unless the manifest of the job is @p closed. */
static void count_frames(const sc_manifest_data *data, bool closed, const int *wanted, int count,
                         sc_store_report *out)
{
    int all = 0, done = 0;

    for (int k = 0; k < data->frames; k++)
        all += data->lines[k].known;
    out->done = all;
    if (!wanted || closed)
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
    SC_OWN(clear_reader) manifest_reader reader = {.manifests = 0};
    sc_store_report report = {.condition = SC_STORE_INCOMPLETE};

    if (strlen(directory) > SC_DIRECTORY_MAX)
        return sc_fail(ctx, SC_ERR_MISSING, "%.60s...: the path is longer than %d bytes", directory,
                       SC_DIRECTORY_MAX);
    SC_PASS(sc_each_file(ctx, directory, sc_is_manifest_name, &reader, read_one));
    if (reader.manifests == 0)
        return sc_fail_no_run(ctx, directory);
    report.frames = reader.data.head.frames;
    if (report.frames == 0) { /* that of the whole job, which is read last, is none */
        damaged(&report, "%s", reader.problem);
        *out = report;
        return SC_OK;
    }
    sc_manifest_data_clear(&reader.data);
    reader = (manifest_reader){.data = {.frames = report.frames}};
    SC_PASS(SC_ZALLOC(ctx, (size_t)report.frames, &reader.data.lines));
    SC_PASS(sc_each_file(ctx, directory, sc_is_manifest_name, &reader, read_one));
    count_frames(&reader.data, reader.closed, wanted, count, &report);
    if (reader.problem[0])
        damaged(&report, "%s", reader.problem);
    else if (reader.closed && reader.data.end.known)
        judge_closed(directory, &reader.data, &report);
    *out = report;
    return SC_OK;
}
