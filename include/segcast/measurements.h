/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What a timing study has measured: a file that grows by a line with every measurement, and the
 *  table of cells that follows from it. Functions of the module study. */
#ifndef SEGCAST_MEASUREMENTS_H
#define SEGCAST_MEASUREMENTS_H

#include "segcast/json_values.h"
#include "segcast/statistics.h"
#include "segcast/study.h"

/** An axis of a study as its results name it. */
typedef struct sc_design_axis {
    char *name;
    char **values; /**< [value_count] */
    int value_count;
} sc_design_axis;

/** What a study varies. Owns everything: sc_design_clear. Cells are the combinations of values, the
 *  last axis varying fastest. */
typedef struct sc_design {
    char *title;
    uint64_t hash; /**< of the study: results of another one are not mixed with it */
    sc_design_axis *axes;
    int axis_count;
    bool whole_jobs; /**< measurements are of whole jobs, not of frames alone */
    bool by_wall;    /**< wall time had to be known exactly, not CPU time */
} sc_design;
/** Free what a design owns; harmless on a zeroed struct. */
void sc_design_clear(sc_design *design);
/** @return the number of cells. */
int sc_design_cells(const sc_design *design);
/** @return the index of the value that axis @p axis has in cell @p cell. */
int sc_design_index(const sc_design *design, int cell, int axis);
/** @return whether two cells differ at most in the axes ranks, threads and placement. */
bool sc_design_is_scaling(const sc_design *design, int cell_a, int cell_b);

/** Times of drawing. */
typedef struct sc_measured_drawing {
    double cpu_s;          /**< CPU seconds of all ranks */
    double most_s, mean_s; /**< wall time: of the busiest rank, the mean */
} sc_measured_drawing;

/** Times of what came before the passes, once. */
typedef struct sc_measured_start {
    double read_s, prepare_s, share_s; /**< wall time */
    double cpu_s;                      /**< CPU seconds of all ranks: reading, preparing, sharing */
    double derive_s, derive_cpu_s;     /**< wall and CPU time of what this cell alone derives from
                                            the prepared volume, such as the octree; a part of
                                            prepare_s */
} sc_measured_start;

/** What was drawn. */
typedef struct sc_measured_work {
    uint64_t rays, samples, contributions;
} sc_measured_work;

/** Memory that was used. */
typedef struct sc_measured_memory {
    uint64_t peak_most_bytes, peak_sum_bytes; /**< resident: largest of all ranks, and their sum */
    uint64_t prepared_bytes;                  /**< of the prepared volume */
} sc_measured_memory;

/** One measurement of a cell: a number of passes over its frames. Times and numbers are of one
 *  pass, the mean of all. A plain value. */
typedef struct sc_measurement {
    int32_t cell, round;           /**< round: how many of all cells came before, from 0 */
    int32_t passes, frames;        /**< frames: of a pass */
    int32_t ranks, nodes, threads; /**< threads: of each rank */
    int64_t begin_unix_s;          /**< seconds since 1970 (UTC) */
    double wall_s, cpu_s;          /**< cpu_s: of all ranks, waiting included */
    sc_measured_drawing draw;
    double idle_mean_s;   /**< for how long a rank had nothing to draw, the mean */
    double gather_mean_s; /**< of passing messages, on a rank's main thread, the mean */
    double accept_s;      /**< rank 0: encoding and writing, beside the drawing */
    sc_measured_start start;
    sc_measured_work work;
    sc_measured_memory memory;
    double energy_j;      /**< energy used by the processors of rank 0's node in one pass; -1: it
                               cannot be read */
    uint64_t pixels_hash; /**< of the hashes of all frames */
} sc_measurement;

/** Where and with what measurements were made: one run of segcast study. Texts are NUL-terminated
 *  and cut off where they do not fit. */
typedef struct sc_study_run {
    char begin[32];
    char host[128], processor[128], mpi[128], version[64], commit[64], batch_job[64];
    char kernel[32]; /**< the variant of kernels that `render.cpu: auto` stands for; empty: unknown
                      */
    int32_t ranks, nodes, cores; /**< cores: that rank 0 may use */
    char *made_from; /**< JSON that names the input files with their SHA-256, as sc_run_record has
                        it; NULL: unknown */
    size_t first;    /**< its first measurement, as an index */
} sc_study_run;

/** @return its texts and numbers as an object, a new reference, or NULL if there is no memory. */
json_t *sc_study_run_json(const sc_study_run *run);

/** A cell that could not be measured. */
typedef struct sc_skipped_cell {
    int cell;
    char *reason; /**< owned */
} sc_skipped_cell;

/** Everything a file of measurements holds. Zero-initialise; owns all, also what runs were made
 * from: sc_measurements_clear. */
typedef struct sc_measurements {
    sc_design design;
    sc_measurement *items;
    size_t count, capacity;
    sc_study_run *runs;
    size_t run_count, run_capacity;
    sc_skipped_cell *skipped; /**< of a cell that was measured later, none */
    size_t skipped_count, skipped_capacity;
    bool complete; /**< the last run measured all that it could */
} sc_measurements;
void sc_measurements_clear(sc_measurements *measurements);
/** Append a measurement. @return SC_ERR_MEMORY, @p to untouched. */
SC_MUST_USE sc_status sc_measurements_append(const sc_ctx *ctx, sc_measurements *to,
                                             const sc_measurement *item);
/** Append, for a cell without measurements, why it was not measured, in place of an earlier reason.
 *  @return SC_ERR_MEMORY, @p to untouched. */
SC_MUST_USE sc_status sc_measurements_skip(const sc_ctx *ctx, sc_measurements *to, int cell,
                                           const char *reason);

/** Read a file of measurements. A last line that is cut off, because the study was killed, is left
 *  out. @param whole_bytes how many bytes come before it. @return SC_ERR_MISSING, SC_ERR_DATA,
 *  SC_ERR_MEMORY. Caller owns *out. */
SC_MUST_USE sc_status sc_measurements_read(const sc_ctx *ctx, const char *path,
                                           sc_measurements *out, uint64_t *whole_bytes);

/** Find out whether @p path begins as a file of measurements, which may be damaged further on.
 *  @return SC_ERR_MEMORY, SC_ERR_WRITE; a file that is missing or another one is no error. */
SC_MUST_USE sc_status sc_measurements_begin(const sc_ctx *ctx, const char *path, bool *out);

/** Make of the runs of a study, and of what they have measured, the history of a directory, without
 * frames. @return SC_ERR_MEMORY. Caller owns *out: sc_history_clear. */
SC_MUST_USE sc_status sc_measurements_history(const sc_ctx *ctx, const sc_measurements *from,
                                              sc_history *out);

/** A file of measurements that is being written. */
typedef struct sc_measurement_file sc_measurement_file;
/** Begin a new file, with the design and @p run in it. @return SC_ERR_CREATE also if the name is
 *  taken. Caller owns *out: sc_measurement_file_close. */
SC_MUST_USE sc_status sc_measurement_file_create(const sc_ctx *ctx, const char *path,
                                                 const sc_design *design, const sc_study_run *run,
                                                 sc_measurement_file **out);
/** Go on with a file of which @p whole_bytes are to be kept, and add @p run. @return SC_ERR_CREATE
 *  if another process writes to it. Caller owns *out: sc_measurement_file_close. */
SC_MUST_USE sc_status sc_measurement_file_resume(const sc_ctx *ctx, const char *path,
                                                 uint64_t whole_bytes, const sc_study_run *run,
                                                 sc_measurement_file **out);
/** Write one measurement, or why a cell is not measured, and flush it to disk.
 *  @return SC_ERR_WRITE, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_measurement_file_add(const sc_ctx *ctx, sc_measurement_file *file,
                                              const sc_measurement *item);
SC_MUST_USE sc_status sc_measurement_file_skip(const sc_ctx *ctx, sc_measurement_file *file,
                                               int cell, const char *reason);
/** Write that the study is complete: the mark on which scripts rely. @return as above. */
SC_MUST_USE sc_status sc_measurement_file_complete(const sc_ctx *ctx, sc_measurement_file *file);
/** Close the file. NULL is allowed. */
void sc_measurement_file_close(sc_measurement_file *file);

/* ---- what follows for each cell ---- */

/** A cell with the statistics of its measurements. All ratios are of medians. */
typedef struct sc_cell_result {
    int cell;
    const char *skipped; /**< why it was not measured; borrowed; NULL: it was, or not yet */
    sc_statistics wall_s, cpu_s;
    sc_measurement typical; /**< the measurement whose CPU time is nearest to the median */
    double frames_per_s, mrays_per_cpu_s;
    double samples_per_ray;
    double imbalance; /**< busiest rank over mean, minus 1 */
    /** Of the cell of this design with the fewest workers (ranks times threads), which differs at
     *  most in them: itself for a study that does not vary them. */
    int base;
    double workers;             /**< ranks times threads */
    double speedup, efficiency; /**< against the base, in rays per second of wall time, so that a
                                     cell may have more to do than its base; 0: without a result */
    double serial_share;        /**< sc_karp_flatt; 0 for the base */
    double cost;                /**< CPU time per ray over that of the base */
} sc_cell_result;

/** Work out the results of all cells. @param out [sc_design_cells]; caller owns: sc_free; borrows
 *  texts of @p measurements. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_cell_results(const sc_ctx *ctx, const sc_measurements *measurements,
                                      sc_cell_result **out);
/** Write a table with a row for each cell as CSV under @p path. @return SC_ERR_CREATE,
 *  SC_ERR_WRITE, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_cells_write_csv(const sc_ctx *ctx, const sc_measurements *measurements,
                                         const sc_cell_result *results, const char *path);
/** Write every measurement as JSON Lines in the format of Extra-P (a line with the parameters, the
 *  metric and its value), for the axes whose values are all numbers. @return as above. */
SC_MUST_USE sc_status sc_cells_write_extrap(const sc_ctx *ctx, const sc_measurements *measurements,
                                            const char *path);
/** @return the cell of a measurement whose pixels are not those of an earlier one that should show
 *  the same picture, or -1. @param from index of the first measurement that is checked.
 *  @param pictures [cells], equal for cells of the same picture. @param other that earlier cell. */
int sc_measurements_mismatch(const sc_measurements *measurements, size_t from,
                             const uint64_t *pictures, int *other);

#endif
