/* SPDX-License-Identifier: BSD-3-Clause */
/* What segcast plan computes from what it has measured: wall time, memory and disk. */
#include "check.h"

#include "plan/plan.h"
#include "render/run.h"

#include <math.h>

/* A job of 20 GOPs of 30 frames of 1920 x 1080. */
static sc_job long_job(void)
{
    sc_job job = {.output = {.video = "v.mp4", .size_px = {1920, 1080}, .fps = 30},
                  .animation = {.frames = 600}};

    return job;
}

/* A frame takes 2 CPU seconds to draw and 0.1 to encode. */
static const sc_plan_probe probe = {
    .prepare_cpu_s = 8,
    .prepare_wall_s = 3,
    .draw_cpu_s = 2,
    .partly_drawn = 12,
    .encoded = 60,
    .first = {0.2, 0.1, 100000},
    .next = {0.1, 0.06, 10000},
    .encoder_bytes = 300 << 20,
    .program_bytes = 30 << 20,
    .prepare_bytes = 500 << 20,
    .prepared_bytes = 100 << 20,
    .derived_bytes = 30 << 20,
    .loaded_bytes = 60 << 20, /* less than all phases: the others are in files */
    .renderer_bytes = 10 << 20,
    .job_bytes = 1000};

TEST(a_node_draws_and_encodes_with_all_cores)
{
    const sc_job job = long_job();
    const sc_plan_run run = sc_plan_run_on(&job, &probe, 1, 1, 8, 0);

    assert_int_equal(run.threads, 8);
    assert_int_equal(run.gops, 0);
    assert_near(sc_plan_encode_cpu_s(&job, &probe), 20 * 0.2 + 580 * 0.1, 1e-9);
    assert_near(run.prepare_s, 3, 1e-9);
    assert_near(run.draw_s, (1200 + 62) / 8.0, 1e-9);
    assert_near(run.encode_s, 20 * 0.1 + 580 * 0.06, 1e-9);
    assert_near(run.wall_s, 3 + (1200 + 62) / 8.0, 1e-9);
    assert_string_equal(run.limit, "drawing");
}

TEST(what_limits_depends_on_the_nodes_and_on_who_encodes)
{
    sc_job job = long_job();
    sc_plan_run run;

    job.farm.encode = SC_ENCODE_ROOT;
    run = sc_plan_run_on(&job, &probe, 8, 1, 8, 0);
    assert_int_equal(run.gops, 0);
    assert_string_equal(run.limit, "encoding"); /* rank 0 needs 36.8 s, the others 20 */
    assert_near(run.wall_s, 3 + 36.8, 1e-9);
    job.farm.encode = SC_ENCODE_SEGMENTS;
    run = sc_plan_run_on(&job, &probe, 8, 1, 8, 0);
    assert_int_equal(run.gops, sc_handout_gops(20, 8, true));
    assert_string_equal(run.limit, "drawing");
    job.farm.encode = SC_ENCODE_AUTO;
    assert_int_equal(sc_plan_run_on(&job, &probe, 6, 1, 8, 0).gops, sc_handout_gops(20, 6, false));
    run = sc_plan_run_on(&job, &probe, 1000, 1, 8, 0);
    assert_int_equal(run.gops, 19); /* too few GOPs for so many ranks: they are gathered */
    assert_true(run.gather);
    job.farm.encode = SC_ENCODE_GATHER;
    run = sc_plan_run_on(&job, &probe, 2, 1, 8, 0);
    assert_int_equal(run.gops, 19);
    assert_true(run.gather);
    job.animation.frames = 590; /* the last GOP, which is shorter, is not gathered */
    assert_int_equal(sc_plan_run_on(&job, &probe, 2, 1, 8, 0).gops, 18);
    assert_int_equal(sc_plan_run_on(&job, &probe, 1, 1, 8, 0).gops, 0);
    job.output.video[0] = '\0';
    strcpy(job.output.video, "none");
    assert_int_equal(sc_plan_run_on(&job, &probe, 6, 1, 8, 0).gops, 0);
}

TEST(threads_of_a_rank_are_its_share_of_the_cores)
{
    const sc_job job = long_job();

    assert_int_equal(sc_plan_run_on(&job, &probe, 2, 3, 8, 0).threads, 2);
    assert_int_equal(sc_plan_run_on(&job, &probe, 2, 16, 8, 0).threads, 1);
    assert_int_equal(sc_plan_run_on(&job, &probe, 2, 1, 8, 3).threads, 3);
    /* cores without a thread do nothing, and more threads than cores do not help */
    assert_near(sc_plan_run_on(&job, &probe, 1, 1, 8, 4).draw_s, (1200 + 62) / 4.0, 1e-9);
    assert_near(sc_plan_run_on(&job, &probe, 1, 16, 8, 0).draw_s,
                sc_plan_run_on(&job, &probe, 1, 8, 8, 0).draw_s, 1e-9);
}

TEST(more_nodes_are_never_slower_where_ranks_encode)
{
    sc_job job = long_job();
    double before_s = 1e9;

    job.farm.encode = SC_ENCODE_SEGMENTS;
    for (int nodes = 1; nodes <= 16; nodes++) {
        const sc_plan_run run = sc_plan_run_on(&job, &probe, nodes, 2, 8, 0);

        assert_true(run.wall_s <= before_s + 1e-9);
        before_s = run.wall_s;
    }
}

TEST(memory_is_that_of_the_farm_and_of_the_encoders)
{
    sc_job job = long_job();
    const size_t frame = (size_t)1920 * 1080 * 3;
    const uint64_t rank = probe.program_bytes + probe.renderer_bytes;
    const uint64_t node = probe.loaded_bytes; /* held once on a node, however many ranks it has */
    sc_farm farm = {.width_px = 1920,
                    .height_px = 1080,
                    .frame_count = 600,
                    .gop_frames = 30,
                    .total_frames = 600};
    sc_farm_memory memory = sc_farm_memory_of(&farm, 4);
    sc_plan_run run;

    job.farm.encode = SC_ENCODE_ROOT;
    run = sc_plan_run_on(&job, &probe, 2, 2, 8, 0);
    assert_int_equal(run.first_node_bytes, node + 2 * rank + memory.window + memory.root +
                                               memory.worker + probe.encoder_bytes);
    assert_int_equal(run.other_node_bytes, node + 2 * (rank + memory.worker));
    job.farm.encode = SC_ENCODE_SEGMENTS; /* every rank has an encoder, a frame and a GOP */
    run = sc_plan_run_on(&job, &probe, 2, 2, 8, 0);
    assert_true(run.other_node_bytes >=
                node + 2 * (rank + memory.worker + frame + probe.encoder_bytes));
    job.farm.encode = SC_ENCODE_GATHER; /* on each node a rank has an encoder and more than a GOP */
    run = sc_plan_run_on(&job, &probe, 2, 2, 8, 0);
    assert_true(run.other_node_bytes >=
                node + 2 * (rank + memory.worker) + 30 * frame + probe.encoder_bytes);
    assert_true(run.other_node_bytes <
                node + 2 * (rank + memory.worker) + 3 * (40 * frame + probe.encoder_bytes));
}

TEST(segments_and_partial_gops_need_room_beside_the_video)
{
    sc_job job = long_job();
    const sc_plan_disk disk = sc_plan_disk_of(&job, &probe, 8);
    sc_plan_disk png, small;
    sc_plan_probe with_png = probe;

    assert_int_equal(disk.video, 20 * 100000 + 580 * 10000);
    assert_int_equal(disk.frames, 0);
    assert_int_equal(disk.end, disk.video + disk.records);
    assert_int_equal(disk.peak, disk.end + 30 * (1920 * 1080 * 3 / 2 + 48));
    job.output.frames = SC_FRAMES_PNG;
    with_png.png = (sc_plan_cost){0.05, 0.05, 1000000};
    png = sc_plan_disk_of(&job, &with_png, 8);
    assert_int_equal(png.frames, 600000000);
    assert_int_equal(png.video, disk.video);
    assert_true(png.records > disk.records);
    assert_near(sc_plan_encode_cpu_s(&job, &with_png), 62 + 600 * 0.05, 1e-9);
    job.output.frames = SC_FRAMES_NONE;
    job.output.size_px[0] = job.output.size_px[1] =
        16; /* the segments are more than a partial GOP */
    small = sc_plan_disk_of(&job, &probe, 8);
    assert_int_equal(small.peak, small.end + disk.video);
    assert_true(small.records < disk.records); /* so are the pictures of the report */
}

TEST(a_simulated_run_agrees_with_the_sum_where_nothing_waits)
{
    const sc_job job = long_job();
    const sc_unit_costs costs = sc_unit_costs_assumed();

    for (int nodes = 1; nodes <= 4; nodes *= 2) {
        const sc_plan_run sum = sc_plan_run_on(&job, &probe, nodes, 1, 8, 0);
        sc_plan_run run = sum;

        assert_ok(sc_plan_simulate(&quiet, &job, &probe, &costs, 8, &run));
        assert_true(run.wall_s >= sum.draw_s + sum.prepare_s - 1e-6);
        assert_true(run.wall_s < 1.1 * sum.wall_s + 2); /* messages, the network, starting */
        assert_near(run.efficiency, 1262 / (8 * nodes * run.wall_s), 1e-6);
        assert_string_equal(run.limit, "drawing");
    }
}

TEST(costs_follow_the_places_that_were_measured)
{
    const sc_unit_costs costs = sc_unit_costs_assumed();
    sc_plan_probe equal = probe, varied;
    sc_job job = long_job();
    sc_plan_run even, uneven;

    strcpy(job.output.video, "none");
    job.farm.partition = SC_PARTITION_FRAMES;
    job.animation.frames = 48;
    equal.first = equal.next = (sc_plan_cost){0};
    varied = equal;
    uneven = even = sc_plan_run_on(&job, &equal, 16, 1, 1, 0);
    for (int i = 0; i < 12; i++)
        varied.place_cpu_s[i] = i == 11 ? 12 : 1; /* the mean stays that of draw_cpu_s, 2 s */
    assert_ok(sc_plan_simulate(&quiet, &job, &equal, &costs, 1, &even));
    assert_ok(sc_plan_simulate(&quiet, &job, &varied, &costs, 1, &uneven));
    assert_true(uneven.wall_s > even.wall_s + 4); /* a frame of 12 s comes last */
}

TEST(the_table_of_nodes_has_the_best_ways_and_says_where_they_stop_to_pay)
{
    const sc_unit_costs costs = sc_unit_costs_assumed();
    sc_plan_nodes nodes = {.most = 64, .cores = 8, .memory_bytes = (uint64_t)64 << 30};
    sc_job job = long_job();
    sc_plan_scale scale, poor;

    assert_ok(sc_plan_scale_to(&quiet, &job, &probe, &costs, &nodes, &scale));
    assert_int_equal(scale.count, 7);
    for (int i = 0; i < scale.count; i++) {
        const sc_plan_row *row = &scale.rows[i];

        assert_int_equal(row->run.nodes, 1 << i);
        assert_true(row->run.ranks * row->run.threads <= 8);
        assert_near(row->core_hours, row->run.wall_s * row->run.nodes * 8 / 3600, 1e-9);
        assert_true(i == 0 || row->run.wall_s < 1.1 * row[-1].run.wall_s);
    }
    assert_true(scale.pays_to >= 8 && scale.pays_to < 64);
    nodes.memory_bytes =
        scale.rows[0].run.first_node_bytes / 2; /* one rank is tried all the same */
    assert_ok(sc_plan_scale_to(&quiet, &job, &probe, &costs, &nodes, &poor));
    for (int i = 0; i < poor.count; i++)
        assert_int_equal(poor.rows[i].run.ranks, 1);
    nodes.ranks = 2;
    nodes.threads = 3;
    job.farm.encode = SC_ENCODE_ROOT;
    assert_ok(sc_plan_scale_to(&quiet, &job, &probe, &costs, &nodes, &scale));
    for (int i = 0; i < scale.count; i++) {
        assert_int_equal(scale.rows[i].run.ranks, 2);
        assert_int_equal(scale.rows[i].run.threads, 3);
        assert_int_equal(scale.rows[i].encode, SC_ENCODE_ROOT);
    }
}

/* With auto, GOPs are not gathered where their encoders have too little memory; and never more at a
 * time than the nodes have memory for. */
TEST(gathering_needs_memory)
{
    sc_job job = {.output = {.size_px = {3840, 2160}, .fps = 30, .crf = 18},
                  .animation.frames = 1800,
                  .farm.encode = SC_ENCODE_AUTO};
    const uint64_t each = (uint64_t)ceil(sc_run_gathering_bytes(&job, 59, 1000));
    const sc_run_ranks any = {.ranks = 1000, .nodes = 1};
    const sc_run_ranks two = {.ranks = 1000, .nodes = 1, .memory_max_bytes = 2 * each};
    const sc_run_ranks few = {.ranks = 1000, .nodes = 1, .memory_max_bytes = 2 * each - 2};
    const sc_run_ranks nodes = {.ranks = 1000, .nodes = 2, .memory_max_bytes = 2 * each - 2};
    const sc_run_ranks many = {.ranks = 1000, .nodes = 3, .memory_max_bytes = 7 * each};

    assert_true(each > 60ull * 3840 * 2160 * 3); /* the frames of two GOPs, and an encoder */
    assert_true(sc_run_gathering_bytes(&job, 0, 1000) == 0);
    assert_true(sc_run_encoding_of(&job, 60, 60, &any).gather);
    assert_int_equal(sc_run_encoding_of(&job, 60, 60, &any).encoders_most, 0);
    assert_true(sc_run_encoding_of(&job, 60, 60, &two).gather); /* groups of one GOP overlap */
    assert_int_equal(sc_run_encoding_of(&job, 60, 60, &two).encoders_most, 1);
    assert_false(sc_run_encoding_of(&job, 60, 60, &few).gather);
    assert_true(sc_run_encoding_of(&job, 60, 60, &nodes).gather); /* one on each */
    assert_int_equal(sc_run_encoding_of(&job, 60, 60, &nodes).encoders_most, 1);
    assert_int_equal(sc_run_encoding_of(&job, 60, 60, &many).encoders_most, 10);
    job.farm.encode = SC_ENCODE_GATHER; /* is refused instead, when it runs */
    assert_true(sc_run_encoding_of(&job, 60, 60, &few).gather);
}

RUN_TESTS(NULL, NULL)
