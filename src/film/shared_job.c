/* SPDX-License-Identifier: BSD-3-Clause */
/* From a job file to the job on every rank: rank 0 reads it, and after each step all ranks agree on
 * the return code, so that they end together after an error. */
#include "panels.h"

sc_status sc_check_job_tissues(sc_app *app, sc_job *job)
{
    SC_OWN(sc_input_clear) sc_input input = {0};
    sc_ctx errors = *app->ctx;
    sc_app quieter = *app;

    if (!job->volume.path[0] || job->given.compare || /* others may have the tissues */
        (job->tissues.rule_count + job->tissues.exception_count + job->verbs.tissue_count +
                 job->film.shot_count ==
             0 &&
         job->animation.camera.optics.focus != SC_FOCUS_TISSUE) ||
        (sc_is_prepared_file(job->volume.path) && sc_comm_size(app->comm) > 1))
        return SC_OK;
    errors.level = SC_LOG_ERROR;
    quieter.ctx = &errors;
    SC_PASS(sc_input_inspect(&quieter, job, !app->options.scan, &input));
    return sc_check_tissues(&errors, job, input.volume.labels, input.volume.label_count);
}

/* Let a job have no arrays. */
static void drop_arrays(sc_job *job)
{
    for (int i = 0; i < SC_JOB_ARRAYS; i++)
        sc_job_set_array(job, i, NULL);
}

/* Send a job of rank 0, without the jobs of its shots, to the others. Collective. */
static sc_status share_job_alone(sc_app *app, sc_job *job)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_status status = SC_OK;

    sc_comm_broadcast(app->comm, job, sizeof *job);
    if (!first) /* the pointers that were received are addresses of rank 0 */
        drop_arrays(job);
    for (int i = 0; i < SC_JOB_ARRAYS && status == SC_OK; i++) {
        size_t count, bytes;
        void *array = sc_job_array(job, i, &count, &bytes);

        status = sc_broadcast_array(app, &array, count, bytes);
        sc_job_set_array(job, i, array);
    }
    for (size_t i = 0; i < job->film.shot_count && !first && job->film.shots; i++)
        drop_arrays(&job->film.shots[i].job);
    return status;
}

sc_status sc_job_share(sc_app *app, sc_job *job)
{
    SC_PASS(share_job_alone(app, job));
    for (size_t i = 0; i < job->film.shot_count; i++)
        SC_PASS(share_job_alone(app, &job->film.shots[i].job));
    return SC_OK;
}

sc_status sc_session_job(sc_app *app, const char *job_path, sc_session *session)
{
    const sc_job_sources sources = {.path = job_path,
                                    .settings = app->options.settings.all,
                                    .setting_count = app->options.settings.count,
                                    .defaults = app->options.settings.defaults,
                                    .default_count = app->options.settings.default_count,
                                    .environment = app->environment,
                                    .no_video = app->options.no_video,
                                    .check_inputs = true};
    sc_status status = app->mistake;

    *session = (sc_session){.times = {.threads = app->threads}};
    if (sc_comm_rank(app->comm) == 0)
        (void)sc_goes_on(&status, sc_job_load(app->ctx, &sources, &session->job));
    if (status == SC_ERR_USAGE || status == SC_ERR_DATA || status == SC_ERR_MISSING)
        (void)sc_check_job_tissues(app,
                                   &session->job); /* so that all mistakes are told in one go */
    SC_PASS(sc_comm_agree(app->comm, status));
    return sc_job_share(app, &session->job);
}
