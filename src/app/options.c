/* SPDX-License-Identifier: BSD-3-Clause */
/* GNU-style options of all commands in one table. */
#include "app.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

typedef struct option_row option_row;
struct option_row {
    const char *name;
    char letter;
    const char *argument; /* NULL: none */
    const char *help;
    const char *commands; /* that take it */
    sc_status (*take)(const sc_ctx *ctx, sc_options *options, const option_row *row,
                      const char *value);
    const char *key; /* of the job, for options that are short for --set */
    size_t place;    /* in sc_options, for take_text and take_flag */
};

static sc_status add_setting(const sc_ctx *ctx, sc_options *options, const char *setting)
{
    if (options->setting_count == SC_SETTINGS_MAX)
        return sc_fail(ctx, SC_ERR_USAGE, "more than %d settings", SC_SETTINGS_MAX);
    options->settings[options->setting_count++] = setting;
    return SC_OK;
}

static sc_status add_owned(const sc_ctx *ctx, sc_options *options, sc_text *text)
{
    if (options->owned_count == SC_SETTINGS_MAX) {
        sc_text_clear(text);
        return sc_fail(ctx, SC_ERR_USAGE, "more than %d settings", SC_SETTINGS_MAX);
    }
    options->owned[options->owned_count++] = text->data;
    return add_setting(ctx, options, text->data);
}

sc_status sc_options_set_text(const sc_ctx *ctx, sc_options *options, const char *key,
                              const char *value)
{
    sc_text text = {0};
    sc_status status;

    SC_TRY(sc_text_add(ctx, &text, "%s='", key));
    for (const char *c = value; *c; c++) /* a quote within quotes is doubled */
        SC_TRY(sc_text_add(ctx, &text, *c == '\'' ? "'%c" : "%c", *c));
    SC_TRY(sc_text_add(ctx, &text, "'"));
    return add_owned(ctx, options, &text);
out:
    sc_text_clear(&text);
    return status;
}

sc_status sc_options_set(const sc_ctx *ctx, sc_options *options, const char *key, const char *value)
{
    sc_text text = {0};
    sc_status status = sc_text_add(ctx, &text, "%s=%s", key, value);

    if (status == SC_OK)
        return add_owned(ctx, options, &text);
    sc_text_clear(&text);
    return status;
}

static sc_status take_key(const sc_ctx *ctx, sc_options *options, const option_row *row,
                          const char *value)
{
    return sc_options_set_text(ctx, options, row->key, value);
}

static sc_status take_set(const sc_ctx *ctx, sc_options *options, const option_row *row,
                          const char *value)
{
    (void)row;
    return add_setting(ctx, options, value);
}

static sc_status take_number(const sc_ctx *ctx, const option_row *row, const char *value, long low,
                             long high, long *out)
{
    char *end;
    long number;

    errno = 0;
    number = strtol(value, &end, 10);
    if (end == value || *end || errno || number < low || number > high)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected a whole number from %ld to "
                       "%ld",
                       row->name, value, low, high);
    *out = number;
    return SC_OK;
}

static sc_status take_threads(const sc_ctx *ctx, sc_options *options, const option_row *row,
                              const char *value)
{
    long threads = 0;
    sc_status status = take_number(ctx, row, value, 1, 4096, &threads);

    if (status == SC_OK)
        options->threads = (int)threads;
    return status;
}

static sc_status take_frame(const sc_ctx *ctx, sc_options *options, const option_row *row,
                            const char *value)
{
    return take_number(ctx, row, value, 0, 1000000, &options->frame);
}

static sc_status take_text(const sc_ctx *ctx, sc_options *options, const option_row *row,
                           const char *value)
{
    (void)ctx;
    memcpy((char *)options + row->place, &value, sizeof value);
    return SC_OK;
}

static sc_status take_flag(const sc_ctx *ctx, sc_options *options, const option_row *row,
                           const char *value)
{
    const bool set = true;

    (void)ctx;
    (void)value;
    memcpy((char *)options + row->place, &set, sizeof set);
    return SC_OK;
}

/* I/N: part I of N, counted from 0. */
static sc_status take_slice(const sc_ctx *ctx, sc_options *options, const option_row *row,
                            const char *value)
{
    int slice, slices, used = 0;

    if (sscanf(value, "%d/%d%n", &slice, &slices, &used) != 2 || value[used] || slice < 0 ||
        slice >= slices || slices > 1000000)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected I/N with I from 0 to N - 1, for example 0/4",
                       row->name, value);
    options->slice = slice;
    options->slices = slices;
    return SC_OK;
}

static sc_status take_picture_size(const sc_ctx *ctx, sc_options *options, const option_row *row,
                                   const char *value)
{
    int width, height, used = 0;
    sc_text text = {0};
    sc_status status;

    if (sscanf(value, "%dx%d%n", &width, &height, &used) != 2 || value[used])
        return sc_fail(ctx, SC_ERR_USAGE, "--%s is \"%s\", expected for example 1280x720",
                       row->name, value);
    status = sc_text_add(ctx, &text, "output.size=[%d, %d]", width, height);
    return status == SC_OK ? add_owned(ctx, options, &text) : status;
}

static sc_status take_point(const sc_ctx *ctx, sc_options *options, const option_row *row,
                            const char *value)
{
    double x, y, z;
    int used = 0;
    sc_text text = {0};
    sc_status status;

    if (sscanf(value, "%lf,%lf,%lf%n", &x, &y, &z, &used) != 3 || value[used])
        return sc_fail(ctx, SC_ERR_USAGE, "--%s is \"%s\", expected for example 12.5,-40,210",
                       row->name, value);
    status = sc_text_add(ctx, &text, "animation.slices.point_mm=[%s]", value);
    return status == SC_OK ? add_owned(ctx, options, &text) : status;
}

/* Seconds, MM:SS or HH:MM:SS. */
static sc_status take_time_limit(const sc_ctx *ctx, sc_options *options, const option_row *row,
                                 const char *value)
{
    double seconds = 0;
    const char *at = value;
    int parts = 0;
    char *end;

    for (;;) {
        const double part = strtod(at, &end);

        if (end == at || !(part >= 0 && part <= 1e8) || ++parts > 3 || (*end && *end != ':'))
            return sc_fail(ctx, SC_ERR_USAGE, "--%s is \"%s\", expected seconds, MM:SS or HH:MM:SS",
                           row->name, value);
        seconds = 60 * seconds + part;
        if (!*end)
            break;
        at = end + 1;
    }
    options->time_limit_s = seconds > 0 ? seconds : 1e-3;
    return SC_OK;
}

#define JOBS "render check plan still orbit views"

static const option_row rows[] = {
    {"output", 'o', "DIR", "folder for everything the job makes", "render", take_text, NULL,
     offsetof(sc_options, output)},
    {"output", 'o', "FILE", "the file to write", "still orbit phantom views prepare", take_text,
     NULL, offsetof(sc_options, output)},
    {"frames", 0, "0-35:2,40", "only these frames of the animation", "render", take_text, NULL,
     offsetof(sc_options, frames)},
    {"resume", 0, NULL, "go on with what the folder holds of this job, after proving it", "render",
     take_flag, NULL, offsetof(sc_options, resume)},
    {"overwrite", 0, NULL, "begin anew in a folder that holds a run", "render", take_flag, NULL,
     offsetof(sc_options, overwrite)},
    {"time-limit", 0, "HH:MM:SS", "stop in order before so much time is over, exit 75", "render",
     take_time_limit, NULL, 0},
    {"slice", 0, "I/N", "only part I of N, counted from 0: for job arrays that share the folder",
     "render", take_slice, NULL, 0},
    {"frame", 0, "K", "number of the frame to draw", "still", take_frame, NULL, 0},
    {"set", 0, "KEY.PATH=VALUE", "set a key of the job; may be repeated", JOBS " prepare", take_set,
     NULL, 0},
    {"labels", 0, "FILE", "label table with names and colours", "orbit views info prepare",
     take_key, "labels", 0},
    {"labels-format", 0, "NAME", "slicer, freesurfer or itksnap", "orbit views info prepare",
     take_key, "labels_format", 0},
    {"size", 0, "WxH", "size of the picture", "orbit views", take_picture_size, NULL, 0},
    {"size", 0, "WxDxH", "voxels along each axis (469x325x487)", "phantom", take_text, NULL,
     offsetof(sc_options, size)},
    {"frames", 0, "N", "number of frames of the turn", "orbit", take_key, "animation.frames", 0},
    {"fps", 0, "N", "frames per second", "orbit", take_key, "output.fps", 0},
    {"axis", 0, "WORD", "axis of the turn, such as superior", "orbit", take_key,
     "animation.camera.orbit.axis", 0},
    {"elevation", 0, "DEGREES", "height of the camera above the turn's plane", "orbit", take_key,
     "animation.camera.orbit.elevation", 0},
    {"turns", 0, "N", "number of turns", "orbit", take_key, "animation.camera.orbit.turns", 0},
    {"zoom", 0, "FACTOR", "scale of the picture", "orbit", take_key, "animation.camera.zoom", 0},
    {"samples", 0, "N", "rays per pixel on edges, 1 to 8", "orbit views", take_key,
     "render.samples", 0},
    {"point", 0, "R,A,S", "where the slices cross, in mm", "views", take_point, NULL, 0},
    {"cpu", 0, "NAME", "kernels for auto, avx512, avx2, sse4 or c (plain C); same pictures", JOBS,
     take_key, "render.cpu", 0},
    {"json", 0, NULL, "for machines", "info", take_flag, NULL, offsetof(sc_options, json)},
    {"threads", 0, "N", "threads of each rank", JOBS " info phantom prepare join verify",
     take_threads, NULL, 0},
    {"quiet", 'q', NULL, "errors and warnings only", JOBS " info phantom prepare join verify",
     take_flag, NULL, offsetof(sc_options, quiet)},
};

static bool takes(const option_row *row, const char *command)
{
    const char *found = strstr(row->commands, command);
    const size_t length = strlen(command);

    return found && (found == row->commands || found[-1] == ' ') &&
           (found[length] == '\0' || found[length] == ' ');
}

static const option_row *find_row(const sc_command *command, const char *name, size_t length,
                                  char letter)
{
    for (size_t i = 0; i < SC_COUNT_OF(rows); i++) {
        if (!takes(&rows[i], command->name))
            continue;
        if (letter ? rows[i].letter == letter
                   : strlen(rows[i].name) == length && !strncmp(rows[i].name, name, length))
            return &rows[i];
    }
    return NULL;
}

static void print_options(const sc_command *command)
{
    printf("usage: segcast %s %s [options]\n%s\n\n", command->name, command->arguments,
           command->help);
    for (size_t i = 0; i < SC_COUNT_OF(rows); i++) {
        char left[64];

        if (!takes(&rows[i], command->name))
            continue;
        snprintf(left, sizeof left, "%c%c--%s%s%s", rows[i].letter ? '-' : ' ',
                 rows[i].letter ? rows[i].letter : ' ', rows[i].name, rows[i].argument ? " " : "",
                 rows[i].argument ? rows[i].argument : "");
        printf("  %.2s%s %-26s %s\n", left, rows[i].letter ? "," : " ", left + 2, rows[i].help);
    }
}

static sc_status unknown_option(const sc_ctx *ctx, const sc_command *command, const char *text)
{
    const char *names[SC_COUNT_OF(rows)], *nearest;

    for (size_t i = 0; i < SC_COUNT_OF(rows); i++)
        names[i] = takes(&rows[i], command->name) ? rows[i].name : NULL;
    nearest = sc_nearest_word(text + strspn(text, "-"), names, SC_COUNT_OF(rows));
    return sc_fail(ctx, SC_ERR_USAGE, "unknown option %s; %s%s%s", text,
                   nearest ? "did you mean --" : "try --help", nearest ? nearest : "",
                   nearest ? "?" : "");
}

/* One argument; @return how many words of argv it used, or 0 with *status set. */
static int parse_argument(const sc_ctx *ctx, const sc_command *command, char **argv,
                          sc_options *out, sc_status *status)
{
    const char *text = argv[0], *equals = strchr(text, '='), *value = NULL;
    const option_row *row;
    int used = 1;

    if (text[0] != '-' || !text[1]) {
        *status = out->input || !command->arguments[0]
                      ? sc_fail(ctx, SC_ERR_USAGE, "unexpected argument \"%s\"", text)
                      : SC_OK;
        out->input = text;
        return *status == SC_OK ? 1 : 0;
    }
    if (text[1] == '-')
        row =
            find_row(command, text + 2, equals ? (size_t)(equals - text - 2) : strlen(text + 2), 0);
    else
        row = text[2] ? NULL : find_row(command, NULL, 0, text[1]);
    if (!row) {
        *status = unknown_option(ctx, command, text);
        return 0;
    }
    if (row->argument) {
        value = equals && text[1] == '-' ? equals + 1 : argv[1];
        used = equals && text[1] == '-' ? 1 : 2;
        if (!value) {
            *status =
                sc_fail(ctx, SC_ERR_USAGE, "--%s needs a value: %s", row->name, row->argument);
            return 0;
        }
    }
    *status = row->take(ctx, out, row, value);
    return *status == SC_OK ? used : 0;
}

sc_status sc_options_parse(const sc_ctx *ctx, const sc_command *command, int argc, char **argv,
                           bool speak, sc_options *out, bool *help)
{
    const char *threads = getenv("SEGCAST_THREADS");
    sc_options options = {.frame = -1};
    sc_status status = SC_OK;

    if (threads) {
        const option_row row = {.name = "threads (SEGCAST_THREADS)"};

        SC_TRY(take_threads(ctx, &options, &row, threads));
    }
    for (int i = 2; i < argc;) {
        int used;

        if (!strcmp(argv[i], "--help")) {
            if (speak)
                print_options(command);
            *help = true;
            break;
        }
        used = parse_argument(ctx, command, argv + i, &options, &status);
        if (!used)
            goto out;
        i += used;
    }
    if (!*help && command->arguments[0] && !options.input) {
        status =
            sc_fail(ctx, SC_ERR_USAGE, "segcast %s needs %s", command->name, command->arguments);
        goto out;
    }
    *out = options;
    return SC_OK;
out:
    sc_options_clear(&options);
    return status;
}

void sc_options_clear(sc_options *options)
{
    for (size_t i = 0; i < options->owned_count; i++)
        sc_free(options->owned[i]);
    *options = (sc_options){0};
}
