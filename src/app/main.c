/* SPDX-License-Identifier: BSD-3-Clause */
#include "app.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

extern char **environ;

/* Exit codes of sysexits.h; 75 asks the batch system to run the job again. */
static int exit_code(sc_status status)
{
    static const int codes[] = {
        [SC_OK] = 0,          [-SC_ERR_INCOMPLETE] = 75, [-SC_ERR_USAGE] = 64,
        [-SC_ERR_DATA] = 65,  [-SC_ERR_MISSING] = 66,    [-SC_ERR_CREATE] = 73,
        [-SC_ERR_WRITE] = 74, [-SC_ERR_MEMORY] = 70,     [-SC_ERR_INTERNAL] = 70};

    return codes[-status];
}

/* A command for one process: rank 0 does it as a group of its own while the others wait. */
static sc_status run_alone(sc_app *app, const sc_command *command)
{
    sc_comm *all = app->comm, *alone = NULL;
    sc_status status = sc_comm_open(app->ctx, false, &alone);

    if (status != SC_OK)
        return status;
    app->comm = alone;
    status = command->run(app);
    app->comm = all;
    sc_comm_close(alone);
    return status;
}

static sc_status run(sc_app *app, int argc, char **argv)
{
    const bool speak = sc_comm_rank(app->comm) == 0;
    const sc_command *command = argc > 1 ? sc_command_find(argv[1]) : NULL;
    const sc_ctx silent = {.rank = 0};
    const sc_ctx *ctx = speak ? app->ctx : &silent;
    bool help = false;
    sc_status status;

    if (argc > 1 && (!strcmp(argv[1], "--version") || !strcmp(argv[1], "--help"))) {
        if (speak)
            (!strcmp(argv[1], "--version") ? sc_print_version : sc_print_help)(stdout);
        return SC_OK;
    }
    if (argc < 2 || !command)
        return sc_command_unknown(ctx, argc > 1 ? argv[1] : NULL);
    SC_TRY(sc_check_group(ctx, app->comm));
    SC_TRY(sc_options_parse(ctx, command, argc, argv, speak, &app->options, &help));
    if (help)
        goto out;
    app->terminal->quiet = app->options.quiet;
    app->threads = app->options.threads ? app->options.threads : sc_default_threads();
    if (command->by_all)
        status = command->run(app);
    else if (speak)
        status = run_alone(app, command);
out:
    return status;
}

int main(int argc, char **argv)
{
    sc_terminal terminal = {.is_tty = isatty(STDERR_FILENO) && getenv("TERM")};
    sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_terminal_write, .user = &terminal};
    sc_app app = {.ctx = &ctx,
                  .terminal = &terminal,
                  .environment = (const char *const *)environ,
                  .begin_s = sc_wall_s()};
    sc_status status = sc_comm_open(&ctx, sc_launched_by_mpi(), &app.comm);

    if (status != SC_OK)
        return exit_code(status);
    ctx.rank = sc_comm_rank(app.comm);
    status = sc_comm_agree(app.comm, run(&app, argc, argv));
    sc_options_clear(&app.options);
    sc_comm_close(app.comm);
    return exit_code(status);
}
