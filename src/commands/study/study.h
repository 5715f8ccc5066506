/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: a timing study as its command, the measuring of a cell and the list of cells
 * see it. */
#ifndef SC_COMMANDS_STUDY_H
#define SC_COMMANDS_STUDY_H

#include "commands.h"
#include "segcast/measurements.h"
#include "segcast/study_file.h"

/* What every rank knows of a cell. Sent as bytes. */
typedef struct sc_cell_info {
    int32_t ranks, threads, placement; /* placement: an sc_comm_choice */
    int32_t frames;                    /* how many are measured */
    uint8_t runs_here;                 /* this allocation, build and processor can run it */
    uint8_t any_cpu;                   /* there are variants of its kernel, and it names none */
    uint64_t volume_key; /* cells with the same one draw the same prepared volume, prepared alike */
    uint64_t picture;    /* of cells with the same one all pixels have to be the same */
} sc_cell_info;

enum { SC_STUDY_PARTS = 32, SC_STUDY_FRAMES_MAX = 10000 };

/* The session of the cell that was measured last. */
typedef struct sc_held_session {
    sc_app app; /* with its communicator */
    sc_session session;
    bool is_here;        /* this rank has one */
    bool is_anywhere;    /* the ranks of its communicator have one */
    int cell;            /* its number */
    sc_rank_record load; /* what loading its volume took */
} sc_held_session;

/* A study on one rank. */
typedef struct sc_study_state {
    sc_app *app;       /* of all ranks */
    sc_status mistake; /* of the study's file, on rank 0: it was told, and sc_study_list_cells tells
                          those of the jobs, too, and returns it */
    sc_cell_info *cells;
    int cell_count;
    /* communicators of some of the ranks that were opened so far, the same list on all ranks */
    struct {
        int ranks, placement;
        sc_comm *comm; /* NULL: this rank is not in it */
    } parts[SC_STUDY_PARTS];
    int part_count;
    sc_held_session held;
    bool whole_jobs; /* see SC_STUDY_JOB */
    /* on rank 0 */
    sc_study study;
    char *made_from; /* see sc_run_record; owned */
    char *work;      /* the directory of the jobs that are measured as a whole */
    sc_design design;
    const char *cpu; /* the best variant that the skip methods of all cells with any_cpu have, which
                        these are measured with; NULL: the best that this processor can run */
    uint8_t *told;   /* [cell_count]: its warnings were shown */
} sc_study_state;

/* ---- study_cells.c: the list of cells ---- */

/* Fill state->design and state->cells on all ranks: each cell's job is loaded and checked on rank
 * 0. @return also SC_ERR_USAGE, SC_ERR_DATA or SC_ERR_MISSING, with all mistakes of all cells
 * logged, each once. */
sc_status sc_study_list_cells(sc_study_state *state);
/* Why a cell cannot run here, in words; for cells whose runs_here is not set. Not collective. */
void sc_study_why_not(const sc_study_state *state, int cell, char *text, size_t size);
/* Put the settings of a cell, and behind them those of the command line, into @p options, a copy of
 * the command line's. The texts are borrowed. On rank 0. */
sc_status sc_study_cell_options(const sc_study_state *state, int cell, sc_options *options);
/* Fill state->made_from: reads all files that the jobs of cells name, once each; but stores of
 * Zarr, N5 and Neuroglancer, of which it is not known how much is measured. On rank 0. @return
 * SC_ERR_MEMORY. */
sc_status sc_study_note_inputs(sc_study_state *state);
/* List the frames that are measured of a job. On rank 0. Caller owns *out: sc_free. */
sc_status sc_study_frames(const sc_study_state *state, const sc_job *job, int **out, int *count);
void sc_study_clear_cells(sc_study_state *state);

/* ---- study_directory.c: what is written, on rank 0 ---- */

/* The names of its measurements and of its page. */
#define SC_STUDY_MEASUREMENTS "measurements.jsonl"
#define SC_STUDY_PAGE "report.html"

/* The directory of a study. */
typedef struct sc_study_records {
    sc_study_state *state;
    const char *directory;
    sc_measurements results; /* of this run and of earlier ones */
    sc_measurement_file *file;
    bool is_new;         /* this run has begun it */
    bool made_directory; /* and has made the directory */
    bool discard; /* the study was refused: sc_study_close removes what has no measurements */
} sc_study_records;
/* Open the directory as the options say; r->state and r->directory are set. The design moves from
 * the state to r->results. @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_DATA, SC_ERR_MEMORY. */
sc_status sc_study_open(sc_study_records *r);
/* Add a measurement, or why a cell is not measured. @return SC_ERR_WRITE, SC_ERR_MEMORY. */
sc_status sc_study_add(sc_study_records *r, const sc_measurement *m);
sc_status sc_study_skip(sc_study_records *r, int cell, const char *reason);
/* Write the tables that follow from all measurements; status.json. */
sc_status sc_study_write_tables(const sc_study_records *r);
sc_status sc_study_write_state(const sc_study_records *r, const sc_progress_report *report);
/* Make the text of the RO-Crate of a directory that holds a study; write that file. @return
 * SC_ERR_MISSING, SC_ERR_DATA, SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
sc_status sc_study_crate(const sc_ctx *ctx, const char *directory, sc_text *out);
sc_status sc_study_write_crate(const sc_study_records *r);
/* Close the file, and free the results. A zeroed struct is allowed. */
void sc_study_close(sc_study_records *r);

/* ---- study_report.c: pages, on rank 0 ---- */

/* Make the page of a study, and put it into its directory, in place of an earlier one. @return
 * SC_ERR_CREATE also if the name is that of something else than a file; SC_ERR_WRITE,
 * SC_ERR_MEMORY. */
sc_status sc_study_write_page(const sc_ctx *ctx, const char *directory,
                              const sc_measurements *measurements);
/* Find out whether a directory holds a study, which may be damaged. @return SC_ERR_WRITE,
 * SC_ERR_MEMORY. */
sc_status sc_study_is_in(const sc_ctx *ctx, const char *directory, bool *out);
/* Read the measurements in a directory. @return SC_ERR_MISSING, SC_ERR_DATA, SC_ERR_MEMORY. Caller
 * owns *out: sc_measurements_clear. */
sc_status sc_study_read(const sc_ctx *ctx, const char *directory, sc_measurements *out);

/* ---- study_schedule.c: which cell is measured next, on rank 0; pure but for its arrays ---- */

/* What the first look at a cell has told. */
typedef struct sc_cell_cost {
    double load_s;    /* of preparing its volume */
    double measure_s; /* of one measurement, without that */
} sc_cell_cost;

/* The order of measurements. */
typedef struct sc_schedule {
    const sc_cell_info *cells;
    int cell_count;
    sc_cell_cost *costs; /* [cell_count] */
    int *order;          /* [cell_count]: cells of the round */
    int *counts;         /* [cell_count]: measurements of each cell so far */
    uint8_t *done;       /* [cell_count]: it needs no more */
    int round, at;       /* at: index into order of the next cell */
    uint64_t seed;
} sc_schedule;
/* @return whether two cells draw the same prepared volume on the same ranks. */
bool sc_cells_share_volume(const sc_cell_info *a, const sc_cell_info *b);
/* Allocate the arrays; rounds begin with @p round. Caller owns: sc_schedule_clear, also after an
 * error. */
sc_status sc_schedule_init(const sc_ctx *ctx, const sc_cell_info *cells, int cell_count,
                           uint64_t seed, int round, sc_schedule *out);
void sc_schedule_clear(sc_schedule *schedule);
/* @return the next cell that runs here and is not done, in an order that is random in each round,
 * but for cells that share a prepared volume, which follow each other; -1: none is left. */
int sc_schedule_next(sc_schedule *schedule);
/* @return the seconds that @p times measurements of every cell take that runs here, without those
 * that were made before. */
double sc_schedule_estimate_s(const sc_schedule *schedule, int times);

/* ---- study_measure.c: measuring a cell ---- */

/* A measurement lasts at least this long, so that the resolution of clocks does not matter; cells
 * that are faster draw their frames several times. */
#define SC_MEASURED_S 0.1

/* How a cell is measured. */
typedef struct sc_study_way {
    bool pilot; /* only its first frame, once, to find out what the study will take */
    int round;
} sc_study_way;

/* Measure a cell on the ranks that it wants, while the others wait. Collective. @param out on rank
 * 0: the measurement. @return the same on all ranks; SC_ERR_INCOMPLETE after a stop. */
sc_status sc_study_measure(sc_study_state *state, int cell, const sc_study_way *way,
                           sc_measurement *out);
/* Close the session that is held, and all communicators of parts. Collective. */
void sc_study_release(sc_study_state *state);

#endif
