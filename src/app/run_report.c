/* SPDX-License-Identifier: BSD-3-Clause */
/* The progress of a run, and the timing records at its end. */
#include "run.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Make "DIR/NAME.ENDING", or for a slice, which shares the directory with others,
 * "DIR/NAME.SLICE.ENDING". */
static sc_status record_path(const sc_run *run, const char *name, const char *ending, char **out)
{
    sc_text text = {0};
    sc_status status = sc_text_add(run->app->ctx, &text, "%s/%s%s%s.%s", run->directory, name,
                                   run->slice[0] ? "." : "", run->slice, ending);

    if (status == SC_OK)
        *out = text.data;
    return status;
}

/* Write status.json. @param ctx where errors go. */
static sc_status write_status(const sc_run *run, const sc_ctx *ctx,
                              const sc_progress_report *report)
{
    char *path = NULL;
    sc_status status = record_path(run, "status", "json", &path);

    if (status == SC_OK)
        status = sc_progress_write(ctx, path, report);
    sc_free(path);
    return status;
}

void sc_run_on_progress(void *user, int done, int total)
{
    sc_run *run = user;
    const int before = atomic_exchange(&run->frames_done, run->plan.kept + done);

    (void)total;
    sc_stage_add(run->app->ctx, (uint64_t)(run->plan.kept + done - before));
}

void sc_run_watch(void *user, const sc_stage_view *view)
{
    const sc_run *run = user;
    const bool draws = !strcmp(view->name, SC_STAGE_DRAWING);
    const sc_ctx silent = {.rank = 0};
    const sc_progress_report report = {.state = "running",
                                       .phase = view->name,
                                       .phase_share = view->share,
                                       .done = atomic_load(&run->frames_done),
                                       .total = run->wanted_count,
                                       .elapsed_s = sc_wall_s() - run->begin_s,
                                       .frames_per_s = draws ? view->rate : 0,
                                       .remaining_s = view->left_s};

    /* A status.json that cannot be written does not end the run. If the disk is full, writing
     * frames will fail and say so. */
    (void)write_status(run, &silent, &report);
}

sc_status sc_run_write_state(sc_run *run, sc_status outcome)
{
    const double elapsed_s = sc_wall_s() - run->begin_s;
    const sc_progress_report report = {
        .state = outcome == SC_OK               ? "complete"
                 : outcome == SC_ERR_INCOMPLETE ? "incomplete"
                                                : "failed",
        .done = run->plan.kept + run->result_count,
        .total = run->wanted_count,
        .elapsed_s = elapsed_s,
        .frames_per_s = elapsed_s > 0 ? run->result_count / elapsed_s : 0,
    };

    return run->keep_records ? write_status(run, run->app->ctx, &report) : SC_OK;
}

void sc_run_fill_phases(sc_run *run, const sc_farm_times *times)
{
    sc_rank_record *r = &run->session.times;
    const double farm_cpu_s = sc_cpu_s() - run->farm_cpu_s;
    const sc_store_times store =
        run->store ? sc_store_time(run->store) : (sc_store_times){times->accept_wall_s, 0};
    /* The CPU time of the encoder's own threads cannot be measured by itself: it is what is left of
     * the CPU time that the process used during the farm. */
    const double rest_cpu_s = farm_cpu_s - times->render_cpu_s - times->gather_cpu_s;

    r->phases[SC_PHASE_RENDER] = (sc_phase_time){times->render_wall_s, times->render_cpu_s};
    r->phases[SC_PHASE_GATHER] = (sc_phase_time){times->gather_wall_s, times->gather_cpu_s};
    r->phases[SC_PHASE_IDLE].wall_s += times->idle_s;
    r->phases[SC_PHASE_ENCODE] =
        (sc_phase_time){run->encode_wall_s, rest_cpu_s > 0 ? rest_cpu_s : 0};
    if (sc_comm_rank(run->app->comm) == 0) {
        r->phases[SC_PHASE_ENCODE].wall_s += store.encode_wall_s;
        r->phases[SC_PHASE_WRITE].wall_s = store.write_wall_s;
    }
    r->accept_wall_s = times->accept_wall_s;
    r->farm_idle_s = times->idle_s;
    r->peak_rss_bytes = sc_peak_rss();
    r->cpu_s = sc_cpu_s();
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
    char *path = NULL;
    sc_status status = record_path(run, "trace", "json", &path);

    if (status == SC_OK)
        status = sc_trace_write(run->app->ctx, path, sc_comm_size(run->app->comm), records, events,
                                counts, stride);
    sc_free(path);
    return status;
}

/* Gather the trace events of all ranks on rank 0, which writes trace.json. @p records is NULL on
 * the others. Collective. */
static sc_status gather_trace(sc_run *run, const sc_rank_record *records)
{
    sc_app *app = run->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    const size_t ranks = (size_t)sc_comm_size(app->comm);
    size_t count = sc_trace_count(run->trace), largest = 1;
    void *counts = NULL, *mine = NULL, *all = NULL;
    sc_status status = SC_OK;

    if (first)
        status = sc_alloc(app->ctx, ranks, sizeof count, &counts);
    SC_TRY(sc_comm_agree(app->comm, status));
    sc_comm_gather(app->comm, &count, sizeof count, counts);
    for (size_t i = 0; first && i < ranks; i++)
        largest = ((size_t *)counts)[i] > largest ? ((size_t *)counts)[i] : largest;
    sc_comm_broadcast(app->comm, &largest, sizeof largest);
    status = sc_zalloc(app->ctx, largest, sizeof(sc_trace_event), &mine);
    if (first && status == SC_OK)
        status = sc_alloc(app->ctx, ranks * largest, sizeof(sc_trace_event), &all);
    SC_TRY(sc_comm_agree(app->comm, status));
    if (first && sc_trace_dropped(run->trace))
        sc_info(app->ctx,
                "trace.json holds only the first %zu events of each rank; later ones found no room",
                count);
    if (count)
        memcpy(mine, sc_trace_events(run->trace), count * sizeof(sc_trace_event));
    sc_comm_gather(app->comm, mine, largest * sizeof(sc_trace_event), all);
    if (first)
        status = write_trace(run, records, all, counts, largest);
out:
    sc_free(counts);
    sc_free(mine);
    sc_free(all);
    return status;
}

/* Is it the name of a file "stats.SLICE.json"? For scandir. */
static int is_stats_of_slice(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name), around = strlen("stats.") + strlen(".json");

    return length > around && !strncmp(entry->d_name, "stats.", strlen("stats.")) &&
           !strcmp(entry->d_name + length - strlen(".json"), ".json");
}

/* Add to @p history what the statistics of all slices in the directory hold. */
static sc_status read_slices(const sc_run *run, sc_history *history)
{
    const sc_job_hashes job = {run->store_job.job_hash, run->store_job.volume_hash};
    struct dirent **entries;
    const int count = scandir(run->directory, &entries, is_stats_of_slice, alphasort);
    sc_status status = SC_OK;

    for (int i = 0; i < count; i++) {
        char *path = NULL;

        if (status == SC_OK)
            status = sc_path_join(run->app->ctx, run->directory, entries[i]->d_name, &path);
        if (status == SC_OK)
            status = sc_history_read(run->app->ctx, path, &job, history);
        sc_free(path);
        free(entries[i]);
    }
    if (count >= 0)
        free(entries);
    return status;
}

/* Read from the statistics @p path, and for the whole job from those of slices, what earlier runs
 * have measured of frames that are there now. Does nothing without --resume. */
static sc_status read_history(const sc_run *run, const char *path, sc_history *history)
{
    const sc_job_hashes job = {run->store_job.job_hash, run->store_job.volume_hash};
    int kept = 0;
    sc_status status;

    if (!run->app->options.resume)
        return SC_OK;
    SC_TRY(sc_history_read(run->app->ctx, path, &job, history));
    if (!run->slice[0])
        SC_TRY(read_slices(run, history));
    for (int i = 0; i < history->frame_count; i++) {
        const int frame = history->frames[i].result.frame;

        if (frame < run->store_job.frames && sc_store_has(run->store, frame))
            history->frames[kept++] = history->frames[i];
    }
    history->frame_count = kept;
out:
    return status;
}

/* Write stats.json and frames.csv, with what earlier runs have measured. On rank 0. */
static sc_status write_run(sc_run *run, sc_run_record *record)
{
    char *json = NULL, *csv = NULL;
    sc_history earlier = {0};
    sc_status status;

    SC_TRY(record_path(run, "stats", "json", &json));
    SC_TRY(record_path(run, "frames", "csv", &csv));
    SC_TRY(read_history(run, json, &earlier));
    record->earlier = &earlier;
    status = sc_run_write(run->app->ctx, record, json, csv);
    record->earlier = NULL;
out:
    sc_history_clear(&earlier);
    sc_free(json);
    sc_free(csv);
    return status;
}

/* Write the name of the processor as the system has it into @p text; empty if it has none. */
static void name_processor(char *text, int size)
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

/* @return the id that the batch system has given to this job, or NULL. */
static const char *batch_job(void)
{
    static const char *const names[] = {"SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID", "JOB_ID"};
    const char *id = NULL;

    for (size_t i = 0; i < SC_COUNT_OF(names) && !id; i++)
        id = getenv(names[i]);
    return id;
}

sc_status sc_run_write_records(sc_run *run, const sc_farm_times *times)
{
    sc_app *app = run->app;
    const sc_prepared *volume = &run->session.volume;
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_run_record record = {.version = sc_version(),
                            .host = run->session.times.host,
                            .ranks = sc_comm_size(app->comm),
                            .nodes = sc_comm_node_count(app->comm),
                            .job = {run->store_job.job_hash, run->store_job.volume_hash},
                            .begin_unix_s = run->begin_unix_s,
                            .wall_s = sc_wall_s() - run->begin_s,
                            .frames = run->results,
                            .frame_count = run->result_count,
                            .volume_bytes = (uint64_t)volume->size[0] * (uint64_t)volume->size[1] *
                                            (uint64_t)volume->size[2] *
                                            (uint64_t)volume->label_bytes,
                            .prepared_bytes = run->session.shared_bytes,
                            .farm_wall_s = times->wall_s,
                            .wrote_png = run->session.job.output.frames == SC_FRAMES_PNG,
                            .from_prepared = run->session.mapped && !run->session.shared};
    char processor[256], mpi[256];
    void *all = NULL;
    sc_status status = SC_OK;

    name_processor(processor, sizeof processor);
    sc_comm_library(mpi, sizeof mpi);
    record.processor = processor;
    record.mpi = mpi;
    record.commit = sc_commit();
    record.kernel = sc_renderer_kernel(run->session.renderer)->cpu;
    record.batch_job = batch_job();
    if (first)
        status = sc_alloc(app->ctx, (size_t)record.ranks, sizeof(sc_rank_record), &all);
    SC_TRY(sc_comm_agree(app->comm, status));
    sc_comm_gather(app->comm, &run->session.times, sizeof run->session.times, all);
    record.rank_records = all;
    if (run->keep_records)
        SC_TRY(sc_comm_agree(app->comm, gather_trace(run, all)));
    if (!first)
        goto out;
    if (run->results)
        qsort(run->results, (size_t)run->result_count, sizeof *run->results, by_frame);
    if (run->keep_records)
        SC_TRY(write_run(run, &record));
    status = sc_run_summarise(app->ctx, &record);
out:
    sc_free(all);
    return status;
}
