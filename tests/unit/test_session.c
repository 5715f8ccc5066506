/* SPDX-License-Identifier: BSD-3-Clause */
/* What a rank other than 0 does with the job that rank 0 sends. */
#include "check.h"
#include "thread_comm.h"

#include "app.h"

#include <stdio.h>
#include <unistd.h>

enum { RANKS = 3 };

typedef struct scenario {
    int poor_rank; /* its allocations fail after the first `budget` */
    long budget;
    sc_status outcomes[RANKS];
    char *received[RANKS];
} scenario;

static void send_array(sc_comm *comm, void *user)
{
    scenario *s = user;
    const int rank = sc_comm_rank(comm);
    long budget = rank == s->poor_rank ? s->budget : 1000;
    sc_ctx ctx = {.alloc_budget = &budget};
    sc_app app = {.ctx = &ctx, .comm = comm};
    static char stale[] = "rank 0's"; /* an address that means nothing to the other ranks */
    void *array = stale;

    if (rank == 0) {
        assert_ok(sc_alloc(&quiet, 6, 1, &array));
        memcpy(array, "hello", 6);
    }
    s->outcomes[rank] = sc_broadcast_array(&app, &array, 6, 1);
    s->received[rank] = array;
}

static void an_array_reaches_all_ranks(void **state)
{
    scenario s = {.poor_rank = -1};

    (void)state;
    run_ranks(RANKS, false, send_array, &s);
    for (int rank = 0; rank < RANKS; rank++) {
        assert_ok(s.outcomes[rank]);
        assert_string_equal(s.received[rank], "hello");
        sc_free(s.received[rank]);
    }
}

/* Nobody may be left with rank 0's address, which would be freed. */
static void an_array_that_one_rank_has_no_memory_for_is_on_rank_0_alone(void **state)
{
    scenario s = {.poor_rank = 1};

    (void)state;
    run_ranks(RANKS, false, send_array, &s);
    for (int rank = 0; rank < RANKS; rank++)
        assert_int_equal(s.outcomes[rank], SC_ERR_MEMORY);
    assert_string_equal(s.received[0], "hello");
    assert_null(s.received[1]);
    assert_null(s.received[2]);
    sc_free(s.received[0]);
}

static void load_job(sc_comm *comm, void *user)
{
    scenario *s = user;
    const int rank = sc_comm_rank(comm);
    long budget = rank == s->poor_rank ? s->budget : 100000;
    sc_ctx ctx = {.alloc_budget = &budget};
    sc_app app = {.ctx = &ctx, .comm = comm, .threads = 1};
    sc_session session;

    s->outcomes[rank] = sc_session_job(&app, "session.yaml", &session);
    sc_session_clear(&session); /* what is freed must be this rank's own */
}

static void a_job_that_one_rank_has_no_memory_for_is_cleared_on_all(void **state)
{
    FILE *file = fopen("session.yaml", "w");

    (void)state;
    fputs("volume: phantom\ntissues:\n  \"*\": {opacity: 0.6}\nanimation:\n  frames: 7\n  clip:\n"
          "    - sweep: {normal: posterior, from: 0%, to: 60%}\n"
          "      except: [coronary arteries]\n",
          file);
    fclose(file);
    for (long budget = 0; budget < 5; budget++) {
        scenario s = {.poor_rank = 2, .budget = budget};

        run_ranks(RANKS, false, load_job, &s);
        assert_int_equal(s.outcomes[0], budget < 2 ? SC_ERR_MEMORY : SC_OK);
        assert_int_equal(s.outcomes[1], s.outcomes[0]);
        assert_int_equal(s.outcomes[2], s.outcomes[0]);
    }
    unlink("session.yaml");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_array_reaches_all_ranks),
        cmocka_unit_test(an_array_that_one_rank_has_no_memory_for_is_on_rank_0_alone),
        cmocka_unit_test(a_job_that_one_rank_has_no_memory_for_is_cleared_on_all),
    };

    return RUN(tests);
}
