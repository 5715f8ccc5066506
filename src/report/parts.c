/* SPDX-License-Identifier: BSD-3-Clause */
/* Parts that several pages have: sizes, links to files, the text of a file. */
#include "internal.h"

#include <unistd.h>

enum {
    FILE_BYTES_MAX = 1 << 20, /* the largest file that is shown, and how much of it */
    FILE_BYTES_SHOWN = 1 << 16
};

const char *sc_report_size(uint64_t bytes, char text[32])
{
    static const char *const units[] = {"bytes", "kB", "MB", "GB", "TB"};
    double value = (double)bytes;
    size_t unit = 0;

    while (value >= 999.5 && unit + 1 < SC_COUNT_OF(units)) {
        value /= 1000;
        unit++;
    }
    snprintf(text, 32, "%.*f %s", unit && value < 99.95 ? 1 : 0, value, units[unit]);
    return text;
}

/* Write DIR/NAME into @p path. */
static void join(const char *directory, const char *name, char path[SC_REPORT_PATH_BYTES])
{
    const int used = snprintf(path, SC_REPORT_PATH_BYTES, "%s/", directory);

    if (used < SC_REPORT_PATH_BYTES)
        snprintf(path + used, (size_t)(SC_REPORT_PATH_BYTES - used), "%s", name);
}

void sc_report_link(sc_page *page, const char *directory, const char *name, const char *what)
{
    char path[SC_REPORT_PATH_BYTES];

    join(directory, name, path);
    if (access(path, R_OK) != 0)
        return;
    sc_page_add(page, "<li><a href=\"");
    sc_page_address(page, name);
    sc_page_add(page, "\">");
    sc_page_text(page, name);
    sc_page_add(page, "</a>: %s</li>\n", what);
}

void sc_report_file(sc_page *page, const char *directory, const char *name, const char *summary)
{
    const sc_ctx looking = sc_quiet(page->ctx);
    char path[SC_REPORT_PATH_BYTES];
    char *text = NULL;
    size_t bytes = 0;
    sc_status status = page->status;

    join(directory, name, path);
    if (status == SC_OK)
        status = sc_file_read(&looking, path, FILE_BYTES_MAX, &text, &bytes);
    if (status == SC_OK) {
        sc_page_add(page, "<details><summary>%s</summary>\n<pre>", summary);
        sc_page_textf(page, "%.*s", FILE_BYTES_SHOWN, text);
        sc_page_add(page, "</pre>\n");
        if (bytes > FILE_BYTES_SHOWN)
            sc_page_add(page, "<p>The rest stands in %s.</p>\n", name);
        sc_page_add(page, "</details>\n");
    } else if (sc_is_of_input(status)) {
        sc_page_add(page, "<p>%s cannot be read.</p>\n", name);
    } else {
        page->status = status;
    }
    sc_free(text);
}

/* What a cause is called, and its colour; -1: none, because nothing is known of it. */
static const struct {
    const char *word;
    int color;
} causes[SC_CAUSE_COUNT] = {
    [SC_CAUSE_DRAW] = {"drawing", SC_PHASE_RENDER},
    [SC_CAUSE_READ] = {"reading", SC_PHASE_READ},
    [SC_CAUSE_PREPARE] = {"preparing", SC_PHASE_PREPARE},
    [SC_CAUSE_SHARE] = {"sharing the volume", SC_PHASE_SHARE},
    [SC_CAUSE_WAIT] = {"waiting for other ranks", SC_PHASE_IDLE},
    [SC_CAUSE_IDLE] = {"idle, without a work unit", SC_PHASE_IDLE},
    [SC_CAUSE_GATHER] = {"passing messages", SC_PHASE_GATHER},
    [SC_CAUSE_ENCODE] = {"encoding and writing", SC_PHASE_ENCODE},
    [SC_CAUSE_THREADS] = {"threads waiting for each other or for a core", SC_PHASE_WRITE},
    [SC_CAUSE_OTHER] = {"all else", -1}};

const char *sc_report_cause(sc_cause cause)
{
    return causes[cause].word;
}

void sc_report_core_row(sc_row_chart *rows, const char *label, const sc_core_time *time)
{
    double at = 0, sum_s = 0;
    char what[700], value[32];
    size_t used = 0;

    for (int i = 0; i < SC_CAUSE_COUNT; i++)
        sum_s += time->causes_s[i];
    sum_s = sum_s > 0 ? sum_s : 1;
    what[0] = '\0';
    for (int i = 0; i < SC_CAUSE_COUNT && used < sizeof what; i++) {
        if (time->causes_s[i] > 0)
            used +=
                (size_t)snprintf(what + used, sizeof what - used, "%s%s %.1f %%", used ? ", " : "",
                                 causes[i].word, 100 * time->causes_s[i] / sum_s);
    }
    sc_row_begin(rows, label, what);
    for (int i = 0; i < SC_CAUSE_COUNT; i++) {
        const double share = 100 * time->causes_s[i] / sum_s;

        if (causes[i].color >= 0)
            sc_row_bar(rows, at, at + share, sc_phase_color((sc_phase)causes[i].color));
        at += share;
    }
    snprintf(value, sizeof value, "%.1f %%", 100 * time->causes_s[SC_CAUSE_DRAW] / sum_s);
    sc_row_end(rows, value);
}

sc_row_chart sc_report_core_begin(sc_page *page)
{
    static const char *const names[] = {"drawing",
                                        "reading",
                                        "preparing",
                                        "sharing the volume",
                                        "passing messages",
                                        "encoding and writing",
                                        "threads waiting for each other or for a core",
                                        "waiting for other ranks, or idle"};
    static const sc_phase phases[] = {SC_PHASE_RENDER, SC_PHASE_READ,   SC_PHASE_PREPARE,
                                      SC_PHASE_SHARE,  SC_PHASE_GATHER, SC_PHASE_ENCODE,
                                      SC_PHASE_WRITE,  SC_PHASE_IDLE};
    int colors[SC_COUNT_OF(phases)];

    for (size_t i = 0; i < SC_COUNT_OF(phases); i++)
        colors[i] = sc_phase_color(phases[i]);
    sc_legend(page, names, colors, SC_COUNT_OF(phases));
    return sc_rows_begin(page, "Where the time of the cores went: what is not drawing is overhead",
                         sc_axis_to(100, 5, false), false);
}
