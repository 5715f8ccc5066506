/* SPDX-License-Identifier: BSD-3-Clause */
/* The plots of a study: speed-up and efficiency over ranks and threads, or bars for each method. */
#include "study_view.h"

#include <math.h>
#include <stdlib.h>

enum {
    CURVES = 7,       /* most curves of a plot; the last colour stands for the ideal */
    CHARTS = 24,      /* most charts of bars */
    BARS = 60,        /* most cells whose core time is shown */
    DOTS = 60,        /* most single measurements that a bar shows */
    CURVE_POINTS = 64 /* most cells of a curve */
};

/* ---- curves over workers ---- */

/* A cell of a curve; low and high: the confidence interval. */
typedef struct curve_point {
    int cell;
    double workers, value, low, high;
} curve_point;

typedef struct curve {
    curve_point points[CURVE_POINTS]; /* by rising workers */
    int count;
    int first_cell; /* for its name */
} curve;

/* What a plot shows of a cell. */
typedef enum measure { SPEEDUP, EFFICIENCY } measure;

/* @return the speed-up of a cell if a pass took @p wall_s and one of its base @p base_s, or its
 * efficiency. */
static double value_at(const sc_study_view *view, int cell, measure what, double wall_s,
                       double base_s)
{
    const sc_cell_result *r = &view->cells[cell], *base = &view->cells[r->base];
    const double work = (double)r->typical.rays / (double)base->typical.rays;
    const double speedup = work * base_s / wall_s;

    return what == SPEEDUP ? speedup : speedup * base->workers / r->workers;
}

static int by_workers(const void *a, const void *b)
{
    const curve_point *x = a, *y = b;

    return x->workers != y->workers ? (x->workers > y->workers ? 1 : -1) : x->cell - y->cell;
}

/* Collect the cells that differ from @p cell only in the axis of ranks or threads. The interval is
 * that of the quotient of two times, each of which lies in its own. */
static void fill_curve(const sc_study_view *view, int cell, measure what, curve *out)
{
    const int values = view->m->design.axes[view->scale].value_count;

    out->count = 0;
    out->first_cell = cell;
    for (int v = 0; v < values && out->count < CURVE_POINTS; v++) {
        const int i = sc_study_with(view, cell, view->scale, v);
        const sc_cell_result *r = &view->cells[i], *base = &view->cells[r->base];
        curve_point *p = &out->points[out->count];

        if (!sc_study_has(view, i) || !sc_study_has(view, r->base) || base->typical.rays == 0 ||
            !(r->wall_s.low > 0) || !(base->wall_s.low > 0))
            continue;
        *p = (curve_point){.cell = i, .workers = r->workers};
        p->value = value_at(view, i, what, r->wall_s.median, base->wall_s.median);
        p->low = value_at(view, i, what, r->wall_s.high, base->wall_s.low);
        p->high = value_at(view, i, what, r->wall_s.low, base->wall_s.high);
        if (i == r->base)
            p->low = p->high = p->value;
        out->count++;
    }
    qsort(out->points, (size_t)out->count, sizeof *out->points, by_workers);
}

/* Draw the measurements of a cell as dots. */
static void draw_measurements(sc_plot *plot, const sc_study_view *view, const curve_point *p,
                              measure what, int color)
{
    const sc_cell_result *base = &view->cells[view->cells[p->cell].base];
    double x[DOTS], y[DOTS];
    int count = 0;

    for (size_t i = 0; i < view->m->count && count < DOTS; i++) {
        const sc_measurement *m = &view->m->items[i];

        if (m->cell != p->cell || !(m->wall_s > 0))
            continue;
        x[count] = p->workers;
        y[count++] = value_at(view, p->cell, what, m->wall_s, base->wall_s.median);
    }
    sc_plot_points(plot, x, y, count, color);
}

/* Draw band, line and dots of a curve. */
static void draw_curve(sc_plot *plot, const sc_study_view *view, const curve *c, measure what,
                       int color)
{
    double x[CURVE_POINTS], y[CURVE_POINTS], low[CURVE_POINTS], high[CURVE_POINTS];

    for (int i = 0; i < c->count; i++) {
        x[i] = c->points[i].workers;
        y[i] = c->points[i].value;
        low[i] = c->points[i].low;
        high[i] = c->points[i].high;
    }
    sc_plot_band(plot, x, low, high, c->count, color);
    sc_plot_line(plot, x, y, c->count, color, false);
    for (int i = 0; i < c->count; i++)
        draw_measurements(plot, view, &c->points[i], what, color);
}

/* Find the least and the most workers of all curves, and the lowest and the highest value. */
static void find_range(const sc_study_view *view, const curve *curves, int count, double workers[2],
                       double values[2])
{
    workers[0] = values[0] = INFINITY;
    workers[1] = values[1] = 0;
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < curves[i].count; j++) {
            const curve_point *p = &curves[i].points[j];
            const sc_cell_result *r = &view->cells[p->cell];
            const double slowest = p->value * r->wall_s.median / r->wall_s.most;
            const double fastest = p->value * r->wall_s.median / r->wall_s.least;

            workers[0] = fmin(workers[0], p->workers);
            workers[1] = fmax(workers[1], p->workers);
            values[0] = fmin(values[0], fmin(p->low, slowest));
            values[1] = fmax(values[1], fmax(p->high, fastest));
        }
    }
}

/* Add the plot of all curves. */
static void add_plot(sc_page *page, const sc_study_view *view, const curve *curves, int count,
                     measure what)
{
    static const sc_plot_words words[] = {
        [SPEEDUP] =
            {"Speed-up against the fewest workers, in rays per second of wall time; more is "
             "better, the dashed line is ideal",
             "The table of scaling holds the numbers.", "ranks times threads"},
        [EFFICIENCY] = {"Efficiency: speed-up for each worker; the dashed line is ideal",
                        "The table of scaling holds the numbers.", "ranks times threads"}};
    double workers[2], values[2], ideal[2] = {1, 1};
    sc_plot plot;

    find_range(view, curves, count, workers, values);
    if (what == SPEEDUP)
        ideal[1] = workers[1] / workers[0];
    plot = sc_plot_begin(page, &words[what], sc_axis_doubling(workers[0], workers[1]),
                         what == SPEEDUP
                             ? sc_axis_doubling(fmin(values[0], 1), fmax(values[1], ideal[1]))
                             : sc_axis_make(0, fmax(values[1], 1), 5));
    sc_plot_line(&plot, workers, ideal, 2, SC_COLOR_IDLE, true);
    for (int i = 0; i < count; i++)
        draw_curve(&plot, view, &curves[i], what, i);
    sc_plot_end(&plot);
}

/* Fill the curves of a study: one for each combination of all axes but that of ranks or threads.
 * @return how many there are; only the first CURVES of them are filled. */
static int fill_curves(const sc_study_view *view, measure what, curve curves[CURVES])
{
    int count = 0;
    curve spare;

    for (int i = 0; i < view->count; i++) {
        curve *c = count < CURVES ? &curves[count] : &spare;

        if (!sc_study_is_first(view, i, view->scale))
            continue;
        fill_curve(view, i, what, c);
        count += c->count > 0;
    }
    return count;
}

/* Add the plots of speed-up and efficiency. */
static void add_scaling(sc_page *page, const sc_study_view *view)
{
    char names[CURVES][SC_CELL_NAME_BYTES];
    const char *labels[CURVES];
    int colors[CURVES], shown, count;
    curve *curves;
    void *block;

    if (page->status == SC_OK)
        page->status = sc_alloc(page->ctx, CURVES, sizeof *curves, &block);
    if (page->status != SC_OK)
        return;
    curves = block;
    count = fill_curves(view, SPEEDUP, curves);
    shown = count < CURVES ? count : CURVES;
    for (int i = 0; i < shown; i++) {
        sc_study_name(view, curves[i].first_cell, view->scale, "all cells", names[i]);
        labels[i] = names[i];
        colors[i] = i;
    }
    if (shown) {
        sc_page_section(page, "Scaling");
        sc_legend(page, labels, colors, shown);
        add_plot(page, view, curves, shown, SPEEDUP);
        (void)fill_curves(view, EFFICIENCY, curves);
        add_plot(page, view, curves, shown, EFFICIENCY);
        sc_page_add(page,
                    "<p class=\"note\">Dots are single measurements. A band holds all quotients of "
                    "two times of which each lies in the 95 %% confidence interval of its median. "
                    "Both axes of the first plot are logarithmic.</p>\n");
        if (shown < count)
            sc_page_add(page, "<p class=\"note\">The first %d of %d curves are shown.</p>\n", shown,
                        count);
        sc_page_section_end(page);
    }
    sc_free(block);
}

/* ---- bars ---- */

/* @return the time of a frame in a measurement. */
static double frame_s(const sc_study_view *view, const sc_measurement *m)
{
    return (view->m->design.by_wall ? m->wall_s : m->cpu_s) / m->frames;
}

/* Add the bar of a cell. */
static void add_bar(sc_row_chart *rows, const sc_study_view *view, int cell)
{
    const sc_statistics *time = sc_study_time(view, cell);
    const double frames = view->cells[cell].typical.frames;
    char label[SC_CELL_NAME_BYTES], value[48], what[160];
    double dots[DOTS];
    int count = 0;

    if (view->series >= 0)
        sc_study_value(view, cell, view->series, label, sizeof label);
    else
        sc_study_name(view, cell, -1, "the only cell", label);
    if (!sc_study_has(view, cell)) {
        sc_row_begin(rows, label, "not measured");
        sc_row_end(rows, "-");
        return;
    }
    for (size_t i = 0; i < view->m->count && count < DOTS; i++) {
        if (view->m->items[i].cell == cell)
            dots[count++] = frame_s(view, &view->m->items[i]);
    }
    snprintf(value, sizeof value, "%.4g", time->median / frames);
    snprintf(what, sizeof what, "median %s of %zu measurements, from %.4g to %.4g", value,
             time->count, time->least / frames, time->most / frames);
    sc_row_begin(rows, label, what);
    sc_row_bar(rows, 0, time->median / frames, 3);
    sc_row_dots(rows, dots, count);
    if (time->has_interval)
        sc_row_interval(rows, time->low / frames, time->high / frames);
    sc_row_end(rows, value);
}

/* Add the chart of a group: of the cells that differ from @p group in the series only. */
static void add_chart(sc_page *page, const sc_study_view *view, int group)
{
    const int values = view->series < 0 ? 1 : view->m->design.axes[view->series].value_count;
    char name[SC_CELL_NAME_BYTES], caption[SC_CELL_NAME_BYTES + 80];
    double most = 0;
    sc_row_chart rows;

    for (int v = 0; v < values; v++) {
        const int cell = view->series < 0 ? group : sc_study_with(view, group, view->series, v);

        if (sc_study_has(view, cell))
            most = fmax(most, sc_study_time(view, cell)->most / view->cells[cell].typical.frames);
    }
    if (most <= 0)
        return;
    sc_study_name(view, group, view->series, "", name);
    snprintf(caption, sizeof caption, "%s%s%s; less is better", name, name[0] ? ": " : "",
             sc_study_unit(view));
    rows = sc_rows_begin(page, caption, sc_axis_to(most, 6, false), false);
    for (int v = 0; v < values; v++)
        add_bar(&rows, view,
                view->series < 0 ? group : sc_study_with(view, group, view->series, v));
    sc_rows_end(&rows, sc_study_unit(view));
}

/* Add the charts of all groups. */
static void add_bars(sc_page *page, const sc_study_view *view)
{
    int count = 0;

    sc_page_section(page, "Time of a frame");
    for (int i = 0; i < view->count; i++) {
        if (!sc_study_is_first(view, i, view->series))
            continue;
        if (count++ < CHARTS)
            add_chart(page, view, i);
    }
    sc_page_add(page, "<p class=\"note\">Bars are medians, circles single measurements, and the "
                      "black line is the 95 %% confidence interval of the median.</p>\n");
    if (count > CHARTS)
        sc_page_add(page, "<p class=\"note\">The first %d of %d charts are shown.</p>\n", CHARTS,
                    count);
    sc_page_section_end(page);
}

/* Add a bar for each cell that splits the time of its cores by cause. */
static void add_core_times(sc_page *page, const sc_study_view *view)
{
    sc_row_chart rows;
    int shown = 0;

    sc_page_section(page, "Where the time went");
    rows = sc_report_core_begin(page);
    for (int i = 0; i < view->count; i++) {
        const sc_core_time time =
            sc_measurement_core_time(&view->cells[i].typical, view->m->design.whole_jobs);
        char name[SC_CELL_NAME_BYTES];

        if (!sc_study_has(view, i) || shown++ >= BARS)
            continue;
        sc_study_name(view, i, -1, "the only cell", name);
        sc_report_core_row(&rows, name, &time);
    }
    sc_rows_end(&rows, "percent");
    if (shown > BARS)
        sc_page_add(
            page, "<p class=\"note\">The first %d of %d cells are shown; cells.csv has all.</p>\n",
            BARS, shown);
    sc_page_add(page, "<p class=\"note\">Of the measurement of each cell that is nearest to the "
                      "median. Cores: ranks times threads. The number at the end is the share of "
                      "drawing.</p>\n");
    sc_page_section_end(page);
}

void sc_report_study_plots(sc_page *page, const sc_study_view *view)
{
    if (view->scale >= 0)
        add_scaling(page, view);
    else
        add_bars(page, view);
    add_core_times(page, view);
}
