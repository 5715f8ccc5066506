/* SPDX-License-Identifier: BSD-3-Clause */
/* The measurements of a study: what is written is read back, damage is told, and the results of
 * cells are those of known times. */
#include "check.h"

#include "segcast/core_time.h"
#include "segcast/measurements.h"

#include <unistd.h>

static char *methods[] = {"none", "leap, \"fast\""}, *ranks[] = {"1", "2", "4"};
static sc_design_axis axes[] = {{"render.skip", methods, 2}, {"ranks", ranks, 3}};
static const sc_design design = {"a study", 0x1234, axes, 2, .by_wall = true};
static const sc_study_run run = {.begin = "2026-01-01T00:00:00Z",
                                 .host = "node\xff",
                                 .processor = "one",
                                 .kernel = "avx2",
                                 .ranks = 4,
                                 .nodes = 1,
                                 .cores = 4};

/* A measurement of @p cell that took @p wall_s on so many ranks. */
static sc_measurement measured(int cell, double wall_s, double cpu_s)
{
    return (sc_measurement){.cell = cell,
                            .passes = 3,
                            .frames = 4,
                            .ranks = 1 << cell % 3,
                            .nodes = 1,
                            .threads = 1,
                            .wall_s = wall_s,
                            .cpu_s = cpu_s,
                            .draw = {.most_s = 3, .mean_s = 2},
                            .work = {.rays = 2000000, .samples = 9000000},
                            .energy_j = -1,
                            .pixels_hash = 0xfedcba9876543210u};
}

static void write_file(const char *path)
{
    sc_measurement_file *file;
    sc_measurement m = measured(1, 2.5, 5);

    unlink(path);
    assert_ok(sc_measurement_file_create(&quiet, path, &design, &run, &file));
    assert_ok(sc_measurement_file_skip(&quiet, file, 2, "needs 4 ranks"));
    assert_ok(sc_measurement_file_skip(&quiet, file, 1, "for now"));
    assert_ok(sc_measurement_file_add(&quiet, file, &m));
    assert_ok(sc_measurement_file_complete(&quiet, file));
    sc_measurement_file_close(file);
}

TEST(what_is_written_is_read)
{
    const sc_measurement m = measured(1, 2.5, 5);
    SC_OWN(sc_measurements_clear) sc_measurements all = {0};
    uint64_t whole;

    write_file("m.jsonl");
    assert_ok(sc_measurements_read(&quiet, "m.jsonl", &all, &whole));
    assert_int_equal(all.count, 1);
    assert_memory_equal(&all.items[0], &m, offsetof(sc_measurement, threads) + sizeof m.threads);
    assert_memory_equal(&all.items[0].begin_unix_s, &m.begin_unix_s,
                        sizeof m - offsetof(sc_measurement, begin_unix_s)); /* there is a gap */
    assert_int_equal(all.skipped_count, 1); /* cell 1 was measured later */
    assert_int_equal(all.skipped[0].cell, 2);
    assert_string_equal(all.skipped[0].reason, "needs 4 ranks");
    assert_int_equal(all.design.axis_count, 2);
    assert_string_equal(all.design.axes[0].values[1], "leap, \"fast\"");
    assert_int_equal(all.design.hash, 0x1234);
    assert_true(all.design.by_wall && !all.design.whole_jobs);
    assert_int_equal(all.run_count, 1);
    assert_string_equal(all.runs[0].kernel, "avx2");
    assert_true(all.complete);
    unlink("m.jsonl");
}

/* A line that was not finished is left out, and overwritten when the study goes on; two processes
 * cannot write to one file. */
TEST(a_killed_study_goes_on)
{
    const sc_measurement m = measured(5, 1, 4);
    sc_measurement_file *file, *second = NULL;
    sc_measurements all;
    uint64_t whole, grown;
    FILE *stream;

    write_file("m.jsonl");
    assert_ok(sc_measurements_read(&quiet, "m.jsonl", &all, &whole));
    sc_measurements_clear(&all);
    stream = fopen("m.jsonl", "a");
    fputs("{\"measurement\":{\"cell\":1,", stream);
    fclose(stream);
    assert_ok(sc_measurements_read(&quiet, "m.jsonl", &all, &grown));
    assert_int_equal(grown, whole);
    sc_measurements_clear(&all);
    assert_ok(sc_measurement_file_resume(&quiet, "m.jsonl", whole, &run, &file));
    assert_int_equal(sc_measurement_file_resume(&listening, "m.jsonl", whole, &run, &second),
                     SC_ERR_CREATE);
    assert_non_null(strstr(said.text, "another segcast study"));
    assert_ok(sc_measurement_file_add(&quiet, file, &m));
    sc_measurement_file_close(file);
    assert_ok(sc_measurements_read(&quiet, "m.jsonl", &all, &whole));
    assert_int_equal(all.count, 2);
    assert_int_equal(all.run_count, 2);
    assert_false(all.complete); /* of the earlier run only */
    sc_measurements_clear(&all);
    assert_int_equal(sc_measurement_file_create(&listening, "m.jsonl", &design, &run, &file),
                     SC_ERR_CREATE);
    unlink("m.jsonl");
}

static void refuses(const char *text, const char *message)
{
    FILE *stream = fopen("bad.jsonl", "w");
    const sc_ctx *ctx = listening_anew();
    sc_measurements all;
    uint64_t whole;

    fputs(text, stream);
    fclose(stream);
    assert_int_equal(sc_measurements_read(ctx, "bad.jsonl", &all, &whole), SC_ERR_DATA);
    if (!strstr(said.text, message))
        fail_msg("\"%s\"; expected \"%s\"", said.text, message);
    unlink("bad.jsonl");
}

#define HEAD                                                                                       \
    "{\"schema\":\"segcast-study-1\",\"study\":\"0000000000000001\",\"title\":\"\",\"axes\":"
TEST(damage_is_told)
{
    refuses("", "holds no line");
    refuses("{}\n", "bad.jsonl:1: this is not the first line");
    refuses("nonsense\n", "bad.jsonl:1");
    refuses(HEAD "[{\"name\":\"a\",\"values\":[]}]}\n", "bad.jsonl:1");
    refuses(HEAD "[{\"name\":\"a\\u0000b\",\"values\":[\"1\"]}]}\n", "bad.jsonl:1");
    refuses(HEAD "[]}\n{\"measurement\":{\"cell\":0}}\n", "bad.jsonl:2: this is no line");
    refuses(HEAD "[]}\n{\"skipped\":{\"cell\":1,\"reason\":\"\"}}\n", "bad.jsonl:2");
    refuses(HEAD "[]}\n{\"run\":{\"ranks\":0}}\n", "bad.jsonl:2");
}

/* Weak scaling: four ranks draw four times as many rays in the time of one. */
TEST(more_work_for_more_ranks)
{
    SC_OWN(sc_measurements_clear) sc_measurements all = {.design = design};
    sc_measurement one = measured(0, 8, 8), four = measured(2, 10, 40);
    SC_OWN(sc_free_at) sc_cell_result *results = NULL;

    four.work.rays = 4 * one.work.rays;
    assert_ok(sc_measurements_append(&quiet, &all, &one));
    assert_ok(sc_measurements_append(&quiet, &all, &four));
    assert_ok(sc_cell_results(&quiet, &all, &results));
    assert_near(results[2].speedup, 3.2, 1e-12);
    assert_near(results[2].efficiency, 0.8, 1e-12);
    assert_near(results[2].cost, 1.25, 1e-12);
    all.design = (sc_design){0};
}

TEST(results_of_known_times)
{
    SC_OWN(sc_measurements_clear) sc_measurements all = {.design = design};
    SC_OWN(sc_free_at) sc_cell_result *results = NULL;
    const double wall_s[2][3] = {{8, 4, 0}, {4, 3, 2}}; /* cell 2 has none */

    for (int method = 0; method < 2; method++) {
        for (int r = 0; r < 3; r++) {
            for (int i = -3; i <= 3 && wall_s[method][r] > 0; i++) {
                const sc_measurement m =
                    measured(3 * method + r, wall_s[method][r] + 0.1 * i, wall_s[method][r]);

                assert_ok(sc_measurements_append(&quiet, &all, &m));
            }
        }
    }
    assert_ok(sc_measurements_skip(&quiet, &all, 2, "needs 4 ranks"));
    assert_ok(sc_cell_results(&quiet, &all, &results));
    assert_int_equal(results[1].base, 0);
    assert_int_equal(results[5].base, 3);
    assert_near(results[1].speedup, 2, 1e-12);
    assert_near(results[1].efficiency, 1, 1e-12);
    assert_near(results[1].serial_share, 0, 1e-12);
    assert_near(results[5].speedup, 2, 1e-12);
    assert_near(results[5].efficiency, 0.5, 1e-12);
    assert_near(results[5].serial_share, 1.0 / 3, 1e-12);
    assert_near(results[5].cost, 0.5, 1e-12);
    assert_near(results[0].frames_per_s, 0.5, 1e-12);
    assert_near(results[0].mrays_per_cpu_s, 0.25, 1e-12);
    assert_near(results[0].samples_per_ray, 4.5, 1e-12);
    assert_near(results[0].imbalance, 0.5, 1e-12);
    assert_string_equal(results[2].skipped, "needs 4 ranks");
    assert_null(results[0].skipped);
    assert_near(results[2].speedup, 0, 0);
    all.design = (sc_design){0}; /* static */
}

/* The whole content of a small file. */
static void read_all(const char *path, char *text, size_t size)
{
    FILE *stream = fopen(path, "r");
    const size_t got = fread(text, 1, size - 1, stream);

    text[got] = '\0';
    fclose(stream);
}

TEST(tables_can_be_read_elsewhere)
{
    SC_OWN(sc_measurements_clear) sc_measurements all = {.design = design};
    const sc_measurement m = measured(4, 2, 3);
    SC_OWN(sc_free_at) sc_cell_result *results = NULL;
    char text[8192];

    assert_ok(sc_measurements_append(&quiet, &all, &m));
    assert_ok(sc_cell_results(&quiet, &all, &results));
    assert_ok(sc_cells_write_csv(&quiet, &all, results, "cells.csv"));
    read_all("cells.csv", text, sizeof text);
    assert_non_null(strstr(text, "\"render.skip\",\"ranks\",state,"));
    assert_non_null(strstr(text, "\"leap, \"\"fast\"\"\",\"2\",\"measured\",1,4,2,1,1,3,"));
    assert_non_null(strstr(text, "\"none\",\"1\",\"not measured yet\",0,"));
    assert_ok(sc_cells_write_extrap(&quiet, &all, "extrap.jsonl"));
    read_all("extrap.jsonl", text, sizeof text);
    assert_string_equal(text, "{\"params\":{\"ranks\":2.0},\"callpath\":\"study->render.skip=leap, "
                              "\\\"fast\\\"\",\"metric\":\"wall_s\",\"value\":2.0}\n"
                              "{\"params\":{\"ranks\":2.0},\"callpath\":\"study->render.skip=leap, "
                              "\\\"fast\\\"\",\"metric\":\"cpu_s\",\"value\":3.0}\n");
    all.design = (sc_design){0};
    unlink("cells.csv");
    unlink("extrap.jsonl");
}

TEST(other_pixels_are_found)
{
    const uint64_t pictures[] = {1, 1, 2, 1, 2, 2};
    SC_OWN(sc_measurements_clear) sc_measurements all = {.design = design};
    sc_measurement a = measured(0, 1, 1), b = measured(2, 1, 1), c = measured(3, 1, 1);
    int other = -1;

    b.pixels_hash++; /* of another picture */
    assert_ok(sc_measurements_append(&quiet, &all, &a));
    assert_ok(sc_measurements_append(&quiet, &all, &b));
    assert_ok(sc_measurements_append(&quiet, &all, &c));
    assert_int_equal(sc_measurements_mismatch(&all, 0, pictures, &other), -1);
    c.pixels_hash--;
    assert_ok(sc_measurements_append(&quiet, &all, &c));
    assert_int_equal(sc_measurements_mismatch(&all, 3, pictures, &other), 3);
    assert_int_equal(other, 0);
    all.design = (sc_design){0};
}

/* The time of cores is split without a rest: drawing, waiting for work, and threads that waited. */
TEST(core_time_adds_up)
{
    const sc_measurement m = {.ranks = 2,
                              .threads = 4,
                              .wall_s = 10,
                              .cpu_s = 60,
                              .draw = {.cpu_s = 40, .mean_s = 7},
                              .idle_mean_s = 1,
                              .start = {.read_s = 0.5, .prepare_s = 1, .cpu_s = 10}};
    const sc_core_time frames = sc_measurement_core_time(&m, false);
    const sc_core_time job = sc_measurement_core_time(&m, true);
    sc_rank_record both[2] = {{.threads = 2, .farm_idle_s = 1}, {.threads = 2, .farm_idle_s = 2}};
    const sc_run_record record = {.ranks = 2, .wall_s = 10, .rank_records = both};
    sc_core_time c;
    double sum = 0;

    assert_near(frames.core_s, 80, 1e-12);
    assert_near(frames.causes_s[SC_CAUSE_DRAW], 40, 1e-12);
    assert_near(frames.causes_s[SC_CAUSE_IDLE], 8, 1e-12);
    assert_near(frames.causes_s[SC_CAUSE_THREADS], 16, 1e-12); /* 7 s x 8 cores, less drawing */
    assert_near(frames.causes_s[SC_CAUSE_OTHER], 16, 1e-12);
    assert_near(job.causes_s[SC_CAUSE_READ], 4, 1e-12);
    assert_near(job.causes_s[SC_CAUSE_PREPARE], 8, 1e-12);
    assert_near(job.causes_s[SC_CAUSE_ENCODE], 10, 1e-12);
    assert_near(job.causes_s[SC_CAUSE_THREADS], 6, 1e-12);
    assert_near(job.causes_s[SC_CAUSE_OTHER], 4, 1e-12);

    both[0].phases[SC_PHASE_PREPARE] = (sc_phase_time){2, 3};
    both[0].phases[SC_PHASE_RENDER] = (sc_phase_time){6, 10};
    both[0].phases[SC_PHASE_ENCODE] = (sc_phase_time){3, 1};
    both[1].phases[SC_PHASE_IDLE] = (sc_phase_time){4, 0}; /* 2 s before the farm, 2 s in it */
    both[1].phases[SC_PHASE_RENDER] = (sc_phase_time){6, 12};
    c = sc_run_core_time(&record);
    for (int i = 0; i < SC_CAUSE_COUNT; i++)
        sum += c.causes_s[i];
    assert_near(c.core_s, 40, 1e-12);
    assert_near(sum, 40, 1e-12);
    assert_near(c.causes_s[SC_CAUSE_DRAW], 22, 1e-12);
    assert_near(c.causes_s[SC_CAUSE_PREPARE], 4, 1e-12);
    assert_near(c.causes_s[SC_CAUSE_WAIT], 4, 1e-12);
    assert_near(c.causes_s[SC_CAUSE_IDLE], 6, 1e-12);
    assert_near(c.causes_s[SC_CAUSE_THREADS], 1, 1e-12); /* 12 - 10 - 1 */
}

RUN_TESTS(NULL, NULL)
