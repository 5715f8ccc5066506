/* SPDX-License-Identifier: BSD-3-Clause */
/* A study with the results of its cells, and the names of cells. */
#include "study_view.h"

#include <stdlib.h>

/* @return the number of an axis with several values, or -1. */
static int find_axis(const sc_design *design, const char *name)
{
    for (int i = 0; i < design->axis_count; i++) {
        if (!strcmp(design->axes[i].name, name) && design->axes[i].value_count > 1)
            return i;
    }
    return -1;
}

/* Choose the axis whose values are compared: the skip methods, or else the last axis that is one of
 * the job. */
static int choose_series(const sc_design *design)
{
    int series = find_axis(design, "render.skip");

    for (int i = design->axis_count - 1; i >= 0 && series < 0; i--) {
        const char *name = design->axes[i].name;

        if (design->axes[i].value_count > 1 && strcmp(name, "ranks") && strcmp(name, "threads"))
            series = i;
    }
    return series;
}

sc_status sc_study_view_open(const sc_ctx *ctx, const sc_measurements *m, sc_study_view *out)
{
    sc_study_view view = {.m = m, .count = sc_design_cells(&m->design)};

    SC_PASS(sc_cell_results(ctx, m, &view.cells));
    for (int i = 0; i < view.count; i++)
        view.measured += view.cells[i].cpu_s.count > 0;
    view.series = choose_series(&m->design);
    view.scale = find_axis(&m->design, "ranks");
    if (view.scale < 0)
        view.scale = find_axis(&m->design, "threads");
    *out = view;
    return SC_OK;
}

void sc_study_view_clear(sc_study_view *view)
{
    sc_free(view->cells);
    *view = (sc_study_view){0};
}

bool sc_study_has(const sc_study_view *view, int cell)
{
    return view->cells[cell].cpu_s.count > 0;
}

int sc_study_with(const sc_study_view *view, int cell, int axis, int value)
{
    const sc_design *design = &view->m->design;
    int step = 1;

    for (int i = axis + 1; i < design->axis_count; i++)
        step *= design->axes[i].value_count;
    return cell + (value - sc_design_index(design, cell, axis)) * step;
}

bool sc_study_is_first(const sc_study_view *view, int cell, int axis)
{
    return axis < 0 || sc_design_index(&view->m->design, cell, axis) == 0;
}

const sc_statistics *sc_study_time(const sc_study_view *view, int cell)
{
    const sc_cell_result *r = &view->cells[cell];

    return view->m->design.by_wall ? &r->wall_s : &r->cpu_s;
}

double sc_study_frame_s(const sc_study_view *view, int cell)
{
    const int frames = view->cells[cell].typical.frames;

    return frames > 0 ? sc_study_time(view, cell)->median / frames : 0;
}

const char *sc_study_unit(const sc_study_view *view)
{
    return view->m->design.by_wall ? "seconds a frame" : "CPU seconds a frame";
}

/* Is the text a number? */
static bool is_number(const char *text)
{
    char *end;

    (void)strtod(text, &end);
    return end != text && !*end;
}

/* Write the value of an axis that a cell has, with the name of the axis if the value is a number.
 */
static void write_value(const sc_study_view *view, int cell, int axis, char *text, size_t size)
{
    const sc_design *design = &view->m->design;
    const char *value = design->axes[axis].values[sc_design_index(design, cell, axis)];

    if (is_number(value))
        snprintf(text, size, "%s %s", design->axes[axis].name, value);
    else
        snprintf(text, size, "%s", value);
}

void sc_study_name(const sc_study_view *view, int cell, int without, const char *alone,
                   char text[SC_CELL_NAME_BYTES])
{
    const sc_design *design = &view->m->design;
    size_t used = 0;

    snprintf(text, SC_CELL_NAME_BYTES, "%s", alone);
    for (int i = 0; i < design->axis_count && used + 3 < SC_CELL_NAME_BYTES; i++) {
        if (i == without || design->axes[i].value_count == 1)
            continue;
        if (used)
            used += (size_t)snprintf(text + used, SC_CELL_NAME_BYTES - used, ", ");
        write_value(view, cell, i, text + used, SC_CELL_NAME_BYTES - used);
        used += strlen(text + used);
    }
}

bool sc_study_has_paper(const sc_study_view *view)
{
    const sc_design_axis *axis = view->series < 0 ? NULL : &view->m->design.axes[view->series];
    bool has_plain = false, has_accelerated = false;

    for (int i = 0; axis && !strcmp(axis->name, "render.skip") && i < axis->value_count; i++) {
        has_plain = has_plain || !strcmp(axis->values[i], "none");
        has_accelerated = has_accelerated || !strcmp(axis->values[i], "interior");
    }
    return has_plain && has_accelerated;
}
