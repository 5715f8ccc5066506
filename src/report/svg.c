/* SPDX-License-Identifier: BSD-3-Clause */
/* Axes and plots as inline SVG. The outer svg has no view box: what stands in it, such as ticks, is
 * placed in percent. Lines and areas are in an inner one that is stretched over the plot, 1000 wide
 * and 1000 high. */
#include "internal.h"

#include <math.h>

/* ---- axes ---- */

/* @return the number of decimals with which multiples of @p step can be told apart. */
static int decimals_of(double step)
{
    const double digits = -floor(log10(step) + 1e-9);

    return digits > 0 ? (digits < 9 ? (int)digits : 9) : 0;
}

sc_axis sc_axis_make(double low, double high, int ticks)
{
    double power, rest, step;
    sc_axis axis;

    if (!isfinite(low) || !isfinite(high) || low > high)
        low = high = 0;
    if (high - low <= 1e-12 * fmax(fabs(low), fabs(high)))
        high = low + (low == 0 ? 1 : fabs(low));
    power = pow(10, floor(log10((high - low) / ticks)));
    rest = (high - low) / ticks / power;
    step = power * (rest < 1.5 ? 1 : rest < 3.5 ? 2 : rest < 7.5 ? 5 : 10);
    axis = (sc_axis){.low = step * floor(low / step + 1e-9),
                     .high = step * ceil(high / step - 1e-9),
                     .step = step,
                     .decimals = decimals_of(step)};
    return axis;
}

sc_axis sc_axis_to(double high, int ticks, bool whole)
{
    sc_axis axis = sc_axis_make(0, high, ticks);

    if (whole && axis.step < 1) {
        axis.step = 1;
        axis.decimals = 0;
    }
    if (isfinite(high) && high > 0)
        axis.high = high;
    return axis;
}

sc_axis sc_axis_doubling(double low, double high)
{
    enum { TICKS_MOST = 12 };
    sc_axis axis = {.low = 0, .high = 1, .step = 1, .doubles = true};

    if (isfinite(low) && isfinite(high) && low > 0 && high >= low) {
        axis.low = floor(log2(low) + 1e-9);
        axis.high = fmax(axis.low + 1, ceil(log2(high) - 1e-9));
    }
    axis.step = ceil((axis.high - axis.low + 1) / TICKS_MOST);
    return axis;
}

double sc_axis_percent(const sc_axis *axis, double value)
{
    if (axis->doubles)
        value = value > 0 ? log2(value) : axis->low;
    return 100 * (value - axis->low) / (axis->high - axis->low);
}

int sc_axis_ticks(const sc_axis *axis)
{
    return (int)floor((axis->high - axis->low) / axis->step + 1e-6) + 1;
}

double sc_axis_tick(const sc_axis *axis, int i)
{
    const double at = axis->low + i * axis->step;

    return axis->doubles ? exp2(at) : at;
}

/* ---- plots ---- */

/* Write the label of a tick. */
static void label_tick(const sc_axis *axis, int i, char text[32])
{
    if (axis->doubles)
        snprintf(text, 32, "%g", sc_axis_tick(axis, i));
    else
        snprintf(text, 32, "%.*f", axis->decimals, sc_axis_tick(axis, i));
}

/* Draw grid lines and the labels of ticks. */
static void draw_axes(const sc_plot *plot, const char *x_label)
{
    sc_page *page = plot->page;
    char text[32];

    for (int i = 0; i < sc_axis_ticks(&plot->y); i++) {
        const double at = 100 - sc_axis_percent(&plot->y, sc_axis_tick(&plot->y, i));

        label_tick(&plot->y, i, text);
        sc_page_add(page,
                    "<line class=\"grid\" x1=\"0\" x2=\"100%%\" y1=\"%.2f%%\" y2=\"%.2f%%\"/>"
                    "<text x=\"0\" y=\"%.2f%%\" dx=\"-8\" dy=\"4\" text-anchor=\"end\">%s</text>\n",
                    at, at, at, text);
    }
    for (int i = 0; i < sc_axis_ticks(&plot->x); i++) {
        const double at = sc_axis_percent(&plot->x, sc_axis_tick(&plot->x, i));

        label_tick(&plot->x, i, text);
        sc_page_add(page,
                    "<text x=\"%.2f%%\" y=\"100%%\" dy=\"18\" text-anchor=\"middle\">%s</text>\n",
                    at, text);
    }
    sc_page_add(page, "<text x=\"50%%\" y=\"100%%\" dy=\"36\" text-anchor=\"middle\">");
    sc_page_text(page, x_label);
    sc_page_add(page, "</text>\n");
}

sc_plot sc_plot_begin(sc_page *page, const sc_plot_words *words, sc_axis x, sc_axis y)
{
    sc_plot plot = {page, x, y};
    const int number = ++page->plots;

    sc_page_add(page, "<figure>\n<figcaption>");
    sc_page_text(page, words->caption);
    sc_page_add(page,
                "</figcaption>\n<svg class=\"plot\" role=\"img\" aria-labelledby=\"title%d "
                "desc%d\"><title id=\"title%d\">",
                number, number, number);
    sc_page_text(page, words->caption);
    sc_page_add(page, "</title><desc id=\"desc%d\">", number);
    sc_page_text(page, words->description);
    sc_page_add(page, "</desc>\n");
    draw_axes(&plot, words->x_label);
    return plot;
}

/* Begin and end what is stretched over the plot. */
static void begin_stretched(sc_page *page)
{
    sc_page_add(page, "<svg width=\"100%%\" height=\"100%%\" viewBox=\"0 0 1000 1000\" "
                      "preserveAspectRatio=\"none\">");
}

static void end_stretched(sc_page *page)
{
    sc_page_add(page, "</svg>\n");
}

/* Add the coordinates of a point, within the plot. */
static void add_point(const sc_plot *plot, double x, double y)
{
    sc_page_add(plot->page, "%.1f %.1f ", 10 * sc_axis_percent(&plot->x, x),
                1000 - 10 * sc_axis_percent(&plot->y, y));
}

void sc_plot_line(sc_plot *plot, const double *x, const double *y, int count, int color,
                  bool dashed)
{
    sc_page *page = plot->page;
    bool pen = false;

    begin_stretched(page);
    sc_page_add(page, "<path class=\"c%d line%s\" style=\"fill: none\" d=\"", color,
                dashed ? " dashed" : "");
    for (int i = 0; i < count; i++) {
        const bool there = isfinite(y[i]);
        const bool alone = there && !pen && (i + 1 == count || !isfinite(y[i + 1]));

        if (there)
            sc_page_add(page, pen ? "" : "M");
        if (there)
            add_point(plot, x[i], y[i]);
        if (alone) /* a point by itself is a line without length, which round ends show */
            sc_page_add(page, "h0.1 ");
        pen = there;
    }
    sc_page_add(page, "\"/>");
    end_stretched(page);
}

void sc_plot_band(sc_plot *plot, const double *x, const double *low, const double *high, int count,
                  int color)
{
    sc_page *page = plot->page;

    begin_stretched(page);
    sc_page_add(page, "<path class=\"c%d band\" d=\"M", color);
    for (int i = 0; i < count; i++)
        add_point(plot, x[i], high[i]);
    for (int i = count - 1; i >= 0; i--)
        add_point(plot, x[i], low[i]);
    sc_page_add(page, "z\"/>");
    end_stretched(page);
}

void sc_plot_points(sc_plot *plot, const double *x, const double *y, int count, int color)
{
    sc_page *page = plot->page;

    begin_stretched(page);
    sc_page_add(page, "<path class=\"c%d dots\" d=\"", color);
    for (int i = 0; i < count; i++) { /* lines without length, of which the round ends are seen */
        sc_page_add(page, "M");
        add_point(plot, x[i], y[i]);
        sc_page_add(page, "h0");
    }
    sc_page_add(page, "\"/>");
    end_stretched(page);
}

void sc_plot_marks(sc_plot *plot, const double *x, int count)
{
    for (int i = 0; i < count; i++) {
        const double at = sc_axis_percent(&plot->x, x[i]);

        sc_page_add(plot->page,
                    "<line class=\"mark\" x1=\"%.2f%%\" x2=\"%.2f%%\" y1=\"0\" y2=\"100%%\"/>", at,
                    at);
    }
}

void sc_plot_end(sc_plot *plot)
{
    sc_page_add(plot->page, "</svg>\n</figure>\n");
}

void sc_legend(sc_page *page, const char *const *names, const int *colors, int count)
{
    sc_page_add(page, "<ul class=\"legend\">\n");
    for (int i = 0; i < count; i++) {
        sc_page_add(page,
                    "<li><svg aria-hidden=\"true\"><rect class=\"c%d\" width=\"100%%\" "
                    "height=\"100%%\"/></svg>",
                    colors[i]);
        sc_page_text(page, names[i]);
        sc_page_add(page, "</li>\n");
    }
    sc_page_add(page, "</ul>\n");
}
