/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  A discrete-event simulation of a run: what a film takes on a machine that is not here.
 *
 *  The work units are those of the farm's own hand-out (sc_handout_next); ranks, messages, the
 *  network, rank 0's two threads and the file system are events in time. Everything that a run does
 *  before and after the farm is a sum. Pure functions: no clock, no messages, no files. */
#ifndef SEGCAST_SIMULATE_H
#define SEGCAST_SIMULATE_H

#include "segcast/farm.h"

/** What a film costs, on a core of speed 1. */
typedef struct sc_sim_film {
    int frames, gop_frames;
    int width_px, height_px;
    bool alpha; /**< see sc_farm */
    sc_partition partition;
    /** How many whole GOPs, the first of the film, are drawn and encoded by one rank each (see
     *  sc_handout_gops), and how many, the last of it, are gathered (see sc_handout_gathered); all
     *  frames between them go to rank 0, which encodes them one after the other. */
    int gops, gathered;
    int encoders_most;        /**< as in sc_farm */
    const double *draw_cpu_s; /**< [frames], borrowed: CPU seconds of drawing each frame */
    double band_rows;         /**< rows that every band costs beside its own */
    double encode_cpu_s;      /**< of a frame in the video, and as PNG file if asked for */
    double encode_wall_s;    /**< the same while nothing else runs on the node, at most encode_cpu_s
                              * and at least encode_cpu_s / threads */
    double frame_file_bytes; /**< of a frame, encoded */

    /* before and after the farm */
    double read_bytes;   /**< of the volume's file, which one rank reads */
    double prepare_s;    /**< wall time of preparing on one node */
    double shared_bytes; /**< what each other node gets of it over the network */
    double derive_s;     /**< wall time of what each node then derives from it */
    double finish_s;     /**< of rank 0 at the end: joining, records; without the file system */
} sc_sim_film;

/** A level of switches: groups of neighbouring nodes, and the link from each to the level above. */
typedef struct sc_sim_switch {
    int nodes;          /**< of a group */
    double bytes_per_s; /**< of its link, each way */
} sc_sim_switch;

enum { SC_SIM_SWITCHES = 4 };

/** A machine. A bandwidth of 0 stands for an infinite one. Rank r is on node r / ranks_per_node. */
typedef struct sc_sim_machine {
    int ranks, ranks_per_node;               /**< both above 0 */
    int threads;                             /**< of a rank, each with a core of its own; above 0 */
    double latency_s;                        /**< of a message over the network, either way */
    double link_bytes_per_s;                 /**< of a node, each way */
    sc_sim_switch switches[SC_SIM_SWITCHES]; /**< from the nodes upwards; those without nodes do not
                                              * count */
    double message_s;        /**< of the main thread of rank 0: a message without its pixels */
    double copy_bytes_per_s; /**< of the main thread of rank 0: pixels that arrive */
    double notice_s;   /**< mean time until a main thread that sleeps notices a message or task */
    int slow_node;     /**< the node whose cores have another speed; negative: none */
    double slow_speed; /**< its speed; that of all others is 1 */
    double start_s, start_node_s; /**< until the first rank runs: fixed, and for each node */
    double file_bytes_per_s, node_file_bytes_per_s; /**< of the shared file system in all, and to
                                                     * one node */
} sc_sim_machine;

/** What decides the wall time of a run. */
typedef enum sc_sim_limit {
    SC_SIM_DRAWING,   /**< the cores are busy: more of them help */
    SC_SIM_STARTING,  /**< starting the ranks */
    SC_SIM_READING,   /**< reading the volume */
    SC_SIM_PREPARING, /**< preparing it on one node, or what each node derives from it */
    SC_SIM_SHARING,   /**< sending it to all nodes */
    SC_SIM_ENCODING,  /**< rank 0 accepts frames one after the other */
    SC_SIM_GATHERING, /**< the encoders of gathered GOPs encode frames one after the other */
    SC_SIM_MESSAGES,  /**< the main thread of rank 0 */
    SC_SIM_NETWORK,   /**< the link of rank 0's node, or a switch */
    SC_SIM_WINDOW,    /**< ranks wait because the window of rank 0 is full */
    SC_SIM_UNITS,     /**< ranks wait because there are too few work units */
    SC_SIM_FINISHING  /**< joining the video, and records */
} sc_sim_limit;
/** @return a few words for it, such as "encoding on rank 0". */
const char *sc_sim_limit_words(sc_sim_limit limit);

/** For how many seconds the parts of a machine were busy. */
typedef struct sc_sim_busy {
    double draw;    /**< sum over all ranks of the time in which they drew or encoded GOPs */
    double accept;  /**< rank 0: in which it encoded frames */
    double gather;  /**< sum over all encoders: in which they encoded frames */
    double message; /**< rank 0: in which its main thread handled messages */
    double link;    /**< the busiest link of the network */
} sc_sim_busy;

/** The outcome of a simulated run. Times are in seconds. */
typedef struct sc_sim_result {
    double wall_s; /**< the sum of the next six */
    double start_s, read_s, prepare_s, share_s, farm_s, finish_s;
    double frames_per_s; /**< frames / wall_s */
    double work_cpu_s;   /**< drawing and encoding all frames, without what bands add */
    /** work_cpu_s over the core time of all ranks (ranks * threads): of the whole wall time, and of
     *  the farm alone. */
    double efficiency, farm_efficiency;
    sc_sim_busy busy_s;
    double window_wait_s; /**< sum over all ranks: without a unit because the window was full */
    double end_wait_s;    /**< sum over all ranks: from the last unit's end to that of the farm */
    long units;           /**< work units handed out */
    int encoders;         /**< the most GOPs that were gathered at a time */
    int window;           /**< frames that rank 0 can hold */
    int held;             /**< the most frames that were finished and not yet accepted */
    sc_sim_limit limit;
} sc_sim_result;

/** Simulate a run. Takes memory in proportion to ranks and frames, and time to work units (a second
 *  for a million). Threads: any. @return SC_ERR_MEMORY, or SC_ERR_INTERNAL if a number that has to
 *  be above 0 is not. */
SC_MUST_USE sc_status sc_simulate(const sc_ctx *ctx, const sc_sim_film *film,
                                  const sc_sim_machine *machine, sc_sim_result *out);

#endif
