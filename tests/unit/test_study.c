/* SPDX-License-Identifier: BSD-3-Clause */
/* What a run was limited by, told from its records. */
#include "check.h"

#include "segcast/study.h"

enum { RANKS = 4 };

/* Four ranks that drew for the same time and hardly waited. */
static void balanced(sc_rank_record *ranks, sc_run_record *run)
{
    *run =
        (sc_run_record){.ranks = RANKS, .rank_records = ranks, .wall_s = 101, .farm_wall_s = 100};
    for (int i = 0; i < RANKS; i++) {
        ranks[i] = (sc_rank_record){.farm_idle_s = 2};
        ranks[i].phases[SC_PHASE_RENDER].wall_s = 98;
    }
}

static void the_limit_is_where_the_time_went(void **state)
{
    sc_rank_record ranks[RANKS];
    sc_run_record run;

    (void)state;
    balanced(ranks, &run);
    assert_int_equal(sc_run_limit(&run), SC_LIMIT_DRAW);
    ranks[0].phases[SC_PHASE_PREPARE].wall_s = 120;
    assert_int_equal(sc_run_limit(&run), SC_LIMIT_PREPARE);

    balanced(ranks, &run);
    ranks[0].take_wall_s = 97;
    assert_int_equal(sc_run_limit(&run), SC_LIMIT_DRAW); /* busy, but nobody waits for it */
    for (int i = 0; i < RANKS; i++)
        ranks[i].farm_idle_s = 60;
    assert_int_equal(sc_run_limit(&run), SC_LIMIT_ENCODE);
    run.wrote_png = true;
    ranks[0].phases[SC_PHASE_WRITE].wall_s = 70;
    ranks[0].phases[SC_PHASE_ENCODE].wall_s = 27;
    assert_int_equal(sc_run_limit(&run), SC_LIMIT_WRITE);

    balanced(ranks, &run);
    for (int i = 0; i < RANKS; i++)
        ranks[i].farm_idle_s = 60;
    ranks[0].phases[SC_PHASE_GATHER].wall_s = 95;
    assert_int_equal(sc_run_limit(&run), SC_LIMIT_GATHER);

    balanced(ranks, &run);
    for (int i = 1; i < RANKS; i++) {
        ranks[i].farm_idle_s = 50;
        ranks[i].phases[SC_PHASE_RENDER].wall_s = 50;
    }
    assert_int_equal(sc_run_limit(&run), SC_LIMIT_BALANCE);
    assert_near(sc_run_imbalance(&run), 98 * 4 / (98 + 150.0) - 1, 1e-12);
}

/* Events beyond the room are counted, not written. */
static void a_trace_keeps_what_it_has_room_for(void **state)
{
    sc_trace *trace;

    (void)state;
    assert_ok(sc_trace_new(&quiet, 3, &trace));
    for (int k = 0; k < 5; k++)
        sc_trace_add(trace, SC_TRACE_DRAW, k, 10 + k, sc_wall_s(), sc_wall_s());
    assert_int_equal(sc_trace_count(trace), 3);
    assert_int_equal(sc_trace_dropped(trace), 2);
    assert_int_equal(sc_trace_events(trace)[2].frame, 12);
    sc_trace_free(trace);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_limit_is_where_the_time_went),
        cmocka_unit_test(a_trace_keeps_what_it_has_room_for),
    };

    return RUN(tests);
}
