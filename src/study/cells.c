/* SPDX-License-Identifier: BSD-3-Clause */
/* What the measurements of a study say of its cells. */
#include "segcast/core_time.h"
#include "segcast/measurements.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>

/* ---- statistics ---- */

/* Collect the wall times and CPU times of a cell. @return how many there are. */
static size_t times_of(const sc_measurements *m, int cell, double *wall_s, double *cpu_s)
{
    size_t count = 0;

    for (size_t i = 0; i < m->count; i++) {
        if (m->items[i].cell != cell)
            continue;
        wall_s[count] = m->items[i].wall_s;
        cpu_s[count++] = m->items[i].cpu_s;
    }
    return count;
}

/* @return the measurement of the cell whose CPU time is nearest to @p median_s. */
static sc_measurement typical_of(const sc_measurements *m, int cell, double median_s)
{
    sc_measurement best = {0};
    double distance = INFINITY;

    for (size_t i = 0; i < m->count; i++) {
        if (m->items[i].cell == cell && fabs(m->items[i].cpu_s - median_s) < distance) {
            distance = fabs(m->items[i].cpu_s - median_s);
            best = m->items[i];
        }
    }
    return best;
}

static double ratio(double a, double b)
{
    return b > 0 ? a / b : 0;
}

/* Fill in what follows from the cell alone. @param times room for two times of each measurement. */
static sc_status describe_cell(const sc_ctx *ctx, const sc_measurements *m, double *times,
                               sc_cell_result *r)
{
    double *cpu_s = times + m->count;
    const size_t count = times_of(m, r->cell, times, cpu_s);
    const sc_measurement *t = &r->typical;

    for (size_t i = 0; i < m->skipped_count; i++) {
        if (m->skipped[i].cell == r->cell)
            r->skipped = m->skipped[i].reason;
    }
    SC_PASS(sc_statistics_of(ctx, times, count, &r->wall_s));
    SC_PASS(sc_statistics_of(ctx, cpu_s, count, &r->cpu_s));
    r->typical = typical_of(m, r->cell, r->cpu_s.median);
    r->frames_per_s = ratio(t->frames, r->wall_s.median);
    r->mrays_per_cpu_s = ratio((double)t->work.rays / 1e6, r->cpu_s.median);
    r->samples_per_ray = ratio((double)t->work.samples, (double)t->work.rays);
    r->imbalance = t->draw.mean_s > 0 ? t->draw.most_s / t->draw.mean_s - 1 : 0;
    r->workers = (double)t->ranks * t->threads;
    return SC_OK;
}

/* @return the rays of a pass per second of @p time. */
static double rays_per(const sc_cell_result *r, const sc_statistics *time)
{
    return ratio((double)r->typical.work.rays, time->median);
}

/* @return the cell with the fewest workers among those that have a result and differ from @p r at
 * most in the machine; @p r itself if there is none. */
static int base_of(const sc_design *design, const sc_cell_result *results, const sc_cell_result *r)
{
    int base = r->cell;

    for (int i = 0; i < sc_design_cells(design); i++) {
        if (results[i].cpu_s.count > 0 && sc_design_is_scaling(design, i, r->cell) &&
            (results[base].cpu_s.count == 0 || results[i].workers < results[base].workers))
            base = i;
    }
    return base;
}

sc_status sc_cell_results(const sc_ctx *ctx, const sc_measurements *measurements,
                          sc_cell_result **out)
{
    const sc_design *design = &measurements->design;
    const int cells = sc_design_cells(design);
    SC_OWN(sc_free_at) void *times = NULL;
    SC_OWN(sc_free_at) sc_cell_result *results = NULL;

    SC_PASS(sc_alloc(ctx, measurements->count + 1, 2 * sizeof(double), &times));
    SC_PASS(SC_ZALLOC(ctx, (size_t)cells, &results));
    for (int i = 0; i < cells; i++) {
        results[i].cell = i;
        SC_PASS(describe_cell(ctx, measurements, times, &results[i]));
    }
    for (int i = 0; i < cells; i++) {
        sc_cell_result *r = &results[i], *base;

        r->base = base_of(design, results, r);
        base = &results[r->base];
        if (r->cpu_s.count == 0 || base->cpu_s.count == 0)
            continue;
        r->speedup = ratio(rays_per(r, &r->wall_s), rays_per(base, &base->wall_s));
        r->efficiency = r->speedup * ratio(base->workers, r->workers);
        r->serial_share = r->speedup > 0 && r->workers > base->workers
                              ? sc_karp_flatt(r->speedup, r->workers / base->workers)
                              : 0;
        r->cost = ratio(rays_per(base, &base->cpu_s), rays_per(r, &r->cpu_s));
    }
    SC_HAND_OVER(results, out);
    return SC_OK;
}

int sc_measurements_mismatch(const sc_measurements *measurements, size_t from,
                             const uint64_t *pictures, int *other)
{
    const sc_measurement *items = measurements->items;

    for (size_t i = from; i < measurements->count; i++) {
        size_t j = 0;

        while (j < i && pictures[items[j].cell] != pictures[items[i].cell])
            j++;
        if (items[j].pixels_hash != items[i].pixels_hash) {
            *other = items[j].cell;
            return items[i].cell;
        }
    }
    return -1;
}

/* ---- tables ---- */

static sc_status add_statistics(const sc_ctx *ctx, sc_text *text, const sc_statistics *s)
{
    return sc_text_add(ctx, text, ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", s->median, s->low, s->high,
                       s->least, s->quartile_1, s->quartile_3, s->most);
}

/* The columns that follow the axes. */
static const char columns[] =
    "state,measurements,frames,ranks,threads,nodes,cpu_s_median,cpu_s_low,cpu_s_high,cpu_s_least,"
    "cpu_s_quartile_1,cpu_s_quartile_3,cpu_s_most,wall_s_median,wall_s_low,wall_s_high,wall_s_"
    "least,wall_s_quartile_1,wall_s_quartile_3,wall_s_most,frames_per_s,mrays_per_cpu_s,samples_"
    "per_ray,imbalance,speedup,efficiency,serial_share,cost,draw_cpu_s,idle_mean_s,gather_mean_s,"
    "accept_s,read_s,prepare_s,share_s,prepare_cpu_s,derive_s,derive_cpu_s,prepared_bytes,peak_rss_"
    "most_bytes,peak_rss_sum_bytes,energy_j,pixels_hash,core_s";

/* Append the row of a cell. */
static sc_status add_cell(const sc_ctx *ctx, const sc_design *design, const sc_cell_result *r,
                          sc_text *text)
{
    const sc_measurement *t = &r->typical;
    const sc_core_time cores = sc_measurement_core_time(t, design->whole_jobs);

    for (int i = 0; i < design->axis_count; i++) {
        SC_PASS(sc_text_add_field(
            ctx, text, design->axes[i].values[sc_design_index(design, r->cell, i)], NULL));
        SC_PASS(sc_text_add(ctx, text, ","));
    }
    SC_PASS(sc_text_add_field(ctx, text,
                              r->skipped            ? r->skipped
                              : r->cpu_s.count == 0 ? "not measured yet"
                                                    : "measured",
                              NULL));
    SC_PASS(sc_text_add(ctx, text, ",%zu,%d,%d,%d,%d", r->cpu_s.count, t->frames, t->ranks,
                        t->threads, t->nodes));
    SC_PASS(add_statistics(ctx, text, &r->cpu_s));
    SC_PASS(add_statistics(ctx, text, &r->wall_s));
    SC_PASS(sc_text_add(ctx, text, ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", r->frames_per_s,
                        r->mrays_per_cpu_s, r->samples_per_ray, r->imbalance, r->speedup,
                        r->efficiency, r->serial_share, r->cost));
    SC_PASS(sc_text_add(ctx, text, ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g",
                        t->draw.cpu_s, t->idle_mean_s, t->gather_mean_s, t->accept_s,
                        t->start.read_s, t->start.prepare_s, t->start.share_s, t->start.cpu_s,
                        t->start.derive_s, t->start.derive_cpu_s));
    SC_PASS(sc_text_add(ctx, text, ",%llu,%llu,%llu,%.9g,%016llx,%.9g",
                        (unsigned long long)t->memory.prepared_bytes,
                        (unsigned long long)t->memory.peak_most_bytes,
                        (unsigned long long)t->memory.peak_sum_bytes, t->energy_j,
                        (unsigned long long)t->pixels_hash, cores.core_s));
    for (int i = 0; i < SC_CAUSE_COUNT; i++)
        SC_PASS(sc_text_add(ctx, text, ",%.9g", cores.causes_s[i]));
    return sc_text_add(ctx, text, "\r\n");
}

sc_status sc_cells_write_csv(const sc_ctx *ctx, const sc_measurements *measurements,
                             const sc_cell_result *results, const char *path)
{
    const sc_design *design = &measurements->design;
    SC_OWN(sc_text_clear) sc_text text = {0};

    for (int i = 0; i < design->axis_count; i++) {
        SC_PASS(sc_text_add_field(ctx, &text, design->axes[i].name, NULL));
        SC_PASS(sc_text_add(ctx, &text, ","));
    }
    SC_PASS(sc_text_add(ctx, &text, "%s", columns));
    for (int i = 0; i < SC_CAUSE_COUNT; i++)
        SC_PASS(sc_text_add(ctx, &text, ",core_%s", sc_cause_key(i)));
    SC_PASS(sc_text_add(ctx, &text, "\r\n"));
    for (int i = 0; i < sc_design_cells(design); i++)
        SC_PASS(add_cell(ctx, design, &results[i], &text));
    return sc_file_write(ctx, path, text.data, text.length_bytes);
}

/* ---- Extra-P ---- */

/* Read the value of an axis as a number. @return false if it is none. */
static bool number_of(const char *value, double *out)
{
    char *end;

    *out = strtod(value, &end);
    return end != value && !*end && isfinite(*out);
}

/* Are all values of the axis numbers? */
static bool is_numeric(const sc_design_axis *axis)
{
    double unused;

    for (int i = 0; i < axis->value_count; i++) {
        if (!number_of(axis->values[i], &unused))
            return false;
    }
    return true;
}

/* Make the parameters of a measurement, and name what the other axes have as its call path.
 * @param path an empty text, the caller's. @return NULL when out of memory. */
static json_t *parameters_of(const sc_ctx *ctx, const sc_design *design, int cell, sc_text *path)
{
    json_t *params = json_object();

    if (sc_text_add(ctx, path, "study") != SC_OK)
        goto failed;
    for (int i = 0; i < design->axis_count && params; i++) {
        const sc_design_axis *axis = &design->axes[i];
        const char *value = axis->values[sc_design_index(design, cell, i)];
        double number = 0;

        if (is_numeric(axis) && number_of(value, &number)) {
            if (json_object_set_new(params, axis->name, json_real(number)))
                goto failed;
        } else if (sc_text_add(ctx, path, "->%s=%s", axis->name, value) != SC_OK) {
            goto failed;
        }
    }
    return params;
failed:
    json_decref(params);
    return NULL;
}

/* Append the two lines of a measurement. */
static sc_status add_extrap(const sc_ctx *ctx, const sc_design *design, const sc_measurement *item,
                            sc_text *text)
{
    const struct {
        const char *name;
        double value;
    } metrics[] = {{"wall_s", item->wall_s}, {"cpu_s", item->cpu_s}};
    SC_OWN(sc_text_clear) sc_text path = {0};
    json_t *params = parameters_of(ctx, design, item->cell, &path);
    sc_status status = SC_OK;

    for (size_t i = 0; i < SC_COUNT_OF(metrics) && status == SC_OK; i++) {
        status = sc_json_add_text(ctx,
                                  params ? json_pack("{s:O, s:s, s:s, s:f}", "params", params,
                                                     "callpath", path.data, "metric",
                                                     metrics[i].name, "value", metrics[i].value)
                                         : NULL,
                                  JSON_COMPACT | JSON_REAL_PRECISION(9), "extrap.jsonl", text);
    }
    json_decref(params);
    return status;
}

sc_status sc_cells_write_extrap(const sc_ctx *ctx, const sc_measurements *measurements,
                                const char *path)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    for (size_t i = 0; i < measurements->count; i++)
        SC_PASS(add_extrap(ctx, &measurements->design, &measurements->items[i], &text));
    return sc_file_write(ctx, path, text.data ? text.data : "", text.length_bytes);
}
