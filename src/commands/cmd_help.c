/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast help: all commands, one of them, the keys of a job file, or what is kept. */
#include "commands.h"
#include "segcast/input.h"

/* Print the keys of a job file, or those that begin with @p prefix. */
static sc_status print_keys(const sc_ctx *ctx, const sc_options *o, const char *prefix)
{
    const sc_keys_format format = o->help.schema     ? SC_KEYS_SCHEMA
                                  : o->help.study    ? SC_KEYS_STUDY
                                  : o->help.markdown ? SC_KEYS_MARKDOWN
                                  : o->help.man      ? SC_KEYS_MAN
                                  : o->json          ? SC_KEYS_JSON
                                                     : SC_KEYS_TABLE;
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_keys_describe(ctx, prefix, format, &text));
    fputs(text.data, stdout);
    return SC_OK;
}

/* Say where prepared volumes are kept, and how much of them; with --clear remove them. */
static sc_status print_kept(const sc_app *app)
{
    SC_OWN(sc_free_at) char *directory = NULL;
    uint64_t bytes = 0;
    int files = 0;

    SC_PASS(sc_kept_directory(app->ctx, &directory));
    if (!directory) {
        puts("Nothing is kept: SEGCAST_CACHE is off, or this is a batch job and does not name a "
             "directory.");
        return SC_OK;
    }
    SC_PASS(sc_kept_trim(app->ctx, directory, app->options.help.clear ? 0 : UINT64_MAX, &files,
                         &bytes));
    printf("%s holds %d prepared volume%s of %.1f MB (SEGCAST_CACHE names another directory, or "
           "off; `segcast help cache --clear` removes them)\n",
           directory, files, files == 1 ? "" : "s", (double)bytes / 1e6);
    return SC_OK;
}

sc_status sc_cmd_help(sc_app *app)
{
    const sc_options *o = &app->options;
    const bool keys = o->input && !strcmp(o->input, "keys");
    const bool cache = o->input && !strcmp(o->input, "cache");
    const sc_command *command = o->input ? sc_command_find(app->commands, o->input) : NULL;
    const char *shell = o->help.bash ? "bash" : o->help.zsh ? "zsh" : o->help.fish ? "fish" : NULL;

    if (cache && o->input_count == 1)
        return print_kept(app);
    if (o->help.clear)
        return sc_fail(app->ctx, SC_ERR_USAGE, "--clear is for what is kept: segcast help cache");
    if (keys)
        return print_keys(app->ctx, o, o->input_count > 1 ? o->inputs[1] : NULL);
    if (o->input_count > 1)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "unexpected argument \"%s\"; `segcast help help` explains the command",
                       o->inputs[1]);
    if (o->json || o->help.markdown || o->help.schema || o->help.study)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--json, --markdown, --schema and --study-schema are for the keys of a job "
                       "file: segcast help keys");
    if (shell)
        return sc_print_completion(app->ctx, app->commands, shell, stdout);
    if (o->help.man)
        return sc_print_manual(app->ctx, app->commands, stdout);
    if (o->input && !command)
        return sc_command_unknown(app->ctx, app->commands, o->input);
    if (command)
        return sc_print_command_help(app->ctx, command, stdout);
    sc_print_help(app->commands, stdout);
    return SC_OK;
}
