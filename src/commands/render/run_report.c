/* SPDX-License-Identifier: BSD-3-Clause */
/* The progress of a run, and the timing records at its end. */
#include "render/run.h"
#include "segcast/report.h"

#include <stdlib.h>
#include <time.h>
#include <unistd.h>

/* Make "DIR/NAME.ENDING", or for a slice, which shares the directory with others,
 * "DIR/NAME.SLICE.ENDING". @param ctx where errors go. */
static sc_status record_path(const sc_ctx *ctx, const sc_run *run, const char *name,
                             const char *ending, char **out)
{
    sc_text text = {0};

    SC_PASS(sc_text_add(ctx, &text, "%s/%s%s%s.%s", run->root.directory, name,
                        run->root.slice[0] ? "." : "", run->root.slice, ending));
    *out = text.data;
    return SC_OK;
}

/* Write status.json. @param ctx where errors go. */
static sc_status write_status(const sc_run *run, const sc_ctx *ctx,
                              const sc_progress_report *report)
{
    SC_OWN(sc_free_at) char *path = NULL;
    sc_progress_report signed_report = *report;
    char process[sizeof run->session.times.host + 32];

    snprintf(process, sizeof process, "%s:%ld", run->session.times.host, (long)getpid());
    signed_report.run = sc_batch_job() ? sc_batch_job() : process;
    SC_PASS(record_path(ctx, run, "status", "json", &path));
    return sc_progress_write(ctx, path, &signed_report);
}

void sc_run_on_progress(void *user, int done, int total)
{
    sc_run *run = user;
    const int before = atomic_exchange(&run->root.frames_done, run->plan.kept + done);

    sc_stage_add(run->app->ctx, (uint64_t)(run->plan.kept + done - before));
}

void sc_run_watch(void *user, const sc_stage_view *view)
{
    const sc_run *run = user;
    const bool draws = !strcmp(view->name, SC_STAGE_DRAWING);
    const sc_ctx silent = {.rank = 0};
    const sc_progress_report report = {.state = "running",
                                       .phase = view->text,
                                       .phase_share = view->share,
                                       .done = atomic_load(&run->root.frames_done),
                                       .total = run->root.wanted_count,
                                       .elapsed_s = sc_wall_s() - run->clock.begin_s,
                                       .frames_per_s = draws ? view->rate : 0,
                                       .remaining_s = view->left_s};

    /* A status.json that cannot be written does not end the run. If the disk is full, writing
     * frames will fail and say so. */
    (void)write_status(run, &silent, &report);
}

sc_status sc_run_write_state(sc_run *run, sc_status outcome)
{
    const double elapsed_s = sc_wall_s() - run->clock.begin_s;
    const sc_progress_report report = {
        .state = outcome == SC_OK               ? "complete"
                 : outcome == SC_ERR_INCOMPLETE ? "incomplete"
                                                : "failed",
        .done = run->plan.kept + run->root.result_count,
        .total = run->root.wanted_count,
        .elapsed_s = elapsed_s,
        .frames_per_s = elapsed_s > 0 ? run->root.result_count / elapsed_s : 0,
    };

    return run->keep_records ? write_status(run, run->app->ctx, &report) : SC_OK;
}

void sc_run_fill_phases(sc_run *run, const sc_farm_times *times)
{
    sc_rank_record *r = &run->session.times;
    const double farm_cpu_s = sc_cpu_s() - run->clock.farm_cpu_s;
    const sc_store_times store = run->root.store ? sc_store_time(run->root.store)
                                                 : (sc_store_times){times->accept_wall_s, 0};
    /* The CPU time of the encoder's own threads cannot be measured by itself: it is what is left of
     * the CPU time that the process used during the farm. */
    const double rest_cpu_s = farm_cpu_s - times->render_cpu_s - times->gather_cpu_s;

    r->phases[SC_PHASE_RENDER] = (sc_phase_time){times->render_wall_s, times->render_cpu_s};
    r->phases[SC_PHASE_GATHER] = (sc_phase_time){times->gather_wall_s, times->gather_cpu_s};
    r->phases[SC_PHASE_IDLE].wall_s += times->idle_s;
    r->phases[SC_PHASE_ENCODE] =
        (sc_phase_time){run->worker.encode_wall_s, rest_cpu_s > 0 ? rest_cpu_s : 0};
    if (sc_comm_rank(run->app->comm) == 0) {
        r->phases[SC_PHASE_ENCODE].wall_s += store.encode_wall_s;
        r->phases[SC_PHASE_WRITE].wall_s = store.write_wall_s;
    }
    r->accept_wall_s = times->accept_wall_s;
    r->farm_idle_s = times->idle_s;
    r->peak_rss_bytes = sc_peak_rss_since();
    r->cpu_s = sc_cpu_s() - run->clock.begin_cpu_s;
    sc_host_name(r->host);
}

/* ---- the timing records of all ranks ---- */

static int by_frame(const void *a, const void *b)
{
    return ((const sc_frame_result *)a)->frame - ((const sc_frame_result *)b)->frame;
}

/* Write trace.json; arguments as of sc_trace_write. */
static sc_status write_trace(sc_run *run, const sc_rank_record *records, const void *events,
                             const size_t *counts, size_t stride)
{
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(record_path(run->app->ctx, run, "trace", "json", &path));
    return sc_trace_write(run->app->ctx, path, sc_comm_size(run->app->comm), records, events,
                          counts, stride);
}

/* Gather the trace events of all ranks on rank 0, which writes trace.json. @p records is NULL on
 * the others. Collective. */
static sc_status gather_trace(sc_run *run, const sc_rank_record *records)
{
    sc_app *app = run->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    const size_t ranks = (size_t)sc_comm_size(app->comm);
    size_t count = sc_trace_count(run->trace), largest = 1;
    SC_OWN(sc_free_at) size_t *counts = NULL;
    SC_OWN(sc_free_at) sc_trace_event *mine = NULL, *all = NULL;

    SC_PASS(sc_comm_gather(app->ctx, app->comm, &count, sizeof count, &counts));
    for (size_t i = 0; first && i < ranks; i++)
        largest = counts[i] > largest ? counts[i] : largest;
    sc_comm_broadcast(app->comm, &largest, sizeof largest);
    SC_PASS(sc_comm_agree(app->comm, SC_ZALLOC(app->ctx, largest, &mine)));
    if (first && sc_trace_dropped(run->trace))
        sc_info(app->ctx,
                "trace.json holds only the first %zu events of each rank; later ones found no room",
                count);
    if (count)
        memcpy(mine, sc_trace_events(run->trace), count * sizeof(sc_trace_event));
    SC_PASS(sc_comm_gather(app->ctx, app->comm, mine, largest * sizeof *mine, &all));
    return first ? write_trace(run, records, all, counts, largest) : SC_OK;
}

/* Drop from @p history the frames that are not there any more, such as those of damaged segments.
 */
static void drop_lost_frames(const sc_run *run, sc_history *history)
{
    int kept = 0;

    for (int i = 0; i < history->frame_count; i++) {
        const int frame = history->frames[i].result.frame;

        if (frame < run->root.store_job.frames && sc_store_has(run->root.store, frame))
            history->frames[kept++] = history->frames[i];
    }
    history->frame_count = kept;
}

/* Add to @p history the wanted frames that are there and of which it knows nothing: a run that was
 * killed has drawn them. @param from index of that run, or -1. */
static sc_status add_unmeasured(const sc_run *run, sc_history *history, int from)
{
    int count = 0, known = 0;
    SC_OWN(sc_free_at) sc_frame_result *frames = NULL;

    SC_PASS(SC_ALLOC(run->app->ctx, (size_t)run->root.wanted_count, &frames));
    for (int i = 0; i < run->root.wanted_count; i++) {
        const int k = run->root.wanted[i];
        const sc_done_frame *done = sc_store_done(run->root.store, k);

        while (known < history->frame_count && history->frames[known].result.frame < k)
            known++;
        if (!done || !sc_store_has(run->root.store, k) ||
            (known < history->frame_count && history->frames[known].result.frame == k))
            continue;
        frames[count++] = (sc_frame_result){
            .frame = k, .rank = done->rank, .render_cpu_s = done->render_cpu_s, .hash = done->hash};
    }
    return sc_history_add(run->app->ctx, history, frames, count, from);
}

/* Read into run->root.earlier, once and before the first frame, what earlier runs have measured of
 * frames that are there: from the statistics @p path, and for the whole job from those of slices.
 * Does nothing without --resume. */
static sc_status read_history(sc_run *run, const char *path)
{
    const sc_job_hashes job = {run->root.store_job.job_hash, run->root.store_job.volume_hash};
    sc_history *history = &run->root.earlier;
    int last;

    if (run->root.has_earlier || !run->app->options.resume)
        return SC_OK;
    SC_PASS(sc_history_read(run->app->ctx, path, &job, history));
    last = history->run_count - 1;
    if (!run->root.slice[0])
        SC_PASS(sc_history_read_slices(run->app->ctx, run->root.directory, &job, history));
    drop_lost_frames(run, history);
    /* Each run puts itself into the statistics before it draws. So frames of which they say nothing
     * were drawn by the last run of this file if it was killed, unless a slice may have done it. */
    if (last >= 0 && (last != history->run_count - 1 || history->runs[last].ended))
        last = -1;
    SC_PASS(add_unmeasured(run, history, last));
    run->root.has_earlier = true;
    return SC_OK;
}

/* Write stats.json and frames.csv, with what earlier runs have measured. On rank 0. */
static sc_status write_run(sc_run *run, sc_run_record *record)
{
    SC_OWN(sc_free_at) char *json = NULL, *csv = NULL;
    SC_OWN(sc_text_clear) sc_text settings = {0};
    sc_status status;

    SC_PASS(record_path(run->app->ctx, run, "stats", "json", &json));
    SC_PASS(record_path(run->app->ctx, run, "frames", "csv", &csv));
    SC_PASS(read_history(run, json));
    status = sc_job_write_json(run->app->ctx, &run->session.job, &settings);
    if (status != SC_OK && status != SC_ERR_DATA)
        return status;
    record->settings = settings.data; /* NULL if a path is not UTF-8, so that JSON cannot hold it */
    record->earlier = &run->root.earlier;
    status = sc_run_write(run->app->ctx, record, json, csv);
    record->settings = NULL;
    record->earlier = NULL;
    return status;
}

void sc_processor_name(char *text, int size)
{
    FILE *file = fopen("/proc/cpuinfo", "r");

    text[0] = '\0';
    while (file && fgets(text, size, file)) {
        const char *colon = strchr(text, ':');

        if (!strncmp(text, "model name", 10) && colon) {
            memmove(text, colon + 2, strlen(colon + 2) + 1);
            text[strcspn(text, "\n")] = '\0';
            break;
        }
        text[0] = '\0';
    }
    if (file)
        fclose(file);
}

const char *sc_batch_job(void)
{
    static const char *const names[] = {"SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID", "JOB_ID"};
    const char *id = NULL;

    for (size_t i = 0; i < SC_COUNT_OF(names) && !id; i++)
        id = getenv(names[i]);
    return id;
}

/* Texts of a record, as long as it is used. */
typedef struct record_texts {
    char processor[256], mpi[256];
} record_texts;

/* Fill in what is known of the run on this rank, without the records of the ranks. @param record
 * borrows from the run, and from @p texts. */
static void describe_run(const sc_run *run, record_texts *texts, sc_run_record *record)
{
    const sc_job *job = &run->session.job;
    const sc_input *input = &run->session.inputs->all[0];
    const sc_prepared *volume = &input->volume;

    sc_processor_name(texts->processor, sizeof texts->processor);
    sc_comm_library(texts->mpi, sizeof texts->mpi);
    *record = (sc_run_record){
        .platform = {.version = sc_version(),
                     .host = run->session.times.host,
                     .commit = sc_commit(),
                     .processor = texts->processor,
                     .kernel = sc_renderer_kernel(sc_session_renderer(&run->session, 0))->cpu,
                     .mpi = texts->mpi,
                     .batch_job = sc_batch_job()},
        .made_from = run->root.made_from,
        .id = run->root.id,
        .ranks = sc_comm_size(run->app->comm),
        .nodes = sc_comm_node_count(run->app->comm),
        .job = {run->root.store_job.job_hash, run->root.store_job.volume_hash},
        .begin_unix_s = run->clock.begin_unix_s,
        .memory.volume = (uint64_t)(job->volume.phase_count ? run->session.inputs->count : 1) *
                         (uint64_t)volume->size[0] * (uint64_t)volume->size[1] *
                         (uint64_t)volume->size[2] * (uint64_t)volume->label_bytes,
        .memory.prepared = sc_inputs_bytes(run->session.inputs),
        .wrote_png = job->output.frames == SC_FRAMES_PNG,
        .from_prepared = input->mapped && !input->shared && !input->kept};
    record->memory.renderer = sc_session_renderer_bytes(&run->session, &record->memory.derived);
}

/* For sc_ctx.write: keep the first error in a text of ERROR_BYTES. */
enum { ERROR_BYTES = 300 };
static void keep_error(void *user, sc_log_level level, const char *text)
{
    char *first = user;

    if (level == SC_LOG_ERROR && !first[0])
        snprintf(first, ERROR_BYTES, "%s", text);
}

/* Write report.html from what the directory holds now. The film is made: if the page cannot be, the
 * run does not fail, and a page of an earlier run does not stay. */
static void write_page(const sc_run *run)
{
    const sc_ctx *ctx = run->app->ctx;
    const sc_job *job = &run->session.job;
    const sc_report_run page = {.directory = run->root.directory,
                                .slice = run->root.slice[0] ? run->root.slice : NULL,
                                .title = job->output.title,
                                .video = job->output.video,
                                .png = job->output.frames == SC_FRAMES_PNG,
                                .frames = job->animation.frames,
                                .fps = job->output.fps};
    char error[ERROR_BYTES] = "";
    const sc_ctx keeping = {.level = SC_LOG_ERROR,
                            .write = keep_error,
                            .user = error,
                            .alloc_budget = ctx->alloc_budget};
    SC_OWN(sc_free_at) char *path = NULL;
    SC_OWN(sc_text_clear) sc_text text = {0};
    sc_status status;

    SC_TRY(record_path(&keeping, run, "report", "html", &path));
    SC_TRY(sc_report_make(&keeping, &page, &text));
    status = sc_file_write(&keeping, path, text.data, text.length_bytes);
out:
    if (status != SC_OK && path)
        (void)unlink(path);
    if (status != SC_OK)
        sc_warn(ctx, "the page with the report was not made: %s; `segcast report %s` makes it",
                error, run->root.directory);
}

/* On rank 0: write the crate of a run that begins. That of a slice leaves alone what another slice
 * has written, which may have completed the job meanwhile. */
static sc_status begin_crate(const sc_run *run)
{
    const sc_ctx *ctx = run->app->ctx;
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(ctx, run->root.directory, SC_CRATE_NAME, &path));
    if (run->root.slice[0] && !access(path, F_OK))
        return SC_OK;
    return sc_write_crate(ctx, run->root.directory, &run->session.job, &run->root.store_job, false);
}

sc_status sc_run_begin_records(sc_run *run)
{
    sc_app *app = run->app;
    sc_run_record record;
    record_texts texts;
    struct timespec now;
    SC_OWN(sc_free_at) sc_rank_record *all = NULL;
    sc_status status = SC_OK;

    clock_gettime(CLOCK_REALTIME, &now);
    sc_host_name(run->session.times.host);
    run->root.id = sc_hash_bytes(run->session.times.host, strlen(run->session.times.host),
                                 (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec);
    run->root.id ^= (uint64_t)getpid() << 32;
    if (run->keep_records && !run->plan.sealed && sc_comm_rank(app->comm) == 0)
        status = sc_run_note_inputs(run);
    SC_PASS(sc_comm_agree(app->comm, status));
    if (!run->keep_records || run->plan.complete)
        return SC_OK;
    SC_PASS(
        sc_comm_gather(app->ctx, app->comm, &run->session.times, sizeof run->session.times, &all));
    if (sc_comm_rank(app->comm) == 0) {
        describe_run(run, &texts, &record);
        record.rank_records = all;
        status = write_run(run, &record);
        if (status == SC_OK)
            status = begin_crate(run);
    }
    return sc_comm_agree(app->comm, status);
}

sc_status sc_run_write_records(sc_run *run, const sc_farm_times *times)
{
    sc_app *app = run->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_run_record record;
    record_texts texts;
    SC_OWN(sc_heat_clear) sc_heat heat = {0};
    SC_OWN(sc_free_at) char *path = NULL;
    SC_OWN(sc_free_at) sc_rank_record *all = NULL;

    describe_run(run, &texts, &record);
    record.ended = true;
    record.wall_s = sc_wall_s() - run->clock.begin_s;
    record.farm_wall_s = times->wall_s;
    record.frames = run->root.results;
    record.frame_count = run->root.result_count;
    SC_PASS(
        sc_comm_gather(app->ctx, app->comm, &run->session.times, sizeof run->session.times, &all));
    record.rank_records = all;
    if (run->keep_records)
        SC_PASS(sc_comm_agree(app->comm, gather_trace(run, all)));
    if (!first)
        return SC_OK;
    if (run->root.results)
        qsort(run->root.results, (size_t)run->root.result_count, sizeof *run->root.results,
              by_frame);
    if (run->keep_records) {
        SC_PASS(record_path(app->ctx, run, "stats", "json", &path));
        sc_run_draw_heat(run, path, &heat);
        record.heat = &heat;
        SC_PASS(write_run(run, &record));
    }
    if (run->keep_records)
        write_page(run);
    if (run->observe)
        run->observe(run->observer, &record);
    return run->observe ? SC_OK : sc_run_summarise(app->ctx, &record);
}
