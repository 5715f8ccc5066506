/* SPDX-License-Identifier: BSD-3-Clause */
/* The page that compares runs in several directories. */
#include "internal.h"

#include <string.h>

enum { PATH_BYTES = 4096 };

/* What is compared, of each directory. */
typedef struct compared {
    const char *name;                              /* of the directory, as the user gave it */
    sc_run_stats stats;                            /* owned */
    bool drew;                                     /* the last run has ended, and drew frames */
    double frames_per_s, draw_cpu_s, encode_cpu_s; /* CPU seconds of a frame */
    uint64_t peak_bytes;                           /* of the rank that took most */
    double phase_wall_s[SC_PHASE_COUNT];           /* of the rank that took longest */
} compared;

/* Read the statistics of a directory. */
static sc_status read_one(const sc_ctx *ctx, const char *directory, compared *out)
{
    char path[PATH_BYTES];
    const sc_run_stats *stats = &out->stats;
    const sc_run_entry *last;
    sc_status status;

    out->name = directory;
    snprintf(path, sizeof path, "%s/stats.json", directory);
    SC_TRY(sc_run_stats_read(ctx, path, &out->stats));
    last = &stats->history.runs[stats->history.run_count - 1];
    out->drew = last->ended && last->frames > 0;
    for (int i = 0; i < last->ranks; i++) {
        const sc_rank_record *rank = &stats->ranks[i];

        out->draw_cpu_s += rank->phases[SC_PHASE_RENDER].cpu_s;
        out->encode_cpu_s += rank->phases[SC_PHASE_ENCODE].cpu_s;
        out->peak_bytes =
            rank->peak_rss_bytes > out->peak_bytes ? rank->peak_rss_bytes : out->peak_bytes;
        for (int p = 0; p < SC_PHASE_COUNT; p++) {
            const double wall_s = rank->phases[p].wall_s;

            out->phase_wall_s[p] = wall_s > out->phase_wall_s[p] ? wall_s : out->phase_wall_s[p];
        }
    }
    if (out->drew) {
        out->draw_cpu_s /= last->frames;
        out->encode_cpu_s /= last->frames;
        out->frames_per_s = stats->frames_per_s;
    }
out:
    return status;
}

/* ---- the summary ---- */

/* @return the number of a frame that both have drawn, with different pixels; -1: there is none.
 * @param common counts those that both have. */
static int differing_frame(const sc_history *a, const sc_history *b, int *common)
{
    int j = 0;

    for (int i = 0; i < a->frame_count; i++) {
        const sc_frame_result *f = &a->frames[i].result;

        while (j < b->frame_count && b->frames[j].result.frame < f->frame)
            j++;
        if (j == b->frame_count || b->frames[j].result.frame != f->frame)
            continue;
        ++*common;
        if (b->frames[j].result.hash != f->hash)
            return f->frame;
    }
    return -1;
}

/* Say whether all have drawn the same pictures. */
static void add_pictures(sc_page *page, const compared *all, int count)
{
    int common = 0;

    for (int i = 1; i < count; i++) {
        const int frame = differing_frame(&all[0].stats.history, &all[i].stats.history, &common);

        if (frame >= 0) {
            sc_page_add(page, "<p>They have drawn different pictures: frame %d of ", frame);
            sc_page_textf(page, "%s is another one than that of %s.", all[i].name, all[0].name);
            sc_page_add(page, "</p>\n");
            return;
        }
    }
    sc_page_add(page, common ? "<p>All have drawn the same pictures, as far as they have drawn the "
                               "same frames.</p>\n"
                             : "<p>No frame was drawn in two of them.</p>\n");
}

/* Say which is fastest. */
static void add_summary(sc_page *page, const compared *all, int count)
{
    const compared *fastest = NULL, *slowest = NULL;

    for (int i = 0; i < count; i++) {
        if (!all[i].drew)
            continue;
        fastest = fastest && fastest->frames_per_s >= all[i].frames_per_s ? fastest : &all[i];
        slowest = slowest && slowest->frames_per_s <= all[i].frames_per_s ? slowest : &all[i];
    }
    sc_page_add(page, "<p class=\"lead\">");
    if (!fastest)
        sc_page_add(page, "No run has ended yet.");
    else if (fastest == slowest)
        sc_page_textf(page, "Only %s has drawn frames: %.2f per second.", fastest->name,
                      fastest->frames_per_s);
    else
        sc_page_textf(page, "%s is fastest: %.2f frames per second, %.2f times as many as %s.",
                      fastest->name, fastest->frames_per_s,
                      slowest->frames_per_s > 0 ? fastest->frames_per_s / slowest->frames_per_s : 0,
                      slowest->name);
    sc_page_add(page, "</p>\n");
    add_pictures(page, all, count);
}

/* ---- charts ---- */

/* Add a row with one bar, or with none of a run that drew nothing. */
static void add_bar(sc_row_chart *rows, const compared *one, double value, int decimals)
{
    char text[48] = "no frames";

    if (one->drew)
        snprintf(text, sizeof text, "%.*f", decimals, value);
    sc_row_begin(rows, one->name, text);
    sc_row_bar(rows, 0, one->drew ? value : 0, sc_phase_color(SC_PHASE_RENDER));
    sc_row_end(rows, text);
}

/* Add the chart of frames per second. */
static void add_speeds(sc_page *page, const compared *all, int count)
{
    double most = 0;
    sc_row_chart rows;

    for (int i = 0; i < count; i++)
        most = all[i].frames_per_s > most ? all[i].frames_per_s : most;
    sc_page_section(page, "Speed");
    rows = sc_rows_begin(page, "Frames per second of the last run; more is better",
                         sc_axis_to(most, 6, false), false);
    for (int i = 0; i < count; i++)
        add_bar(&rows, &all[i], all[i].frames_per_s, 2);
    sc_rows_end(&rows, "frames per second");
    sc_page_section_end(page);
}

/* Add the chart of the cost of a frame. */
static void add_costs(sc_page *page, const compared *all, int count)
{
    static const sc_phase phases[] = {SC_PHASE_RENDER, SC_PHASE_ENCODE};
    const char *names[2];
    int colors[2];
    double most = 0;
    sc_row_chart rows;

    for (int i = 0; i < 2; i++) {
        names[i] = sc_phase_word(phases[i]);
        colors[i] = sc_phase_color(phases[i]);
    }
    for (int i = 0; i < count; i++) {
        const double cost = all[i].drew ? all[i].draw_cpu_s + all[i].encode_cpu_s : 0;

        most = cost > most ? cost : most;
    }
    sc_page_section(page, "Cost of a frame");
    sc_legend(page, names, colors, 2);
    rows = sc_rows_begin(page, "CPU seconds of a frame; less is better", sc_axis_to(most, 4, false),
                         false);
    for (int i = 0; i < count; i++) {
        const compared *one = &all[i];
        char text[80] = "no frames", value[32] = "no frames";

        if (one->drew) {
            snprintf(text, sizeof text, "drawing %.3f s, encoding %.3f s", one->draw_cpu_s,
                     one->encode_cpu_s);
            snprintf(value, sizeof value, "%.3f", one->draw_cpu_s + one->encode_cpu_s);
        }
        sc_row_begin(&rows, one->name, text);
        if (one->drew) {
            sc_row_bar(&rows, 0, one->draw_cpu_s, colors[0]);
            sc_row_bar(&rows, one->draw_cpu_s, one->draw_cpu_s + one->encode_cpu_s, colors[1]);
        }
        sc_row_end(&rows, value);
    }
    sc_rows_end(&rows, "CPU seconds");
    sc_page_section_end(page);
}

/* Add the chart of phases. */
static void add_phases(sc_page *page, const compared *all, int count)
{
    const char *names[SC_PHASE_COUNT];
    int colors[SC_PHASE_COUNT];
    double most = 0;
    sc_row_chart rows;

    for (int i = 0; i < count; i++) {
        double sum = 0;

        for (int p = 0; p < SC_PHASE_COUNT; p++)
            sum += all[i].phase_wall_s[p];
        most = sum > most ? sum : most;
    }
    for (int p = 0; p < SC_PHASE_COUNT; p++) {
        names[p] = sc_phase_word(p);
        colors[p] = sc_phase_color(p);
    }
    sc_page_section(page, "Phases");
    sc_legend(page, names, colors, SC_PHASE_COUNT);
    rows = sc_rows_begin(page, "Wall seconds of each phase on the rank on which it took longest",
                         sc_axis_to(most, 6, false), false);
    for (int i = 0; i < count; i++) {
        char text[400] = "";
        double at = 0;
        size_t used = 0;

        for (int p = 0; p < SC_PHASE_COUNT && used < sizeof text; p++)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%s %.2f s", p ? ", " : "",
                                     names[p], all[i].phase_wall_s[p]);
        sc_row_begin(&rows, all[i].name, text);
        for (int p = 0; p < SC_PHASE_COUNT; p++) {
            sc_row_bar(&rows, at, at + all[i].phase_wall_s[p], colors[p]);
            at += all[i].phase_wall_s[p];
        }
        snprintf(text, sizeof text, "%.2f s", at);
        sc_row_end(&rows, text);
    }
    sc_rows_end(&rows, "seconds");
    sc_page_section_end(page);
}

/* Add the chart of memory. */
static void add_memory(sc_page *page, const compared *all, int count)
{
    double most = 0;
    sc_row_chart rows;

    for (int i = 0; i < count; i++)
        most = (double)all[i].peak_bytes > most ? (double)all[i].peak_bytes : most;
    sc_page_section(page, "Memory");
    rows = sc_rows_begin(page, "Peak memory of the rank that took most, in MB; less is better",
                         sc_axis_to(most / 1e6, 6, false), false);
    for (int i = 0; i < count; i++)
        add_bar(&rows, &all[i], (double)all[i].peak_bytes / 1e6, 0);
    sc_rows_end(&rows, "MB");
    sc_page_section_end(page);
}

/* Add the table of all figures. */
static void add_table(sc_page *page, const compared *all, int count)
{
    static const char *const heads[] = {"Directory",       "Nodes",        "Ranks",
                                        "Threads",         "Frames",       "Wall time, s",
                                        "CPU time, s",     "Frames per s", "CPU s a frame",
                                        "Mrays per CPU s", "Imbalance",    "Peak, MB"};
    sc_table table;

    sc_page_section(page, "All figures");
    table = sc_table_begin(page, "The last run in each directory", heads, SC_COUNT_OF(heads));
    for (int i = 0; i < count; i++) {
        const compared *one = &all[i];
        const sc_run_stats *stats = &one->stats;
        const sc_run_entry *last = &stats->history.runs[stats->history.run_count - 1];

        sc_table_cell(&table, "%s", one->name);
        sc_table_cell(&table, "%d", last->nodes);
        sc_table_cell(&table, "%d", last->ranks);
        sc_table_cell(&table, "%d", last->threads);
        sc_table_cell(&table, "%d", last->frames);
        sc_table_cell(&table, "%.2f", last->wall_s);
        sc_table_cell(&table, "%.2f", last->cpu_s);
        sc_table_cell(&table, "%.2f", one->frames_per_s);
        sc_table_cell(&table, "%.3f", one->drew ? one->draw_cpu_s + one->encode_cpu_s : 0);
        sc_table_cell(&table, "%.2f", stats->mrays_per_cpu_s);
        sc_table_cell(&table, "%.0f %%", 100 * sc_run_imbalance(&stats->run));
        sc_table_cell(&table, "%.0f", (double)one->peak_bytes / 1e6);
    }
    sc_table_end(&table);
    sc_page_add(page, "<ul>\n");
    for (int i = 0; i < count; i++) {
        const sc_run_stats *stats = &all[i].stats;

        if (!all[i].drew)
            continue;
        sc_page_add(page, "<li>");
        sc_page_textf(page, "%s was limited by ", all[i].name);
        sc_page_prose(page, sc_bottleneck_advice(sc_run_bottleneck(&stats->run)));
        sc_page_add(page, ".</li>\n");
    }
    sc_page_add(page, "</ul>\n");
    sc_page_section_end(page);
}

sc_status sc_report_compare(const sc_ctx *ctx, const char *const *directories, int count,
                            sc_text *out)
{
    sc_page page = {.ctx = ctx};
    compared *all = NULL;
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)count, sizeof *all, &block));
    all = block;
    for (int i = 0; i < count; i++)
        SC_TRY(read_one(ctx, directories[i], &all[i]));
    page = sc_page_begin(ctx, "Comparison of runs");
    add_summary(&page, all, count);
    add_speeds(&page, all, count);
    add_costs(&page, all, count);
    add_phases(&page, all, count);
    add_memory(&page, all, count);
    add_table(&page, all, count);
    SC_TRY(sc_page_end(&page));
    *out = page.text;
    page.text = (sc_text){0};
out:
    sc_page_clear(&page);
    for (int i = 0; i < count && all; i++)
        sc_run_stats_clear(&all[i].stats);
    sc_free(all);
    return status;
}
