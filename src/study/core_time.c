/* SPDX-License-Identifier: BSD-3-Clause */
/* Splits the time of cores by what it was spent on. */
#include "segcast/core_time.h"

const char *sc_cause_key(sc_cause cause)
{
    static const char *const keys[SC_CAUSE_COUNT] = {"draw_s",    "read_s", "prepare_s", "share_s",
                                                     "wait_s",    "idle_s", "gather_s",  "encode_s",
                                                     "threads_s", "other_s"};

    return keys[cause];
}

static double not_negative(double value)
{
    return value > 0 ? value : 0;
}

/* Fill in what is left of @p core_s of a rank: of the time in which it drew, @p drawing_s times its
 * cores, threads waited for what was neither drawing nor the rest of its work. @param c the causes
 * of this rank alone, those two zero. */
static void fill_rest(double core_s, double drawing_s, sc_core_time *c)
{
    double rest_s = core_s;
    const double waited_s = drawing_s - c->causes_s[SC_CAUSE_DRAW] - c->causes_s[SC_CAUSE_GATHER] -
                            c->causes_s[SC_CAUSE_ENCODE];

    for (int i = 0; i < SC_CAUSE_COUNT; i++)
        rest_s -= c->causes_s[i];
    rest_s = not_negative(rest_s);
    c->causes_s[SC_CAUSE_THREADS] =
        not_negative(waited_s) < rest_s ? not_negative(waited_s) : rest_s;
    c->causes_s[SC_CAUSE_OTHER] = rest_s - c->causes_s[SC_CAUSE_THREADS];
    c->core_s = core_s;
}

sc_core_time sc_run_core_time(const sc_run_record *run)
{
    sc_core_time sum = {0};

    for (int i = 0; i < run->ranks; i++) {
        const sc_rank_record *r = &run->rank_records[i];
        const sc_phase_time *p = r->phases;
        const double cores = r->threads;
        sc_core_time c = {0};

        c.causes_s[SC_CAUSE_DRAW] = p[SC_PHASE_RENDER].cpu_s;
        c.causes_s[SC_CAUSE_READ] = cores * p[SC_PHASE_READ].wall_s;
        c.causes_s[SC_CAUSE_PREPARE] = cores * p[SC_PHASE_PREPARE].wall_s;
        c.causes_s[SC_CAUSE_SHARE] = cores * p[SC_PHASE_SHARE].wall_s;
        c.causes_s[SC_CAUSE_WAIT] = cores * not_negative(p[SC_PHASE_IDLE].wall_s - r->farm_idle_s);
        c.causes_s[SC_CAUSE_IDLE] = cores * r->farm_idle_s;
        c.causes_s[SC_CAUSE_GATHER] = p[SC_PHASE_GATHER].cpu_s;
        c.causes_s[SC_CAUSE_ENCODE] = p[SC_PHASE_ENCODE].cpu_s + p[SC_PHASE_WRITE].cpu_s;
        fill_rest(cores * run->wall_s, cores * p[SC_PHASE_RENDER].wall_s, &c);
        sum.core_s += c.core_s;
        for (int j = 0; j < SC_CAUSE_COUNT; j++)
            sum.causes_s[j] += c.causes_s[j];
    }
    return sum;
}

sc_core_time sc_measurement_core_time(const sc_measurement *m, bool whole_job)
{
    const double cores = (double)m->ranks * m->threads;
    sc_core_time c = {0};

    c.causes_s[SC_CAUSE_DRAW] = m->draw.cpu_s;
    c.causes_s[SC_CAUSE_IDLE] = cores * m->idle_mean_s;
    if (whole_job) {
        c.causes_s[SC_CAUSE_READ] = cores * m->start.read_s;
        c.causes_s[SC_CAUSE_PREPARE] = cores * m->start.prepare_s;
        c.causes_s[SC_CAUSE_SHARE] = cores * m->start.share_s;
        c.causes_s[SC_CAUSE_ENCODE] = not_negative(m->cpu_s - m->draw.cpu_s - m->start.cpu_s);
    }
    fill_rest(cores * m->wall_s, cores * m->draw.mean_s, &c);
    return c;
}
