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
