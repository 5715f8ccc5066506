/* SPDX-License-Identifier: BSD-3-Clause */
/* Heat pictures: counts for each pixel of a small picture, and how stats.json holds them. */
#include "heat_json.h"
#include "segcast/json_values.h"

#include <math.h>

/* Codes above 0 are in steps of a sixteenth of a doubling. */
#define CODES_PER_DOUBLING 16

uint8_t sc_heat_code(uint64_t count)
{
    const double code = count ? 1 + CODES_PER_DOUBLING * log2((double)count) : 0;

    return (uint8_t)(code < 255 ? lround(code) : 255);
}

double sc_heat_count(uint8_t code)
{
    return code ? exp2((code - 1.0) / CODES_PER_DOUBLING) : 0;
}

sc_status sc_heat_new(const sc_ctx *ctx, int width_px, int height_px, sc_heat *out)
{
    SC_OWN(sc_heat_clear) sc_heat heat = {.width_px = width_px, .height_px = height_px};

    for (int i = 0; i < SC_HEAT_KINDS; i++) {
        SC_PASS(sc_zalloc(ctx, (size_t)width_px * (size_t)height_px, 1, &heat.codes[i]));
    }
    SC_HAND_OVER(heat, out);
    return SC_OK;
}

void sc_heat_clear(sc_heat *heat)
{
    for (int i = 0; i < SC_HEAT_KINDS; i++)
        sc_free(heat->codes[i]);
    *heat = (sc_heat){0};
}

/* ---- JSON ---- */

static const char *const keys[SC_HEAT_KINDS] = {"samples", "contributions"};

/* @return the rows of a picture as texts of two hexadecimal digits for each pixel; NULL: no memory.
 */
static json_t *rows_to_json(const sc_heat *heat, const uint8_t *codes)
{
    static const char digits[] = "0123456789abcdef";
    json_t *rows = json_array();
    char text[2 * SC_HEAT_SIDE];

    for (int y = 0; y < heat->height_px && rows; y++) {
        for (int x = 0; x < heat->width_px; x++) {
            const uint8_t code = codes[y * heat->width_px + x];

            text[2 * x] = digits[code >> 4];
            text[2 * x + 1] = digits[code & 15];
        }
        rows = sc_json_with(rows, json_stringn(text, 2 * (size_t)heat->width_px));
    }
    return rows;
}

json_t *sc_heat_to_json(const sc_heat *heat)
{
    json_t *json;

    if (!heat || heat->width_px == 0)
        return json_null();
    json = json_pack("{s:i, s:i, s:i, s:f}", "frame", heat->frame, "width", heat->width_px,
                     "height", heat->height_px, "cpu_s", heat->cpu_s);
    for (int i = 0; i < SC_HEAT_KINDS && json; i++)
        json = sc_json_with_key(json, keys[i], rows_to_json(heat, heat->codes[i]));
    return json;
}

/* @return the value of a hexadecimal digit, or -1. */
static int digit_value(char digit)
{
    return digit >= '0' && digit <= '9'   ? digit - '0'
           : digit >= 'a' && digit <= 'f' ? digit - 'a' + 10
                                          : -1;
}

/* Read the rows of a picture. @return false if they are none of its size. */
static bool rows_from_json(const json_t *rows, const sc_heat *heat, uint8_t *codes)
{
    if (json_array_size(rows) != (size_t)heat->height_px)
        return false;
    for (int y = 0; y < heat->height_px; y++) {
        const json_t *row = json_array_get(rows, (size_t)y);
        const char *text = json_string_value(row);

        if (!text || json_string_length(row) != 2 * (size_t)heat->width_px)
            return false;
        for (int x = 0; x < heat->width_px; x++) {
            const int high = digit_value(text[2 * x]), low = digit_value(text[2 * x + 1]);

            if (high < 0 || low < 0)
                return false;
            codes[y * heat->width_px + x] = (uint8_t)(16 * high + low);
        }
    }
    return true;
}

sc_status sc_heat_from_json(const sc_ctx *ctx, const json_t *json, sc_heat *out, bool *good)
{
    SC_OWN(sc_heat_clear) sc_heat heat = {0};
    int frame, width, height;
    double cpu_s;

    *good = true;
    if (!json || json_is_null(json))
        return SC_OK;
    *good = sc_json_int(json_object_get(json, "frame"), 0, INT32_MAX, &frame) &&
            sc_json_int(json_object_get(json, "width"), 1, SC_HEAT_SIDE, &width) &&
            sc_json_int(json_object_get(json, "height"), 1, SC_HEAT_SIDE, &height) &&
            sc_json_real(json_object_get(json, "cpu_s"), 0, INFINITY, &cpu_s);
    if (!*good)
        return SC_OK;
    SC_PASS(sc_heat_new(ctx, width, height, &heat));
    heat.frame = frame;
    heat.cpu_s = cpu_s;
    for (int i = 0; i < SC_HEAT_KINDS; i++)
        *good = *good && rows_from_json(json_object_get(json, keys[i]), &heat, heat.codes[i]);
    if (*good) {
        SC_HAND_OVER(heat, out);
    }
    return SC_OK;
}
