/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads the command line with getopt_long. */
#include "option_values.h"

#include <getopt.h>
#include <stdlib.h>
#include <unistd.h>

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
    sc_option_owners with = {0};

    if (access(text, F_OK) == 0)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "unknown option %s; the file of this name is given as ./%s", text, text);
    for (size_t i = 0; i < list->count; i++)
        names[i] = list->rows[i].name;
    snprintf(word, sizeof word, "%.*s", (int)strcspn(begin, "="), begin);
    nearest = sc_nearest_word(word, names, list->count);
    if (!strncmp(text, "--", 2)) {
        list_beginnings(list, word, beginnings, sizeof beginnings);
        SC_PASS(sc_options_find_owners(ctx, word, &with));
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
    return sc_fail(ctx, SC_ERR_USAGE, "unknown option %s; try `segcast help %s`", text,
                   command->name);
}

/* Is @p word, such as "--over" or "--over=x", not the whole name of an option? getopt_long takes
 * the beginning of a name as well. */
static bool is_abbreviated(const sc_option *row, const char *word)
{
    const size_t length = strlen(row->name);

    return strncmp(word, "--", 2) || strncmp(word + 2, row->name, length) ||
           (word[2 + length] && word[2 + length] != '=');
}

/* Log that there is no option of one letter @p letter. getopt_long does not say in which word it
 * was: either in @p last, whose letters have all been read then, or in @p next. @return
 * SC_ERR_USAGE. */
static sc_status unknown_letter(const sc_ctx *ctx, const sc_command *command,
                                const sc_option_list *list, int letter, const char *last,
                                const char *next)
{
    const bool is_last = last[0] == '-' && last[1] != '-' && last[strlen(last) - 1] == letter;
    const char *word = is_last || !next ? last : next;

    if (word[0] == '-' && word[1] == letter)
        return unknown_option(ctx, command, list, word);
    return sc_fail(ctx, SC_ERR_USAGE, "unknown option -%c in %s; try `segcast help %s`", letter,
                   word, command->name);
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
    const int most = strstr(command->argument, "...") ? argc
                     : strchr(command->argument, ' ') ? 2
                                                      : 1;

    for (int i = optind; i < argc; i++) {
        if (options->input_count == most || options->plan.calibrate)
            return sc_fail(ctx, SC_ERR_USAGE,
                           "unexpected argument \"%s\"; `segcast help %s` explains the command",
                           argv[i], command->name);
        if (!argv[i][0])
            return sc_fail(
                ctx, SC_ERR_USAGE,
                "the argument is empty, expected %s; is a variable of the script not set?",
                command->argument);
        if (sc_check_tilde(ctx, "the argument", argv[i]) != SC_OK)
            return SC_ERR_USAGE;
        options->input = options->input ? options->input : argv[i];
        options->input_count++;
    }
    options->inputs = (const char *const *)(argv + optind);
    if (command->argument[0] != '[' && !options->input && !options->help.help &&
        !options->help.version && !options->plan.calibrate)
        return sc_fail(ctx, SC_ERR_USAGE, "segcast %s needs %s; `segcast help %s` explains it",
                       command->name, command->argument, command->name);
    return SC_OK;
}

/* Store the values of the environment variables that stand for options. @return the first mistake;
 * all are logged. */
static sc_status read_environment(const sc_ctx *ctx, sc_options *options)
{
    const char *threads = getenv("SEGCAST_THREADS");
    const char *max_memory = getenv("SEGCAST_MAX_MEMORY");
    sc_status status = SC_OK;

    if (threads)
        status = sc_options_set_threads(ctx, options, "SEGCAST_THREADS", threads);
    if (max_memory)
        (void)sc_goes_on(&status,
                         sc_options_set_max_memory(ctx, options, "SEGCAST_MAX_MEMORY", max_memory));
    return status;
}

/* Store all options of @p argv. @param is_unknown set if one is unknown: the word behind it may be
 * its value. Behind an unknown letter nothing more is read, since the letters after it may be
 * anything. @return the first mistake; all are logged. */
static sc_status read_options(const sc_ctx *ctx, const sc_command *command, int argc, char **argv,
                              const sc_option_list *list, sc_options *options, bool *is_unknown)
{
    getopt_tables tables;
    sc_status status = SC_OK, found;
    int result;

    fill_tables(list, &tables);
    opterr = 0; /* getopt_long prints no messages: refuse does */
    while ((result = getopt_long(argc, argv, tables.shorts, tables.longs, NULL)) != -1) {
        const sc_option *row = find_option(list, result);
        /* argv[optind - 1] is the last word that was read */
        const char *word =
            row && optarg && optarg == argv[optind - 1] ? argv[optind - 2] : argv[optind - 1];
        const bool is_letter = result == '?' && optopt && optopt < FIRST_LONG;

        if (is_letter) {
            *is_unknown = true;
            return unknown_letter(ctx, command, list, optopt, word, argv[optind]);
        }
        if (row && (result < FIRST_LONG || !is_abbreviated(row, word))) {
            found = row->store(ctx, options, row, optarg);
        } else {
            found = row ? unknown_option(ctx, command, list, word)
                        : refuse(ctx, command, list, result, word);
            *is_unknown = *is_unknown || (result == '?' && !optopt);
        }
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

sc_status sc_options_parse(const sc_ctx *ctx, const sc_command *command, int argc, char **argv,
                           sc_options *out)
{
    const sc_ctx silent = {.rank = 0};
    sc_option_list list;
    SC_OWN(sc_options_clear) sc_options options = {.still.frame = -1};
    bool is_unknown = false;
    sc_status status, found;

    SC_PASS(sc_options_list(ctx, command, &list));
    if (!strcmp(command->name, "status"))
        SC_PASS(sc_options_list_more(ctx, "render", &list));
    status = read_environment(ctx, &options);
    if (!sc_goes_on(&status,
                    read_options(ctx, command, argc - 1, argv + 1, &list, &options, &is_unknown)))
        return status;
    /* What stands behind an unknown option may be its value, and no argument. */
    found = read_arguments(is_unknown ? &silent : ctx, command, argc - 1, argv + 1, &options);
    if (!is_unknown && !sc_goes_on(&status, found))
        return status;
    SC_HAND_OVER(options, out);
    return status;
}

void sc_options_clear(sc_options *options)
{
    for (size_t i = 0; i < options->owned.count; i++)
        sc_free(options->owned.all[i]);
    *options = (sc_options){0};
}
