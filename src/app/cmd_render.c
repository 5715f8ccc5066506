/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast render and segcast orbit: the farm around a session, and the files it leaves. */
#include "app.h"

#include "segcast/video.h"

#include <string.h>
#include <unistd.h>

typedef struct run_state {
    sc_app *app;
    sc_session session;
    int *frames, frame_count;
    double begin_s, farm_begin_s, farm_cpu_s;
    sc_status draw_status; /* of the drawing thread; read when that has ended */
    /* rank 0 only */
    const char *directory; /* of the outputs */
    bool keep_records;     /* manifest, status and statistics */
    char *video_path;
    sc_sink *video, *png;
    sc_manifest *manifest;
    sc_frame_result *results;
    int result_count;
    double encode_wall_s, write_wall_s, write_cpu_s;
    double told_s, status_s; /* when progress was last told */
} run_state;

/* ---- callbacks of the farm ---- */

static void draw(void *user, int frame, sc_image *image, sc_frame_result *result)
{
    run_state *run = user;
    sc_render_stats stats = {0};

    sc_status status = sc_session_draw(run->app, &run->session, frame, image, &stats);

    run->draw_status = status != SC_OK ? status : run->draw_status;
    result->render_wall_s = stats.wall_s;
    result->render_cpu_s = stats.cpu_s;
    result->rays = stats.counters.rays;
    result->samples = stats.counters.samples;
    result->contributions = stats.counters.contributions;
}

static sc_status take(void *user, const sc_frame_result *result, const sc_image *image)
{
    run_state *run = user;
    const sc_ctx *ctx = run->app->ctx;
    const double wall_s = sc_wall_s();
    double encoded_s, cpu_s;
    sc_status status = SC_OK;

    if (run->video)
        SC_TRY(sc_sink_push(ctx, run->video, result->frame, image));
    encoded_s = sc_wall_s();
    cpu_s = sc_thread_cpu_s();
    run->encode_wall_s += encoded_s - wall_s;
    if (run->png)
        SC_TRY(sc_sink_push(ctx, run->png, result->frame, image));
    if (run->manifest)
        SC_TRY(sc_manifest_add(ctx, run->manifest, result));
    run->write_wall_s += sc_wall_s() - encoded_s;
    run->write_cpu_s += sc_thread_cpu_s() - cpu_s;
    run->results[run->result_count++] = *result;
out:
    return status;
}

static void format_seconds(double seconds, char *text, size_t size)
{
    const long s = (long)(seconds + 0.5);

    if (s >= 3600)
        snprintf(text, size, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
    else
        snprintf(text, size, "%ld:%02ld", s / 60, s % 60);
}

static void tell_bar(run_state *run, int taken, int total, double rate, const char *left)
{
    enum { WIDTH = 30 };
    char bar[WIDTH + 1], text[160];

    memset(bar, '.', WIDTH);
    memset(bar, '#', (size_t)(WIDTH * (long)taken / total));
    bar[WIDTH] = '\0';
    snprintf(text, sizeof text, "[%s] %d/%d frames  %.2f/s  %s left", bar, taken, total, rate,
             left);
    sc_terminal_bar(run->app->terminal, text);
}

static void tick(void *user, int taken, int total)
{
    run_state *run = user;
    const double now_s = sc_wall_s(), elapsed_s = now_s - run->farm_begin_s;
    const double rate = elapsed_s > 0 ? taken / elapsed_s : 0;
    const double remaining_s = rate > 0 ? (total - taken) / rate : 0;
    const bool tty = run->app->terminal->is_tty;
    const sc_status_report report = {"running", taken,      total, now_s - run->begin_s,
                                     rate,      remaining_s};
    char left[32] = "?";

    if (rate > 0)
        format_seconds(remaining_s, left, sizeof left);
    if (tty && now_s - run->told_s > 0.2) {
        tell_bar(run, taken, total, rate, left);
        run->told_s = now_s;
    } else if (!tty && now_s - run->told_s > 5) {
        sc_info(run->app->ctx, "%d of %d frames (%.0f %%), %.2f frames/s, %s left", taken, total,
                100.0 * taken / total, rate, left);
        run->told_s = now_s;
    }
    /* Progress that cannot be told must not end the job; the frames themselves will notice. */
    if (run->keep_records && now_s - run->status_s > 2) {
        const sc_ctx silent = {.rank = 0};

        if (sc_status_write(&silent, run->directory, &report) == SC_OK)
            run->status_s = now_s;
    }
}

/* ---- outputs, rank 0 ---- */

/* What decides the pictures beside the volume: the job's keys and every tissue's resolved look,
 * which may come from a label table. */
static sc_status hash_job(const run_state *run, uint64_t *out)
{
    const sc_session *s = &run->session;
    const sc_ctx *ctx = run->app->ctx;
    sc_text text = {0};
    sc_status status;

    SC_TRY(sc_job_write(ctx, &s->job, true, &text));
    for (int id = 1; id < s->volume.label_count; id++) {
        const sc_tissue *t = &s->tissues[id];

        SC_TRY(sc_text_add(ctx, &text, "%lld %d %.17g %.17g %.9g %.9g %.9g\n",
                           (long long)s->volume.labels[id].value, t->visible, t->opacity,
                           t->interior_opacity, t->rgb_linear[0], t->rgb_linear[1],
                           t->rgb_linear[2]));
    }
    *out = sc_hash_bytes(text.data, text.length_bytes, 0);
out:
    sc_text_clear(&text);
    return status;
}

static sc_status write_job(run_state *run)
{
    const sc_ctx *ctx = run->app->ctx;
    const sc_session *s = &run->session;
    sc_text text = {0};
    sc_manifest_head head = {.version = sc_version(),
                             .volume_hash = s->volume.volume_hash,
                             .frames = s->job.animation.frames,
                             .width_px = s->job.output.size_px[0],
                             .height_px = s->job.output.size_px[1]};
    char *path = NULL;
    sc_status status;

    SC_TRY(sc_job_write(ctx, &s->job, false, &text));
    SC_TRY(hash_job(run, &head.job_hash));
    SC_TRY(sc_path_join(ctx, run->directory, "job.yaml", &path));
    SC_TRY(sc_file_write(ctx, path, text.data, text.length_bytes));
    status = sc_manifest_open(ctx, run->directory, &head, &run->manifest);
out:
    sc_text_clear(&text);
    sc_free(path);
    return status;
}

static sc_status open_video(run_state *run)
{
    const sc_job *job = &run->session.job;
    const sc_video_settings settings = {.width_px = job->output.size_px[0],
                                        .height_px = job->output.size_px[1],
                                        .fps = job->output.fps,
                                        .crf = job->output.crf,
                                        .preset = sc_job_preset(job)};
    sc_status status;

    if (!strcmp(job->output.video, "none"))
        return SC_OK;
    status = sc_path_join(run->app->ctx, run->directory, job->output.video, &run->video_path);
    if (status == SC_OK)
        status = sc_sink_open_video(run->app->ctx, run->video_path, &settings, &run->video);
    return status;
}

static sc_status open_outputs(run_state *run)
{
    const sc_ctx *ctx = run->app->ctx;
    char *frames = NULL;
    void *results;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)run->frame_count, sizeof *run->results, &results));
    run->results = results;
    SC_TRY(sc_make_directory(ctx, run->directory));
    if (run->keep_records) {
        SC_TRY(write_job(run));
        if (run->session.job.output.frames == SC_FRAMES_PNG) {
            SC_TRY(sc_path_join(ctx, run->directory, "frames", &frames));
            SC_TRY(sc_sink_open_png(ctx, frames, &run->png));
        }
    }
    status = open_video(run);
out:
    sc_free(frames);
    return status;
}

static sc_status finish_outputs(run_state *run, sc_status outcome)
{
    const sc_ctx *ctx = run->app->ctx;
    const bool complete = outcome == SC_OK;
    const double wall_s = sc_wall_s();
    sc_status status = outcome;

    if (complete || outcome == SC_ERR_INCOMPLETE) {
        status = SC_OK;
        if (run->video && run->result_count > 0)
            status = sc_sink_finish(ctx, run->video, complete);
        if (status == SC_OK && run->png)
            status = sc_sink_finish(ctx, run->png, complete);
        status = status == SC_OK ? outcome : status;
    }
    run->encode_wall_s += sc_wall_s() - wall_s;
    return status;
}

static sc_status write_state(run_state *run, sc_status outcome)
{
    const double elapsed_s = sc_wall_s() - run->begin_s;
    const sc_status_report report = {
        .state = outcome == SC_OK               ? "complete"
                 : outcome == SC_ERR_INCOMPLETE ? "incomplete"
                                                : "failed",
        .done = run->result_count,
        .total = run->frame_count,
        .elapsed_s = elapsed_s,
        .frames_per_s = elapsed_s > 0 ? run->result_count / elapsed_s : 0,
    };

    return run->keep_records ? sc_status_write(run->app->ctx, run->directory, &report) : SC_OK;
}

/* ---- statistics ---- */

static void fill_phases(run_state *run, const sc_farm_times *times)
{
    sc_rank_record *r = &run->session.times;
    const double farm_cpu_s = sc_cpu_s() - run->farm_cpu_s;
    double encode_cpu_s;

    r->phases[SC_PHASE_RENDER] = (sc_phase_time){times->render_wall_s, times->render_cpu_s};
    r->phases[SC_PHASE_GATHER] = (sc_phase_time){times->gather_wall_s, times->gather_cpu_s};
    r->phases[SC_PHASE_IDLE].wall_s += times->idle_s;
    if (sc_comm_rank(run->app->comm) == 0) {
        /* The encoder has threads of its own: what the farm used and nothing else did. */
        encode_cpu_s = farm_cpu_s - times->render_cpu_s - times->gather_cpu_s - run->write_cpu_s;
        r->phases[SC_PHASE_ENCODE] =
            (sc_phase_time){run->encode_wall_s, encode_cpu_s > 0 ? encode_cpu_s : 0};
        r->phases[SC_PHASE_WRITE] = (sc_phase_time){run->write_wall_s, run->write_cpu_s};
    }
    r->peak_rss_bytes = sc_peak_rss();
    r->cpu_s = sc_cpu_s();
}

static void summarise(const run_state *run, const sc_run_record *record)
{
    const sc_rank_record *r = record->rank_records;
    double render_cpu_s = 0;
    char wall[32];

    for (int i = 0; i < record->ranks; i++)
        render_cpu_s += r[i].phases[SC_PHASE_RENDER].cpu_s;
    format_seconds(record->wall_s, wall, sizeof wall);
    sc_info(run->app->ctx,
            "%d frames in %s (%.2f frames/s): reading %.1f s, preparing %.1f s; drawing %.3f CPU "
            "s/frame, encoding %.3f; imbalance %.0f %%",
            record->frame_count, wall,
            record->wall_s > 0 ? record->frame_count / record->wall_s : 0,
            r->phases[SC_PHASE_READ].wall_s, r->phases[SC_PHASE_PREPARE].wall_s,
            record->frame_count ? render_cpu_s / record->frame_count : 0,
            record->frame_count ? r->phases[SC_PHASE_ENCODE].cpu_s / record->frame_count : 0,
            100 * sc_run_imbalance(record));
}

/* Collective: the ranks' records come together on rank 0. */
static sc_status write_records(run_state *run)
{
    sc_app *app = run->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    char host[64] = "unknown";
    sc_run_record record = {.version = sc_version(),
                            .host = host,
                            .ranks = sc_comm_size(app->comm),
                            .nodes = sc_comm_node_count(app->comm),
                            .wall_s = sc_wall_s() - run->begin_s,
                            .frames = run->results,
                            .frame_count = run->result_count,
                            .volume_bytes = (uint64_t)run->session.volume.size[0] *
                                            (uint64_t)run->session.volume.size[1] *
                                            (uint64_t)run->session.volume.size[2] *
                                            (uint64_t)run->session.volume.label_bytes,
                            .prepared_bytes = run->session.shared_bytes};
    void *all = NULL;
    sc_status status = SC_OK;

    if (first)
        status = sc_alloc(app->ctx, (size_t)record.ranks, sizeof(sc_rank_record), &all);
    SC_TRY(sc_comm_agree(app->comm, status));
    sc_comm_gather(app->comm, &run->session.times, sizeof run->session.times, all);
    record.rank_records = all;
    gethostname(host, sizeof host - 1);
    if (first && run->keep_records)
        status = sc_run_write(app->ctx, &record, run->directory);
    if (first)
        summarise(run, &record);
out:
    sc_free(all);
    return status;
}

/* ---- the run ---- */

/* Threads that share a core make everything slow; say which flags mend it. */
static void check_placement(const sc_app *app)
{
    const int cores = sc_usable_cores();

    if (sc_comm_rank(app->comm) != 0)
        return;
    sc_info(app->ctx, "%d rank%s on %d node%s, %d thread%s each", sc_comm_size(app->comm),
            sc_comm_size(app->comm) == 1 ? "" : "s", sc_comm_node_count(app->comm),
            sc_comm_node_count(app->comm) == 1 ? "" : "s", app->threads,
            app->threads == 1 ? "" : "s");
    if (app->threads > cores)
        sc_warn(app->ctx,
                "%d threads share %d core%s; use mpirun --map-by slot:PE=%d, or srun "
                "--cpus-per-task=%d, or --threads %d",
                app->threads, cores, cores == 1 ? "" : "s", app->threads, app->threads, cores);
}

static sc_status run_farm(run_state *run)
{
    sc_app *app = run->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    const sc_farm farm = {.width_px = run->session.job.output.size_px[0],
                          .height_px = run->session.job.output.size_px[1],
                          .frames = run->frames,
                          .frame_count = run->frame_count,
                          .draw = draw,
                          .take = take,
                          .tick = tick,
                          .stop = sc_signals_install(),
                          .user = run};
    sc_farm_times times;
    sc_status status;

    run->farm_begin_s = run->told_s = sc_wall_s();
    run->farm_cpu_s = sc_cpu_s();
    status = sc_farm_run(app->ctx, app->comm, &farm, &times);
    status = sc_comm_agree(app->comm, status == SC_OK ? run->draw_status : status);
    sc_terminal_clear(app->terminal);
    if (first)
        status = finish_outputs(run, status);
    status = sc_comm_agree(app->comm, status);
    fill_phases(run, &times);
    return status;
}

static void clear_run(run_state *run)
{
    sc_sink_close(run->video);
    sc_sink_close(run->png);
    sc_manifest_close(run->manifest);
    sc_free(run->video_path);
    sc_free(run->results);
    sc_free(run->frames);
    sc_session_clear(&run->session);
}

static void tell_outcome(const run_state *run, sc_status outcome)
{
    if (sc_comm_rank(run->app->comm) != 0)
        return;
    if (outcome == SC_ERR_INCOMPLETE)
        sc_warn(run->app->ctx, "stopped on request after %d of %d frames; run again for the rest",
                run->result_count, run->frame_count);
    else if (outcome == SC_OK)
        printf("%s\n", run->video_path ? run->video_path : run->directory);
}

/* @p keep_records: write the folder of the job with its manifest and statistics. */
static sc_status run_job(sc_app *app, const char *job_path, bool keep_records)
{
    run_state run = {.app = app, .keep_records = keep_records, .begin_s = sc_wall_s()};
    const bool first = sc_comm_rank(app->comm) == 0;
    const sc_ctx silent = {.rank = 0};
    sc_status status, outcome;

    SC_TRY(sc_session_job(app, job_path, &run.session));
    SC_TRY(sc_frames_parse(first ? app->ctx : &silent, app->options.frames,
                           run.session.job.animation.frames, &run.frames, &run.frame_count));
    run.directory = keep_records && app->options.output ? app->options.output
                                                        : run.session.job.output.directory;
    check_placement(app);
    SC_TRY(sc_session_volume(app, &run.session));
    SC_TRY(sc_comm_agree(app->comm, first ? open_outputs(&run) : SC_OK));
    outcome = run_farm(&run);
    if (first && outcome != SC_OK && outcome != SC_ERR_INCOMPLETE)
        (void)write_state(&run, outcome); /* the first error is the one to report */
    status = outcome;
    if (outcome != SC_OK && outcome != SC_ERR_INCOMPLETE)
        goto out;
    SC_TRY(sc_comm_agree(app->comm, write_records(&run)));
    SC_TRY(sc_comm_agree(app->comm, first ? write_state(&run, outcome) : SC_OK));
    tell_outcome(&run, outcome);
    status = outcome;
out:
    clear_run(&run);
    return status;
}

sc_status sc_run_render(sc_app *app)
{
    return run_job(app, app->options.input, true);
}

sc_status sc_run_orbit(sc_app *app)
{
    const char *output = app->options.output ? app->options.output : "orbit.mp4";
    const char *slash = strrchr(output, '/');
    char directory[SC_PATH_BYTES];
    sc_status status;

    snprintf(directory, sizeof directory, "%.*s", slash ? (int)(slash - output) : 1,
             slash ? output : ".");
    SC_TRY(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_TRY(sc_options_set_text(app->ctx, &app->options, "output.directory", directory));
    SC_TRY(
        sc_options_set_text(app->ctx, &app->options, "output.video", slash ? slash + 1 : output));
    app->options.frames = NULL;
    status = run_job(app, NULL, false);
out:
    return status;
}
