/* SPDX-License-Identifier: BSD-3-Clause */
/* Measures for segcast plan: draws parts of frames, and encodes some frames in a row. */
#include "plan/plan.h"

#include <stdlib.h>

/* Bands of this many rows, a tile high or less, are drawn of SC_PLAN_PLACES frames at full size:
 * of each frame every STRIDE-th band. Pictures of a smaller size would not do: a larger share of
 * their pixels lies on edges, which take more rays, so that they cost two to three times as much.
 */
enum { STRIDE = 16, BAND_ROWS = 16 };

/* How many frames are drawn whole and encoded. A frame depends on those before it, so they come in
 * runs of neighbours: RUN frames at up to PLACES places of the animation. */
enum {
    SHARE = 10,     /* one of so many frames of the job at most, */
    RUN = 8,        /* in runs of about so many, */
    LEAST = 6,      /* but at least so many frames if there is time, */
    ALWAYS = 2,     /* and so many in any case */
    PLACES = 8,     /* at so many places at most */
    LOOKAHEAD = 80, /* no encoder holds more frames than this */
    KEPT_MIB = 256  /* memory for the pictures of a run */
};
#define TIME_S 25.0 /* wall time for them */
#define SMALL_S 2.0 /* a job that is drawn in this time is drawn whole */

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

/* Measure what drawing a frame costs: fills draw_cpu_s and partly_drawn. The frames are spread over
 * the animation, the bands over the picture. The first band is drawn twice, so that what is needed
 * only once is not counted. @param image of the size of the job's frames. */
static sc_status measure_drawing(sc_app *app, sc_session *session, sc_image *image,
                                 sc_plan_probe *out)
{
    const int frames = session->job.animation.frames;
    const int probes = frames < SC_PLAN_PLACES ? frames : SC_PLAN_PLACES;
    double cpu_s = 0, rows = 0, unused_s = 0, unused = 0;

    sc_stage_begin(app->ctx, "measuring the drawing", 0, (uint64_t)probes + 1);
    SC_PASS(draw_bands(app, session, frames / 2, STRIDE / 2, image, &unused_s, &unused));
    for (int i = 0; i < probes; i++) {
        const int k = (int)(((long)frames * (2 * i + 1)) / (2 * probes));
        const double before_s = cpu_s, before = rows;

        sc_stage_add(app->ctx, 1);
        SC_PASS(draw_bands(app, session, k, 7 * i + STRIDE / 2, image, &cpu_s, &rows));
        out->place_cpu_s[i] = (cpu_s - before_s) / (rows - before) * session->job.output.size_px[1];
    }
    out->draw_cpu_s = rows > 0 ? cpu_s / rows * session->job.output.size_px[1] : 0;
    out->partly_drawn = probes;
    return SC_OK;
}

/* ---- encoding ---- */

/* Draws and encodes runs of frames. */
typedef struct prober {
    sc_app *app;
    sc_session *session;
    sc_image *image;
    sc_encoder *encoder; /* NULL: a job without video */
    char *pictures;      /* [run], each of picture_bytes: converted frames */
    size_t picture_bytes;
    int places,
        run; /* number of runs of neighbouring frames; frames of a run (the last: or fewer) */
    double draw_cpu_s;    /* sums over all frames drawn, from here on */
    double convert_cpu_s; /* conversion and hashing, on one thread */
    sc_plan_cost first;   /* the first frame of each run, encoded alone */
    sc_plan_cost runs;    /* runs encoded whole */
    sc_plan_cost png;
} prober;

/* Set places and run: how many frames are drawn whole. Needs picture_bytes. */
static void choose_frames(prober *p, double frame_cpu_s)
{
    const sc_job *job = &p->session->job;
    const sc_video_settings video = sc_run_video_settings(job);
    const int frames = job->animation.frames, gop = sc_video_gop_frames(&video);
    const double frame_s = frame_cpu_s / p->app->threads;
    const double most = ((size_t)KEPT_MIB << 20) / (double)p->picture_bytes;
    const double affordable = frame_s > 0 ? TIME_S / frame_s : frames;
    double wanted = frames / SHARE > LEAST ? frames / SHARE : LEAST;

    wanted = wanted < affordable ? wanted : affordable;
    wanted = wanted > ALWAYS ? wanted : ALWAYS;
    if (frames * frame_s <= SMALL_S || wanted >= frames) {
        p->run = gop;
        p->run = p->run < most ? p->run : (int)most;
        p->places = (frames + gop - 1) / gop;
    } else {
        p->places = (int)wanted / RUN;
        p->places = p->places < 1 ? 1 : p->places > PLACES ? PLACES : p->places;
        p->run = (int)(wanted / p->places);
        p->run = p->run < most ? p->run : (int)most;
    }
    p->run = p->run < gop ? p->run : gop;
    p->run = p->run > ALWAYS ? p->run : ALWAYS;
    p->run = p->run < frames ? p->run : frames;
}

/* Write the frame in p->image as a PNG file in memory, and add what that costs to p->png. */
static sc_status measure_png(prober *p)
{
    const sc_ctx *ctx = p->app->ctx;
    const double cpu_s = sc_thread_cpu_s();
    char *data;
    size_t bytes;
    const sc_status status =
        sc_image_compress_png(ctx, p->image, "a frame in memory", &data, &bytes);

    free(data);
    p->png.cpu_s += sc_thread_cpu_s() - cpu_s;
    p->png.bytes += (double)bytes;
    return status;
}

/* Draw @p count frames from number @p first on; convert them to p->pictures, if there is a video,
 * and write them as PNG, if the job does. */
static sc_status draw_run(prober *p, int first, int count)
{
    for (int i = 0; i < count; i++) {
        sc_render_stats stats;
        double cpu_s;

        SC_PASS(sc_session_draw(p->app, p->session, first + i, NULL, p->image, &stats));
        p->draw_cpu_s += stats.cpu_s;
        cpu_s = sc_thread_cpu_s();
        (void)sc_image_hash(p->image);
        if (p->encoder)
            memcpy(p->pictures + (size_t)i * p->picture_bytes,
                   sc_encoder_convert(p->encoder, p->image), p->picture_bytes);
        p->convert_cpu_s += sc_thread_cpu_s() - cpu_s;
        if (p->session->job.output.frames == SC_FRAMES_PNG)
            SC_PASS(measure_png(p));
        sc_stage_add(p->app->ctx, 1);
    }
    return SC_OK;
}

/* Encode the first @p count of p->pictures as a GOP, and add what that costs to @p cost. */
static sc_status encode(prober *p, int count, sc_plan_cost *cost)
{
    const sc_ctx *ctx = p->app->ctx;
    const double cpu_s = sc_cpu_s(), wall_s = sc_wall_s();
    SC_OWN(sc_segment_free) sc_segment segment = {0};

    for (int i = 0; i < count; i++)
        SC_PASS(sc_encoder_push(ctx, p->encoder, p->pictures + (size_t)i * p->picture_bytes, 0));
    SC_PASS(sc_encoder_finish(ctx, p->encoder, 0, 0, &segment));
    cost->cpu_s += sc_cpu_s() - cpu_s;
    cost->wall_s += sc_wall_s() - wall_s;
    cost->bytes += (double)segment.bytes;
    return SC_OK;
}

/* Find how much memory an encoder takes for a whole GOP: it keeps frames of the future before it
 * encodes one. One picture in place of all will do. */
static sc_status measure_memory(prober *p, sc_plan_probe *out)
{
    const sc_ctx *ctx = p->app->ctx;
    const sc_job *job = &p->session->job;
    const sc_video_settings video = sc_run_video_settings(job);
    const uint64_t before = sc_heap_bytes();
    int count = sc_video_gop_frames(&video);
    SC_OWN(sc_encoder_close_at) sc_encoder *encoder = NULL;

    count = count < job->animation.frames ? count : job->animation.frames;
    count = count < LOOKAHEAD ? count : LOOKAHEAD;
    SC_PASS(sc_encoder_open(ctx, job->output.video, &video, &encoder));
    for (int i = 0; i < count; i++) {
        uint64_t now;

        SC_PASS(sc_encoder_push(ctx, encoder, p->pictures, 0));
        now = sc_heap_bytes();
        if (now > before + out->encoder_bytes)
            out->encoder_bytes = now - before;
    }
    return SC_OK;
}

/* @return (whole - part) / count, but at least 0; 0 if count is. */
static double mean_rest(double whole, double part, int count)
{
    return count > 0 && whole > part ? (whole - part) / count : 0;
}

/* Turn the sums of the prober, over out->encoded frames in @p runs runs, into what a frame costs.
 * In a job that was drawn whole its frames are the better measure of drawing, too. */
static void conclude(const prober *p, int runs, sc_plan_probe *out)
{
    const int rest = out->encoded - runs;
    const double convert_s = p->convert_cpu_s / out->encoded;

    if (out->encoded == p->session->job.animation.frames)
        out->draw_cpu_s = p->draw_cpu_s / out->encoded;
    out->png = (sc_plan_cost){p->png.cpu_s / out->encoded, p->png.cpu_s / out->encoded,
                              p->png.bytes / out->encoded};
    if (!p->encoder)
        return;
    out->first = (sc_plan_cost){p->first.cpu_s / runs + convert_s,
                                p->first.wall_s / runs + convert_s, p->first.bytes / runs};
    out->next = (sc_plan_cost){mean_rest(p->runs.cpu_s, p->first.cpu_s, rest) + convert_s,
                               mean_rest(p->runs.wall_s, p->first.wall_s, rest) + convert_s,
                               mean_rest(p->runs.bytes, p->first.bytes, rest)};
}

/* Draw and encode runs of frames: fills what @p out holds of encoding. Does nothing for a job
 * without outputs. */
static sc_status measure_encoding(prober *p, sc_plan_probe *out)
{
    const sc_ctx *ctx = p->app->ctx;
    const sc_job *job = &p->session->job;
    const sc_video_settings video = sc_run_video_settings(job);
    const int frames = job->animation.frames, gop = sc_video_gop_frames(&video);
    int runs = 0;
    sc_status status = SC_OK;

    if (!sc_run_has_video(job) && job->output.frames != SC_FRAMES_PNG)
        return SC_OK;
    p->picture_bytes = sc_picture_bytes(job->output.video, &video);
    choose_frames(p, out->draw_cpu_s);
    sc_stage_begin(ctx, "measuring the encoding", 0, (uint64_t)p->places * (uint64_t)p->run);
    if (sc_run_has_video(job)) {
        SC_TRY(sc_alloc(ctx, (size_t)p->run, p->picture_bytes, &p->pictures));
        SC_TRY(sc_encoder_open(ctx, job->output.video, &video, &p->encoder));
        sc_encoder_drop(p->encoder); /* every run opens the codec, as every GOP does */
    }
    for (; runs < p->places; runs++) {
        const int first = p->run == gop && p->places == (frames + gop - 1) / gop
                              ? runs * gop
                              : (int)((long)(frames - p->run) * (2 * runs + 1) / (2 * p->places));
        const int count = frames - first < p->run ? frames - first : p->run;

        SC_TRY(draw_run(p, first, count));
        out->encoded += count;
        if (!p->encoder)
            continue;
        SC_TRY(encode(p, count, &p->runs));
        SC_TRY(encode(p, 1, &p->first));
    }
    if (p->encoder)
        SC_TRY(measure_memory(p, out));
    conclude(p, runs, out);
out:
    sc_encoder_close(p->encoder);
    sc_free(p->pictures);
    return status;
}

sc_status sc_plan_measure(sc_app *app, sc_session *session, uint64_t program_bytes,
                          sc_plan_probe *out)
{
    SC_OWN(sc_image_clear) sc_image image = {0};
    prober p = {.app = app, .session = session, .image = &image};
    SC_OWN(sc_text_clear) sc_text text = {0};
    uint64_t volumes_bytes;

    *out = (sc_plan_probe){.program_bytes = program_bytes,
                           .memory_max_bytes = app->ctx->memory_max_bytes,
                           .prepare_bytes = sc_peak_rss(),
                           .prepared_bytes = sc_inputs_bytes(session->inputs)};
    out->renderer_bytes = sc_session_renderer_bytes(session, &out->derived_bytes);
    volumes_bytes = out->prepared_bytes + out->derived_bytes;
    out->loaded_bytes = (uint64_t)(sc_session_loaded_share(session) * (double)volumes_bytes);
    if (out->loaded_bytes < volumes_bytes)
        out->phase_file_bytes = volumes_bytes;
    out->prepared_bytes += sc_session_grey_bytes(session); /* which nodes hold once, too */
    out->loaded_bytes += sc_session_grey_bytes(session);
    for (int phase = SC_PHASE_READ; phase <= SC_PHASE_SHARE; phase++) {
        out->prepare_cpu_s += session->times.phases[phase].cpu_s;
        out->prepare_wall_s += session->times.phases[phase].wall_s;
    }
    SC_PASS(sc_job_write(app->ctx, &session->job, false, &text));
    out->job_bytes = text.length_bytes;
    SC_PASS(sc_session_image(app, session, &image));
    SC_PASS(measure_drawing(app, session, &image, out));
    return measure_encoding(&p, out);
}
