/* SPDX-License-Identifier: BSD-3-Clause */
/* Check the values of options and store them; settings of the job that options make. */
#include "option_values.h"

#include "segcast/timeline.h"

#include <errno.h>
#include <stdlib.h>

/* ---- settings of the job ---- */

/* Keep @p text until the options are cleared; takes ownership of it, also after an error. @param
 * out its characters. */
static sc_status own(const sc_ctx *ctx, sc_options *options, sc_text *text, const char **out)
{
    if (options->owned.count == SC_SETTINGS_MAX) {
        sc_text_clear(text);
        return sc_fail(ctx, SC_ERR_USAGE, "more than %d settings", SC_SETTINGS_MAX);
    }
    options->owned.all[options->owned.count++] = text->data;
    *out = text->data;
    return SC_OK;
}

/* Keep a copy of the first @p length characters of @p from until the options are cleared. */
static sc_status copy(const sc_ctx *ctx, sc_options *options, const char *from, size_t length,
                      const char **out)
{
    sc_text text = {0};

    SC_PASS(sc_text_add(ctx, &text, "%.*s", (int)length, from));
    return own(ctx, options, &text, out);
}

/* Append a setting, whose texts stay borrowed. */
static sc_status add_setting(const sc_ctx *ctx, sc_options *options, sc_setting setting)
{
    if (options->settings.count == SC_SETTINGS_MAX)
        return sc_fail(ctx, SC_ERR_USAGE, "more than %d settings", SC_SETTINGS_MAX);
    options->settings.all[options->settings.count++] = setting;
    return SC_OK;
}

sc_status sc_options_set_as(const sc_ctx *ctx, sc_options *options, const char *origin,
                            const char *key, const char *value)
{
    sc_setting setting = {.literal = true};

    SC_PASS(copy(ctx, options, key, strlen(key), &setting.path));
    SC_PASS(copy(ctx, options, value, strlen(value), &setting.value));
    setting.origin = setting.path;
    if (origin)
        SC_PASS(copy(ctx, options, origin, strlen(origin), &setting.origin));
    return add_setting(ctx, options, setting);
}

sc_status sc_options_set_text(const sc_ctx *ctx, sc_options *options, const char *key,
                              const char *value)
{
    return sc_options_set_as(ctx, options, NULL, key, value);
}

sc_status sc_options_default(const sc_ctx *ctx, sc_options *options, const char *key,
                             const char *value)
{
    if (options->settings.default_count == SC_COUNT_OF(options->settings.defaults))
        return sc_fail(ctx, SC_ERR_INTERNAL, "a command sets more than %zu defaults",
                       SC_COUNT_OF(options->settings.defaults));
    options->settings.defaults[options->settings.default_count++] =
        (sc_setting){.origin = key, .path = key, .value = value};
    return SC_OK;
}

/* ---- values ---- */

sc_status sc_store_key(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                       const char *value)
{
    sc_setting setting = {.value = value, .literal = true};
    sc_text origin = {0};

    SC_PASS(sc_text_add(ctx, &origin, "--%s %s", option->name, value));
    SC_PASS(own(ctx, options, &origin, &setting.origin));
    SC_PASS(copy(ctx, options, option->key, strlen(option->key), &setting.path));
    return add_setting(ctx, options, setting);
}

sc_status sc_store_set(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                       const char *value)
{
    sc_setting setting = {.origin = value};
    const char *equals = value;
    bool quoted = false;
    sc_status status;

    while (*equals && (quoted || *equals != '=')) {
        quoted ^= *equals == '"';
        equals++;
    }
    if (!*equals)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected KEY.PATH=VALUE, for example render.quality=still; "
                       "`segcast help keys` lists all",
                       option->name, value);
    setting.value = equals + 1;
    status = copy(ctx, options, value, (size_t)(equals - value), &setting.path);
    return status == SC_OK ? add_setting(ctx, options, setting) : status;
}

/* Read a whole number from @p low to @p high. @param name what messages call it. */
static sc_status read_number(const sc_ctx *ctx, const char *name, const char *value, long low,
                             long high, long *out)
{
    char *end;
    long number;

    errno = 0;
    number = strtol(value, &end, 10);
    if (end == value || *end || errno || number < low || number > high)
        return sc_fail(ctx, SC_ERR_USAGE, "%s is \"%s\", expected a whole number from %ld to %ld",
                       name, value, low, high);
    *out = number;
    return SC_OK;
}

sc_status sc_options_set_threads(const sc_ctx *ctx, sc_options *options, const char *name,
                                 const char *value)
{
    long threads = 0;

    SC_PASS(read_number(ctx, name, value, 1, 4096, &threads));
    options->limits.threads = (int)threads;
    return SC_OK;
}

sc_status sc_store_threads(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                           const char *value)
{
    return sc_options_set_threads(ctx, options, "--threads", value);
}

sc_status sc_store_count(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value)
{
    char name[32];
    long number = 0;

    snprintf(name, sizeof name, "--%s", option->name);
    SC_PASS(read_number(ctx, name, value, 1, 65536, &number));
    memcpy((char *)options + option->offset, &(int){(int)number}, sizeof(int));
    return SC_OK;
}

sc_status sc_options_set_max_memory(const sc_ctx *ctx, sc_options *options, const char *name,
                                    const char *value)
{
    static const char units[] = "KMGT";
    char *end;
    double bytes = strtod(value, &end);
    const char *unit = *end ? strchr(units, *end) : NULL;

    if (unit) {
        for (const char *u = units; u <= unit; u++)
            bytes *= 1024;
        end++;
        end += !strcmp(end, "iB") ? 2 : !strcmp(end, "B") ? 1 : 0;
    }
    if (end == value || *end || !(bytes >= 1 && bytes <= 1e18))
        return sc_fail(ctx, SC_ERR_USAGE, "%s is \"%s\", expected a size such as 8G or 500M", name,
                       value);
    options->limits.max_memory_bytes = (uint64_t)bytes;
    return SC_OK;
}

sc_status sc_store_max_memory(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                              const char *value)
{
    return sc_options_set_max_memory(ctx, options, "--max-memory", value);
}

sc_status sc_store_frame(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value)
{
    return read_number(ctx, "--frame", value, 0, 1000000, &options->still.frame);
}

static const char *const views[] = {"anterior", "posterior", "left",   "right",   "superior",
                                    "inferior", "45,20",     "135,20", "-135,20", "-45,20"};
static const char *const look_names[] = {"plain", "studio", "cinematic", "atlas", "xray"};
static const sc_sheet sheets[] = {{"views", "view", views, SC_COUNT_OF(views)},
                                  {"looks", "look", look_names, SC_COUNT_OF(look_names)}};

/* @return the angles of an orbit, around the patient and above, that a value of --view stands for:
 * of a word those at which the camera stands on that side, in @p room, else the value. */
static const char *find_angles(const char *view, char room[16])
{
    sc_vec3 side;

    if (!sc_anatomical_direction(view, &side))
        return view;
    snprintf(room, 16, "%d,%d", side.y < 0 ? 180 : (int)(-90 * side.x), (int)(90 * side.z));
    return room;
}

/* Append a shot of a sheet, for the value @p word of its option. */
static sc_status add_shot(const sc_ctx *ctx, const sc_sheet *sheet, const char *word, sc_text *out)
{
    char room[16];
    const char *angles = find_angles(word, room), *comma = strchr(angles, ',');

    if (strcmp(sheet->option, "view") != 0)
        return sc_text_add(ctx, out, "{%s: %s}", sheet->option, word);
    return sc_text_add(ctx, out,
                       "{animation: {camera: {orbit: {turns: 0, angle: %.*s, elevation: %s}}}}",
                       (int)(comma - angles), angles, comma + 1);
}

/* Let the job be a film of one shot for each picture of a sheet. */
static sc_status set_shots(const sc_ctx *ctx, sc_options *options, const sc_option *option)
{
    const sc_sheet *sheet = options->still.sheet;
    const char *value = NULL;
    SC_OWN(sc_text_clear) sc_text shots = {0};

    for (int i = 0; i < sheet->count; i++) {
        SC_PASS(sc_text_add(ctx, &shots, "%s", i ? ", " : "shots=["));
        SC_PASS(add_shot(ctx, sheet, sheet->words[i], &shots));
    }
    SC_PASS(sc_text_add(ctx, &shots, "]"));
    SC_PASS(own(ctx, options, &shots, &value));
    shots.data = NULL; /* the options have it */
    SC_PASS(sc_store_set(ctx, options, option, value));
    options->settings.all[options->settings.count - 1].origin = "--sheet";
    return SC_OK;
}

sc_status sc_store_sheet(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value)
{
    char *end;
    const long count = strtol(value, &end, 10);

    options->still.slices = !strcmp(value, "slices");
    options->still.sheet = NULL;
    for (size_t i = 0; i < SC_COUNT_OF(sheets); i++)
        options->still.sheet = strcmp(value, sheets[i].name) ? options->still.sheet : &sheets[i];
    options->still.pictures = options->still.sheet ? options->still.sheet->count : 0;
    if (options->still.slices)
        return SC_OK;
    if (options->still.sheet)
        return set_shots(ctx, options, option);
    if (end == value || *end || count < 1 || count > SC_PICTURES_MAX)
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "--%s is \"%s\", expected a whole number from 1 to %d, views, looks or slices",
            option->name, value, SC_PICTURES_MAX);
    options->still.pictures = (int)count;
    return SC_OK;
}

sc_status sc_store_view(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                        const char *value)
{
    size_t count;
    const char *const *words = sc_anatomical_words(&count);
    const char *const nearest = sc_nearest_word(value, words, count);
    char room[16];
    const char *angles = find_angles(value, room), *comma = strchr(angles, ','), *start = NULL;
    SC_OWN(sc_text_clear) sc_text origin = {0};

    if (!comma)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected anterior, posterior, left, right, superior, "
                       "inferior, or two angles such as 30,15%s%s%s",
                       option->name, value, nearest ? "; did you mean \"" : "",
                       nearest ? nearest : "", nearest ? "\"?" : "");
    SC_PASS(copy(ctx, options, angles, (size_t)(comma - angles), &start));
    SC_PASS(sc_text_add(ctx, &origin, "--%s %s", option->name, value));
    SC_PASS(sc_options_set_as(ctx, options, origin.data, "animation.camera.orbit.angle", start));
    return sc_options_set_as(ctx, options, origin.data, "animation.camera.orbit.elevation",
                             comma + 1);
}

sc_status sc_store_framed(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value)
{
    /* So faint that ten layers before the tissue take a third of it away, and still seen. */
    static const char faint[] = "0.04";
    SC_OWN(sc_text_clear) sc_text origin = {0};
    SC_OWN(sc_text_clear) sc_text path = {0};

    SC_PASS(sc_text_add(ctx, &origin, "--%s %s", option->name, value));
    SC_PASS(sc_text_add(ctx, &path, "tissues.\"%s\".opacity", value));
    SC_PASS(sc_options_set_as(ctx, options, origin.data, "animation.verbs.0.frame", value));
    SC_PASS(sc_store_set(ctx, options, option, "animation.verbs.0.during=[0%, 0%]"));
    SC_PASS(sc_options_set_as(ctx, options, origin.data, "tissues.*.opacity", faint));
    return sc_options_set_as(ctx, options, origin.data, path.data, "1");
}

sc_status sc_store_text(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                        const char *value)
{
    memcpy((char *)options + option->offset, &value, sizeof value);
    return SC_OK;
}

sc_status sc_store_frames(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value)
{
    int *frames = NULL, count;
    const sc_status status = sc_frames_parse(ctx, value, SC_JOB_FRAMES_MAX, &frames, &count);

    sc_free(frames); /* which of them the job has, it alone knows */
    return status == SC_OK ? sc_store_text(ctx, options, option, value) : status;
}

sc_status sc_check_tilde(const sc_ctx *ctx, const char *what, const char *path)
{
    const char *home = getenv("HOME");

    if (path[0] != '~' || (path[1] && path[1] != '/'))
        return SC_OK;
    return sc_fail(ctx, SC_ERR_USAGE,
                   "%s is \"%s\", but only a shell replaces \"~\", and only outside of quotes and "
                   "at the beginning of a word; write %s%s",
                   what, path, home ? home : "$HOME", path + 1);
}

sc_status sc_store_output(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value)
{
    char what[64];
    sc_status status;

    if (!value[0])
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is empty, expected %s; is a variable of the script not set?",
                       option->name, option->argument);
    snprintf(what, sizeof what, "--%s", option->name);
    status = sc_check_tilde(ctx, what, value);
    return status == SC_OK ? sc_store_text(ctx, options, option, value) : status;
}

sc_status sc_store_flag(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                        const char *value)
{
    const bool set = true;

    memcpy((char *)options + option->offset, &set, sizeof set);
    return SC_OK;
}

sc_status sc_store_slice(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value)
{
    int slice, slices, used = 0;

    if (sscanf(value, "%d/%d%n", &slice, &slices, &used) != 2 || value[used] || slice < 0 ||
        slice >= slices || slices > 1000000)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected I/N with I from 0 to N - 1, for example 0/4",
                       option->name, value);
    options->part.slice = slice;
    options->part.slices = slices;
    return SC_OK;
}

/* Read a time as sc_parse_seconds. @return false if it is none, or longer than all films and runs.
 */
static bool read_seconds(const char *value, double *out)
{
    return sc_parse_seconds(value, out) && *out <= 1e8;
}

sc_status sc_store_time_limit(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                              const char *value)
{
    double seconds;

    if (!read_seconds(value, &seconds))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected seconds, MM:SS or HH:MM:SS, with two digits up to "
                       "59 behind each colon",
                       option->name, value);
    options->part.time_limit_s = seconds > 0 ? seconds : 1e-3;
    return SC_OK;
}

sc_status sc_store_moment(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value)
{
    char *end;
    const double percent = strtod(value, &end);

    if (end != value && !strcmp(end, "%") && percent >= 0 && percent <= 100) {
        options->still.moment = SC_MOMENT_SHARE;
        options->still.moment_at = percent / 100;
        return SC_OK;
    }
    if (!read_seconds(value, &options->still.moment_at))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected seconds, MM:SS, HH:MM:SS, or a share of the film "
                       "from 0%% to 100%%; behind each colon there are two digits, up to 59",
                       option->name, value);
    options->still.moment = SC_MOMENT_SECONDS;
    return SC_OK;
}
