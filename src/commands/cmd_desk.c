/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast desk: look at a job or a volume in a browser, and change it by hand. */
#include "commands.h"
#include "init/init.h"
#include "segcast/desk.h"

enum { JOB_MAX_BYTES = 1 << 20 };

/* Read the job file or, if the input is a volume, generate a default job. Called on rank 0 only. */
static sc_status find_job(sc_app *app, bool is_new, sc_text *path, sc_text *text)
{
    const char *input = app->options.input;
    sc_comm *all = app->comm;
    size_t bytes;
    sc_status status;

    if (!is_new) {
        SC_PASS(sc_text_add(app->ctx, path, "%s", input));
        return sc_file_read(app->ctx, input, JOB_MAX_BYTES, &text->data, &bytes);
    }
    SC_PASS(sc_comm_open(app->ctx, false, &app->comm));
    status = sc_init_write(app, false, path, text);
    sc_comm_close(app->comm);
    app->comm = all;
    return status;
}

sc_status sc_cmd_desk(sc_app *app)
{
    const char *input = app->options.input;
    SC_OWN(sc_text_clear) sc_text text = {0}, path = {0};
    sc_desk_plan plan = {.is_new = !sc_input_may_be_job(input) || sc_job_is_phantom(input),
                         .listen = app->options.desk.listen,
                         .port = app->options.desk.port,
                         .idle_min = app->options.desk.idle_min};
    sc_status status = SC_OK;

    if (sc_comm_rank(app->comm) == 0)
        status = find_job(app, plan.is_new, &path, &text);
    SC_PASS(sc_comm_agree(app->comm, status));
    plan.path = path.data;
    plan.text = text.data;
    return sc_desk_serve(app, &plan);
}
