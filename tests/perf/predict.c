/* SPDX-License-Identifier: BSD-3-Clause */
/* Prints what sc_simulate predicts for a film on 64 to 65,536 ranks of a cluster. With it the
 * tables of docs/studies.md were made.
 *
 *   predict WIDTH HEIGHT FRAMES DRAW_S ENCODE_S RANKS_PER_NODE THREADS PARTITION [ENCODE]
 *
 * DRAW_S: CPU seconds of a frame in the mean; they vary from a tenth to 1.9 times as much.
 * ENCODE_S: wall seconds that rank 0 needs to encode a frame with 3 cores or more. PARTITION: auto,
 * frames or tiles. ENCODE: auto, as farm.encode in a job, or rank0. */
#include "segcast/simulate.h"

#include <stdlib.h>
#include <string.h>

enum { FRAMES_MAX = 1000000, ENCODER_CORES = 3 };

/* A cluster: 10 GB/s between nodes, a file system of 2 GB/s. */
static const sc_sim_machine cluster = {.latency_s = 5e-6,
                                       .link_bytes_per_s = 10e9,
                                       .message_s = 20e-6,
                                       .copy_bytes_per_s = 8e9,
                                       .notice_s = 3e-4,
                                       .slow_node = -1,
                                       .start_s = 1,
                                       .start_node_s = 1e-3,
                                       .file_bytes_per_s = 2e9,
                                       .node_file_bytes_per_s = 1e9};

/* @return the partition of that name; automatic if there is none. */
static sc_partition partition_of(const char *name)
{
    return !strcmp(name, "frames")  ? SC_PARTITION_FRAMES
           : !strcmp(name, "tiles") ? SC_PARTITION_TILES
                                    : SC_PARTITION_AUTO;
}

int main(int argc, char **argv)
{
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_log_to_stderr};
    const int frames = argc == 9 || argc == 10 ? atoi(argv[3]) : 0;
    /* a volume of 80 MB, prepared in 3 s to 100 MB; every node derives for 0.4 s from that */
    sc_sim_film film = {.frames = frames,
                        .gop_frames = 30,
                        .band_rows = 0.44,
                        .frame_file_bytes = 60000,
                        .read_bytes = 80e6,
                        .prepare_s = 3,
                        .shared_bytes = 100e6,
                        .derive_s = 0.4,
                        .finish_s = 0.2};
    double *costs;
    int code = 0;

    if (frames < 1 || frames > FRAMES_MAX) {
        fprintf(stderr, "usage: predict WIDTH HEIGHT FRAMES DRAW_S ENCODE_S RANKS_PER_NODE THREADS "
                        "auto|frames|tiles [auto|rank0]\n");
        return 64;
    }
    costs = malloc((size_t)frames * sizeof *costs);
    for (int k = 0; k < frames; k++)
        costs[k] = atof(argv[4]) * (0.1 + 1.8 * (double)(k * 7919L % 1000) / 1000);
    film.draw_cpu_s = costs;
    film.width_px = atoi(argv[1]);
    film.height_px = atoi(argv[2]);
    film.encode_wall_s = atof(argv[5]);
    film.encode_cpu_s = ENCODER_CORES * film.encode_wall_s;
    film.partition = partition_of(argv[8]);
    printf("%6s %10s %10s %10s %5s %7s %7s %8s  %s\n", "ranks", "wall s", "efficiency", "of farm",
           "held", "window", "units", "encoders", "limited by");
    for (int ranks = 64; ranks <= 65536; ranks *= 4) {
        sc_sim_machine machine = cluster;
        sc_sim_result r;

        if (argc < 10 || strcmp(argv[9], "rank0") != 0) {
            film.gops = sc_handout_gops(frames / film.gop_frames, ranks, false);
            film.gathered = sc_handout_gathered(frames / film.gop_frames, ranks, false);
        }
        machine.ranks = ranks;
        machine.ranks_per_node = atoi(argv[6]);
        machine.threads = atoi(argv[7]);
        code |= sc_simulate(&ctx, &film, &machine, &r) != SC_OK;
        if (!code)
            printf("%6d %10.1f %10.3f %10.3f %5d %7d %7ld %8d  %s\n", ranks, r.wall_s, r.efficiency,
                   r.farm_efficiency, r.held, r.window, r.units, r.encoders,
                   sc_sim_limit_words(r.limit));
    }
    free(costs);
    return code;
}
