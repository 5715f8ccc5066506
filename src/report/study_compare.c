/* SPDX-License-Identifier: BSD-3-Clause */
/* The page that compares studies in several directories, cell by cell of the same name. */
#include "study_view.h"

#include <math.h>

enum { CELLS_SHOWN = 150 };

/* The studies that are compared. */
typedef struct studies {
    const char *const *names; /* of their directories; borrowed */
    sc_study_view *views;     /* [count], owned */
    int count;
} studies;

static void clear_studies(studies *s)
{
    for (int i = 0; i < s->count; i++)
        sc_study_view_clear(&s->views[i]);
    sc_free(s->views);
}

/* @return the cell of a study that is named like the cell @p cell of the first one and was
 * measured, or -1. */
static int find_same(const studies *s, int study, int cell)
{
    const sc_study_view *view = &s->views[study];
    char wanted[SC_CELL_NAME_BYTES], name[SC_CELL_NAME_BYTES];

    sc_study_name(&s->views[0], cell, -1, "the only cell", wanted);
    for (int i = 0; i < view->count; i++) {
        sc_study_name(view, i, -1, "the only cell", name);
        if (sc_study_has(view, i) && !strcmp(name, wanted))
            return i;
    }
    return -1;
}

/* What one study says beside the first. */
typedef struct beside {
    int common;               /* cells of the same name that both have measured */
    int apart;                /* of them, those whose confidence intervals do not overlap */
    int other_pixels;         /* and those with other pixels */
    double log_sum, farthest; /* of the ratios of their times; the ratio farthest from 1 */
} beside;

/* @return the median of the first study's kind of time for a frame. */
static double time_s(const studies *s, int study, int cell)
{
    const sc_cell_result *r = &s->views[study].cells[cell];
    const bool wall = s->views[0].m->design.by_wall;

    return (wall ? r->wall_s.median : r->cpu_s.median) / r->typical.frames;
}

/* @return whether a measurement of @p cell has other pixels than @p pixels_hash. */
static bool has_other_pixels(const sc_measurements *m, int cell, uint64_t pixels_hash)
{
    for (size_t i = 0; i < m->count; i++) {
        if (m->items[i].cell == cell && m->items[i].pixels_hash != pixels_hash)
            return true;
    }
    return false;
}

static beside compare(const studies *s, int study)
{
    const bool wall = s->views[0].m->design.by_wall;
    beside b = {.farthest = 1};

    for (int i = 0; i < s->views[0].count; i++) {
        const int other = sc_study_has(&s->views[0], i) ? find_same(s, study, i) : -1;
        const sc_cell_result *x = &s->views[0].cells[i], *y;
        const sc_statistics *p, *q;
        double ratio;

        if (other < 0)
            continue;
        y = &s->views[study].cells[other];
        p = wall ? &x->wall_s : &x->cpu_s;
        q = wall ? &y->wall_s : &y->cpu_s;
        ratio = time_s(s, study, other) / time_s(s, 0, i);
        b.common++;
        b.log_sum += log(ratio);
        b.farthest = fabs(log(ratio)) > fabs(log(b.farthest)) ? ratio : b.farthest;
        b.apart += p->low / x->typical.frames > q->high / y->typical.frames ||
                   q->low / y->typical.frames > p->high / x->typical.frames;
        b.other_pixels += has_other_pixels(s->views[0].m, x->cell, x->typical.pixels_hash) ||
                          has_other_pixels(s->views[study].m, y->cell, x->typical.pixels_hash);
    }
    return b;
}

/* @return a study. */
static json_t *study_json(const studies *s, int study)
{
    const sc_measurements *m = s->views[study].m;
    const beside b = compare(s, study);

    return json_pack("{s:o, s:o, s:o, s:I, s:b, s:{s:i, s:i, s:i, s:o, s:o}}", "name",
                     sc_json_text(s->names[study]), "title", sc_json_text(m->design.title), "run",
                     m->run_count ? sc_study_run_json(&m->runs[m->run_count - 1]) : json_null(),
                     "count", (json_int_t)m->count, "complete", m->complete, "beside", "common",
                     b.common, "apart", b.apart, "other_pixels", b.other_pixels, "mean",
                     sc_json_number(exp(b.log_sum / b.common)), "farthest",
                     sc_json_number(b.farthest));
}

/* @return a cell of the first study with the time of a frame in each study, null where it was not
 * measured. */
static json_t *cell_json(const studies *s, int cell)
{
    char name[SC_CELL_NAME_BYTES];
    json_t *times = json_array();

    sc_study_name(&s->views[0], cell, -1, "the only cell", name);
    for (int i = 0; i < s->count; i++) {
        const int same = find_same(s, i, cell);

        times = sc_json_with(times, same < 0 ? json_null() : json_real(time_s(s, i, same)));
    }
    return json_pack("{s:o, s:o}", "name", sc_json_text(name), "times", times);
}

sc_status sc_report_compare_studies(const sc_ctx *ctx, const char *const *directories,
                                    const sc_measurements *measurements, int count, sc_text *out)
{
    SC_OWN(clear_studies) studies s = {.names = directories};
    json_auto_t *data = NULL, *list = json_array(), *cells = json_array();

    SC_PASS(SC_ZALLOC(ctx, (size_t)count, &s.views));
    for (; s.count < count; s.count++)
        SC_PASS(sc_study_view_open(ctx, &measurements[s.count], &s.views[s.count]));
    for (int i = 0; i < count; i++)
        list = sc_json_with(list, study_json(&s, i));
    for (int i = 0; i < s.views[0].count && json_array_size(cells) < CELLS_SHOWN; i++) {
        if (sc_study_has(&s.views[0], i))
            cells = sc_json_with(cells, cell_json(&s, i));
    }
    data = json_pack("{s:s, s:s, s:s, s:i, s:O, s:O}", "kind", "studies", "title",
                     "Comparison of studies", "unit", sc_study_unit(&s.views[0]), "cell_count",
                     s.views[0].measured, "studies", list, "cells", cells);
    return sc_json_page(ctx, data, out);
}
