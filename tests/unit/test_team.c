/* SPDX-License-Identifier: BSD-3-Clause */
/* Teams: loops that several ranks do together, over arrays that all see; and what happens when one
 * rank has no memory. The ranks are threads here. */
#include "check.h"

#include "thread_team.h"

enum { ITEMS = 1013, LOOPS = 7 };

typedef struct counting {
    uint32_t *counts; /* [ITEMS], of the team */
    _Atomic int *calls;
} counting;

/* Count items [begin, end) once more; an sc_range_fn on a counting. */
static void count_items(void *user, size_t begin, size_t end, int thread)
{
    const counting *c = user;

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

    SC_PASS(sc_team_alloc(ctx, team, 3, 5, &first));
    SC_PASS(sc_team_alloc(ctx, team, ITEMS, sizeof *c.counts, &block));
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
    return SC_OK;
}

/* Count in loops, and then let rank 0 alone have an error; a team_work_fn on the number of calls of
 * each rank. */
static sc_status count(const sc_ctx *ctx, sc_comm *comm, sc_team *team, void *user)
{
    _Atomic int *calls = user; /* how often each rank has called the body of the loop */
    const int rank = sc_comm_rank(comm);

    assert_int_equal(sc_team_ranks(team), sc_comm_size(comm));
    SC_PASS(count_in_loops(ctx, team, &calls[rank]));
    assert_int_equal(sc_team_agree(team, rank ? SC_OK : SC_ERR_DATA), SC_ERR_DATA);
    return SC_OK;
}

TEST(every_item_is_done_once_by_any_ranks_and_threads)
{
    for (int ranks = 1; ranks <= 4; ranks++) {
        for (int threads = 1; threads <= 3; threads++) {
            _Atomic int calls[THREAD_RANKS_MAX] = {0};
            thread_team team = {.work = count, .user = calls, .threads = threads};

            assert_ok(run_team(&team, ranks));
            for (int rank = 0; rank < ranks; rank++)
                assert_true(calls[rank] > 0);
        }
    }
}

TEST(a_rank_without_memory_ends_all)
{
    for (long budget = 0; budget < 5; budget++) {
        _Atomic int calls[THREAD_RANKS_MAX] = {0};
        thread_team team = {.work = count,
                            .user = calls,
                            .threads = 1,
                            .scarce = true,
                            .poor_rank = 1,
                            .budget = budget};

        assert_int_equal(run_team(&team, 3), budget < 4 ? SC_ERR_MEMORY : SC_OK);
    }
}

TEST(a_team_needs_room_that_ranks_share)
{
    _Atomic int calls[THREAD_RANKS_MAX] = {0};
    thread_team team = {.work = count, .user = calls, .threads = 1, .separate = true};

    assert_int_equal(run_team(&team, 2), SC_ERR_MEMORY);
    assert_ok(run_team(&team, 1)); /* a rank alone needs none */
}

TEST(a_rank_without_a_communicator_is_a_team)
{
    _Atomic int calls = 0;
    sc_team *team;

    assert_ok(sc_team_open(&quiet, NULL, 2, NULL, &team));
    assert_int_equal(sc_team_ranks(team), 1);
    assert_ok(count_in_loops(&quiet, team, &calls));
    assert_true(calls >= LOOPS);
    sc_team_close(team);
    sc_team_close(NULL);
}

RUN_TESTS(NULL, NULL)
