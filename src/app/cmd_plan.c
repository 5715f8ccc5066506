/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast plan: what a job will take, measured on a few small frames of the job itself. */
#include "app.h"

enum { PROBES = 5, SHRINK = 4 };

/* CPU seconds of a full-size frame, from PROBES frames of 1/SHRINK of the width and height. */
static sc_status probe(sc_app *app, sc_session *session, double *cpu_s)
{
    const int frames = session->job.animation.frames;
    sc_image image = {0};
    double sum = 0;
    sc_status status = sc_image_init(app->ctx, session->job.output.size_px[0],
                                     session->job.output.size_px[1], &image);

    if (status != SC_OK)
        return status;
    for (int i = 0; i < PROBES; i++) {
        const sc_scene scene =
            sc_timeline_scene(&session->timeline, (int)((long)frames * i / PROBES));
        sc_render_stats stats;

        sc_render_frame(session->renderer, &scene, NULL, &image, &stats);
        sum += stats.cpu_s;
    }
    sc_image_clear(&image);
    *cpu_s = sum / PROBES * SHRINK * SHRINK;
    return SC_OK;
}

sc_status sc_cmd_plan(sc_app *app)
{
    sc_session session = {0};
    int width_px, height_px;
    double cpu_s, gib = 1024.0 * 1024 * 1024;
    sc_status status;

    SC_TRY(sc_session_job(app, app->options.input, &session));
    width_px = session.job.output.size_px[0];
    height_px = session.job.output.size_px[1];
    session.job.output.size_px[0] = width_px / SHRINK > 16 ? width_px / SHRINK : 16;
    session.job.output.size_px[1] = height_px / SHRINK > 16 ? height_px / SHRINK : 16;
    SC_TRY(sc_session_volume(app, &session));
    SC_TRY(probe(app, &session, &cpu_s));
    printf("frames           %d of %d x %d, %d ray%s per pixel\n", session.job.animation.frames,
           width_px, height_px, session.job.render.samples,
           session.job.render.samples == 1 ? "" : "s");
    printf("kernel           %s, %s\n", sc_renderer_kernel(session.renderer)->name,
           sc_renderer_kernel(session.renderer)->cpu);
    printf("volume           %d x %d x %d voxels, %d labels\n", session.volume.size[0],
           session.volume.size[1], session.volume.size[2], session.volume.label_count - 1);
    printf("memory per node  %.2f GiB shared, once; at most %.2f GiB while rank 0 prepares\n",
           (double)session.shared_bytes / gib, (double)sc_peak_rss() / gib);
    printf("per rank         %.0f MiB for four frames, and 1 bit per voxel for what is visible; "
           "rank 0 "
           "holds up to 128 MiB of frames, or two\n",
           4.0 * width_px * height_px * 3 / 1048576);
    printf("drawing          %.2f CPU s per frame, %.3f core hours in all (%d frames of 1/%d size "
           "measured here; encoding comes on top)\n",
           cpu_s, cpu_s * session.job.animation.frames / 3600, PROBES, SHRINK * SHRINK);
out:
    sc_session_clear(&session);
    return status;
}
