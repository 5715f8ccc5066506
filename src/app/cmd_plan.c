/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast plan: what a job will take, measured on parts of frames of the job itself. */
#include "run.h"

#include <jansson.h>
#include <stdlib.h>

/* Bands of this many rows, a tile high or less, are drawn of so many frames at full size: of each
 * frame every STRIDE-th band. Pictures of a smaller size would not do: a larger share of their
 * pixels lies on edges, which take more rays, so that they cost two to three times as much. */
enum { PROBES = 12, STRIDE = 16, BAND_ROWS = 16 };

#define MIB (1024.0 * 1024)
#define GIB (1024 * MIB)

/* What was measured of a job. */
typedef struct probe {
    double frame_cpu_s;   /* CPU seconds of drawing a frame */
    double prepare_cpu_s; /* of reading and preparing the volume */
    double prepare_wall_s;
    int frames; /* of how many frames parts were drawn */
} probe;

/* Draw every STRIDE-th band of frame @p k, beginning with number @p first, into @p image; add the
 * CPU seconds and the rows to what is there. */
static sc_status draw_bands(sc_app *app, sc_session *session, int k, int first, sc_image *image,
                            double *cpu_s, double *rows)
{
    const int height_px = session->job.output.size_px[1];
    const int bands = (height_px + BAND_ROWS - 1) / BAND_ROWS;
    sc_status status = SC_OK;

    for (int band = first % (bands < STRIDE ? bands : STRIDE); band < bands && status == SC_OK;
         band += STRIDE) {
        const int end = (band + 1) * BAND_ROWS;
        const sc_rows part = {band * BAND_ROWS, end < height_px ? end : height_px};
        sc_render_stats stats;

        status = sc_session_draw(app, session, k, &part, image, &stats);
        *cpu_s += stats.cpu_s;
        *rows += part.end - part.first;
    }
    return status;
}

/* Measure what drawing a frame costs. The frames are spread over the animation, the bands over the
 * picture. The first band is drawn twice, so that what is needed only once is not counted. */
static sc_status measure(sc_app *app, sc_session *session, probe *out)
{
    const int *size_px = session->job.output.size_px;
    const int frames = session->job.animation.frames;
    const int probes = frames < PROBES ? frames : PROBES;
    sc_image image = {0};
    double cpu_s = 0, rows = 0, unused_s = 0, unused = 0;
    sc_status status;

    sc_stage_begin(app->ctx, "measuring", 0, (uint64_t)probes + 1);
    SC_TRY(sc_image_init(app->ctx, size_px[0], size_px[1], &image));
    SC_TRY(draw_bands(app, session, frames / 2, STRIDE / 2, &image, &unused_s, &unused));
    for (int i = 0; i < probes; i++) {
        const int k = (int)(((long)frames * (2 * i + 1)) / (2 * probes));

        sc_stage_add(app->ctx, 1);
        SC_TRY(draw_bands(app, session, k, 7 * i + STRIDE / 2, &image, &cpu_s, &rows));
    }
    out->frame_cpu_s = rows > 0 ? cpu_s / rows * size_px[1] : 0;
    out->frames = probes;
    for (int phase = SC_PHASE_READ; phase <= SC_PHASE_SHARE; phase++) {
        out->prepare_cpu_s += session->times.phases[phase].cpu_s;
        out->prepare_wall_s += session->times.phases[phase].wall_s;
    }
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

/* Print the plan as JSON. @return SC_ERR_MEMORY. */
static sc_status print_json(const sc_ctx *ctx, const sc_session *session, const probe *p,
                            uint64_t program_bytes)
{
    const sc_job *job = &session->job;
    const sc_farm_memory farm = farm_memory(job, job->output.size_px);
    const size_t root_bytes = farm.window + farm.root;
    json_t *json = json_pack(
        "{s:s, s:i, s:[i,i], s:i, s:i, s:f, s:f, s:f, s:f, s:{s:I, s:I, s:I, s:I, s:I}}", "schema",
        "segcast-plan-1", "frames", job->animation.frames, "size", job->output.size_px[0],
        job->output.size_px[1], "samples", job->render.samples, "frames_measured", p->frames,
        "draw_cpu_s_per_frame", p->frame_cpu_s, "draw_cpu_s",
        p->frame_cpu_s * job->animation.frames, "prepare_cpu_s", p->prepare_cpu_s, "prepare_wall_s",
        p->prepare_wall_s, "memory", "prepared_bytes", (json_int_t)session->shared_bytes,
        "program_bytes", (json_int_t)program_bytes, "renderer_bytes",
        (json_int_t)sc_renderer_bytes(session->renderer), "frames_bytes", (json_int_t)farm.worker,
        "root_frames_bytes", (json_int_t)root_bytes);
    char *text = json ? json_dumps(json, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) : NULL;

    json_decref(json);
    if (!text)
        return sc_fail(ctx, SC_ERR_MEMORY, "out of memory while the plan was written as JSON");
    printf("%s\n", text);
    free(text);
    return SC_OK;
}

/* @return the wall seconds up to the last frame on @p nodes nodes like this one, with a thread on
 * each core; encoding beside the drawing is not counted. */
static double wall_s_on(int nodes, const sc_session *session, const probe *p)
{
    return p->prepare_wall_s +
           p->frame_cpu_s * session->job.animation.frames / nodes / sc_usable_cores();
}

/* Print the plan for people. */
static void print_text(const sc_session *session, const probe *p, uint64_t program_bytes)
{
    const sc_job *job = &session->job;
    const int *size_px = job->output.size_px;

    printf("frames           %d of %d x %d, %d ray%s per pixel\n", job->animation.frames,
           size_px[0], size_px[1], job->render.samples, job->render.samples == 1 ? "" : "s");
    printf("kernel           %s, %s\n", sc_renderer_kernel(session->renderer)->name,
           sc_renderer_kernel(session->renderer)->cpu);
    printf("volume           %d x %d x %d voxels, %d labels\n", session->volume.size[0],
           session->volume.size[1], session->volume.size[2], session->volume.label_count - 1);
    print_memory(session, size_px, program_bytes);
    printf("before drawing   %.1f s, %.1f CPU s for reading and preparing the volume\n",
           p->prepare_wall_s, p->prepare_cpu_s);
    printf("drawing          %.3f CPU s per frame, %.4f core hours in all (parts of %d frames "
           "measured here; encoding comes on top)\n",
           p->frame_cpu_s, p->frame_cpu_s * job->animation.frames / 3600, p->frames);
    printf("wall time        %.0f s on 1 node like this one (%d cores), %.0f s on 4, %.0f s on 16, "
           "without encoding\n",
           wall_s_on(1, session, p), sc_usable_cores(), wall_s_on(4, session, p),
           wall_s_on(16, session, p));
}

sc_status sc_cmd_plan(sc_app *app)
{
    const uint64_t program_bytes = sc_peak_rss();
    sc_session session = {0};
    probe measured = {0};
    sc_status status;

    SC_TRY(sc_session_job(app, app->options.input, &session));
    SC_TRY(sc_session_volume(app, &session));
    SC_TRY(measure(app, &session, &measured));
    sc_display_end_stage(app);
    if (app->options.json)
        status = print_json(app->ctx, &session, &measured, program_bytes);
    else
        print_text(&session, &measured, program_bytes);
out:
    sc_session_clear(&session);
    return status;
}
