/* SPDX-License-Identifier: BSD-3-Clause */
/* Finding a command by its name, and the table of exit codes. */
#include "segcast/cli.h"

enum { COMMANDS_MAX = 64 };

const sc_command *sc_command_find(const sc_command *commands, const char *name)
{
    for (const sc_command *command = commands; command->name; command++) {
        if (!strcmp(name, command->name))
            return command;
    }
    return NULL;
}

sc_status sc_command_unknown(const sc_ctx *ctx, const sc_command *commands, const char *name)
{
    const char *names[COMMANDS_MAX], *nearest;
    size_t count = 0;

    if (!name)
        return sc_fail(ctx, SC_ERR_USAGE, "no command; try `segcast --help`");
    if (name[0] == '-')
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "the command comes first: segcast COMMAND %s; `segcast --help` lists the commands",
            name);
    if (sc_input_as_command(ctx, name) != SC_OK)
        return SC_ERR_USAGE;
    for (; commands[count].name && count < COMMANDS_MAX; count++)
        names[count] = commands[count].name;
    nearest = sc_nearest_word(name, names, count);
    return sc_fail(ctx, SC_ERR_USAGE, "unknown command \"%s\"; %s%s%s", name,
                   nearest ? "did you mean \"" : "try `segcast --help`", nearest ? nearest : "",
                   nearest ? "\"?" : "");
}

const sc_exit_code sc_exit_codes[] = {
    {SC_OK, 0, "complete"},
    {SC_ERR_USAGE, 64, "wrong use: command line or settings"},
    {SC_ERR_DATA, 65, "an input is wrong or damaged"},
    {SC_ERR_MISSING, 66, "an input is missing"},
    {SC_ERR_INTERNAL, 70, "out of memory, or an error inside segcast"},
    {SC_ERR_SYSTEM, 71, "a limit of the system is reached"},
    {SC_ERR_CREATE, 73, "an output cannot be created, or exists already"},
    {SC_ERR_WRITE, 74, "an output cannot be written, or an input not be read"},
    {SC_ERR_INCOMPLETE, 75, "incomplete: run again with --resume"},
    {0}};

int sc_exit_code_of(sc_status status)
{
    for (const sc_exit_code *row = sc_exit_codes; row->meaning; row++) {
        if (row->status == status)
            return row->code;
    }
    return 70; /* SC_ERR_MEMORY, too */
}
