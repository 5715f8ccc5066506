/* SPDX-License-Identifier: BSD-3-Clause */
/* The hand-out by itself, and the farm with one rank; unit.simulate has many ranks. */
#include "check.h"

#include "segcast/farm.h"

enum { UNITS = 500 };

TEST(a_single_frame_is_split_over_all_ranks)
{
    const sc_work work = {.ranks = 2,
                          .frames = 1,
                          .width_px = 3840,
                          .height_px = 2160,
                          .partition = SC_PARTITION_AUTO};
    sc_handout h = sc_handout_begin(&work);
    sc_work_unit unit;
    int units = 0, next_row = 0;

    while (sc_handout_next(&h, &unit) == SC_HANDOUT_UNIT) {
        assert_int_equal(unit.kind, SC_UNIT_BAND);
        assert_int_equal(unit.row, next_row);
        next_row += unit.rows;
        units++;
    }
    assert_int_equal(next_row, 2160);
    assert_in_range(units, 12, 40);
}

TEST(partitions_split_the_frames_that_they_promise)
{
    sc_work work = {.ranks = 4, .frames = 100, .width_px = 640, .height_px = 480};
    sc_handout h;

    work.partition = SC_PARTITION_FRAMES;
    assert_int_equal(sc_handout_begin(&work).split_from, 100);
    work.partition = SC_PARTITION_TILES;
    assert_int_equal(sc_handout_begin(&work).split_from, 0);
    work.partition = SC_PARTITION_AUTO;
    assert_in_range(sc_handout_begin(&work).split_from, 80, 96);
    work.ranks = 1;
    assert_int_equal(sc_handout_begin(&work).split_from, 100);
    work.height_px = 7; /* lower than a band */
    work.partition = SC_PARTITION_TILES;
    h = sc_handout_begin(&work);
    assert_true(h.band_rows > 0);
}

TEST(gops_go_out_first_and_leave_frames_for_the_end)
{
    const sc_work work = {.ranks = 4, .gops = 3, .frames = 2, .width_px = 64, .height_px = 64};
    sc_handout h = sc_handout_begin(&work);
    sc_work_unit unit;

    for (int g = 0; g < 3; g++) {
        assert_int_equal(sc_handout_next(&h, &unit), SC_HANDOUT_UNIT);
        assert_int_equal(unit.kind, SC_UNIT_GOP);
        assert_int_equal(unit.index, g);
    }
    assert_int_equal(sc_handout_next(&h, &unit), SC_HANDOUT_UNIT);
    assert_int_not_equal(unit.kind, SC_UNIT_GOP);
    assert_int_equal(sc_handout_gops(100, 2, false), 0);
    assert_int_equal(sc_handout_gops(100, 2, true), 99);
    assert_int_equal(sc_handout_gops(100, 8, false), 96);
    assert_int_equal(sc_handout_gops(10, 8, false), 0);
    assert_int_equal(sc_handout_gops(1, 8, true), 0);
    assert_int_equal(sc_handout_gops(0, 8, true), 0);
}

/* ---- gathered GOPs ---- */

enum { GATHERED = 23, GATHERED_FRAMES = 6 };

/* Hand out everything, and check that each encoder gets its GOPs one after the other, each in the
 * order of its frames, and that every row goes out once. @param delay so many frames are taken
 * late.
 */
static void check_gathered(const sc_work *work, int encoders, int delay)
{
    int rows[GATHERED][GATHERED_FRAMES] = {{0}}, next[GATHERED] = {0}, latest[64] = {0};
    sc_handout h = sc_handout_begin(work);
    sc_handout_answer answer;
    sc_work_unit unit;

    memset(latest, -1, sizeof latest);
    while ((answer = sc_handout_next(&h, &unit)) != SC_HANDOUT_END) {
        h.encoders = encoders;
        if (answer == SC_HANDOUT_WAIT)
            assert_true(h.taken < h.next_gathered || h.accepted < h.next_frame);
        if (answer == SC_HANDOUT_WAIT || unit.encoder == 0) {
            h.taken += h.taken < h.next_gathered;
            h.accepted += h.accepted < h.next_frame;
            continue;
        }
        assert_in_range(unit.encoder, 1, work->ranks - 1);
        assert_true(unit.index < h.taken + h.gather_window);
        assert_true(unit.gop >= latest[unit.encoder]);
        latest[unit.encoder] = unit.gop;
        assert_true(unit.place == next[unit.gop] || unit.place == next[unit.gop] - 1);
        next[unit.gop] = unit.place + 1;
        rows[unit.gop][unit.place] += unit.rows;
        if (h.next_gathered > h.taken + delay)
            h.taken++;
    }
    for (int gop = 0; gop < GATHERED; gop++) {
        for (int i = 0; i < GATHERED_FRAMES; i++)
            assert_int_equal(rows[gop][i], work->height_px);
    }
}

TEST(every_gathered_frame_goes_to_the_encoder_of_its_gop_in_order)
{
    for (int partition = SC_PARTITION_AUTO; partition <= SC_PARTITION_TILES; partition++) {
        for (int ranks = 2; ranks < 64; ranks += 1 + ranks / 2) {
            for (int encoders = 1; encoders < 64; encoders += encoders) {
                const sc_work work = {.ranks = ranks,
                                      .frames = 4,
                                      .gathered = GATHERED,
                                      .gop_frames = GATHERED_FRAMES,
                                      .width_px = 64,
                                      .height_px = 100,
                                      .partition = (sc_partition)partition};

                check_gathered(&work, encoders, 0);
                check_gathered(&work, encoders, 1000);
            }
        }
    }
}

/* A rank that gets GOPs of two groups must not get the later one first, so that a group waits until
 * all encoders of the one before it have begun. */
TEST(a_group_waits_until_the_one_before_it_has_begun)
{
    const sc_work work = {.ranks = 5,
                          .gathered = 8,
                          .gop_frames = 3,
                          .width_px = 64,
                          .height_px = 64,
                          .partition = SC_PARTITION_FRAMES};
    sc_handout h = sc_handout_begin(&work);
    sc_work_unit unit;

    h.encoders = 4;
    for (int i = 0; i < 12; i++) {
        assert_int_equal(sc_handout_next(&h, &unit), SC_HANDOUT_UNIT);
        assert_int_equal(unit.encoder, 1 + i % 4);
        assert_int_equal(unit.gop, i % 4);
        assert_int_equal(unit.place, i / 4);
        assert_true(sc_handout_gathers_next(&h));
    }
    h.taken = 3;
    assert_int_equal(sc_handout_next(&h, &unit), SC_HANDOUT_WAIT);
    h.taken = 4;
    assert_int_equal(sc_handout_next(&h, &unit), SC_HANDOUT_UNIT);
    assert_int_equal(unit.gop, 4);
    h.stopped = true;
    assert_int_equal(sc_handout_next(&h, &unit), SC_HANDOUT_END);
}

/* However many encoders are wanted, no more GOPs are gathered at a time than there is memory for.
 */
TEST(groups_are_no_larger_than_allowed)
{
    const sc_work work = {.ranks = 9,
                          .gathered = 8,
                          .gop_frames = 3,
                          .encoders_most = 3,
                          .width_px = 64,
                          .height_px = 64,
                          .partition = SC_PARTITION_FRAMES};
    sc_handout h = sc_handout_begin(&work);
    sc_work_unit unit;
    int most = 0;

    while (sc_handout_next(&h, &unit) == SC_HANDOUT_UNIT) {
        h.encoders = 8;
        most = h.group.gops > most ? h.group.gops : most;
        h.taken = h.next_gathered;
    }
    assert_int_equal(h.next_gathered, 24);
    assert_int_equal(most, 3);
}

/* @return the rows of the next band of a gathered GOP, with all frames before it taken. */
static int next_band(sc_handout *h)
{
    sc_work_unit unit;

    h->taken = h->next_gathered;
    h->encoders = 20;
    assert_int_equal(sc_handout_next(h, &unit), SC_HANDOUT_UNIT);
    assert_int_equal(unit.kind, SC_UNIT_BAND);
    return unit.rows;
}

TEST(bands_of_gathered_gops_get_thinner_towards_the_end)
{
    const sc_work work = {.ranks = 1000,
                          .gathered = 60,
                          .gop_frames = 30,
                          .width_px = 3840,
                          .height_px = 2160,
                          .partition = SC_PARTITION_AUTO};
    sc_handout h = sc_handout_begin(&work);
    int first = next_band(&h), rows = first, before;

    assert_true(first > 32 && first % 16 == 0);
    while (h.next_gathered < 60 * 30 - 1) {
        const bool begins = h.next_gathered_row == 0;

        before = rows;
        rows = next_band(&h);
        assert_true(rows <= before || begins);
    }
    assert_int_equal(rows, 8);
    /* frames that are drawn at the same time leave most of the window free */
    assert_true((long)first * work.ranks * 4 < (long)h.gather_window * work.height_px);
}

TEST(there_are_as_many_encoders_as_costs_ask_for)
{
    assert_int_equal(sc_handout_encoders(64, 0, 0), 1);
    assert_int_equal(sc_handout_encoders(4096, 200, 0), 17);
    assert_int_equal(sc_handout_encoders(4096, 200, 0.3), 19);
    assert_int_equal(sc_handout_encoders(4096, 1e6, 1e-6), 1);
    assert_int_equal(sc_handout_encoders(4096, 1e-9, 1e6), 4096);
    assert_int_equal(sc_handout_gathered(60, 1, true), 0);
    assert_int_equal(sc_handout_gathered(60, 2, true), 59);
    assert_int_equal(sc_handout_gathered(0, 2, true), 0);
    assert_int_equal(sc_handout_gathered(60, 8, false), 0);
    assert_int_equal(sc_handout_gathered(60, 4096, false), 59);
    assert_int_equal(sc_handout_gathered(12288, 4096, false), 0); /* GOPs are drawn whole */
}

TEST(a_rank_asks_ahead_only_if_it_knows_what_a_unit_costs)
{
    assert_true(sc_handout_ask_age_s(100, 0) > 1e300);
    assert_near(sc_handout_ask_age_s(100, 0.02), 2 - 0.01, 1e-12);
    assert_true(sc_handout_ask_age_s(100, 5e-5) <= 0 && sc_handout_ask_age_s(100, 5e-5) >= 0);
}

/* After a stop a frame of which some bands are out is completed, and no other is begun. */
TEST(a_stop_ends_the_hand_out_at_a_frame)
{
    const sc_work work = {.ranks = 2,
                          .frames = 50,
                          .width_px = 64,
                          .height_px = 480,
                          .partition = SC_PARTITION_TILES};
    sc_handout h = sc_handout_begin(&work);
    sc_work_unit unit;
    int rows = 0;

    assert_int_equal(sc_handout_next(&h, &unit), SC_HANDOUT_UNIT);
    rows = unit.rows;
    h.stopped = true;
    while (sc_handout_next(&h, &unit) == SC_HANDOUT_UNIT) {
        assert_int_equal(unit.index, 0);
        assert_false(sc_handout_finished(&h));
        rows += unit.rows;
    }
    assert_int_equal(rows, 480);
    assert_false(sc_handout_finished(&h));
    while (h.out > 0)
        sc_handout_unit_done(&h);
    assert_true(sc_handout_finished(&h));
}

/* ---- the farm with one rank ---- */

#define SLOW_S 0.5

typedef struct probe {
    int accepted[UNITS], count, stop_after, fail_after;
    int slow_frame;  /* drawing this frame takes SLOW_S; 0: none does */
    double accept_s; /* how long accepting a frame takes */
    int most_done;   /* the largest number of frames that on_progress was told */
    atomic_int stop;
    sc_partition partition;
    int gops;
    double deadline_s;
} probe;

static sc_status draw(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result)
{
    const size_t row_bytes = (size_t)image->width_px * 3;
    const probe *p = user;

    if (frame > 0 && frame == p->slow_frame)
        sc_sleep_s(SLOW_S);
    memset(image->rgb + (size_t)row * row_bytes, frame, (size_t)rows * row_bytes);
    result->samples = (uint64_t)frame * 3 * (uint64_t)rows;
    return SC_OK;
}

/* The payload of a GOP is the number of its first frame. */
static sc_status draw_gop(void *user, int first, int count, sc_frame_result *results,
                          sc_payload *out)
{
    void *data;

    for (int i = 0; i < count; i++)
        results[i].frame = first + i;
    assert_ok(sc_alloc(&quiet, 1, sizeof first, &data));
    memcpy(data, &first, sizeof first);
    *out = (sc_payload){data, sizeof first};
    return SC_OK;
}

static sc_status accept_frame(void *user, const sc_frame_result *result, const sc_image *image)
{
    probe *p = user;

    assert_int_equal(image->rgb[5], (uint8_t)result->frame);
    assert_int_equal(result->samples, (uint64_t)result->frame * 3 * (uint64_t)image->height_px);
    assert_int_equal(result->hash, sc_image_hash(image));
    p->accepted[p->count++] = result->frame;
    sc_sleep_s(p->accept_s);
    p->stop = p->stop || p->count == p->stop_after;
    if (p->stop_after > 0)
        sc_sleep_s(5e-3); /* so that the farm notices the stop */
    return p->count == p->fail_after ? SC_ERR_WRITE : SC_OK;
}

static sc_status accept_gop(void *user, const sc_frame_result *results, int count,
                            const sc_payload *payload)
{
    probe *p = user;

    assert_int_equal(payload->bytes, sizeof(int));
    assert_int_equal(*(const int *)payload->data, results[0].frame);
    for (int i = 0; i < count; i++)
        p->accepted[p->count++] = results[i].frame;
    return SC_OK;
}

static void note_progress(void *user, int done, int total)
{
    probe *p = user;

    p->most_done = done > p->most_done ? done : p->most_done;
}

static sc_status run(probe *p, const int *frames, int count)
{
    sc_comm *comm;
    sc_farm_times times;
    static const int gops[] = {100, 104};
    const sc_farm farm = {.width_px = 5,
                          .height_px = 40,
                          .partition = p->partition,
                          .gops = gops,
                          .gop_count = p->gops,
                          .gop_frames = 4,
                          .total_frames = 106,
                          .calls.draw_gop = draw_gop,
                          .calls.accept_gop = accept_gop,
                          .deadline_s = p->deadline_s,
                          .frames = frames,
                          .frame_count = count,
                          .calls.draw = draw,
                          .calls.accept_frame = accept_frame,
                          .calls.on_progress = note_progress,
                          .stop = &p->stop,
                          .calls.user = p};
    sc_status status;

    assert_ok(sc_comm_open(&quiet, false, &comm));
    status = sc_farm_run(&quiet, comm, &farm, &times);
    sc_comm_close(comm);
    return status;
}

TEST(one_rank_accepts_all_frames_in_order)
{
    const int frames[] = {3, 4, 7, 9, 30, 31, 32, 33, 90};
    probe p = {.stop_after = -1, .fail_after = -1};

    assert_ok(run(&p, frames, 9));
    assert_int_equal(p.count, 9);
    assert_memory_equal(p.accepted, frames, sizeof frames);
}

TEST(bands_and_gops_are_all_accepted)
{
    const int frames[] = {3, 4, 7, 9, 30, 31};
    probe p = {.stop_after = -1, .fail_after = -1, .partition = SC_PARTITION_TILES, .gops = 2};
    int sum = 0;

    assert_ok(run(&p, frames, 6));
    assert_int_equal(p.count, 6 + 4 + 2); /* the last GOP is shorter */
    for (int i = 0; i < p.count; i++)
        sum += p.accepted[i];
    assert_int_equal(sum, 3 + 4 + 7 + 9 + 30 + 31 + 100 + 101 + 102 + 103 + 104 + 105);
}

TEST(a_deadline_that_has_passed_stops_the_farm)
{
    int frames[100];
    probe p = {.stop_after = -1, .fail_after = -1, .deadline_s = sc_wall_s() - 1};

    for (int i = 0; i < 100; i++)
        frames[i] = i;
    assert_int_equal(run(&p, frames, 100), SC_ERR_INCOMPLETE);
    assert_int_equal(p.count, 0);
    p.deadline_s = sc_wall_s() + 1000;
    assert_ok(run(&p, frames, 100));
}

TEST(the_farm_returns_incomplete_after_a_stop_and_the_error_of_a_callback)
{
    int frames[UNITS];
    probe p = {.stop_after = 4, .fail_after = -1}, q = {.stop_after = -1, .fail_after = 4};

    for (int i = 0; i < UNITS; i++)
        frames[i] = i;
    assert_int_equal(run(&p, frames, UNITS), SC_ERR_INCOMPLETE);
    assert_in_range(p.count, 4, 4 + 64 + 2); /* the window, and what was being drawn */
    assert_int_equal(run(&q, frames, UNITS), SC_ERR_WRITE);
    assert_int_equal(q.count, 4);
}

/* The frame that cannot be accepted fails while the next one is still being drawn, so that progress
 * is told afterwards. */
TEST(a_frame_that_cannot_be_accepted_does_not_count_as_done)
{
    const int frames[] = {0, 1, 2, 3, 4};
    probe p = {.stop_after = -1, .fail_after = 1, .slow_frame = 1, .accept_s = SLOW_S / 5};

    assert_int_equal(run(&p, frames, 5), SC_ERR_WRITE);
    assert_int_equal(p.count, 1);
    assert_int_equal(p.most_done, 0);
}

RUN_TESTS(NULL, NULL)
