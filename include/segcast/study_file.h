/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  A study file: which job is measured, what is varied from one cell of the study to the next, and
 *  how long and how exactly each cell is measured. Read by the module job, with the rules of job
 *  files. Local functions; nothing is collective. */
#ifndef SEGCAST_STUDY_FILE_H
#define SEGCAST_STUDY_FILE_H

#include "segcast/job.h"

/** The most axes of a study, and the most cells. */
enum { SC_STUDY_AXES_MAX = 16, SC_STUDY_CELLS_MAX = 10000 };

/** What is measured of a cell. */
typedef enum sc_study_subject {
    SC_STUDY_FRAMES, /**< drawing and gathering frames of a volume that is prepared already */
    SC_STUDY_JOB     /**< the whole job: reading, preparing, drawing, encoding and writing */
} sc_study_subject;
/** Which time decides when a cell has been measured exactly enough. */
typedef enum sc_study_metric { SC_STUDY_CPU, SC_STUDY_WALL } sc_study_metric;

/** Settings of the job, and of the machine, that hold together. */
typedef struct sc_study_settings {
    sc_setting *items; /**< [count], owned with their texts */
    size_t count;
    int ranks, threads; /**< 0: not set here */
    int placement;      /**< an sc_comm_choice; -1: not set here */
} sc_study_settings;

/** One value of an axis. */
typedef struct sc_study_value {
    char *name; /**< as in the file, such as "leap" or "512x512"; owned */
    sc_study_settings settings;
} sc_study_value;

/** An axis: what is varied. The cells of a study are all combinations of the values of its axes. */
typedef struct sc_study_axis {
    char *name;             /**< such as "render.skip"; owned */
    sc_study_value *values; /**< [value_count], at least 1, owned */
    int value_count;
} sc_study_axis;

/** A study. Members that hold an enum are of type int, as in sc_job. */
typedef struct sc_study {
    char title[256];
    char job[SC_PATH_BYTES];        /**< the job file; empty: there are settings only */
    sc_study_settings set;          /**< what holds for all cells */
    sc_study_axis *axes;            /**< [axis_count], owned */
    int axis_count;                 /**< 0: the study has one cell */
    char job_where[SC_WHERE_BYTES]; /**< "file:line" of it, for messages; may be empty */
    int measure;                    /**< sc_study_subject */
    int metric;                     /**< sc_study_metric */
    char frames[256]; /**< a list for sc_frames_parse, or empty: four of the animation */
    double precision; /**< half the confidence interval of the median, of the median */
    int least, most;  /**< measurements of each cell */
    double budget_s;  /**< for the whole study */
    int seed;         /**< of the random order */
} sc_study;

/** Read and check a study file. Paths in it become relative to the working directory, as those of
 *  a job do. All mistakes are logged, as far as the text can be read as YAML; the values of keys of
 *  jobs are checked only when a cell's job is loaded.
 *  @param out written also after SC_ERR_DATA: all that was right, without axes that have no values,
 *  so that the caller can look for mistakes in the jobs.
 *  @return SC_ERR_DATA, SC_ERR_MISSING, SC_ERR_MEMORY. Caller owns: sc_study_clear. */
SC_MUST_USE sc_status sc_study_load(const sc_ctx *ctx, const char *path, sc_study *out);
/** Free what a study owns; harmless on a zeroed struct. */
void sc_study_clear(sc_study *study);
/** Append the study to @p text as YAML, every key with its value; sc_study_load reads it back.
 *  @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_study_write(const sc_ctx *ctx, const sc_study *study, sc_text *text);

/** @return the number of cells: the product of the numbers of values. */
int sc_study_cells(const sc_study *study);
/** @return the value of axis @p axis in cell @p cell: the last axis varies fastest. */
const sc_study_value *sc_study_value_of(const sc_study *study, int cell, int axis);
/** Settings that a cell has: those of the study, then those of its values.
 *  @param out borrows from @p study; its array is the caller's: sc_free(out->items). Ranks and
 *  threads stay 0, and placement is SC_COMM_PACKED, where nothing sets them.
 *  @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_study_cell(const sc_ctx *ctx, const sc_study *study, int cell,
                                    sc_study_settings *out);

#endif
