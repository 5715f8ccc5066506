/* SPDX-License-Identifier: BSD-3-Clause */
#include "commands.h"

#include <stdlib.h>
#include <unistd.h>

extern char **environ;

/* Read the command line and execute its command. Only rank 0 logs mistakes in the command line. */
static sc_status execute(sc_app *app, int argc, char **argv)
{
    const bool is_root = sc_comm_rank(app->comm) == 0;
    const char *name = argc > 1 ? argv[1] : NULL;
    const sc_command *command = name ? sc_command_find(app->commands, name) : NULL;
    const sc_ctx silent = {.rank = 0};
    const sc_ctx *ctx = is_root ? app->ctx : &silent;
    sc_options *options = &app->options;
    sc_status status = SC_OK;

    if (name && (!strcmp(name, "--version") || !strcmp(name, "-V"))) {
        if (is_root && argc > 2 && !strcmp(argv[2], "--json"))
            return sc_print_version_json(ctx);
        if (is_root)
            sc_print_version(stdout);
        return SC_OK;
    }
    if (name && (!strcmp(name, "--help") || !strcmp(name, "-h"))) {
        command = argc > 2 ? sc_command_find(app->commands, argv[2]) : NULL;
        if (is_root && command)
            return sc_print_command_help(ctx, command, stdout);
        if (is_root)
            sc_print_help(app->commands, stdout);
        return SC_OK;
    }
    if (!command)
        return sc_command_unknown(ctx, app->commands, name);
    status = sc_check_communicator(ctx, app->comm);
    SC_PASS(sc_agree_aloud(app, status));
    SC_PASS(sc_read_command_line(app, ctx, command, argc, argv));
    app->terminal->quiet = options->quiet;
    app->ctx->memory_max_bytes =
        options->limits.max_memory_bytes ? options->limits.max_memory_bytes : sc_machine_memory();
    sc_signals_tell(is_root, app->terminal->is_tty);
    app->threads = options->limits.threads ? options->limits.threads : sc_default_threads();
    app->ctx->threads = app->threads;
    if (options->help.help)
        status = is_root ? sc_print_command_help(ctx, command, stdout) : SC_OK;
    else if (options->help.version && is_root)
        sc_print_version(stdout);
    else if (!options->help.version)
        status = sc_execute(app, command);
    if (status == SC_OK)
        status = app->mistake; /* which the command should have returned */
    return status;
}

int main(int argc, char **argv)
{
    sc_terminal terminal = {.is_tty = isatty(STDERR_FILENO) && getenv("TERM"),
                            .lock = PTHREAD_MUTEX_INITIALIZER};
    sc_stage stage = {.name = NULL};
    sc_ctx ctx = {
        .level = SC_LOG_INFO, .write = sc_terminal_write, .user = &terminal, .stage = &stage};
    sc_app app = {.ctx = &ctx,
                  .terminal = &terminal,
                  .commands = sc_commands,
                  .environment = (const char *const *)environ,
                  .argc = argc,
                  .argv = argv,
                  .begin_s = sc_wall_s()};
    sc_status status;

    sc_heap_return_large_blocks();
    sc_signals_install();
    if (!sc_open_standard_streams())
        return sc_exit_code_of(SC_ERR_INTERNAL);
    status = sc_ensure_stack(&ctx);
    if (status == SC_OK)
        status = sc_launch(&ctx, &app.comm);
    if (status != SC_OK)
        return sc_exit_code_of(status);
    ctx.rank = sc_comm_rank(app.comm);
    status = sc_finish_standard_output(&ctx, execute(&app, argc, argv));
    status = sc_comm_agree(app.comm, status);
    sc_options_clear(&app.options);
    sc_comm_close(app.comm);
    return sc_exit_code_of(status);
}
