/* SPDX-License-Identifier: BSD-3-Clause */
/* Heat pictures: how much work the rays of each pixel of a frame were. */
#include "internal.h"

#include <stdlib.h>

enum { STEPS = 48 }; /* of the scale of colours */

/* The scale of colours: dark to light, in equal steps of lightness; what has no work is grey. */
static const uint8_t scale[][3] = {{32, 26, 70},  {84, 44, 125},  {156, 56, 120},
                                   {219, 92, 86}, {246, 156, 76}, {250, 226, 140}};
static const uint8_t nothing[3] = {128, 132, 138};

/* Set the colour of a place on the scale, from 0 to 1. */
static void color_at(double at, uint8_t rgb[3])
{
    const int parts = (int)SC_COUNT_OF(scale) - 1;
    const double place = at < 0 ? 0 : at > 1 ? parts : at * parts;
    const int below = place < parts ? (int)place : parts - 1;

    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(scale[below][c] +
                           (place - below) * (scale[below + 1][c] - scale[below][c]) + 0.5);
}

/* What the codes of a picture say together. */
typedef struct summary {
    int histogram[256];
    int low, high, median; /* codes of the pixels with any work; 0: there is none */
    int with_work, pixels;
} summary;

static summary sum_up(const sc_heat *heat, const uint8_t *codes)
{
    summary s = {.pixels = heat->width_px * heat->height_px};
    int below = 0;

    for (int i = 0; i < s.pixels; i++)
        s.histogram[codes[i]]++;
    s.with_work = s.pixels - s.histogram[0];
    for (int code = 1; code < 256; code++) {
        if (s.histogram[code] == 0)
            continue;
        s.low = s.low ? s.low : code;
        s.high = code;
        if (2 * below < s.with_work)
            s.median = code;
        below += s.histogram[code];
    }
    return s;
}

/* Add the scale: colours over the counts that they stand for. */
static void add_scale(sc_page *page, const summary *s, const char *unit)
{
    const double low = sc_heat_count((uint8_t)s->low), high = sc_heat_count((uint8_t)s->high);
    sc_row_chart rows = sc_rows_begin(page, "", sc_axis_doubling(low, high), true);

    sc_row_begin(&rows, "", "the colours from few to many");
    for (int i = 0; i < STEPS; i++) {
        uint8_t rgb[3];

        color_at((i + 0.5) / STEPS, rgb);
        sc_page_add(page,
                    "<rect x=\"%.2f%%\" width=\"%.2f%%\" height=\"100%%\" style=\"fill: "
                    "#%02x%02x%02x\"/>",
                    100.0 * i / STEPS, 100.0 / STEPS + 0.1, rgb[0], rgb[1], rgb[2]);
    }
    sc_row_end(&rows, "");
    sc_rows_end(&rows, unit);
}

/* Add one picture. @param what is counted, as the unit of the scale. */
static void add_picture(sc_page *page, const sc_heat *heat, const uint8_t *codes, const char *what)
{
    const summary s = sum_up(heat, codes);
    const sc_axis axis =
        sc_axis_doubling(sc_heat_count((uint8_t)s.low), sc_heat_count((uint8_t)s.high));
    char words[200];
    sc_image image = {0};
    char *data = NULL;
    size_t bytes = 0;

    if (s.with_work == 0 || page->status != SC_OK)
        return;
    page->status = sc_image_init(page->ctx, heat->width_px, heat->height_px, &image);
    for (int i = 0; i < s.pixels && page->status == SC_OK; i++) {
        if (codes[i])
            color_at(sc_axis_percent(&axis, sc_heat_count(codes[i])) / 100, &image.rgb[3 * i]);
        else
            for (int c = 0; c < 3; c++)
                image.rgb[3 * i + c] = nothing[c];
    }
    if (page->status == SC_OK)
        page->status = sc_image_compress_png(page->ctx, &image, "a heat picture", &data, &bytes);
    sc_image_clear(&image);
    snprintf(
        words, sizeof words,
        "Frame %d: %s, from %.0f to %.0f, median %.0f, where there are any; none in %.0f %% of "
        "the pixels (grey)",
        heat->frame, what, sc_heat_count((uint8_t)s.low), sc_heat_count((uint8_t)s.high),
        sc_heat_count((uint8_t)s.median), 100.0 * s.histogram[0] / s.pixels);
    sc_page_add(page,
                "<figure class=\"heat\"><figcaption>%s</figcaption><img alt=\"%s\" width=\"%d\" "
                "height=\"%d\" src=\"data:image/png;base64,",
                words, words, heat->width_px, heat->height_px);
    if (page->status == SC_OK)
        sc_page_base64(page, data, bytes);
    sc_page_add(page, "\"/>\n");
    add_scale(page, &s, what);
    sc_page_add(page, "</figure>\n");
    free(data);
}

void sc_report_heat(sc_page *page, const sc_run_stats *stats)
{
    static const char *const units[SC_HEAT_KINDS] = {[SC_HEAT_SAMPLES] = "samples per pixel",
                                                     [SC_HEAT_CONTRIBUTIONS] =
                                                         "contributions per pixel"};
    const sc_heat *heat = &stats->heat;

    if (heat->width_px == 0)
        return;
    sc_page_section(page, "Work of each pixel");
    sc_page_add(page, "<div class=\"heats\">\n");
    for (int i = 0; i < SC_HEAT_KINDS; i++)
        add_picture(page, heat, heat->codes[i], units[i]);
    sc_page_add(page, "</div>\n");
    sc_page_add(
        page,
        "<p class=\"note\">Samples are cells or samples of a ray that were examined, and "
        "contributions boundary voxels that it met. The frame is one whose work is near the "
        "mean. It was drawn once more for this page, after the run, with one ray through the "
        "middle of each of %d x %d pixels, in %.3f CPU seconds.</p>\n",
        heat->width_px, heat->height_px, heat->cpu_s);
    sc_page_section_end(page);
}
