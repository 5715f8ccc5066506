/* SPDX-License-Identifier: BSD-3-Clause */
/* The bottleneck of a run, the trace, and the statistics of several runs on one job. */
#include "check.h"

#include "segcast/study.h"

#include <stdio.h>
#include <unistd.h>

enum { RANKS = 4 };

/* Fill in four ranks that drew for the same time and hardly waited. */
static void balanced(sc_rank_record *ranks, sc_run_record *run)
{
    *run =
        (sc_run_record){.ranks = RANKS, .rank_records = ranks, .wall_s = 101, .farm_wall_s = 100};
    for (int i = 0; i < RANKS; i++) {
        ranks[i] = (sc_rank_record){.farm_idle_s = 2};
        ranks[i].phases[SC_PHASE_RENDER].wall_s = 98;
    }
}

static void the_bottleneck_is_where_the_time_went(void **state)
{
    sc_rank_record ranks[RANKS];
    sc_run_record run;

    (void)state;
    balanced(ranks, &run);
    assert_int_equal(sc_run_bottleneck(&run), SC_BOTTLENECK_DRAW);
    ranks[0].phases[SC_PHASE_PREPARE].wall_s = 120;
    assert_int_equal(sc_run_bottleneck(&run), SC_BOTTLENECK_PREPARE);
    run.from_prepared = true; /* then it must not be advised to prepare the volume */
    assert_int_equal(sc_run_bottleneck(&run), SC_BOTTLENECK_START);

    balanced(ranks, &run);
    ranks[0].accept_wall_s = 97;
    assert_int_equal(sc_run_bottleneck(&run),
                     SC_BOTTLENECK_DRAW); /* it is busy, but no rank waits for it */
    for (int i = 0; i < RANKS; i++)
        ranks[i].farm_idle_s = 60;
    assert_int_equal(sc_run_bottleneck(&run), SC_BOTTLENECK_ENCODE);
    run.wrote_png = true;
    ranks[0].phases[SC_PHASE_WRITE].wall_s = 70;
    ranks[0].phases[SC_PHASE_ENCODE].wall_s = 27;
    assert_int_equal(sc_run_bottleneck(&run), SC_BOTTLENECK_WRITE);

    balanced(ranks, &run);
    for (int i = 0; i < RANKS; i++)
        ranks[i].farm_idle_s = 60;
    ranks[0].phases[SC_PHASE_GATHER].wall_s = 95;
    assert_int_equal(sc_run_bottleneck(&run), SC_BOTTLENECK_GATHER);

    balanced(ranks, &run);
    for (int i = 1; i < RANKS; i++) {
        ranks[i].farm_idle_s = 50;
        ranks[i].phases[SC_PHASE_RENDER].wall_s = 50;
    }
    assert_int_equal(sc_run_bottleneck(&run), SC_BOTTLENECK_BALANCE);
    assert_near(sc_run_imbalance(&run), 98 * 4 / (98 + 150.0) - 1, 1e-12);
}

/* Events for which there is no room are only counted. */
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

/* ---- several runs on one job ---- */

static const sc_job_hashes job = {0x1234, 0xfedcba9876543210};

/* Write a run that drew frames [first, first + count) with measured values of its own. */
static void write_run(int64_t begin_unix_s, int first, int count, const sc_history *earlier)
{
    sc_rank_record rank = {.threads = 3, .cpu_s = 5};
    sc_frame_result frames[20];
    const sc_run_record run = {.version = "1",
                               .host = "n1",
                               .job = job,
                               .begin_unix_s = begin_unix_s,
                               .earlier = earlier,
                               .ranks = 1,
                               .nodes = 1,
                               .wall_s = 2.5,
                               .rank_records = &rank,
                               .frames = frames,
                               .frame_count = count};

    for (int i = 0; i < count; i++)
        frames[i] = (sc_frame_result){.frame = first + i,
                                      .render_cpu_s = 0.1 * (double)begin_unix_s,
                                      .rays = 1000,
                                      .hash = 0xabcdef0000000000u + (uint64_t)(first + i)};
    assert_ok(sc_run_write(&quiet, &run, "stats.json", "frames.csv"));
}

static int count_lines(const char *path)
{
    FILE *file = fopen(path, "r");
    int lines = 0, c;

    while ((c = fgetc(file)) != EOF)
        lines += c == '\n';
    fclose(file);
    return lines;
}

static void earlier_runs_keep_what_they_measured(void **state)
{
    sc_history first = {0}, both = {0};
    sc_ctx ctx;
    heard h;

    (void)state;
    ctx = listening(&h);
    unlink("stats.json");
    assert_ok(sc_history_read(&ctx, "stats.json", &job, &first));
    assert_int_equal(first.run_count, 0);
    write_run(10, 0, 5, &first);
    assert_ok(sc_history_read(&ctx, "stats.json", &job, &first));
    assert_int_equal(first.run_count, 1);
    assert_int_equal(first.frame_count, 5);
    write_run(20, 4, 6, &first); /* frames from 4 on are drawn again */
    assert_ok(sc_history_read(&ctx, "stats.json", &job, &both));
    assert_int_equal(both.run_count, 2);
    assert_string_equal(both.runs[0].begin, "1970-01-01T00:00:10Z");
    assert_string_equal(both.runs[1].begin, "1970-01-01T00:00:20Z");
    assert_string_equal(both.runs[1].host, "n1");
    assert_int_equal(both.runs[1].frames, 6);
    assert_int_equal(both.runs[1].threads, 3);
    assert_near(both.runs[1].cpu_s, 5, 1e-9);
    assert_int_equal(both.frame_count, 10);
    for (int i = 0; i < 10; i++) {
        assert_int_equal(both.frames[i].result.frame, i);
        assert_int_equal(both.frames[i].run, i >= 4);
        assert_near(both.frames[i].result.render_cpu_s, i < 4 ? 1 : 2, 1e-9);
        assert_int_equal(both.frames[i].result.hash, 0xabcdef0000000000u + (uint64_t)i);
    }
    assert_int_equal(count_lines("frames.csv"), 11);
    assert_ok(sc_history_read(&ctx, "stats.json", &job,
                              &both)); /* reads the same runs again, which adds nothing */
    assert_int_equal(both.run_count, 2);
    assert_int_equal(both.frame_count, 10);
    assert_string_equal(h.text, "");
    sc_history_clear(&first);
    sc_history_clear(&both);
}

/* Each damaged file gives a warning and adds nothing. */
static void damaged_statistics_are_left_out(void **state)
{
    const sc_job_hashes other = {0x1235, 0xfedcba9876543210};
    char *text;
    size_t bytes;

    (void)state;
    write_run(10, 0, 5, NULL);
    assert_ok(sc_file_read(&quiet, "stats.json", 100000, &text, &bytes));
    for (int way = 0; way < 5; way++) {
        char *run = strstr(text, "\"run\": 0"), *hash = strstr(text, "\"hash\": \"a");
        sc_history history = {0};
        heard h;
        const sc_ctx ctx = listening(&h);

        assert_non_null(run);
        assert_non_null(hash);
        run[7] = way == 1 ? '7' : '0'; /* the frame names a run that does not exist */
        hash[9] = way == 2 ? 'x' : 'a';
        assert_ok(sc_file_write(&quiet, "stats.json", way == 4 ? "{}" : text,
                                way == 0   ? bytes / 2
                                : way == 4 ? 2
                                           : bytes));
        assert_ok(sc_history_read(&ctx, "stats.json", way == 3 ? &other : &job, &history));
        assert_int_equal(history.run_count, 0);
        assert_int_equal(history.frame_count, 0);
        assert_int_equal(h.errors, 0);
        assert_non_null(strstr(h.text, "stats.json: "));
        sc_history_clear(&history);
    }
    sc_free(text);
    unlink("stats.json");
    unlink("frames.csv");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bottleneck_is_where_the_time_went),
        cmocka_unit_test(a_trace_keeps_what_it_has_room_for),
        cmocka_unit_test(earlier_runs_keep_what_they_measured),
        cmocka_unit_test(damaged_statistics_are_left_out),
    };

    return RUN(tests);
}
