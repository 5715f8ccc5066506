/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to app: options, the commands, and what they share. */
#ifndef SC_APP_APP_H
#define SC_APP_APP_H

#include "options.h"
#include "segcast/comm.h"
#include "segcast/study.h"

/* Standard error, which shows messages and, if it is a terminal, a progress bar below them. */
typedef struct sc_terminal {
    bool is_tty, quiet, bar_shown;
} sc_terminal;
/* Writer for sc_ctx.write with an sc_terminal as user. */
void sc_terminal_write(void *user, sc_log_level level, const char *text);
/* Draw the bar, over an earlier one. */
void sc_terminal_bar(sc_terminal *terminal, const char *text);
/* Remove the bar. */
void sc_terminal_clear(sc_terminal *terminal);

/* What every command gets. */
struct sc_app {
    sc_ctx *ctx;
    sc_comm *comm;
    sc_terminal *terminal;
    const char *const *environment;
    const sc_command *commands; /* the table; ended by a row without a name */
    sc_options options;
    int threads;     /* of this rank */
    double begin_s;  /* by sc_wall_s */
    sc_trace *trace; /* borrowed, or NULL */
};

/* Was this process started by an MPI launcher such as mpirun or srun? */
bool sc_launched_by_mpi(void);
/* SC_ERR_USAGE if srun has started several tasks that are not connected by MPI: each would take
 * itself for rank 0 of 1, and they would overwrite each other's files. */
sc_status sc_check_communicator(const sc_ctx *ctx, const sc_comm *comm);

void sc_print_version(FILE *stream);
const char *sc_version(void);

/* ---- a session: a job with its volume and renderer; collective unless said otherwise ---- */

typedef struct sc_session {
    bool measure; /* everything is to be measured, not drawn: no label is hidden */
    sc_job job;
    sc_shared *shared; /* block that holds the prepared volume, or NULL: it is in a mapped file */
    const void *mapped;
    size_t mapped_bytes;
    size_t shared_bytes;   /* of the prepared volume, wherever it is */
    sc_label *labels;      /* of a mapped volume, with the job's names and colours */
    sc_label_stats *stats; /* of a volume that is only inspected */
    sc_prepared volume;
    sc_tissue *tissues;
    sc_renderer *renderer;
    uint32_t clip_sets[SC_CLIP_SETS_MAX]; /* planes of each, as bits; see sc_clip_sets_find */
    int clip_set_count;
    sc_timeline timeline;
    sc_rank_record times;
} sc_session;

/* Send an array of rank 0, @p count elements of @p size bytes, to the others, which own their copy.
 * After an error *array is NULL on them; on rank 0 it always stays what it was. Collective. */
sc_status sc_broadcast_array(sc_app *app, void **array, size_t count, size_t size);
/* Read the job on rank 0 and send it to all others. After an error, too: sc_session_clear. */
sc_status sc_session_job(sc_app *app, const char *job_path, sc_session *session);
/* The volume of the job, prepared and shared. */
sc_status sc_session_load(sc_app *app, sc_session *session);
/* Map the prepared file of the job on every rank, after agreeing that it is the same file on all.
 * @param usable whether the job can use it as it is. Collective, the same result on all ranks. */
sc_status sc_session_map(const sc_app *app, sc_session *session, bool *usable);
/* The size of the phantom that a job names as its volume. SC_ERR_USAGE if that cannot be read. */
sc_status sc_phantom_size(const sc_ctx *ctx, const char *volume, int size[3]);
/* Give a volume the names and colours of the job's label table, if the job names one. */
sc_status sc_apply_labels(const sc_app *app, const sc_job *job, sc_volume *volume);
/* What can be known of the volume of the job without preparing it: its size, its geometry, its
 * labels and, in the label statistics, their voxels and bounding boxes; the rest of
 * session->volume stays empty. One streaming pass over the voxels, in bounded memory; with
 * @p header_only none: then the labels are those of the label tables and those that the job names
 * by number, and the boxes are empty. Not collective: for one rank alone. */
sc_status sc_session_inspect(sc_app *app, bool header_only, sc_session *session);
/* Tissues and clip sets of the volume of the session. Collective. */
sc_status sc_session_tissues(sc_app *app, sc_session *session);
/* The timeline, framed on @p points, and warnings of clip planes that leave nothing or miss what is
 * shown. Collective. */
void sc_session_timeline(sc_app *app, sc_session *session, const sc_vec3 *points, size_t count);
/* On this rank alone: read the volume of the job and prepare what the job shows of it; all of it if
 * session->measure. @param measure_all also what this job does not need. Caller owns both outputs,
 * also after an error. @param times NULL: not taken. */
sc_status sc_session_prepare(const sc_app *app, const sc_session *session, bool measure_all,
                             sc_volume *volume, sc_preparation **preparation,
                             sc_rank_record *times);
/* What a phase took since the given times; also to the trace. @p times NULL: not taken. */
void sc_add_time(const sc_app *app, sc_rank_record *times, sc_phase phase, double wall_s,
                 double cpu_s);
/* Read, prepare and share the volume; resolve tissues, planes and framing. */
sc_status sc_session_volume(sc_app *app, sc_session *session);
/* Draw frame @p k, or rows of it, in the layout of the job. */
sc_status sc_session_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                          sc_image *image, sc_render_stats *stats);
void sc_session_clear(sc_session *session);

/* Log a table of ranks, hosts, threads, cores and memory, and a warning where threads have to share
 * cores, with the options of mpirun and srun that help. Collective. */
sc_status sc_report_placement(sc_app *app);
/* The time, by sc_wall_s, at which the run has to end: before the allocation of the batch system or
 * the time limit of the command line ends, with a margin; 0: no limit. */
double sc_deadline_s(const sc_app *app);

/* Handle USR1, TERM and INT: the first of them sets the flag that is returned; another INT or TERM
 * ends the process at once. */
const volatile sig_atomic_t *sc_signals_install(void);

/* ---- the commands: rows of sc_commands ---- */

sc_status sc_cmd_render(sc_app *app);
sc_status sc_cmd_join(sc_app *app);
sc_status sc_cmd_verify(sc_app *app);
sc_status sc_cmd_orbit(sc_app *app);
sc_status sc_cmd_still(sc_app *app);
sc_status sc_cmd_views(sc_app *app);
sc_status sc_cmd_check(sc_app *app);
sc_status sc_cmd_plan(sc_app *app);
sc_status sc_cmd_info(sc_app *app);
sc_status sc_cmd_phantom(sc_app *app);
sc_status sc_cmd_prepare(sc_app *app);
sc_status sc_cmd_keys(sc_app *app);
sc_status sc_cmd_help(sc_app *app);

#endif
