/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast render and segcast orbit: a run, from the job to the finished outputs. */
#include "render/run.h"

#include <signal.h>
#include <time.h>

/* The number of events that all ranks together keep for the trace: about 100 MB of JSON. */
enum { TRACE_EVENTS = 1 << 20 };

/* ---- outputs, rank 0 ---- */

static sc_store_mode store_mode(const sc_app *app)
{
    return app->options.overwrite ? SC_STORE_OVERWRITE
           : app->options.resume  ? SC_STORE_RESUME
                                  : SC_STORE_NEW;
}

/* @return the name of the slice as the store takes it: NULL for the whole job. */
static const char *slice_of(const sc_run *run)
{
    return run->root.slice[0] ? run->root.slice : NULL;
}

/* Fill run->root.slice: the name of the slice, such that it can be part of a file name. "0-35:2,40"
 * becomes "0-35x2_40". It stays empty if all frames are wanted. */
static sc_status name_slice(sc_run *run)
{
    const sc_options *o = &run->app->options;
    const char *frames = o->part.frames;
    size_t used = 0;

    if (o->part.slices > 1)
        snprintf(run->root.slice, sizeof run->root.slice, "%dof%d", o->part.slice, o->part.slices);
    if (!frames || run->root.wanted_count == run->session.job.animation.frames)
        return SC_OK;
    for (const char *c = frames; *c; c++) {
        if (*c == ' ')
            continue;
        if (used + 1 >= sizeof run->root.slice)
            return sc_fail(run->app->ctx, SC_ERR_USAGE, "--frames is longer than %zu characters",
                           sizeof run->root.slice - 1);
        run->root.slice[used++] = *c == ':' ? 'x' : *c == ',' ? '_' : *c;
    }
    return SC_OK;
}

/* Append the job of a run as resolved. Its directory is that in which the text is to lie, so that
 * the text says the same wherever it is read from, and after the directory was moved. */
static sc_status add_resolved_job(const sc_run *run, sc_text *text)
{
    SC_OWN(sc_free_at) sc_job *copy = NULL;

    SC_PASS(SC_ALLOC(run->app->ctx, 1, &copy));
    *copy = run->session.job;
    strcpy(copy->output.directory, ".");
    return sc_job_write(run->app->ctx, copy, false, text);
}

/* Set *out to whether job.yaml in the directory of the run is the very file that was given. */
static sc_status is_job_given(const sc_run *run, bool *out)
{
    SC_OWN(sc_free_at) char *path = NULL;
    const sc_status status = sc_path_join(run->app->ctx, run->root.directory, "job.yaml", &path);

    *out = status == SC_OK && run->root.job_path && sc_same_file(run->root.job_path, path);
    return status;
}

/* Write job.yaml, the job as resolved, into the directory of the run; but where that is the very
 * file that was given, --overwrite leaves it alone unless its text stays the same, and others never
 * write it: what its user has written into it would be lost.
 * @param store NULL: only check. @return also SC_ERR_CREATE, logged, if it is left alone. */
static sc_status write_job(const sc_run *run, sc_store *store)
{
    const sc_ctx *ctx = run->app->ctx;
    SC_OWN(sc_text_clear) sc_text text = {0};
    SC_OWN(sc_free_at) char *path = NULL, *given = NULL;
    size_t bytes = 0;
    bool is_given;

    SC_PASS(add_resolved_job(run, &text));
    SC_PASS(sc_path_join(ctx, run->root.directory, "job.yaml", &path));
    SC_PASS(is_job_given(run, &is_given));
    if (is_given && run->app->options.overwrite) {
        SC_PASS(sc_file_read(ctx, path, (size_t)64 << 20, &given, &bytes));
        if (bytes != text.length_bytes || memcmp(given, text.data, bytes) != 0)
            return sc_fail(
                ctx, SC_ERR_CREATE,
                "%s: is the job that was given, and --overwrite would replace it by the job as "
                "resolved; copy it to another place first, or choose another directory with -o",
                path);
    }
    if (store && (!is_given || run->app->options.overwrite))
        return sc_store_write_job(ctx, store, text.data, text.length_bytes);
    return SC_OK;
}

/* One line of a text. */
typedef struct text_line {
    const char *text;
    size_t length; /* without its end */
} text_line;

/* Take the next line from *at. @return whether there is one. */
static bool next_line(const char **at, text_line *out)
{
    *out = (text_line){*at, strcspn(*at, "\n")};
    *at += out->length + ((*at)[out->length] != '\0');
    return out->length > 0;
}

/* The output directory was refused. If another job has run there, report the first line in which
 * its job.yaml differs from this job. All other reasons have been reported by the error. */
static void tell_difference(const sc_run *run)
{
    const sc_ctx quiet = sc_quiet(run->app->ctx);
    SC_OWN(sc_text_clear) sc_text mine = {0};
    SC_OWN(sc_free_at) char *path = NULL, *theirs = NULL;
    sc_store_job job = run->root.store_job, other = {.frames = 0};
    char version[64];
    text_line here, there, section = {"", 0};
    const char *a, *b;
    size_t bytes;

    if (job.keeps_job || sc_store_identify(&quiet, run->root.directory, &other, version) != SC_OK ||
        (other.job_hash == job.job_hash && other.volume_hash == job.volume_hash) ||
        add_resolved_job(run, &mine) != SC_OK ||
        sc_path_join(&quiet, run->root.directory, "job.yaml", &path) != SC_OK ||
        sc_file_read(&quiet, path, (size_t)64 << 20, &theirs, &bytes) != SC_OK)
        return;
    for (a = mine.data, b = theirs; next_line(&a, &here) && next_line(&b, &there);) {
        const int indent = (int)strspn(here.text, " ");

        if (indent == 0)
            section = here;
        if (here.length == there.length && !strncmp(here.text, there.text, here.length))
            continue;
        sc_warn(run->app->ctx, "the first difference is \"%.*s%s%.*s\", which was \"%.*s\"",
                indent ? (int)section.length : 0, section.text, indent ? " " : "",
                (int)here.length - indent, here.text + indent,
                (int)(there.length - strspn(there.text, " ")),
                there.text + strspn(there.text, " "));
        return;
    }
}

/* @return what the store has to know of the job, without its hashes; texts are borrowed. */
static sc_store_job store_job_of(const sc_run *run)
{
    const sc_job *job = &run->session.job;

    return (sc_store_job){.version = sc_version(),
                          .frames = job->animation.frames,
                          .video = job->output.video,
                          .png = job->output.frames == SC_FRAMES_PNG,
                          .settings = sc_run_video_settings(job),
                          .threads = run->app->threads};
}

/* Fill run->root.store_job, open run->root.store and, unless all is done and proven, write
 * job.yaml. */
static sc_status open_store(sc_run *run)
{
    const sc_session *s = &run->session;
    sc_store_job *job = &run->root.store_job;
    sc_status status;

    *job = store_job_of(run);
    SC_PASS(is_job_given(run, &job->keeps_job));
    job->volume_hash = sc_inputs_hash(s->inputs);
    SC_PASS(sc_run_hash_job(run, &job->job_hash));
    status = sc_store_open(run->app->ctx, run->root.directory, job, run->root.wanted,
                           run->root.wanted_count, slice_of(run), store_mode(run->app),
                           &run->root.store);
    if (status == SC_ERR_CREATE)
        tell_difference(run);
    SC_PASS(status);
    sc_store_begun_clear(&run->root.begun); /* now it is the store's */
    run->plan.complete = sc_store_is_complete(run->root.store);
    run->plan.sealed = sc_store_is_sealed(run->root.store);
    run->plan.identity = sc_store_identity(run->root.store);
    if (!run->plan.sealed)
        return write_job(run, run->root.store);
    return SC_OK;
}

/* Open the store or, without records, the video writer. On rank 0. */
static sc_status open_outputs(sc_run *run)
{
    const sc_ctx *ctx = run->app->ctx;
    const sc_job *job = &run->session.job;
    sc_video_settings settings = sc_run_video_settings(job);

    SC_PASS(SC_ZALLOC(ctx, (size_t)run->root.wanted_count + 1, &run->root.results));
    if (sc_run_has_video(job) && !run->root.video_path)
        SC_PASS(sc_path_join(ctx, run->root.directory, job->output.video, &run->root.video_path));
    if (run->keep_records)
        return open_store(run);
    settings.version = sc_version();
    settings.volume_hash = sc_inputs_hash(run->session.inputs);
    SC_PASS(sc_run_hash_job(run, &settings.job_hash));
    return sc_video_writer_open(ctx, run->root.video_path, &settings, &run->root.writer);
}

/* ---- the plan ---- */

/* Choose, on rank 0, of @p gops [whole], which no run has begun, those that other ranks encode;
 * they are put at the beginning of the array. @return as of sc_run_check_gathering. */
static sc_status choose_gops(sc_run *run, int *gops, int whole)
{
    sc_draw_plan *plan = &run->plan;
    const sc_run_ranks where = {.ranks = sc_comm_size(run->app->comm),
                                .nodes = sc_comm_node_count(run->app->comm),
                                .memory_max_bytes = run->app->ctx->memory_max_bytes};
    const sc_run_ranks unlimited = {.ranks = where.ranks, .nodes = where.nodes};
    const int frames = run->session.job.animation.frames;
    const int full = whole - (whole > 0 && gops[whole - 1] + plan->gop_frames > frames);
    const sc_run_encoding encoding = sc_run_encoding_of(&run->session.job, whole, full, &where);
    const sc_run_encoding wanted = sc_run_encoding_of(&run->session.job, whole, full, &unlimited);

    plan->gop_count = encoding.gops;
    plan->gather = encoding.gather;
    plan->encoders_most = encoding.encoders_most;
    if (encoding.gather)
        memmove(gops, gops + full - encoding.gops, (size_t)encoding.gops * sizeof *gops);
    return sc_run_check_gathering(run->app->ctx, &run->session.job, wanted.gather ? wanted.gops : 0,
                                  &where);
}

/* Find out, on rank 0, what is left to be drawn, from run->root.wanted and the store: fills
 * run->plan, run->gops and run->frames. */
static sc_status make_plan(sc_run *run)
{
    const sc_ctx *ctx = run->app->ctx;
    sc_draw_plan *plan = &run->plan;
    const sc_video_settings settings = sc_run_video_settings(&run->session.job);
    SC_OWN(sc_free_at) int *gops = NULL, *frames = NULL;
    int whole = 0, g = 0;

    plan->gop_frames = sc_video_gop_frames(&settings);
    if (run->root.store)
        SC_PASS(sc_store_whole_gops(ctx, run->root.store, &gops, &whole));
    if (run->keep_records)
        SC_PASS(choose_gops(run, gops, whole));
    SC_PASS(SC_ALLOC(ctx, (size_t)run->root.wanted_count + 1, &frames));
    for (int i = 0; i < run->root.wanted_count; i++) {
        const int k = run->root.wanted[i];

        while (g < plan->gop_count && gops[g] + plan->gop_frames <= k)
            g++;
        if (g < plan->gop_count && k >= gops[g])
            continue; /* it is drawn with its GOP */
        if (run->root.store && sc_store_has(run->root.store, k))
            plan->kept++;
        else
            frames[plan->frame_count++] = k;
    }
    SC_HAND_OVER(frames, &run->frames);
    SC_HAND_OVER(gops, &run->gops);
    return SC_OK;
}

/* Send the plan, with frames and gops, from rank 0 to all others. Collective. */
static sc_status share_plan(sc_run *run)
{
    sc_app *app = run->app;

    sc_comm_broadcast(app->comm, &run->plan, sizeof run->plan);
    SC_PASS(SC_BROADCAST(app, (size_t)run->plan.frame_count, &run->frames));
    return SC_BROADCAST(app, (size_t)run->plan.gop_count, &run->gops);
}

/* ---- the run ---- */

/* On rank 0: complete the outputs, unless the farm ended with an error. @return @p outcome, or the
 * error that came here. */
static sc_status finish_outputs(sc_run *run, sc_status outcome)
{
    const sc_ctx *ctx = run->app->ctx;
    const double begin_s = sc_wall_s();
    sc_status status = outcome;

    if (outcome != SC_OK && outcome != SC_ERR_INCOMPLETE)
        return outcome;
    SC_PASS(sc_inputs_check_files(ctx, run->session.inputs));
    sc_signals_expendable(true);
    if (run->root.store && !run->root.slice[0])
        status = sc_store_finish(ctx, run->root.store, &run->root.missing);
    else if (!run->root.store && run->root.result_count > 0)
        status = sc_video_writer_finish(ctx, run->root.writer, outcome == SC_OK,
                                        run->app->options.overwrite);
    sc_signals_expendable(false);
    sc_trace_add(run->trace, SC_TRACE_FINISH, run->app->threads, -1, begin_s, sc_wall_s());
    return status == SC_OK ? outcome : status;
}

/* Has another run begun in the directory meanwhile, or completed the job? Its records must stay. */
static bool is_replaced(const sc_run *run)
{
    return run->root.store && sc_store_is_replaced(run->root.store);
}

/* On rank 0 of a run that is_replaced: leave the directory to the other run, whatever has failed
 * since, which may have been told as an error. @return SC_ERR_INCOMPLETE. */
static sc_status give_way(sc_run *run)
{
    run->plan.replaced = true;
    sc_warn(run->app->ctx,
            "%s: another run has begun in this directory meanwhile, and has it now; this one ends. "
            "`segcast status %s` tells how far the job is",
            run->root.directory, run->root.directory);
    return SC_ERR_INCOMPLETE;
}

/* On rank 0, when everything of the run is written: a slice completes the job if it is the last to
 * end; then the manifest of a complete job is closed. */
static sc_status close_outputs(sc_run *run)
{
    const sc_ctx *ctx = run->app->ctx;
    sc_status status = SC_OK;

    if (!run->root.store)
        return SC_OK;
    if (run->root.slice[0]) {
        SC_TRY(sc_store_end_slice(ctx, run->root.store));
        SC_TRY(sc_store_finish(ctx, run->root.store, &run->root.missing));
    }
    run->plan.complete = sc_store_is_complete(run->root.store);
    if (run->plan.complete || !run->root.slice[0])
        SC_TRY(sc_write_crate(ctx, run->root.directory, &run->session.job, &run->root.store_job,
                              run->plan.complete));
    status = sc_store_seal(ctx, run->root.store);
out:
    return status == SC_ERR_INCOMPLETE ? give_way(run) : status;
}

/* For sc_display_watch, with a run as user: write status.json while it is this run's. */
static void watch(void *user, const sc_stage_view *view)
{
    if (!is_replaced(user))
        sc_run_watch(user, view);
}

/* Draw everything in the plan; returns when all outputs are complete. @param times of this rank.
 * Collective. */
static sc_status run_farm(sc_run *run, sc_farm_times *times)
{
    sc_app *app = run->app;
    const sc_job *job = &run->session.job;
    const sc_farm farm = {.width_px = job->output.size_px[0],
                          .height_px = job->output.size_px[1],
                          .alpha = job->render.background.is_none,
                          .partition = (sc_partition)job->farm.partition,
                          .frames = run->frames,
                          .frame_count = run->plan.frame_count,
                          .gops = run->gops,
                          .gop_count = run->plan.gop_count,
                          .gather = run->plan.gather,
                          .encoders_most = run->plan.encoders_most,
                          .gop_frames = run->plan.gop_frames,
                          .total_frames = job->animation.frames,
                          .calls.draw = sc_run_draw,
                          .share_frames = job->farm.share,
                          .spoils_other_rows = sc_job_has_views(job),
                          .calls.draw_gop = sc_run_draw_gop,
                          .calls.encode_frame = sc_run_encode_frame,
                          .calls.accept_frame = sc_run_accept_frame,
                          .calls.accept_gop = sc_run_accept_gop,
                          .calls.on_progress = sc_run_on_progress,
                          .stop = run->stop,
                          .deadline_s = run->clock.deadline_s,
                          .calls.user = run};
    sc_status status;

    sc_stage_begin(app->ctx, SC_STAGE_DRAWING, (uint64_t)run->plan.kept,
                   (uint64_t)run->root.wanted_count);
    run->clock.farm_begin_s = sc_wall_s();
    run->clock.farm_cpu_s = sc_cpu_s();
    status = sc_farm_run(app->ctx, app->comm, &farm, times);
    sc_signals_stop_in_order(false); /* what was drawn is on disk */
    sc_stage_begin(app->ctx, "completing", 0, 0);
    if (sc_comm_rank(app->comm) == 0)
        status = finish_outputs(run, status);
    if (status != SC_OK && is_replaced(run))
        status = give_way(run);
    status = sc_comm_agree(app->comm, status);
    sc_comm_broadcast(app->comm, &run->plan.replaced, sizeof run->plan.replaced);
    sc_run_fill_phases(run, times);
    return status;
}

static void clear_run(sc_run *run)
{
    sc_display_watch(run->app->display, NULL, NULL);
    sc_store_unbegin(&run->root.begun);
    sc_video_writer_close(run->root.writer);
    sc_store_close(run->root.store);
    sc_encoder_close(run->worker.encoder);
    sc_image_clear(&run->worker.gop_image);
    sc_free(run->worker.gop_pngs.data);
    run->app->trace = NULL;
    sc_trace_free(run->trace);
    sc_free(run->worker.spans);
    sc_free(run->root.made_from);
    sc_free(run->root.video_path);
    sc_free(run->root.results);
    sc_free(run->frames);
    sc_free(run->gops);
    sc_free(run->root.wanted);
    sc_history_clear(&run->root.earlier);
    sc_session_clear(&run->session);
}

/* On rank 0: log why a run is incomplete and what to do, or print the path of what it has made. */
static void report_outcome(const sc_run *run, sc_status outcome)
{
    const sc_ctx *ctx = run->app->ctx;
    const char *reason =
        *run->stop == SIGXCPU ? "because the limit of CPU time is reached (ulimit -t)"
        : run->clock.deadline_s > 0 && !*run->stop ? "because the time is nearly up"
                                                   : "on request";

    if (sc_comm_rank(run->app->comm) != 0)
        return;
    if (outcome == SC_ERR_INCOMPLETE && run->clock.deadline_s > 0 && !*run->stop &&
        run->root.result_count == 0)
        sc_warn(ctx, "no frame could be finished in the time; running again with the same limit "
                     "will not help: more time, or `segcast convert`, will");
    if (outcome == SC_ERR_INCOMPLETE)
        sc_warn(ctx, "stopped %s after %d of %d frames; %s", reason,
                run->plan.kept + run->root.result_count, run->root.wanted_count,
                run->keep_records ? "run again with --resume for the rest"
                                  : "the next run begins anew: what can go on is a job (`segcast "
                                    "init`, `segcast render`)");
    else if (outcome == SC_OK && run->root.store && run->root.missing == 0 &&
             !sc_store_is_complete(run->root.store))
        sc_info(ctx,
                "%s: all frames are there; another slice that has not ended yet, or `segcast join "
                "%s`, completes the job",
                run->root.directory, run->root.directory);
    else if (outcome == SC_OK && run->root.missing > 0)
        sc_info(ctx,
                "%s: %d frames of other slices are not there yet; the last slice, or `segcast join "
                "%s`, completes the job",
                run->root.directory, run->root.missing, run->root.directory);
    if (outcome == SC_OK)
        sc_print_made(run->root.video_path &&
                              (!run->root.store || sc_store_is_complete(run->root.store))
                          ? run->root.video_path
                          : run->root.directory);
}

/* On rank 0, of a run that writes the video alone: make its directory, and check that the video can
 * be written there. Fills run->root.video_path. */
static sc_status prepare_video(sc_run *run)
{
    const sc_ctx *ctx = run->app->ctx;

    SC_PASS(sc_path_join(ctx, run->root.directory, run->session.job.output.video,
                         &run->root.video_path));
    SC_PASS(sc_make_directory(ctx, run->root.directory));
    if (run->app->options.overwrite) /* what runs that were killed have left beside the video */
        sc_remove_temporaries(run->root.directory, false);
    return sc_check_output(run->app, &run->session.job, run->root.video_path, true);
}

/* Refuse options that exclude each other. @return the first mistake; all are logged. */
static sc_status check_use(const sc_app *app)
{
    const sc_options *o = &app->options;
    sc_status status = SC_OK;

    if (o->overwrite && (o->resume || o->part.frames || o->part.slices))
        status = sc_fail(app->ctx, SC_ERR_USAGE,
                         "--overwrite cannot be used with --resume, nor with --frames or --slice: "
                         "slices share a directory");
    if (o->part.frames && o->part.slices)
        status = sc_fail(app->ctx, SC_ERR_USAGE, "--frames and --slice exclude each other");
    return status;
}

/* On rank 0, before anything that takes long: fill run->root.directory, run->root.wanted
 * and run->root.slice, and refuse a directory that holds a run already. */
static sc_status prepare_run(sc_run *run)
{
    const sc_app *app = run->app;
    const sc_job *job = &run->session.job;
    const sc_options *o = &app->options;
    const sc_video_settings settings = sc_run_video_settings(job);

    run->root.directory =
        run->keep_records && app->options.output ? app->options.output : job->output.directory;
    if (o->part.slices)
        SC_PASS(sc_frames_slice(app->ctx, o->part.slice, o->part.slices,
                                sc_video_gop_frames(&settings), job->animation.frames,
                                &run->root.wanted, &run->root.wanted_count));
    else
        SC_PASS(sc_frames_parse(app->ctx, o->part.frames, job->animation.frames, &run->root.wanted,
                                &run->root.wanted_count));
    SC_PASS(name_slice(run));
    if (run->keep_records) {
        const sc_store_job store_job = store_job_of(run);

        SC_PASS(sc_store_check(app->ctx, run->root.directory, &store_job, slice_of(run),
                               store_mode(app)));
        SC_PASS(write_job(run, NULL));
        return sc_store_begin(app->ctx, run->root.directory, &store_job, slice_of(run),
                              store_mode(app), &run->root.begun);
    }
    return prepare_video(run);
}

/* Allocate what every rank needs for its timing records: run->trace and run->worker.spans. */
static sc_status allocate_records(sc_run *run)
{
    const sc_app *app = run->app;
    const size_t events = (size_t)TRACE_EVENTS / (size_t)sc_comm_size(app->comm) + 256;

    SC_PASS(sc_trace_new(app->ctx, events, &run->trace));
    return SC_ALLOC(app->ctx, (size_t)app->threads, &run->worker.spans);
}

/* Everything before the first frame: job, volume, outputs, plan. Collective. */
static sc_status begin_run(sc_run *run, const char *job_path)
{
    sc_app *app = run->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_status status;

    SC_PASS(sc_defer(app, first ? check_use(app) : SC_OK));
    SC_PASS(sc_session_job(app, job_path, &run->session));
    /* From here on the first error ends the run. Threads that work at the same time, and the last
     * status.json, can fail for the same reason. */
    app->terminal->one_error = true;
    SC_PASS(sc_comm_agree(app->comm,
                          first ? sc_run_check_encoder(app->ctx, &run->session.job) : SC_OK));
    SC_PASS(sc_comm_agree(app->comm, allocate_records(run)));
    SC_PASS(sc_comm_agree(app->comm, first ? prepare_run(run) : SC_OK));
    if (first && run->keep_records)
        sc_warn_of_outputs(app, &run->session.job);
    SC_PASS(sc_report_placement(app));
    run->clock.deadline_s = sc_deadline_s(app);
    app->trace = run->trace;
    if (run->root.begun.may_write)
        sc_display_watch(app->display, sc_run_watch, run);
    SC_PASS(sc_session_volume(app, &run->session));
    sc_signals_stop_in_order(true);
    /* While what an earlier run has made is removed, no new status.json may come: it would be taken
     * for a file of somebody else. This also waits for one that is being written. */
    if (app->options.overwrite)
        sc_display_watch(app->display, NULL, NULL);
    SC_PASS(sc_comm_agree(app->comm, first ? open_outputs(run) : SC_OK));
    SC_PASS(sc_comm_agree(app->comm, first && !run->plan.complete ? make_plan(run) : SC_OK));
    status = share_plan(run);
    if (run->plan.complete)
        run->plan.kept = run->root.wanted_count;
    atomic_store(&run->root.frames_done, run->plan.kept);
    if (first && run->keep_records && !run->plan.complete)
        sc_display_watch(app->display, watch, run);
    if (first && run->plan.sealed)
        sc_info(app->ctx, "%s: the job is complete, and verified; there is nothing to do",
                run->root.directory);
    else if (first && run->plan.complete)
        sc_info(app->ctx, "%s: the job is complete, and verified; only its records are written",
                run->root.directory);
    else if (first && run->plan.kept)
        sc_info(app->ctx, "%s: %d of %d frames are there, and verified", run->root.directory,
                run->plan.kept, run->root.wanted_count);
    return status;
}

/* Do a run from start to end. @param run zeroed but for app, keep_records and what is measured;
 * cleared at the end. Collective. */
static sc_status run_job(sc_run *run, const char *job_path)
{
    sc_app *app = run->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_farm_times times = {0};
    sc_status status, outcome = SC_OK;

    run->root.job_path = job_path;
    run->clock.begin_s = sc_wall_s();
    run->clock.begin_unix_s = (int64_t)time(NULL);
    run->stop = sc_signals_catch_stop();
    run->give_up = sc_signals_give_up();
    SC_TRY(begin_run(run, job_path));
    SC_TRY(sc_run_begin_records(run));
    if (!run->plan.complete) {
        outcome = run_farm(run, &times);
        sc_display_watch(app->display, NULL, NULL);
        if (first && outcome != SC_OK && outcome != SC_ERR_INCOMPLETE && !is_replaced(run))
            (void)sc_run_write_state(run, outcome); /* the first error is the one to report */
        status = outcome;
        if (run->plan.replaced || (outcome != SC_OK && outcome != SC_ERR_INCOMPLETE))
            goto out;
    }
    sc_display_watch(app->display, NULL, NULL);
    if (!run->plan.sealed) {
        SC_TRY(sc_comm_agree(app->comm, sc_run_write_records(run, &times)));
        SC_TRY(sc_comm_agree(app->comm, first ? sc_run_write_state(run, outcome) : SC_OK));
        SC_TRY(sc_comm_agree(app->comm, first ? close_outputs(run) : SC_OK));
    }
    if (!run->observe) {
        sc_display_end_stage(app);
        report_outcome(run, outcome);
    }
    status = outcome;
out:
    if (*run->give_up) { /* closing an encoder that holds frames takes its time */
        sc_signals_tell(false, false);
        sc_signals_expendable(true);
    }
    clear_run(run);
    return status;
}

sc_status sc_run_measured(sc_app *app, const char *job_path, sc_run_observer *observe, void *user)
{
    sc_run run = {.app = app,
                  .keep_records = true,
                  .clock.begin_cpu_s = sc_cpu_s(),
                  .observe = observe,
                  .observer = user};

    return run_job(&run, job_path);
}

sc_status sc_cmd_render(sc_app *app)
{
    sc_run run = {.app = app, .keep_records = true};

    return run_job(&run, app->options.input);
}

sc_status sc_cmd_orbit(sc_app *app)
{
    const char *output = app->options.output ? app->options.output : "orbit.mp4";
    const char *name = sc_file_name(output);
    sc_run run = {.app = app};
    SC_OWN(sc_free_at) char *directory = NULL;
    sc_text origin = {0};
    sc_status status = SC_OK;

    if (!*name)
        status = sc_fail(app->ctx, SC_ERR_USAGE,
                         "--output is \"%s\", a directory; expected the name of a video in it, "
                         "such as %sorbit.mp4",
                         output, output);
    SC_TRY(status);
    SC_TRY(sc_folder_of(app->ctx, output, &directory));
    SC_TRY(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_TRY(sc_expect_series(app));
    SC_TRY(sc_options_default(app->ctx, &app->options, "look", "studio"));
    SC_TRY(sc_options_set_text(app->ctx, &app->options, "output.directory", directory));
    SC_TRY(sc_text_add(app->ctx, &origin, "--output %s", output));
    SC_TRY(sc_options_set_as(app->ctx, &app->options, origin.data, "output.video", name));
    app->options.part.frames = NULL;
out:
    sc_text_clear(&origin);
    status = sc_comm_agree(app->comm, status);
    return status == SC_OK ? run_job(&run, NULL) : status;
}
