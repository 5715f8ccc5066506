/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast study: measures all cells of a study again and again, in random order, until each is
 * known exactly enough or the time is over. */
#include "study/study.h"

#include <math.h>

/* What all ranks do next. Sent as bytes. */
typedef struct step {
    int32_t cell; /* -1: the study ends */
    sc_study_way way;
} step;

/* Rank 0's view of a study. */
typedef struct director {
    sc_study_state *state;
    sc_study_records records;
    sc_schedule schedule;
    double begin_s, deadline_s, told_s; /* by sc_wall_s; deadline_s 0: none */
    int piloted;                        /* how many cells have been looked at */
    sc_status outcome;
} director;

/* ---- progress ---- */

/* @return how many measurements of all cells are done, of *total at most: a cell that is known
 * exactly enough counts as measured as often as any may be, so that the last one completes it. */
static int progress_of(const director *d, int *total)
{
    const sc_schedule *s = &d->schedule;
    const int most = d->state->study.most;
    int done = 0;

    *total = 0;
    for (int i = 0; i < s->cell_count; i++) {
        if (!s->cells[i].runs_here)
            continue;
        *total += most;
        done += s->done[i] || s->counts[i] > most ? most : s->counts[i];
    }
    return done;
}

/* @return in how many seconds the study ends at the latest, as far as that can be told. */
static double remaining_s(const director *d)
{
    const sc_study *study = &d->state->study;
    const double now_s = sc_wall_s();
    const double budget_s = study->budget_s - (now_s - d->begin_s);
    const double left_s =
        fmin(sc_schedule_estimate_s(&d->schedule, study->most), fmax(0, budget_s));

    return d->deadline_s > 0 ? fmin(left_s, fmax(0, d->deadline_s - now_s)) : left_s;
}

/* Write status.json, unless that was done just now. */
static void tell_state(director *d, const char *state)
{
    const bool runs = !strcmp(state, "running");
    sc_progress_report report = {.state = state,
                                 .phase = runs ? "measuring" : NULL,
                                 .phase_share = -1,
                                 .elapsed_s = sc_wall_s() - d->begin_s};

    if (runs && sc_wall_s() - d->told_s < 2)
        return;
    d->told_s = sc_wall_s();
    report.done = progress_of(d, &report.total);
    if (runs)
        report.remaining_s = remaining_s(d);
    else if (!strcmp(state, "complete")) /* perhaps because the budget is used up */
        report.total = report.done;
    /* A status.json that cannot be written does not end the study: its measurements matter. */
    (void)sc_study_write_state(&d->records, &report);
}

/* Append seconds in the words of people. */
static void format_time(double seconds, char *out, size_t size)
{
    if (seconds < 90)
        snprintf(out, size, "%.0f s", seconds);
    else if (seconds < 5400)
        snprintf(out, size, "%.0f min", seconds / 60);
    else
        snprintf(out, size, "%.1f h", seconds / 3600);
}

/* ---- the schedule ---- */

/* Note a new measurement of a cell, and whether the cell needs more. */
static sc_status note(director *d, const sc_measurement *m)
{
    const sc_study *study = &d->state->study;
    const sc_measurements *all = &d->records.results;
    sc_schedule *s = &d->schedule;
    sc_statistics statistics;
    SC_OWN(sc_free_at) double *values = NULL;
    size_t count = 0;
    sc_status status;

    SC_PASS(SC_ALLOC(d->state->app->ctx, all->count + 1, &values));
    for (size_t i = 0; i < all->count; i++) {
        if (all->items[i].cell == m->cell)
            values[count++] =
                study->metric == SC_STUDY_CPU ? all->items[i].cpu_s : all->items[i].wall_s;
    }
    status = sc_statistics_of(d->state->app->ctx, values, count, &statistics);
    if (status == SC_OK) {
        s->counts[m->cell] = (int)count;
        s->done[m->cell] =
            (int)count >= study->most || ((int)count >= study->least &&
                                          sc_statistics_precision(&statistics) <= study->precision);
    }
    return status;
}

/* Note what the first look at a cell has told of its cost. */
static void note_cost(director *d, const sc_measurement *m)
{
    sc_cell_cost *cost = &d->schedule.costs[m->cell];
    const double frame_s = m->wall_s;
    const int frames = d->state->cells[m->cell].frames;

    d->piloted++;
    if (d->state->whole_jobs) {
        cost->measure_s = m->wall_s;
        return;
    }
    cost->load_s = m->start.read_s + m->start.prepare_s + m->start.share_s - m->start.derive_s;
    cost->measure_s = m->start.derive_s + frame_s + fmax(frames * frame_s, SC_MEASURED_S);
}

/* All pixels of cells that show the same picture have to be the same. @param from index of the
 * first measurement that is checked. */
static sc_status check_pixels(const director *d, size_t from)
{
    const sc_ctx *ctx = d->state->app->ctx;
    uint64_t *pictures = NULL;
    int cell, other = -1;

    SC_PASS(SC_ALLOC(ctx, (size_t)d->state->cell_count, &pictures));
    for (int i = 0; i < d->state->cell_count; i++)
        pictures[i] = d->state->cells[i].picture;
    cell = sc_measurements_mismatch(&d->records.results, from, pictures, &other);
    sc_free(pictures);
    if (cell < 0)
        return SC_OK;
    return sc_fail(ctx, SC_ERR_INTERNAL,
                   "cells %d and %d show the same picture, but their pixels differ: this is a bug "
                   "of segcast, or the volume has changed meanwhile; %s/cells.csv names the cells",
                   other, cell, d->records.directory);
}

/* @return a cell that has not been looked at, or -1. */
static int next_to_pilot(const director *d)
{
    for (int i = 0; i < d->schedule.cell_count; i++) {
        if (d->schedule.cells[i].runs_here && d->schedule.costs[i].measure_s == 0 &&
            !d->schedule.done[i])
            return i;
    }
    return -1;
}

/* All cells have been looked at: tell how often the budget lets each be measured. */
static void tell_plan(const director *d)
{
    const sc_study *study = &d->state->study;
    const double left_s = study->budget_s - (sc_wall_s() - d->begin_s);
    int times = study->least;
    char budget[32];

    format_time(study->budget_s, budget, sizeof budget);
    while (times > 0 && sc_schedule_estimate_s(&d->schedule, times) > left_s)
        times--;
    if (times == 0)
        sc_warn(d->state->app->ctx,
                "the budget of %s does not last for one measurement of each of %d cells", budget,
                d->piloted);
    else if (times < study->least)
        sc_warn(d->state->app->ctx,
                "the budget of %s lets each of %d cells be measured about %d time%s, and not %d; "
                "raise budget for narrower intervals",
                budget, d->piloted, times, times == 1 ? "" : "s", study->least);
    else
        sc_info(d->state->app->ctx, "%d cells, each measured %d times or more within %s",
                d->piloted, study->least, budget);
}

/* The budget is used up. @return the outcome: the study is complete if every cell that runs here
 * was measured; SC_ERR_USAGE if none was. */
static sc_status end_of_budget(const director *d)
{
    const sc_ctx *ctx = d->state->app->ctx;
    const sc_schedule *s = &d->schedule;
    int cells = 0, without = 0, few = 0;
    char budget[32];

    for (int i = 0; i < s->cell_count; i++) {
        cells += s->cells[i].runs_here;
        without += s->cells[i].runs_here && s->counts[i] == 0;
        few += s->cells[i].runs_here && s->counts[i] < d->state->study.least;
    }
    format_time(d->state->study.budget_s, budget, sizeof budget);
    if (d->records.results.count == 0)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "%s: the budget is %s, and looking at %d of %d cells took longer; raise "
                       "budget, or lower the frames or the number of values",
                       d->state->app->options.input, budget, d->piloted, cells);
    if (few)
        sc_warn(ctx,
                "the budget of %s is used up: %d of %d cells were measured fewer than %d times, "
                "and %d of them not at all",
                budget, few, cells, d->state->study.least, without);
    return without ? SC_ERR_INCOMPLETE : SC_OK;
}

/* @return what all ranks do next; cell -1, with d->outcome, when nothing is left to measure, the
 * budget is used up, or a signal or the deadline ends the study. On rank 0. */
static step choose(director *d)
{
    const step end = {.cell = -1};
    const double now_s = sc_wall_s();
    const int pilot = next_to_pilot(d);
    int cell;

    d->outcome = SC_OK;
    if (*sc_signals_catch_stop() || (d->deadline_s > 0 && now_s > d->deadline_s)) {
        d->outcome = SC_ERR_INCOMPLETE;
        return end;
    }
    if (now_s - d->begin_s > d->state->study.budget_s) {
        d->outcome = end_of_budget(d);
        return end;
    }
    if (pilot >= 0)
        return (step){.cell = pilot, .way = {.pilot = true}};
    cell = sc_schedule_next(&d->schedule);
    return (step){.cell = cell, .way = {.round = d->schedule.round}};
}

/* Keep what was measured. On rank 0. */
static sc_status keep(director *d, const step *what, const sc_measurement *m)
{
    int total, before;

    if (what->way.pilot) {
        note_cost(d, m);
        if (next_to_pilot(d) < 0)
            tell_plan(d);
        if (!d->state->whole_jobs)
            return SC_OK;
    }
    before = progress_of(d, &total);
    SC_PASS(sc_study_add(&d->records, m));
    SC_PASS(note(d, m));
    sc_stage_add(d->state->app->ctx, (uint64_t)(progress_of(d, &total) - before));
    tell_state(d, "running");
    return check_pixels(d, d->records.results.count - 1);
}

/* ---- the results as a table ---- */

enum { COLUMN_MOST = 40 }; /* longest value of an axis that widens its column */

/* Print @p text in a column; what is longer than the column makes its line longer. */
static void print_column(const char *text, int width)
{
    const int length = (int)sc_printable(text, NULL, 0);

    sc_print(stdout, text);
    printf("%*s", length < width ? width - length + 2 : 2, "");
}

/* @return the width of an axis's column. */
static int width_of(const sc_design_axis *axis)
{
    int width = (int)sc_printable(axis->name, NULL, 0);

    for (int i = 0; i < axis->value_count; i++) {
        const int length = (int)sc_printable(axis->values[i], NULL, 0);

        width = length > width ? length : width;
    }
    return width < COLUMN_MOST ? width : COLUMN_MOST;
}

/* Print the names of all columns. @param scales the study varies ranks or threads. */
static void print_head(const sc_design *design, bool scales)
{
    for (int i = 0; i < design->axis_count; i++)
        print_column(design->axes[i].name, width_of(&design->axes[i]));
    printf("%12s %6s %10s %4s%s", "CPU s/frame", "+-", "s/frame", "n",
           scales ? "  speed-up efficiency" : "");
    if (design->axis_count)
        printf("  times as fast as ");
    if (design->axis_count)
        sc_print(stdout, design->axes[design->axis_count - 1].values[0]);
    printf("\n");
}

/* Print the line of a cell. */
static void print_cell(const sc_design *design, const sc_cell_result *results, int cell,
                       bool scales)
{
    const sc_cell_result *r = &results[cell], *first = r;
    const double frames = r->typical.frames, precision = sc_statistics_precision(&r->cpu_s);

    for (int i = 0; i < design->axis_count; i++)
        print_column(design->axes[i].values[sc_design_index(design, cell, i)],
                     width_of(&design->axes[i]));
    if (r->cpu_s.count == 0) {
        printf("%s\n", r->skipped ? r->skipped : "not measured yet");
        return;
    }
    printf("%12.4g ", r->cpu_s.median / frames);
    if (isfinite(precision))
        printf("%4.1f %%", 100 * precision);
    else
        printf("%6s", "");
    printf(" %10.4g %4zu", r->wall_s.median / frames, r->cpu_s.count);
    if (scales)
        printf("  %8.2f %10.2f", r->speedup, r->efficiency);
    if (design->axis_count)
        first -= sc_design_index(design, cell, design->axis_count - 1);
    if (first != r && first->cpu_s.count > 0)
        printf("  %.2f", first->cpu_s.median / first->typical.frames * frames / r->cpu_s.median);
    printf("\n");
}

/* Print one line for each cell. */
static sc_status print_results(const director *d)
{
    const sc_design *design = &d->records.results.design;
    const int cells = sc_design_cells(design);
    SC_OWN(sc_free_at) sc_cell_result *results = NULL;
    bool scales = false;

    SC_PASS(sc_cell_results(d->state->app->ctx, &d->records.results, &results));
    for (int i = 0; i < cells; i++)
        scales = scales || results[i].base != i;
    print_head(design, scales);
    for (int i = 0; i < cells; i++)
        print_cell(design, results, i, scales);
    return SC_OK;
}

/* ---- the command ---- */

/* Everything on rank 0 between the list of cells and the first measurement. */
static sc_status begin(director *d)
{
    sc_study_state *state = d->state;
    const sc_app *app = state->app;
    const sc_measurements *all = &d->records.results;
    char why[160];
    int total, done, last_round = -1;

    d->records.state = state;
    d->records.directory = app->options.output ? app->options.output : "segcast-study";
    SC_PASS(sc_path_join(app->ctx, d->records.directory, "work", &state->work));
    SC_PASS(sc_study_note_inputs(state));
    SC_PASS(sc_study_open(&d->records));
    SC_PASS(sc_study_write_crate(&d->records));
    SC_PASS(check_pixels(d, 0));
    for (size_t i = 0; i < all->count; i++)
        last_round = all->items[i].round > last_round ? all->items[i].round : last_round;
    SC_PASS(sc_schedule_init(app->ctx, state->cells, state->cell_count, (uint64_t)state->study.seed,
                             last_round + 1, &d->schedule));
    for (int i = 0; i < state->cell_count; i++) {
        if (state->cells[i].runs_here)
            continue;
        sc_study_why_not(state, i, why, sizeof why);
        SC_PASS(sc_study_skip(&d->records, i, why));
    }
    for (size_t i = 0; i < all->count; i++)
        SC_PASS(note(d, &all->items[i]));
    done = progress_of(d, &total);
    d->begin_s = sc_wall_s();
    sc_stage_begin(app->ctx, "measuring", (uint64_t)done, (uint64_t)total);
    tell_state(d, "running");
    return SC_OK;
}

/* Measure one cell after the other until rank 0 ends it. Collective. */
static sc_status measure_all(director *d)
{
    sc_app *app = d->state->app;
    const bool first = sc_comm_rank(app->comm) == 0;

    for (;;) {
        step next = {0};
        sc_measurement m = {0};

        if (first)
            next = choose(d);
        sc_comm_broadcast(app->comm, &next, sizeof next);
        if (next.cell < 0)
            break;
        SC_PASS(sc_study_measure(d->state, next.cell, &next.way, &m));
        SC_PASS(sc_comm_agree(app->comm, first ? keep(d, &next, &m) : SC_OK));
    }
    return sc_comm_agree(app->comm, d->outcome);
}

/* Write report.html from what is on disk, so that segcast report makes the same page. What was
 * measured is kept: a page that cannot be made does not fail the study. */
static void write_page(const director *d)
{
    const sc_ctx *ctx = d->state->app->ctx;
    const char *directory = d->records.directory;
    SC_OWN(sc_measurements_clear) sc_measurements all = {0};
    sc_status status = sc_study_read(ctx, directory, &all);

    if (status == SC_OK)
        status = sc_study_write_page(ctx, directory, &all);
    if (status != SC_OK)
        sc_warn(ctx, "the page with the report was not made; `segcast report %s` makes it",
                directory);
}

/* On rank 0: write the tables, print the results and say how it ended. @return @p outcome, or a
 * more severe error. */
static sc_status end(director *d, sc_status outcome)
{
    const sc_app *app = d->state->app;
    sc_status status;

    sc_stage_end(app->ctx);
    if (!d->records.file || (outcome != SC_OK && outcome != SC_ERR_INCOMPLETE)) {
        d->records.discard = true;
        if (d->records.results.count > 0)
            tell_state(d, "failed");
        return outcome;
    }
    SC_TRY(sc_study_write_tables(&d->records));
    if (outcome == SC_OK)
        SC_TRY(sc_measurement_file_complete(app->ctx, d->records.file));
    write_page(d);
    SC_TRY(sc_study_write_crate(&d->records));
    tell_state(d, outcome == SC_OK ? "complete" : "incomplete");
    sc_display_end_stage(app);
    SC_TRY(print_results(d));
    if (outcome == SC_ERR_INCOMPLETE)
        sc_warn(app->ctx,
                "stopped after %zu measurements; run again with --resume for the rest of the study",
                d->records.results.count);
    sc_print_made(d->records.directory);
out:
    return status == SC_OK ? outcome : status;
}

sc_status sc_cmd_study(sc_app *app)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_study_state state = {.app = app};
    director d = {.state = &state, .begin_s = sc_wall_s(), .deadline_s = sc_deadline_s(app)};
    sc_status status;

    app->measures = true;
    sc_signals_catch_stop();
    if (first)
        state.mistake = sc_study_load(app->ctx, app->options.input, &state.study);
    SC_TRY(sc_study_list_cells(&state));
    SC_TRY(sc_report_placement(app));
    SC_TRY(sc_comm_agree(app->comm, first ? begin(&d) : SC_OK));
    sc_signals_stop_in_order(true);
    status = measure_all(&d);
out:
    sc_study_release(&state);
    sc_signals_stop_in_order(false);
    if (first)
        status = end(&d, status);
    status = sc_comm_agree(app->comm, status);
    sc_schedule_clear(&d.schedule);
    sc_study_close(&d.records);
    sc_study_clear_cells(&state);
    return status;
}
