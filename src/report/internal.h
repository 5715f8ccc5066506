/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to report. Files call only functions of files that are named further down here:
 * compare_page.c, run_page.c, study_compare.c, study_markdown.c, study_page.c, study_words.c,
 * study_plots.c, study_view.c, activity.c, frames.c, heat.c, parts.c, rows.c, svg.c, html.c,
 * style.c. */
#ifndef SC_REPORT_INTERNAL_H
#define SC_REPORT_INTERNAL_H

#include "segcast/core_time.h"
#include "segcast/report.h"

/* ---- activity.c: what each thread did when ---- */

/* Add the section with the activity of the threads to @p page, from the trace of a run, whose ranks
 * are in @p stats; or why there is none. @param path that of trace.json. */
void sc_report_activity(sc_page *page, const char *path, const sc_run_stats *stats);

/* ---- frames.c: the cost of the frames along the film, with some of them ---- */

/* Add the section with the cost along the film to @p page. */
void sc_report_frames(sc_page *page, const sc_report_run *run, const sc_run_stats *stats);

/* ---- heat.c: the work of each pixel ---- */

/* Add the section with the heat pictures of a run to @p page, if there are any. */
void sc_report_heat(sc_page *page, const sc_run_stats *stats);

/* ---- parts.c: parts that several pages have ---- */

enum { SC_REPORT_PATH_BYTES = 4096 };
/* Write a size as people read it, "12.3 MB", into @p text. @return it. */
const char *sc_report_size(uint64_t bytes, char text[32]);
/* Add an item of a list with a link to a file of the directory, if the file is there. @param what
 * it holds, as HTML. */
void sc_report_link(sc_page *page, const char *directory, const char *name, const char *what);
/* Add the text of a file of the directory, which is shown when @p summary is chosen. @param name
 * and @param summary as HTML. */
void sc_report_file(sc_page *page, const char *directory, const char *name, const char *summary);

/* @return what a cause of overhead is called; static. */
const char *sc_report_cause(sc_cause cause);
/* Begin rows of bars, each of which splits 100 % of the time of cores by cause, with a legend; add
 * such a row, with the share of drawing at its end. The caller ends the rows. */
sc_row_chart sc_report_core_begin(sc_page *page);
void sc_report_core_row(sc_row_chart *rows, const char *label, const sc_core_time *time);

/* ---- style.c ---- */

/* The style of all pages, without the colours of series. */
extern const char sc_page_style[];

/* @return what a phase is called in a report, such as "drawing"; static. */
const char *sc_phase_word(sc_phase phase);
/* @return the index of the colour of a phase. */
int sc_phase_color(sc_phase phase);

#endif
