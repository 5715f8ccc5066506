/* SPDX-License-Identifier: BSD-3-Clause */
/* Rows with a common axis: a label, a strip of bars, a value. */
#include "internal.h"

#include <math.h>

sc_row_chart sc_rows_begin(sc_page *page, const char *caption, sc_axis axis, bool thin)
{
    sc_page_add(page, "<figure%s>\n<figcaption>", thin ? " class=\"thin\"" : "");
    sc_page_text(page, caption);
    sc_page_add(page, "</figcaption>\n");
    return (sc_row_chart){page, axis, thin};
}

void sc_row_begin(sc_row_chart *rows, const char *label, const char *description)
{
    sc_page *page = rows->page;

    sc_page_add(page, "<div class=\"row\"><span>");
    sc_page_text(page, label);
    sc_page_add(page, "</span><svg class=\"strip\" role=\"img\"><title>");
    sc_page_textf(page, "%s: %s", label, description);
    sc_page_add(page, "</title>");
}

void sc_row_bar(sc_row_chart *rows, double from, double to, int color)
{
    const double begin = sc_axis_percent(&rows->axis, from);
    const double end = sc_axis_percent(&rows->axis, to);

    if (end > begin)
        sc_page_add(rows->page,
                    "<rect class=\"bar c%d\" x=\"%.3f%%\" width=\"%.3f%%\" height=\"100%%\"/>",
                    color, begin, end - begin);
}

void sc_row_dots(sc_row_chart *rows, const double *values, int count)
{
    for (int i = 0; i < count; i++)
        sc_page_add(rows->page, "<circle class=\"dot\" cx=\"%.3f%%\" cy=\"50%%\" r=\"3\"/>",
                    sc_axis_percent(&rows->axis, values[i]));
}

void sc_row_interval(sc_row_chart *rows, double low, double high)
{
    const double begin = sc_axis_percent(&rows->axis, low);
    const double end = sc_axis_percent(&rows->axis, high);

    sc_page_add(rows->page,
                "<line class=\"interval\" x1=\"%.3f%%\" x2=\"%.3f%%\" y1=\"50%%\" y2=\"50%%\"/>"
                "<line class=\"interval\" x1=\"%.3f%%\" x2=\"%.3f%%\" y1=\"25%%\" y2=\"75%%\"/>"
                "<line class=\"interval\" x1=\"%.3f%%\" x2=\"%.3f%%\" y1=\"25%%\" y2=\"75%%\"/>",
                begin, end, begin, begin, end, end);
}

/* Add one path for all that was done of a kind. Where something new begins, a thin gap is left, if
 * what follows is longer than that. */
static void add_kind(sc_page *page, const int8_t *kinds, const bool *begins, int count, int kind)
{
    sc_page_add(page, "<path class=\"c%d\" d=\"", kind);
    for (int i = 0, end; i < count; i = end) {
        end = i + 1;
        if (kinds[i] != kind)
            continue;
        while (end < count && kinds[end] == kind && !begins[end])
            end++;
        sc_page_add(page, "M%d%s 0V1H%dV0z", i, end - i > 3 ? ".7" : "", end);
    }
    sc_page_add(page, "\"/>");
}

void sc_row_strip(sc_row_chart *rows, const int8_t *kinds, const bool *begins, int count)
{
    bool there[SC_SERIES_COLORS] = {false};

    for (int i = 0; i < count; i++) {
        if (kinds[i] >= 0)
            there[kinds[i]] = true;
    }
    sc_page_add(rows->page,
                "<svg width=\"100%%\" height=\"100%%\" viewBox=\"0 0 %d 1\" "
                "preserveAspectRatio=\"none\">",
                count);
    for (int kind = 0; kind < SC_SERIES_COLORS; kind++) {
        if (there[kind])
            add_kind(rows->page, kinds, begins, count, kind);
    }
    sc_page_add(rows->page, "</svg>");
}

void sc_row_end(sc_row_chart *rows, const char *value)
{
    sc_page_add(rows->page, "</svg>");
    if (!rows->thin) {
        sc_page_add(rows->page, "<span class=\"value\">");
        sc_page_text(rows->page, value);
        sc_page_add(rows->page, "</span>");
    }
    sc_page_add(rows->page, "</div>\n");
}

void sc_rows_end(sc_row_chart *rows, const char *label)
{
    sc_page *page = rows->page;

    sc_page_add(page, "<div class=\"row\"><span></span><svg class=\"scale\" aria-hidden=\"true\">");
    for (int i = 0; i < sc_axis_ticks(&rows->axis); i++) {
        const double value = sc_axis_tick(&rows->axis, i);
        const double at = sc_axis_percent(&rows->axis, value);

        sc_page_add(page,
                    "<line class=\"grid\" x1=\"%.2f%%\" x2=\"%.2f%%\" y1=\"0\" y2=\"5\"/>"
                    "<text x=\"%.2f%%\" y=\"18\" text-anchor=\"%s\">%.*f</text>",
                    at, at, at,
                    at < 1    ? "start"
                    : at > 96 ? "end"
                              : "middle",
                    rows->axis.decimals, value);
    }
    sc_page_add(page, "<text x=\"50%%\" y=\"34\" text-anchor=\"middle\">");
    sc_page_text(page, label);
    sc_page_add(page, "</text></svg>%s</div>\n</figure>\n",
                rows->thin ? "" : "<span class=\"value\"></span>");
}
