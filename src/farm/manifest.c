/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/farm.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

struct sc_manifest {
    FILE *stream;
    char *path;
};

/* Hashes as 16 hexadecimal digits: JSON numbers are too short for them. */
static json_t *hex(uint64_t value)
{
    char text[17];

    snprintf(text, sizeof text, "%016llx", (unsigned long long)value);
    return json_string(text);
}

static sc_status add_line(const sc_ctx *ctx, sc_manifest *manifest, json_t *line)
{
    char *text = line ? json_dumps(line, JSON_COMPACT) : NULL;
    sc_status status = SC_OK;

    json_decref(line);
    if (!text)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", manifest->path);
    if (fprintf(manifest->stream, "%s\n", text) < 0 || fflush(manifest->stream))
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", manifest->path,
                         strerror(errno));
    free(text);
    return status;
}

sc_status sc_manifest_open(const sc_ctx *ctx, const char *directory, const sc_manifest_head *head,
                           sc_manifest **out)
{
    sc_manifest *manifest = NULL;
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *manifest, &block));
    manifest = block;
    SC_TRY(sc_path_join(ctx, directory, "manifest.jsonl", &manifest->path));
    manifest->stream = fopen(manifest->path, "w");
    if (!manifest->stream) {
        status = sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", manifest->path,
                         strerror(errno));
        goto out;
    }
    SC_TRY(add_line(ctx, manifest,
                    json_pack("{s:s, s:s, s:o, s:o, s:i, s:[i,i]}", "schema", "segcast-manifest-1",
                              "version", head->version, "job_hash", hex(head->job_hash),
                              "volume_hash", hex(head->volume_hash), "frames", head->frames, "size",
                              head->width_px, head->height_px)));
    *out = manifest;
    return SC_OK;
out:
    sc_manifest_close(manifest);
    return status;
}

sc_status sc_manifest_add(const sc_ctx *ctx, sc_manifest *manifest, const sc_frame_result *result)
{
    return add_line(ctx, manifest,
                    json_pack("{s:i, s:o, s:i, s:f}", "frame", result->frame, "hash",
                              hex(result->hash), "rank", result->rank, "render_cpu_s",
                              result->render_cpu_s));
}

void sc_manifest_close(sc_manifest *manifest)
{
    if (!manifest)
        return;
    if (manifest->stream)
        fclose(manifest->stream);
    sc_free(manifest->path);
    sc_free(manifest);
}

sc_status sc_status_write(const sc_ctx *ctx, const char *directory, const sc_status_report *report)
{
    json_t *json = json_pack("{s:s, s:s, s:i, s:i, s:f, s:f, s:f}", "schema", "segcast-status-1",
                             "state", report->state, "done", report->done, "total", report->total,
                             "elapsed_s", report->elapsed_s, "frames_per_s", report->frames_per_s,
                             "remaining_s", report->remaining_s);
    char *text = json ? json_dumps(json, JSON_INDENT(2)) : NULL;
    char *path = NULL;
    sc_status status;

    if (!text) {
        status = sc_fail(ctx, SC_ERR_MEMORY, "status.json: out of memory");
        goto out;
    }
    SC_TRY(sc_path_join(ctx, directory, "status.json", &path));
    status = sc_file_write(ctx, path, text, strlen(text));
out:
    sc_free(path);
    free(text);
    json_decref(json);
    return status;
}
