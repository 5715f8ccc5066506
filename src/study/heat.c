/* SPDX-License-Identifier: BSD-3-Clause */
/* Heat pictures: counts for each pixel of a small picture, and how stats.json holds them. */
#include "heat_json.h"

#include <math.h>
#include <string.h>

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
    sc_heat heat = {.width_px = width_px, .height_px = height_px};
    void *block;
    sc_status status = SC_OK;

    for (int i = 0; i < SC_HEAT_KINDS; i++) {
        SC_TRY(sc_zalloc(ctx, (size_t)width_px * (size_t)height_px, 1, &block));
        heat.codes[i] = block;
    }
    *out = heat;
    heat = (sc_heat){0};
out:
    sc_heat_clear(&heat);
    return status;
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
        if (json_array_append_new(rows, json_stringn(text, 2 * (size_t)heat->width_px))) {
            json_decref(rows);
            rows = NULL;
        }
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
    for (int i = 0; i < SC_HEAT_KINDS && json; i++) {
        if (json_object_set_new(json, keys[i], rows_to_json(heat, heat->codes[i]))) {
            json_decref(json);
            json = NULL;
        }
    }
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

/* @return the whole number at a key, or -1 if there is none within its limits. */
static int read_int(const json_t *json, const char *key, int most)
{
    const json_t *value = json_object_get(json, key);
    const json_int_t number = json_integer_value(value);

    return json_is_integer(value) && number >= 0 && number <= most ? (int)number : -1;
}

sc_status sc_heat_from_json(const sc_ctx *ctx, const json_t *json, sc_heat *out, bool *good)
{
    const int frame = read_int(json, "frame", INT32_MAX);
    const int width = read_int(json, "width", SC_HEAT_SIDE);
    const int height = read_int(json, "height", SC_HEAT_SIDE);
    const json_t *cpu_s = json_object_get(json, "cpu_s");
    sc_heat heat = {0};
    sc_status status = SC_OK;

    *good = true;
    if (!json || json_is_null(json))
        return SC_OK;
    *good = frame >= 0 && width > 0 && height > 0 && json_is_number(cpu_s) &&
            json_number_value(cpu_s) >= 0;
    if (!*good)
        return SC_OK;
    SC_TRY(sc_heat_new(ctx, width, height, &heat));
    heat.frame = frame;
    heat.cpu_s = json_number_value(cpu_s);
    for (int i = 0; i < SC_HEAT_KINDS; i++)
        *good = *good && rows_from_json(json_object_get(json, keys[i]), &heat, heat.codes[i]);
    if (*good) {
        *out = heat;
        heat = (sc_heat){0};
    }
out:
    sc_heat_clear(&heat);
    return status;
}
