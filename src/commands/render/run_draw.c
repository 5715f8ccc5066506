/* SPDX-License-Identifier: BSD-3-Clause */
/* The callbacks of the farm: frames and GOPs are drawn on any rank and accepted on rank 0. */
#include "render/run.h"

#include <limits.h>
#include <math.h>

/* After a signal, if the end of the allocation is not known, a GOP that needs longer than this to
 * be finished is given up: Slurm, for example, kills 30 s after the signal (KillWait). */
#define PATIENCE_S 30

_Static_assert((int)SC_SHOTS_MAX <= (int)SC_CHAPTERS_MAX, "each shot may begin a chapter");

/* Fill in a chapter for each shot that has a name. It lasts until the next one begins. Before the
 * first of them there is one with the title of the film: players take the first to begin at 0. */
static void find_chapters(const sc_job *job, sc_video_settings *settings)
{
    bool any = false;

    for (size_t i = 0; i < job->film.shot_count; i++)
        any = any || job->film.shots[i].name[0];
    for (size_t i = 0; i < job->film.shot_count && any; i++) {
        const sc_shot *shot = &job->film.shots[i];

        if (!shot->name[0] && i > 0)
            continue;
        if (settings->chapter_count)
            settings->chapters[settings->chapter_count - 1].end = shot->span.first;
        settings->chapters[settings->chapter_count++] =
            (sc_video_chapter){shot->span.first, job->animation.frames,
                               shot->name[0] ? shot->name : job->output.title};
    }
}

/* @return whether all pictures of a job show all directions. */
static bool shows_all_directions(const sc_job *job)
{
    bool all = job->film.shot_count > 0 || job->animation.camera.projection == SC_EQUIRECTANGULAR;

    for (size_t i = 0; i < job->film.shot_count; i++)
        all = all && job->film.shots[i].job.animation.camera.projection == SC_EQUIRECTANGULAR;
    return all;
}

sc_video_settings sc_run_video_settings(const sc_job *job)
{
    sc_video_settings settings = {.width_px = job->output.size_px[0],
                                  .height_px = job->output.size_px[1],
                                  .fps = job->output.fps,
                                  .codec = (sc_codec)job->output.codec,
                                  .crf = job->output.crf,
                                  .preset = sc_job_preset(job),
                                  .title = job->output.title,
                                  .author = job->output.author,
                                  .alpha = job->render.background.is_none,
                                  .spherical = shows_all_directions(job)};

    find_chapters(job, &settings);
    return settings;
}

sc_status sc_run_check_encoder(const sc_ctx *ctx, const sc_job *job)
{
    const sc_video_settings settings = sc_run_video_settings(job);
    const double bytes = sc_video_encoder_bytes_least(job->output.video, &settings);

    if (!sc_run_has_video(job))
        return SC_OK;
    SC_PASS(sc_video_check_encoder(ctx, job->output.video, settings.codec));
    return sc_memory_check(ctx, bytes, "choose a smaller one, or video: none with frames: png, or ",
                           "output.size is %d x %d: to encode a video of that size takes at least",
                           settings.width_px, settings.height_px);
}

bool sc_run_has_video(const sc_job *job)
{
    return strcmp(job->output.video, "none") != 0;
}

double sc_run_gathering_bytes(const sc_job *job, int gathered, int ranks)
{
    const sc_video_settings settings = sc_run_video_settings(job);
    const sc_farm farm = {.width_px = settings.width_px,
                          .height_px = settings.height_px,
                          .partition = (sc_partition)job->farm.partition,
                          .gop_count = gathered,
                          .gather = true,
                          .gop_frames = sc_video_gop_frames(&settings),
                          .total_frames = job->animation.frames,
                          .spoils_other_rows = sc_job_has_views(job)};

    if (gathered == 0)
        return 0;
    return (double)sc_farm_memory_of(&farm, ranks).encoder +
           sc_video_encoder_bytes_least(job->output.video, &settings);
}

/* @return how many encoders of gathered GOPs the memory of all nodes allows. */
static long encoders_allowed(const sc_job *job, int gathered, const sc_run_ranks *where)
{
    const double each = sc_run_gathering_bytes(job, gathered, where->ranks);

    if (gathered == 0 || where->memory_max_bytes == 0)
        return LONG_MAX;
    return where->nodes * (long)((double)where->memory_max_bytes / each);
}

/* @return how many encoders work at the same time at least: two groups of GOPs overlap. */
static int encoders_least(int gathered)
{
    return gathered < 2 ? gathered : 2;
}

sc_run_encoding sc_run_encoding_of(const sc_job *job, int whole, int full,
                                   const sc_run_ranks *where)
{
    const int encode = job->farm.encode;
    const int gathered = sc_handout_gathered(full, where->ranks, encode == SC_ENCODE_GATHER);
    const long allowed = encoders_allowed(job, gathered, where);

    if (encode == SC_ENCODE_ROOT)
        return (sc_run_encoding){0};
    if (encode == SC_ENCODE_GATHER || (gathered > 0 && allowed >= encoders_least(gathered)))
        return (sc_run_encoding){.gops = gathered,
                                 .gather = true,
                                 .encoders_most = allowed < 2              ? 1
                                                  : allowed / 2 < gathered ? (int)(allowed / 2)
                                                                           : 0};
    return (sc_run_encoding){
        .gops = sc_handout_gops(whole, where->ranks, encode == SC_ENCODE_SEGMENTS)};
}

sc_status sc_run_check_gathering(const sc_ctx *ctx, const sc_job *job, int gathered,
                                 const sc_run_ranks *where)
{
    static const double gib = 1024.0 * 1024 * 1024;
    const double each = sc_run_gathering_bytes(job, gathered, where->ranks),
                 limit = (double)where->memory_max_bytes;
    const int least = (encoders_least(gathered) + where->nodes - 1) / where->nodes;

    if (encoders_allowed(job, gathered, where) >= encoders_least(gathered))
        return SC_OK;
    if (job->farm.encode == SC_ENCODE_GATHER)
        return sc_fail(
            ctx, SC_ERR_SYSTEM,
            "farm.encode is gather: each rank that encodes holds frames of %d x %d for %s with its "
            "encoder, and %d of them on a node are over the limit of %s; choose farm.encode: auto, "
            "or raise the limit where there is more memory: --max-memory %.0fG",
            job->output.size_px[0], job->output.size_px[1], sc_size_text(each, (char[24]){0}),
            least, sc_size_text(limit, (char[24]){0}), ceil(least * each / gib));
    sc_warn(
        ctx,
        "farm.encode: frames of a second are not gathered to be encoded by several ranks: each of "
        "these would hold %s, and %d of them on a node are over the limit of %s (--max-memory)",
        sc_size_text(each, (char[24]){0}), least, sc_size_text(limit, (char[24]){0}));
    return SC_OK;
}

sc_status sc_run_check_encode_key(const sc_ctx *ctx, const sc_job *job)
{
    const sc_video_settings settings = sc_run_video_settings(job);
    const int gops = job->animation.frames / sc_video_gop_frames(&settings);
    const sc_run_ranks anywhere = {
        .ranks = 2, .nodes = 2, .memory_max_bytes = ctx->memory_max_bytes};

    if (job->farm.encode != SC_ENCODE_GATHER || !sc_run_has_video(job))
        return SC_OK;
    return sc_run_check_gathering(ctx, job, sc_handout_gathered(gops, anywhere.ranks, true),
                                  &anywhere);
}

/* Add to the trace when each thread drew, since the last call. */
static void trace_threads(sc_run *run, int frame)
{
    sc_renderer *renderer;

    for (int r = 0; (renderer = sc_session_renderer(&run->session, r)) != NULL; r++) {
        sc_renderer_spans(renderer, run->worker.spans);
        for (int i = 0; i < run->app->threads; i++) {
            if (run->worker.spans[i].begin_s > 0)
                sc_trace_add(run->trace, SC_TRACE_DRAW, i, frame, run->worker.spans[i].begin_s,
                             run->worker.spans[i].end_s);
        }
    }
}

/* Draw rows of a frame, and fill in its timing record except wait_s, rank and hash. */
static sc_status draw_rows(sc_run *run, int frame, const sc_rows *rows, sc_image *image,
                           sc_frame_result *result)
{
    const sc_status status =
        sc_session_draw_frame(run->app, &run->session, frame, rows, image, result);

    trace_threads(run, frame);
    return status;
}

sc_status sc_run_draw(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result)
{
    const sc_rows part = {row, row + rows};

    return draw_rows(user, frame, &part, image, result);
}

/* ---- GOPs: drawn, encoded and packed by one rank ---- */

/* Append a block to a payload: its size, as a uint64_t, then its bytes. The payload of a GOP has
 * one block for the segment and, if PNG files are asked for, a second one, which holds a block for
 * the file of each frame. */
static sc_status add_block(const sc_ctx *ctx, sc_payload *payload, const void *data, size_t bytes)
{
    const uint64_t size = bytes;
    char *end;

    SC_PASS(
        sc_resize(ctx, payload->bytes, payload->bytes + sizeof size + bytes, 1, &payload->data));
    end = (char *)payload->data + payload->bytes;
    memcpy(end, &size, sizeof size);
    memcpy(end + sizeof size, data, bytes);
    payload->bytes += sizeof size + bytes;
    return SC_OK;
}

/* Read the block at offset *at and move *at behind it. @p out borrows the payload. @return false if
 * it is cut off. */
static bool next_block(const sc_payload *payload, size_t *at, sc_segment *out)
{
    uint64_t size;

    if (*at + sizeof size > payload->bytes)
        return false;
    memcpy(&size, (const char *)payload->data + *at, sizeof size);
    if (size > payload->bytes - *at - sizeof size)
        return false;
    *out = (sc_segment){(char *)payload->data + *at + sizeof size, size};
    *at += sizeof size + size;
    return true;
}

/* Append the PNG file of @p image as a block. */
static sc_status add_png(const sc_ctx *ctx, sc_payload *payload, const sc_image *image)
{
    SC_OWN(sc_free_at) char *data = NULL;
    size_t bytes;

    SC_PASS(sc_image_compress_png(ctx, image, "a frame in memory", &data, &bytes));
    return add_block(ctx, payload, data, bytes);
}

/* Has a signal come, and would the GOP be finished too late? @param done how many of its @p count
 * frames have been drawn since @p begin_s. */
static bool should_give_up(const sc_run *run, double begin_s, int done, int count)
{
    const double now_s = sc_wall_s();
    const double left_s = done ? (now_s - begin_s) / done * (count - done) : PATIENCE_S;

    if (*run->give_up)
        return true;
    if (!*run->stop)
        return false;
    return run->clock.deadline_s > 0 ? now_s + left_s > run->clock.deadline_s
                                     : left_s >= PATIENCE_S;
}

/* Make the encoder at the first GOP, and drop what an unfinished GOP left in it. */
static sc_status open_gop_encoder(sc_run *run)
{
    const sc_job *job = &run->session.job;
    const sc_video_settings settings = sc_run_video_settings(job);

    if (!run->worker.encoder)
        SC_PASS(sc_encoder_open(run->app->ctx, job->output.video, &settings, &run->worker.encoder));
    sc_encoder_drop(run->worker.encoder);
    return SC_OK;
}

/* Encode a frame of a GOP; append its PNG file to @p pngs if asked for. */
static sc_status push_frame(sc_run *run, const sc_frame_result *result, const sc_image *image,
                            sc_payload *pngs)
{
    const sc_ctx *ctx = run->app->ctx;
    const double begin_s = sc_wall_s();
    sc_status status;

    sc_signals_expendable(true);
    status = sc_encoder_push(ctx, run->worker.encoder,
                             sc_encoder_convert(run->worker.encoder, image), result->hash);
    if (status == SC_OK && run->session.job.output.frames == SC_FRAMES_PNG)
        status = add_png(ctx, pngs, image);
    sc_signals_expendable(false);
    run->worker.encode_wall_s += sc_wall_s() - begin_s;
    sc_trace_add(run->trace, SC_TRACE_ENCODE, run->app->threads, result->frame, begin_s,
                 sc_wall_s());
    return status;
}

static void clear_payload(sc_payload *payload)
{
    sc_free(payload->data);
}

/* End a GOP that begins with frame @p first, and pack it with its PNG files. */
static sc_status finish_gop(sc_run *run, int first, const sc_payload *pngs, sc_payload *out)
{
    const sc_ctx *ctx = run->app->ctx;
    const double begin_s = sc_wall_s();
    SC_OWN(clear_payload) sc_payload all = {0};
    SC_OWN(sc_segment_free) sc_segment segment = {0};
    sc_status status;

    sc_signals_expendable(true);
    status = sc_encoder_finish(ctx, run->worker.encoder, run->plan.identity, first, &segment);
    sc_signals_expendable(false);
    SC_PASS(status);
    SC_PASS(add_block(ctx, &all, segment.data, segment.bytes));
    if (pngs->bytes)
        SC_PASS(add_block(ctx, &all, pngs->data, pngs->bytes));
    run->worker.encode_wall_s += sc_wall_s() - begin_s;
    SC_HAND_OVER(all, out);
    return SC_OK;
}

/* Draw a frame into run->worker.gop_image and encode it; append its PNG file to @p pngs if asked
 * for. */
static sc_status draw_and_push(sc_run *run, int frame, sc_frame_result *result, sc_payload *pngs)
{
    const double wait_s = result->wait_s;

    *result = (sc_frame_result){.frame = frame, .wait_s = wait_s};
    SC_PASS(draw_rows(run, frame, NULL, &run->worker.gop_image, result));
    result->hash = sc_image_hash(&run->worker.gop_image);
    return push_frame(run, result, &run->worker.gop_image, pngs);
}

sc_status sc_run_draw_gop(void *user, int first, int count, sc_frame_result *results,
                          sc_payload *out)
{
    sc_run *run = user;
    const double begin_s = sc_wall_s();
    SC_OWN(clear_payload) sc_payload pngs = {0};

    if (!run->worker.gop_image.rgb)
        SC_PASS(sc_session_image(run->app, &run->session, &run->worker.gop_image));
    SC_PASS(open_gop_encoder(run));
    for (int i = 0; i < count; i++) {
        sc_status status;

        if (should_give_up(run, begin_s, i, count))
            return SC_OK;
        status = draw_and_push(run, first + i, &results[i], &pngs);
        if (status == SC_ERR_INCOMPLETE)
            return SC_OK; /* the GOP is given up */
        SC_PASS(status);
    }
    return finish_gop(run, first, &pngs, out);
}

sc_status sc_run_encode_frame(void *user, int first, int count, const sc_frame_result *result,
                              const sc_image *image, sc_payload *out)
{
    sc_run *run = user;

    if (result->frame == first) {
        sc_free(run->worker.gop_pngs.data);
        run->worker.gop_pngs = (sc_payload){0};
        SC_PASS(open_gop_encoder(run));
    }
    SC_PASS(push_frame(run, result, image, &run->worker.gop_pngs));
    if (result->frame == first + count - 1)
        return finish_gop(run, first, &run->worker.gop_pngs, out);
    return SC_OK;
}

/* ---- rank 0 ---- */

static sc_done_frame done_of(const sc_frame_result *result)
{
    return (sc_done_frame){.frame = result->frame,
                           .rank = result->rank,
                           .render_cpu_s = result->render_cpu_s,
                           .hash = result->hash};
}

/* Keep the timing record of an accepted frame, and add the time since @p begin_s to the trace. */
static void note_accepted(sc_run *run, const sc_frame_result *result, double begin_s)
{
    sc_trace_add(run->trace, SC_TRACE_ENCODE, run->app->threads, result->frame, begin_s,
                 sc_wall_s());
    run->root.results[run->root.result_count++] = *result;
}

sc_status sc_run_accept_frame(void *user, const sc_frame_result *result, const sc_image *image)
{
    sc_run *run = user;
    const sc_done_frame done = done_of(result);
    const double begin_s = sc_wall_s();
    sc_status status;

    SC_PASS(sc_inputs_check_files(run->app->ctx, run->session.inputs));
    sc_signals_expendable(true);
    status = run->root.store ? sc_store_add_frame(run->app->ctx, run->root.store, &done, image)
                             : sc_video_writer_push(run->app->ctx, run->root.writer, image);
    sc_signals_expendable(false);
    if (status == SC_OK)
        note_accepted(run, result, begin_s);
    return status;
}

sc_status sc_run_accept_gop(void *user, const sc_frame_result *results, int count,
                            const sc_payload *payload)
{
    sc_run *run = user;
    const sc_ctx *ctx = run->app->ctx;
    const bool png = run->session.job.output.frames == SC_FRAMES_PNG;
    const double begin_s = sc_wall_s();
    SC_OWN(sc_free_at) sc_done_frame *done = NULL;
    SC_OWN(sc_free_at) sc_segment *pngs = NULL;
    sc_segment segment, rest;
    size_t at = 0, within = 0;
    sc_status status;

    SC_PASS(sc_inputs_check_files(ctx, run->session.inputs));
    SC_PASS(SC_ALLOC(ctx, (size_t)count, &done));
    SC_PASS(SC_ZALLOC(ctx, (size_t)count, &pngs));
    if (!next_block(payload, &at, &segment) || (png && !next_block(payload, &at, &rest)))
        return sc_fail(ctx, SC_ERR_INTERNAL,
                       "a GOP has arrived from a rank with a payload that is cut off");
    for (int i = 0; i < count; i++) {
        const sc_payload inner = {png ? rest.data : NULL, png ? rest.bytes : 0};

        done[i] = done_of(&results[i]);
        if (png && !next_block(&inner, &within, &pngs[i]))
            return sc_fail(ctx, SC_ERR_INTERNAL,
                           "a GOP has arrived from a rank with a payload that is cut off");
    }
    sc_signals_expendable(true);
    status = sc_store_add_gop(ctx, run->root.store, done, count, &segment, png ? pngs : NULL);
    sc_signals_expendable(false);
    SC_PASS(status);
    for (int i = 0; i < count; i++)
        note_accepted(run, &results[i], begin_s);
    return SC_OK;
}
