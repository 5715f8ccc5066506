/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes the file of measurements: JSON Lines, each flushed to disk before the next measurement. */
#include "internal.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

struct sc_measurement_file {
    int fd;
    char *path;
};

/* ---- JSON ---- */

json_t *sc_study_run_json(const sc_study_run *run)
{
    return sc_json_of_rows(sc_study_run_rows, run);
}

static json_t *axes_json(const sc_design *design)
{
    json_t *axes = json_array();

    for (int i = 0; i < design->axis_count && axes; i++) {
        json_t *values = json_array();

        for (int j = 0; j < design->axes[i].value_count; j++)
            json_array_append_new(values, json_string(design->axes[i].values[j]));
        axes = sc_json_with(
            axes, json_pack("{s:s, s:o}", "name", design->axes[i].name, "values", values));
    }
    return axes;
}

/* ---- lines ---- */

/* Write all of @p bytes bytes. */
static sc_status write_all(const sc_ctx *ctx, const sc_measurement_file *file, const char *data,
                           size_t bytes)
{
    while (bytes > 0) {
        const ssize_t done = write(file->fd, data, bytes);

        if (done < 0 && errno == EINTR)
            continue;
        if (done < 0)
            return sc_fail(ctx, SC_ERR_WRITE, "%s: %s", file->path, sc_reason(errno));
        data += done;
        bytes -= (size_t)done;
    }
    return SC_OK;
}

/* Write @p json as a line, and flush it to disk; takes ownership of it. NULL: out of memory. */
static sc_status write_line(const sc_ctx *ctx, sc_measurement_file *file, json_t *json)
{
    SC_OWN(sc_text_clear) sc_text line = {0};

    SC_PASS(sc_json_add_text(ctx, json, JSON_COMPACT | JSON_REAL_PRECISION(9), file->path, &line));
    SC_PASS(write_all(ctx, file, line.data, line.length_bytes));
    if (fsync(file->fd) && errno != EINVAL && errno != EROFS)
        return sc_fail(ctx, SC_ERR_WRITE, "%s: %s", file->path, sc_reason(errno));
    return SC_OK;
}

SC_CLOSE_AT(sc_measurement_file_close, sc_measurement_file)

/* Open the file @p path for this process alone. @param flags of open. */
static sc_status open_file(const sc_ctx *ctx, const char *path, int flags,
                           sc_measurement_file **out)
{
    SC_OWN(sc_measurement_file_close_at) sc_measurement_file *file = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &file));
    file->fd = -1;
    SC_PASS(sc_text_copy(ctx, path, &file->path));
    file->fd = open(path, flags | O_WRONLY | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file->fd < 0)
        return sc_fail(ctx, SC_ERR_CREATE, "%s: %s", path, sc_reason(errno));
    if (flock(file->fd, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK)
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: another segcast study is writing to this file; wait for its end, or "
                       "choose another directory with -o",
                       path);
    SC_HAND_OVER(file, out);
    return SC_OK;
}

static sc_status write_run(const sc_ctx *ctx, sc_measurement_file *file, const sc_study_run *run)
{
    json_t *json = sc_study_run_json(run);

    if (run->made_from)
        json = sc_json_with_key(json, "made_from", json_loads(run->made_from, 0, NULL));
    return write_line(ctx, file, json ? json_pack("{s:o}", "run", json) : NULL);
}

sc_status sc_measurement_file_create(const sc_ctx *ctx, const char *path, const sc_design *design,
                                     const sc_study_run *run, sc_measurement_file **out)
{
    SC_OWN(sc_measurement_file_close_at) sc_measurement_file *file = NULL;

    SC_PASS(open_file(ctx, path, O_CREAT | O_EXCL, &file));
    SC_PASS(write_line(ctx, file,
                       json_pack("{s:s, s:o, s:s, s:s, s:s, s:o}", "schema", "segcast-study-1",
                                 "study", sc_json_of_hash(design->hash), "title",
                                 design->title ? design->title : "", "measure",
                                 design->whole_jobs ? "job" : "frames", "metric",
                                 design->by_wall ? "wall" : "cpu", "axes", axes_json(design))));
    SC_PASS(write_run(ctx, file, run));
    SC_HAND_OVER(file, out);
    return SC_OK;
}

sc_status sc_measurement_file_resume(const sc_ctx *ctx, const char *path, uint64_t whole_bytes,
                                     const sc_study_run *run, sc_measurement_file **out)
{
    SC_OWN(sc_measurement_file_close_at) sc_measurement_file *file = NULL;

    SC_PASS(open_file(ctx, path, 0, &file));
    /* What a killed study has begun to write is cut off; later lines follow the whole ones. */
    if (ftruncate(file->fd, (off_t)whole_bytes) || lseek(file->fd, 0, SEEK_END) < 0)
        return sc_fail(ctx, SC_ERR_WRITE, "%s: %s", path, sc_reason(errno));
    SC_PASS(write_run(ctx, file, run));
    SC_HAND_OVER(file, out);
    return SC_OK;
}

sc_status sc_measurement_file_add(const sc_ctx *ctx, sc_measurement_file *file,
                                  const sc_measurement *item)
{
    json_t *json = sc_json_of_rows(sc_measurement_rows, item);

    return write_line(ctx, file, json ? json_pack("{s:o}", "measurement", json) : NULL);
}

sc_status sc_measurement_file_skip(const sc_ctx *ctx, sc_measurement_file *file, int cell,
                                   const char *reason)
{
    return write_line(ctx, file,
                      json_pack("{s:{s:i, s:s}}", "skipped", "cell", cell, "reason", reason));
}

sc_status sc_measurement_file_complete(const sc_ctx *ctx, sc_measurement_file *file)
{
    return write_line(ctx, file, json_pack("{s:b}", "complete", 1));
}

void sc_measurement_file_close(sc_measurement_file *file)
{
    if (!file)
        return;
    if (file->fd >= 0)
        close(file->fd);
    sc_free(file->path);
    sc_free(file);
}
