/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast prepare: write the prepared volume to a file; jobs that map it start without preparing.
 */
#include "app.h"

#include <string.h>

/* Is the argument a job file, judged by the end of its name? */
static bool is_job(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot && (!strcmp(dot, ".yaml") || !strcmp(dot, ".yml"));
}

sc_status sc_cmd_prepare(sc_app *app)
{
    const char *path = app->options.output ? app->options.output : "prepared.segc";
    const char *job = is_job(app->options.input) ? app->options.input : NULL;
    sc_session session = {0};
    sc_volume_input input = {0};
    sc_preparation *preparation = NULL;
    double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    sc_status status;

    if (!job)
        SC_TRY(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_TRY(sc_check_ending(app->ctx, path, ".segc", "a prepared volume"));
    SC_TRY(sc_session_job(app, job, &session));
    SC_TRY(sc_check_output(app, &session, path, true));
    if (sc_is_prepared_file(session.job.volume)) {
        status =
            sc_fail(app->ctx, SC_ERR_USAGE, "%s: is a prepared file already", session.job.volume);
        goto out;
    }
    SC_TRY(sc_session_prepare(app, &session, true, &input, &preparation));
    SC_TRY(sc_preparation_save(app->ctx, preparation, path, app->options.overwrite));
    sc_info(app->ctx, "%s: %.1f MB, prepared in %.2f s, %.2f CPU s", path,
            (double)sc_preparation_bytes(preparation) * 1e-6, sc_wall_s() - wall_s,
            sc_cpu_s() - cpu_s);
    sc_display_end_stage(app);
    sc_print_made(path);
out:
    sc_preparation_free(preparation);
    sc_volume_input_clear(&input);
    sc_session_clear(&session);
    return status;
}
