/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to app: what segcast plan measures of a job, and what follows from it. */
#ifndef SC_APP_PLAN_H
#define SC_APP_PLAN_H

#include "run.h"

/* What an output costs that is made of frames in a row: its first frame costs more than those that
 * follow, because they hold only what has changed. All is 0 for an output that is not asked for. */
typedef struct sc_plan_cost {
    double cpu_s, wall_s; /* wall_s: while nothing else runs */
    double bytes;
} sc_plan_cost;

/* What was measured of a job. */
typedef struct sc_plan_probe {
    double prepare_cpu_s, prepare_wall_s;   /* reading and preparing the volume */
    double draw_cpu_s;                      /* of a frame, all threads together */
    int partly_drawn;                       /* frames of which bands were drawn */
    int encoded;                            /* frames that were drawn whole and encoded */
    sc_plan_cost first, next;               /* of a GOP: its first frame, and each of the others */
    sc_plan_cost png;                       /* of a frame as PNG file */
    uint64_t encoder_bytes;                 /* memory of an encoder; 0: there is none, or unknown */
    uint64_t program_bytes;                 /* memory of the process before it read the volume */
    uint64_t prepare_bytes;                 /* the most that it had until the volume was prepared */
    uint64_t prepared_bytes, derived_bytes; /* of the volume, once per node */
    uint64_t renderer_bytes;                /* of each rank */
    uint64_t job_bytes;                     /* size of job.yaml */
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
    int gops;                  /* how many GOPs are encoded by the rank that drew them */
    double wall_s;             /* of the whole run: prepare_s + max(draw_s, encode_s) */
    double prepare_s;
    double draw_s;     /* drawing, with what the same cores encode */
    double encode_s;   /* what rank 0 encodes beside the drawing, one frame after the other */
    const char *limit; /* which of them decides: "preparing", "drawing" or "encoding" */
    uint64_t first_node_bytes, other_node_bytes; /* memory of rank 0's node, and of the others */
} sc_plan_run;
/* @return what the job takes on @p nodes nodes with @p ranks ranks on each, by the farm's own rules
 * of who encodes and how many frames wait. @param cores of a node. @param threads of a rank; 0: as
 * many as the ranks of a node have cores. */
sc_plan_run sc_plan_run_on(const sc_job *job, const sc_plan_probe *probe, int nodes, int ranks,
                           int cores, int threads);

#endif
