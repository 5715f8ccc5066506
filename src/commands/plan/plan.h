/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: what segcast plan measures of a job, and what follows from it. */
#ifndef SC_COMMANDS_PLAN_H
#define SC_COMMANDS_PLAN_H

#include "plan/calibration.h"
#include "render/run.h"
#include "segcast/simulate.h"

/* What an output costs that is made of frames in a row: its first frame costs more than those that
 * follow, because they hold only what has changed. All is 0 for an output that is not asked for. */
typedef struct sc_plan_cost {
    double cpu_s, wall_s; /* wall_s: while nothing else runs */
    double bytes;
} sc_plan_cost;

/* At so many places of the animation the cost of drawing is measured, evenly spread. */
enum { SC_PLAN_PLACES = 12 };

/* What was measured of a job. */
typedef struct sc_plan_probe {
    double prepare_cpu_s, prepare_wall_s;   /* reading and preparing the volume */
    double draw_cpu_s;                      /* of a frame, all threads together */
    int partly_drawn;                       /* frames of which bands were drawn */
    double place_cpu_s[SC_PLAN_PLACES];     /* [partly_drawn]: of each, a whole frame */
    int encoded;                            /* frames that were drawn whole and encoded */
    sc_plan_cost first, next;               /* of a GOP: its first frame, and each of the others */
    sc_plan_cost png;                       /* of a frame as PNG file */
    uint64_t encoder_bytes;                 /* memory of an encoder; 0: there is none, or unknown */
    uint64_t program_bytes;                 /* memory of the process before it read the volume */
    uint64_t prepare_bytes;                 /* the most that it had until the volume was prepared */
    uint64_t prepared_bytes, derived_bytes; /* of the volume, once per node */
    uint64_t phase_file_bytes;              /* of these, what is held in files, of phases */
    uint64_t loaded_bytes;                  /* of these, what is in memory at a time */
    uint64_t renderer_bytes;                /* of each rank */
    uint64_t job_bytes;                     /* size of job.yaml */
    uint64_t memory_max_bytes;              /* that each process may take; 0: no limit */
} sc_plan_probe;

/* Measure the job of @p session, of which job and volume are filled: parts of frames, some frames
 * in a row, and their encoding. Costs about a tenth of the job and half a minute at most, unless
 * two frames take longer. @param program_bytes for the member of that name. @return
 * SC_ERR_MEMORY, or as sc_encoder_open and sc_encoder_push. */
sc_status sc_plan_measure(sc_app *app, sc_session *session, uint64_t program_bytes,
                          sc_plan_probe *out);

/* ---- plan_model.c: what follows; pure functions ---- */

/* Bytes on disk, in the folder of the job. */
typedef struct sc_plan_disk {
    uint64_t video, frames; /* the video; the PNG files */
    uint64_t records;       /* manifest, statistics, trace, job.yaml */
    uint64_t end;           /* all of these, which are there at the end */
    uint64_t peak;          /* the most at a time: with segments and partial GOPs */
} sc_plan_disk;
/* @return what the job writes, drawn by ranks of @p threads threads. */
sc_plan_disk sc_plan_disk_of(const sc_job *job, const sc_plan_probe *probe, int threads);

/* @return the CPU seconds of encoding all outputs of the job. */
double sc_plan_encode_cpu_s(const sc_job *job, const sc_plan_probe *probe);

/* What a run on some nodes takes. */
typedef struct sc_plan_run {
    int nodes, ranks, threads; /* ranks: of a node; threads: of a rank */
    int gops;                  /* how many GOPs are encoded by ranks other than rank 0, */
    bool gather;               /* which gather them; otherwise each by the rank that drew it */
    int encoders_most;         /* as in sc_farm */
    double wall_s;             /* of the whole run: prepare_s + max(draw_s, encode_s), or as
                                * simulated */
    double efficiency;         /* simulated: drawing and encoding over the time of all cores */
    double prepare_s;
    double draw_s;     /* drawing, with what the same cores encode */
    double encode_s;   /* what rank 0 encodes beside the drawing, one frame after the other */
    const char *limit; /* which of them decides: "preparing", "drawing" or "encoding"; or what the
                        * simulation says, see sc_sim_limit_words */
    uint64_t first_node_bytes, other_node_bytes; /* memory of rank 0's node, and of the others */
} sc_plan_run;
/* @return what the job takes on @p nodes nodes with @p ranks ranks on each, by the farm's own rules
 * of who encodes and how many frames wait. @param cores of a node. @param threads of a rank; 0: as
 * many as the ranks of a node have cores. */
sc_plan_run sc_plan_run_on(const sc_job *job, const sc_plan_probe *probe, int nodes, int ranks,
                           int cores, int threads);

/* ---- plan_scale.c: the same, simulated ---- */

/* Simulate @p run, a result of sc_plan_run_on for nodes of @p cores cores: replaces wall_s and
 * limit, and fills in efficiency. @return SC_ERR_MEMORY. */
sc_status sc_plan_simulate(const sc_ctx *ctx, const sc_job *job, const sc_plan_probe *probe,
                           const sc_unit_costs *costs, int cores, sc_plan_run *run);

/* The best run on a number of nodes. */
typedef struct sc_plan_row {
    sc_plan_run run;
    int encode;        /* farm.encode with which it is, an sc_encode */
    double core_hours; /* of all cores of the nodes while it runs */
} sc_plan_row;

enum {
    SC_PLAN_ROWS_MAX = 17,
    SC_PLAN_RANKS_MOST = 65536
}; /* no run with more ranks is simulated */

/* How a job scales. */
typedef struct sc_plan_scale {
    sc_plan_row rows[SC_PLAN_ROWS_MAX]; /* [count], for 1, 2, 4, ... nodes */
    int count;
    int pays_to; /* so many nodes: the next row does not pay, see SC_PLAN_PAYS */
} sc_plan_scale;
/* Twice as many nodes pay if the run is so many times as fast. */
#define SC_PLAN_PAYS 1.5

/* Nodes, and what is open. */
typedef struct sc_plan_nodes {
    int most;              /* number of them */
    int cores;             /* of each */
    uint64_t memory_bytes; /* of each */
    int ranks, threads;    /* of a node and of a rank, if they are given; 0: open */
} sc_plan_nodes;

/* Find the best number of ranks and threads, and, if the job leaves that to the program, who
 * encodes, for 1, 2, 4, ... nodes. @return SC_ERR_MEMORY. */
sc_status sc_plan_scale_to(const sc_ctx *ctx, const sc_job *job, const sc_plan_probe *probe,
                           const sc_unit_costs *costs, const sc_plan_nodes *nodes,
                           sc_plan_scale *out);

#endif
