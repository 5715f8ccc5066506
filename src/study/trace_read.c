/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads a trace.json back. It may hold a million events, so each line, which is one of them, is
 * parsed by itself. Nothing in it is trusted. */
#include "segcast/json_values.h"
#include "segcast/study.h"

#include <errno.h>
#include <sys/stat.h>

/* The longest line that sc_trace_write writes is far shorter: it names a host. */
enum { LINE_BYTES = 1024 };

/* Read a number of microseconds as seconds. */
static bool read_us(const json_t *event, const char *key, double *out)
{
    const bool good = sc_json_real(json_object_get(event, key), 0, 1e18, out);

    *out /= 1e6;
    return good;
}

/* @return the kind of event with which the name begins, or -1. */
static int kind_of(const char *name)
{
    const size_t length = name ? strcspn(name, " ") : 0;

    for (int kind = 0; kind < SC_TRACE_KIND_COUNT; kind++) {
        if (strlen(sc_trace_kind_name(kind)) == length &&
            !strncmp(name, sc_trace_kind_name(kind), length))
            return kind;
    }
    return -1;
}

/* Read an event. Those that name ranks and threads have another "ph", and are passed over.
 * @return false if it is neither. */
static bool read_event(const json_t *json, sc_trace_fn *each, void *user)
{
    const char *ph = json_string_value(json_object_get(json, "ph"));
    const json_t *frame = json_object_get(json_object_get(json, "args"), "frame");
    sc_trace_event event = {.frame = -1};
    int pid, tid, number = -1;

    if (!ph || strcmp(ph, "X") != 0)
        return ph && !strcmp(ph, "M");
    event.kind = (int16_t)kind_of(json_string_value(json_object_get(json, "name")));
    if (event.kind < 0 || !sc_json_int(json_object_get(json, "pid"), 1, INT32_MAX, &pid) ||
        !sc_json_int(json_object_get(json, "tid"), 1, INT16_MAX, &tid) ||
        !read_us(json, "ts", &event.begin_s) || !read_us(json, "dur", &event.duration_s) ||
        (frame && !sc_json_int(frame, 0, INT32_MAX, &number)))
        return false;
    event.frame = number;
    event.thread = (int16_t)(tid - 1);
    each(user, pid - 1, &event);
    return true;
}

/* Read a line of the array of events, without its comma. */
static bool read_line(char *line, sc_trace_fn *each, void *user)
{
    size_t length = strcspn(line, "\n");
    json_t *json;
    bool good;

    if (!strncmp(line, "{\"displayTimeUnit\"", 18) || line[0] == ']' || length == 0)
        return true; /* what stands around the events */
    length -= line[length - 1] == ',';
    json = json_loadb(line, length, 0, NULL);
    good = json && read_event(json, each, user);
    json_decref(json);
    return good;
}

sc_status sc_trace_read(const sc_ctx *ctx, const char *path, sc_trace_fn *each, void *user)
{
    char line[LINE_BYTES] = "";
    struct stat info;
    FILE *stream = NULL;
    int number = 0;
    bool good = true;
    sc_status status = SC_OK;

    if (stat(path, &info) || (S_ISREG(info.st_mode) && !(stream = fopen(path, "r"))))
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be opened: %s", path,
                       sc_reason(errno));
    if (!stream) /* opening a pipe would wait for its writer */
        return sc_fail(ctx, SC_ERR_MISSING, "%s: is not a file", path);
    while (good && fgets(line, sizeof line, stream)) {
        number++;
        good = read_line(line, each, user);
    }
    if (!good)
        status = sc_fail(ctx, SC_ERR_DATA, "%s:%d: is damaged: it is not a line of a trace", path,
                         number);
    else if (ferror(stream) || line[0] != ']')
        status = sc_fail(ctx, SC_ERR_DATA, "%s: is damaged: its end is missing", path);
    fclose(stream);
    return status;
}
