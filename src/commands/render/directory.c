/* SPDX-License-Identifier: BSD-3-Clause */
/* What the directory of a job belongs to, for commands that need neither its job file nor its
 * volume. */
#include "render/run.h"

sc_status sc_read_directory(const sc_app *app, const char *directory, sc_job *job,
                            sc_store_job *out, char *version)
{
    SC_OWN(sc_free_at) char *path = NULL;
    sc_job_sources sources = {0};

    *out = (sc_store_job){.threads = app->threads};
    SC_PASS(sc_store_identify(app->ctx, directory, out, version));
    SC_PASS(sc_path_join(app->ctx, directory, "job.yaml", &path));
    sources.path = path;
    SC_PASS(sc_job_load(app->ctx, &sources, job));
    out->video = job->output.video;
    out->png = job->output.frames == SC_FRAMES_PNG;
    out->settings = sc_run_video_settings(job);
    if (job->animation.frames != out->frames)
        return sc_fail(app->ctx, SC_ERR_DATA, "%s: has %d frames, the manifest beside it %d", path,
                       job->animation.frames, out->frames);
    return SC_OK;
}
