/* SPDX-License-Identifier: BSD-3-Clause */
/* The order in which the cells of a study are measured. Repeats of a cell are spread over the whole
 * study, so that a machine that becomes slower or faster meanwhile changes all cells alike. */
#include "study/study.h"

sc_status sc_schedule_init(const sc_ctx *ctx, const sc_cell_info *cells, int cell_count,
                           uint64_t seed, int round, sc_schedule *out)
{
    *out =
        (sc_schedule){.cells = cells, .cell_count = cell_count, .seed = seed, .round = round - 1};
    out->at = cell_count;
    SC_PASS(SC_ZALLOC(ctx, (size_t)cell_count, &out->costs));
    SC_PASS(SC_ZALLOC(ctx, (size_t)cell_count, &out->order));
    SC_PASS(SC_ZALLOC(ctx, (size_t)cell_count, &out->counts));
    return SC_ZALLOC(ctx, (size_t)cell_count, &out->done);
}

void sc_schedule_clear(sc_schedule *schedule)
{
    sc_free(schedule->costs);
    sc_free(schedule->order);
    sc_free(schedule->counts);
    sc_free(schedule->done);
    *schedule = (sc_schedule){0};
}

bool sc_cells_share_volume(const sc_cell_info *a, const sc_cell_info *b)
{
    return a->volume_key == b->volume_key && a->ranks == b->ranks && a->threads == b->threads &&
           a->placement == b->placement;
}

/* Bring all cells into the order of the next round: random, and then each cell directly behind the
 * first one with its volume. */
static void begin_round(sc_schedule *s)
{
    int *order = s->order;
    int sorted = 0;

    s->round++;
    s->at = 0;
    sc_random_order(s->seed + (uint64_t)s->round, s->cell_count, order);
    while (sorted < s->cell_count) {
        const int first = order[sorted++];

        for (int i = sorted; i < s->cell_count; i++) {
            const int cell = order[i];

            if (!sc_cells_share_volume(&s->cells[first], &s->cells[cell]))
                continue;
            order[i] = order[sorted];
            order[sorted++] = cell;
        }
    }
}

int sc_schedule_next(sc_schedule *schedule)
{
    for (int looked = 0; looked < 2 * schedule->cell_count; looked++) {
        int cell;

        if (schedule->at == schedule->cell_count)
            begin_round(schedule);
        cell = schedule->order[schedule->at++];
        if (schedule->cells[cell].runs_here && !schedule->done[cell])
            return cell;
    }
    return -1;
}

double sc_schedule_estimate_s(const sc_schedule *schedule, int times)
{
    double sum_s = 0;

    for (int i = 0; i < schedule->cell_count; i++) {
        const int left = times - schedule->counts[i];
        double load_s = schedule->costs[i].load_s;

        if (!schedule->cells[i].runs_here || left <= 0 || schedule->done[i])
            continue;
        /* A volume is prepared once in each round, for the first of its cells. */
        for (int j = 0; j < i && load_s > 0; j++) {
            if (sc_cells_share_volume(&schedule->cells[i], &schedule->cells[j]) &&
                schedule->cells[j].runs_here)
                load_s = 0;
        }
        sum_s += left * (schedule->costs[i].measure_s + load_s);
    }
    return sum_s;
}
