/* SPDX-License-Identifier: BSD-3-Clause */
/* The bottleneck of a run, the trace, and the statistics of several runs on one job. */
#include "check.h"

#include "segcast/study.h"

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

TEST(the_bottleneck_is_where_the_time_went)
{
    sc_rank_record ranks[RANKS];
    sc_run_record run;

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

    balanced(ranks, &run); /* two threads each that drew for 90 %, then for half of the time */
    for (int share = 90; share >= 50; share -= 40) {
        for (int i = 0; i < RANKS; i++) {
            ranks[i].threads = 2;
            ranks[i].phases[SC_PHASE_RENDER].cpu_s = 2 * 98 * share / 100.0;
        }
        assert_int_equal(sc_run_bottleneck(&run),
                         share == 90 ? SC_BOTTLENECK_DRAW : SC_BOTTLENECK_CORES);
    }
}

/* Events for which there is no room are only counted. */
TEST(a_trace_keeps_what_it_has_room_for)
{
    sc_trace *trace;

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
    sc_rank_record ranks[3] = {
        {.threads = 3, .cpu_s = 5, .host = "n1"}, {.host = "a \"b\", c"}, {.host = "n1"}};
    sc_frame_result frames[20];
    const sc_run_record run = {.platform = {.version = "1", .host = "n1", .mpi = "MPI \xff 1"},
                               .settings = "{\"render\":{\"samples\":4}}",
                               .id = (uint64_t)begin_unix_s,
                               .ended = count > 0,
                               .job = job,
                               .begin_unix_s = begin_unix_s,
                               .earlier = earlier,
                               .ranks = 3,
                               .nodes = 2,
                               .wall_s = 2.5,
                               .rank_records = ranks,
                               .frames = frames,
                               .frame_count = count};

    for (int i = 0; i < count; i++)
        frames[i] = (sc_frame_result){.frame = first + i,
                                      .rank = i % 3,
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

TEST(earlier_runs_keep_what_they_measured)
{
    SC_OWN(sc_history_clear) sc_history first = {0}, both = {0};

    unlink("stats.json");
    assert_ok(sc_history_read(&listening, "stats.json", &job, &first));
    assert_int_equal(first.run_count, 0);
    write_run(10, 0, 5, &first);
    assert_ok(sc_history_read(&listening, "stats.json", &job, &first));
    assert_int_equal(first.run_count, 1);
    assert_int_equal(first.frame_count, 5);
    write_run(20, 4, 6, &first); /* frames from 4 on are drawn again */
    assert_ok(sc_history_read(&listening, "stats.json", &job, &both));
    assert_int_equal(both.run_count, 2);
    assert_string_equal(both.runs[0].begin, "1970-01-01T00:00:10Z");
    assert_string_equal(both.runs[1].begin, "1970-01-01T00:00:20Z");
    assert_string_equal(both.runs[1].host, "n1");
    assert_int_equal(both.runs[1].frames, 6);
    assert_int_equal(both.runs[1].threads, 3);
    assert_near(both.runs[1].cpu_s, 5, 1e-9);
    assert_string_equal(both.runs[1].mpi, "MPI \xef\xbf\xbd 1");
    assert_string_equal(both.runs[1].commit, "");
    assert_int_equal(both.runs[1].host_count, 2);
    assert_string_equal(both.runs[1].hosts[1], "a \"b\", c");
    for (int i = 0; i < 3; i++)
        assert_int_equal(both.runs[0].rank_hosts[i], i == 1);
    assert_int_equal(both.frame_count, 10);
    for (int i = 0; i < 10; i++) {
        assert_int_equal(both.frames[i].result.frame, i);
        assert_int_equal(both.frames[i].run, i >= 4);
        assert_near(both.frames[i].result.render_cpu_s, i < 4 ? 1 : 2, 1e-9);
        assert_int_equal(both.frames[i].result.hash, 0xabcdef0000000000u + (uint64_t)i);
    }
    assert_int_equal(count_lines("frames.csv"), 11);
    assert_ok(sc_history_read(&listening, "stats.json", &job,
                              &both)); /* reads the same runs again, which adds nothing */
    assert_int_equal(both.run_count, 2);
    assert_int_equal(both.frame_count, 10);
    assert_string_equal(said.text, "");
}

/* @return whether the file has a line that ends with @p ending. */
static bool has_line(const char *path, const char *ending)
{
    FILE *file = fopen(path, "r");
    char line[512];
    bool found = false;

    while (fgets(line, sizeof line, file) && !found) {
        const size_t length = strcspn(line, "\n");

        found = length >= strlen(ending) &&
                !strncmp(line + length - strlen(ending), ending, strlen(ending));
    }
    fclose(file);
    return found;
}

/* A run that was killed stands in the list, because it wrote the file before it drew; its frames
 * are those of which nothing was measured. */
TEST(a_killed_run_is_listed_with_its_frames)
{
    const sc_frame_result drawn[] = {{.frame = 1, .rank = 1, .hash = 7},
                                     {.frame = 6, .rank = 1, .render_cpu_s = 0.5, .hash = 8},
                                     {.frame = 7, .rank = 3, .hash = 9}}; /* there are 3 ranks */
    sc_history history = {0}, read = {0};

    write_run(10, 0, 5, NULL);
    assert_ok(sc_history_read(&quiet, "stats.json", &job, &history));
    write_run(20, 5, 0, &history); /* it is about to draw */
    sc_history_clear(&history);
    assert_ok(sc_history_read(&quiet, "stats.json", &job, &history));
    assert_int_equal(history.run_count, 2);
    assert_true(history.runs[0].ended && !history.runs[1].ended);
    assert_ok(sc_history_add(&quiet, &history, drawn, 3, 1));
    assert_int_equal(history.frame_count, 7);
    assert_true(history.frames[1].measured && history.frames[1].run == 0);
    assert_int_equal(history.frames[5].run, 1);
    assert_int_equal(history.frames[6].run, -1);
    assert_ok(sc_history_add(&quiet, &history, drawn, 3, 0)); /* they are known now */
    assert_int_equal(history.frame_count, 7);
    assert_int_equal(history.frames[5].run, 1);
    assert_int_equal(history.frames[6].run, -1);
    write_run(30, 8, 2, &history);
    assert_ok(sc_history_read(&quiet, "stats.json", &job, &read));
    assert_int_equal(read.run_count, 3);
    assert_int_equal(read.frame_count, 9);
    assert_true(!read.frames[5].measured && read.frames[5].run == 1 &&
                read.frames[5].result.hash == 8);
    assert_near(read.frames[5].result.render_cpu_s, 0.5, 1e-9);
    assert_true(!read.frames[6].measured && read.frames[6].run == -1);
    assert_true(has_line("frames.csv", ",abcdef0000000001,0,\"a \"\"b\"\", c\""));
    assert_true(has_line("frames.csv", "6,1,,0.500000,,,,,0000000000000008,1,\"a \"\"b\"\", c\""));
    assert_true(has_line("frames.csv", "7,3,,0.000000,,,,,0000000000000009,,"));
    assert_true(has_line("frames.csv", ",abcdef0000000008,2,n1"));
    sc_history_clear(&history);
    sc_history_clear(&read);
}

/* What segcast would not have written is refused as a whole: numbers out of range, texts that are
 * too long, ranks and hosts that do not exist. */
TEST(forged_statistics_are_left_out)
{
    static const char *const forged[][2] = {
        {"\"ranks\": 3,\n   \"threads\"", "\"ranks\": 4294967299, \"threads\""},
        {"\"ended\": true", "\"ended\": 1"},
        {"\"farm_wall_s\": 0", "\"farm_wall_s\": -1"},
        {"\"rank_hosts\": [\n    0,\n    1", "\"rank_hosts\": [0, 2"},
        {"\"rank_hosts\": [\n    0,\n    1,", "\"rank_hosts\": [0,"},
        {"\"hosts\": [\n    \"n1\"", "\"hosts\": [7"},
        {"\"rank\": 2", "\"rank\": 3"},
        {"\"rays\": 1000", "\"rays\": -5"},
        {"\"samples\": 0", "\"samples\": null"},
        {"\"run\": 0", "\"run\": null"}, /* it was measured, so the run is known */
        {"\"begin\": \"1970", "\"begin\": \"1\\u0000"},
        {"\"id\": \"0", "\"id\": \"X"}};
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    write_run(10, 0, 5, NULL);
    assert_ok(sc_file_read(&quiet, "stats.json", 100000, &text, &bytes));
    for (size_t i = 0; i < SC_COUNT_OF(forged); i++) {
        const char *at = strstr(strstr(text, "\"runs\""), forged[i][0]);
        SC_OWN(sc_history_clear) sc_history history = {0};
        SC_OWN(sc_text_clear) sc_text changed = {0};
        const sc_ctx *ctx = listening_anew();

        assert_non_null(at);
        assert_ok(sc_text_add(&quiet, &changed, "%.*s%s%s", (int)(at - text), text, forged[i][1],
                              at + strlen(forged[i][0])));
        assert_ok(sc_file_write(&quiet, "stats.json", changed.data, changed.length_bytes));
        assert_ok(sc_history_read(ctx, "stats.json", &job, &history));
        if (history.run_count || !strstr(said.text, "stats.json: is damaged"))
            fail_msg("%s was taken: %s", forged[i][1], said.text);
    }
}

/* Each damaged file gives a warning and adds nothing. */
TEST(damaged_statistics_are_left_out)
{
    const sc_job_hashes other = {0x1235, 0xfedcba9876543210};
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    write_run(10, 0, 5, NULL);
    assert_ok(sc_file_read(&quiet, "stats.json", 100000, &text, &bytes));
    for (int way = 0; way < 5; way++) {
        char *run = strstr(text, "\"run\": 0"), *hash = strstr(text, "\"hash\": \"a");
        SC_OWN(sc_history_clear) sc_history history = {0};
        const sc_ctx *ctx = listening_anew();

        assert_non_null(run);
        assert_non_null(hash);
        run[7] = way == 1 ? '7' : '0'; /* the frame names a run that does not exist */
        hash[9] = way == 2 ? 'x' : 'a';
        assert_ok(sc_file_write(&quiet, "stats.json", way == 4 ? "{}" : text,
                                way == 0   ? bytes / 2
                                : way == 4 ? 2
                                           : bytes));
        assert_ok(sc_history_read(ctx, "stats.json", way == 3 ? &other : &job, &history));
        assert_int_equal(history.run_count, 0);
        assert_int_equal(history.frame_count, 0);
        assert_int_equal(said.errors, 0);
        assert_non_null(strstr(said.text, "stats.json: "));
    }
    unlink("stats.json");
    unlink("frames.csv");
}

/* ---- reading back ---- */

TEST(statistics_are_read_back)
{
    sc_rank_record ranks[2] = {
        {.threads = 3, .cpu_s = 5, .farm_idle_s = 1.5, .accept_wall_s = 2, .peak_rss_bytes = 7000},
        {.threads = 2, .cpu_s = 4, .host = "n2", .peak_rss_bytes = 8000}};
    const sc_frame_result frame = {.rank = 1, .render_cpu_s = 2, .rays = 4000000};
    const sc_run_record run = {.platform = {.version = "1.2", .host = "n1"},
                               .ended = true,
                               .job = job,
                               .ranks = 2,
                               .nodes = 2,
                               .wall_s = 4,
                               .farm_wall_s = 3,
                               .rank_records = ranks,
                               .frames = &frame,
                               .frame_count = 1,
                               .memory = {.volume = 100, .prepared = 200},
                               .wrote_png = true};
    SC_OWN(sc_run_stats_clear) sc_run_stats stats = {0};

    strcpy(ranks[0].host, "n1");
    for (int p = 0; p < SC_PHASE_COUNT; p++)
        ranks[1].phases[p] = (sc_phase_time){p + 1, 10 * p};
    assert_ok(sc_run_write(&quiet, &run, "stats.json", "frames.csv"));
    assert_ok(sc_run_stats_read(&quiet, "stats.json", &stats));
    assert_string_equal(stats.version, "1.2");
    assert_int_equal(stats.run.ranks, 2);
    assert_true(stats.run.ended && stats.run.wrote_png && !stats.run.from_prepared);
    assert_memory_equal(stats.ranks, ranks, sizeof ranks);
    assert_int_equal(stats.run.memory.prepared, 200);
    assert_int_equal(stats.run.frame_count, 1);
    assert_int_equal(stats.history.frame_count, 1);
    assert_near(stats.frames_per_s, 0.25, 1e-9);
    assert_int_equal(sc_run_bottleneck(&stats.run), sc_run_bottleneck(&run));
    assert_int_equal(stats.heat.width_px, 0);
}

/* Counts keep their size within 3 percent, and 0 and the largest are told apart from all others. */
TEST(heat_codes_keep_counts)
{
    uint8_t last = 0;

    assert_int_equal(sc_heat_code(0), 0);
    assert_int_equal(sc_heat_code(1), 1);
    assert_int_equal(sc_heat_code(UINT64_MAX), 255);
    assert_near(sc_heat_count(0), 0, 0);
    for (uint64_t count = 1; count < 50000; count += 1 + count / 50) {
        const uint8_t code = sc_heat_code(count);

        assert_true(code >= last && code < 255);
        assert_near(sc_heat_count(code) / (double)count, 1, 0.03);
        last = code;
    }
}

/* A heat picture is read back, and a damaged one is refused; statistics without one are whole. */
TEST(heat_is_read_back)
{
    const char *const edits[] = {"\"width\": 3",  "\"width\": 4", "\"01ff80\"", "\"01ff8\"",
                                 "\"01ff80\"",    "\"01fg80\"",   "\"01ff80\"", "\"01ff8000\"",
                                 "\"height\": 2", "\"height\": 0"};
    sc_rank_record rank = {.threads = 1, .host = "n1"};
    SC_OWN(sc_heat_clear) sc_heat heat = {0};
    const sc_run_record run = {.platform = {.version = "1", .host = "n1"},
                               .job = job,
                               .ranks = 1,
                               .nodes = 1,
                               .rank_records = &rank,
                               .heat = &heat};
    sc_run_stats stats = {0};
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    assert_ok(sc_heat_new(&quiet, 3, 2, &heat));
    heat.frame = 7;
    heat.cpu_s = 0.5;
    memcpy(heat.codes[SC_HEAT_SAMPLES], "\x00\x00\x05\x01\xff\x80", 6);
    heat.codes[SC_HEAT_CONTRIBUTIONS][4] = 9;
    assert_ok(sc_run_write(&quiet, &run, "stats.json", "frames.csv"));
    assert_ok(sc_run_stats_read(&quiet, "stats.json", &stats));
    assert_int_equal(stats.heat.frame, 7);
    assert_int_equal(stats.heat.width_px, 3);
    assert_int_equal(stats.heat.height_px, 2);
    for (int i = 0; i < SC_HEAT_KINDS; i++)
        assert_memory_equal(stats.heat.codes[i], heat.codes[i], 6);
    sc_run_stats_clear(&stats);
    assert_ok(sc_file_read(&quiet, "stats.json", 1 << 20, &text, &bytes));
    for (size_t i = 0; i < SC_COUNT_OF(edits); i += 2) {
        char *at = strstr(text, edits[i]);
        FILE *file = fopen("damaged.json", "wb");

        assert_non_null(at);
        fprintf(file, "%.*s%s%s", (int)(at - text), text, edits[i + 1], at + strlen(edits[i]));
        fclose(file);
        assert_int_equal(sc_run_stats_read(&quiet, "damaged.json", &stats), SC_ERR_DATA);
    }
    unlink("damaged.json");
}

/* Whatever byte of the file is another one, or where it ends: it is read or refused. */
TEST(damaged_statistics_are_refused)
{
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;
    int refused = 0;

    write_run(10, 0, 2, NULL);
    assert_ok(sc_file_read(&quiet, "stats.json", 1 << 20, &text, &bytes));
    for (size_t at = 0; at < bytes; at += 3) {
        const char was = text[at];
        SC_OWN(sc_run_stats_clear) sc_run_stats stats = {0};
        FILE *file = fopen("damaged.json", "wb");

        text[at] = at % 2 ? '7' : '"';
        fwrite(text, 1, at % 7 ? bytes : at, file);
        fclose(file);
        text[at] = was;
        refused += sc_run_stats_read(&quiet, "damaged.json", &stats) == SC_ERR_DATA;
    }
    assert_true(refused > 100);
    unlink("damaged.json");
    {
        sc_run_stats stats = {0};

        assert_int_equal(sc_run_stats_read(&quiet, "nowhere.json", &stats), SC_ERR_MISSING);
    }
}

/* Events that were read, for read_event. */
typedef struct read_events {
    sc_trace_event events[4];
    int ranks[4], count;
} read_events;

static void read_event(void *user, int rank, const sc_trace_event *event)
{
    read_events *r = user;

    assert_true(r->count < 4);
    r->ranks[r->count] = rank;
    r->events[r->count++] = *event;
}

TEST(a_trace_is_read_back)
{
    const sc_rank_record ranks[2] = {{.threads = 2, .host = "a \"b\" <c>"}, {.threads = 1}};
    const sc_trace_event events[4] = {
        {.begin_s = 0, .duration_s = 1, .frame = -1, .kind = SC_TRACE_READ},
        {1, 0.5, 7, SC_TRACE_DRAW, 1},
        {2, 0.25, 8, SC_TRACE_ENCODE, 1}};
    const size_t counts[2] = {2, 1};
    static const char *const damaged[] = {
        "{\"traceEvents\":[\n{\"ph\":\"X\"}\n]}\n",
        "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n{\"ph\":\"X\",\"pid\":0,\"tid\":1,\"ts\":1,"
        "\"dur\":1,\"name\":\"draw 1\"}\n]}\n",
        "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n{\"ph\":\"X\",\"pid\":1,\"tid\":1,\"ts\":1,"
        "\"dur\":1,\"name\":\"drawn 1\"}\n]}\n",
        "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n", ""};
    read_events found = {.count = 0};

    assert_ok(sc_trace_write(&quiet, "trace.json", 2, ranks, events, counts, 2));
    assert_ok(sc_trace_read(&quiet, "trace.json", read_event, &found));
    assert_int_equal(found.count, 3);
    assert_int_equal(found.ranks[1], 0);
    assert_int_equal(found.ranks[2], 1);
    for (int i = 0; i < 3; i++) {
        assert_near(found.events[i].begin_s, events[i].begin_s, 1e-6);
        assert_near(found.events[i].duration_s, events[i].duration_s, 1e-6);
        assert_int_equal(found.events[i].frame, events[i].frame);
        assert_int_equal(found.events[i].kind, events[i].kind);
        assert_int_equal(found.events[i].thread, events[i].thread);
    }
    for (size_t i = 0; i < SC_COUNT_OF(damaged); i++) {
        assert_ok(sc_file_write(&quiet, "trace.json", damaged[i], strlen(damaged[i])));
        assert_int_equal(sc_trace_read(&quiet, "trace.json", read_event, &found), SC_ERR_DATA);
    }
    assert_int_equal(sc_trace_read(&quiet, ".", read_event, &found), SC_ERR_MISSING);
    unlink("trace.json");
    assert_int_equal(sc_trace_read(&quiet, "trace.json", read_event, &found), SC_ERR_MISSING);
}

RUN_TESTS(NULL, NULL)
