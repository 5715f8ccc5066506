/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes and reads the lines of a manifest, each a JSON object. */
#include "internal.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SCHEMA "segcast-manifest-2"
enum { MANIFEST_MAX_BYTES = 1 << 30 }; /* about ten million lines */

struct sc_manifest_writer {
    FILE *stream; /* open for appending */
    char *path;   /* owned; for messages */
};

/* @return a hash as a text of 16 hexadecimal digits: JSON numbers cannot hold 64 bits exactly. */
static json_t *hash_to_json(uint64_t value)
{
    char text[17];

    snprintf(text, sizeof text, "%016llx", (unsigned long long)value);
    return json_string(text);
}

/* Append @p line to the stream and hand it to the system (fflush). Takes ownership of @p line, of
 * which NULL stands for no memory. @param path for messages.
 * @return SC_ERR_WRITE, SC_ERR_MEMORY. */
static sc_status add_line(const sc_ctx *ctx, FILE *stream, const char *path, json_t *line)
{
    char *text = line ? json_dumps(line, JSON_COMPACT) : NULL;
    sc_status status = SC_OK;

    json_decref(line);
    if (!text)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    if (fprintf(stream, "%s\n", text) < 0 || fflush(stream))
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, sc_reason(errno));
    free(text);
    return status;
}

/* Make the first line: schema, version, both hashes, number of frames and their size. Like
 * frame_to_json: a new reference that the caller owns, or NULL if there is no memory. */
static json_t *head_to_json(const sc_store_job *job)
{
    return json_pack("{s:s, s:s, s:o, s:o, s:i, s:[i,i]}", "schema", SCHEMA, "version",
                     job->version, "job_hash", hash_to_json(job->job_hash), "volume_hash",
                     hash_to_json(job->volume_hash), "frames", job->frames, "size",
                     job->settings.width_px, job->settings.height_px);
}

/* Make the line of a frame: number, hash, rank and CPU time. */
static json_t *frame_to_json(const sc_done_frame *done)
{
    return json_pack("{s:i, s:o, s:i, s:f}", "frame", done->frame, "hash", hash_to_json(done->hash),
                     "rank", done->rank, "render_cpu_s", done->render_cpu_s);
}

/* Write the head of @p job and the lines k for which keep[k] is set; without @p lines the head
 * alone, and @p keep is not read. */
static sc_status write_lines(const sc_ctx *ctx, FILE *stream, const char *path,
                             const sc_store_job *job, const sc_frame_line *lines, const bool *keep)
{
    sc_status status = add_line(ctx, stream, path, head_to_json(job));

    for (int k = 0; k < job->frames && status == SC_OK; k++) {
        if (lines && keep[k])
            status = add_line(ctx, stream, path, frame_to_json(&lines[k].done));
    }
    return status;
}

sc_status sc_manifest_create(const sc_ctx *ctx, const char *path, const sc_store_job *job,
                             const sc_frame_line *lines, const bool *keep, sc_manifest_writer **out)
{
    sc_manifest_writer *manifest = NULL;
    sc_outfile file = {0};
    sc_text copy = {0};
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_outfile_open(ctx, path, true, &file));
    SC_TRY(write_lines(ctx, file.stream, path, job, lines, keep));
    SC_TRY(sc_outfile_commit(ctx, &file));
    SC_TRY(sc_zalloc(ctx, 1, sizeof *manifest, &block));
    manifest = block;
    SC_TRY(sc_text_add(ctx, &copy, "%s", path));
    manifest->path = copy.data;
    manifest->stream = fopen(path, "a");
    if (!manifest->stream) {
        status = sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be opened: %s", path, sc_reason(errno));
        goto out;
    }
    *out = manifest;
    return SC_OK;
out:
    sc_outfile_discard(&file);
    sc_manifest_close(manifest);
    return status;
}

sc_status sc_manifest_add_frame(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_done_frame *done)
{
    return add_line(ctx, manifest->stream, manifest->path, frame_to_json(done));
}

sc_status sc_manifest_add_end(const sc_ctx *ctx, sc_manifest_writer *manifest,
                              const sc_store_job *job, const sc_manifest_end *end)
{
    const bool video = strcmp(job->video, "none") != 0;
    json_t *line = json_pack("{s:b, s:i}", "complete", 1, "frames", job->frames);

    if (line && video) {
        json_object_set_new(line, "video", json_string(job->video));
        json_object_set_new(line, "video_bytes", json_integer((json_int_t)end->video_bytes));
        json_object_set_new(line, "video_hash", hash_to_json(end->video_hash));
    }
    return add_line(ctx, manifest->stream, manifest->path, line);
}

sc_status sc_manifest_sync(const sc_ctx *ctx, sc_manifest_writer *manifest)
{
    if (!manifest)
        return SC_OK;
    if (fflush(manifest->stream) || (fsync(fileno(manifest->stream)) && errno != EINVAL))
        return sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", manifest->path,
                       sc_reason(errno));
    return SC_OK;
}

void sc_manifest_close(sc_manifest_writer *manifest)
{
    if (!manifest)
        return;
    if (manifest->stream)
        fclose(manifest->stream);
    sc_free(manifest->path);
    sc_free(manifest);
}

/* ---- reading ---- */

/* Both return the value at @p key of an object, or 0 if it is missing or of another type. A hash is
 * a text of hexadecimal digits. */
static uint64_t get_hash(const json_t *line, const char *key)
{
    const char *text = json_string_value(json_object_get(line, key));

    return text ? strtoull(text, NULL, 16) : 0;
}

static int get_int(const json_t *line, const char *key)
{
    return (int)json_integer_value(json_object_get(line, key));
}

/* Fill all of @p head from the first line; what the line lacks is 0 or "". */
static void read_head(const json_t *line, sc_manifest_head *head)
{
    const char *version = json_string_value(json_object_get(line, "version"));
    const json_t *size = json_object_get(line, "size");

    *head = (sc_manifest_head){.known = true,
                               .job_hash = get_hash(line, "job_hash"),
                               .volume_hash = get_hash(line, "volume_hash"),
                               .frames = get_int(line, "frames")};
    snprintf(head->version, sizeof head->version, "%s", version ? version : "");
    for (size_t i = 0; i < 2; i++)
        head->size_px[i] = (int)json_integer_value(json_array_get(size, i));
}

/* Fill all of @p end from an end line. */
static void read_end(const json_t *line, sc_manifest_end *end)
{
    const char *video = json_string_value(json_object_get(line, "video"));

    *end = (sc_manifest_end){true,
                             (uint64_t)json_integer_value(json_object_get(line, "video_bytes")),
                             get_hash(line, "video_hash"),
                             {0}};
    snprintf(end->video, sizeof end->video, "%s", video ? video : "");
}

/* Put the line into @p data: a head or an end replaces the one before; a frame's line goes to
 * data->lines, if that is not NULL, and adds to data->count. @return false, with @p data untouched,
 * if the line is not that of a manifest, or of a frame out of range. */
static bool read_line(const json_t *line, sc_manifest_data *data)
{
    sc_done_frame done;

    if (json_object_get(line, "schema")) {
        read_head(line, &data->head);
        return true;
    }
    if (json_is_true(json_object_get(line, "complete"))) {
        read_end(line, &data->end);
        return true;
    }
    if (!json_is_integer(json_object_get(line, "frame")))
        return false;
    done = (sc_done_frame){.frame = get_int(line, "frame"),
                           .rank = get_int(line, "rank"),
                           .render_cpu_s = json_real_value(json_object_get(line, "render_cpu_s")),
                           .hash = get_hash(line, "hash")};
    if (done.frame < 0 || (data->lines && done.frame >= data->frames))
        return false;
    if (data->lines)
        data->lines[done.frame] = (sc_frame_line){true, done};
    data->count++;
    return true;
}

sc_status sc_manifest_read(const sc_ctx *ctx, const char *path, sc_manifest_data *data)
{
    char *text = NULL;
    size_t bytes;
    sc_status status = sc_file_read(ctx, path, MANIFEST_MAX_BYTES, &text, &bytes);

    if (status != SC_OK)
        return status;
    data->head = (sc_manifest_head){0};
    for (char *at = text, *end; (end = strchr(at, '\n')); at = end + 1) {
        json_t *line = json_loadb(at, (size_t)(end - at), 0, NULL);
        const bool ok = line && (at == text) == (json_object_get(line, "schema") != NULL) &&
                        read_line(line, data);

        json_decref(line);
        if (!ok)
            break; /* whatever follows a damaged line is ignored, too */
    }
    sc_free(text);
    return SC_OK;
}
