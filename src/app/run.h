/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to app: the state of a run, and the callbacks and reports of segcast render. */
#ifndef SC_APP_RUN_H
#define SC_APP_RUN_H

#include "app.h"
#include "segcast/store.h"

/* What the run is to draw; the same on all ranks. */
typedef struct sc_draw_plan {
    int frame_count, gop_count;
    int gop_frames;
    int kept; /* wanted frames that earlier runs have done */
    uint64_t identity;
    uint8_t complete; /* earlier runs have finished the job: there is nothing to do */
} sc_draw_plan;

typedef struct sc_run {
    sc_app *app;
    sc_session session;
    sc_draw_plan plan;
    int *frames, *gops; /* [plan.frame_count], [plan.gop_count] */
    double begin_s, farm_begin_s, farm_cpu_s, deadline_s;
    int64_t begin_unix_s;
    const volatile sig_atomic_t *stop;
    sc_trace *trace;
    bool keep_records; /* manifest, progress and statistics; else the video alone */
    /* used by the worker thread that draws */
    sc_render_span *spans; /* [threads] */
    sc_image gop_image;
    sc_encoder *encoder;
    double encode_wall_s; /* of GOPs drawn on this rank */
    /* on rank 0 */
    const char *directory; /* of the outputs */
    char slice[128];       /* its name, or empty: the whole job */
    int *wanted, wanted_count, missing;
    sc_store_job store_job;
    sc_store *store;
    char *video_path;
    sc_video_writer *writer; /* of a video without records */
    sc_frame_result *results;
    int result_count;
    double told_s, written_s; /* when progress was last shown, and written to status.json */
} sc_run;

/* ---- run_draw.c: callbacks of the farm ---- */

sc_status sc_run_draw(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result);
sc_status sc_run_draw_gop(void *user, int first, int count, sc_frame_result *results,
                          sc_payload *out);
sc_status sc_run_accept_frame(void *user, const sc_frame_result *result, const sc_image *image);
sc_status sc_run_accept_gop(void *user, const sc_frame_result *results, int count,
                            const sc_payload *payload);
sc_video_settings sc_run_video_settings(const sc_job *job);
bool sc_run_has_video(const sc_job *job);

/* ---- run_report.c: progress and timing records ---- */

/* For sc_farm.on_progress. */
void sc_run_on_progress(void *user, int done, int total);
void sc_run_fill_phases(sc_run *run, const sc_farm_times *times);
/* Write status.json for the last time. */
sc_status sc_run_write_state(sc_run *run, sc_status outcome);
/* Gather the timing records of all ranks on rank 0, write them and log a summary. Collective. */
sc_status sc_run_write_records(sc_run *run, const sc_farm_times *times);

#endif
