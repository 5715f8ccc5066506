/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line for those who get a film: without what may name persons or places. */
#include "segcast/cli.h"

/* @return the row of a word such as "--frames", "--frames=3" or "-oDIR", and its value; NULL: it is
 * no option. @param next the word behind it, or NULL. @param takes_next whether that is its value.
 */
static const sc_option *row_of(const sc_option_list *list, const char *word, const char *next,
                               const char **value, bool *takes_next)
{
    const bool is_long = !strncmp(word, "--", 2);
    const size_t length = is_long ? strcspn(word + 2, "=") : 1;

    for (size_t i = 0; i < list->count && word[0] == '-' && word[1]; i++) {
        const sc_option *row = &list->rows[i];
        const char *rest = is_long ? word + 2 + length : word + 2;

        if (is_long ? strlen(row->name) != length || strncmp(row->name, word + 2, length) != 0
                    : row->letter != word[1])
            continue;
        *takes_next = row->argument && !rest[0];
        *value = !row->argument ? NULL : *takes_next ? next : rest + (is_long && rest[0] == '=');
        return row;
    }
    return NULL;
}

/* @return whether a value is a number, a list of numbers or the like, and no path. */
static bool is_plain(const char *value)
{
    static const char *const words[] = {"true", "false", "auto", "none"};

    for (size_t i = 0; i < SC_COUNT_OF(words); i++) {
        if (!strcmp(value, words[i]))
            return true;
    }
    return value[0] && value[0] != '/' && !value[strspn(value, "0123456789.,:%+-x/")];
}

/* Append the value of an option, or what help calls it. */
static sc_status add_value(const sc_ctx *ctx, const sc_option *row, const char *value,
                           sc_text *text)
{
    const char *equals = !strcmp(row->name, "set") ? strchr(value, '=') : NULL;
    const bool is_path = strstr(row->argument, "DIR") || strstr(row->argument, "FILE");

    if (equals && is_plain(equals + 1) &&
        strspn(value, "abcdefghijklmnopqrstuvwxyz_.0123456789") == (size_t)(equals - value))
        return sc_text_add(ctx, text, " %s", value);
    return sc_text_add(ctx, text, " %s", !is_path && is_plain(value) ? value : row->argument);
}

sc_status sc_command_shown(const sc_ctx *ctx, const sc_command *command, int argc,
                           char *const *argv, sc_text *text)
{
    sc_option_list list;

    SC_PASS(sc_options_list(ctx, command, &list));
    SC_PASS(sc_text_add(ctx, text, "segcast %s", command->name));
    for (int i = 2; i < argc; i++) {
        const char *value = NULL;
        bool takes_next = false;
        const sc_option *row =
            row_of(&list, argv[i], i + 1 < argc ? argv[i + 1] : NULL, &value, &takes_next);

        if (!strcmp(argv[i], "--"))
            continue;
        if (!row) {
            SC_PASS(sc_text_add(ctx, text, " %s", command->argument));
            continue;
        }
        SC_PASS(sc_text_add(ctx, text, " --%s", row->name));
        if (value)
            SC_PASS(add_value(ctx, row, value, text));
        i += takes_next;
    }
    return SC_OK;
}
