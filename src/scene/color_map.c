/* SPDX-License-Identifier: BSD-3-Clause */
/* Colour maps, and the scale from values to their colours. The maps of the viridis family are
 * perceptually uniform: equal steps of the value look equally large, also to the colour-blind
 * (Smith and van der Walt, "A Better Default Colormap for Matplotlib", SciPy 2015; cividis: Nunez,
 * Anderton and Renslow, PLoS ONE 13(7), 2018). Here they are a few of their colours, between which
 * levels of sRGB are interpolated; so is coolwarm (Moreland, "Diverging Color Maps for Scientific
 * Visualization", 2009). */
#include "segcast/color_by.h"

#include <math.h>
#include <string.h>

enum { STOPS_MAX = 17 };

/* By sc_color_map; 0xrrggbb at equal distances. */
static const struct {
    int count;
    uint32_t stops[STOPS_MAX];
} maps[] = {
    [SC_MAP_VIRIDIS] = {9,
                        {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962,
                         0xaddc30, 0xfde725}},
    [SC_MAP_CIVIDIS] = {10,
                        {0x00204d, 0x00336f, 0x39486b, 0x575c6d, 0x707173, 0x8a8779, 0xa69d75,
                         0xc4b56c, 0xe4cf5b, 0xffea46}},
    [SC_MAP_MAGMA] = {9,
                      {0x000004, 0x1d1147, 0x51127c, 0x822681, 0xb63679, 0xe65164, 0xfb8861,
                       0xfec287, 0xfcfdbf}},
    [SC_MAP_INFERNO] = {9,
                        {0x000004, 0x210c4a, 0x56106e, 0x89226a, 0xbb3754, 0xe35932, 0xf98c0a,
                         0xf9c932, 0xfcffa4}},
    [SC_MAP_PLASMA] = {9,
                       {0x0d0887, 0x4c02a1, 0x7e03a8, 0xa92395, 0xcc4678, 0xe56b5d, 0xf89441,
                        0xfdc328, 0xf0f921}},
    [SC_MAP_COOLWARM] = {5, {0x3b4cc0, 0x8db0fe, 0xdddddd, 0xf49a7b, 0xb40426}},
};

void sc_color_map_at(sc_color_map map, double share, uint8_t rgb[3])
{
    const int steps = maps[map].count - 1;
    const double at = steps * (share > 0 ? share < 1 ? share : 1 : 0);
    const int low = at < steps ? (int)at : steps - 1;
    const double part = at - low;

    for (int c = 0; c < 3; c++) {
        const int shift = 16 - 8 * c;
        const double from = maps[map].stops[low] >> shift & 255;
        const double to = maps[map].stops[low + 1] >> shift & 255;

        rgb[c] = (uint8_t)(from + part * (to - from) + 0.5);
    }
}

void sc_color_scale_at(const sc_color_scale *scale, double value, uint8_t rgb[3])
{
    const double length = scale->high / 2 - scale->low / 2; /* by halves, lest it overflows */

    if (isnan(value))
        memcpy(rgb, scale->missing, sizeof scale->missing);
    else
        sc_color_map_at((sc_color_map)scale->map,
                        length > 0 ? (value / 2 - scale->low / 2) / length : 0.5, rgb);
}

void sc_color_scale_between(const sc_color_scale *scale, double from, double to, double share,
                            uint8_t rgb[3])
{
    uint8_t ends[2][3];

    if (isnan(from) == isnan(to)) {
        sc_color_scale_at(scale, (1 - share) * from + share * to, rgb);
        return;
    }
    sc_color_scale_at(scale, from, ends[0]);
    sc_color_scale_at(scale, to, ends[1]);
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(ends[0][c] + share * (ends[1][c] - ends[0][c]) + 0.5);
}

void sc_color_scale_find(const sc_color_by *by, const sc_prepared *volume, const double *values,
                         int columns, const char *title, sc_color_scale *out)
{
    double low = HUGE_VAL, high = -HUGE_VAL;

    *out = (sc_color_scale){.is_used = true, .map = by->map, .low = by->low, .high = by->high};
    memcpy(out->missing, by->missing, sizeof out->missing);
    snprintf(out->title, sizeof out->title, "%s", by->title[0] ? by->title : title);
    for (int id = 1; id < volume->label_count; id++) {
        if (!volume->stats[id].voxels || (volume->how.hidden && volume->how.hidden[id]))
            continue;
        for (int c = 0; c < columns; c++) {
            const double value = values[(size_t)c * (size_t)volume->label_count + (size_t)id];

            out->lacks_some = out->lacks_some || isnan(value);
            low = fmin(low, value); /* fmin and fmax ignore NAN */
            high = fmax(high, value);
        }
    }
    if (!by->range_auto)
        return;
    if (by->map == SC_MAP_COOLWARM && low < 0 && high > 0) {
        high = fmax(-low, high);
        low = -high;
    }
    out->low = low <= high ? low : 0;
    out->high = low <= high ? high : 1;
}
