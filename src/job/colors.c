/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours of a job: by name, as hexadecimal digits, or as a list of three numbers. */
#include "key.h"
#include "segcast/job.h"
#include "segcast/overlay.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* The colours that have a name in CSS (W3C, CSS Color Module Level 4, section 6.1). */
static const struct {
    const char *name;
    unsigned rgb;
} names[] = {{"aliceblue", 0xf0f8ff},
             {"antiquewhite", 0xfaebd7},
             {"aqua", 0x00ffff},
             {"aquamarine", 0x7fffd4},
             {"azure", 0xf0ffff},
             {"beige", 0xf5f5dc},
             {"bisque", 0xffe4c4},
             {"black", 0x000000},
             {"blanchedalmond", 0xffebcd},
             {"blue", 0x0000ff},
             {"blueviolet", 0x8a2be2},
             {"brown", 0xa52a2a},
             {"burlywood", 0xdeb887},
             {"cadetblue", 0x5f9ea0},
             {"chartreuse", 0x7fff00},
             {"chocolate", 0xd2691e},
             {"coral", 0xff7f50},
             {"cornflowerblue", 0x6495ed},
             {"cornsilk", 0xfff8dc},
             {"crimson", 0xdc143c},
             {"cyan", 0x00ffff},
             {"darkblue", 0x00008b},
             {"darkcyan", 0x008b8b},
             {"darkgoldenrod", 0xb8860b},
             {"darkgray", 0xa9a9a9},
             {"darkgreen", 0x006400},
             {"darkgrey", 0xa9a9a9},
             {"darkkhaki", 0xbdb76b},
             {"darkmagenta", 0x8b008b},
             {"darkolivegreen", 0x556b2f},
             {"darkorange", 0xff8c00},
             {"darkorchid", 0x9932cc},
             {"darkred", 0x8b0000},
             {"darksalmon", 0xe9967a},
             {"darkseagreen", 0x8fbc8f},
             {"darkslateblue", 0x483d8b},
             {"darkslategray", 0x2f4f4f},
             {"darkslategrey", 0x2f4f4f},
             {"darkturquoise", 0x00ced1},
             {"darkviolet", 0x9400d3},
             {"deeppink", 0xff1493},
             {"deepskyblue", 0x00bfff},
             {"dimgray", 0x696969},
             {"dimgrey", 0x696969},
             {"dodgerblue", 0x1e90ff},
             {"firebrick", 0xb22222},
             {"floralwhite", 0xfffaf0},
             {"forestgreen", 0x228b22},
             {"fuchsia", 0xff00ff},
             {"gainsboro", 0xdcdcdc},
             {"ghostwhite", 0xf8f8ff},
             {"gold", 0xffd700},
             {"goldenrod", 0xdaa520},
             {"gray", 0x808080},
             {"green", 0x008000},
             {"greenyellow", 0xadff2f},
             {"grey", 0x808080},
             {"honeydew", 0xf0fff0},
             {"hotpink", 0xff69b4},
             {"indianred", 0xcd5c5c},
             {"indigo", 0x4b0082},
             {"ivory", 0xfffff0},
             {"khaki", 0xf0e68c},
             {"lavender", 0xe6e6fa},
             {"lavenderblush", 0xfff0f5},
             {"lawngreen", 0x7cfc00},
             {"lemonchiffon", 0xfffacd},
             {"lightblue", 0xadd8e6},
             {"lightcoral", 0xf08080},
             {"lightcyan", 0xe0ffff},
             {"lightgoldenrodyellow", 0xfafad2},
             {"lightgray", 0xd3d3d3},
             {"lightgreen", 0x90ee90},
             {"lightgrey", 0xd3d3d3},
             {"lightpink", 0xffb6c1},
             {"lightsalmon", 0xffa07a},
             {"lightseagreen", 0x20b2aa},
             {"lightskyblue", 0x87cefa},
             {"lightslategray", 0x778899},
             {"lightslategrey", 0x778899},
             {"lightsteelblue", 0xb0c4de},
             {"lightyellow", 0xffffe0},
             {"lime", 0x00ff00},
             {"limegreen", 0x32cd32},
             {"linen", 0xfaf0e6},
             {"magenta", 0xff00ff},
             {"maroon", 0x800000},
             {"mediumaquamarine", 0x66cdaa},
             {"mediumblue", 0x0000cd},
             {"mediumorchid", 0xba55d3},
             {"mediumpurple", 0x9370db},
             {"mediumseagreen", 0x3cb371},
             {"mediumslateblue", 0x7b68ee},
             {"mediumspringgreen", 0x00fa9a},
             {"mediumturquoise", 0x48d1cc},
             {"mediumvioletred", 0xc71585},
             {"midnightblue", 0x191970},
             {"mintcream", 0xf5fffa},
             {"mistyrose", 0xffe4e1},
             {"moccasin", 0xffe4b5},
             {"navajowhite", 0xffdead},
             {"navy", 0x000080},
             {"oldlace", 0xfdf5e6},
             {"olive", 0x808000},
             {"olivedrab", 0x6b8e23},
             {"orange", 0xffa500},
             {"orangered", 0xff4500},
             {"orchid", 0xda70d6},
             {"palegoldenrod", 0xeee8aa},
             {"palegreen", 0x98fb98},
             {"paleturquoise", 0xafeeee},
             {"palevioletred", 0xdb7093},
             {"papayawhip", 0xffefd5},
             {"peachpuff", 0xffdab9},
             {"peru", 0xcd853f},
             {"pink", 0xffc0cb},
             {"plum", 0xdda0dd},
             {"powderblue", 0xb0e0e6},
             {"purple", 0x800080},
             {"rebeccapurple", 0x663399},
             {"red", 0xff0000},
             {"rosybrown", 0xbc8f8f},
             {"royalblue", 0x4169e1},
             {"saddlebrown", 0x8b4513},
             {"salmon", 0xfa8072},
             {"sandybrown", 0xf4a460},
             {"seagreen", 0x2e8b57},
             {"seashell", 0xfff5ee},
             {"sienna", 0xa0522d},
             {"silver", 0xc0c0c0},
             {"skyblue", 0x87ceeb},
             {"slateblue", 0x6a5acd},
             {"slategray", 0x708090},
             {"slategrey", 0x708090},
             {"snow", 0xfffafa},
             {"springgreen", 0x00ff7f},
             {"steelblue", 0x4682b4},
             {"tan", 0xd2b48c},
             {"teal", 0x008080},
             {"thistle", 0xd8bfd8},
             {"tomato", 0xff6347},
             {"turquoise", 0x40e0d0},
             {"violet", 0xee82ee},
             {"wheat", 0xf5deb3},
             {"white", 0xffffff},
             {"whitesmoke", 0xf5f5f5},
             {"yellow", 0xffff00},
             {"yellowgreen", 0x9acd32}};

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

static char lower(char c)
{
    return (char)tolower((unsigned char)c);
}

/* Find a colour by its name, in which case, blanks, "-" and "_" do not matter. @param plain room
 * for @p size bytes: gets the name as the table writes it. @return false if no colour has it. */
static bool find_name(const char *text, char *plain, size_t size, uint8_t rgb[3])
{
    size_t used = 0;

    for (; *text && used + 1 < size; text++) {
        const char c = lower(*text);

        if (!strchr(" -_", c))
            plain[used++] = c;
    }
    plain[used] = '\0';
    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        if (!strcmp(plain, names[i].name)) {
            split(names[i].rgb, rgb);
            return true;
        }
    }
    return false;
}

/* Fill words[SC_COUNT_OF(names)] with the names of the table. */
static void list_names(const char **words)
{
    for (size_t i = 0; i < SC_COUNT_OF(names); i++)
        words[i] = names[i].name;
}

#define COLOR_EXPECTED                                                                             \
    "a name such as red, \"#rgb\", \"#rrggbb\", or [red, green, blue] with levels from 0 to 255 "  \
    "or "                                                                                          \
    "shares from 0.0 to 1.0"

/* Read a colour given as one value: a name or digits. */
static sc_status read_word(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                           uint8_t rgb[3])
{
    const char *words[SC_COUNT_OF(names)];
    char plain[32];

    if (!node->text[0])
        return sc_yaml_fail(ctx, node,
                            "%s has no value: in YAML a # begins a comment, so that a colour such "
                            "as \"#ff0000\" needs quotes",
                            key->name);
    if (node->text[0] == '#')
        return read_digits(node->text, rgb) ? SC_OK : sc_wrong_type(ctx, node, key->type->expected);
    if (find_name(node->text, plain, sizeof plain, rgb))
        return SC_OK;
    list_names(words);
    return sc_no_such_word(ctx, key, node, plain, words, SC_COUNT_OF(words));
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
static sc_status write_color(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             sc_text *text)
{
    const uint8_t *rgb = value;

    (void)key;
    (void)indent;
    return sc_text_add(ctx, text, "[%d, %d, %d]", rgb[0], rgb[1], rgb[2]);
}

/* Names as the table writes them, so that editors complete them; digits; or three numbers. */
static json_t *color_schema(const sc_key *key)
{
    const char *words[SC_COUNT_OF(names)];

    (void)key;
    list_names(words);
    return json_pack("{s:[o, {s:s, s:s}, o]}", "anyOf", sc_words_schema(words, SC_COUNT_OF(words)),
                     "type", "string", "pattern", "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$",
                     sc_list_schema("number", 0, 255, 3));
}

const sc_value_type sc_type_color = {
    .name = "colour",
    .expected = COLOR_EXPECTED,
    .read = read_color,
    .write = write_color,
    .schema = color_schema,
};

/* sc_vec3: a colour that is a value of key frames, in levels from 0 to 255. */
static sc_status read_levels(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const bool is_word = node->kind == SC_YAML_SCALAR &&
                         (!strcmp(node->text, "auto") || !strcmp(node->text, "none"));
    uint8_t rgb[3];
    sc_status status;

    if (is_word)
        return sc_yaml_fail(ctx, node,
                            "%s is \"%s\", expected a colour in key frames: auto and none hold for "
                            "all frames",
                            key->name, node->text);
    status = read_color(ctx, key, node, rgb);
    if (status == SC_OK)
        *(sc_vec3 *)value = (sc_vec3){rgb[0], rgb[1], rgb[2]};
    return status;
}

/* Split a colour of key frames into three levels. */
static void to_levels(sc_vec3 from, uint8_t rgb[3])
{
    rgb[0] = (uint8_t)from.x;
    rgb[1] = (uint8_t)from.y;
    rgb[2] = (uint8_t)from.z;
}

static sc_status write_levels(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                              sc_text *text)
{
    uint8_t rgb[3];

    to_levels(*(const sc_vec3 *)value, rgb);
    return write_color(ctx, key, rgb, indent, text);
}

const sc_value_type sc_type_color_levels = {
    .name = "colour",
    .expected = COLOR_EXPECTED,
    .read = read_levels,
    .write = write_levels,
    .schema = color_schema,
};

/* @return the track of a row. */
static sc_track *track_of(const sc_key *key, void *value)
{
    return (sc_track *)((char *)value + key->track);
}

/* uint8_t[3], sRGB: a colour; or key frames of colours, of which it becomes the first. */
static sc_status read_tracked(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    sc_track *track = track_of(key, value);
    sc_status status;

    if (!sc_is_track(node))
        return read_color(ctx, key, node, value);
    status = sc_read_track(ctx, key, node, track);
    if (status == SC_OK)
        to_levels(track->keys[0].value, value);
    return status;
}

static sc_status write_tracked(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                               sc_text *text)
{
    const sc_track *track = (const sc_track *)((const char *)value + key->track);

    return track->count ? sc_write_track(ctx, key, track, text)
                        : write_color(ctx, key, value, indent, text);
}

static json_t *tracked_schema(const sc_key *key)
{
    return json_pack("{s:[o, o]}", "anyOf", color_schema(key), sc_track_schema(key));
}

const sc_value_type sc_type_tracked_color = {
    .name = "colour or key frames",
    .of_key_frames = &sc_type_color_levels,
    .expected = COLOR_EXPECTED ", or key frames of colours",
    .read = read_tracked,
    .write = write_tracked,
    .schema = tracked_schema,
};

/* sc_background: a colour, auto, none, or key frames of colours. */
static sc_status read_background(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                 void *value)
{
    sc_background *background = value;
    sc_status status = SC_OK;

    if (sc_is_track(node)) {
        status = sc_read_track(ctx, key, node, &background->track);
        if (status == SC_OK) {
            background->is_auto = background->is_none = false;
            to_levels(background->track.keys[0].value, background->rgb);
        }
        return status;
    }
    background->is_auto = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "auto");
    background->is_none = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "none");
    if (background->is_none)
        memset(background->rgb, 255, sizeof background->rgb);
    else if (!background->is_auto)
        status = read_color(ctx, key, node, background->rgb);
    return status;
}

/* "auto", "none", a list of three levels, or key frames of such. */
static sc_status write_background(const sc_ctx *ctx, const sc_key *key, const void *value,
                                  int indent, sc_text *text)
{
    const sc_background *background = value;

    if (background->track.count)
        return sc_write_track(ctx, key, &background->track, text);
    if (background->is_auto)
        return sc_text_add(ctx, text, "auto");
    if (background->is_none)
        return sc_text_add(ctx, text, "none");
    return write_color(ctx, key, background->rgb, indent, text);
}

/* What color_schema allows, the words auto and none, or key frames of colours. */
static json_t *background_schema(const sc_key *key)
{
    return json_pack("{s:[o, {s:[s, s]}, o]}", "anyOf", color_schema(key), "enum", "auto", "none",
                     sc_track_schema(key));
}

const sc_value_type sc_type_background = {
    .name = "colour, auto, none or key frames",
    .of_key_frames = &sc_type_color_levels,
    .expected = "auto, none, " COLOR_EXPECTED ", or key frames of colours",
    .read = read_background,
    .write = write_background,
    .schema = background_schema,
};

void sc_background_at(const sc_background *background, int k, int frames, uint8_t rgb[3])
{
    sc_srgb_table table;
    sc_track tones;
    float linear[3];

    memcpy(rgb, background->rgb, sizeof background->rgb);
    if (!background->track.count)
        return;
    sc_srgb_table_init(&table);
    sc_track_tones(&background->track, &tones);
    sc_track_color(&tones, sc_frame_time(k, frames), linear);
    for (int i = 0; i < 3; i++)
        rgb[i] = sc_srgb_level(&table, linear[i]);
}

/* @return whether a background jumps from one colour to another: too far for a film in which the
 * colour changes by degrees. */
static bool jumps(const uint8_t a[3], const uint8_t b[3])
{
    enum { FAR = 48 };
    bool far = false;

    for (int i = 0; i < 3; i++)
        far = far || abs(a[i] - b[i]) > FAR;
    return far;
}

/* @return in how many of the @p reach frames before frame @p k, or behind it, the background is
 * light: where it jumps, or the film ends, it counts as if it stayed as it was. @param step -1
 * or 1. */
static int count_light(const sc_background *background, int k, int frames, int step, int reach)
{
    uint8_t last[3], next[3];
    bool ends = false;
    int count = 0;

    sc_background_at(background, k, frames, last);
    for (int i = 1; i <= reach; i++) {
        const int at = k + step * i;

        ends = ends || at < 0 || at >= frames;
        if (!ends) {
            sc_background_at(background, at, frames, next);
            ends = jumps(last, next);
        }
        if (!ends)
            memcpy(last, next, sizeof last);
        count += sc_is_light(last);
    }
    return count;
}

double sc_dark_text_at(const sc_background *background, int k, int frames, int fps)
{
    const int reach = fps > 4 ? fps / 4 : 1; /* frames before and behind this one */
    uint8_t own[3];
    int light;

    sc_background_at(background, k, frames, own);
    light = sc_is_light(own);
    if (!background->track.count)
        return light;
    light += count_light(background, k, frames, -1, reach);
    light += count_light(background, k, frames, 1, reach);
    return (double)light / (2 * reach + 1);
}
