/* SPDX-License-Identifier: BSD-3-Clause */
/* The page of a study. */
#include "study_view.h"

#include <math.h>

enum {
    CELLS_SHOWN = 150,
    RUNS_SHOWN = 50,
    TIMES_SHOWN = 4000 /* most single measurements, of all cells together */
};

/* ---- cells ---- */

/* @return a number of a measurement that may be unknown. */
static json_t *known(double value)
{
    return sc_json_number(value >= 0 ? value : NAN);
}

/* @return the statistics of a time, for each of @p frames frames. */
static json_t *time_json(const sc_statistics *s, double frames)
{
    const double none = s->has_interval ? 0 : NAN;

    return json_pack("{s:f, s:o, s:o, s:o, s:f, s:f, s:[f, f]}", "median", s->median / frames,
                     "low", sc_json_number(s->low / frames + none), "high",
                     sc_json_number(s->high / frames + none), "precision",
                     sc_json_number(sc_statistics_precision(s)), "least", s->least / frames, "most",
                     s->most / frames, "quartiles", s->quartile_1 / frames, s->quartile_3 / frames);
}

/* @return single measurements of a cell, as time of a frame: wall time where speed-up is shown. */
static json_t *times_json(const sc_study_view *view, int cell, int most)
{
    const bool wall = view->scale >= 0 || view->m->design.by_wall;
    json_t *times = json_array();

    for (size_t i = 0; i < view->m->count; i++) {
        const sc_measurement *m = &view->m->items[i];

        if (m->cell == cell && json_array_size(times) < (size_t)most)
            times = sc_json_with(times, json_real((wall ? m->wall_s : m->cpu_s) / m->frames));
    }
    return times;
}

/* @return the speed-up of a cell, times @p factor, and between which numbers it lies if both times
 * lie in their confidence intervals; null if there is none. */
static json_t *speedup_json(const sc_study_view *view, const sc_cell_result *r, double factor)
{
    const sc_statistics *time = &r->wall_s, *base = &view->cells[r->base].wall_s;
    const double value = factor * r->speedup;

    if (!(r->speedup > 0) || !(time->low > 0) || !(base->low > 0))
        return json_null();
    if (r->base == r->cell)
        return json_pack("[f, f, f]", value, value, value);
    return json_pack("[f, f, f]", value,
                     value * time->median / time->high * base->low / base->median,
                     value * time->median / time->low * base->high / base->median);
}

/* @return what limited a cell, judged by its typical measurement. */
static const char *limit_of(const sc_study_view *view, const sc_measurement *t)
{
    const double drawing_s = t->draw.mean_s * t->ranks * t->threads;
    const double start_s =
        view->m->design.whole_jobs ? t->start.read_s + t->start.prepare_s + t->start.share_s : 0;

    if (start_s > 0.5 * t->wall_s)
        return "start";
    if (t->accept_s > 0.8 * t->wall_s)
        return "encode";
    if (t->idle_mean_s > 0.15 * t->wall_s)
        return "wait";
    if (t->ranks * t->threads > 1 && drawing_s > 0 && t->draw.cpu_s < 0.8 * drawing_s)
        return "cores";
    return "draw";
}

/* @return a cell. @param times how many of its measurements are told. */
static json_t *cell_json(const sc_study_view *view, int cell, int times)
{
    const sc_cell_result *r = &view->cells[cell];
    const sc_measurement *t = &r->typical;
    const sc_core_time cores = sc_measurement_core_time(t, view->m->design.whole_jobs);
    json_t *json = json_pack(
        "{s:i, s:i, s:i, s:i, s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:I, "
        "s:I, s:I, s:s}",
        "cell", cell, "n", (int)r->cpu_s.count, "nodes", t->nodes, "ranks", t->ranks, "threads",
        t->threads, "base", r->base, "workers", r->workers, "serial_share", r->serial_share, "cost",
        r->cost, "imbalance", r->imbalance, "frames_per_s", r->frames_per_s, "mrays_per_cpu_s",
        r->mrays_per_cpu_s, "samples_per_ray", r->samples_per_ray, "contributions_per_ray",
        t->work.rays ? (double)t->work.contributions / (double)t->work.rays : 0, "start_s",
        t->start.read_s + t->start.prepare_s + t->start.share_s, "derive_s", t->start.derive_s,
        "prepared_bytes", (json_int_t)t->memory.prepared_bytes, "peak_rss_most_bytes",
        (json_int_t)t->memory.peak_most_bytes, "peak_rss_sum_bytes",
        (json_int_t)t->memory.peak_sum_bytes, "limit", limit_of(view, t));
    json_t *more = json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "cpu", time_json(&r->cpu_s, t->frames), "wall",
        time_json(&r->wall_s, t->frames), "times", times_json(view, cell, times), "speedup",
        speedup_json(view, r, 1), "efficiency",
        speedup_json(view, r, view->cells[r->base].workers / r->workers), "energy_j",
        known(t->energy_j >= 0 ? t->energy_j / t->frames : -1), "core", sc_json_core_time(&cores));

    if (!more || json_object_update(json, more)) {
        json_decref(json);
        json = NULL;
    }
    json_decref(more);
    return json;
}

static json_t *cells_json(const sc_study_view *view)
{
    const int shown = view->measured < CELLS_SHOWN ? view->measured : CELLS_SHOWN;
    json_t *cells = json_array();
    int found = 0;

    for (int i = 0; i < view->count && found < shown; i++) {
        if (sc_study_has(view, i)) {
            cells = sc_json_with(cells, cell_json(view, i, TIMES_SHOWN / shown));
            found++;
        }
    }
    return cells;
}

/* ---- the axes ---- */

static json_t *axes_json(const sc_design *design)
{
    json_t *axes = json_array();

    for (int a = 0; a < design->axis_count; a++) {
        json_t *values = json_array();

        for (int v = 0; v < design->axes[a].value_count; v++)
            values = sc_json_with(values, sc_json_text(design->axes[a].values[v]));
        axes = sc_json_with(axes, json_pack("{s:o, s:o}", "name",
                                            sc_json_text(design->axes[a].name), "values", values));
    }
    return axes;
}

/* ---- the whole ---- */

/* @return whether the values of an axis may not change a pixel. */
static bool keeps_pixels(const char *name)
{
    return !strcmp(name, "ranks") || !strcmp(name, "threads") || !strcmp(name, "placement") ||
           !strcmp(name, "render.skip") || !strcmp(name, "render.cpu") ||
           !strncmp(name, "farm.", strlen("farm."));
}

/* Set `mismatch` to two cells whose pixels have to be the same and are not, or to null. */
static sc_status add_mismatch(const sc_ctx *ctx, const sc_study_view *view, json_t *data)
{
    const sc_design *design = &view->m->design;
    SC_OWN(sc_free_at) uint64_t *pictures = NULL;
    int cell, other = 0;

    SC_PASS(SC_ZALLOC(ctx, (size_t)view->count, &pictures));
    for (int i = 0; i < view->count; i++) {
        for (int a = 0; a < design->axis_count; a++) {
            if (!keeps_pixels(design->axes[a].name))
                pictures[i] = pictures[i] * (uint64_t)design->axes[a].value_count +
                              (uint64_t)sc_design_index(design, i, a);
        }
    }
    cell = sc_measurements_mismatch(view->m, 0, pictures, &other);
    return sc_json_set(ctx, data, "mismatch",
                       cell < 0 ? json_null() : json_pack("[i, i]", cell, other));
}

static json_t *runs_json(const sc_measurements *m)
{
    json_t *runs = json_array();

    for (size_t i = m->run_count > RUNS_SHOWN ? m->run_count - RUNS_SHOWN : 0; i < m->run_count;
         i++)
        runs = sc_json_with(runs, sc_study_run_json(&m->runs[i]));
    return runs;
}

/* @return why cells were not measured, each reason once, with how many they are. */
static json_t *skipped_json(const sc_measurements *m)
{
    json_t *json = json_array();

    for (size_t i = 0; i < m->skipped_count; i++) {
        int same = 0;
        bool is_new = true;

        for (size_t j = 0; j < m->skipped_count; j++) {
            const bool equal = !strcmp(m->skipped[j].reason, m->skipped[i].reason);

            is_new = is_new && !(equal && j < i);
            same += equal;
        }
        if (is_new)
            json = sc_json_with(json, json_pack("{s:i, s:o}", "count", same, "reason",
                                                sc_json_text(m->skipped[i].reason)));
    }
    return json;
}

/* @return the times of the paper for its two methods, if the study compares these; else null. */
static json_t *paper_json(const sc_study_view *view)
{
    return sc_study_has_paper(view) ? json_pack("{s:f, s:f}", "none", SC_PAPER_PLAIN_S, "interior",
                                                SC_PAPER_ACCELERATED_S)
                                    : json_null();
}

sc_status sc_report_study(const sc_ctx *ctx, const char *directory, const sc_measurements *m,
                          sc_text *out)
{
    static const char *const files[] = {"measurements.jsonl", "cells.csv", "extrap.jsonl",
                                        "study.yaml"};
    SC_OWN(sc_study_view_clear) sc_study_view view = {0};
    json_auto_t *data = NULL;
    int missing = 0;

    SC_PASS(sc_study_view_open(ctx, m, &view));
    for (int i = 0; i < view.count; i++)
        missing += !view.cells[i].skipped && !sc_study_has(&view, i);
    data = json_pack(
        "{s:s, s:o, s:I, s:i, s:i, s:i, s:b, s:b, s:i, s:i, s:o, s:o, s:o, s:I, s:o, s:o}", "kind",
        "study", "title", sc_json_text(m->design.title[0] ? m->design.title : "A timing study"),
        "count", (json_int_t)m->count, "cell_count", view.count, "measured", view.measured,
        "missing", missing, "complete", m->complete, "by_wall", m->design.by_wall, "series",
        view.series, "scale", view.scale, "axes", axes_json(&m->design), "cells", cells_json(&view),
        "runs", runs_json(m), "run_count", (json_int_t)m->run_count, "skipped", skipped_json(m),
        "paper", paper_json(&view));
    SC_PASS(add_mismatch(ctx, &view, data));
    SC_PASS(sc_json_sources(ctx, directory, "study.yaml", files, SC_COUNT_OF(files), data));
    return sc_json_page(ctx, data, out);
}
