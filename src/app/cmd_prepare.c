/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast prepare: write the prepared volume to a file; jobs that map it start without preparing.
 */
#include "app.h"

#include <string.h>

#define ENDING ".segc"

/* Is the argument a job file, judged by the end of its name? */
static bool is_job(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot && (!strcmp(dot, ".yaml") || !strcmp(dot, ".yml"));
}

/* Find the opacity of each label, for the light that is derived for the job; NULL if its tissues
 * have mistakes, which are told when the job is drawn. Caller owns *out: sc_free. */
static sc_status find_opacity(const sc_app *app, const sc_job *job, const sc_prepared *view,
                              float **out)
{
    const sc_ctx silent = {.rank = 0};
    const size_t labels = (size_t)view->label_count;
    void *tissues = NULL, *opacity = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(app->ctx, labels, sizeof(sc_tissue), &tissues));
    SC_TRY(sc_zalloc(app->ctx, labels, sizeof(float), &opacity));
    if (sc_transfer_resolve(&silent, view, job->rules, job->rule_count,
                            (sc_opacity_rule)job->render.auto_opacity, tissues) != SC_OK)
        goto out;
    for (int id = 1; id < view->label_count; id++) {
        const sc_tissue *tissue = (const sc_tissue *)tissues + id;

        ((float *)opacity)[id] = tissue->visible ? (float)tissue->opacity : 0;
    }
    *out = opacity;
    opacity = NULL;
out:
    sc_free(opacity);
    sc_free(tissues);
    return status;
}

/* Prepare the volume of a session, which may be that of a phase, and write it to @p path. For
 * surfaces that are smooth, what pictures are drawn from is derived, too. @param opacity as of
 * find_opacity: filled by the first phase, by which the tissues of all look. */
static sc_status prepare_file(sc_app *app, sc_session *session, const char *path, float **opacity)
{
    const double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    sc_volume_input input = {0};
    sc_preparation *preparation = NULL;
    sc_status status;

    SC_TRY(sc_session_prepare(app, session, true, &input, &preparation));
    session->drawn = input.drawn;
    session->drawn_known = input.drawn_known;
    session->volume = sc_preparation_view(preparation);
    if (session->job.render.surface == SC_SURFACE_SMOOTH) {
        if (!*opacity)
            SC_TRY(find_opacity(app, &session->job, &session->volume, opacity));
        SC_TRY(sc_preparation_derive(app->ctx, preparation, *opacity));
    }
    SC_TRY(sc_preparation_save(app->ctx, preparation, path, app->options.overwrite));
    sc_info(app->ctx, "%s: %.1f MB, prepared in %.2f s, %.2f CPU s", path,
            (double)sc_preparation_file_bytes(preparation) * 1e-6, sc_wall_s() - wall_s,
            sc_cpu_s() - cpu_s);
    sc_display_end_stage(app);
    sc_print_made(path);
out:
    session->volume = (sc_prepared){0};
    sc_preparation_free(preparation);
    sc_volume_input_clear(&input);
    return status;
}

/* Refuse to write @p path if the volume that it would hold is prepared already. */
static sc_status check_input(const sc_app *app, const sc_session *session, const char *volume,
                             const char *path)
{
    const sc_status status = sc_check_output(app, session, path, true);

    if (status == SC_OK && sc_is_prepared_file(volume))
        return sc_fail(app->ctx, SC_ERR_USAGE, "%s: is a prepared file already", volume);
    return status;
}

/* Prepare each phase of a session's volume, and write it to a file of its own: @p path with the
 * number of the phase. */
static sc_status prepare_phases(sc_app *app, sc_session *session, const char *path)
{
    const int count = (int)session->job.phase_count;
    float *opacity = NULL;
    sc_text name = {0};
    sc_app own;
    sc_status status;

    SC_TRY(sc_begin_phase_store(app, session, &own));
    for (int pass = 0; pass < 2; pass++) { /* all are checked before the first is made */
        for (int i = 0; i < count; i++) {
            sc_session phase;

            sc_text_clear(&name);
            SC_TRY(sc_phase_path(app->ctx, path, ENDING, i, count, &name));
            sc_session_begin_phase(session, i, &phase);
            phase.is_later_phase = false; /* each file has colours, so that it can be used alone */
            if (pass)
                SC_TRY(prepare_file(&own, &phase, name.data, &opacity));
            else
                SC_TRY(check_input(&own, session, session->job.phases[i].path, name.data));
            session->drawn = phase.drawn;
            session->drawn_known = phase.drawn_known;
        }
    }
out:
    sc_phase_store_free(own.phase_store);
    sc_text_clear(&name);
    sc_free(opacity);
    return status;
}

sc_status sc_cmd_prepare(sc_app *app)
{
    const char *path = app->options.output ? app->options.output : "prepared" ENDING;
    const char *job = is_job(app->options.input) ? app->options.input : NULL;
    sc_session session = {0};
    float *opacity = NULL;
    sc_status status;

    if (!job) {
        SC_TRY(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
        SC_TRY(sc_expect_series(app));
    }
    SC_TRY(sc_check_ending(app->ctx, path, ENDING, "a prepared volume"));
    SC_TRY(sc_session_job(app, job, &session));
    if (session.job.phase_count) {
        status = prepare_phases(app, &session, path);
        goto out;
    }
    SC_TRY(check_input(app, &session, session.job.volume, path));
    status = prepare_file(app, &session, path, &opacity);
out:
    sc_free(opacity);
    sc_session_clear(&session);
    return status;
}
