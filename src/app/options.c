/* SPDX-License-Identifier: BSD-3-Clause */
/* The options of all commands in one table, read by getopt_long. */
#include "options.h"

#include <errno.h>
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

/* ---- settings of the job ---- */

/* Keep @p text until the options are cleared; takes ownership of it, also after an error. @param
 * out its characters. */
static sc_status own(const sc_ctx *ctx, sc_options *options, sc_text *text, const char **out)
{
    if (options->owned_count == SC_SETTINGS_MAX) {
        sc_text_clear(text);
        return sc_fail(ctx, SC_ERR_USAGE, "more than %d settings", SC_SETTINGS_MAX);
    }
    options->owned[options->owned_count++] = text->data;
    *out = text->data;
    return SC_OK;
}

/* Keep a copy of the first @p length characters of @p from until the options are cleared. */
static sc_status copy(const sc_ctx *ctx, sc_options *options, const char *from, size_t length,
                      const char **out)
{
    sc_text text = {0};
    sc_status status = sc_text_add(ctx, &text, "%.*s", (int)length, from);

    if (status == SC_OK)
        return own(ctx, options, &text, out);
    sc_text_clear(&text);
    return status;
}

/* Append a setting, whose texts stay borrowed. */
static sc_status add_setting(const sc_ctx *ctx, sc_options *options, sc_setting setting)
{
    if (options->setting_count == SC_SETTINGS_MAX)
        return sc_fail(ctx, SC_ERR_USAGE, "more than %d settings", SC_SETTINGS_MAX);
    options->settings[options->setting_count++] = setting;
    return SC_OK;
}

/* Append a setting with copies of both texts. Messages name its key. @param literal see sc_setting.
 */
static sc_status add_copy(const sc_ctx *ctx, sc_options *options, const char *key,
                          const char *value, bool literal)
{
    sc_setting setting = {.literal = literal};
    sc_status status;

    SC_TRY(copy(ctx, options, key, strlen(key), &setting.path));
    SC_TRY(copy(ctx, options, value, strlen(value), &setting.value));
    setting.origin = setting.path;
    status = add_setting(ctx, options, setting);
out:
    return status;
}

sc_status sc_options_set_text(const sc_ctx *ctx, sc_options *options, const char *key,
                              const char *value)
{
    return add_copy(ctx, options, key, value, true);
}

sc_status sc_options_set(const sc_ctx *ctx, sc_options *options, const char *key, const char *value)
{
    return add_copy(ctx, options, key, value, false);
}

sc_status sc_options_default(const sc_ctx *ctx, sc_options *options, const char *key,
                             const char *value)
{
    if (options->default_count == SC_COUNT_OF(options->defaults))
        return sc_fail(ctx, SC_ERR_INTERNAL, "a command sets more than %zu defaults",
                       SC_COUNT_OF(options->defaults));
    options->defaults[options->default_count++] =
        (sc_setting){.origin = key, .path = key, .value = value};
    return SC_OK;
}

/* ---- values ---- */

/* Store the value of an option that sets a key of the job: as a setting, which messages call by the
 * option's name. */
static sc_status store_key(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                           const char *value)
{
    sc_setting setting = {.value = value, .literal = true};
    sc_text origin = {0};
    sc_status status;

    SC_TRY(sc_text_add(ctx, &origin, "--%s %s", option->name, value));
    SC_TRY(own(ctx, options, &origin, &setting.origin));
    SC_TRY(copy(ctx, options, option->key, strlen(option->key), &setting.path));
    status = add_setting(ctx, options, setting);
    return status;
out:
    sc_text_clear(&origin);
    return status;
}

/* Read KEY.PATH=VALUE. An equals sign within quotes belongs to the path. */
static sc_status store_set(const sc_ctx *ctx, sc_options *options, const sc_option *option,
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
                       "--%s is \"%s\", expected KEY.PATH=VALUE, for example "
                       "render.samples=4; `segcast keys` lists all keys",
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

/* Set the number of threads. @param name what messages call its source. */
static sc_status set_threads(const sc_ctx *ctx, sc_options *options, const char *name,
                             const char *value)
{
    long threads = 0;
    sc_status status = read_number(ctx, name, value, 1, 4096, &threads);

    if (status == SC_OK)
        options->threads = (int)threads;
    return status;
}

static sc_status store_threads(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                               const char *value)
{
    (void)option;
    return set_threads(ctx, options, "--threads", value);
}

/* Store a number of things, from 1 on, in the int at option->offset. */
static sc_status store_count(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                             const char *value)
{
    char name[32];
    long number = 0;
    int count;
    sc_status status;

    snprintf(name, sizeof name, "--%s", option->name);
    status = read_number(ctx, name, value, 1, 65536, &number);
    count = (int)number;
    if (status == SC_OK)
        memcpy((char *)options + option->offset, &count, sizeof count);
    return status;
}

/* Set the limit of memory: a number of bytes, or of K, M, G or T (powers of 1,024), such as 1.5G or
 * 64GiB. @param name what messages call its source. */
static sc_status set_max_memory(const sc_ctx *ctx, sc_options *options, const char *name,
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
    options->max_memory_bytes = (uint64_t)bytes;
    return SC_OK;
}

static sc_status store_max_memory(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                                  const char *value)
{
    (void)option;
    return set_max_memory(ctx, options, "--max-memory", value);
}

static sc_status store_frame(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                             const char *value)
{
    (void)option;
    return read_number(ctx, "--frame", value, 0, 1000000, &options->frame);
}

/* Store a number of pictures on a sheet. */
static sc_status store_pictures(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                                const char *value)
{
    long count = 0;
    char name[32];
    sc_status status;

    snprintf(name, sizeof name, "--%s", option->name);
    status = read_number(ctx, name, value, 1, SC_PICTURES_MAX, &count);
    if (status == SC_OK)
        options->pictures = (int)count;
    return status;
}

/* Store the address of the value, which is part of argv, in the member at option->offset. */
static sc_status store_text(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                            const char *value)
{
    (void)ctx;
    memcpy((char *)options + option->offset, &value, sizeof value);
    return SC_OK;
}

/* As store_text, for the path of an output, which is not empty: "~" would become the name of a
 * folder. */
static sc_status store_output(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                              const char *value)
{
    const char *home = getenv("HOME");

    if (!value[0])
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is empty, expected %s; is a variable of the script not set?",
                       option->name, option->argument);
    if (value[0] == '~' && (!value[1] || value[1] == '/'))
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "--%s is \"%s\", but only a shell replaces \"~\", and only outside of quotes "
            "and at the beginning of a word; write %s%s",
            option->name, value, home ? home : "$HOME", value + 1);
    return store_text(ctx, options, option, value);
}

/* Set the bool at option->offset. */
static sc_status store_flag(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                            const char *value)
{
    const bool set = true;

    (void)ctx;
    (void)value;
    memcpy((char *)options + option->offset, &set, sizeof set);
    return SC_OK;
}

/* Read I/N: part I of N, counted from 0. */
static sc_status store_slice(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                             const char *value)
{
    int slice, slices, used = 0;

    if (sscanf(value, "%d/%d%n", &slice, &slices, &used) != 2 || value[used] || slice < 0 ||
        slice >= slices || slices > 1000000)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected I/N with I from 0 to N - 1, for example 0/4",
                       option->name, value);
    options->slice = slice;
    options->slices = slices;
    return SC_OK;
}

/* Read seconds, MM:SS or HH:MM:SS, where the last part may have decimals. @return false if @p value
 * is anything else. */
static bool read_seconds(const char *value, double *out)
{
    double seconds = 0;
    const char *at = value;
    int parts = 0;
    char *end;

    for (;;) {
        const double part = strtod(at, &end);

        if (end == at || !(part >= 0 && part <= 1e8) || ++parts > 3 || (*end && *end != ':'))
            return false;
        seconds = 60 * seconds + part;
        if (!*end)
            break;
        at = end + 1;
    }
    *out = seconds;
    return true;
}

/* Read a time. A limit of 0 becomes a millisecond, because 0 stands for none. */
static sc_status store_time_limit(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                                  const char *value)
{
    double seconds;

    if (!read_seconds(value, &seconds))
        return sc_fail(ctx, SC_ERR_USAGE, "--%s is \"%s\", expected seconds, MM:SS or HH:MM:SS",
                       option->name, value);
    options->time_limit_s = seconds > 0 ? seconds : 1e-3;
    return SC_OK;
}

/* Read a moment of the film: a time, or a share of the film such as 50%. */
static sc_status store_moment(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                              const char *value)
{
    char *end;
    const double percent = strtod(value, &end);

    if (end != value && !strcmp(end, "%") && percent >= 0 && percent <= 100) {
        options->moment = SC_MOMENT_SHARE;
        options->moment_at = percent / 100;
        return SC_OK;
    }
    if (!read_seconds(value, &options->moment_at))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--%s is \"%s\", expected seconds, MM:SS, HH:MM:SS, or a share of the film "
                       "from 0%% to 100%%",
                       option->name, value);
    options->moment = SC_MOMENT_SECONDS;
    return SC_OK;
}

/* ---- the table ---- */

#define JOB_COMMANDS "render check plan still storyboard orbit views"
#define AT(member) offsetof(sc_options, member)

static const sc_option option_rows[] = {
    {"output", 'o', "DIR", "directory for everything the job makes", "render", store_output,
     AT(output), ""},
    {"output", 'o', "DIR", "directory for what the study measures (segcast-study)", "study",
     store_output, AT(output), ""},
    {"output", 'o', "FILE.html", "the page that compares several directories (comparison.html)",
     "report", store_output, AT(output), ""},
    {"output", 'o', "FILE", "the file to write",
     "still storyboard orbit phantom views prepare init tables", store_output, AT(output), ""},
    {"frames", 0, "LIST", "only these frames of the animation, for example 0-35:2,40",
     "render storyboard", store_text, AT(frames), ""},
    {"resume", 0, NULL, "go on with what the directory holds of this job, after verifying it",
     "render", store_flag, AT(resume), ""},
    {"overwrite", 0, NULL, "begin anew in a directory that holds a run", "render", store_flag,
     AT(overwrite), ""},
    {"overwrite", 0, NULL, "replace the file if there is one",
     "still storyboard orbit phantom views prepare report tables", store_flag, AT(overwrite), ""},
    {"resume", 0, NULL, "go on with the measurements that the directory holds of this study",
     "study", store_flag, AT(resume), ""},
    {"overwrite", 0, NULL, "begin anew in a directory that holds a study", "study", store_flag,
     AT(overwrite), ""},
    {"time-limit", 0, "HH:MM:SS", "stop in order before so much time is over, with exit code 75",
     "render study", store_time_limit, 0, ""},
    {"slice", 0, "I/N", "only part I of N, counted from 0: for job arrays that share the directory",
     "render", store_slice, 0, ""},
    {"frame", 0, "K", "number of the frame to draw", "still", store_frame, 0, ""},
    {"time", 0, "T",
     "draw the frame at this time: seconds, MM:SS, or a share of the film such as 50%", "still",
     store_moment, 0, ""},
    {"count", 0, "N", "how many frames to show, from the first to the last (12)", "storyboard",
     store_pictures, 0, ""},
    {"set", 0, "KEY.PATH=VALUE", "set a key of the job; may be repeated",
     JOB_COMMANDS " prepare study", store_set, 0, ""},
    {"size", 0, "WxDxH", "voxels along each axis (469x325x487)", "phantom", store_text, AT(size),
     ""},
    {"to", 0, "NAME",
     "format to be written: slicer, freesurfer, itksnap, xml, csv, bids, json, neuroglancer or "
     "ome-zarr (default: by the ending of the file)",
     "tables", store_text, AT(to), ""},
    {"fast", 0, NULL, "read only the header of the volume, not its voxels", "check", store_flag,
     AT(fast), ""},
    {"nodes", 0, "N",
     "nodes to tell time and memory for, like this one (1, 4 and 16; a table to 64)", "plan",
     store_count, AT(nodes), ""},
    {"ranks", 0, "N", "ranks on each node (1); with --threads N, or as many as there are cores",
     "plan", store_count, AT(ranks), ""},
    {"json", 0, NULL, "as JSON, for machines", "info keys plan calibrate status", store_flag,
     AT(json), ""},
    {"markdown", 0, NULL, "as the document docs/job.md", "keys", store_flag, AT(markdown), ""},
    {"markdown", 0, NULL, "print the tables of a study in Markdown, and make no page", "report",
     store_flag, AT(markdown), ""},
    {"schema", 0, NULL, "as a JSON schema, with which editors complete and check job files", "keys",
     store_flag, AT(schema), ""},
    {"study-schema", 0, NULL, "the same of study files", "keys", store_flag, AT(study), ""},
    {"man", 0, NULL, "as a manual page: segcast-job(5)", "keys", store_flag, AT(man), ""},
    {"man", 0, NULL, "everything as a manual page: segcast(1)", "help", store_flag, AT(man), ""},
    {"bash", 0, NULL, "completions of the command line for bash", "help", store_flag, AT(bash), ""},
    {"zsh", 0, NULL, "completions for zsh", "help", store_flag, AT(zsh), ""},
    {"fish", 0, NULL, "completions for fish", "help", store_flag, AT(fish), ""},
    {"threads", 0, "N", "threads of each rank (also SEGCAST_THREADS)",
     JOB_COMMANDS " info init phantom prepare join verify study", store_threads, 0, ""},
    {"max-memory", 0, "SIZE",
     "refuse volumes that take more memory, for example 8G (also SEGCAST_MAX_MEMORY; default: what "
     "the machine has)",
     JOB_COMMANDS " info phantom prepare study", store_max_memory, 0, ""},
    {"quiet", 'q', NULL, "errors and warnings only",
     JOB_COMMANDS " info init phantom prepare join verify status study report calibrate tables",
     store_flag, AT(quiet), ""},
    {"help", 'h', NULL, "explain the command and its options", NULL, store_flag, AT(help), ""},
    {"version", 'V', NULL, "print version, commit, compiler and libraries", NULL, store_flag,
     AT(version), ""},
};

/* Is @p command one of the names in @p commands, which spaces separate? */
static bool names_command(const char *commands, const char *command)
{
    const size_t length = strlen(command);

    for (; commands; commands = strchr(commands, ' ')) {
        commands += *commands == ' ';
        if (!strncmp(commands, command, length) &&
            (commands[length] == '\0' || commands[length] == ' '))
            return true;
    }
    return false;
}

bool sc_command_has_threads(const sc_command *command)
{
    for (size_t i = 0; i < SC_COUNT_OF(option_rows); i++) {
        if (!strcmp(option_rows[i].name, "threads"))
            return names_command(option_rows[i].commands, command->name);
    }
    return false;
}

/* Lists the options of a command. */
typedef struct lister {
    const sc_ctx *ctx;
    const char *name;     /* of the command */
    sc_option_list *list; /* rows are appended here, unless an option of that name is there */
} lister;

static sc_status add_row(const lister *l, const sc_option *row)
{
    for (size_t i = 0; i < l->list->count; i++) {
        if (!strcmp(l->list->rows[i].name, row->name))
            return SC_OK;
    }
    if (l->list->count == SC_OPTIONS_MAX)
        return sc_fail(l->ctx, SC_ERR_INTERNAL, "a command has more than %d options",
                       SC_OPTIONS_MAX);
    l->list->rows[l->list->count++] = *row;
    return SC_OK;
}

/* Append the option of a key to the list, if the command has it. For sc_job_each_key, with a lister
 * as user. */
static sc_status add_key(void *user, const sc_key_info *info)
{
    const lister *l = user;
    sc_option row = {.name = info->option,
                     .argument = info->argument,
                     .help = info->help,
                     .commands = info->commands,
                     .store = store_key};

    if (!info->option || !names_command(info->commands, l->name))
        return SC_OK;
    if (strlen(info->path) >= sizeof row.key)
        return sc_fail(l->ctx, SC_ERR_INTERNAL, "the key %s is too long for an option", info->path);
    strcpy(row.key, info->path);
    return add_row(l, &row);
}

/* Append the options of the command @p name to the list of @p l. */
static sc_status add_rows(lister *l, const char *name)
{
    sc_status status;

    l->name = name;
    SC_TRY(sc_job_each_key(l->ctx, add_key, l));
    for (size_t i = 0; i < SC_COUNT_OF(option_rows); i++) {
        if (!option_rows[i].commands || names_command(option_rows[i].commands, name))
            SC_TRY(add_row(l, &option_rows[i]));
    }
out:
    return status;
}

sc_status sc_options_list(const sc_ctx *ctx, const sc_command *command, sc_option_list *out)
{
    lister l = {.ctx = ctx, .list = out};

    out->count = 0;
    return add_rows(&l, command->name);
}

/* ---- reading ---- */

/* The value that getopt_long returns for row i of the list is FIRST_LONG + i, or the row's letter.
 */
enum { FIRST_LONG = 256 };

typedef struct getopt_tables {
    struct option longs[SC_OPTIONS_MAX + 1];
    char shorts[2 * SC_OPTIONS_MAX + 2];
} getopt_tables;

/* Make the tables that getopt_long reads. */
static void fill_tables(const sc_option_list *list, getopt_tables *out)
{
    char *letter = out->shorts;

    *letter++ = ':'; /* makes getopt_long return ':' for a missing value and '?' otherwise */
    for (size_t i = 0; i < list->count; i++) {
        const sc_option *row = &list->rows[i];

        out->longs[i] = (struct option){row->name, row->argument ? required_argument : no_argument,
                                        NULL, FIRST_LONG + (int)i};
        if (row->letter) {
            *letter++ = row->letter;
            if (row->argument)
                *letter++ = ':';
        }
    }
    *letter = '\0';
    out->longs[list->count] = (struct option){0};
}

/* @return the row for a value that getopt_long has returned, or NULL. */
static const sc_option *find_option(const sc_option_list *list, int value)
{
    if (value >= FIRST_LONG && (size_t)(value - FIRST_LONG) < list->count)
        return &list->rows[value - FIRST_LONG];
    for (size_t i = 0; i < list->count; i++) {
        if (value && list->rows[i].letter == value)
            return &list->rows[i];
    }
    return NULL;
}

/* The commands that have an option. */
typedef struct owners {
    const char *name; /* of the option */
    char commands[256];
} owners;

static void add_owners(owners *o, const char *option, const char *commands)
{
    char *end = o->commands + strlen(o->commands);

    if (option && commands && !strcmp(option, o->name))
        snprintf(end, (size_t)(o->commands + sizeof o->commands - end), "%s%s",
                 o->commands[0] ? " " : "", commands);
}

/* Add the commands that have the option of a key. For sc_job_each_key, with owners as user. */
static sc_status add_owners_of_key(void *user, const sc_key_info *info)
{
    add_owners(user, info->option, info->commands);
    return SC_OK;
}

/* Fill o->commands with the names of the commands that have the option; empty if there are none.
 * @return SC_ERR_MEMORY. */
static sc_status find_owners(const sc_ctx *ctx, owners *o)
{
    for (size_t i = 0; i < SC_COUNT_OF(option_rows); i++)
        add_owners(o, option_rows[i].name, option_rows[i].commands);
    return sc_job_each_key(ctx, add_owners_of_key, o);
}

/* Append to @p out "--size, --set": up to 4 options of the list that begin with @p word. */
static void list_beginnings(const sc_option_list *list, const char *word, char *out, size_t size)
{
    int found = 0;

    for (size_t i = 0; i < list->count && word[0] && found < 4; i++) {
        if (!strncmp(list->rows[i].name, word, strlen(word)))
            snprintf(out + strlen(out), size - strlen(out), "%s--%s", found++ ? " or " : "",
                     list->rows[i].name);
    }
}

/* Log that there is no such option, with those that may be meant. @param text the word of the
 * command line. @return SC_ERR_USAGE. */
static sc_status unknown_option(const sc_ctx *ctx, const sc_command *command,
                                const sc_option_list *list, const char *text)
{
    const char *names[SC_OPTIONS_MAX], *nearest;
    const char *begin = text + strspn(text, "-");
    char word[64], beginnings[256] = "";
    owners with = {.name = word};
    sc_status status;

    for (size_t i = 0; i < list->count; i++)
        names[i] = list->rows[i].name;
    snprintf(word, sizeof word, "%.*s", (int)strcspn(begin, "="), begin);
    nearest = sc_nearest_word(word, names, list->count);
    if (!strncmp(text, "--", 2)) {
        list_beginnings(list, word, beginnings, sizeof beginnings);
        SC_TRY(find_owners(ctx, &with));
    }
    if (beginnings[0])
        return sc_fail(ctx, SC_ERR_USAGE,
                       "unknown option %s; did you mean %s? Names of options are not abbreviated",
                       text, beginnings);
    if (with.commands[0])
        return sc_fail(ctx, SC_ERR_USAGE, "segcast %s has no option --%s; these commands have: %s",
                       command->name, word, with.commands);
    if (nearest)
        return sc_fail(ctx, SC_ERR_USAGE, "unknown option %s; did you mean --%s?", text, nearest);
    status =
        sc_fail(ctx, SC_ERR_USAGE, "unknown option %s; try `segcast help %s`", text, command->name);
out:
    return status;
}

/* Is @p word, such as "--over" or "--over=x", not the whole name of an option? getopt_long takes
 * the beginning of a name as well. */
static bool is_abbreviated(const sc_option *row, const char *word)
{
    const size_t length = strlen(row->name);

    return strncmp(word, "--", 2) || strncmp(word + 2, row->name, length) ||
           (word[2 + length] && word[2 + length] != '=');
}

/* Log what getopt_long has refused. @param result what it returned, '?' or ':'. @param text the
 * word of the command line. */
static sc_status refuse(const sc_ctx *ctx, const sc_command *command, const sc_option_list *list,
                        int result, const char *text)
{
    const sc_option *row = find_option(list, optopt);

    if (row && !strncmp(text, "--", 2) && is_abbreviated(row, text))
        return unknown_option(ctx, command, list, text);
    if (row && result == ':')
        return sc_fail(ctx, SC_ERR_USAGE, "--%s needs a value: %s", row->name, row->argument);
    if (row && !row->argument)
        return sc_fail(ctx, SC_ERR_USAGE, "--%s takes no value, but is given as \"%s\"", row->name,
                       text);
    return unknown_option(ctx, command, list, text);
}

/* Store what is left in @p argv after the options: at most one argument, if the command takes one,
 * or several. */
static sc_status read_arguments(const sc_ctx *ctx, const sc_command *command, int argc, char **argv,
                                sc_options *options)
{
    const size_t length = strlen(command->argument);
    const bool several = length > 3 && !strcmp(command->argument + length - 3, "...");

    for (int i = optind; i < argc; i++) {
        if ((options->input && !several) || !command->argument[0])
            return sc_fail(ctx, SC_ERR_USAGE, "unexpected argument \"%s\"", argv[i]);
        if (!argv[i][0])
            return sc_fail(ctx, SC_ERR_USAGE,
                           "the argument is empty, expected %s; is a variable of the script not "
                           "set?",
                           command->argument);
        options->input = options->input ? options->input : argv[i];
        options->input_count++;
    }
    options->inputs = (const char *const *)(argv + optind);
    if (command->argument[0] && command->argument[0] != '[' && !options->input && !options->help &&
        !options->version)
        return sc_fail(ctx, SC_ERR_USAGE, "segcast %s needs %s", command->name, command->argument);
    return SC_OK;
}

sc_status sc_options_parse(const sc_ctx *ctx, const sc_command *command, int argc, char **argv,
                           sc_options *out)
{
    const char *threads = getenv("SEGCAST_THREADS");
    const char *max_memory = getenv("SEGCAST_MAX_MEMORY");
    sc_option_list list;
    getopt_tables tables;
    sc_options options = {.frame = -1};
    int result;
    sc_status status;

    SC_TRY(sc_options_list(ctx, command, &list));
    if (!strcmp(command->name, "status"))
        SC_TRY(add_rows(&(lister){.ctx = ctx, .list = &list}, "render"));
    fill_tables(&list, &tables);
    if (threads)
        SC_TRY(set_threads(ctx, &options, "SEGCAST_THREADS", threads));
    if (max_memory)
        SC_TRY(set_max_memory(ctx, &options, "SEGCAST_MAX_MEMORY", max_memory));
    opterr = 0; /* getopt_long prints no messages: refuse does */
    while ((result = getopt_long(argc - 1, argv + 1, tables.shorts, tables.longs, NULL)) != -1) {
        const sc_option *row = find_option(&list, result);
        /* argv + 1 was given, so that argv[optind] is the word before the next one to be read */
        const char *word =
            row && optarg && optarg == argv[optind] ? argv[optind - 1] : argv[optind];

        if (!row || (result >= FIRST_LONG && is_abbreviated(row, word))) {
            status = row ? unknown_option(ctx, command, &list, word)
                         : refuse(ctx, command, &list, result, word);
            goto out;
        }
        SC_TRY(row->store(ctx, &options, row, optarg));
    }
    SC_TRY(read_arguments(ctx, command, argc - 1, argv + 1, &options));
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
