/* SPDX-License-Identifier: BSD-3-Clause */
/* What a study varies, and the lists of what it has measured. */
#include "internal.h"

#define ROW(kind, key, member) SC_JSON_ROW_AS(kind, key, sc_measurement, member)

const sc_json_row sc_measurement_rows[] = {
    ROW(INT, "cell", cell),
    ROW(INT, "round", round),
    ROW(INT, "passes", passes),
    ROW(INT, "frames", frames),
    ROW(INT, "ranks", ranks),
    ROW(INT, "nodes", nodes),
    ROW(INT, "threads", threads),
    ROW(TIME, "begin_unix_s", begin_unix_s),
    ROW(SECONDS, "wall_s", wall_s),
    ROW(SECONDS, "cpu_s", cpu_s),
    ROW(SECONDS, "draw_cpu_s", draw.cpu_s),
    ROW(SECONDS, "draw_most_s", draw.most_s),
    ROW(SECONDS, "draw_mean_s", draw.mean_s),
    ROW(SECONDS, "idle_mean_s", idle_mean_s),
    ROW(SECONDS, "gather_mean_s", gather_mean_s),
    ROW(SECONDS, "accept_s", accept_s),
    ROW(SECONDS, "read_s", start.read_s),
    ROW(SECONDS, "prepare_s", start.prepare_s),
    ROW(SECONDS, "share_s", start.share_s),
    ROW(SECONDS, "prepare_cpu_s", start.cpu_s),
    ROW(SECONDS, "derive_s", start.derive_s),
    ROW(SECONDS, "derive_cpu_s", start.derive_cpu_s),
    ROW(COUNT, "rays", work.rays),
    ROW(COUNT, "samples", work.samples),
    ROW(COUNT, "contributions", work.contributions),
    ROW(COUNT, "peak_rss_most_bytes", memory.peak_most_bytes),
    ROW(COUNT, "peak_rss_sum_bytes", memory.peak_sum_bytes),
    ROW(COUNT, "prepared_bytes", memory.prepared_bytes),
    ROW(REAL, "energy_j", energy_j),
    ROW(HASH, "pixels_hash", pixels_hash),
    {0}};

#define RUN(kind, member) SC_JSON_ROW(kind, sc_study_run, member)

const sc_json_row sc_study_run_rows[] = {
    RUN(INT, ranks),   RUN(INT, nodes),      RUN(INT, cores),      RUN(TEXT, begin),
    RUN(TEXT, host),   RUN(TEXT, processor), RUN(TEXT, mpi),       RUN(TEXT, version),
    RUN(TEXT, commit), RUN(TEXT, kernel),    RUN(TEXT, batch_job), {0}};

void sc_design_clear(sc_design *design)
{
    for (int i = 0; i < design->axis_count; i++) {
        sc_design_axis *axis = &design->axes[i];

        for (int j = 0; j < axis->value_count; j++)
            sc_free(axis->values[j]);
        sc_free(axis->values);
        sc_free(axis->name);
    }
    sc_free(design->axes);
    sc_free(design->title);
    *design = (sc_design){0};
}

int sc_design_cells(const sc_design *design)
{
    int cells = 1;

    for (int i = 0; i < design->axis_count; i++)
        cells *= design->axes[i].value_count;
    return cells;
}

int sc_design_index(const sc_design *design, int cell, int axis)
{
    for (int i = design->axis_count - 1; i > axis; i--)
        cell /= design->axes[i].value_count;
    return cell % design->axes[axis].value_count;
}

/* Does the axis vary the machine, not the job? */
static bool is_of_machine(const sc_design_axis *axis)
{
    return !strcmp(axis->name, "ranks") || !strcmp(axis->name, "threads") ||
           !strcmp(axis->name, "placement");
}

bool sc_design_is_scaling(const sc_design *design, int cell_a, int cell_b)
{
    for (int i = 0; i < design->axis_count; i++) {
        if (!is_of_machine(&design->axes[i]) &&
            sc_design_index(design, cell_a, i) != sc_design_index(design, cell_b, i))
            return false;
    }
    return true;
}

/* ---- lists ---- */

void sc_measurements_clear(sc_measurements *measurements)
{
    sc_design_clear(&measurements->design);
    for (size_t i = 0; i < measurements->skipped_count; i++)
        sc_free(measurements->skipped[i].reason);
    for (size_t i = 0; i < measurements->run_count; i++)
        sc_free(measurements->runs[i].made_from);
    sc_free(measurements->items);
    sc_free(measurements->runs);
    sc_free(measurements->skipped);
    *measurements = (sc_measurements){0};
}

/* Remove the reason why @p cell was not measured, if there is one. */
static void drop_reason(sc_measurements *from, int cell)
{
    size_t kept = 0;

    for (size_t i = 0; i < from->skipped_count; i++) {
        if (from->skipped[i].cell == cell)
            sc_free(from->skipped[i].reason);
        else
            from->skipped[kept++] = from->skipped[i];
    }
    from->skipped_count = kept;
}

sc_status sc_measurements_append(const sc_ctx *ctx, sc_measurements *to, const sc_measurement *item)
{
    SC_PASS(SC_GROW(ctx, to->count, &to->capacity, &to->items));
    to->items[to->count++] = *item;
    drop_reason(to, item->cell);
    return SC_OK;
}

sc_status sc_measurements_skip(const sc_ctx *ctx, sc_measurements *to, int cell, const char *reason)
{
    char *text;

    for (size_t i = 0; i < to->count; i++) {
        if (to->items[i].cell == cell)
            return SC_OK;
    }
    SC_PASS(SC_GROW(ctx, to->skipped_count, &to->skipped_capacity, &to->skipped));
    SC_PASS(sc_text_copy(ctx, reason, &text));
    drop_reason(to, cell);
    to->skipped[to->skipped_count++] = (sc_skipped_cell){cell, text};
    return SC_OK;
}

sc_status sc_measurements_add_run(const sc_ctx *ctx, sc_measurements *to, const sc_study_run *run)
{
    SC_PASS(SC_GROW(ctx, to->run_count, &to->run_capacity, &to->runs));
    to->runs[to->run_count] = *run;
    to->runs[to->run_count++].first = to->count;
    return SC_OK;
}

/* Fill in a run of a history from that of a study. @param measured [count] in it: the last of them
 * tells how long it went on. */
static sc_status fill_entry(const sc_ctx *ctx, const sc_study_run *run,
                            const sc_measurement *measured, size_t count, sc_run_entry *out)
{
    const sc_measurement *last = count ? &measured[count - 1] : NULL;
    time_t begin;

    *out = (sc_run_entry){.id = sc_hash_bytes(run->begin, strlen(run->begin), run->first),
                          .frames = (int)count,
                          .ranks = run->ranks,
                          .threads = run->cores,
                          .nodes = run->nodes};
    out->ended = last && sc_parse_time(run->begin, &begin);
    if (out->ended)
        out->wall_s = (double)(last->begin_unix_s - begin) + last->wall_s * last->passes;
    snprintf(out->begin, sizeof out->begin, "%s", run->begin);
    snprintf(out->processor, sizeof out->processor, "%s", run->processor);
    snprintf(out->kernel, sizeof out->kernel, "%s", run->kernel);
    snprintf(out->mpi, sizeof out->mpi, "%s", run->mpi);
    snprintf(out->commit, sizeof out->commit, "%s", run->commit);
    return run->made_from ? sc_text_copy(ctx, run->made_from, &out->made_from) : SC_OK;
}

sc_status sc_measurements_history(const sc_ctx *ctx, const sc_measurements *from, sc_history *out)
{
    SC_OWN(sc_history_clear) sc_history history = {0};

    SC_PASS(sc_history_allocate(ctx, from->run_count, 0, &history));
    for (size_t i = 0; i < from->run_count; i++) {
        const sc_study_run *run = &from->runs[i];
        const size_t end = i + 1 < from->run_count ? run[1].first : from->count;

        SC_PASS(fill_entry(ctx, run, from->items + run->first, end - run->first,
                           &history.runs[history.run_count++]));
    }
    SC_HAND_OVER(history, out);
    return SC_OK;
}
