/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast desk: look at a job or a volume in a browser, and change it by hand. */
#include "commands.h"
#include "init/init.h"
#include "segcast/desk.h"

enum { JOB_MAX_BYTES = 1 << 20 };

sc_status sc_cmd_desk(sc_app *app)
{
    const char *input = app->options.input;
    SC_OWN(sc_text_clear) sc_text text = {0}, path = {0};
    sc_desk_plan plan = {.listen = app->options.listen,
                         .port = app->options.port,
                         .idle_min = app->options.idle_min};
    size_t bytes;

    if (!sc_input_may_be_job(input) || sc_job_is_phantom(input)) {
        SC_PASS(sc_init_write(app, &path, &text));
        plan.is_new = true;
    } else {
        SC_PASS(sc_text_add(app->ctx, &path, "%s", input));
        SC_PASS(sc_file_read(app->ctx, input, JOB_MAX_BYTES, &text.data, &bytes));
    }
    plan.path = path.data;
    plan.text = text.data;
    return sc_desk_serve(app, &plan);
}
