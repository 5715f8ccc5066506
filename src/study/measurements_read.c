/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads a file of measurements. Nothing in it is trusted: numbers are checked against their ranges,
 * cells against the design. */
#include "internal.h"
#include "measurement_rows.h"
#include "segcast/json_values.h"

#include <jansson.h>

/* A study of the largest design measured a thousand times writes less. */
enum { FILE_MAX_MIB = 1024 };
#define REAL_MOST 1e15
enum { AXES_MAX = 64, CELLS_MAX = 1000000, LONGEST_RUN = 1000000 };

/* ---- values; false: missing, of another type or out of range ---- */

static bool read_row(const json_t *value, const sc_measurement_row *row, sc_measurement *item)
{
    void *at = (char *)item + row->offset;

    switch (row->type) {
    case SC_ROW_INT:
        return sc_json_int(value, 0, INT32_MAX, at);
    case SC_ROW_COUNT:
        return sc_json_count(value, at);
    case SC_ROW_TIME:
        *(int64_t *)at = json_integer_value(value);
        return json_is_integer(value) && json_integer_value(value) >= 0;
    case SC_ROW_HASH:
        return sc_json_hash(value, at);
    case SC_ROW_SECONDS:
        return sc_json_real(value, 0, REAL_MOST, at);
    case SC_ROW_REAL: /* -1: it cannot be read here */
        return sc_json_real(value, -1, REAL_MOST, at);
    }
    return false;
}

/* @return whether the object holds a measurement of a cell of the design. */
static bool read_measurement(const json_t *object, int cells, sc_measurement *out)
{
    for (const sc_measurement_row *row = sc_measurement_rows; row->name; row++) {
        if (!read_row(json_object_get(object, row->name), row, out))
            return false;
    }
    return out->cell < cells && out->passes > 0 && out->frames > 0 && out->ranks > 0 &&
           out->threads > 0;
}

static bool read_run(const json_t *object, sc_study_run *out)
{
    *out = (sc_study_run){0};
    for (const sc_run_text *text = sc_run_texts; text->name; text++) {
        const char *value = json_string_value(json_object_get(object, text->name));

        (void)sc_copy_name(value ? value : "", (char *)out + text->offset, text->bytes);
    }
    return json_is_object(object) &&
           sc_json_int(json_object_get(object, "ranks"), 1, LONGEST_RUN, &out->ranks) &&
           sc_json_int(json_object_get(object, "nodes"), 1, LONGEST_RUN, &out->nodes) &&
           sc_json_int(json_object_get(object, "cores"), 1, LONGEST_RUN, &out->cores);
}

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
        *good = read_run(json_object_get(line, "run"), &run);
        if (*good)
            SC_PASS(sc_keep_made_from(ctx, json_object_get(line, "run"), &run.made_from));
        return *good ? sc_measurements_add_run(ctx, out, &run) : SC_OK;
    }
    if (skipped) {
        *good = reason && sc_json_int(json_object_get(skipped, "cell"), 0, cells - 1, &cell);
        return *good ? sc_measurements_skip(ctx, out, cell, reason) : SC_OK;
    }
    *good = read_measurement(json_object_get(line, "measurement"), cells, &item);
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
