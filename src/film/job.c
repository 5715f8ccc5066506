/* SPDX-License-Identifier: BSD-3-Clause */
/* From a job file to the job on every rank: rank 0 reads it, and after each step all ranks agree on
 * the return code, so that they end together after an error. */
#include "panels.h"

#include <string.h>

sc_status sc_check_job_tissues(sc_app *app, sc_job *job)
{
    SC_OWN(sc_input_clear) sc_input input = {0};
    sc_ctx errors = *app->ctx;
    sc_app quieter = *app;

    if (!job->volume[0] || job->has_compare || /* others may have the tissues */
        (job->rule_count + job->exception_count + job->verb_tissue_count + job->shot_count == 0 &&
         job->animation.camera.optics.focus != SC_FOCUS_TISSUE) ||
        (sc_is_prepared_file(job->volume) && sc_comm_size(app->comm) > 1))
        return SC_OK;
    errors.level = SC_LOG_ERROR;
    quieter.ctx = &errors;
    SC_PASS(sc_input_inspect(&quieter, job, !app->options.scan, &input));
    return sc_check_tissues(&errors, job, input.volume.labels, input.volume.label_count);
}

/* The arrays of a job. */
enum { ARRAYS = 10 };
typedef struct job_array {
    void *data;
    size_t count, size;
} job_array;

static void get_arrays(const sc_job *job, job_array out[ARRAYS])
{
    const job_array arrays[ARRAYS] = {
        {job->rules, job->rule_count, sizeof *job->rules},
        {job->exceptions, job->exception_count, sizeof *job->exceptions},
        {job->verbs, job->verb_count, sizeof *job->verbs},
        {job->verb_tissues, job->verb_tissue_count, sizeof *job->verb_tissues},
        {job->captions, job->caption_count, sizeof *job->captions},
        {job->overlay_tissues, job->overlay_tissue_count, sizeof *job->overlay_tissues},
        {job->volume_tissues, job->volume_tissue_count, sizeof *job->volume_tissues},
        {job->shots, job->shot_count, sizeof *job->shots},
        {job->phases, job->phase_count, sizeof *job->phases},
        {job->tissue_tracks, job->tissue_track_count, sizeof *job->tissue_tracks}};

    memcpy(out, arrays, sizeof arrays);
}

static void set_arrays(sc_job *job, const job_array arrays[ARRAYS])
{
    job->rules = arrays[0].data;
    job->exceptions = arrays[1].data;
    job->verbs = arrays[2].data;
    job->verb_tissues = arrays[3].data;
    job->captions = arrays[4].data;
    job->overlay_tissues = arrays[5].data;
    job->volume_tissues = arrays[6].data;
    job->shots = arrays[7].data;
    job->phases = arrays[8].data;
    job->tissue_tracks = arrays[9].data;
}

/* Send a job of rank 0, without the jobs of its shots, to the others. Collective. */
static sc_status share_job_alone(sc_app *app, sc_job *job)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const job_array nothing[ARRAYS] = {0};
    job_array arrays[ARRAYS];
    sc_status status = SC_OK;

    if (first)
        get_arrays(job, arrays);
    sc_comm_broadcast(app->comm, job, sizeof *job);
    /* The pointers in the job that was received are addresses of rank 0. They are replaced by this
     * rank's own: NULL at first, then the copies of the arrays. */
    if (!first) {
        set_arrays(job, nothing);
        get_arrays(job, arrays);
    }
    for (int i = 0; i < ARRAYS && status == SC_OK; i++) {
        status = sc_broadcast_array(app, &arrays[i].data, arrays[i].count, arrays[i].size);
        set_arrays(job, arrays);
    }
    for (size_t i = 0; i < job->shot_count && !first && job->shots; i++)
        set_arrays(&job->shots[i].job, nothing);
    return status;
}

/* Send the job of rank 0 to all others. Collective. */
static sc_status share_job(sc_app *app, sc_job *job)
{
    sc_status status = share_job_alone(app, job);

    for (size_t i = 0; i < job->shot_count && status == SC_OK; i++)
        status = share_job_alone(app, &job->shots[i].job);
    return status;
}

sc_status sc_session_job(sc_app *app, const char *job_path, sc_session *session)
{
    const sc_job_sources sources = {.path = job_path,
                                    .settings = app->options.settings,
                                    .setting_count = app->options.setting_count,
                                    .defaults = app->options.defaults,
                                    .default_count = app->options.default_count,
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
    return share_job(app, &session->job);
}
