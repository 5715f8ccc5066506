/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: the state of a run, and the callbacks and reports of segcast render. */
#ifndef SC_COMMANDS_RUN_H
#define SC_COMMANDS_RUN_H

#include "commands.h"
#include "segcast/store.h"

/* What the run is to draw: rank 0 finds it out and sends it to all others, as bytes. */
typedef struct sc_draw_plan {
    int frame_count, gop_count;
    int gop_frames;
    int encoders_most; /* as in sc_farm */
    int kept;          /* number of wanted frames that earlier runs have done */
    uint64_t identity; /* see sc_store_identity */
    uint8_t gather;    /* GOPs are gathered: see sc_farm */
    uint8_t sealed;    /* and its records are proven: nothing is to be written */
    uint8_t complete;  /* earlier runs have finished the job: there is nothing to do */
    uint8_t replaced;  /* another run has taken the directory over: nothing more is to be written */
} sc_draw_plan;

/* Called on rank 0 with the record of a run that has ended. */
typedef void sc_run_observer(void *user, const sc_run_record *record);

/* When a run began and has to end. */
typedef struct sc_run_clock {
    double begin_s, farm_begin_s; /* by sc_wall_s */
    double farm_cpu_s;            /* CPU time of the process before the farm */
    double deadline_s;            /* see sc_deadline_s */
    int64_t begin_unix_s;
    double begin_cpu_s; /* CPU time of the process when the run began; 0: the run is all it does */
} sc_run_clock;

/* Used by the worker thread that draws; from the encoder on by that which encodes GOPs on this
 * rank: the same, or, if they are gathered, another one. */
typedef struct sc_run_worker {
    sc_render_span *spans; /* [threads] */
    sc_image gop_image;
    sc_encoder *encoder;
    sc_payload gop_pngs;  /* of a gathered GOP, so far: see add_block in run_draw.c */
    double encode_wall_s; /* wall time of encoding GOPs on this rank */
} sc_run_worker;

/* What only rank 0 knows of a run: its outputs and records. */
typedef struct sc_run_root {
    const char *job_path;      /* the job file that was given; NULL: none */
    const char *directory;     /* where the outputs go */
    char slice[128];           /* name of the slice; empty: the whole job */
    int *wanted, wanted_count; /* frames of the slice or of the whole job, in rising order */
    int missing;               /* frames of the job that no run has done yet */
    sc_store_job store_job;
    sc_store *store;
    char *video_path;
    sc_video_writer *writer;  /* instead of the store, if only the video is written */
    sc_frame_result *results; /* [wanted_count], of frames accepted in this run */
    int result_count;
    atomic_int frames_done; /* of those wanted, by earlier runs and this one */
    sc_store_begun begun;   /* what was made before the volume was read */
    uint64_t id;            /* see sc_run_record */
    sc_history earlier;     /* what earlier runs have measured; owned */
    bool has_earlier;       /* it was read */
    char *made_from;        /* see sc_run_record; owned */
} sc_run_root;

/* The state of a run on one rank. */
typedef struct sc_run {
    sc_app *app;
    sc_session session;
    sc_draw_plan plan;
    int *frames, *gops; /* [plan.frame_count], [plan.gop_count]: see sc_farm */
    sc_run_clock clock;
    const atomic_int *stop, *give_up; /* see sc_signals_catch_stop, _give_up */
    sc_run_observer *observe;         /* see sc_run_measured; or NULL */
    void *observer;
    sc_trace *trace;
    bool keep_records; /* write manifest, progress and statistics; otherwise the video alone */
    sc_run_worker worker;
    sc_run_root root;
} sc_run;

/* ---- cmd_render.c ---- */

/* Do the run of a job from start to end as `segcast render` with the options of @p app does, with
 * all its files, but print nothing at its end; give what was measured to @p observe on rank 0.
 * CPU time is counted from here on. Collective. @return as `segcast render`. */
sc_status sc_run_measured(sc_app *app, const char *job_path, sc_run_observer *observe, void *user);

/* ---- identity.c ---- */

/* Hash everything that determines the pictures of a run whose session is complete, except the
 * volume, which has a hash of its own. Not collective. @return SC_ERR_MEMORY. */
sc_status sc_run_hash_job(sc_run *run, uint64_t *out);

/* ---- run_draw.c: callbacks of sc_farm, with an sc_run as user ---- */

sc_status sc_run_draw(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result);
sc_status sc_run_draw_gop(void *user, int first, int count, sc_frame_result *results,
                          sc_payload *out);
sc_status sc_run_encode_frame(void *user, int first, int count, const sc_frame_result *result,
                              const sc_image *image, sc_payload *out);
sc_status sc_run_accept_frame(void *user, const sc_frame_result *result, const sc_image *image);
sc_status sc_run_accept_gop(void *user, const sc_frame_result *results, int count,
                            const sc_payload *payload);
/* @return the video settings of a job; their texts are borrowed from it. */
sc_video_settings sc_run_video_settings(const sc_job *job);
/* @return SC_ERR_CREATE, logged, if this libavcodec has no encoder for the job's video;
 * SC_ERR_SYSTEM, logged, if it takes more memory than is allowed; otherwise SC_OK. */
SC_MUST_USE sc_status sc_run_check_encoder(const sc_ctx *ctx, const sc_job *job);
bool sc_run_has_video(const sc_job *job);
/* Who encodes. */
typedef struct sc_run_encoding {
    int gops;    /* how many GOPs ranks encode; rank 0 encodes the rest */
    bool gather; /* they are gathered, the last ones of those with the full length; otherwise each
                  * is drawn by the rank that encodes it, the first ones */
    int encoders_most; /* as in sc_farm */
} sc_run_encoding;
/* Where GOPs are encoded. */
typedef struct sc_run_ranks {
    int ranks, nodes;
    uint64_t memory_max_bytes; /* for the encoders of gathered GOPs on each node; 0: no limit */
} sc_run_ranks;
/* @return who encodes the GOPs that no run has begun: @p whole of them, @p full of which have the
 * full length (the last one of an animation may be shorter), with ranks that do a job with all its
 * records. As many GOPs are gathered at a time as the memory of all nodes allows, to which ranks
 * are taken to be spread evenly; with farm.encode: auto none if it does not allow the two groups
 * that overlap, of one GOP each. */
sc_run_encoding sc_run_encoding_of(const sc_job *job, int whole, int full,
                                   const sc_run_ranks *where);
/* Warn, or with farm.encode: gather refuse, if there is too little memory for the encoders of @p
 * gathered GOPs, so many as would be gathered without a limit. @return SC_ERR_SYSTEM. */
SC_MUST_USE sc_status sc_run_check_gathering(const sc_ctx *ctx, const sc_job *job, int gathered,
                                             const sc_run_ranks *where);
/* @return how many bytes a rank needs at least that encodes one of @p gathered gathered GOPs, with
 * @p ranks ranks: the frames that it holds, and its encoder; 0 without GOPs. */
double sc_run_gathering_bytes(const sc_job *job, int gathered, int ranks);
/* Refuse farm.encode: gather where the encoder of one GOP is too large for any node, however many
 * ranks and nodes the job gets. @return SC_ERR_SYSTEM. */
SC_MUST_USE sc_status sc_run_check_encode_key(const sc_ctx *ctx, const sc_job *job);

/* ---- directory.c ---- */

/* Read what a directory belongs to: the job from its job.yaml, and version, hashes and size from
 * its manifest. @param version room for 64 bytes, which out->version points to; other texts of @p
 * out are borrowed from @p job, which the caller owns, also after an error: sc_job_clear. @return
 * SC_ERR_MISSING if it holds no run, SC_ERR_DATA. */
sc_status sc_read_directory(const sc_app *app, const char *directory, sc_job *job,
                            sc_store_job *out, char *version);

/* ---- run_crate.c: where the film comes from ---- */

/* On rank 0, before the first frame: fill run->root.made_from; reads all input files. @return
 * SC_ERR_MEMORY. */
sc_status sc_run_note_inputs(sc_run *run);
/* Write the RO-Crate of a directory by what it holds now. @param store_job of which version, hashes
 * and number of frames are read. @param is_complete the video is finished. Not collective. @return
 * SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
sc_status sc_write_crate(const sc_ctx *ctx, const char *directory, const sc_job *job,
                         const sc_store_job *store_job, bool is_complete);

/* ---- run_heat.c ---- */

/* Draw the heat picture of a run that has ended, if it has drawn frames; one that has not keeps
 * that of an earlier run in the stats.json under @p path. On rank 0. @param out zeroed; the caller
 * owns it: sc_heat_clear. */
void sc_run_draw_heat(sc_run *run, const char *path, sc_heat *out);

/* ---- run_report.c: progress and timing records ---- */

/* For sc_farm_calls.on_progress: note how many frames are done. */
void sc_run_on_progress(void *user, int done, int total);
/* For sc_display_watch, with a run as user whose directory may be written to: write status.json. */
void sc_run_watch(void *user, const sc_stage_view *view);
/* Fill in the timing record of this rank after the farm, from @p times and the store's. */
void sc_run_fill_phases(sc_run *run, const sc_farm_times *times);
/* Write status.json for the last time, with the state that belongs to @p outcome. */
sc_status sc_run_write_state(sc_run *run, sc_status outcome);
/* Before the first frame: choose run->root.id, and put the run into stats.json, so that a later one
 * knows of it even if this one is killed. Nothing is written if nothing is to be drawn. Collective.
 */
sc_status sc_run_begin_records(sc_run *run);
/* Gather the timing records of all ranks on rank 0, write them and log a summary. Collective. */
sc_status sc_run_write_records(sc_run *run, const sc_farm_times *times);

#endif
