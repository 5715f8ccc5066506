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

/* Derive what pictures of the job are drawn from, for the file; nothing for surfaces of voxels. The
 * light is derived for the opacities of the job, unless its tissues have mistakes, which are told
 * when the job is drawn. */
static sc_status derive(const sc_app *app, const sc_job *job, sc_preparation *preparation)
{
    const sc_prepared view = sc_preparation_view(preparation);
    const sc_ctx silent = {.rank = 0};
    const size_t labels = (size_t)view.label_count;
    void *tissues = NULL, *opacity = NULL;
    bool resolved;
    sc_status status;

    if (job->render.surface != SC_SURFACE_SMOOTH)
        return SC_OK;
    SC_TRY(sc_zalloc(app->ctx, labels, sizeof(sc_tissue), &tissues));
    SC_TRY(sc_zalloc(app->ctx, labels, sizeof(float), &opacity));
    resolved = sc_transfer_resolve(&silent, &view, job->rules, job->rule_count,
                                   (sc_opacity_rule)job->render.auto_opacity, tissues) == SC_OK;
    for (int id = 1; id < view.label_count; id++) {
        const sc_tissue *tissue = (const sc_tissue *)tissues + id;

        ((float *)opacity)[id] = tissue->visible ? (float)tissue->opacity : 0;
    }
    status = sc_preparation_derive(app->ctx, preparation, resolved ? opacity : NULL);
out:
    sc_free(opacity);
    sc_free(tissues);
    return status;
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
    SC_TRY(derive(app, &session.job, preparation));
    SC_TRY(sc_preparation_save(app->ctx, preparation, path, app->options.overwrite));
    sc_info(app->ctx, "%s: %.1f MB, prepared in %.2f s, %.2f CPU s", path,
            (double)sc_preparation_file_bytes(preparation) * 1e-6, sc_wall_s() - wall_s,
            sc_cpu_s() - cpu_s);
    sc_display_end_stage(app);
    sc_print_made(path);
out:
    sc_preparation_free(preparation);
    sc_volume_input_clear(&input);
    sc_session_clear(&session);
    return status;
}
