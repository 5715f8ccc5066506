/* SPDX-License-Identifier: BSD-3-Clause */
/* The page of a study. */
#include "study_view.h"

#include <math.h>
#include <string.h>

enum {
    CELLS_SHOWN = 250, /* most cells in a table */
    RUNS_SHOWN = 50,
    AXIS_VALUES_SHOWN = 60,
    WORK_COLUMNS = 9 /* of the table of work, without energy */
};

/* ---- what the axes do ---- */

/* How the time per ray changes with a value of an axis, against its first one, over all
 * combinations of the other axes that were measured with both. */
typedef struct effect {
    int count;
    double log_sum, low, high;
} effect;

/* @return the time per ray of a pass of a cell. */
static double ray_s(const sc_study_view *view, int cell)
{
    const uint64_t rays = view->cells[cell].typical.rays;

    return rays ? sc_study_time(view, cell)->median / (double)rays : 0;
}

static effect find_effect(const sc_study_view *view, int axis, int value)
{
    effect e = {.low = INFINITY};

    for (int i = 0; i < view->count; i++) {
        const int other = sc_study_with(view, i, axis, value);
        double ratio;

        if (!sc_study_is_first(view, i, axis) || !sc_study_has(view, i) ||
            !sc_study_has(view, other) || !(ray_s(view, i) > 0))
            continue;
        ratio = ray_s(view, other) / ray_s(view, i);
        e.count++;
        e.log_sum += log(ratio);
        e.low = fmin(e.low, ratio);
        e.high = fmax(e.high, ratio);
    }
    return e;
}

/* Add the table that tells what each axis does. */
static void add_effects(sc_page *page, const sc_study_view *view)
{
    static const char *const heads[] = {"Axis", "Value", "Time per ray, of that of the first value",
                                        "Least and most"};
    const sc_design *design = &view->m->design;
    sc_table table;
    int shown = 0;

    sc_page_section(page, "What the axes do");
    table = sc_table_begin(page,
                           design->by_wall ? "Wall time per ray; geometric mean over the other axes"
                                           : "CPU time per ray; geometric mean over the other axes",
                           heads, SC_COUNT_OF(heads));
    for (int a = 0; a < design->axis_count; a++) {
        for (int v = 0; v < design->axes[a].value_count && design->axes[a].value_count > 1; v++) {
            const effect e = find_effect(view, a, v);

            if (e.count == 0 || shown++ >= AXIS_VALUES_SHOWN)
                continue;
            sc_table_cell(&table, "%s", design->axes[a].name);
            sc_table_cell(&table, "%s", design->axes[a].values[v]);
            sc_table_cell(&table, "%.3f", exp(e.log_sum / e.count));
            sc_table_cell(&table, e.count > 1 ? "%.3f to %.3f" : "-", e.low, e.high);
        }
    }
    sc_table_end(&table);
    sc_page_section_end(page);
}

/* ---- the tables of cells ---- */

/* Adds the values of a cell, all after its name, to a table. */
typedef void add_cell_fn(sc_table *table, const sc_study_view *view, const sc_cell_result *r);

/* Add a table with a row for each measured cell. */
static void add_cells(sc_page *page, const sc_study_view *view, const char *caption,
                      const char *const *heads, int columns, add_cell_fn *add)
{
    sc_table table = sc_table_begin(page, caption, heads, columns);
    int shown = 0;

    for (int i = 0; i < view->count; i++) {
        char name[SC_CELL_NAME_BYTES];

        if (!sc_study_has(view, i) || shown++ >= CELLS_SHOWN)
            continue;
        sc_study_name(view, i, -1, "the only cell", name);
        sc_table_cell(&table, "%s", name);
        add(&table, view, &view->cells[i]);
    }
    sc_table_end(&table);
    if (shown > CELLS_SHOWN)
        sc_page_add(
            page, "<p class=\"note\">The first %d of %d cells are shown; cells.csv has all.</p>\n",
            CELLS_SHOWN, shown);
}

static void add_times(sc_table *table, const sc_study_view *view, const sc_cell_result *r)
{
    const sc_statistics *both[] = {&r->cpu_s, &r->wall_s};
    const double frames = r->typical.frames;

    (void)view;
    sc_table_cell(table, "%zu", r->cpu_s.count);
    for (int i = 0; i < 2; i++) {
        const sc_statistics *s = both[i];

        sc_table_cell(table, "%.4g", s->median / frames);
        sc_table_cell(table, s->has_interval ? "%.4g to %.4g" : "-", s->low / frames,
                      s->high / frames);
        sc_table_cell(table, "%.4g, %.4g", s->quartile_1 / frames, s->quartile_3 / frames);
        sc_table_cell(table, "%.4g", s->least / frames);
    }
}

static void add_work(sc_table *table, const sc_study_view *view, const sc_cell_result *r)
{
    const sc_measurement *t = &r->typical;
    char text[32];

    (void)view;
    sc_table_cell(table, "%.3f", r->mrays_per_cpu_s);
    sc_table_cell(table, "%.2f", r->samples_per_ray);
    sc_table_cell(table, "%.2f", t->rays ? (double)t->contributions / (double)t->rays : 0);
    sc_table_cell(table, "%.3f", t->read_s + t->prepare_s + t->share_s);
    sc_table_cell(table, "%.3f", t->derive_s);
    sc_table_cell(table, "%s", sc_report_size(t->prepared_bytes, text));
    sc_table_cell(table, "%s", sc_report_size(t->peak_rss_most_bytes, text));
    sc_table_cell(table, "%s", sc_report_size(t->peak_rss_sum_bytes, text));
    if (table->columns > WORK_COLUMNS)
        sc_table_cell(table, t->energy_j >= 0 ? "%.3g" : "-", t->energy_j / t->frames);
}

static void add_parallel(sc_table *table, const sc_study_view *view, const sc_cell_result *r)
{
    char base[SC_CELL_NAME_BYTES];

    sc_study_name(view, r->base, -1, "-", base);
    sc_table_cell(table, "%d", r->typical.nodes);
    sc_table_cell(table, "%d", r->typical.ranks);
    sc_table_cell(table, "%d", r->typical.threads);
    sc_table_cell(table, "%s", r->base == r->cell ? "itself" : base);
    sc_table_cell(table, "%.3f", r->speedup);
    sc_table_cell(table, "%.3f", r->efficiency);
    sc_table_cell(table, r->base == r->cell ? "-" : "%.4f", r->serial_share);
    sc_table_cell(table, "%.3f", r->cost);
    sc_table_cell(table, "%.1f %%", 100 * r->imbalance);
    sc_table_cell(table, "%.3f", r->frames_per_s);
}

/* Add all tables of cells. */
static void add_tables(sc_page *page, const sc_study_view *view)
{
    static const char *const times[] = {"Cell",      "n",     "CPU s a frame",  "95 % interval",
                                        "Quartiles", "Least", "Wall s a frame", "95 % interval",
                                        "Quartiles", "Least"};
    static const char *const work[] = {"Cell",
                                       "Mrays per CPU s",
                                       "Samples per ray",
                                       "Contributions per ray",
                                       "Preparation, s",
                                       "Of that, for this cell alone, s",
                                       "Prepared volume",
                                       "Peak memory of a rank",
                                       "Of all ranks",
                                       "Energy of a frame, J"};
    static const char *const parallel[] = {"Cell",
                                           "Nodes",
                                           "Ranks",
                                           "Threads",
                                           "Beside",
                                           "Speed-up",
                                           "Efficiency",
                                           "Serial share (Karp-Flatt)",
                                           "CPU time per ray, of the base",
                                           "Imbalance",
                                           "Frames per s"};
    bool scales = false, has_energy = false;

    for (int i = 0; i < view->count; i++) {
        scales = scales || view->cells[i].base != i;
        has_energy = has_energy || (sc_study_has(view, i) && view->cells[i].typical.energy_j >= 0);
    }
    sc_page_section(page, "All cells");
    add_cells(page, view, "Times of a frame, in seconds", times, SC_COUNT_OF(times), add_times);
    sc_page_add(
        page,
        "<p class=\"note\">The 95 %% confidence interval of the median reaches from one "
        "measurement to another, chosen by their ranks (binomial distribution), so that "
        "nothing is assumed of how times are distributed; it needs %d measurements. Quartiles "
        "are interpolated. CPU time is that of all ranks, waiting included.</p>\n",
        SC_INTERVAL_LEAST);
    if (scales)
        add_cells(page, view, "Speed-up in rays per second of wall time", parallel,
                  SC_COUNT_OF(parallel), add_parallel);
    add_cells(page, view, "Work, preparation and memory, of the measurement nearest to the median",
              work, has_energy ? WORK_COLUMNS + 1 : WORK_COLUMNS, add_work);
    if (!has_energy)
        sc_page_add(page, "<p class=\"note\">Energy could not be read: most systems allow only "
                          "administrators to read the counters of the processor (RAPL).</p>\n");
    sc_page_section_end(page);
}

/* ---- the machine ---- */

/* Add the table of all runs of segcast study. */
static void add_runs(sc_page *page, const sc_measurements *m)
{
    static const char *const heads[] = {
        "Begin",           "Host",   "Processor", "Nodes",   "Ranks",
        "Cores of rank 0", "Kernel", "MPI",       "segcast", "Batch job"};
    const size_t first = m->run_count > RUNS_SHOWN ? m->run_count - RUNS_SHOWN : 0;
    sc_table table;

    sc_page_section(page, "Where it was measured");
    table = sc_table_begin(page, "Runs of segcast study", heads, SC_COUNT_OF(heads));
    for (size_t i = first; i < m->run_count; i++) {
        const sc_study_run *run = &m->runs[i];

        sc_table_cell(&table, "%s", run->begin);
        sc_table_cell(&table, "%s", run->host);
        sc_table_cell(&table, "%s", run->processor);
        sc_table_cell(&table, "%d", run->nodes);
        sc_table_cell(&table, "%d", run->ranks);
        sc_table_cell(&table, "%d", run->cores);
        sc_table_cell(&table, "%s", run->kernel[0] ? run->kernel : "-");
        sc_table_cell(&table, "%s", run->mpi);
        sc_table_cell(&table, "%s, commit %s", run->version, run->commit);
        sc_table_cell(&table, "%s", run->batch_job[0] ? run->batch_job : "-");
    }
    sc_table_end(&table);
    sc_page_section_end(page);
}

/* Add the study as read, and links to its files. */
static void add_files(sc_page *page, const char *directory)
{
    static const struct {
        const char *name, *what;
    } files[] = {{"measurements.jsonl", "every measurement"},
                 {"cells.csv", "a row for each cell, with all columns"},
                 {"extrap.jsonl", "every measurement in the format of Extra-P"},
                 {"study.yaml", "the study as read, which can be measured again"}};

    sc_page_section(page, "Settings");
    sc_report_file(page, directory, "study.yaml", "The study with all its settings");
    sc_page_section_end(page);
    sc_page_section(page, "Files");
    sc_page_add(page, "<ul>\n");
    for (size_t i = 0; i < SC_COUNT_OF(files); i++)
        sc_report_link(page, directory, files[i].name, files[i].what);
    sc_page_add(page, "</ul>\n");
    sc_page_section_end(page);
}

sc_status sc_report_study(const sc_ctx *ctx, const char *directory, const sc_measurements *m,
                          sc_text *out)
{
    sc_study_view view = {0};
    sc_page page = {.ctx = ctx};
    sc_status status;

    SC_TRY(sc_study_view_open(ctx, m, &view));
    page = sc_page_begin(ctx, m->design.title[0] ? m->design.title : "A timing study");
    sc_report_study_words(&page, &view);
    if (view.measured) {
        sc_report_study_plots(&page, &view);
        if (m->design.axis_count)
            add_effects(&page, &view);
        add_tables(&page, &view);
    }
    add_runs(&page, m);
    add_files(&page, directory);
    SC_TRY(sc_page_end(&page));
    *out = page.text;
    page.text = (sc_text){0};
out:
    sc_page_clear(&page);
    sc_study_view_clear(&view);
    return status;
}
