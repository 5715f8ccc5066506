/* SPDX-License-Identifier: BSD-3-Clause */
/* The farm with several ranks, which are threads of this process: what is drawn arrives whole, and
 * whatever fails on any rank ends the farm on all of them. The thread sanitizer watches, too, in
 * the preset tsan. */
#include "check.h"
#include "thread_comm.h"

#include "../../src/farm/internal.h"

#include <stdatomic.h>
#include <unistd.h>

enum { FRAMES = 40, GOP_FRAMES = 4, GOPS = 5, WIDTH_PX = 16, HEIGHT_PX = 64, NEVER = -1 };
/* The frames of the GOPs follow those that are drawn one by one. */
enum { TOTAL = FRAMES + GOPS * GOP_FRAMES };
enum { PAYLOAD_BYTES = 300000 }; /* payload of a GOP, which takes many messages */

/* How the farm is run, and what came of it. */
typedef struct scenario {
    int ranks;
    sc_partition partition;
    bool gops;     /* some GOPs are drawn whole, */
    bool gathers;  /* or gathered */
    bool shares;   /* ranks share frames */
    bool spoils;   /* drawing spoils other rows */
    bool meet;     /* nobody finishes a first GOP before every rank has begun one */
    int fails_at;  /* the frame that cannot be drawn, or NEVER */
    int poor_rank; /* the rank on which only the first `budget` allocations succeed, or NEVER */
    long budget;
    atomic_int stop;
    atomic_int begun, met; /* GOPs that were begun; ranks that have seen one begun on every rank */
    bool accepted[TOTAL];
    int accepted_count;
    sc_status outcomes[THREAD_RANKS_MAX];
    int stop_after;               /* encoded frames after which a stop comes; 0: none does */
    bool fails_to_encode;         /* the frame fails_at is drawn, but cannot be encoded */
    atomic_int encoded, finished; /* frames and GOPs that were encoded, on all ranks */
} scenario;

/* What a rank has encoded of a gathered GOP. Ranks are threads. */
static _Thread_local struct {
    int first, count;
} encoding = {NEVER, 0};

static sc_status draw(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result)
{
    const scenario *s = user;
    const size_t row_bytes = (size_t)image->width_px * 3;

    memset(image->rgb + (size_t)row * row_bytes, frame + 1, (size_t)rows * row_bytes);
    if (s->spoils && row + rows < image->height_px)
        memset(image->rgb + (size_t)(row + rows) * row_bytes, 0xff, row_bytes);
    result->samples = (uint64_t)rows;
    return frame == s->fails_at && !s->fails_to_encode && row + rows > image->height_px / 2
               ? SC_ERR_MEMORY
               : SC_OK;
}

/* Wait until every rank has begun a GOP, but 10 s at most. */
static void wait_for_others(scenario *s)
{
    for (int i = 0; i < 10000 && s->begun < s->ranks; i++)
        sc_sleep_s(1e-3);
    s->met += s->begun >= s->ranks;
}

static sc_status draw_gop(void *user, int first, int count, sc_frame_result *results,
                          sc_payload *out)
{
    scenario *s = user;
    void *data;

    if (s->meet && s->begun++ < s->ranks)
        wait_for_others(s);
    for (int i = 0; i < count; i++) {
        results[i].frame = first + i;
        if (first + i == s->fails_at)
            return SC_ERR_MEMORY;
    }
    assert_ok(sc_alloc(&quiet, PAYLOAD_BYTES, 1, &data));
    memset(data, first, PAYLOAD_BYTES);
    *out = (sc_payload){data, PAYLOAD_BYTES};
    return SC_OK;
}

static sc_status encode_frame(void *user, int first, int count, const sc_frame_result *result,
                              const sc_image *image, sc_payload *out)
{
    scenario *s = user;
    void *data;

    if (result->frame == first) {
        encoding.first = first;
        encoding.count = 0;
    }
    assert_int_equal(first, encoding.first);
    assert_int_equal(count, GOP_FRAMES);
    assert_int_equal(result->frame, first + encoding.count);
    assert_int_equal(result->samples, HEIGHT_PX);
    assert_int_equal(result->hash, sc_image_hash(image));
    for (size_t i = 0; i < sc_image_bytes(image); i++)
        assert_int_equal(image->rgb[i], result->frame + 1);
    if (result->frame == s->fails_at)
        return SC_ERR_MEMORY;
    if (++s->encoded == s->stop_after)
        s->stop = 1;
    if (++encoding.count < count)
        return SC_OK;
    assert_ok(sc_alloc(&quiet, PAYLOAD_BYTES, 1, &data));
    memset(data, first, PAYLOAD_BYTES);
    *out = (sc_payload){data, PAYLOAD_BYTES};
    s->finished++;
    return SC_OK;
}

static void note_accepted(scenario *s, int frame)
{
    assert_int_not_equal(frame, s->fails_at);
    assert_false(s->accepted[frame]);
    s->accepted[frame] = true;
    s->accepted_count++;
}

static sc_status accept_frame(void *user, const sc_frame_result *result, const sc_image *image)
{
    for (size_t i = 0; i < sc_image_bytes(image); i++)
        assert_int_equal(image->rgb[i], result->frame + 1);
    assert_int_equal(result->samples, HEIGHT_PX);
    assert_int_equal(result->hash, sc_image_hash(image));
    note_accepted(user, result->frame);
    return SC_OK;
}

static sc_status accept_gop(void *user, const sc_frame_result *results, int count,
                            const sc_payload *payload)
{
    const unsigned char *bytes = payload->data;

    assert_int_equal(payload->bytes, PAYLOAD_BYTES);
    for (size_t i = 0; i < payload->bytes; i++)
        assert_int_equal(bytes[i], results[0].frame);
    for (int i = 0; i < count; i++)
        note_accepted(user, results[i].frame);
    return SC_OK;
}

static void run_rank(sc_comm *comm, void *user)
{
    scenario *s = user;
    long budget = sc_comm_rank(comm) == s->poor_rank ? s->budget : 1000000;
    const sc_ctx ctx = {.alloc_budget = &budget};
    int frames[FRAMES], gops[GOPS];
    const sc_farm farm = {.width_px = WIDTH_PX,
                          .height_px = HEIGHT_PX,
                          .partition = s->partition,
                          .frames = frames,
                          .frame_count = FRAMES,
                          .gops = gops,
                          .gop_count = s->gops ? GOPS : 0,
                          .gather = s->gathers,
                          .gop_frames = GOP_FRAMES,
                          .total_frames = TOTAL,
                          .share_frames = s->shares,
                          .spoils_other_rows = s->spoils,
                          .calls.draw = draw,
                          .calls.draw_gop = draw_gop,
                          .calls.encode_frame = encode_frame,
                          .calls.accept_frame = accept_frame,
                          .calls.accept_gop = accept_gop,
                          .stop = &s->stop,
                          .calls.user = s};
    sc_farm_times times;

    for (int i = 0; i < FRAMES; i++)
        frames[i] = i;
    for (int g = 0; g < GOPS; g++)
        gops[g] = FRAMES + g * GOP_FRAMES;
    s->outcomes[sc_comm_rank(comm)] = sc_farm_run(&ctx, comm, &farm, &times);
}

/* Run the farm on all ranks. @return the return code, which must be the same on all ranks. */
static sc_status run(scenario *s)
{
    alarm(120); /* ends a farm that hangs, which makes the test fail */
    run_ranks(s->ranks, s->shares, run_rank, s);
    alarm(0);
    for (int rank = 1; rank < s->ranks; rank++)
        assert_int_equal(s->outcomes[rank], s->outcomes[0]);
    return s->outcomes[0];
}

/* Call @p check with every way of sharing out frames. */
static void for_all_ways(void (*check)(const scenario *way))
{
    for (int ranks = 1; ranks <= 3; ranks += 2) {
        for (int partition = SC_PARTITION_AUTO; partition <= SC_PARTITION_TILES; partition++) {
            for (int bits = 0; bits < 16; bits++)
                check(&(scenario){.ranks = ranks,
                                  .partition = (sc_partition)partition,
                                  .gops = bits & 1,
                                  .gathers = bits >> 3 & 1,
                                  .shares = bits >> 1 & 1,
                                  .spoils = bits >> 2 & 1,
                                  .fails_at = NEVER,
                                  .poor_rank = NEVER});
        }
    }
}

static void check_all_accepted(const scenario *way)
{
    scenario s = *way;

    assert_ok(run(&s));
    assert_int_equal(s.accepted_count, s.gops ? TOTAL : FRAMES);
}

TEST(every_frame_is_accepted_once_in_every_way)
{
    for_all_ways(check_all_accepted);
}

/* A rank that does not know yet how long a unit takes must not keep a second one, which another
 * rank could begin at once. */
TEST(no_rank_holds_a_second_gop_while_others_have_none)
{
    scenario s = {.ranks = GOPS, .gops = true, .meet = true, .fails_at = NEVER, .poor_rank = NEVER};

    assert_ok(run(&s));
    assert_int_equal(s.met, GOPS);
}

static void check_failed_frame(const scenario *way)
{
    scenario s = *way;

    s.fails_at = 11;
    assert_int_equal(run(&s), SC_ERR_MEMORY);
    for (int k = 0; k < FRAMES; k++)
        assert_true(k < s.fails_at || !s.accepted[k]);
}

TEST(a_frame_that_cannot_be_drawn_is_not_accepted_and_ends_all_ranks)
{
    for_all_ways(check_failed_frame);
}

static void check_failed_gop(const scenario *way)
{
    scenario s = *way;

    if (!s.gops)
        return;
    s.fails_at = FRAMES + GOP_FRAMES + 2;
    assert_int_equal(run(&s), SC_ERR_MEMORY);
    assert_false(s.accepted[s.fails_at]);
    if (s.gathers && s.ranks > 1)
        return; /* the other frames of the GOP are accepted one by one */
    for (int i = 0; i < GOP_FRAMES; i++)
        assert_false(s.accepted[FRAMES + GOP_FRAMES + i]);
}

TEST(a_gop_that_cannot_be_drawn_is_not_accepted_and_ends_all_ranks)
{
    for_all_ways(check_failed_gop);
}

static void check_stop(const scenario *way)
{
    scenario s = *way;
    sc_status outcome;

    if (!s.gops || !s.gathers || s.ranks == 1)
        return;
    s.stop_after = 2 * GOP_FRAMES - 1;
    outcome = run(&s);
    assert_true(outcome == SC_ERR_INCOMPLETE || (outcome == SC_OK && s.accepted_count == TOTAL));
    /* what was encoded is accepted, also the frames of GOPs that were not finished */
    assert_true(s.accepted_count >= FRAMES + s.encoded);
}

TEST(after_a_stop_no_frame_of_a_gathered_gop_is_lost)
{
    for_all_ways(check_stop);
}

TEST(a_gathered_frame_that_cannot_be_encoded_ends_all_ranks)
{
    for (int place = 0; place < GOP_FRAMES; place++) {
        scenario s = {.ranks = 3,
                      .gops = true,
                      .gathers = true,
                      .fails_to_encode = true,
                      .fails_at = FRAMES + GOP_FRAMES + place,
                      .poor_rank = NEVER};

        assert_int_equal(run(&s), SC_ERR_MEMORY);
        assert_true(s.accepted_count < TOTAL);
    }
}

/* ---- an encoder alone ---- */

static sc_status fail_to_encode(void *user, int first, int count, const sc_frame_result *result,
                                const sc_image *image, sc_payload *out)
{
    return SC_ERR_MEMORY;
}

/* Rank 1 gathers a GOP from the frame *(int *)user on, which never is encoded. */
static void gather_without_end(sc_comm *comm, void *user)
{
    static atomic_int no_stop;
    const int from = *(const int *)user, gops[2] = {0, GOP_FRAMES};
    const sc_farm farm = {.width_px = WIDTH_PX,
                          .height_px = HEIGHT_PX,
                          .gops = gops,
                          .gop_count = 2,
                          .gather = true,
                          .gop_frames = GOP_FRAMES,
                          .calls.encode_frame = fail_to_encode,
                          .stop = &no_stop};
    static const char rows[WIDTH_PX * HEIGHT_PX * 3];
    char inbox[sizeof(sc_result_message) + sizeof rows];
    sc_message mail = {.tag = 0};
    sc_gather *g;

    while (sc_comm_rank(comm) == 0 && mail.tag != SC_TAG_YIELDED) {
        if (sc_comm_poll(comm, &mail))
            sc_comm_receive(comm, &mail, inbox);
        sc_sleep_s(1e-4);
    }
    if (sc_comm_rank(comm) == 0)
        return;
    assert_ok(sc_gather_open(&quiet, comm, &farm, &g));
    for (int place = from; place < GOP_FRAMES; place++)
        sc_gather_add(g,
                      &(sc_result_message){.unit = {.kind = SC_UNIT_FRAME,
                                                    .rows = HEIGHT_PX,
                                                    .encoder = 1,
                                                    .gop = 1,
                                                    .place = place}},
                      rows);
    assert_true(sc_gather_is_behind(g));
    if (from > 0)
        sc_gather_yield(g, GOP_FRAMES - from); /* the first frame does not come */
    for (int i = 0; i < 10000 && sc_gather_is_behind(g); i++) {
        (void)sc_gather_step(g);
        sc_sleep_s(1e-3);
    }
    assert_false(sc_gather_is_behind(g));
    if (from == 0)
        sc_gather_yield(g, GOP_FRAMES);
    for (int i = 0; i < 10000 && (sc_gather_step(g) || sc_comm_pending(comm) > 0); i++)
        sc_sleep_s(1e-3);
    sc_gather_close(g);
}

TEST(an_encoder_does_not_wait_for_frames_that_are_never_encoded)
{
    alarm(120);
    for (int from = 0; from < 2; from++)
        run_ranks(2, false, gather_without_end, &from);
    alarm(0);
}

TEST(an_allocation_that_fails_on_any_rank_ends_all_ranks)
{
    for (int way = 0; way < 6; way++) {
        const int rank = way % 3;
        sc_status outcome = SC_ERR_MEMORY;

        for (long budget = 0; outcome != SC_OK; budget++) {
            scenario s = {.ranks = 3,
                          .gops = true,
                          .gathers = way >= 3,
                          .fails_at = NEVER,
                          .poor_rank = rank,
                          .budget = budget};

            outcome = run(&s);
            assert_true(outcome == SC_OK || outcome == SC_ERR_MEMORY);
            assert_true(outcome != SC_OK || s.accepted_count == TOTAL);
            assert_true(budget < 1000);
        }
    }
}

RUN_TESTS(NULL, NULL)
