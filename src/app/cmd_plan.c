/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast plan: what a job will take, measured on a few small frames of the job itself. */
#include "run.h"

enum { PROBES = 5, SHRINK = 4 };

#define MIB (1024.0 * 1024)
#define GIB (1024 * MIB)

/* Estimate the CPU seconds of a full-size frame: draw PROBES frames of the session, whose pictures
 * have 1/SHRINK of the width and height. */
static sc_status probe(sc_app *app, sc_session *session, double *cpu_s)
{
    const int frames = session->job.animation.frames;
    sc_image image = {0};
    double sum = 0;
    sc_status status;

    SC_TRY(sc_image_init(app->ctx, session->job.output.size_px[0], session->job.output.size_px[1],
                         &image));
    for (int i = 0; i < PROBES; i++) {
        const int k = (int)((long)frames * i / PROBES);
        sc_render_stats stats;

        SC_TRY(sc_session_draw(app, session, k, NULL, &image, &stats));
        sum += stats.cpu_s;
    }
    *cpu_s = sum / PROBES * SHRINK * SHRINK;
out:
    sc_image_clear(&image);
    return status;
}

/* @return what the farm will hold of frames of full size, with as many ranks as frames, which need
 * the largest window. */
static sc_farm_memory farm_memory(const sc_job *job, const int size_px[2])
{
    const sc_video_settings video = sc_run_video_settings(job);
    const sc_farm farm = {.width_px = size_px[0],
                          .height_px = size_px[1],
                          .frame_count = job->animation.frames,
                          .gop_frames = sc_video_gop_frames(&video),
                          .spoils_other_rows = job->output.layout == SC_LAYOUT_VIEWS};

    return sc_farm_memory_of(&farm, job->animation.frames);
}

/* Print how much memory a run needs. @param program_bytes size of this process before it read the
 * volume. */
static void print_memory(const sc_session *session, const int size_px[2], uint64_t program_bytes)
{
    const sc_farm_memory farm = farm_memory(&session->job, size_px);

    printf("memory per node  %.2f GiB for the prepared volume, which its ranks share; %.2f GiB on "
           "rank 0 while it is prepared\n",
           (double)session->shared_bytes / GIB, (double)sc_peak_rss() / GIB);
    printf("each rank        %.0f MiB for the program, %.0f MiB for the renderer, up to %.0f MiB "
           "for frames\n",
           (double)program_bytes / MIB, (double)sc_renderer_bytes(session->renderer) / MIB,
           (double)farm.worker / MIB);
    printf(
        "rank 0           up to %.0f MiB for frames that wait; an encoder comes on top, on rank 0 "
        "or (farm.encode: segments) on every rank\n",
        (double)(farm.window + farm.root) / MIB);
}

sc_status sc_cmd_plan(sc_app *app)
{
    const uint64_t program_bytes = sc_peak_rss();
    sc_session session = {0};
    int *size_px = session.job.output.size_px, full_px[2];
    double cpu_s;
    sc_status status;

    SC_TRY(sc_session_job(app, app->options.input, &session));
    for (int i = 0; i < 2; i++) {
        full_px[i] = size_px[i];
        size_px[i] = full_px[i] / SHRINK > 16 ? full_px[i] / SHRINK : 16;
    }
    SC_TRY(sc_session_volume(app, &session));
    SC_TRY(probe(app, &session, &cpu_s));
    printf("frames           %d of %d x %d, %d ray%s per pixel\n", session.job.animation.frames,
           full_px[0], full_px[1], session.job.render.samples,
           session.job.render.samples == 1 ? "" : "s");
    printf("kernel           %s, %s\n", sc_renderer_kernel(session.renderer)->name,
           sc_renderer_kernel(session.renderer)->cpu);
    printf("volume           %d x %d x %d voxels, %d labels\n", session.volume.size[0],
           session.volume.size[1], session.volume.size[2], session.volume.label_count - 1);
    print_memory(&session, full_px, program_bytes);
    printf("drawing          %.2f CPU s per frame, %.3f core hours in all (%d frames of 1/%d size "
           "measured here; encoding comes on top)\n",
           cpu_s, cpu_s * session.job.animation.frames / 3600, PROBES, SHRINK * SHRINK);
out:
    sc_session_clear(&session);
    return status;
}
