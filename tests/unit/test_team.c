/* SPDX-License-Identifier: BSD-3-Clause */
/* Teams: loops that several ranks do together, over arrays that all see; and what happens when one
 * rank has no memory. The ranks are threads here. */
#include "check.h"

#include "segcast/team.h"
#include "thread_comm.h"

#include <unistd.h>

enum { ITEMS = 1013, LOOPS = 7 };

typedef struct scenario {
    int threads;
    int poor_rank; /* has memory for @p budget allocations only; -1: none */
    long budget;
    sc_status outcomes[THREAD_RANKS_MAX];
    _Atomic int calls[THREAD_RANKS_MAX]; /* how often each rank has called the body of the loop */
} scenario;

typedef struct counting {
    uint32_t *counts; /* [ITEMS], of the team */
    _Atomic int *calls;
} counting;

/* Count items [begin, end) once more; an sc_range_fn on a counting. */
static void count_items(void *user, size_t begin, size_t end, int thread)
{
    const counting *c = user;

    (void)thread;
    atomic_fetch_add(c->calls, 1);
    for (size_t i = begin; i < end; i++)
        c->counts[i]++;
    sc_sleep_s(20e-6); /* so that others get some, too */
}

/* Do LOOPS loops over one array, and see after each that every item was done once. */
static sc_status count_in_loops(const sc_ctx *ctx, sc_team *team, _Atomic int *calls)
{
    counting c = {.calls = calls};
    void *first, *block;
    sc_status status;

    SC_TRY(sc_team_alloc(ctx, team, 3, 5, &first));
    SC_TRY(sc_team_alloc(ctx, team, ITEMS, sizeof *c.counts, &block));
    assert_ptr_not_equal(first, block);
    c.counts = block;
    for (uint32_t loop = 0; loop < LOOPS; loop++) {
        sc_team_for(team, ITEMS, 1 + 40 * loop, count_items, &c);
        for (size_t i = 0; i < ITEMS; i++)
            assert_int_equal(c.counts[i], loop + 1);
        assert_ok(sc_team_agree(team, SC_OK)); /* none counts on before all have looked */
    }
    sc_team_for(team, 0, 1, count_items, &c); /* of no items: the body is not called */
    sc_team_free(team, first);
    assert_true(sc_team_bytes(team) >= ITEMS * sizeof *c.counts);
out:
    return status;
}

static void run_rank(sc_comm *comm, void *user)
{
    scenario *s = user;
    const int rank = sc_comm_rank(comm);
    long budget = rank == s->poor_rank ? s->budget : 1000000;
    const sc_ctx ctx = {.alloc_budget = &budget};
    sc_team *team = NULL;
    sc_status status;

    SC_TRY(sc_team_open(&ctx, comm, s->threads, NULL, &team));
    assert_int_equal(sc_team_ranks(team), sc_comm_size(comm));
    SC_TRY(count_in_loops(&ctx, team, &s->calls[rank]));
    assert_int_equal(sc_team_agree(team, rank ? SC_OK : SC_ERR_DATA), SC_ERR_DATA);
out:
    sc_team_close(team);
    s->outcomes[rank] = status;
}

/* @return the return code, which must be the same on all ranks. */
static sc_status run(scenario *s, int ranks, bool shares)
{
    alarm(120); /* ends a team that hangs, which makes the test fail */
    run_ranks(ranks, shares, run_rank, s);
    alarm(0);
    for (int rank = 1; rank < ranks; rank++)
        assert_int_equal(s->outcomes[rank], s->outcomes[0]);
    return s->outcomes[0];
}

static void every_item_is_done_once_by_any_ranks_and_threads(void **state)
{
    (void)state;
    for (int ranks = 1; ranks <= 4; ranks++) {
        for (int threads = 1; threads <= 3; threads++) {
            scenario s = {.threads = threads, .poor_rank = -1};

            assert_ok(run(&s, ranks, true));
            for (int rank = 0; rank < ranks; rank++)
                assert_true(s.calls[rank] > 0);
        }
    }
}

static void a_rank_without_memory_ends_all(void **state)
{
    (void)state;
    for (long budget = 0; budget < 5; budget++) {
        scenario s = {.threads = 1, .poor_rank = 1, .budget = budget};
        const sc_status outcome = run(&s, 3, true);

        assert_int_equal(outcome, budget < 4 ? SC_ERR_MEMORY : SC_OK);
    }
}

static void a_team_needs_room_that_ranks_share(void **state)
{
    scenario s = {.threads = 1, .poor_rank = -1};

    (void)state;
    assert_int_equal(run(&s, 2, false), SC_ERR_MEMORY);
    assert_ok(run(&s, 1, false)); /* a rank alone needs none */
}

static void a_rank_without_a_communicator_is_a_team(void **state)
{
    _Atomic int calls = 0;
    sc_team *team;

    (void)state;
    assert_ok(sc_team_open(&quiet, NULL, 2, NULL, &team));
    assert_int_equal(sc_team_ranks(team), 1);
    assert_ok(count_in_loops(&quiet, team, &calls));
    assert_true(calls >= LOOPS);
    sc_team_close(team);
    sc_team_close(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_is_done_once_by_any_ranks_and_threads),
        cmocka_unit_test(a_rank_without_memory_ends_all),
        cmocka_unit_test(a_team_needs_room_that_ranks_share),
        cmocka_unit_test(a_rank_without_a_communicator_is_a_team),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
