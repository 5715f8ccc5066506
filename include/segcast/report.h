/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Reports of runs and studies: pages of HTML that need nothing but themselves. A page is text with
 * its style in it and its plots as inline SVG; it has no script, and names no file that is not in
 * its own directory. It is well-formed XML, too. The blocks of which pages are made come first:
 * text, tables, plots and rows of bars; then the pages themselves. All functions are local, one
 * call at a time per page.
 *
 *  Plots have no size of their own: positions in them are shares of their width and height, so that
 *  letters and lines stay as large as they are on a telephone and on a wide screen. */
#ifndef SEGCAST_REPORT_H
#define SEGCAST_REPORT_H

#include "segcast/measurements.h"
#include "segcast/study.h"

/* ---- text ---- */

/** A page that is being written. The first error ends the writing: everything that is added later
 *  is dropped, so only sc_page_end has to be looked at. Owns its text: sc_page_clear. */
typedef struct sc_page {
    const sc_ctx *ctx; /**< where errors go; borrowed */
    sc_text text;
    sc_status status; /**< SC_OK, or the first error */
    int plots;        /**< how many there are so far: they are numbered */
} sc_page;

/** Begin a page, up to its heading. @param title of the page, any text. @return the page; what went
 *  wrong is in its status. Caller owns: sc_page_clear. */
sc_page sc_page_begin(const sc_ctx *ctx, const char *title);
/** End the page. @return SC_OK, or the first error of all that was added. */
SC_MUST_USE sc_status sc_page_end(sc_page *page);
/** Free the text of @p page, which is empty then. An empty one is allowed. */
void sc_page_clear(sc_page *page);
/** Add HTML as it is; for fixed markup and numbers, never for a text that comes from outside. */
void sc_page_add(sc_page *page, const char *fmt, ...) SC_PRINTF(2, 3);
/** Add any text so that it is shown as it is, also within an attribute: characters that HTML obeys
 *  are escaped, those that a terminal or the order of writing obeys are shown as of sc_printable;
 *  newlines and tabs stay. */
void sc_page_text(sc_page *page, const char *text);
/** As sc_page_text, of a formatted text. */
void sc_page_textf(sc_page *page, const char *fmt, ...) SC_PRINTF(2, 3);
/** As sc_page_text; what stands between backquotes is shown as code. */
void sc_page_prose(sc_page *page, const char *text);
/** Add the name of a file as a relative address, for an attribute. */
void sc_page_address(sc_page *page, const char *name);
/** Add bytes in base 64, for a data address. */
void sc_page_base64(sc_page *page, const void *data, size_t bytes);
/** Begin a section with a heading. */
void sc_page_section(sc_page *page, const char *heading);
/** End the section. */
void sc_page_section_end(sc_page *page);

/* ---- tables ---- */

enum { SC_TABLE_COLUMNS_MAX = 16 };
/** A table that is being filled, cell by cell. */
typedef struct sc_table {
    sc_page *page;
    const char *const *heads;
    int columns, column; /**< column: of the next cell */
} sc_table;
/** Begin a table. On narrow screens each row becomes a block, with the heads before the values.
 *  @param heads [columns], at most SC_TABLE_COLUMNS_MAX; borrowed until the table ends. */
sc_table sc_table_begin(sc_page *page, const char *caption, const char *const *heads, int columns);
/** Add the next cell; the first of each row is the head of the row. */
void sc_table_cell(sc_table *table, const char *fmt, ...) SC_PRINTF(2, 3);
/** End the table; the last row is whole. */
void sc_table_end(sc_table *table);

/** Begin a list of facts, each with a name. */
void sc_facts_begin(sc_page *page);
/** Add a fact. */
void sc_fact(sc_page *page, const char *name, const char *fmt, ...) SC_PRINTF(3, 4);
/** End the list. */
void sc_facts_end(sc_page *page);

/* ---- axes and colours ---- */

/** The number of colours for series, and the one that stands for waiting. Every two of them differ
 *  for the colour-blind, too. */
enum { SC_SERIES_COLORS = 8, SC_COLOR_IDLE = 7 };
/** The colours, as sRGB. */
extern const uint8_t sc_series_colors[SC_SERIES_COLORS][3];

/** An axis with ticks at low, low + step, ..., high. */
typedef struct sc_axis {
    double low, high, step;
    int decimals; /**< that the labels of ticks need */
    bool doubles; /**< logarithmic: low, high and step are logarithms to the base 2 */
} sc_axis;
/** @return an axis on which @p low and @p high lie, with about @p ticks steps (at least 1) of 1, 2
 *  or 5 times a power of ten. Of values that are equal or not finite: an axis from 0 to 1 or around
 *  the value. */
sc_axis sc_axis_make(double low, double high, int ticks);
/** @return an axis from 0 to exactly @p high, with ticks as of sc_axis_make, which need not reach
 * its end. @param whole they are whole numbers. */
sc_axis sc_axis_to(double high, int ticks, bool whole);
/** @return a logarithmic axis on which @p low and @p high lie, both above 0, with ticks at powers
 * of two, at most 12. Of other values: an axis from 1 to 2. */
sc_axis sc_axis_doubling(double low, double high);
/** @return where @p value lies, in percent of the axis from its beginning; on a logarithmic axis 0
 *  for values that are not above 0. */
double sc_axis_percent(const sc_axis *axis, double value);
/** @return the number of ticks. */
int sc_axis_ticks(const sc_axis *axis);
/** @return the value at the tick @p i, counted from 0. */
double sc_axis_tick(const sc_axis *axis, int i);

/* ---- plots ---- */

/** A plot that is being drawn. */
typedef struct sc_plot {
    sc_page *page;
    sc_axis x, y;
} sc_plot;
/** What a plot is, in words. */
typedef struct sc_plot_words {
    const char *caption;     /**< what is shown, with its unit */
    const char *description; /**< what is to be seen, for those who cannot see it */
    const char *x_label;     /**< what the horizontal axis counts */
} sc_plot_words;
/** Begin a plot with its frame and axes. */
sc_plot sc_plot_begin(sc_page *page, const sc_plot_words *words, sc_axis x, sc_axis y);
/** Draw a line through the points (x[i], y[i]), i below @p count; it has a gap where y[i] is NaN.
 *  @param color index of a colour. */
void sc_plot_line(sc_plot *plot, const double *x, const double *y, int count, int color,
                  bool dashed);
/** Fill what lies between @p low and @p high [count] at @p x; all are finite. */
void sc_plot_band(sc_plot *plot, const double *x, const double *low, const double *high, int count,
                  int color);
/** Draw a dot at each point (x[i], y[i]), i below @p count; all are finite. */
void sc_plot_points(sc_plot *plot, const double *x, const double *y, int count, int color);
/** Mark places of the horizontal axis by lines. */
void sc_plot_marks(sc_plot *plot, const double *x, int count);
/** End the plot. */
void sc_plot_end(sc_plot *plot);
/** Add a list of names with their colours, names[i] with colors[i]. */
void sc_legend(sc_page *page, const char *const *names, const int *colors, int count);

/* ---- rows: bars side by side, or what threads did when ---- */

/** Rows with a common horizontal axis. */
typedef struct sc_row_chart {
    sc_page *page;
    sc_axis axis;
    bool thin; /**< rows are low, so that many fit */
} sc_row_chart;
/** Begin rows. @param caption what is shown, with its unit. */
sc_row_chart sc_rows_begin(sc_page *page, const char *caption, sc_axis axis, bool thin);
/** Begin a row. @param description what the row shows, for those who cannot see it. */
void sc_row_begin(sc_row_chart *rows, const char *label, const char *description);
/** Draw a bar from one value of the axis to another. */
void sc_row_bar(sc_row_chart *rows, double from, double to, int color);
/** Draw dots at @p values [count], those of which a bar shows the median. */
void sc_row_dots(sc_row_chart *rows, const double *values, int count);
/** Draw a line from @p low to @p high over a bar: how exactly its end is known. */
void sc_row_interval(sc_row_chart *rows, double low, double high);
/** Draw what happened when: kinds[i], i below @p count, is what was done in the i-th of @p count
 *  equal parts of the axis, as index of a colour, or -1; begins[i]: something new begins there. */
void sc_row_strip(sc_row_chart *rows, const int8_t *kinds, const bool *begins, int count);
/** End the row. @param value text at its end; "": none. */
void sc_row_end(sc_row_chart *rows, const char *value);
/** End the rows, with their axis. @param label what the axis counts. */
void sc_rows_end(sc_row_chart *rows, const char *label);

/* ---- pages ---- */

/** The most frames that a page shows as small pictures, and their longer side in pixels. */
enum { SC_REPORT_PICTURES = 8, SC_REPORT_PICTURE_SIDE = 200 };

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
