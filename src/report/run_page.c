/* SPDX-License-Identifier: BSD-3-Clause */
/* The page of a run. */
#include "internal.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    PATH_BYTES = 4096,
    RANKS_SHOWN = 24, /* most ranks in the chart of phases */
    RUNS_SHOWN = 50,  /* most runs in the table: the last ones */
    SLOWEST_SHOWN = 3 /* frames that are named */
};

/* Write the path of "STEM.ENDING" in the directory, or that of the slice, into @p path; @p name
 * receives the name without the directory. */
static void record_path(const sc_report_run *run, const char *stem, const char *ending,
                        char path[PATH_BYTES], const char **name)
{
    const int used = snprintf(path, PATH_BYTES, "%s/", run->directory);

    if (used < PATH_BYTES)
        snprintf(path + used, (size_t)(PATH_BYTES - used), "%s%s%s.%s", stem, run->slice ? "." : "",
                 run->slice ? run->slice : "", ending);
    *name = path + (used < PATH_BYTES ? used : 0);
}

/* @return the last run. */
static const sc_run_entry *last_run(const sc_run_stats *stats)
{
    return &stats->history.runs[stats->history.run_count - 1];
}

/* @return the CPU seconds of a phase, of all ranks together. */
static double phase_cpu_s(const sc_run_stats *stats, sc_phase phase)
{
    double sum = 0;

    for (int i = 0; i < stats->run.ranks; i++)
        sum += stats->ranks[i].phases[phase].cpu_s;
    return sum;
}

/* @return the wall seconds of a phase on the rank on which it took longest. */
static double phase_wall_s(const sc_run_stats *stats, sc_phase phase)
{
    double most = 0;

    for (int i = 0; i < stats->run.ranks; i++) {
        const double wall_s = stats->ranks[i].phases[phase].wall_s;

        most = wall_s > most ? wall_s : most;
    }
    return most;
}

/* ---- the summary ---- */

/* For qsort of pointers to sc_past_frame: the one with the most CPU time first. */
static int by_cost(const void *a, const void *b)
{
    const sc_past_frame *const *x = a, *const *y = b;
    const double p = (*x)->result.render_cpu_s, q = (*y)->result.render_cpu_s;

    return p < q ? 1 : p > q ? -1 : (*x)->result.frame - (*y)->result.frame;
}

/* Add the sentence with the slowest frames of all runs. */
static void add_slowest(sc_page *page, const sc_history *history)
{
    const size_t count = (size_t)history->frame_count;
    const sc_past_frame **sorted;
    void *block;

    if (count < 2 || page->status != SC_OK)
        return;
    page->status = sc_alloc(page->ctx, count, sizeof *sorted, &block);
    if (page->status != SC_OK)
        return;
    sorted = block;
    for (size_t i = 0; i < count; i++)
        sorted[i] = &history->frames[i];
    qsort(block, count, sizeof *sorted, by_cost);
    sc_page_add(page, " The slowest frames were");
    for (size_t i = 0; i < count && i < SLOWEST_SHOWN; i++)
        sc_page_add(page, "%s %d (%.3f CPU s)", i ? "," : "", sorted[i]->result.frame,
                    sorted[i]->result.render_cpu_s);
    sc_page_add(page, ".");
    sc_free(block);
}

/* Add what the run did, what limited it, and what would make the next one faster. */
static void add_summary(sc_page *page, const sc_report_run *run, const sc_run_stats *stats)
{
    const sc_run_entry *last = last_run(stats);
    const int drawn = last->frames;
    const int there = stats->history.frame_count;

    if (!last->ended) {
        sc_page_add(page, "<p class=\"lead\">The last run was killed, or goes on still: it has "
                          "measured nothing yet. If it was killed, the same command with "
                          "<code>--resume</code> goes on.</p>\n");
        return;
    }
    if (drawn == 0) {
        sc_page_add(page, "<p class=\"lead\">The last run drew no frame.</p>\n");
        return;
    }
    sc_page_add(page, "<p class=\"lead\">%d frame%s in %.1f s: %.2f frames per second. Limited by ",
                drawn, drawn == 1 ? "" : "s", last->wall_s, stats->frames_per_s);
    sc_page_prose(page, sc_bottleneck_advice(sc_run_bottleneck(&stats->run)));
    sc_page_add(page, ".</p>\n<p>Drawing took %.3f CPU seconds a frame, encoding %.3f. ",
                phase_cpu_s(stats, SC_PHASE_RENDER) / drawn,
                phase_cpu_s(stats, SC_PHASE_ENCODE) / drawn);
    sc_page_add(page, "Worker threads waited for work %.0f %% of the time.",
                100 * sc_run_waiting(&stats->run));
    if (stats->run.ranks > 1)
        sc_page_add(page, " The busiest rank drew %.0f %% longer than the mean of all.",
                    100 * sc_run_imbalance(&stats->run));
    add_slowest(page, &stats->history);
    sc_page_add(page, "</p>\n");
    if (run->slice) {
        sc_page_add(page, "<p>");
        sc_page_textf(page, "This is slice %s: its frames are a part of the film's %d.", run->slice,
                      run->frames);
        sc_page_add(page, "</p>\n");
    }
    if (!run->slice && there < run->frames)
        sc_page_add(page,
                    "<p>The film is incomplete: %d of %d frames are drawn. The same command with "
                    "<code>--resume</code> goes on.</p>\n",
                    there, run->frames);
}

/* ---- the table of the run ---- */

/* Add a fact that may be unknown. */
static void add_known(sc_page *page, const char *name, const char *value)
{
    if (value[0])
        sc_fact(page, name, "%s", value);
}

/* Add the facts of the last run. */
static void add_facts(sc_page *page, const sc_run_stats *stats)
{
    const sc_run_entry *last = last_run(stats);
    uint64_t peak = 0;
    char text[32];

    for (int i = 0; i < stats->run.ranks; i++)
        peak = stats->ranks[i].peak_rss_bytes > peak ? stats->ranks[i].peak_rss_bytes : peak;
    sc_page_section(page, "The run");
    sc_facts_begin(page);
    sc_fact(page, "Begin", "%s", last->begin);
    sc_fact(page, "Host of rank 0", "%s", last->host);
    add_known(page, "Processor", last->processor);
    add_known(page, "Kernel", last->kernel);
    sc_fact(page, "Nodes", "%d", last->nodes);
    sc_fact(page, "Ranks", "%d", last->ranks);
    sc_fact(page, "Threads of a rank", "%d", last->threads);
    add_known(page, "MPI", last->mpi);
    add_known(page, "Batch job", last->batch_job);
    if (last->ended) {
        sc_fact(page, "Frames drawn", "%d", last->frames);
        sc_fact(page, "Wall time", "%.2f s", last->wall_s);
        sc_fact(page, "CPU time", "%.2f s", last->cpu_s);
        sc_fact(page, "Frames per second", "%.3f", stats->frames_per_s);
        sc_fact(page, "Million rays per CPU second", "%.2f", stats->mrays_per_cpu_s);
        sc_fact(page, "Imbalance of ranks", "%.1f %%", 100 * sc_run_imbalance(&stats->run));
        sc_fact(page, "Peak memory of a rank", "%s", sc_report_size(peak, text));
    }
    sc_fact(page, "Volume", "%s", sc_report_size(stats->run.volume_bytes, text));
    sc_fact(page, "Prepared volume", "%s", sc_report_size(stats->run.prepared_bytes, text));
    sc_fact(page, "Derived from it for drawing", "%s",
            sc_report_size(stats->run.derived_bytes, text));
    sc_fact(page, "segcast", "%s%s%s", stats->version, last->commit[0] ? ", commit " : "",
            last->commit);
    sc_facts_end(page);
    sc_page_section_end(page);
}

/* ---- phases ---- */

/* @return the seconds of all phases of a rank together. */
static double rank_sum_s(const sc_rank_record *rank)
{
    double sum = 0;

    for (int p = 0; p < SC_PHASE_COUNT; p++)
        sum += rank->phases[p].wall_s;
    return sum;
}

/* Add the bar of a rank. */
static void add_rank(sc_row_chart *rows, const sc_run_stats *stats, int i)
{
    const sc_rank_record *rank = &stats->ranks[i];
    char label[SC_HOST_BYTES + 32], what[400], value[32];
    size_t used = 0;
    double at = 0;

    snprintf(label, sizeof label, "rank %d%s%s", i, stats->run.nodes > 1 ? " on " : "",
             stats->run.nodes > 1 ? rank->host : "");
    for (int p = 0; p < SC_PHASE_COUNT && used < sizeof what; p++)
        used += (size_t)snprintf(what + used, sizeof what - used, "%s%s %.2f s", p ? ", " : "",
                                 sc_phase_word(p), rank->phases[p].wall_s);
    sc_row_begin(rows, label, what);
    for (int p = 0; p < SC_PHASE_COUNT; p++) {
        sc_row_bar(rows, at, at + rank->phases[p].wall_s, sc_phase_color(p));
        at += rank->phases[p].wall_s;
    }
    snprintf(value, sizeof value, "%.2f s", at);
    sc_row_end(rows, value);
}

/* Add the table of phases. */
static void add_phase_table(sc_page *page, const sc_run_stats *stats)
{
    static const char *const heads[] = {"Phase", "Wall time of the slowest rank, s",
                                        "CPU time of all ranks, s"};
    sc_table table = sc_table_begin(page, "Phases of all ranks", heads, SC_COUNT_OF(heads));

    for (int p = 0; p < SC_PHASE_COUNT; p++) {
        sc_table_cell(&table, "%s", sc_phase_word(p));
        sc_table_cell(&table, "%.2f", phase_wall_s(stats, p));
        sc_table_cell(&table, "%.2f", phase_cpu_s(stats, p));
    }
    sc_table_end(&table);
}

/* Add how the time of all cores is split by cause, as a bar and as a table. */
static void add_core_time(sc_page *page, const sc_run_stats *stats)
{
    static const char *const heads[] = {"Cause", "Core time, s", "Share"};
    const sc_core_time time = sc_run_core_time(&stats->run);
    sc_row_chart rows = sc_report_core_begin(page);
    sc_table table;

    sc_report_core_row(&rows, "all ranks", &time);
    sc_rows_end(&rows, "percent");
    table = sc_table_begin(page, "Time of all cores: wall time, ranks and threads multiplied",
                           heads, SC_COUNT_OF(heads));
    for (int i = 0; i < SC_CAUSE_COUNT; i++) {
        sc_table_cell(&table, "%s", sc_report_cause(i));
        sc_table_cell(&table, "%.2f", time.causes_s[i]);
        sc_table_cell(&table, "%.1f %%",
                      time.core_s > 0 ? 100 * time.causes_s[i] / time.core_s : 0);
    }
    sc_table_end(&table);
}

/* Add the bars of the ranks: of many, some at even distances. */
static void add_phases(sc_page *page, const sc_run_stats *stats)
{
    const int ranks = stats->run.ranks, shown = ranks < RANKS_SHOWN ? ranks : RANKS_SHOWN;
    const char *names[SC_PHASE_COUNT];
    int colors[SC_PHASE_COUNT];
    double longest = 0;
    sc_row_chart rows;

    for (int p = 0; p < SC_PHASE_COUNT; p++) {
        names[p] = sc_phase_word(p);
        colors[p] = sc_phase_color(p);
    }
    for (int i = 0; i < ranks; i++)
        longest = rank_sum_s(&stats->ranks[i]) > longest ? rank_sum_s(&stats->ranks[i]) : longest;
    sc_page_section(page, "Where the time went");
    sc_legend(page, names, colors, SC_PHASE_COUNT);
    rows = sc_rows_begin(page, "Wall seconds of each rank by phase", sc_axis_to(longest, 6, false),
                         false);
    for (int i = 0; i < shown; i++)
        add_rank(&rows, stats, (int)((long)i * ranks / shown));
    sc_rows_end(&rows, "seconds");
    if (shown < ranks)
        sc_page_add(page, "<p class=\"note\">%d of %d ranks are shown, at even distances.</p>\n",
                    shown, ranks);
    sc_page_add(page,
                "<p class=\"note\">Rank 0 encodes, writes and passes messages beside drawing, "
                "so its bar may be longer than the run.</p>\n");
    add_phase_table(page, stats);
    add_core_time(page, stats);
    sc_page_section_end(page);
}

/* ---- what stands at the end ---- */

/* Add the film, if it is there. */
static void add_film(sc_page *page, const sc_report_run *run)
{
    char path[PATH_BYTES];

    snprintf(path, sizeof path, "%s/%s", run->directory, run->video);
    if (!strcmp(run->video, "none") || access(path, R_OK) != 0)
        return;
    sc_page_section(page, "The film");
    sc_page_add(page, "<video controls=\"controls\" preload=\"metadata\" title=\"");
    sc_page_text(page, run->video);
    sc_page_add(page, "\" src=\"");
    sc_page_address(page, run->video);
    sc_page_add(page, "\"></video>\n<p><a href=\"");
    sc_page_address(page, run->video);
    sc_page_add(page, "\">");
    sc_page_text(page, run->video);
    sc_page_add(page, "</a>: %d frames at %d per second</p>\n", run->frames, run->fps);
    sc_page_section_end(page);
}

/* Add the table of all runs on the job. */
static void add_runs(sc_page *page, const sc_history *history)
{
    static const char *const heads[] = {"Begin",  "Host",         "Nodes",       "Ranks", "Threads",
                                        "Frames", "Wall time, s", "CPU time, s", "State"};
    const int first = history->run_count > RUNS_SHOWN ? history->run_count - RUNS_SHOWN : 0;
    sc_table table;

    sc_page_section(page, "Runs on this job");
    table = sc_table_begin(page, first ? "The last runs; stats.json has all of them" : "All runs",
                           heads, SC_COUNT_OF(heads));
    for (int i = first; i < history->run_count; i++) {
        const sc_run_entry *run = &history->runs[i];

        sc_table_cell(&table, "%s", run->begin);
        sc_table_cell(&table, "%s%s", run->host, run->host_count > 1 ? " and others" : "");
        sc_table_cell(&table, "%d", run->nodes);
        sc_table_cell(&table, "%d", run->ranks);
        sc_table_cell(&table, "%d", run->threads);
        sc_table_cell(&table, "%d", run->frames);
        sc_table_cell(&table, "%.2f", run->wall_s);
        sc_table_cell(&table, "%.2f", run->cpu_s);
        sc_table_cell(&table, "%s", run->ended ? "ended" : "killed, or goes on still");
    }
    sc_table_end(&table);
    sc_page_section_end(page);
}

/* Add the job as it was resolved. */
static void add_settings(sc_page *page, const sc_report_run *run)
{
    sc_page_section(page, "Settings");
    sc_report_file(page, run->directory, "job.yaml", "The job with all its settings");
    sc_page_section_end(page);
}

/* Add links to the files from which the page was made. */
static void add_files(sc_page *page, const sc_report_run *run)
{
    static const struct {
        const char *stem, *ending, *what;
    } files[] = {{"stats", "json", "all measurements"},
                 {"frames", "csv", "one line for each frame"},
                 {"trace", "json", "what each thread did when"},
                 {"manifest", "jsonl", "hashes of the job, the frames and the files"}};
    char path[PATH_BYTES];
    const char *name;

    sc_page_section(page, "Files");
    sc_page_add(page, "<ul>\n");
    for (size_t i = 0; i < SC_COUNT_OF(files); i++) {
        record_path(run, files[i].stem, files[i].ending, path, &name);
        sc_report_link(page, run->directory, name, files[i].what);
    }
    sc_report_link(page, run->directory, "job.yaml", "the job with all its settings");
    sc_page_add(page, "</ul>\n");
    sc_page_section_end(page);
}

sc_status sc_report_make(const sc_ctx *ctx, const sc_report_run *run, sc_text *out)
{
    char path[PATH_BYTES];
    const char *name;
    sc_run_stats stats = {0};
    sc_page page = {.ctx = ctx};
    sc_status status;

    record_path(run, "stats", "json", path, &name);
    SC_TRY(sc_run_stats_read(ctx, path, &stats));
    page = sc_page_begin(ctx, run->title[0]                ? run->title
                              : strcmp(run->video, "none") ? run->video
                                                           : "A film of segcast");
    add_summary(&page, run, &stats);
    add_facts(&page, &stats);
    if (last_run(&stats)->ended)
        add_phases(&page, &stats);
    record_path(run, "trace", "json", path, &name);
    sc_report_activity(&page, path, &stats);
    sc_report_frames(&page, run, &stats);
    sc_report_heat(&page, &stats);
    add_film(&page, run);
    add_runs(&page, &stats.history);
    add_settings(&page, run);
    add_files(&page, run);
    SC_TRY(sc_page_end(&page));
    *out = page.text;
    page.text = (sc_text){0};
out:
    sc_page_clear(&page);
    sc_run_stats_clear(&stats);
    return status;
}
