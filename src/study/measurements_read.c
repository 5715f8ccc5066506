/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads a file of measurements. Nothing in it is trusted: numbers are checked against their ranges,
 * cells against the design. */
#include "internal.h"
#include "segcast/json_values.h"

#include <jansson.h>

/* A study of the largest design measured a thousand times writes less. */
enum { FILE_MAX_MIB = 1024 };
enum { AXES_MAX = 64, CELLS_MAX = 1000000 };

/* ---- the design, in the first line ---- */

/* Copy a text without NUL bytes; *out is NULL for anything else. Caller owns *out. */
static sc_status copy_string(const sc_ctx *ctx, const json_t *value, char **out)
{
    const char *from = json_string_value(value);

    *out = NULL;
    if (!from || strlen(from) != json_string_length(value))
        return SC_OK;
    return sc_text_copy(ctx, from, out);
}

/* Read an axis into @p out, which owns what is read, also after an error. @param good set to false
 * if it is none. */
static sc_status read_axis(const sc_ctx *ctx, const json_t *object, sc_design_axis *out, bool *good)
{
    const json_t *values = json_object_get(object, "values");
    const size_t count = json_array_size(values);

    if (count < 1 || count > CELLS_MAX) {
        *good = false;
        return SC_OK;
    }
    SC_PASS(SC_ZALLOC(ctx, count, &out->values));
    SC_PASS(copy_string(ctx, json_object_get(object, "name"), &out->name));
    *good = *good && out->name;
    for (size_t i = 0; i < count && *good; i++) {
        SC_PASS(copy_string(ctx, json_array_get(values, i), &out->values[i]));
        out->value_count++;
        *good = out->values[i] != NULL;
    }
    return SC_OK;
}

/* @return whether the member @p key is the text @p value; it may be missing. */
static bool has_text(const json_t *object, const char *key, const char *value)
{
    const char *text = json_string_value(json_object_get(object, key));

    return text && !strcmp(text, value);
}

/* Read the first line into @p out, which owns what is read, also after an error. */
static sc_status read_design(const sc_ctx *ctx, const json_t *line, sc_design *out, bool *good)
{
    const char *schema = json_string_value(json_object_get(line, "schema"));
    const json_t *axes = json_object_get(line, "axes");
    const size_t count = json_array_size(axes);
    double cells = 1;

    *good = schema && !strcmp(schema, "segcast-study-1") && json_is_array(axes) &&
            count <= AXES_MAX && sc_json_hash(json_object_get(line, "study"), &out->hash);
    if (!*good)
        return SC_OK;
    out->whole_jobs = has_text(line, "measure", "job");
    out->by_wall = has_text(line, "metric", "wall");
    SC_PASS(copy_string(ctx, json_object_get(line, "title"), &out->title));
    SC_PASS(SC_ZALLOC(ctx, count, &out->axes));
    for (size_t i = 0; i < count && *good; i++) {
        out->axis_count++;
        SC_PASS(read_axis(ctx, json_array_get(axes, i), &out->axes[i], good));
        cells *= out->axes[i].value_count;
        *good = *good && cells <= CELLS_MAX;
    }
    *good = *good && out->title;
    return SC_OK;
}

/* ---- lines ---- */

/* Read one of the lines after the first. @param good set to false if it is none of a study. */
static sc_status read_line(const sc_ctx *ctx, const json_t *line, sc_measurements *out, bool *good)
{
    const int cells = sc_design_cells(&out->design);
    const json_t *skipped = json_object_get(line, "skipped");
    const char *reason = json_string_value(json_object_get(skipped, "reason"));
    sc_measurement item;
    sc_study_run run;
    int32_t cell;

    out->complete = json_is_true(json_object_get(line, "complete"));
    if (out->complete)
        return SC_OK;
    if (json_object_get(line, "run")) {
        run = (sc_study_run){0};
        *good = sc_json_read_rows(sc_study_run_rows, json_object_get(line, "run"), &run) &&
                run.ranks > 0 && run.nodes > 0 && run.cores > 0;
        if (*good)
            SC_PASS(sc_keep_made_from(ctx, json_object_get(line, "run"), &run.made_from));
        return *good ? sc_measurements_add_run(ctx, out, &run) : SC_OK;
    }
    if (skipped) {
        *good = reason && sc_json_int(json_object_get(skipped, "cell"), 0, cells - 1, &cell);
        return *good ? sc_measurements_skip(ctx, out, cell, reason) : SC_OK;
    }
    *good = sc_json_read_rows(sc_measurement_rows, json_object_get(line, "measurement"), &item) &&
            item.cell < cells && item.passes > 0 && item.frames > 0 && item.ranks > 0 &&
            item.threads > 0;
    return *good ? sc_measurements_append(ctx, out, &item) : SC_OK;
}

/* Read the lines of @p text into @p out. @param whole see sc_measurements_read. */
static sc_status read_lines(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                            sc_measurements *out, uint64_t *whole)
{
    int number = 0;
    sc_status status = SC_OK;

    *whole = 0;
    while (*whole < bytes && status == SC_OK) {
        const char *at = text + *whole, *end = memchr(at, '\n', bytes - *whole);
        json_t *line = end ? json_loadb(at, (size_t)(end - at), 0, NULL) : NULL;
        bool good = json_is_object(line);

        if (!end)
            break; /* the study was killed while it wrote this line */
        if (good)
            status = number == 0 ? read_design(ctx, line, &out->design, &good)
                                 : read_line(ctx, line, out, &good);
        json_decref(line);
        number++;
        if (status == SC_OK && !good)
            return sc_fail(
                ctx, SC_ERR_DATA,
                number == 1
                    ? "%s:%d: this is not the first line of a file that segcast study writes"
                    : "%s:%d: this is no line that segcast study writes; the file is damaged",
                path, number);
        *whole += (uint64_t)(end + 1 - at);
    }
    if (status == SC_OK && number == 0)
        status = sc_fail(ctx, SC_ERR_DATA, "%s: the file holds no line of a study", path);
    return status;
}

sc_status sc_measurements_read(const sc_ctx *ctx, const char *path, sc_measurements *out,
                               uint64_t *whole_bytes)
{
    SC_OWN(sc_measurements_clear) sc_measurements all = {0};
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;
    uint64_t whole;

    SC_PASS(sc_file_read(ctx, path, (size_t)FILE_MAX_MIB << 20, &text, &bytes));
    SC_PASS(read_lines(ctx, path, text, bytes, &all, &whole));
    *out = all;
    *whole_bytes = whole;
    all = (sc_measurements){0};
    return SC_OK;
}

sc_status sc_measurements_begin(const sc_ctx *ctx, const char *path, bool *out)
{
    const sc_ctx silent = sc_quiet(ctx);
    SC_OWN(sc_design_clear) sc_design design = {0};
    json_t *line = NULL;
    SC_OWN(sc_free_at) char *text = NULL;
    const char *end;
    size_t bytes;
    bool good = false;
    sc_status status;

    SC_TRY(sc_file_read(&silent, path, (size_t)FILE_MAX_MIB << 20, &text, &bytes));
    end = memchr(text, '\n', bytes);
    line = end ? json_loadb(text, (size_t)(end - text), 0, NULL) : NULL;
    if (json_is_object(line))
        status = read_design(&silent, line, &design, &good);
out:
    if (sc_is_of_input(status))
        status = SC_OK;
    if (status == SC_OK)
        *out = good;
    json_decref(line);
    return status;
}
