/* SPDX-License-Identifier: BSD-3-Clause */
/* The simulation of runs, with cases that can be solved by hand. */
#include "check.h"

#include "segcast/simulate.h"

#include <math.h>

enum { FRAMES_MAX = 2000 };

/* A film of @p frames frames of 160 x 120, each of which takes @p cost_s (kept in @p costs). */
static sc_sim_film film_of(int frames, double cost_s, double *costs)
{
    for (int k = 0; k < frames; k++)
        costs[k] = cost_s;
    return (sc_sim_film){.frames = frames,
                         .gop_frames = 10,
                         .width_px = 160,
                         .height_px = 120,
                         .partition = SC_PARTITION_FRAMES,
                         .draw_cpu_s = costs};
}

/* Ranks of one thread, each on a node of its own, where nothing but drawing takes time. */
static sc_sim_machine machine_of(int ranks)
{
    return (sc_sim_machine){.ranks = ranks, .ranks_per_node = 1, .threads = 1, .slow_node = -1};
}

static sc_sim_result simulate(const sc_sim_film *film, const sc_sim_machine *machine)
{
    sc_sim_result result;

    assert_ok(sc_simulate(&quiet, film, machine, &result));
    assert_true(result.held <= result.window);
    return result;
}

TEST(equal_frames_take_their_share)
{
    double costs[FRAMES_MAX];
    const sc_sim_film film = film_of(8, 1, costs);
    sc_sim_machine machine = machine_of(4);
    sc_sim_result r = simulate(&film, &machine);

    assert_near(r.farm_s, 2, 1e-9);
    assert_near(r.wall_s, 2, 1e-9);
    assert_near(r.frames_per_s, 4, 1e-9);
    assert_near(r.efficiency, 1, 1e-9);
    assert_near(r.busy_s.draw, 8, 1e-9);
    assert_int_equal(r.units, 8);
    assert_int_equal(r.limit, SC_SIM_DRAWING);
    machine.threads = 2;
    assert_near(simulate(&film, &machine).farm_s, 1, 1e-9);
    machine = machine_of(3); /* two ranks draw three frames, one draws two */
    r = simulate(&film, &machine);
    assert_near(r.farm_s, 3, 1e-9);
    assert_near(r.end_wait_s, 1, 1e-9);
}

TEST(a_slow_rank_gets_fewer_frames)
{
    double costs[FRAMES_MAX];
    const sc_sim_film film = film_of(6, 1, costs);
    sc_sim_machine machine = machine_of(2);

    machine.slow_node = 1;
    machine.slow_speed = 0.5;
    assert_near(simulate(&film, &machine).farm_s, 4, 1e-9); /* four frames of 1 s, two of 2 s */
    machine.slow_node = 7;                                  /* a node that is not there */
    assert_near(simulate(&film, &machine).farm_s, 3, 1e-9);
}

static double same_cost(int frame)
{
    return 0.4;
}

/* Costs like those of a clip plane that removes the whole heart: they fall from 1.2 s to 0.004 s.
 */
static double falling_cost(int frame)
{
    return frame < 900 ? 1.2 * (1 - frame / 900.0) + 0.004 : 0.004;
}

static double wild_cost(int frame)
{
    uint64_t seed = (uint64_t)frame * 7919 + 1;

    return 0.02 + (double)(random_bits(&seed) % 1000) / 800;
}

/* A film takes no more than 5 % longer than if all ranks ended at the same time, and what the
 * costliest band takes on the slowest rank. @param slow a fifth of the ranks has half of the
 * speed. */
static void check_balance(int ranks, int frames, double (*cost_s)(int), bool slow)
{
    enum { MOST = 12 * 250 + 900 };
    static double costs[MOST];
    sc_sim_film film = film_of(frames, 0, costs);
    sc_sim_machine machine = machine_of(ranks);
    const int slow_ranks = slow ? (ranks + 4) / 5 : 0;
    double sum_s = 0, most_s = 0, ideal_s, band_s;

    assert_true(frames <= MOST);
    for (int k = 0; k < frames; k++) {
        costs[k] = cost_s(k);
        sum_s += costs[k];
        most_s = fmax(most_s, costs[k]);
    }
    film.partition = SC_PARTITION_AUTO;
    machine.ranks_per_node = slow ? slow_ranks : 1;
    machine.slow_node = slow ? 0 : -1;
    machine.slow_speed = 0.5;
    ideal_s = sum_s / (ranks - slow_ranks * (1 - machine.slow_speed));
    band_s = most_s / (slow ? machine.slow_speed : 1) * 16 / film.height_px;
    if (simulate(&film, &machine).farm_s > 1.05 * ideal_s + band_s)
        fail_msg("%d ranks, %d frames: end at %g, %g would be ideal, a band takes %g", ranks,
                 frames, simulate(&film, &machine).farm_s, ideal_s, band_s);
}

TEST(all_ranks_end_within_the_time_of_a_band)
{
    static const int ranks[] = {2, 3, 7, 16, 64, 250};

    for (size_t i = 0; i < SC_COUNT_OF(ranks); i++) {
        for (int slow = 0; slow < 2; slow++) {
            check_balance(ranks[i], 12 * ranks[i], same_cost, slow);
            check_balance(ranks[i], 12 * ranks[i], wild_cost, slow);
            if (!slow || ranks[i] < 100) /* else a slow rank draws its first frame the longest */
                check_balance(ranks[i], 12 * ranks[i] + 900, falling_cost, slow);
        }
    }
}

TEST(the_hand_out_keeps_16384_ranks_busy)
{
    enum { RANKS = 16384 };
    static double costs[4 * RANKS];
    sc_sim_film film = film_of(4 * RANKS, 0, costs);
    const sc_sim_machine machine = machine_of(RANKS);

    for (int k = 0; k < film.frames; k++)
        costs[k] = wild_cost(k);
    film.partition = SC_PARTITION_AUTO;
    assert_true(simulate(&film, &machine).farm_efficiency > 1 / 1.3);
}

/* When rank 0 can hold only a few frames, several ranks draw each of them. */
TEST(large_frames_keep_many_ranks_busy)
{
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(120, 0.4, costs);
    const sc_sim_machine machine = machine_of(300);
    sc_sim_result r;

    film.width_px = 7680;
    film.height_px = 4320;
    film.partition = SC_PARTITION_AUTO;
    r = simulate(&film, &machine);
    assert_true((size_t)r.window * 7680 * 4320 * 3 <= (size_t)(256 + 4 * 300) << 20);
    assert_true(r.farm_efficiency > 1 / 1.25);
}

TEST(a_costly_last_frame_is_waited_for_or_split)
{
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(4, 1, costs);
    const sc_sim_machine machine = machine_of(2);
    sc_sim_result r;

    costs[3] = 12;
    r = simulate(&film, &machine);
    assert_near(r.farm_s, 13, 1e-9); /* behind frame 2 on rank 1 */
    assert_int_equal(r.limit, SC_SIM_UNITS);
    film.partition = SC_PARTITION_TILES; /* bands of 16 rows: the last 120 take 12 s / 120 each */
    r = simulate(&film, &machine);
    assert_true(r.farm_s >= 7.5 && r.farm_s < 7.5 + 2 * 1.6);
    film.band_rows = 4; /* seven bands of 16 rows and one of 8 cost 4 more each */
    assert_near(simulate(&film, &machine).busy_s.draw, 15 * (120 + 8 * 4) / 120.0, 1e-9);
}

TEST(rank_0_encodes_one_frame_after_the_other)
{
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(40, 1, costs);
    sc_sim_machine machine = machine_of(8);
    sc_sim_result r;

    film.encode_wall_s = 0.5; /* by some other device: it needs no core */
    r = simulate(&film, &machine);
    assert_near(r.farm_s, 1 + 40 * 0.5, 1e-9);
    assert_near(r.busy_s.accept, 20, 1e-9);
    assert_int_equal(r.limit, SC_SIM_ENCODING);
    assert_true(r.held > 20);
    film.gops = 4; /* GOPs of ten frames: four ranks draw and encode one each */
    r = simulate(&film, &machine);
    assert_near(r.farm_s, 10 * 1.5, 1e-9);
    assert_int_equal(r.units, 4);
    /* one rank alone: its core draws 40 s and encodes 20 s, which end together or nearly so */
    film.gops = 0;
    film.encode_cpu_s = 0.5;
    machine = machine_of(1);
    r = simulate(&film, &machine);
    assert_true(r.farm_s >= 60 - 1e-9 && r.farm_s < 60.5 + 1e-9);
    assert_near(r.work_cpu_s, 60, 1e-9);
}

TEST(gathered_gops_are_encoded_side_by_side)
{
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(40, 1, costs);
    sc_sim_machine machine = machine_of(9);
    sc_sim_result r;

    film.encode_wall_s = 0.5; /* by some other device: it needs no core */
    film.gathered = 4;
    r = simulate(&film, &machine); /* 8 ranks draw, and the last of 40 frames is encoded */
    assert_true(r.farm_s >= 5.5 - 1e-9 && r.farm_s < 8 + 1e-9);
    assert_near(r.busy_s.gather, 20, 1e-9);
    assert_near(r.busy_s.accept, 0, 1e-9);
    assert_in_range(r.encoders, 1, 4);
    film.gathered = 3; /* rank 0 draws and encodes ten frames at first */
    r = simulate(&film, &machine);
    assert_near(r.busy_s.gather, 15, 1e-9);
    assert_near(r.busy_s.accept, 5, 1e-9);
    /* one rank draws, which is the only encoder, too; it has one core for both */
    film.gathered = 4;
    film.encode_cpu_s = 0.5;
    machine = machine_of(2);
    r = simulate(&film, &machine);
    assert_true(r.farm_s >= 60 - 1e-9 && r.farm_s < 60.5 + 1e-9);
}

/* A film of one minute in 4K, as in docs/studies.md: what rank 0 alone could not encode. */
TEST(gathering_lets_a_film_scale_to_thousands_of_ranks)
{
    static const struct {
        int ranks;
        double root, gathered; /* the efficiency of the farm is below and above this */
    } cases[] = {{1024, 0.65, 0.97}, {4096, 0.17, 0.945}};
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(1800, 0, costs);

    for (int k = 0; k < film.frames; k++)
        costs[k] = 200 * (0.1 + 1.8 * (double)(k * 7919L % 1000) / 1000);
    film.gop_frames = 30;
    film.width_px = 3840;
    film.height_px = 2160;
    film.partition = SC_PARTITION_AUTO;
    film.band_rows = 0.44;
    film.encode_wall_s = 0.1;
    film.encode_cpu_s = 0.3;
    film.frame_file_bytes = 60000;
    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        sc_sim_machine machine = machine_of(cases[i].ranks);

        machine.ranks_per_node = 64;
        machine.latency_s = 5e-6;
        machine.link_bytes_per_s = 10e9;
        machine.message_s = 20e-6;
        machine.copy_bytes_per_s = 8e9;
        machine.notice_s = 3e-4;
        film.gathered = 0;
        assert_true(simulate(&film, &machine).farm_efficiency < cases[i].root);
        film.gathered = sc_handout_gathered(60, cases[i].ranks, false);
        assert_int_equal(film.gathered, 59);
        assert_true(simulate(&film, &machine).farm_efficiency > cases[i].gathered);
    }
}

TEST(messages_and_pixels_take_their_time)
{
    double costs[FRAMES_MAX];
    const double frame_bytes = 3.0 * 160 * 120;
    sc_sim_film film = film_of(100, 0.1, costs);
    sc_sim_machine machine = machine_of(1000);
    sc_sim_result r;

    /* A frame is asked for, handed out, drawn and sent; rank 0 has drawn 5 and begun 2 before. */
    machine.latency_s = 0.45;
    assert_near(simulate(&film, &machine).farm_s, 0.45 + 0.45 + 0.1 + 0.45, 1e-9);
    machine.latency_s = 0;
    machine.link_bytes_per_s = frame_bytes; /* a frame a second, 99 of which come from others */
    r = simulate(&film, &machine);
    assert_near(r.farm_s, 0.1 + 99, 1e-6);
    assert_near(r.busy_s.link, 99, 1e-6);
    assert_int_equal(r.limit, SC_SIM_NETWORK);
    machine.switches[0] = (sc_sim_switch){10, 0}; /* nodes 0 to 9 share a switch, no limit above */
    machine.switches[1] = (sc_sim_switch){100, frame_bytes / 2};
    assert_true(simulate(&film, &machine).farm_s <
                99.2); /* all frames are drawn on nodes below 100 */
    machine.switches[0].bytes_per_s = frame_bytes / 2;
    assert_true(simulate(&film, &machine).farm_s > 99 + 89);
    machine.ranks_per_node = 1000; /* one node: pixels are shared */
    assert_near(simulate(&film, &machine).farm_s, 0.1, 1e-6);
    machine.message_s = 0.01; /* 99 results, and two requests of each rank */
    r = simulate(&film, &machine);
    assert_true(r.busy_s.message > 99 * 0.01 * 2);
    assert_int_equal(r.limit, SC_SIM_MESSAGES);
}

TEST(what_comes_before_and_after_the_farm_is_added)
{
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(8, 1, costs);
    sc_sim_machine machine = machine_of(4);
    sc_sim_result r;

    film.read_bytes = 300;
    film.prepare_s = 7;
    film.shared_bytes = 40;
    film.derive_s = 0.5;
    film.finish_s = 0.25;
    film.frame_file_bytes = 5;
    machine.file_bytes_per_s = 200;
    machine.node_file_bytes_per_s = 100;
    machine.link_bytes_per_s = 1e3;
    machine.start_s = 1;
    machine.start_node_s = 0.5;
    r = simulate(&film, &machine);
    assert_near(r.start_s, 3, 1e-9);
    assert_near(r.read_s, 3, 1e-9);
    assert_near(r.prepare_s, 7.5, 1e-9);
    assert_near(r.share_s, 0.04, 1e-9);
    assert_near(r.finish_s, 0.25 + 2 * 40 / 100.0, 1e-9);
    assert_near(r.wall_s, 3 + 3 + 7.5 + 0.04 + r.farm_s + r.finish_s, 1e-9);
    machine.link_bytes_per_s = 0;
    assert_int_equal(simulate(&film, &machine).limit, SC_SIM_PREPARING);
    film.read_bytes = 3000;
    assert_int_equal(simulate(&film, &machine).limit, SC_SIM_READING);
    machine.start_s = 100;
    assert_int_equal(simulate(&film, &machine).limit, SC_SIM_STARTING);
    for (int limit = 0; limit <= SC_SIM_FINISHING; limit++)
        assert_true(strlen(sc_sim_limit_words((sc_sim_limit)limit)) > 3);
}

/* Every frame is drawn once, whatever the machine, and the same run is the same to the last bit. */
TEST(any_machine_draws_all_frames)
{
    double costs[FRAMES_MAX];
    uint64_t seed = 5;

    for (int i = 0; i < 300; i++) {
        const int frames = 1 + (int)(random_bits(&seed) % 90);
        sc_sim_film film = film_of(frames, 1, costs);
        sc_sim_machine machine = machine_of(1 + (int)(random_bits(&seed) % 40));
        sc_sim_result r, again;

        for (int k = 0; k < frames; k++)
            costs[k] = random_real(&seed, 0, 0.3);
        film.partition = (sc_partition)(random_bits(&seed) % 3);
        film.gops = (int)(random_bits(&seed) % (unsigned)(frames / 10 + 1));
        if (i % 2 && machine.ranks > 1) {
            film.gathered = film.gops;
            film.gops = 0;
        }
        film.encode_wall_s = random_real(&seed, 0, 0.05);
        film.encode_cpu_s = film.encode_wall_s;
        machine.ranks_per_node = 1 + (int)(random_bits(&seed) % 5);
        machine.threads = 1 + (int)(random_bits(&seed) % 4);
        machine.latency_s = random_real(&seed, 0, 1e-3);
        machine.message_s = random_real(&seed, 0, 1e-3);
        machine.notice_s = random_real(&seed, 0, 1e-3);
        machine.link_bytes_per_s = random_real(&seed, 1e7, 1e9);
        r = simulate(&film, &machine);
        again = simulate(&film, &machine);
        assert_memory_equal(&r, &again, sizeof r);
        assert_true(r.efficiency > 0 && r.efficiency <= 1 + 1e-9);
    }
}

TEST(the_largest_machines_are_simulated_event_by_event)
{
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(1800, 30, costs);

    film.width_px = 3840;
    film.height_px = 2160;
    film.partition = SC_PARTITION_AUTO;
    for (int ranks = 2; ranks <= 65536; ranks *= 32) {
        const sc_sim_machine machine = machine_of(ranks);
        const sc_sim_result r = simulate(&film, &machine);

        assert_true(r.farm_s >= 1800.0 * 30 / ranks * (1 - 1e-9));
        assert_in_range(r.units, 1800, 1800 * 135);
    }
}

TEST(what_is_impossible_or_without_memory_is_an_error)
{
    double costs[FRAMES_MAX];
    sc_sim_film film = film_of(8, 1, costs);
    sc_sim_machine machine = machine_of(4);
    sc_sim_result r;
    long budget = 0;
    sc_ctx poor = {.alloc_budget = &budget};

    for (long allowed = 0;; allowed++) {
        sc_status status;

        budget = allowed;
        status = sc_simulate(&poor, &film, &machine, &r);
        if (status == SC_OK)
            break;
        assert_int_equal(status, SC_ERR_MEMORY);
        assert_true(allowed < 10);
    }
    machine.ranks = 0;
    assert_int_equal(sc_simulate(&quiet, &film, &machine, &r), SC_ERR_INTERNAL);
    machine.ranks = 4;
    film.gops = 1;
    assert_int_equal(sc_simulate(&quiet, &film, &machine, &r), SC_ERR_INTERNAL);
}

RUN_TESTS(NULL, NULL)
