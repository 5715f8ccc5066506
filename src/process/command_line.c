/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line as all ranks read it, and its mistakes beside those of a job. */
#include "segcast/process.h"

#include <sys/stat.h>

/* @return whether the argument is a job file or a study, whose mistakes can be told in one go with
 * those of the command line. A command that takes a directory as well looks at what was made, not
 * at the job. */
static bool is_job_there(const sc_command *command, const sc_options *options)
{
    struct stat info;

    return options->input && !options->help.help && !options->help.version &&
           (strstr(command->argument, "JOB") || strstr(command->argument, "STUDY")) &&
           !strstr(command->argument, "DIR") && stat(options->input, &info) == 0;
}

sc_status sc_read_command_line(sc_app *app, const sc_ctx *ctx, const sc_command *command, int argc,
                               char **argv)
{
    const bool is_root = sc_comm_rank(app->comm) == 0;
    const sc_options *options = &app->options;
    sc_status status = sc_options_parse(ctx, command, argc, argv, &app->options);
    /* Only rank 0 looks at files. */
    const bool goes_on =
        status == SC_ERR_USAGE && (!is_root || is_job_there(command, &app->options));

    if (sc_comm_agree(app->comm, goes_on ? SC_OK : SC_ERR_USAGE) == SC_OK) {
        app->mistake = status;
        status = SC_OK;
    }
    if (status == SC_OK && is_root && !options->help.help && !options->help.version)
        status = sc_input_check(ctx, command, options->input);
    return sc_agree_aloud(app, status);
}
