/* SPDX-License-Identifier: BSD-3-Clause */
/* The hand-out alone, with simulated ranks; and the farm with one rank. */
#include "check.h"

#include "segcast/farm.h"

enum { UNITS = 500, RANKS_MAX = 64 };

/* Ranks of random speed; units come back in any order. What is held never exceeds the window, and
 * every unit is drawn exactly once. */
static void simulate(int ranks, int window, uint64_t seed)
{
    sc_handout h = {.total = UNITS, .window = window};
    int busy[RANKS_MAX], drawn[UNITS] = {0};
    bool back[UNITS] = {false};

    for (int i = 0; i < ranks; i++)
        busy[i] = -1;
    while (h.taken < UNITS) {
        const int rank = (int)(random_bits(&seed) % (uint64_t)ranks);

        if (busy[rank] >= 0) {
            back[busy[rank]] = true;
            busy[rank] = -1;
            sc_handout_back(&h);
        } else {
            const int unit = sc_handout_next(&h);

            if (unit >= 0) {
                assert_int_equal(drawn[unit]++, 0);
                assert_true(unit < h.taken + window);
                busy[rank] = unit;
            }
        }
        while (h.taken < UNITS && back[h.taken])
            h.taken++;
    }
    assert_true(sc_handout_finished(&h));
    assert_int_equal(sc_handout_next(&h), SC_HANDOUT_END);
}

static void every_unit_goes_out_once_within_the_window(void **state)
{
    (void)state;
    for (int ranks = 1; ranks <= RANKS_MAX; ranks = 2 * ranks + 1) {
        simulate(ranks, 1, 3);
        simulate(ranks, 2 * ranks, 5);
    }
}

static void a_stop_ends_the_hand_out(void **state)
{
    sc_handout h = {.total = 10, .window = 4};

    (void)state;
    assert_int_equal(sc_handout_next(&h), 0);
    assert_int_equal(sc_handout_next(&h), 1);
    h.stopped = true;
    assert_int_equal(sc_handout_next(&h), SC_HANDOUT_END);
    assert_false(sc_handout_finished(&h));
    sc_handout_back(&h);
    sc_handout_back(&h);
    assert_true(sc_handout_finished(&h));
}

static void the_window_bounds_memory(void **state)
{
    const size_t frame_4k = 3840 * 2160 * 3;

    (void)state;
    assert_true((size_t)sc_handout_window(100000, frame_4k) * frame_4k <= (size_t)128 << 20);
    assert_true(sc_handout_window(1, 1000) >= 2);
    assert_true(sc_handout_window(1, (size_t)1 << 40) >= 2);
}

typedef struct probe {
    int taken[UNITS], count, stop_after, fail_after;
    volatile sig_atomic_t stop;
} probe;

static void draw(void *user, int frame, sc_image *image, sc_frame_result *result)
{
    (void)user;
    memset(image->rgb, frame, sc_image_bytes(image));
    result->samples = (uint64_t)frame * 3;
}

static sc_status take(void *user, const sc_frame_result *result, const sc_image *image)
{
    probe *p = user;

    assert_int_equal(image->rgb[5], (uint8_t)result->frame);
    assert_int_equal(result->samples, (uint64_t)result->frame * 3);
    assert_int_equal(result->hash, sc_image_hash(image));
    p->taken[p->count++] = result->frame;
    p->stop = p->count == p->stop_after;
    return p->count == p->fail_after ? SC_ERR_WRITE : SC_OK;
}

static sc_status run(probe *p, const int *frames, int count)
{
    sc_comm *comm;
    sc_farm_times times;
    const sc_farm farm = {.width_px = 5,
                          .height_px = 3,
                          .frames = frames,
                          .frame_count = count,
                          .draw = draw,
                          .take = take,
                          .stop = &p->stop,
                          .user = p};
    sc_status status;

    assert_ok(sc_comm_open(&quiet, false, &comm));
    status = sc_farm_run(&quiet, comm, &farm, &times);
    sc_comm_close(comm);
    return status;
}

static void one_rank_takes_all_frames_in_order(void **state)
{
    const int frames[] = {3, 4, 7, 9, 30, 31, 32, 33, 90};
    probe p = {.stop_after = -1, .fail_after = -1};

    (void)state;
    assert_ok(run(&p, frames, 9));
    assert_int_equal(p.count, 9);
    assert_memory_equal(p.taken, frames, sizeof frames);
}

static void a_stop_is_incomplete_and_an_error_is_itself(void **state)
{
    int frames[100];
    probe p = {.stop_after = 4, .fail_after = -1}, q = {.stop_after = -1, .fail_after = 4};

    (void)state;
    for (int i = 0; i < 100; i++)
        frames[i] = i;
    assert_int_equal(run(&p, frames, 100), SC_ERR_INCOMPLETE);
    assert_in_range(p.count, 4, 20);
    assert_int_equal(run(&q, frames, 100), SC_ERR_WRITE);
    assert_int_equal(q.count, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_unit_goes_out_once_within_the_window),
        cmocka_unit_test(a_stop_ends_the_hand_out),
        cmocka_unit_test(the_window_bounds_memory),
        cmocka_unit_test(one_rank_takes_all_frames_in_order),
        cmocka_unit_test(a_stop_is_incomplete_and_an_error_is_itself),
    };

    return RUN(tests);
}
