/* SPDX-License-Identifier: BSD-3-Clause */
/* Heat pictures: how much work the rays of each pixel of a frame were. */
#include "internal.h"
#include "segcast/image.h"

/* Describe the codes of a picture: the least, the most and the median count of pixels with any, and
 * the share of those without. @param png borrowed. @return NULL also if no pixel has work. */
static json_t *describe(const char *name, const uint8_t *codes, int pixels, json_t *png)
{
    int histogram[256] = {0}, low = 0, high = 0, median = 0, below = 0;

    for (int i = 0; i < pixels; i++)
        histogram[codes[i]]++;
    for (int code = 1; code < 256; code++) {
        if (histogram[code] == 0)
            continue;
        low = low ? low : code;
        high = code;
        if (2 * below < pixels - histogram[0])
            median = code;
        below += histogram[code];
    }
    return json_pack("{s:s, s:f, s:f, s:f, s:f, s:O}", "name", name, "low",
                     sc_heat_count((uint8_t)low), "high", sc_heat_count((uint8_t)high), "median",
                     sc_heat_count((uint8_t)median), "none", (double)histogram[0] / pixels, "png",
                     png);
}

/* Add one picture, whose grey values are the codes, unless no pixel has any work. */
static sc_status add_kind(const sc_ctx *ctx, const sc_heat *heat, int kind, json_t **kinds)
{
    static const char *const names[SC_HEAT_KINDS] = {
        [SC_HEAT_SAMPLES] = "samples", [SC_HEAT_CONTRIBUTIONS] = "contributions"};
    const int pixels = heat->width_px * heat->height_px;
    bool any = false;
    SC_OWN(sc_image_clear) sc_image image = {0};
    json_auto_t *png = NULL;

    SC_PASS(sc_image_init(ctx, heat->width_px, heat->height_px, &image));
    for (int i = 0; i < pixels; i++) {
        any = any || heat->codes[kind][i];
        memset(&image.rgb[3 * i], heat->codes[kind][i], 3);
    }
    if (any) {
        SC_PASS(sc_json_png(ctx, &image, &png));
        *kinds = sc_json_with(*kinds, describe(names[kind], heat->codes[kind], pixels, png));
    }
    return SC_OK;
}

sc_status sc_report_heat(const sc_ctx *ctx, const sc_heat *heat, json_t *data)
{
    json_auto_t *kinds = json_array();

    for (int i = 0; i < SC_HEAT_KINDS && heat->width_px; i++)
        SC_PASS(add_kind(ctx, heat, i, &kinds));
    if (heat->width_px)
        return sc_json_set(ctx, data, "heat",
                           json_pack("{s:i, s:i, s:i, s:f, s:O}", "frame", heat->frame, "width",
                                     heat->width_px, "height", heat->height_px, "cpu_s",
                                     heat->cpu_s, "kinds", kinds));
    return SC_OK;
}
