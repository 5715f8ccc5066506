/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours of a job: by name, as hexadecimal digits, or as a list of three numbers. */
#include "key.h"
#include "segcast/job.h"

#include <stdlib.h>

/* Split 0xRRGGBB into three levels. */
static void split(unsigned long number, uint8_t rgb[3])
{
    for (int i = 0; i < 3; i++)
        rgb[i] = (uint8_t)(number >> (16 - 8 * i) & 255);
}

/* Read "#rgb" or "#rrggbb". @return false if the text has another form. */
static bool read_digits(const char *text, uint8_t rgb[3])
{
    const size_t count = strlen(text) - 1;
    unsigned long number;

    if ((count != 3 && count != 6) || strspn(text + 1, "0123456789abcdefABCDEF") != count)
        return false;
    number = strtoul(text + 1, NULL, 16);
    if (count == 3) /* each digit stands for two: #fa0 is #ffaa00 */
        number = (number & 0xf00) * 0x1100 + (number & 0xf0) * 0x110 + (number & 0xf) * 0x11;
    split(number, rgb);
    return true;
}

#define COLOR_EXPECTED                                                                             \
    "a name such as red, \"#rgb\", \"#rrggbb\", or [red, green, blue] with levels from 0 to 255 "  \
    "or "                                                                                          \
    "shares from 0.0 to 1.0"

/* Read a colour given as one value: a name or digits. */
static sc_status read_word(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                           uint8_t rgb[3])
{
    const char *words[SC_COLOR_NAMES];
    char plain[SC_COLOR_NAME_BYTES];

    if (!node->text[0])
        return sc_yaml_fail(ctx, node,
                            "%s has no value: in YAML a # begins a comment, so that a colour such "
                            "as \"#ff0000\" needs quotes",
                            key->name);
    if (node->text[0] == '#')
        return read_digits(node->text, rgb) ? SC_OK : sc_wrong_type(ctx, node, key->type->expected);
    if (sc_color_by_name(node->text, plain, rgb))
        return SC_OK;
    sc_color_names(words);
    return sc_no_such_word(ctx, key, node, plain, words, SC_COLOR_NAMES);
}

/* uint8_t[3], sRGB: a name of CSS, "#rgb", "#rrggbb", or three numbers. The numbers are levels from
 * 0 to 255, of which fractions are cut off; or, if none is above 1 and one is written with a
 * decimal point, shares of full brightness, which are rounded to levels. */
static sc_status read_color(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double level[3], most = 0;
    bool has_point = false, has_share = false;

    if (node->kind == SC_YAML_SCALAR)
        return read_word(ctx, key, node, value);
    if (node->kind != SC_YAML_LIST || node->count != 3)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (int i = 0; i < 3; i++) {
        if (!sc_parse_number(node->items[i], &level[i]) || !(level[i] >= 0 && level[i] <= 255))
            return sc_wrong_type(ctx, node, key->type->expected);
        most = level[i] > most ? level[i] : most;
        has_point = has_point || strpbrk(node->items[i]->text, ".eE");
        has_share = has_share || (level[i] > 0 && level[i] < 1);
    }
    if (most > 1 && has_share)
        return sc_wrong_type(ctx, node,
                             "either levels from 0 to 255 or shares from 0.0 to 1.0, not both");
    if (most == 1 && !has_point)
        sc_warn(ctx,
                "%s:%d: %s is [%g, %g, %g], which is almost black, because whole numbers are "
                "levels from 0 to 255; for shares of full brightness write [%.1f, %.1f, %.1f]",
                node->origin, node->line, key->name, level[0], level[1], level[2], level[0],
                level[1], level[2]);
    for (int i = 0; i < 3; i++)
        ((uint8_t *)value)[i] = (uint8_t)(most <= 1 && has_point ? 255 * level[i] + 0.5 : level[i]);
    return SC_OK;
}

/* As a list of three levels. */
static sc_status write_color(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const uint8_t *rgb = value;

    return sc_text_add(ctx, text, "[%d, %d, %d]", rgb[0], rgb[1], rgb[2]);
}

/* Names as the table writes them, so that editors complete them. */
static size_t list_names(const sc_key *key, const char **words)
{
    sc_color_names(words);
    return SC_COLOR_NAMES;
}

#define COLOR_SCHEMA                                                                               \
    "{anyOf: [$words, {type: string, pattern: "                                                    \
    "'^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$'}, " SC_SCHEMA_LIST(                                      \
        "{type: number, minimum: 0, maximum: 255}", 3) "]}"

const sc_value_type sc_type_color = {
    .name = "colour",
    .expected = COLOR_EXPECTED,
    .read = read_color,
    .write = write_color,
    .list_words = list_names,
    .schema = COLOR_SCHEMA,
};

/* sc_vec3: a colour that is a value of key frames, in levels from 0 to 255. */
static sc_status read_levels(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const bool is_word = node->kind == SC_YAML_SCALAR &&
                         (!strcmp(node->text, "auto") || !strcmp(node->text, "none"));
    uint8_t rgb[3];

    if (is_word)
        return sc_yaml_fail(
            ctx, node,
            "%s is \"%s\", expected a colour in key frames: auto and none hold for all frames",
            key->name, node->text);
    SC_PASS(read_color(ctx, key, node, rgb));
    *(sc_vec3 *)value = (sc_vec3){rgb[0], rgb[1], rgb[2]};
    return SC_OK;
}

/* Split a colour of key frames into three levels. */
static void to_levels(sc_vec3 from, uint8_t rgb[3])
{
    rgb[0] = (uint8_t)from.x;
    rgb[1] = (uint8_t)from.y;
    rgb[2] = (uint8_t)from.z;
}

static sc_status write_levels(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    uint8_t rgb[3];

    to_levels(*(const sc_vec3 *)value, rgb);
    return write_color(ctx, key, rgb, text);
}

const sc_value_type sc_type_color_levels = {
    .name = "colour",
    .expected = COLOR_EXPECTED,
    .read = read_levels,
    .write = write_levels,
    .list_words = list_names,
    .schema = COLOR_SCHEMA,
};

/* A colour becomes the first of its key frames. */
static sc_status take_first(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    to_levels(sc_track_of(key, value)->keys[0].value, value);
    return SC_OK;
}

const sc_value_type sc_type_tracked_color = {
    .name = "colour or key frames",
    .of_key_frames = &sc_type_color_levels,
    .constant = &sc_type_color,
    .take_track = take_first,
    .expected = COLOR_EXPECTED ", or key frames of colours",
    .read = sc_read_tracked,
    .write = sc_write_tracked,
    .schema = SC_SCHEMA_TRACKED,
};

_Static_assert(offsetof(sc_background, rgb) == 0, "a background is read as its colour");

/* sc_background: a colour, auto, none, or key frames of colours. */
static sc_status read_background(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                 void *value)
{
    sc_background *background = value;

    background->is_auto = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "auto");
    background->is_none = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "none");
    if (background->is_none)
        memset(background->rgb, 255, sizeof background->rgb);
    return background->is_auto || background->is_none ? SC_OK
                                                      : sc_read_tracked(ctx, key, node, value);
}

static sc_status write_background(const sc_ctx *ctx, const sc_key *key, const void *value,
                                  sc_text *text)
{
    const sc_background *background = value;

    if (background->is_auto || background->is_none)
        return sc_text_add(ctx, text, background->is_auto ? "auto" : "none");
    return sc_write_tracked(ctx, key, value, text);
}

const sc_value_type sc_type_background = {
    .name = "colour, auto, none or key frames",
    .of_key_frames = &sc_type_color_levels,
    .constant = &sc_type_color,
    .take_track = take_first,
    .expected = "auto, none, " COLOR_EXPECTED ", or key frames of colours",
    .read = read_background,
    .write = write_background,
    .schema = "{anyOf: [$color, {enum: [auto, none]}, $track]}",
};
