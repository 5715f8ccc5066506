/* SPDX-License-Identifier: BSD-3-Clause */
/* A team whose ranks are threads of one process, one of which may run out of memory. */
#ifndef SC_TEST_THREAD_TEAM_H
#define SC_TEST_THREAD_TEAM_H

#include "segcast/team.h"
#include "thread_comm.h"

#include <unistd.h>

/* What each rank does; @p user is shared by all. @return its outcome. */
typedef sc_status team_work_fn(const sc_ctx *ctx, sc_comm *comm, sc_team *team, void *user);

typedef struct thread_team {
    team_work_fn *work;
    void *user;
    int threads;   /* of each rank */
    bool scarce;   /* poor_rank has memory for @p budget allocations only */
    int poor_rank; /* read if scarce, as budget */
    long budget;
    bool separate; /* the ranks can share no memory */
    sc_status outcomes[THREAD_RANKS_MAX];
} thread_team;

static void thread_team_rank(sc_comm *comm, void *user)
{
    thread_team *t = user;
    const int rank = sc_comm_rank(comm);
    long budget = t->scarce && rank == t->poor_rank ? t->budget : 1000000;
    const sc_ctx ctx = {.alloc_budget = &budget};
    sc_team *team = NULL;
    sc_status status;

    SC_TRY(sc_team_open(&ctx, comm, t->threads, NULL, &team));
    status = t->work(&ctx, comm, team, t->user);
out:
    sc_team_close(team);
    t->outcomes[rank] = status;
}

/* Let all ranks do the work. @return the outcome, which must be the same on all ranks. A team that
 * hangs ends the test. */
static sc_status run_team(thread_team *t, int ranks)
{
    alarm(240);
    run_ranks(ranks, !t->separate, thread_team_rank, t);
    alarm(0);
    for (int rank = 1; rank < ranks; rank++)
        assert_int_equal(t->outcomes[rank], t->outcomes[0]);
    return t->outcomes[0];
}

/* Let each allocation fail once on each of two ranks, until none does: all ranks end, without
 * memory or well. @param clear called with t->user after each try, unless NULL. */
static inline void fail_every_allocation(thread_team *t, void (*clear)(void *user))
{
    sc_status outcome = SC_ERR_MEMORY;
    long budget = 0;

    t->scarce = true;
    for (; outcome != SC_OK; budget++) {
        t->poor_rank = (int)(budget % 2);
        t->budget = budget / 2;
        outcome = run_team(t, 2);
        assert_true(outcome == SC_OK || outcome == SC_ERR_MEMORY);
        if (clear)
            clear(t->user);
    }
    assert_true(budget > 40);
}

#endif
