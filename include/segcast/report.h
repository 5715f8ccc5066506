/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Reports of runs and studies: pages that need nothing but the film beside them (page.h draws
 *  them), and tables for documents. All functions are local. */
#ifndef SEGCAST_REPORT_H
#define SEGCAST_REPORT_H

#include "segcast/measurements.h"
#include "segcast/study.h"

/** The most frames that a page shows as small pictures, and their longer side in pixels. */
enum { SC_REPORT_PICTURES = 8, SC_REPORT_PICTURE_SIDE = 120 };

/** A run as it lies in its directory. All texts are borrowed. */
typedef struct sc_report_run {
    const char *directory;
    const char *slice; /**< name of the slice; NULL: the whole job */
    const char *title; /**< of the film; empty: none */
    const char *video; /**< name of the video in the directory, which may be missing, or "none" */
    bool png;          /**< frames may be there as PNG files */
    int frames, fps;   /**< of the whole film */
} sc_report_run;
/** Make the page of a run from what its directory holds: stats.json, trace.json, job.yaml, and of
 *  the video or the PNG files some frames. The same files give the same bytes. What is missing or
 *  damaged but for stats.json is left out, which the page says.
 *  @return SC_ERR_MISSING, SC_ERR_DATA: stats.json; SC_ERR_MEMORY. Caller owns @p out:
 *  sc_text_clear. */
SC_MUST_USE sc_status sc_report_make(const sc_ctx *ctx, const sc_report_run *run, sc_text *out);

/** Make the page of a timing study from its measurements, with links to the files of @p directory.
 *  The same measurements give the same bytes. @return SC_ERR_MEMORY. Caller owns @p out:
 *  sc_text_clear. */
SC_MUST_USE sc_status sc_report_study(const sc_ctx *ctx, const char *directory,
                                      const sc_measurements *measurements, sc_text *out);

/** Write the results of a study as tables in Markdown: the values of one axis (the skip methods, or
 *  the last axis of the job) as columns, with times, work, preparation and memory; of a study over
 *  ranks or threads a row for each cell. If the two methods of the paper are compared, its times
 *  stand beside them. @return SC_ERR_MEMORY. Caller owns @p out: sc_text_clear. */
SC_MUST_USE sc_status sc_report_study_markdown(const sc_ctx *ctx,
                                               const sc_measurements *measurements, sc_text *out);

/** Make a page that compares several studies, cell by cell of the same name, with the first one.
 *  @param directories [count], at least 1: their names. @param measurements [count], theirs.
 *  @return SC_ERR_MEMORY. Caller owns @p out: sc_text_clear. */
SC_MUST_USE sc_status sc_report_compare_studies(const sc_ctx *ctx, const char *const *directories,
                                                const sc_measurements *measurements, int count,
                                                sc_text *out);

/** Make a page that compares the last runs in @p directories [count], at least 1, by what their
 *  stats.json say; they are named as given. @return SC_ERR_MISSING, SC_ERR_DATA, naming the first
 *  file that is wrong; SC_ERR_MEMORY. Caller owns @p out: sc_text_clear. */
SC_MUST_USE sc_status sc_report_compare(const sc_ctx *ctx, const char *const *directories,
                                        int count, sc_text *out);

#endif
